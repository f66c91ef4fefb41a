"""Basis of the odds far above the noise: ``python -m blind.tune_rigs --seed 4200 --count 80 --to build/rigs``.

Like ``blind.tune``, on dirty rigs with open answers; see ``make tune-rigs``.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from blind import rigs, run
from blind.asked import Asked
from blind.chance import reliability
from blind.rig_score import right_first, scores
from blind.score import Answer
from blind.searched import FACTORS, Searched, search_all, view
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import SwingingChain, scene_of
from synth.diagnosis.verdict import CALIBRATED, Calibration
from synth.files.gap_project import read_gap_project

FAR = (
    "most",
    "most_of_several",
    "steep",
    "most_unknown",
    "per_unknown_far",
    "per_state_far",
    "accuracy",
    "accuracy_steep",
    "free_leads",
)
SHOWN = ("calibration", "top1", "joint", "false_alarm", "invented", "unknown_flagged", "unknown_wrong", "two_named")
APART = (*run.APART, "diagnosis/verdict.py", "diagnosis/odds.py", "diagnosis/sentences.py")  # not used by a search


def main(words: list[str] | None = None) -> int:
    asked = Asked.of(words, "blind.tune_rigs", __doc__)
    if not asked.answers.exists():
        rigs.make(asked, rigs.plan(asked.seed, asked.count), rigs.one)
    answers = json.loads(asked.answers.read_text())
    cases = search_all(asked, list(answers), search_rig, APART)
    print(table(answers, cases), reliability_table(answers, cases), sep="\n\n")  # noqa: T201
    return 0


def search_rig(case: Path) -> Searched:
    """The search of the rig in this folder, with its errors on unseen trials."""
    project = read_gap_project(case / "gap.yaml")
    scene, _ = scene_of(project.leg, project.trials, project.tolerance, project.seed)
    plant = SwingingChain(scene, ())
    found = plant.search(lambda text: None)
    coarse = {project.leg.joint_names[item.joint]: item.step for item in scene.coarse}
    return Searched(found, coarse, plant.freely(found), plant.motion)


def line(answers: Mapping[str, Answer], cases: Mapping[str, Searched], calibration: Calibration) -> list[float]:
    """Mean squared error of the first cause's probability, then the scores ``SHOWN``."""
    views = {name: view(case, calibration) for name, case in cases.items()}
    found = {entry.key: entry.value for entry in scores(answers, views)}
    squares = [(views[n].first[1] - float(right_first(a, views[n]))) ** 2 for n, a in answers.items()]
    return [sum(squares) / len(squares), *(found[key] for key in SHOWN)]


def table(answers: Mapping[str, Answer], cases: Mapping[str, Searched]) -> str:
    """One row per calibration: the current one, and those with one number of the far remainder changed."""
    rows = [("current", line(answers, cases, CALIBRATED))]
    for name in FAR:
        for factor in FACTORS:
            value = getattr(CALIBRATED, name) * factor
            rows.append((f"{name} {value:.3g}", line(answers, cases, replace(CALIBRATED, **{name: value}))))
    head = f"{'':24s}" + "".join(f"{cell:>16s}" for cell in ("squared error", *SHOWN))
    return "\n".join([head, *(f"{name:24s}" + "".join(f"{x:16.3f}" for x in values) for name, values in rows)])


def reliability_table(answers: Mapping[str, Answer], cases: Mapping[str, Searched]) -> str:
    """Of rigs with a main cause, by tenths of the first cause's probability: how many, its mean, and how many right."""
    views = {name: view(cases[name], CALIBRATED) for name, answer in answers.items() if answer["kind"] != "none"}
    rows = np.array([[found.first[1], float(right_first(answers[name], found))] for name, found in views.items()])
    lines = [
        f"from {low:.1f}: {n:3d} rigs, {said:.3f}, {right * n:.0f} right" for low, n, said, right in reliability(rows)
    ]
    return "\n".join(["first cause of rigs with a main cause, stated probability", *lines])


if __name__ == "__main__":
    sys.exit(main())
