"""Where a joint comes to rest: its last samples, or, if the recording ends in motion, what its swings tell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from synth.arrays import Array

TAIL = 10  # a recording's last tenth
LEAST_SWING = 0.02  # of the range: smaller turns are no swings
# Peak-to-peak motion over the last half cycle, of the whole range, above which a joint still moves: turns that count
# as swings remain, about which the mean of the last samples is not yet the rest.
STILL_RANGE = LEAST_SWING
# Of the last swing: two estimates of rest that differ by more belong to no single decaying oscillation
CLOSE_ESTIMATES = 0.1
# Of the first swing, that a motion which starts at rest covers in the first tenth of a half cycle: 2.4 % for a cosine.
STARTS_SLOWLY = 0.06

MOVES_AT_END = "the recording ends before the joint comes to rest"
FROM_SWINGS = f"{MOVES_AT_END}, which is estimated from its last swings"
FROM_LEG = f"{MOVES_AT_END}, which is taken from the fitted leg"


@dataclass(frozen=True)
class Rest:
    """``angle`` rad, None if unknown; ``why`` : how it was found if not from the last samples, or why it is unknown.

    ``turns`` (m,) s : times of the motion's extremes, for the frequency of a motion about an unknown rest.
    """

    angle: float | None
    why: str
    turns: Array


def last_tenths(angle: Array) -> Array:
    """(...) mean of the last tenth of curves (n, ...), their rest if they have come to rest."""
    return np.asarray(angle[-max(2, len(angle) // TAIL) :].mean(axis=0))


def last_tenth(angle: Array) -> float:
    """As ``last_tenths`` of one curve (n,)."""
    return float(last_tenths(angle))


def rest_of(time: Array, angle: Array, noise: float, equilibrium: float | None = None) -> Rest:
    """Rest of a smooth curve, ``time`` (n,) s and ``angle`` (n,) rad with ``noise`` rad.

    The mean of the last tenth, if the curve hardly moves over its last half cycle (see ``STILL_RANGE``). Else the
    ``equilibrium`` of a leg fitted to it, if it lies between the last two extremes, as a decaying oscillation's does.
    Else from the last three extremes: their distances from rest have one ratio, so rest is
    ``(x0 x2 - x1^2) / (x0 + x2 - 2 x1)`` (Aitken's delta-squared process; exact for one decaying mode); if a fourth is
    there, its estimate must agree.
    """
    span = float(np.ptp(angle))
    turns = _turns(angle, max(3 * noise, LEAST_SWING * span))
    inner = [vertex(time, angle, k) for k in turns[1:]]
    moments = np.array([at for at, _ in inner])
    begins = [len(angle) - max(2, len(angle) // TAIL)]
    if len(turns) > 1:
        begins.append(int(np.searchsorted(time, time[-1] - (time[turns[-1]] - time[turns[-2]]))))
    if float(np.ptp(angle[min(begins) :])) <= max(6 * noise, STILL_RANGE * span):
        return Rest(last_tenth(angle), "", moments)
    heights = [height for _, height in inner]
    if len(turns) > 1 and _starts_at_rest(time, angle, turns[1]):
        heights = [float(angle[0]), *heights]
    if equilibrium is not None and _lies_between(equilibrium, heights, angle):
        return Rest(equilibrium, FROM_LEG, moments)
    found = _of_swings(heights)
    return Rest(found, MOVES_AT_END if found is None else FROM_SWINGS, moments)


def vertex(time: Array, angle: Array, k: int) -> tuple[float, float]:
    """Time and height of the extreme at sample ``k``, from the parabola through it and its neighbours."""
    a, b, c = (float(value) for value in angle[k - 1 : k + 2])
    bend = a - 2 * b + c
    shift = 0.5 * (a - c) / bend if bend else 0.0
    return float(time[k] + shift * 0.5 * (time[k + 1] - time[k - 1])), b - 0.25 * (a - c) * shift


def _turns(angle: Array, least: float) -> list[int]:
    """Samples of the first sample and the extremes, each farther than ``least`` from the curve's next turn."""
    found, way, top, bottom = [0], 0, 0, 0
    for k in range(1, len(angle)):
        top = k if angle[k] > angle[top] else top
        bottom = k if angle[k] < angle[bottom] else bottom
        if way >= 0 and angle[top] - angle[k] > least:
            found += [top] if top else []
            way, bottom = -1, k
        elif way <= 0 and angle[k] - angle[bottom] > least:
            found += [bottom] if bottom else []
            way, top = 1, k
    return found


def _starts_at_rest(time: Array, angle: Array, turn: int) -> bool:
    """Whether the first sample is an extreme: the motion to the first turn begins slowly."""
    soon = int(np.searchsorted(time, time[0] + 0.1 * (time[turn] - time[0])))
    return 0 < soon < turn and bool(abs(angle[soon] - angle[0]) < STARTS_SLOWLY * abs(angle[turn] - angle[0]))


def _lies_between(rest: float, heights: list[float], angle: Array) -> bool:
    """Whether a rest lies between the last two extremes, or, with fewer, ahead of the curve's end or within it."""
    if len(heights) > 1:
        return min(heights[-2:]) < rest < max(heights[-2:])
    return bool(np.isfinite(rest) and (angle[-1] - angle[0]) * (rest - angle[0]) > 0)


def _of_swings(heights: list[float]) -> float | None:
    """Rest of a decaying oscillation from its extremes; None if they belong to none."""
    if len(heights) < 3:
        return None
    found = [_aitken(*heights[k - 3 : k]) for k in range(len(heights), max(len(heights) - 2, 2), -1)]
    if None in found or abs(found[0] - found[-1]) > CLOSE_ESTIMATES * abs(heights[-1] - heights[-2]):  # type: ignore[operator]
        return None
    return found[0]


def _aitken(first: float, second: float, third: float) -> float | None:
    """The limit of a sequence whose differences shrink and alternate; None if they do not."""
    if not -1.0 < (third - second) / (second - first) < 0.0:
        return None
    return (first * third - second**2) / (first + third - 2 * second)
