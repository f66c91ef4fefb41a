"""When a sliding joint of each lane turns within the lane's own step, or a common one; see ``turning_events``.

The rate's course over a step is that of the dense output, of order 4, so a step that is repeated up to the turn ends
within ``EVENT_WINDOW`` of it.
"""

from __future__ import annotations

from typing import Any

from numba import int64, njit

from synth.compiling.numba_internals import UNCOUNTED
from synth.swing.effects.inlined import LEAST_PRESLIDING, inlined
from synth.swing.explicit_pairs import DORMAND_PRINCE
from synth.swing.lane_layout import LANES, PLACE
from synth.swing.turning_events import EVENT_WINDOW, MEMORIES, NEVER

_DENSE = DORMAND_PRINCE.dense
_options: dict[str, Any] = {"fastmath": True, "error_model": "numpy", "nogil": True, **UNCOUNTED}
# Of the way from its bend to sliding, so much less is taken as enough that no start of sliding is missed.
_RESERVE = 0.7
_ITERATIONS = 8  # of Newton's method; three are usual
_BEYOND = 0.1  # of the step, in which a turn after its end is looked for
_HALVINGS = 12  # of the step, for a turn and a turn back within it; shorter ones reverse friction for too short a time


@njit(**_options)
def turns_within(bends, slides, Z, x, y, K, step, cut, leader):  # type: ignore[no-untyped-def]
    """Write to ``cut`` (16,) the time from the start of each lane's step to its first turn, ``NEVER`` without one.

    A turn within ``EVENT_WINDOW`` of the end of the step is at its end. Where a lane turns, those with the same
    ``leader`` (16,) also step to their turn if it lies shortly after their step, so that copies of a leg take steps
    alike. ``step`` (16,) s; other arrays as in ``turning_events``.
    """
    for lane in range(LANES):
        cut[lane] = NEVER
    for m in range(len(bends)):
        if bends[m, 0] < 0:
            continue
        own, b, row = (m * LANES) & PLACE, (bends[m, 0] * LANES) & PLACE, bends[m, 1] & PLACE
        # Most steps contain no turn; this vectorised check over all lanes decides.
        count = 0.0
        for lane in range(LANES):
            before, after, sliding = x[b + lane], y[b + lane], slides[own + lane]
            sense = sliding if sliding != 0.0 else before
            near = (after * sense <= 0.0) | (abs(after) <= EVENT_WINDOW * abs(K[6, b + lane]))
            near |= (
                _lowest(before * sliding, after * sliding, step[lane], K[0, b + lane], K[6, b + lane], sliding) < 0.0
            )
            count += 1.0 if near & (Z[row, lane] < LEAST_PRESLIDING) & (step[lane] > 0.0) else 0.0
        if count == 0.0:
            continue
        turned = 0  # a bit for each leader with a lane that turns
        for lane in range(LANES):
            h, d, e = step[lane], (MEMORIES + m) * LANES + lane, b + lane
            if Z[row, lane] >= LEAST_PRESLIDING or h == 0.0:
                continue
            before, after, sense = x[e], y[e], slides[own + lane]
            slid = sense != 0.0
            if not slid:  # it bends, but may start to slide within the step and turn after that
                sense = 1.0 if before > 0.0 else -1.0
                slid = _RESERVE * abs(K[0, d]) * h * abs(before) > (1.0 - x[d] * sense) * abs(before - after)
            if abs(after) <= EVENT_WINDOW * abs(K[6, e]):
                if y[d] * sense > 0.999:  # turns at the end of the step; undo what it has bent back by then
                    y[d] = sense
            elif after * sense < 0.0 and slid:
                where = _turn(before, after, h, e, K, sense, 0.0, 1.0)
                cut[lane] = min(cut[lane], max(where * h, 1e-3 * EVENT_WINDOW))
                turned |= 1 << int64(leader[lane])
            elif slides[own + lane] != 0.0 and _lowest(before * sense, after * sense, h, K[0, e], K[6, e], sense) < 0.0:
                where = _lowest_place(before, after, h, e, K, sense)
                if where > 0.0:
                    where = _turn(before, after, h, e, K, sense, 0.0, where)
                    cut[lane] = min(cut[lane], max(where * h, 1e-3 * EVENT_WINDOW))
        for lane in range(LANES if turned else 0):
            h, e, sense = step[lane], b + lane, slides[own + lane]
            late = (turned >> int64(leader[lane])) & 1 != 0 and cut[lane] == NEVER and h > 0.0
            if late and y[e] * sense > EVENT_WINDOW * abs(K[6, e]):
                where = _turn(x[e], y[e], h, e, K, sense, 1.0, 1.0 + _BEYOND)
                cut[lane] = where * h if where < 1.0 + _BEYOND else NEVER


