"""Basis of the odds: ``python -m blind.tune --seed 1000 --count 120 --to build/blind``; see ``make tune``.

Searches the cases of a seed with open answers, then scores the calibration and the same with one number changed at a
time. A search takes as long as a diagnosis; finished ones are reused. The doubts that a diagnosis adds where its
verdict depends on one recording, or fails on held-out trials, are not in these odds.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import log
from pathlib import Path
from typing import Any

from blind import make, run, score
from blind.asked import Asked
from blind.searched import FACTORS, Searched, search_all, view
from synth.diagnosis.angle_search import search
from synth.diagnosis.plants.swinging_chain.chain_candidates import candidates, natural_sizes_of
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import scene_of
from synth.diagnosis.settled import settle_leading
from synth.diagnosis.verdict import CALIBRATED, Calibration, judge
from synth.files.gap_project import read_gap_project

SHOWN = ("calibration", "top1", "two_named", "tie_reported", "unknown_flagged", "unknown_wrong", "known_unknown")
LEAST = 2e-3  # probability of the truth, below which a case counts no worse
APART = (*run.APART, "diagnosis/verdict.py", "diagnosis/odds.py", "diagnosis/sentences.py")  # not used by a search


def main(words: list[str] | None = None) -> int:
    asked = Asked.of(words, "blind.tune", __doc__)
    make.once(asked)
    answers = json.loads(asked.answers.read_text())
    print(table(answers, search_all(asked, list(answers), search_case, APART)))  # noqa: T201
    return 0


def search_case(case: Path) -> Searched:
    """The search of the case in this folder."""
    project = read_gap_project(case / "gap.yaml")
    scene, _ = scene_of(project.leg, project.trials, project.tolerance, project.seed)
    found = search(
        scene.bench, candidates(project.leg, scene.given, natural_sizes_of(project.leg, scene.given)), CALIBRATED
    )
    found, _ = settle_leading(scene.bench, found, CALIBRATED)
    return Searched(found, {project.leg.joint_names[item.joint]: item.step for item in scene.coarse})


def truth(answer: Mapping[str, Any], case: Searched, calibration: Calibration) -> float:
    """Probability of the truth of a case: no cause, an unknown one, a single cause, or all causes together."""
    judged = judge(case.found, calibration)
    if answer["kind"] == "none":
        return judged.none
    if answer["kind"] == "unknown":
        return judged.unknown
    true = {key for key in score.true_keys(answer) if key[0] != "encoder_quantisation"}
    if len(true) == 1:
        (only,) = true
        return next((p for item, p in judged.singles if item.keys[0] == only), 0.0)
    return (1.0 - judged.unknown) * sum(w for item, w in judged.weighed if true <= set(item.keys))


def line(answers: Mapping[str, Any], cases: Mapping[str, Searched], calibration: Calibration) -> list[float]:
    """Mean logarithm of the truth's probability, then the scores ``SHOWN``."""
    views = {name: view(case, calibration) for name, case in cases.items()}
    found = {entry.key: entry.value for entry in score.scores(answers, views)}
    logarithms = [log(max(truth(answers[name], case, calibration), LEAST)) for name, case in cases.items()]
    return [sum(logarithms) / len(logarithms), *(found[key] for key in SHOWN)]


def table(answers: Mapping[str, Any], cases: Mapping[str, Searched]) -> str:
    """One row per calibration: the current one, and those with one number changed."""
    rows = [("current", line(answers, cases, CALIBRATED))]
    for name, value in vars(CALIBRATED).items():
        for factor in FACTORS:
            changed = replace(CALIBRATED, **{name: value * factor})
            rows.append((f"{name} {value * factor:g}", line(answers, cases, changed)))
    return "\n".join(
        [_row("", ["log p", *SHOWN]), *(_row(name, [f"{x:.3f}" for x in values]) for name, values in rows)]
    )


def _row(name: str, cells: Sequence[str]) -> str:
    return f"{name:24s}" + "".join(f"{cell:>16s}" for cell in cells)


if __name__ == "__main__":
    sys.exit(main())
