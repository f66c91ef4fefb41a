"""Where a joint that dry friction brakes turns back, and where one with play meets its flank: events, lane by lane.

Friction that slides turns over at once when its joint turns back; a bristle left to itself would do so over the way
that it bends, which delays every half swing a little (measured: a swing 25 times the presliding off after ten of them).
So a step ends where a sliding joint's rate passes zero, and the bend is put where the joint stays at rest, or, where
not even the whole torque holds it, to sliding the other way. Between such moments the motion is smooth: friction
keeps its sense through a step, also in those stages that lie beyond the turn at which the step is then cut.

A presliding that is meant, as of gears, stays where the joint turns back: all of it from ``LEAST_GIVE`` on, with which
every bristle holds, and of less than that a share in proportion.

Where a joint with play meets a flank, the damper behind it makes the force jump: there, too, a step ends.

Lanes that turn, or meet, within ``AT_ONCE`` of the step's end do so there together, each corrected to first order for
the time by which it is late (the saltation of hybrid systems: Leine & Nijmeijer, *Dynamics and Bifurcations of
Non-Smooth Mechanical Systems*, 2004, ch. 7). Perturbed copies of one leg so stay smooth functions of what is perturbed.

Arrays are flat, 16 lanes a state: ``x`` the state at a step's start, ``y`` at its end, ``K`` (7, n_state * 16) the
derivatives. ``bends`` (n_state, 2): for a bristle, the state whose rate bends it and its presliding's row in the
workspace ``Z``, else -1. States from 2 n on are memories, for which ``slides`` and ``due`` have 16 entries each.
``plays`` (n_state, 3): for an output side behind play, the joint, and the rows of the gap and of the spring's rest,
else -1.
"""

from __future__ import annotations

import math
from typing import Any

from numba import njit

from synth.compiling.numba_internals import UNCOUNTED
from synth.swing.effects.inlined import LEAST_GIVE, bend_that_holds, held
from synth.swing.lane_layout import LANES, MOST_LINKS

AT_ONCE = 1e-5  # s
NEVER = 1e300  # s, no event in sight
SEATED = 1e-9  # rad beyond the flank, which rounding does not undo
PLACE = (1 << 48) - 1  # masked by it, an index cannot be negative: none is counted from the end, which costs a gather
_options: dict[str, Any] = {"fastmath": True, "error_model": "numpy", "nogil": True, **UNCOUNTED}


@njit(**_options)
def _give(bends, j, lane, Z):  # type: ignore[no-untyped-def]
    """How much of the give with which bristle ``j`` holds it also has where it turns back: 0 none, 1 all of it."""
    return min(Z[bends[j, 1], lane] / LEAST_GIVE, 1.0)


@njit(**_options)
def slide_from_start(n, bends, Z, x, K):  # type: ignore[no-untyped-def]
    """Bend each bristle as if its joint had slid as it moves, or into where it is pushed if it rests.

    One that rests then counts as turning back, which finds whether it is held. One that gives as much where it turns
    as where it holds is straight instead.
    """
    for j in range(2 * (n & MOST_LINKS), len(bends)):
        if bends[j, 0] >= 0:
            for lane in range(LANES):
                rate, pull = x[bends[j, 0] * LANES + lane], K[0, bends[j, 0] * LANES + lane]
                if rate == 0.0 and _give(bends, j, lane, Z) >= 1.0:
                    x[j * LANES + lane] = 0.0
                else:
                    x[j * LANES + lane] = 1.0 if rate > 0.0 or (rate == 0.0 and pull < 0.0) else -1.0


@njit(**_options)
def turn_back(bends, j, started, Z, x, K, turning, target):  # type: ignore[no-untyped-def]
    """Fill ``turning`` (16,) with the sense in which bristle ``j`` slid where its joint turns back now, 0 elsewhere.

    ``target`` (16,): its bend where even its whole torque does not hold the joint. Without any give it slides the other
    way at once, else it has still to bend there; not ``started``, it had been straight. Both are left as they are where
    no lane turns back, which is soon seen.
    """
    m, b, give_row = (j * LANES) & PLACE, (bends[j, 0] * LANES) & PLACE, bends[j, 1] & PLACE
    count = 0.0
    for lane in range(LANES):
        z, rate, pull = x[m + lane], x[b + lane], K[0, b + lane]
        near = (abs(rate) <= AT_ONCE * abs(pull)) & (pull * z < 0.0)
        count += 1.0 if near & (abs(z) >= 1.0) & (Z[give_row, lane] < LEAST_GIVE) else 0.0
    if count == 0.0:
        return False
    for lane in range(LANES):
        z, rate, pull = x[m + lane], x[b + lane], K[0, b + lane]
        give = _give(bends, j, lane, Z)
        back = give < 1.0 and abs(z) >= 1.0 and pull * z < 0.0 and abs(rate) <= AT_ONCE * abs(pull)
        turning[lane] = z if back else 0.0
        target[lane] = z * (2.0 * give - 1.0) if started else z * (give - 1.0)
    return True


