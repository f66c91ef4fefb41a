"""The result of a rehearsal: how often each cause is found, what it is confused with, its smallest detectable size."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from synth.rehearsal.ladder import visible_from
from synth.rehearsal.outcome import CANNOT, FAILED, CaseOutcome, Key
from synth.rehearsal.plants import RUNGS, cause_places
from synth.rehearsal.sizes import SIZE_MEANINGS
from synth.rehearsal.users_rig import BACKGROUND_SHARE, Rig
from synth.remarks import remarks_json
from synth.units import quantity

MOST_ENDS = 3  # ways in which diagnoses failed, in the sentence; each case has its own message
FORMAT = "synth/rehearsal/1"
LARGE_RUNG = 2  # rung of a large cause, for the sentence and the picture
LARGE = f"with a gap of {RUNGS[LARGE_RUNG]:g} times the unexplained remainder"


@dataclass(frozen=True)
class CauseSummary:
    """One cause at one joint over its cases: lowest rung at which it is found, with sizes and gaps there."""

    key: Key
    outcomes: tuple[CaseOutcome, ...]

    @property
    def rung(self) -> int | None:
        """Lowest rung from which it is found; None if there is none."""
        return visible_from(self.outcomes)

    @property
    def highest(self) -> int | None:
        """The highest rung that could be planted and was diagnosed."""
        planted = [o.task.rung for o in self.outcomes if o.counts]
        return max(planted) if planted else None

    def size(self) -> dict[str, Any] | None:
        """Median size at that rung, in its usual unit."""
        rung, meaning = self.rung, SIZE_MEANINGS.get(self.key[0])
        sizes = [o.size for o in self.outcomes if o.task.rung == rung and o.size is not None and o.counts]
        if rung is None or meaning is None or not sizes:
            return None
        return {"of": meaning[0], **quantity(float(np.median(sizes)), meaning[1])}

    @property
    def large(self) -> list[CaseOutcome]:
        """Of each draw of leg and form the case that tells whether a large cause is found.

        A large case is planted only where a smaller one of its draw was missed. The large cases by themselves would be
        a choice of the causes that are hard to find: a cause found at a smaller size counts as found when large. It
        does so from the draw's second case on, when one that was missed at first has been tried when large.
        """
        draws: dict[int, list[CaseOutcome]] = {}
        for outcome in self.outcomes:
            if outcome.counts:
                draws.setdefault(outcome.task.draw, []).append(outcome)
        found = []
        for cases in draws.values():
            smaller = [o for o in cases if o.right and o.task.rung < LARGE_RUNG] if len(cases) > 1 else []
            telling = [o for o in cases if o.task.rung == LARGE_RUNG] or smaller
            found += [max(telling, key=lambda o: o.task.rung)] if telling else []
        return found

    def taken_for(self) -> dict[str, int]:
        """Its confusions where it was large and neither found nor tied, most frequent first."""
        wrong = [o for o in self.large if not o.right and not o.tied]
        return dict(Counter(o.taken_for for o in wrong).most_common())

    def tied_with(self) -> dict[str, int]:
        """The causes that it was tied with at any size, most frequent first."""
        return dict(Counter(name for o in self.outcomes if o.counts for name in o.tied_with).most_common())

    def as_json(self) -> dict[str, Any]:
        """One entry of ``causes``."""
        counted = [o for o in self.outcomes if o.counts]
        large = self.large
        rung = self.rung
        gaps = [o.gap for o in counted if o.task.rung == rung]
        return {
            "effect": self.key[0],
            "joint": self.key[1],
            "cases": len(counted),
            "named": sum(o.right for o in counted),
            "named_with_absent": sum(o.with_absent for o in counted),
            "tied": sum(o.tied for o in counted),
            "large": len(large),
            "large_named": sum(o.right for o in large),
            "large_tied": sum(o.tied for o in large),
            "visible_from": self.size(),
            "visible_gap": quantity(float(np.median(gaps)), "deg") if gaps else None,
            "times_unexplained": None if rung is None else RUNGS[rung],
            "cannot_be_large": any(o.verdict == CANNOT for o in self.outcomes),
            "taken_for": self.taken_for(),
            "tied_with": self.tied_with(),
        }


@dataclass(frozen=True)
class RehearsalResult:
    """All cases of a rehearsal, and their input."""

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
        large = self._large
        nothing, others = self.of_kind("nothing"), self.of_kind("unlisted")
        text = ""
        if large:
            text = f"In these trials a cause {LARGE} is found in {_hits(sum(o.right for o in large), len(large))}"
            text += _count_text(sum(o.task.rung < LARGE_RUNG for o in large), " ({} of them at a smaller gap already)")
            text += _count_text(sum(o.with_absent for o in large), ", in {} together with an absent cause")
            text += _count_text(sum(o.tied for o in large), " and tied with others in {}") + "; "
        found = self._found_words("causes that were planted" if self._left > 0 else "causes that can act in this leg")
        text += found if text else found[:1].upper() + found[1:]
        if nothing:
            beside = {len(nothing): "small causes", 0: "noise"}.get(sum(bool(o.small) for o in nothing))
            text += f" With {beside or 'noise and some small causes'} only, an absent cause is named in "
            text += _hits(sum(not o.right and not o.tied for o in nothing), len(nothing))
            text += _count_text(sum(o.tied for o in nothing), " and tied with a true explanation in {}") + "."
        if others:
            text += (
                f" Causes outside the library are called unknown in {_hits(sum(o.right for o in others), len(others))}."
            )
        return f"{text} {self.failed}".rstrip()

    @property
    def failed(self) -> str:
        """How many diagnoses failed, and how; empty if none did."""
        found = [o for o in self.outcomes if o.verdict == FAILED]
        if not found:
            return ""
        ends = Counter(o.message.partition(":")[0] or "no message" for o in found)
        told = ", ".join(f"{end} ({count} times)" if count > 1 else end for end, count in ends.most_common(MOST_ENDS))
        verb = "diagnosis failed and is" if len(found) == 1 else "diagnoses failed and are"
        return f"{len(found)} {verb} not counted: {told}. The same command again repeats only what failed."

    @property
    def coverage(self) -> str:
        """What was not planted; empty if everything was."""
        words = [] if self._large else [f"any cause {LARGE}"]
        words += [f"{self._left} further causes that may act in this leg"] if self._left > 0 else []
        return f"Not planted: {'; '.join(words)}." if words else ""

    @property
    def _large(self) -> list[CaseOutcome]:
        """The first telling case of each cause: one that is found easily has more draws than one that is not."""
        return [shown.large[0] for shown in self.shown if shown.large]

    @property
    def _left(self) -> int:
        """How many causes that may act were not planted."""
        return len(cause_places(self.rig, self.seed)) - len(self.shown)

    def _found_words(self, kind: str) -> str:
        """How many of these causes were found, and how many were only tied with others."""
        possible = [shown for shown in self.shown if shown.highest is not None]
        if not possible:
            return "no cause was planted at a size that can be found."
        found = [shown for shown in possible if shown.rung is not None]
        tied = sum(any(o.tied for o in shown.outcomes) for shown in possible if shown.rung is None)
        text = f"{_hits(len(found), len(possible))} {kind} were found at some size"
        return (
            text
            + _count_text(tied, ", {} more only tied with others that these trials cannot distinguish from it")
            + "."
        )

    def as_json(self) -> dict[str, Any]:
        """``rehearsal.json``."""
        names = [shown.key for shown in self.shown]
        return {
            "format": FORMAT,
            "name": self.name,
            "sentence": self.sentence,
            "coverage": self.coverage,
            "seed": self.seed,
            "cases": len(self.outcomes),
            "background": quantity(self.rig.background, "deg"),
            "background_share": BACKGROUND_SHARE,
            "small_causes": self._small_causes_json(),
            "noise": quantity(float(np.sqrt(np.mean(self.rig.noise**2))), "deg"),
            "noise_filters": {
                name: one.words for name, one in zip(self.rig.nominal.names, self.rig.filters, strict=False) if one
            },
            "rungs": list(RUNGS),
            "joints": list(self.rig.nominal.names),
            "causes": [shown.as_json() for shown in self.shown],
            "nothing_planted": self._tally("nothing"),
            "not_in_the_library": self._tally("unlisted"),
            "confusion": self._confusion(names),
            "left_out": list(self.rig.left_out),
            "plants": [outcome.as_json() for outcome in self.outcomes],
            "identity": dict(self.identity),
            **remarks_json((*self.rig.left_out, *filter(None, [self.failed]))),
        }

    def _small_causes_json(self) -> dict[str, Any]:
        """In how many cases small causes were planted, how many at most, and the median gap that they leave."""
        planted = [o for o in self.outcomes if o.counts]
        beside = [o for o in planted if o.small]
        gap = float(np.median([o.small_gap for o in beside])) if beside else None
        most = max((len(o.small) for o in beside), default=0)
        told = None if gap is None else quantity(gap, "deg")
        return {"cases": len(beside), "of": len(planted), "most": most, "gap": told}

    def _tally(self, kind: str) -> dict[str, Any]:
        """Number of correct cases, and the confusions of the others."""
        found = self.of_kind(kind)
        wrong = Counter(o.taken_for for o in found if not o.right and not o.tied)
        tallied = {"cases": len(found), "right": sum(o.right for o in found), "tied": sum(o.tied for o in found)}
        tallied["with_small"] = sum(bool(o.small) for o in found)
        return tallied | {"taken_for": dict(wrong.most_common())}

    def _confusion(self, names: Sequence[Key]) -> list[dict[str, Any]]:
        """One row per cause: the diagnoses that tell whether it is found when large."""
        rows = []
        for shown in self.shown:
            large = shown.large
            diagnoses = Counter(o.diagnosis for o in large)
            rows.append(
                {"effect": shown.key[0], "joint": shown.key[1], "cases": len(large), "diagnoses": dict(diagnoses)}
            )
        return rows


def _count_text(count: int, text: str) -> str:
    """The text with the count; nothing for zero."""
    return text.format(count) if count else ""


def _hits(hits: int, count: int) -> str:
    return f"{hits} of {count}"
