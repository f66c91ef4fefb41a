"""What the odds rest on: ``python -m blind.tune --seed 1000 --count 120 --to build/blind``; see ``make tune``.

Searches the cases of a seed whose answers are open, then scores the calibration as it is, and with one number of it
changed at a time: a better one would show. Searching takes the time of a check; what was searched before is kept.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from math import log
from pathlib import Path
from typing import Any

from blind import make, run, score
from blind.asked import Asked
from blind.views import Key, View
from synth.diagnosis.angle_search import search
from synth.diagnosis.hypotheses import Assessed, Hypotheses
from synth.diagnosis.plants.swinging_chain.chain_candidates import candidates, scales
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import scene_of
from synth.diagnosis.verdict import CALIBRATED, Calibration, Judged, judge, with_counts
from synth.files.gap_project import read_gap_project

FACTORS = (0.5, 0.7, 1.4, 2.0)  # by which each number is changed
SHOWN = ("calibration", "top1", "two_named", "tie_reported", "unknown_flagged", "unknown_wrong", "known_unknown")
LEAST = 2e-3  # probability of the truth, below which a case counts no worse
APART = (*run.APART, "diagnosis/jumps", "diagnosis/verdict.py")  # may change without the searches being done anew


@dataclass(frozen=True)
class Cause:
    """One cause of a hypothesis, by name."""

    key: Key
    size: int


@dataclass(frozen=True)
class Named:
    """A hypothesis without its fit."""

    hypothesis: tuple[Cause, ...]


@dataclass(frozen=True)
class Searched:
    """What a search found in one case: all that odds are made of. ``coarse`` : joint -> count, rad."""

    found: Hypotheses[Named]
    coarse: Mapping[str, float]


def main(words: list[str] | None = None) -> int:
    asked = Asked.of(words, "blind.tune", __doc__)
    make.once(asked)
    answers = json.loads(asked.answers.read_text())
    out = asked.folder / f"searched-{run.source_hash(APART)[:12]}"
    out.mkdir(exist_ok=True)
    with ProcessPoolExecutor(asked.workers) as pool:
        list(pool.map(partial(_search, out=out), [asked.cases / name for name in answers]))
    cases = {name: _read(out / f"{name}.json") for name in answers}
    print(table(answers, cases))  # noqa: T201
    return 0


def _search(case: Path, out: Path) -> None:
    """Search a case and note what odds need of it."""
    file = out / f"{case.name}.json"
    if file.exists():
        return
    project = read_gap_project(case / "gap.yaml")
    scene, _ = scene_of(project.leg, project.trials, project.tolerance, project.seed)
    found = search(scene.bench, candidates(project.leg, scene.given, scales(project.leg, scene.given)))

    def brief(item: Assessed[Any]) -> dict[str, Any]:
        return {"causes": [[*c.key, c.size] for c in item.fit.hypothesis], "cost": item.cost, "ratio": item.ratio}

    document = {
        "none": brief(found.none),
        "singles": [brief(item) for item in found.singles],
        "several": [brief(item) for item in found.several],
        "coarse": {project.leg.joint_names[item.joint]: item.step for item in scene.coarse},
    }
    partial_file = file.with_suffix(".part")
    partial_file.write_text(json.dumps(document) + "\n")
    partial_file.rename(file)


def _read(file: Path) -> Searched:
    document = json.loads(file.read_text())

    def assessed(item: Mapping[str, Any]) -> Assessed[Named]:
        causes = tuple(Cause((effect, joint), size) for effect, joint, size in item["causes"])
        return Assessed(Named(causes), item["cost"], item["ratio"])

    found = Hypotheses(
        assessed(document["none"]),
        tuple(map(assessed, document["singles"])),
        tuple(map(assessed, document["several"])),
    )
    return Searched(found, document["coarse"])


def view(case: Searched, calibration: Calibration) -> View:
    """What the program would say of a case."""
    judged = with_counts(judge(case.found, calibration), len(case.coarse) > 0)
    counted: tuple[Key, ...] = tuple(("encoder_quantisation", joint) for joint in case.coarse)
    ranked = [(item.keys[0], probability) for item, probability in judged.singles]
    ranked += [(key, judged.counts) for key in counted]
    explained = judged.verdict in ("effect", "tie")
    return View(
        verdict=judged.verdict,
        ranked=tuple(sorted(ranked, key=lambda item: -item[1])),
        explanation=(*judged.accepted.keys, *counted) if explained else (),
        tied=tuple(item.keys for item in judged.tied),
        none=judged.none,
        unknown=judged.unknown,
    )


def truth(answer: Mapping[str, Any], case: Searched, calibration: Calibration) -> float:
    """Probability given to what is true of a case: nothing, an unknown, a cause, or all causes together."""
    judged: Judged[Named] = judge(case.found, calibration)
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
    told = [log(max(truth(answers[name], case, calibration), LEAST)) for name, case in cases.items()]
    return [sum(told) / len(told), *(found[key] for key in SHOWN)]


def table(answers: Mapping[str, Any], cases: Mapping[str, Searched]) -> str:
    """A row a calibration: as it is, and with each number changed."""
    rows = [("as it is", line(answers, cases, CALIBRATED))]
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
