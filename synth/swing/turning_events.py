"""Events of each lane: a joint with dry friction reverses, or a joint with backlash meets a flank.

Sliding friction changes sign at once when its joint reverses. A bristle alone would do so over its presliding, which
delays every half swing (measured: an error of 25 times the presliding after ten half swings). A step therefore ends
where the rate of a sliding joint passes zero. The bend of the bristle is then set to the value that keeps the joint at
rest, or, if even the full friction torque does not hold the joint, to sliding in the other direction. Between events
the motion is smooth: friction keeps its sign during a step, even in stages beyond the reversal at which the step is
then cut.

An intended presliding, as of gears, is kept at a reversal: fully if it is at least ``LEAST_PRESLIDING``, which every
bristle has while it holds, and in proportion if it is smaller.

A step also ends where a joint with backlash meets a flank, because the damper behind the flank makes the force jump.

Lanes with an event within ``EVENT_WINDOW`` of the end of the step have it there together. Each is corrected to first
order for the time difference (saltation of hybrid systems: Leine & Nijmeijer, *Dynamics and Bifurcations of Non-Smooth
Mechanical Systems*, 2004, ch. 7), so that perturbed copies of a leg remain smooth functions of the perturbation.

Arrays are flat with 16 lanes per state: ``x`` is the state at the start of a step, ``y`` at its end, ``K``
(7, n_state * 16) contains the derivatives. States are ``MOST_LINKS`` angles, as many rates, and memories from
``MEMORIES`` on. ``bends`` (n_memory, 2) : for a bristle, the state whose rate bends it and the row of its presliding in
the workspace ``Z``, else -1. ``slides`` has 16 entries a memory, ``due`` one a lane. ``plays`` (n_memory, 3) : for the
output side of a backlash, the joint and the rows of the gap and of the spring's rest, else -1.
"""

from __future__ import annotations

import math
from typing import Any

from numba import njit

from synth.compiling.numba_internals import UNCOUNTED
from synth.swing.effects.inlined import LEAST_PRESLIDING, bend_that_holds, held
from synth.swing.lane_layout import LANES, MOST_LINKS, PLACE

EVENT_WINDOW = 1e-5  # s, accuracy of an event: at 10 rad/s^2 a rate of 1e-4 rad/s, negligible
MEMORIES = 2 * MOST_LINKS  # the first of them among the states
NEVER = 1e300  # s, time of an event that is not expected
SEATED = 1e-9  # rad of overlap with the flank, more than rounding errors
_options: dict[str, Any] = {"fastmath": True, "error_model": "numpy", "nogil": True, **UNCOUNTED}


@njit(**_options)
def _kept_share(bends, m, lane, Z):  # type: ignore[no-untyped-def]
    """Share of the holding presliding of bristle ``m`` that remains at a reversal: 0 none, 1 all of it."""
    return min(Z[bends[m, 1], lane] / LEAST_PRESLIDING, 1.0)


@njit(**_options)
def slide_from_start(bends, Z, x, K):  # type: ignore[no-untyped-def]
    """Initial bend of each bristle: sliding in the direction of motion, or, at rest, of the applied torque.

    A joint at rest is then treated as a reversal, which determines whether friction holds it. A bristle that keeps its
    full presliding at reversals starts straight.
    """
    for m in range(len(bends)):
        if bends[m, 0] >= 0:
            for lane in range(LANES):
                rate, pull = x[bends[m, 0] * LANES + lane], K[0, bends[m, 0] * LANES + lane]
                if rate == 0.0 and _kept_share(bends, m, lane, Z) >= 1.0:
                    x[(MEMORIES + m) * LANES + lane] = 0.0
                else:
                    x[(MEMORIES + m) * LANES + lane] = 1.0 if rate > 0.0 or (rate == 0.0 and pull < 0.0) else -1.0


