"""What a rehearsal tells: which cause is named how often, what it is taken for, and the smallest that shows."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from synth.rehearsal.ladder import visible_from
from synth.rehearsal.outcome import CANNOT, CaseOutcome, Key
from synth.rehearsal.plants import RUNGS
from synth.rehearsal.sizes import MEANING
from synth.rehearsal.users_rig import BACKGROUND, Rig
from synth.units import quantity

FORMAT = "synth/rehearsal/1"
LARGE = 2  # rung from which on a cause is large: what is named there counts in the sentence and the picture


@dataclass(frozen=True)
class CauseSummary:
    """One cause at one joint over its cases: the least rung at which it is named, with sizes and gaps there."""

    key: Key
    outcomes: tuple[CaseOutcome, ...]

    @property
    def rung(self) -> int | None:
        """Least rung from which on it is named; None where in none."""
        return visible_from(self.outcomes)

    @property
    def highest(self) -> int | None:
        """The highest rung that could be planted."""
        planted = [o.task.rung for o in self.outcomes if o.verdict != CANNOT]
        return max(planted) if planted else None

    def size(self) -> dict[str, Any] | None:
        """Median size at that rung, in the figure by which people speak of it."""
        rung, meaning = self.rung, MEANING.get(self.key[0])
        sizes = [o.size for o in self.outcomes if o.task.rung == rung and o.size is not None and o.counts]
        if rung is None or meaning is None or not sizes:
            return None
        return {"of": meaning[0], **quantity(float(np.median(sizes)), meaning[1])}

    def taken_for(self) -> dict[str, int]:
        """What it was taken for where it is large and was not named, most often first."""
        wrong = [o.taken_for for o in self.outcomes if o.counts and not o.right and o.task.rung >= LARGE]
        return dict(Counter(wrong).most_common())

    def as_json(self) -> dict[str, Any]:
        """One of ``causes``."""
        counted = [o for o in self.outcomes if o.counts]
        large = [o for o in counted if o.task.rung >= LARGE]
        rung = self.rung
        gaps = [o.gap for o in counted if o.task.rung == rung]
        return {
            "effect": self.key[0],
            "joint": self.key[1],
            "cases": len(counted),
            "named": sum(o.right for o in counted),
            "large": len(large),
            "large_named": sum(o.right for o in large),
            "visible_from": self.size(),
            "visible_gap": quantity(float(np.median(gaps)), "deg") if gaps else None,
            "times_unexplained": None if rung is None else RUNGS[rung],
            "cannot_be_large": any(o.verdict == CANNOT for o in self.outcomes),
            "taken_for": self.taken_for(),
        }


@dataclass(frozen=True)
class RehearsalResult:
    """All cases of a rehearsal, and what they rest on."""

    name: str
    rig: Rig
    seed: int
    outcomes: tuple[CaseOutcome, ...]
    identity: Mapping[str, str]

    @property
    def shown(self) -> tuple[CauseSummary, ...]:
        """Causes of the library, by effect and joint."""
        found: dict[Key, list[CaseOutcome]] = {}
        for outcome in self.outcomes:
            if outcome.kind == "cause" and outcome.planted is not None:
                found.setdefault(outcome.planted, []).append(outcome)
        order = {name: place for place, name in enumerate(["base", *self.rig.nominal.names])}
        return tuple(CauseSummary(key, tuple(found[key])) for key in sorted(found, key=lambda k: (k[0], order[k[1]])))

    def of_kind(self, kind: str) -> list[CaseOutcome]:
        """Cases that were planted and diagnosed."""
        return [o for o in self.outcomes if o.kind == kind and o.counts]

    @property
    def sentence(self) -> str:
        """The answer."""
        large = [o for o in self.of_kind("cause") if o.task.rung >= LARGE]
        nothing, strange = self.of_kind("nothing"), self.of_kind("stranger")
        seen = sum(shown.rung is not None for shown in self.shown)
        count = _of(sum(o.right for o in large), len(large))
        said = f"On these trials a cause whose gap is {RUNGS[LARGE]:g} times what stays unexplained or more is named "
        said += f"in {count}; {seen} of {len(self.shown)} causes were named at some size."
        if nothing:
            said += " With nothing but small causes planted, something that is not there is accused in "
            said += f"{_of(sum(not o.right for o in nothing), len(nothing))}."
        if strange:
            said += f" What is in no list is called unknown in {_of(sum(o.right for o in strange), len(strange))}."
        return said

    def as_json(self) -> dict[str, Any]:
        """``rehearsal.json``."""
        names = [shown.key for shown in self.shown]
        return {
            "format": FORMAT,
            "name": self.name,
            "sentence": self.sentence,
            "seed": self.seed,
            "cases": len(self.outcomes),
            "background": quantity(self.rig.background, "deg"),
            "background_share": BACKGROUND,
            "noise": quantity(float(np.sqrt(np.mean(self.rig.noise**2))), "deg"),
            "rungs": list(RUNGS),
            "causes": [shown.as_json() for shown in self.shown],
            "nothing_planted": self._tally("nothing"),
            "not_in_the_library": self._tally("stranger"),
            "confusion": self._confusion(names),
            "left_out": list(self.rig.left_out),
            "plants": [outcome.as_json() for outcome in self.outcomes],
            "identity": dict(self.identity),
            "warnings": list(self.rig.left_out),
        }

    def _tally(self, kind: str) -> dict[str, Any]:
        """How many were right, and what the others were taken for."""
        found = self.of_kind(kind)
        wrong = Counter(o.taken_for for o in found if not o.right)
        return {"cases": len(found), "right": sum(o.right for o in found), "taken_for": dict(wrong.most_common())}

    def _confusion(self, names: Sequence[Key]) -> list[dict[str, Any]]:
        """A row a cause: how often its large cases were said to be what."""
        rows = []
        for shown in self.shown:
            large = [o for o in shown.outcomes if o.counts and o.task.rung >= LARGE]
            said = Counter(o.taken_for for o in large)
            rows.append({"effect": shown.key[0], "joint": shown.key[1], "cases": len(large), "said": dict(said)})
        return rows


def _of(hits: int, count: int) -> str:
    return f"{hits} of {count}" if count else "none of 0"