@njit(**_options)
def take_hold(bends, j, x, K, turning, target):  # type: ignore[no-untyped-def]
    """Put the bend where the joint's acceleration is zero, or to the ``target``.

    The acceleration is linear in the share of its torque that a bristle gives; ``K[0]`` has it with the share as it
    was, ``K[1]`` with the target's.
    """
    for lane in range(LANES):
        if turning[lane] != 0.0:
            e = bends[j, 0] * LANES + lane
            if K[1, e] * turning[lane] <= 0.0:
                x[j * LANES + lane] = target[lane]
            else:
                share = turning[lane] + (held(target[lane], 0.0) - turning[lane]) * K[0, e] / (K[0, e] - K[1, e])
                x[j * LANES + lane] = bend_that_holds(share)


@njit(**_options)
def make_up(n, bends, j, x, K, turning):  # type: ignore[no-untyped-def]
    """Correct the rates for the time since the turn, in which friction had the wrong sense: ``K[0]`` where ``K[2]``."""
    for lane in range(LANES):
        if turning[lane] != 0.0:
            late = x[bends[j, 0] * LANES + lane] / K[0, bends[j, 0] * LANES + lane]
            _as_if_at_once(n, lane, late, x, K)
    for e in range(len(x)):
        K[0, e] = K[2, e]


@njit(**_options)
def _as_if_at_once(n, lane, late, x, K):  # type: ignore[no-untyped-def]
    """Correct one lane's rates for an event that was ``late`` s ago, by the accelerations before and after it."""
    for i in range(n, 2 * n):
        e = i * LANES + lane
        x[e] += (K[2, e] - K[0, e]) * late
        K[2, e - n * LANES] = x[e]


@njit(**_options)
def find_sliding(n, bends, Z, x, K, slides):  # type: ignore[no-untyped-def]
    """Fill ``slides`` with the sense in which each bristle slides through the coming step, 0 where it bends."""
    for j in range(2 * (n & MOST_LINKS), len(bends)):
        own = ((j - 2 * n) * LANES) & PLACE
        if bends[j, 0] < 0:
            for lane in range(LANES):
                slides[own + lane] = 0.0
        else:
            m, b, give_row = (j * LANES) & PLACE, (bends[j, 0] * LANES) & PLACE, bends[j, 1] & PLACE
            for lane in range(LANES):
                z, rate, pull = x[m + lane], x[b + lane], K[0, b + lane]
                resting = (abs(rate) <= AT_ONCE * abs(pull)) & (pull * z > 0.0)
                goes_on = (rate * z > 0.0) | resting
                slides[own + lane] = z if goes_on & (abs(z) >= 1.0) & (Z[give_row, lane] < LEAST_GIVE) else 0.0


@njit(**_options)
def keep_sliding(n, slides, k):  # type: ignore[no-untyped-def]
    """What slides does not bend, in whatever sense the rate of the stage ``k`` is."""
    first = 2 * (n & MOST_LINKS) * LANES
    for e in range(len(slides)):
        k[first + e] = 0.0 if slides[e] != 0.0 else k[first + e]


@njit(**_options)
def bound_bends(n, bends, y, error):  # type: ignore[no-untyped-def]
    """Put bends beyond -1..1 back there, and count their error from there."""
    for j in range(2 * (n & MOST_LINKS), len(bends)):
        if bends[j, 0] >= 0:
            m = (j * LANES) & PLACE
            for lane in range(LANES):
                kept = max(-1.0, min(1.0, y[m + lane]))
                error[m + lane] = kept - max(-1.0, min(1.0, y[m + lane] - error[m + lane]))
                y[m + lane] = kept


@njit(**_options)
def first_turn(n, bends, slides, Z, x, y, K, t, h, due):  # type: ignore[no-untyped-def]
    """Where in the step from ``t`` to ``t + h`` the first joint turns back against its sliding bristle.

    ``h`` if none does before the step's end, give or take ``AT_ONCE``; ``due`` is filled with the moments of all.
    """
    first = h
    for j in range(2 * (n & MOST_LINKS), len(bends)):
        own = ((j - 2 * n) * LANES) & PLACE
        for lane in range(LANES):
            due[own + lane] = NEVER
        if bends[j, 0] < 0:
            continue
        # Most steps end with no joint near a turn: one look at all lanes at once tells.
        b, give_row = (bends[j, 0] * LANES) & PLACE, bends[j, 1] & PLACE
        count = 0.0
        for lane in range(LANES):
            before, after, sliding = x[b + lane], y[b + lane], slides[own + lane]
            sense = sliding if sliding != 0.0 else before
            near = (after * sense <= 0.0) | (abs(after) <= AT_ONCE * abs(K[6, b + lane]))
            count += 1.0 if near & (Z[give_row, lane] < LEAST_GIVE) else 0.0
        if count == 0.0:
            continue
        for lane in range(LANES):
            if _give(bends, j, lane, Z) >= 1.0:
                continue
            d, e = (j * LANES & PLACE) + lane, b + lane
            before, after, sense = x[e], y[e], slides[own + lane]
            slid = sense != 0.0
            if not slid:  # it bends, but may come to slide within the step and turn back after that
                sense = 1.0 if before > 0.0 else -1.0
                slid = 0.7 * abs(K[0, d]) * h * abs(before) > (1.0 - x[d] * sense) * abs(before - after)
            if abs(after) <= AT_ONCE * abs(K[6, e]):
                if y[d] * sense > 0.999:  # turns at the step's end; what it has bent back by then is made up for
                    y[d] = sense
            elif after * sense < 0.0 and slid:
                where = _zero(before, after, h * K[0, e], h * K[6, e], sense)
                due[own + lane] = t + where * h
                first = min(first, max(where * h, 1e-3 * AT_ONCE))
    return first


