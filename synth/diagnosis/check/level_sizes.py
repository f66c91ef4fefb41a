"""Sizes of a cause whose strength starts from no zero: a limit, which the lower it is takes the more off.

Such a strength is log-normal, and where it does nothing no multiple of it would do more: a limit of current above all
that the drive asks for. Its effect is not proportional to anything either, because of a lower limit ever more is cut
off. So its sizes are read from a ladder over its whole range: of ``n`` times the smallest visible size is the value
at which the signal is ``n`` times as large.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.diagnosis.effect_shape import SMALL_STRENGTH, ShapedEffect, has_size
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.screening import ladder_starts

COARSE_RUNGS = 25  # over the prior's whole range: steps of 28 % of a torque limit's
FINE_RUNGS = 7  # between the two among which the smallest visible size is: to 4 %, then interpolated


CHANGES = (0.01, 0.1, 1.0, 4.0, 12.0, 30.0, 70.0)  # of a stated size, in units of a search's first strength


@dataclass(frozen=True)
class Level:
    """The signal of a cause without a zero at each of its values, from the weakest to the strongest.

    ``points`` (n_rung, n_unknown) whitened; ``signals`` (n_rung,) after subtracting the tolerances' part.
    """

    points: Array
    signals: Array

    @classmethod
    def of(cls, points: Array, signals: Array, strength: int) -> Level | None:
        """Rungs in any order; None if the motion diverges at all. ``strength`` : index of an unknown that is one."""
        known = np.flatnonzero(np.isfinite(signals))
        if not len(known):
            return None
        order = known[np.argsort(points[known, strength])]
        if signals[order[0]] > signals[order[-1]]:
            order = order[::-1]
        return cls(points[order], signals[order])

    def at_signal(self, wanted: float) -> Array | None:
        """Whitened unknowns (n_unknown,) of the weakest value with that signal; None if none has it."""
        return _point_with(self.points, self.signals, wanted)

    def rung_with_signal(self, wanted: float) -> Array:
        """The weakest rung with at least that signal; else the strongest.

        Not interpolated: between the last rung that does nothing and the first that acts, a limit may do nothing yet.
        """
        k = _first_with(self.signals, wanted)
        return np.asarray(self.points[int(np.argmax(self.signals)) if k is None else k])

    def between(self, wanted: float) -> list[Array]:
        """Points between the two rungs among which the wanted signal is; none without such."""
        k = _first_with(self.signals, wanted)
        if not k:
            return []
        shares = np.arange(1, FINE_RUNGS + 1)[:, None] / (FINE_RUNGS + 1)
        return list(self.points[k - 1] + shares * (self.points[k] - self.points[k - 1]))

    @property
    def falls(self) -> bool:
        """Whether the lower its value the stronger it is: a limit."""
        return bool(np.sum(self.points[-1] - self.points[0]) < 0.0)


def _first_with(signals: Array, wanted: float) -> int | None:
    reached = np.flatnonzero(signals >= wanted)
    return int(reached[0]) if len(reached) else None


def _point_with(points: Array, signals: Array, wanted: float) -> Array | None:
    """The point with that signal, linear between the last rung below it and the first above."""
    k = _first_with(signals, wanted)
    if k is None:
        return None
    if k == 0:
        return np.asarray(points[0])
    share = (wanted - signals[k - 1]) / (signals[k] - signals[k - 1])
    return np.asarray(points[k - 1] + share * (points[k] - points[k - 1]))


def is_level(candidate: ShapedEffect) -> bool:
    """Whether its strengths have no zero, and it has no place that would make it visible, as a stop has."""
    return not has_size(candidate) and not any(parameter.anchor for parameter in candidate.effect.parameters)


def strength_places(candidate: ShapedEffect) -> list[int]:
    """Places of the strengths among its unknowns."""
    return [k for k, name in enumerate(candidate.shape.free) if name in candidate.effect.strengths]


def level_rungs(start: EvaluatedHypothesis, first: int) -> list[EvaluatedHypothesis]:
    """The start with its strengths over their whole range; ``first`` : index of the candidate's unknowns."""
    candidate = start.hypothesis[-1]
    low, high = candidate.bounds()
    chosen = strength_places(candidate)
    made = []
    for share in np.linspace(0.0, 1.0, COARSE_RUNGS):
        point = start.unknowns[first:].copy()
        point[chosen] = low[chosen] + share * (high[chosen] - low[chosen])
        made.append(with_point(start, first, point))
    return made


def rungs_from_designed(start: EvaluatedHypothesis, first: int) -> list[EvaluatedHypothesis]:
    """The start at a ladder of sizes from the designed one, in both senses: 0, or of a stated effect its size."""
    candidate = start.hypothesis[-1]
    if not candidate.designed:
        return ladder_starts(start, first)
    low, high = candidate.bounds()
    strong = np.zeros(candidate.size)
    strong[[k for k, name in enumerate(candidate.shape.free) if name in candidate.designed]] = SMALL_STRENGTH
    points = [
        np.clip(start.unknowns[first:] + factor * strong, low, high) for size in CHANGES for factor in (size, -size)
    ]
    distinct = {tuple(point.round(9)): point for point in points if np.any(point != start.unknowns[first:])}
    return [with_point(start, first, point) for point in distinct.values()]


def with_point(start: EvaluatedHypothesis, first: int, point: Array) -> EvaluatedHypothesis:
    """The start with its last candidate's unknowns (n_unknown,) replaced."""
    return start.start_at(unknowns=np.concatenate([start.unknowns[:first], point]), frame=start.frame)


def distinct_starts(candidate: ShapedEffect) -> list[Array]:
    """Its starts; of those that differ in the strengths alone the first, if its ladder covers them all."""
    starts = candidate.starts()
    if not is_level(candidate):
        return starts
    shapes = [k for k in range(candidate.size) if k not in strength_places(candidate)]
    return list({tuple(start[shapes]): start for start in reversed(starts)}.values())
