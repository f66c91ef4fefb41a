"""What the odds far above the noise rest on: ``python -m blind.tune_rigs --seed 4200 --count 80 --to build/rigs``.

As ``blind.tune``, on dirty rigs whose answers are open; see ``make tune-rigs``. Searching takes the time of a check;
what was searched before is kept.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from blind import rigs, run
from blind.asked import Asked
from blind.rig_score import right_first, scores
from blind.score import Answer
from blind.tune import FACTORS, Cause, Named
from blind.views import View
from synth.diagnosis.hypotheses import Assessed, Hypotheses, TrialErrors
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import SwingingChain, scene_of
from synth.diagnosis.unseen import by_trial
from synth.diagnosis.verdict import CALIBRATED, Calibration, judge
from synth.files.gap_project import read_gap_project

FAR = (
    "most",
    "most_of_several",
    "steep",
    "most_unknown",
    "per_unknown_far",
    "accuracy",
    "accuracy_steep",
    "free_leads",
)
SHOWN = ("calibration", "top1", "joint", "false_alarm", "invented", "unknown_flagged", "unknown_wrong", "two_named")
APART = (*run.APART, "diagnosis/verdict.py", "diagnosis/odds.py", "diagnosis/sentences.py")  # no part of a search


@dataclass(frozen=True)
class Searched:
    """What a search found in one rig; ``free`` and ``motion`` as for ``judge``."""

    found: Hypotheses[Named]
    free: TrialErrors | None
    motion: float


def main(words: list[str] | None = None) -> int:
    asked = Asked.of(words, "blind.tune_rigs", __doc__)
    if not asked.answers.exists():
        rigs.make(asked, rigs.plan(asked.seed, asked.count), rigs.one)
    answers = json.loads(asked.answers.read_text())
    out = asked.folder / f"searched-{run.source_hash(APART)[:12]}"
    out.mkdir(exist_ok=True)
    with ProcessPoolExecutor(asked.workers) as pool:
        list(pool.map(partial(_search, out=out), [asked.cases / name for name in answers]))
    print(table(answers, {name: read(json.loads((out / f"{name}.json").read_text())) for name in answers}))  # noqa: T201
    return 0


def _search(case: Path, out: Path) -> None:
    """Search a rig and note what odds need of it."""
    file = out / f"{case.name}.json"
    if file.exists():
        return
    project = read_gap_project(case / "gap.yaml")
    scene, _ = scene_of(project.leg, project.trials, project.tolerance, project.seed)
    plant = SwingingChain(scene, ())
    found = plant.search(lambda text: None)

    def brief(item: Assessed[Any]) -> dict[str, Any]:
        return {
            "causes": [[*c.key, c.size] for c in item.fit.hypothesis],
            "cost": item.cost,
            "ratio": item.ratio,
            "unseen": _listed(item.unseen),
            "seen": _listed(by_trial(scene.bench, item.fit.residuals)) if item.seen is not None else None,
        }

    document = {
        "none": brief(found.none),
        "singles": [brief(item) for item in found.singles],
        "several": [brief(item) for item in found.several],
        "free": _listed(plant.freely(found)),
        "motion": plant.motion,
    }
    partial_file = file.with_suffix(".part")
    partial_file.write_text(json.dumps(document) + "\n")
    partial_file.rename(file)


def _listed(errors: TrialErrors | None) -> list[Any] | None:
    return None if errors is None else [each.tolist() for each in (errors.squares, errors.counts, errors.independent)]


def read(document: Mapping[str, Any]) -> Searched:
    """The search that was noted."""

    def errors(listed: Sequence[Any] | None) -> TrialErrors | None:
        return None if listed is None else TrialErrors(*(np.array(each) for each in listed))

    def assessed(item: Mapping[str, Any]) -> Assessed[Named]:
        causes = tuple(Cause((effect, joint), size) for effect, joint, size in item["causes"])
        return Assessed(Named(causes), item["cost"], item["ratio"], errors(item["unseen"]), errors(item["seen"]))

    found = Hypotheses(
        assessed(document["none"]),
        tuple(map(assessed, document["singles"])),
        tuple(map(assessed, document["several"])),
    )
    return Searched(found, errors(document["free"]), document["motion"])


def view(case: Searched, calibration: Calibration) -> View:
    """What the program would say of a rig, but for causes read directly from the counts."""
    judged = judge(case.found, calibration, free=case.free, motion=case.motion)
    explained = judged.verdict in ("effect", "tie")
    together = {*judged.accepted.keys} if len(judged.accepted.keys) > 1 else set()
    cost = {item.keys[0]: item.cost for item, _ in judged.singles}
    ranked = [(item.keys[0], probability) for item, probability in judged.singles]
    highest = max((probability for key, probability in ranked if key in together), default=0.0)
    ranked.sort(key=lambda e: (-highest, cost[e[0]]) if e[0] in together else (-e[1], 0.0))
    return View(
        verdict=judged.verdict,
        ranked=tuple(ranked),
        explanation=judged.accepted.keys if explained else (),
        tied=tuple(item.keys for item in judged.tied),
        none=judged.none,
        unknown=judged.unknown,
    )


def line(answers: Mapping[str, Answer], cases: Mapping[str, Searched], calibration: Calibration) -> list[float]:
    """Mean squared error of the first cause's probability, then the scores ``SHOWN``."""
    views = {name: view(case, calibration) for name, case in cases.items()}
    found = {entry.key: entry.value for entry in scores(answers, views)}
    squares = [(views[n].first[1] - float(right_first(a, views[n]))) ** 2 for n, a in answers.items()]
    return [sum(squares) / len(squares), *(found[key] for key in SHOWN)]


def table(answers: Mapping[str, Answer], cases: Mapping[str, Searched]) -> str:
    """A row a calibration: as it is, and with each number of the far remainder changed."""
    rows = [("as it is", line(answers, cases, CALIBRATED))]
    for name in FAR:
        for factor in FACTORS:
            value = getattr(CALIBRATED, name) * factor
            rows.append((f"{name} {value:.3g}", line(answers, cases, replace(CALIBRATED, **{name: value}))))
    head = f"{'':24s}" + "".join(f"{cell:>16s}" for cell in ("squared error", *SHOWN))
    return "\n".join([head, *(f"{name:24s}" + "".join(f"{x:16.3f}" for x in values) for name, values in rows)])


if __name__ == "__main__":
    sys.exit(main())