@njit(**_options)
def _zero(before, after, slope_before, slope_after, sense):  # type: ignore[no-untyped-def]
    """Zero in 0..1 of the cubic with these ends and slopes, positive times ``sense`` before it: Newton, kept inside."""
    low, high = 0.0, 1.0
    where = before / (before - after)
    for _ in range(6):
        if not (low < where < high):
            where = 0.5 * (low + high)
        u = 1.0 - where
        value = u * u * ((1.0 + 2.0 * where) * before + where * slope_before)
        value += where * where * ((3.0 - 2.0 * where) * after - u * slope_after)
        if value * sense > 0.0:
            low = where
        else:
            high = where
        slope = 6.0 * where * u * (after - before) + u * (1.0 - 3.0 * where) * slope_before
        slope += where * (3.0 * where - 2.0) * slope_after
        where -= value / slope
    return where if low < where < high else 0.5 * (low + high)


@njit(**_options)
def next_due(due, t):  # type: ignore[no-untyped-def]
    """The next moment at which a joint is expected to turn back, or ``NEVER``."""
    coming = NEVER
    for e in range(len(due)):
        if due[e] > t + AT_ONCE:
            coming = min(coming, due[e])
    return coming


@njit(**_options)
def first_contact(n, plays, Z, x, y, K, h):  # type: ignore[no-untyped-def]
    """Where in a step of ``h`` to stop, shortly before the first joint with play meets its flank; ``h`` if none does.

    The force there jumps, and what the step tells of the time after it is no good: the estimate, a parabola, gets
    better as the step gets shorter, and is repeated until the end lies within ``AT_ONCE`` before the contact.
    """
    first = h
    for j in range(2 * (n & MOST_LINKS), len(plays)):
        for lane in range(LANES):
            if plays[j, 0] < 0 or Z[plays[j, 1], lane] <= 0.0:
                continue
            side, before, closing = _clearance(n, plays, j, lane, Z, x, y, K)
            lag = y[plays[j, 0] * LANES + lane] - Z[plays[j, 2], lane] - y[j * LANES + lane]
            after = side * lag - 0.5 * Z[plays[j, 1], lane]
            if before < 0.0 and after > 0.0:
                bend = after - before - closing * h  # of the parabola, times h^2
                root = math.sqrt(max((closing * h) ** 2 - 4.0 * bend * before, 0.0))
                where = -2.0 * before / (closing * h + root) if closing * h + root > 0.0 else 0.5
                first = min(first, max(min(where, 1.0) * h - 0.3 * AT_ONCE, 1e-3 * AT_ONCE))
    return first


@njit(**_options)
def _clearance(n, plays, j, lane, Z, x, y, K):  # type: ignore[no-untyped-def]
    """The flank (+-1) towards which the joint is after the step, its distance (< 0 when apart) before, and its rate."""
    q, d = plays[j, 0] * LANES + lane, j * LANES + lane
    side = 1.0 if y[q] - Z[plays[j, 2], lane] - y[d] > 0.0 else -1.0
    before = side * (x[q] - Z[plays[j, 2], lane] - x[d]) - 0.5 * Z[plays[j, 1], lane]
    return side, before, side * (x[q + n * LANES] - K[0, d])


@njit(**_options)
def meet(n, plays, j, Z, x, K, meeting):  # type: ignore[no-untyped-def]
    """Bring the output side ``j`` to the flank that the joint is about to meet, in ``meeting`` (16,) s, 0 for not."""
    any_meeting = False
    for lane in range(LANES):
        meeting[lane] = 0.0
        if plays[j, 0] >= 0 and Z[plays[j, 1], lane] > 0.0:
            side, before, closing = _clearance(n, plays, j, lane, Z, x, x, K)
            if before < 0.0 and -before <= AT_ONCE * closing:
                meeting[lane] = -before / closing
                x[j * LANES + lane] += side * (before - SEATED)
                any_meeting = True
    return any_meeting


@njit(**_options)
def make_up_contact(n, x, K, meeting):  # type: ignore[no-untyped-def]
    """Correct the rates for contacts that were made too early: ``K[0]`` without, ``K[2]`` with the flank's force."""
    for lane in range(LANES):
        if meeting[lane] > 0.0:
            _as_if_at_once(n, lane, -meeting[lane], x, K)
    for e in range(len(x)):
        K[0, e] = K[2, e]