@njit(**_options)
def first_turn(bends, slides, Z, x, y, K, t, h, room, due):  # type: ignore[no-untyped-def]
    """Time from the start of a common step from ``t`` to ``t + h`` to the first turn in any lane; ``h`` without one.

    ``due`` (16,) is filled with the times of each lane's first turn, ``NEVER`` without one. ``room`` (3, 16).
    """
    step, cut, leader = room[0], room[1], room[2]
    for lane in range(LANES):
        step[lane], leader[lane] = h, lane  # each its own: a turn after the step's end is left to the next step
    turns_within(bends, slides, Z, x, y, K, step, cut, leader)
    first = h
    for lane in range(LANES):
        first = min(first, cut[lane])
        due[lane] = t + cut[lane] if cut[lane] < NEVER else NEVER
    return first


@inlined
def _lowest(before, after, h, first, last, sense):  # type: ignore[no-untyped-def]
    """Bound from below of a convex course within the step, where the tangents of both ends meet; 1 of another course.

    ``before``, ``after`` : rates in the sense of sliding; ``first``, ``last`` : accelerations.
    """
    falling, rising = h * first * sense, h * last * sense
    dips = (falling < 0.0) & (rising > 0.0)
    where = (before - after + rising) / (rising - falling if dips else 1.0)
    return before + where * falling if dips else 1.0


@njit(**_options)
def _top(h, e, K):  # type: ignore[no-untyped-def]
    """The coefficient of fourth order of the rate's course."""
    top = _DENSE[0] * K[0, e] + _DENSE[2] * K[2, e] + _DENSE[3] * K[3, e]
    return h * (top + _DENSE[4] * K[4, e] + _DENSE[5] * K[5, e] + _DENSE[6] * K[6, e])


@njit(**_options)
def _lowest_place(before, after, h, e, K, sense):  # type: ignore[no-untyped-def]
    """Share of the step at which the rate is lowest in the sense of sliding, by bisection; 0 if it does not turn."""
    rise = after - before
    bow, top = h * K[0, e] - rise, _top(h, e, K)
    skew = rise - h * K[6, e] - bow
    low, high = 0.0, 1.0
    for _ in range(_HALVINGS):
        p = 0.5 * (low + high)
        u = 1.0 - p
        if (rise + (u - p) * bow + p * (2.0 - 3.0 * p) * skew + 2.0 * p * u * (u - p) * top) * sense < 0.0:
            low = p
        else:
            high = p
        if (before + p * (rise + u * (bow + p * (skew + u * top)))) * sense < 0.0:
            return p
    return 0.0


@njit(**_options)
def _turn(before, after, h, e, K, sense, low, high):  # type: ignore[no-untyped-def]
    """Share of the step between ``low`` and ``high`` at which the rate turns, by Newton's method and bisection.

    ``sense`` : sign of the rate before that.
    """
    rise = after - before
    bow, top = h * K[0, e] - rise, _top(h, e, K)
    skew = rise - h * K[6, e] - bow
    p = before / (before - after)
    for _ in range(_ITERATIONS):
        if not (low <= p <= high):
            p = 0.5 * (low + high)
        u = 1.0 - p
        value = before + p * (rise + u * (bow + p * (skew + u * top)))
        if value * sense > 0.0:
            low = p
        else:
            high = p
        slope = rise + (u - p) * bow + p * (2.0 - 3.0 * p) * skew + 2.0 * p * u * (u - p) * top
        p -= value / slope
    return min(max(p, low), high)