@njit(**_options)
def find_reversals(bends, m, started, Z, x, K, turning, target):  # type: ignore[no-untyped-def]
    """Write to ``turning`` (16,) the direction in which bristle ``m`` slid if its joint reverses now, else 0.

    ``target`` (16,) : its bend if even the full friction torque does not hold the joint. Without presliding it slides
    in the other direction at once, otherwise it still has to bend there; before the first step (not ``started``) it was
    straight. If no lane reverses, both arrays are unchanged and the result is False.
    """
    d, b, row = ((MEMORIES + m) * LANES) & PLACE, (bends[m, 0] * LANES) & PLACE, bends[m, 1] & PLACE
    count = 0.0
    for lane in range(LANES):
        z, rate, pull = x[d + lane], x[b + lane], K[0, b + lane]
        near = (abs(rate) <= EVENT_WINDOW * abs(pull)) & (pull * z < 0.0)
        count += 1.0 if near & (abs(z) >= 1.0) & (Z[row, lane] < LEAST_PRESLIDING) else 0.0
    if count == 0.0:
        return False
    for lane in range(LANES):
        z, rate, pull = x[d + lane], x[b + lane], K[0, b + lane]
        kept = _kept_share(bends, m, lane, Z)
        back = kept < 1.0 and abs(z) >= 1.0 and pull * z < 0.0 and abs(rate) <= EVENT_WINDOW * abs(pull)
        turning[lane] = z if back else 0.0
        target[lane] = z * (2.0 * kept - 1.0) if started else z * (kept - 1.0)
    return True


@njit(**_options)
def hold_joint(bends, m, x, K, turning, target):  # type: ignore[no-untyped-def]
    """Set the bend to the value at which the joint's acceleration is zero, or to ``target`` if there is none.

    The acceleration is linear in the share of the friction torque that the bristle exerts; ``K[0]`` contains it for the
    present bend, ``K[1]`` for the target.
    """
    for lane in range(LANES):
        if turning[lane] != 0.0:
            d, e = (MEMORIES + m) * LANES + lane, bends[m, 0] * LANES + lane
            if K[1, e] * turning[lane] <= 0.0:
                x[d] = target[lane]
            else:
                share = turning[lane] + (held(target[lane], 0.0) - turning[lane]) * K[0, e] / (K[0, e] - K[1, e])
                x[d] = bend_that_holds(share)


@njit(**_options)
def correct_reversal(n, bends, m, x, K, turning):  # type: ignore[no-untyped-def]
    """Correct the rates for the time since the reversal, during which friction had the wrong sign.

    ``K[0]`` : accelerations with the wrong sign, ``K[2]`` : with the right one.
    """
    for lane in range(LANES):
        if turning[lane] != 0.0:
            late = x[bends[m, 0] * LANES + lane] / K[0, bends[m, 0] * LANES + lane]
            _correct_rates(n, lane, late, x, K)
    for e in range(len(x)):
        K[0, e] = K[2, e]


@njit(**_options)
def _correct_rates(n, lane, late, x, K):  # type: ignore[no-untyped-def]
    """Correct one lane's rates for an event ``late`` s ago, from the accelerations before and after it."""
    for i in range(MOST_LINKS, MOST_LINKS + (n & MOST_LINKS)):
        e = i * LANES + lane
        x[e] += (K[2, e] - K[0, e]) * late


@njit(**_options)
def find_sliding(bends, Z, x, K, slides):  # type: ignore[no-untyped-def]
    """Write to ``slides`` the direction in which each bristle slides during the next step, 0 if it bends."""
    for m in range(len(bends)):
        own = (m * LANES) & PLACE
        if bends[m, 0] < 0:
            for lane in range(LANES):
                slides[own + lane] = 0.0
        else:
            d, b, row = ((MEMORIES + m) * LANES) & PLACE, (bends[m, 0] * LANES) & PLACE, bends[m, 1] & PLACE
            for lane in range(LANES):
                z, rate, pull = x[d + lane], x[b + lane], K[0, b + lane]
                resting = (abs(rate) <= EVENT_WINDOW * abs(pull)) & (pull * z > 0.0)
                goes_on = (rate * z > 0.0) | resting
                slides[own + lane] = z if goes_on & (abs(z) >= 1.0) & (Z[row, lane] < LEAST_PRESLIDING) else 0.0


@njit(**_options)
def keep_sliding(slides, k):  # type: ignore[no-untyped-def]
    """Set the bend rate of sliding bristles in stage ``k`` to zero, whatever the sign of the joint's rate."""
    first = MEMORIES * LANES
    for e in range(len(slides)):
        k[first + e] = 0.0 if slides[e] != 0.0 else k[first + e]


