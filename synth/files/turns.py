"""Angles that jump by whole turns: readings wrapped to -180..180 or 0..360 deg, continued where that is certain.

A step is a jump if it is half a turn or more and far larger than those beside it, while less whole turns it is one of
them. A joint that turns on for many turns has no such step. A single wrong reading is an outlier, no jump.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.motion.smoothing import lost_samples

TURN = 2.0 * np.pi  # rad
ROOM = 2.0  # times the larger of the two steps on each side, which a step may be
NOISE = np.radians(5.0)  # added to that: far above any encoder's noise, far below a turn
NEAR = 0.25  # of a turn from a whole one, up to which a step that is no jump is questioned


@dataclass(frozen=True, eq=False)
class Unwrapped:
    """One channel (n,) rad without jumps, how many there were, and the sample after the first doubtful step or None."""

    angle: Array
    jumps: int
    doubtful: int | None


def unwrapped(angle: Array) -> Unwrapped:
    """A channel (n,) rad, nan where missing, continued over its jumps."""
    known = np.flatnonzero(np.isfinite(angle))
    value = angle[known]
    step = np.diff(value)
    if not np.any(np.abs(step) > 0.5 * TURN):
        return Unwrapped(angle, 0, None)
    turns = np.round(step / TURN)
    usual = _beside(np.where(turns == 0.0, np.abs(step), 0.0)) * ROOM + NOISE
    # Over missing samples a joint moves farther; more than a quarter of a turn, and the turns are a guess.
    usual = np.minimum(usual * np.diff(known), np.maximum(usual, NEAR * TURN))
    left = np.abs(step - turns * TURN)
    jump = (turns != 0.0) & (np.abs(step) > usual) & (left <= usual)
    whole = value - np.r_[0.0, np.cumsum(np.where(jump, turns, 0.0))] * TURN
    result = angle.copy()
    result[known] = whole
    good = known[~lost_samples(whole[:, None])[:, 0]]
    step = np.diff(result[good])
    turns = np.round(step / TURN)
    usual = _beside(np.where(turns == 0.0, np.abs(step), 0.0)) * ROOM + NOISE
    odd = (turns != 0.0) & (np.abs(step - turns * TURN) <= NEAR * TURN) & (np.abs(step) > usual * np.diff(good))
    return Unwrapped(result, int(jump.sum()), int(good[np.argmax(odd) + 1]) if odd.any() else None)


def _beside(size: Array) -> Array:
    """(m,) the largest of the two before and the two after each."""
    padded = np.pad(size, 2)
    return np.asarray(np.max([padded[k : k + len(size)] for k in (0, 1, 3, 4)], axis=0))


def turns_together(middles: Sequence[float], jumped: Sequence[bool], reference: float) -> list[float]:
    """Whole turns, rad, that bring one joint's recordings together, of which some were unwrapped.

    ``middles`` (t,) rad of their angles; ``jumped`` : which were unwrapped. If none was, all stay. Those that never
    jumped agree with the leg file as a rule, so that all go to the turn nearest to their median; else to that of the
    first, which is the nearest to ``reference``, rad.
    """
    if not any(jumped):
        return [0.0] * len(middles)
    kept = [middle for middle, moved in zip(middles, jumped, strict=True) if not moved]
    first = float(np.median(kept)) if kept else middles[0] + TURN * round((reference - middles[0]) / TURN)
    return [TURN * round((first - middle) / TURN) for middle in middles]
