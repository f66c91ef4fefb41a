"""Angles that jump by whole turns: readings wrapped to -180..180 or 0..360 deg, continued where that is certain.

A step is a jump if it is half a turn or more and far larger than those beside it, while less whole turns it is one of
them. A joint that turns on for many turns has no such step. A single wrong reading is an outlier, no jump.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import radians

import numpy as np

from synth.arrays import Array, Mask
from synth.swing.leg_model import Joint

TURN = 2.0 * np.pi  # rad
ROOM = 2.0  # times the larger of the two steps on each side, which a step may be
NOISE = np.radians(5.0)  # added to that: far above any encoder's noise, far below a turn
RUN = 3  # wrong readings in a run, as in ``motion.smoothing``
NEAR = 0.25  # of a turn from a whole one, up to which a step that is no jump is questioned
WIDEST = radians(400)  # beyond any joint's travel; a joint that turns farther must state its range
# Of a joint without a stated range, a choice: a human knee bends by about 140 deg. Degrees taken for radians are 57
# times as wide.
UNUSUAL_TRAVEL = radians(150)
YIELDING = radians(30)  # beyond a stated range: stops yield and zeros are off by some degrees


@dataclass(frozen=True, eq=False)
class Unwrapped:
    """One channel (n,) rad without jumps, how many there were, and the sample after the first doubtful step or None."""

    angle: Array
    jumps: int
    doubtful: int | None


def unwrapped(angle: Array) -> Unwrapped:
    """A channel (n,) rad, nan where missing, continued over its jumps."""
    known = np.flatnonzero(np.isfinite(angle))
    step = np.diff(angle[known])
    if not np.any(np.abs(step) > 0.5 * TURN):
        return Unwrapped(angle, 0, None)
    turns, usual = _whole_and_usual(step)
    # Over missing samples a joint moves farther; more than a quarter of a turn, and the turns are a guess.
    near = np.minimum(usual * np.diff(known), np.maximum(usual, NEAR * TURN))
    jump = (turns != 0.0) & (np.abs(step) > near) & (np.abs(step - turns * TURN) <= near)
    result = angle.copy()
    result[known] -= np.r_[0.0, np.cumsum(np.where(jump, turns, 0.0))] * TURN
    step = np.diff(result[known])
    turns, usual = _whole_and_usual(step)
    odd = (turns != 0.0) & (np.abs(step - turns * TURN) <= NEAR * TURN) & (np.abs(step) > usual * np.diff(known))
    odd &= ~_there_and_back(step, usual)
    return Unwrapped(result, int(jump.sum()), int(known[np.argmax(odd) + 1]) if odd.any() else None)


def continued(direction: Array) -> Array:
    """Directions (n,) rad, nan where missing, each on the turn nearest to the one before.

    For angles of vectors, which are known within a turn only: any step is the one below half a turn. A reading of a
    sensor may count its turns, and is ``unwrapped`` instead.
    """
    result = direction.copy()
    known = np.isfinite(direction)
    result[known] = np.unwrap(direction[known])
    return result


def usual_angle(joint: Joint) -> float:
    """Where a joint is by its leg file, rad: the middle of its range, else its spring's free angle, else straight."""
    if joint.range is not None:
        return sum(joint.range) / 2
    return joint.spring.free_angle if joint.spring is not None else joint.zero


def widest(joint: Joint) -> float:
    """The largest angle, rad, either way, that a recording of the joint may hold."""
    return max([WIDEST, *(abs(end) + YIELDING for end in joint.range or ())])


def far_command(joint: Joint, command: Array) -> int | None:
    """Index of the first command (m,) rad beyond what a recording of the joint may hold; None if there is none."""
    beyond = np.abs(command) > widest(joint)
    return int(beyond.argmax()) if beyond.any() else None


def unusual_travel(joint: Joint, angle: Array) -> float:
    """What readings (n,) rad of the joint cover, rad, where that is more than it is known to do; else 0.

    A joint does what its stated range says, and without one what a limb's joint does.
    """
    known = np.sort(angle[np.isfinite(angle)])
    wrong = min(RUN, len(known) // 8)  # at either end: a run of wrong readings does not count
    low, high = float(known[wrong]), float(known[-1 - wrong])
    if joint.range is not None:
        usual = joint.range[0] - YIELDING <= low and high <= joint.range[1] + YIELDING
    else:
        usual = high - low <= UNUSUAL_TRAVEL
    return 0.0 if usual else high - low


def _whole_and_usual(step: Array) -> tuple[Array, Array]:
    """(m,) the turn nearest to each step, -1, 0 or 1, and (m,) rad up to which it is usual beside its neighbours.

    Readings within one turn jump by no more than one.
    """
    turns = np.round(step / TURN)
    turns[np.abs(turns) > 1.0] = 0.0
    return turns, _beside(np.where(turns == 0.0, np.abs(step), 0.0)) * ROOM + NOISE


def _there_and_back(step: Array, usual: Array) -> Mask:
    """(m,) True for steps to a run of at most ``RUN`` wrong readings and back: outliers, which a fit ignores."""
    found = np.zeros(len(step), dtype=bool)
    for apart in range(1, min(RUN, len(step) - 1) + 1):
        back = np.abs(step[:-apart] + step[apart:]) <= usual[:-apart] + usual[apart:]
        found[:-apart] |= back
        found[apart:] |= back
    return found


def _beside(size: Array) -> Array:
    """(m,) the largest of the two before and the two after each."""
    padded = np.pad(size, 2)
    return np.asarray(np.max([padded[k : k + len(size)] for k in (0, 1, 3, 4)], axis=0))


def turns_back(spans: Sequence[tuple[float, float, float]], joint: Joint) -> list[int]:
    """Whole turns that bring a joint's recordings back that lie on another turn than the others; else 0.

    ``spans`` : (t) lower end, middle and upper end of the angles, rad, without glitches. A spring's angle is not
    periodic, so a recording is turned only where no joint turns on: each covers less than half a turn, and after the
    turn it lies where the others do. What lies in the joint's stated range stays.
    """
    none = [0] * len(spans)
    if any(high - low > TURN / 2 for low, _, high in spans):
        return none
    ends = joint.range or (np.inf, -np.inf)
    inside = [ends[0] - YIELDING <= low and high <= ends[1] + YIELDING for low, _, high in spans]
    middles = np.array([middle for _, middle, _ in spans])
    # Where most are; of as many, where the leg file has the joint.
    some = middles[inside] if any(inside) else middles
    alike = np.abs(some[:, None] - some) <= TURN / 2
    most = np.lexsort((np.abs(some - usual_angle(joint)), -alike.sum(axis=1)))[0]
    home = float(np.median(some[alike[most]]))
    away = np.abs(middles - home) > TURN / 2
    turns = np.round((home - middles) / TURN)
    back = np.abs(middles + turns * TURN - home) < TURN / 4
    return [int(turns[t]) if away[t] and back[t] and not inside[t] else 0 for t in range(len(spans))]


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