@njit(**_options)
def bound_bends(bends, y, error):  # type: ignore[no-untyped-def]
    """Clip bends to -1..1, and compute their error from the clipped values."""
    for m in range(len(bends)):
        if bends[m, 0] >= 0:
            d = ((MEMORIES + m) * LANES) & PLACE
            for lane in range(LANES):
                kept = max(-1.0, min(1.0, y[d + lane]))
                error[d + lane] = kept - max(-1.0, min(1.0, y[d + lane] - error[d + lane]))
                y[d + lane] = kept


@njit(**_options)
def next_reversal(due, t):  # type: ignore[no-untyped-def]
    """The next time at which a joint is expected to reverse, or ``NEVER``."""
    coming = NEVER
    for e in range(len(due)):
        if due[e] > t + EVENT_WINDOW:
            coming = min(coming, due[e])
    return coming


@njit(**_options)
def first_contact(plays, Z, x, y, K, h):  # type: ignore[no-untyped-def]
    """Time within a step of ``h`` shortly before the first joint with backlash meets its flank; ``h`` if none does.

    The force jumps at the contact, so the state after it cannot be used for interpolation. The time is estimated with a
    parabola, which improves as the step gets shorter; the step is repeated until it ends within ``EVENT_WINDOW`` before
    the contact.
    """
    first = h
    for m in range(len(plays)):
        for lane in range(LANES):
            if plays[m, 0] < 0 or Z[plays[m, 1], lane] <= 0.0:
                continue
            side, before, closing = _clearance(plays, m, lane, Z, x, y, K)
            lag = y[plays[m, 0] * LANES + lane] - Z[plays[m, 2], lane] - y[(MEMORIES + m) * LANES + lane]
            after = side * lag - 0.5 * Z[plays[m, 1], lane]
            if before < 0.0 and after > 0.0:
                bend = after - before - closing * h  # quadratic coefficient of the parabola, times h^2
                root = math.sqrt(max((closing * h) ** 2 - 4.0 * bend * before, 0.0))
                where = -2.0 * before / (closing * h + root) if closing * h + root > 0.0 else 0.5
                # A third of the window before the event, so that its error stays inside.
                first = min(first, max(min(where, 1.0) * h - 0.3 * EVENT_WINDOW, 1e-3 * EVENT_WINDOW))
    return first


@njit(**_options)
def _clearance(plays, m, lane, Z, x, y, K):  # type: ignore[no-untyped-def]
    """The flank (+-1) on whose side the joint is after the step; its distance before (< 0: open) and closing rate."""
    q, d = plays[m, 0] * LANES + lane, (MEMORIES + m) * LANES + lane
    side = 1.0 if y[q] - Z[plays[m, 2], lane] - y[d] > 0.0 else -1.0
    before = side * (x[q] - Z[plays[m, 2], lane] - x[d]) - 0.5 * Z[plays[m, 1], lane]
    return side, before, side * (x[q + MOST_LINKS * LANES] - K[0, d])


@njit(**_options)
def close_contact(plays, m, Z, x, K, meeting):  # type: ignore[no-untyped-def]
    """Move the output side ``m`` to the flank that the joint is about to meet; True if there is one in some lane.

    ``meeting`` (16,) : filled with the time to the contact, s; 0 without contact.
    """
    any_meeting = False
    for lane in range(LANES):
        meeting[lane] = 0.0
        if plays[m, 0] >= 0 and Z[plays[m, 1], lane] > 0.0:
            side, before, closing = _clearance(plays, m, lane, Z, x, x, K)
            if before < 0.0 and -before <= EVENT_WINDOW * closing:
                meeting[lane] = -before / closing
                x[(MEMORIES + m) * LANES + lane] += side * (before - SEATED)
                any_meeting = True
    return any_meeting


@njit(**_options)
def correct_contact(n, x, K, meeting):  # type: ignore[no-untyped-def]
    """Correct the rates for contacts that were applied too early.

    ``K[0]`` : accelerations without, ``K[2]`` : with the force of the flank.
    """
    for lane in range(LANES):
        if meeting[lane] > 0.0:
            _correct_rates(n, lane, -meeting[lane], x, K)
    for e in range(len(x)):
        K[0, e] = K[2, e]
