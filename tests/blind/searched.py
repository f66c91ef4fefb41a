"""Searches of blind cases without their fits, stored so that odds and verdicts can be computed from them again."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from blind import run
from blind.asked import Asked
from blind.views import Key, View
from synth.arrays import Array
from synth.diagnosis.hypotheses import Assessment, Hypotheses, TrialErrors
from synth.diagnosis.verdict import Calibration, judge, with_coarse_counts
from synth.swing.effects import registered

FACTORS = (0.5, 0.7, 1.4, 2.0)  # on each number of a calibration, one at a time: a better value would show


@dataclass(frozen=True)
class Cause:
    """One cause of a hypothesis, by name."""

    key: Key
    size: int
    links: int = 0
    replaced_links: int = 0

    @property
    def part(self) -> str:
        """As of a candidate; empty for an effect of the jumping leg."""
        effect = next((each for each in registered() if each.name == self.key[0]), None)
        return "" if effect is None or effect.belongs_to == "joint" else effect.belongs_to


@dataclass(frozen=True)
class Named:
    """A hypothesis without its fit."""

    hypothesis: tuple[Cause, ...]
    shapes: Array


@dataclass(frozen=True)
class Searched:
    """The result of one search: all that odds depend on.

    ``coarse`` : joint -> width of its encoder's counts, rad; ``free`` and ``motion`` as for ``judge``.
    """

    found: Hypotheses[Any]
    coarse: Mapping[str, float] = field(default_factory=dict)
    free: TrialErrors | None = None
    motion: float = np.inf

    def as_json(self) -> dict[str, Any]:
        """The inverse of ``read``."""
        return {
            "none": _hypothesis_json(self.found.none),
            "singles": [_hypothesis_json(item) for item in self.found.singles],
            "several": [_hypothesis_json(item) for item in self.found.several],
            "small": [list(key) for key in self.found.small],
            "coarse": dict(self.coarse),
            "free": _errors_json(self.free),
            "motion": self.motion if np.isfinite(self.motion) else None,
        }


def _hypothesis_json(item: Assessment[Any]) -> dict[str, Any]:
    return {
        "causes": [[*cause.key, cause.size, cause.links] for cause in item.fit.hypothesis],
        "cost": item.cost,
        "ratio": item.ratio,
        "shapes": item.fit.shapes.tolist(),
        "unseen": _errors_json(item.unseen),
        "seen": _errors_json(item.seen),
    }


def _errors_json(errors: TrialErrors | None) -> list[Any] | None:
    return None if errors is None else [each.tolist() for each in (errors.squares, errors.counts, errors.independent)]


def read(document: Mapping[str, Any]) -> Searched:
    """A search from its JSON."""

    def errors(listed: Sequence[Any] | None) -> TrialErrors | None:
        return None if listed is None else TrialErrors(*(np.array(each) for each in listed))

    def hypothesis(item: Mapping[str, Any]) -> Assessment[Named]:
        causes = tuple(Cause((effect, joint), *sizes) for effect, joint, *sizes in item["causes"])
        fit = Named(causes, np.array(item["shapes"]).reshape(-1, 2))
        return Assessment(fit, item["cost"], item["ratio"], errors(item["unseen"]), errors(item["seen"]))

    found = Hypotheses(
        hypothesis(document["none"]),
        tuple(map(hypothesis, document["singles"])),
        tuple(map(hypothesis, document["several"])),
        tuple((effect, joint) for effect, joint in document.get("small", ())),
    )
    motion = document["motion"]
    return Searched(found, document["coarse"], errors(document["free"]), np.inf if motion is None else motion)


def search_all(
    asked: Asked, names: Sequence[str], search: Callable[[Path], Searched], apart: Sequence[str]
) -> dict[str, Searched]:
    """The search of each case by name; stored ones are reused while the program, except ``apart``, is the same."""
    out = asked.folder / f"searched-{run.source_hash(apart)[:12]}"
    out.mkdir(exist_ok=True)
    with ProcessPoolExecutor(asked.workers) as pool:
        list(pool.map(partial(store, search=search, out=out), [asked.cases / name for name in names]))
    return {name: read(json.loads((out / f"{name}.json").read_text())) for name in names}


def store(case: Path, search: Callable[[Path], Searched], out: Path) -> None:
    """Search the case in a folder unless its search is stored in ``out``."""
    file = out / f"{case.name}.json"
    if not file.exists():
        unfinished = file.with_suffix(".part")
        unfinished.write_text(json.dumps(search(case).as_json()) + "\n")
        unfinished.rename(file)


def view(case: Searched, calibration: Calibration) -> View:
    """The program's diagnosis of a case under a calibration."""
    judged = with_coarse_counts(
        judge(case.found, calibration, free=case.free, motion=case.motion), coarse=len(case.coarse) > 0
    )
    counted: tuple[Key, ...] = tuple(("encoder_quantisation", joint) for joint in case.coarse)
    explained = judged.verdict in ("effect", "tie")
    single = {item.keys[0]: probability for item, probability in judged.singles}
    probability = single | dict.fromkeys(counted, judged.counts)
    return View(
        verdict=judged.verdict,
        ranked=tuple((key, probability[key]) for key in judged.in_order(probability)),
        explanation=(*judged.accepted.keys, *counted) if explained else (),
        tied=tuple(item.keys for item in judged.tied),
        none=judged.none,
        unknown=judged.unknown,
    )
