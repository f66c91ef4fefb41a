"""Bogacki-Shampine 3(2) for sixteen jumps with a common adaptive step; each lane stops when its outcome is known.

The motion is stiff because of winding, ground contact and bending links, so stability limits the step. A
third-order pair has twice the stable step per evaluation of Dormand-Prince 5(4) (on the imaginary axis 1.73/3
against 1.0/6), and the required accuracy is only a thousandth of the height.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import float64, int64, njit, types

from synth.compiling.compiled import compiled
from synth.jump.jump_layout import LANES
from synth.jump.jump_step import ROOM, compiled_step
from synth.jump.outcomes import (
    APEX,
    CLEARANCE,
    COLLAPSED,
    CREEP,
    CROSSED,
    END_TIME,
    ENERGY,
    GEAR_TORQUE_AT_START,
    LANDED_AGAIN,
    LEAST_SPREAD,
    LEVEL,
    LIFTED,
    N_OUTCOME,
    PEAK_CURRENT,
    PEAK_GEAR_TORQUE,
    PEAK_NORMAL,
    RUNNING,
    SETTLED,
    START_COM,
    STATUS,
    TAKEOFF_HEIGHT,
    TAKEOFF_SPEED,
    TAKEOFF_TIME,
    TOO_STIFF,
    TOO_WEAK,
)  # fmt: skip

LONGEST = 4e-3  # s, of a step, so that a landing is not stepped over
_rhs = types.FunctionType(types.void(float64[:, ::1]))
_signature = int64(
    _rhs,
    float64[:, ::1],
    int64[::1],
    float64,
    float64,
    float64,
    float64,
    int64,
    float64,
    float64[:, ::1],
    float64[:, ::1],
)
_rules: dict[str, Any] = {"fastmath": True, "error_model": "numpy", "nogil": True}
views, try_step, take = compiled_step(_rules)
PARTS = 8  # of the step in which a torque peaks: the peak is then 64 times nearer than at the steps alone


@njit(**_rules)
def crest(before, middle, after, h, next_h):  # type: ignore[no-untyped-def]
    """Greatest size near a sample and its time from it, by the parabola through it and its neighbours.

    ``h`` s before and ``next_h`` s after it. Where the sample is not the greatest of the three: 0, as no peak is there.
    """
    sign = 1.0 if middle >= 0.0 else -1.0
    rise, fall = sign * (middle - before) / h, sign * (middle - after) / next_h  # slopes to and from it
    if rise < 0.0 or fall < 0.0 or rise + fall <= 0.0:
        return 0.0, 0.0
    slope = (rise * next_h - fall * h) / (h + next_h)  # of the parabola at the middle sample
    ahead = 0.5 * slope * (h + next_h) / (rise + fall)
    return abs(middle) + 0.5 * slope * ahead, ahead


@njit(**_rules)
def keep(ends, lane, old, new, span, h, share):  # type: ignore[no-untyped-def]
    """Keep in ``ends`` (2, 2, n, 16) the step of ``h`` s from ``old`` to ``new`` (2, n, 16); a share of it counts."""
    for c in range(2):
        for j in range(ends.shape[2]):
            ends[0, c, j, lane], ends[1, c, j, lane] = old[c, j, lane], new[c, j, lane]
    span[0, lane], span[1, lane] = h, share


@njit(**_rules)
def peaks_within(rhs, Z, ends, span, row, out):  # type: ignore[no-untyped-def]
    """Raise each lane's ``out`` (16,) to the greatest size of a row of ``Z`` within its kept step.

    The states between are the cubic through both ends and their derivatives, of the pair's own order.
    """
    for k in range(1, PARTS + 1):
        for lane in range(LANES):
            h, s = span[0, lane], span[1, lane] * k / PARTS
            a, b = s * s * (3.0 - 2.0 * s), s * (1.0 - s)
            for j in range(ends.shape[2]):
                moved = ends[0, 0, j, lane] + a * (ends[1, 0, j, lane] - ends[0, 0, j, lane])
                slopes = (1.0 - s) * ends[0, 1, j, lane] - s * ends[1, 1, j, lane]
                Z[j, lane] = moved + h * b * slopes
        rhs(Z)
        for lane in range(LANES):
            if span[0, lane] > 0.0:
                out[lane] = max(out[lane], abs(Z[row, lane]))


@compiled(_signature, **_rules)
def jump(rhs, Z, where, duration, longest, tolerance, first_step, max_steps, fall, outcome, trace):  # type: ignore[no-untyped-def]
    """Integrate from the crouch until every lane's outcome is known.

    Parameters
    ----------
    rhs : the compiled right-hand side.
    Z : (n_row, 16) workspace with initial state and parameters.
    where : rows: n_state, derivative, normal, foot, foot_speed, com_speed, com, gear_torque, drawn, bend, alive,
        height, energy.
    duration : s; a lane on the ground then or later is too weak if it has not lifted.
    longest : s; every lane ends then, also in flight, as too weak.
    tolerance : error per step relative to 1 in metres, radians, and their rates over 30 per second.
    first_step : s; max_steps : accepted and rejected; a group that needs more is too stiff.
    fall : m/s; a flying lane's outcome is known once its centre of mass falls so fast.
    outcome : (n_outcome, 16) filled in, rows as ``outcomes.OUTCOMES``.
    trace : (m, 1 + n_row) lane 0 at every accepted step, time first, as far as it fits; m = 0 for none.

    Returns
    -------
    Number of steps; of traced rows in ``where[13]``.
    """
    n, d = where[0], where[1]
    normal, foot, foot_speed, com_speed, com = where[2], where[3], where[4], where[5], where[6]
    gear, drawn, bend, alive, height, energy = where[7], where[8], where[9], where[10], where[11], where[12]
    n_row = Z.shape[0]
    F, S = Z.reshape(-1), np.empty(ROOM)
    foot_before = np.empty(LANES)
    # State and derivative at the ends of the last two steps, and the gear torque at the earlier two of these.
    recent, torques = np.empty((3, 2, n, LANES)), np.empty((2, LANES))
    # Of each lane the step in which the torque of its push seems greatest: ends, length and share, and that torque;
    # first until the foot first lifts, and of later contacts before takeoff, then of contacts that do not count yet.
    ends, span, greatest = np.zeros((2, 2, 2, n, LANES)), np.zeros((2, 2, LANES)), np.zeros((2, LANES))
    # Of each lane's last contact: time, speed and height of the centre of mass, energy; whether it has not counted yet.
    lift, on_ground = np.zeros((4, LANES)), np.zeros(LANES, dtype=np.bool_)
    # Of each lane the peaks of torque and current since the foot first lifted: until now, and until its last contact.
    since, until = np.zeros((2, LANES)), np.zeros((2, LANES))
    # Of each lane the greatest rise until now, and whether it is in the flight to or after the foot's greatest height.
    risen, aloft = np.zeros(LANES), np.zeros(LANES, dtype=np.bool_)
    x, begun, _, A, error_sum = views(S, n)
    n_angle = (n - 3) // 2
    for lane in range(LANES):
        Z[alive, lane] = 1.0
        for c in range(N_OUTCOME):
            outcome[c, lane] = 0.0
    rhs(Z)
    for lane in range(LANES):
        outcome[START_COM, lane] = Z[com, lane]
        outcome[GEAR_TORQUE_AT_START, lane], outcome[LEAST_SPREAD, lane] = Z[gear, lane], -Z[bend, lane]
        foot_before[lane] = Z[foot, lane]
        torques[0, lane], torques[1, lane] = 1e300, Z[gear, lane]  # so that the start is no peak between two steps
    take(F, S, n, d)
    oldest, before_last, newest = 0, 1, 2
    for j in range(n):
        for lane in range(LANES):
            recent[newest, 0, j, lane] = x[j, lane]
            recent[newest, 1, j, lane] = begun[j, lane]
    t = 0.0
    h = last_h = first_step
    steps = 0
    traced = 0
    running = LANES
    if len(trace) > 0:
        trace[0, 0] = 0.0
        for c in range(n_row):
            trace[0, 1 + c] = Z[c, 0]
        traced = 1
    while running > 0:
        try_step(rhs, Z, F, S, n, d, h, tolerance)
        steps += 1
        error = 1e-30
        for lane in range(LANES):
            error = max(error, error_sum[lane])
        error = math.sqrt(error / n)
        if error <= 1.0:
            t += h
            take(F, S, n, d)
            oldest, before_last, newest = before_last, newest, oldest
            for j in range(n):
                for lane in range(LANES):
                    recent[newest, 0, j, lane] = x[j, lane]
                    recent[newest, 1, j, lane] = begun[j, lane]
            for lane in range(LANES):
                if Z[alive, lane] == 0.0:
                    continue
                at, speed = Z[foot, lane], Z[com_speed, lane]
                before, highest = foot_before[lane], outcome[CLEARANCE, lane]
                pushing = highest < LIFTED
                which = 0 if pushing else 1
                foot_before[lane] = at
                outcome[CLEARANCE, lane] = max(highest, at)
                risen[lane] = max(risen[lane], Z[com, lane] - outcome[START_COM, lane])
                aloft[lane] = pushing or at > highest or (aloft[lane] and at > 0.0)
                if aloft[lane]:  # a leg that landed may still stand up higher than it jumped
                    outcome[APEX, lane] = risen[lane]
                outcome[LEAST_SPREAD, lane] = min(outcome[LEAST_SPREAD, lane], -Z[bend, lane])
                outcome[PEAK_NORMAL, lane] = max(outcome[PEAK_NORMAL, lane], Z[normal, lane])
                if at <= 0.0 or before <= 0.0:  # to the foot's passage through the ground, within a step
                    share = 1.0 if at <= 0.0 else before / (before - at)
                    lift[0, lane], on_ground[lane] = t - (1.0 - share) * h, True
                    for k, now in ((1, speed), (2, Z[com, lane]), (3, x[energy, lane])):
                        lift[k, lane] += share * (now - lift[k, lane])
                    if share < 1.0:
                        left = abs(torques[1, lane] + share * (Z[gear, lane] - torques[1, lane]))
                        if left > greatest[which, lane]:
                            greatest[which, lane] = left
                            keep(ends[which], lane, recent[before_last], recent[newest], span[which], h, share)
                if not pushing:
                    since[0, lane] = max(since[0, lane], abs(Z[gear, lane]))
                    since[1, lane] = max(since[1, lane], abs(Z[drawn, lane]))
                    if at <= 0.0:
                        until[0, lane], until[1, lane] = since[0, lane], since[1, lane]
                if on_ground[lane] and (pushing or at > highest):  # of contacts, the last before the greatest height
                    on_ground[lane] = False
                    for k, c in ((0, PEAK_GEAR_TORQUE), (1, PEAK_CURRENT)):
                        outcome[c, lane] = max(outcome[c, lane], until[k, lane])
                    if not pushing and greatest[1, lane] > greatest[0, lane]:
                        greatest[0, lane] = greatest[1, lane]
                        keep(ends[0], lane, ends[1, 0], ends[1, 1], span[0], span[1, 0, lane], span[1, 1, lane])
                    for k, c in ((0, TAKEOFF_TIME), (1, TAKEOFF_SPEED), (2, TAKEOFF_HEIGHT), (3, ENERGY)):
                        outcome[c, lane] = lift[k, lane]
                first, middle, now = torques[0, lane], torques[1, lane], Z[gear, lane]
                torques[0, lane], torques[1, lane] = middle, now
                if before <= 0.0 and abs(middle) >= abs(first) and abs(middle) >= abs(now):
                    top, ahead = crest(first, middle, now, last_h, h)
                    if top > greatest[which, lane]:
                        greatest[which, lane] = top
                        if ahead < 0.0:
                            keep(ends[which], lane, recent[oldest], recent[before_last], span[which], last_h, 1.0)
                        else:
                            keep(ends[which], lane, recent[before_last], recent[newest], span[which], h, 1.0)
                if at <= 0.0 and pushing:  # until the foot first lifts; after that ``until``
                    outcome[PEAK_GEAR_TORQUE, lane] = max(outcome[PEAK_GEAR_TORQUE, lane], abs(Z[gear, lane]))
                    outcome[PEAK_CURRENT, lane] = max(outcome[PEAK_CURRENT, lane], abs(Z[drawn, lane]))
                ended = RUNNING
                if outcome[CLEARANCE, lane] > LIFTED and speed < -fall and (Z[foot_speed, lane] < 0.0 or at <= 0.0):
                    ended = LANDED_AGAIN
                elif t >= duration and at <= 0.0 and outcome[CLEARANCE, lane] > LIFTED:
                    ended = LANDED_AGAIN  # and stands, without ever having fallen so fast
                elif x[height, lane] <= 0.0 or abs(Z[bend, lane]) > LEVEL:
                    ended = COLLAPSED
                elif (
                    (t >= duration and at <= 0.0)
                    or t >= longest
                    or (
                        pushing
                        and t > SETTLED
                        and at <= 0.0
                        and abs(speed) < CREEP
                        and abs(begun[1 + n_angle, lane]) < 0.5
                    )
                ):
                    ended = TOO_WEAK  # by now, or at rest: held, or stretched without lifting off
                if ended == LANDED_AGAIN and outcome[LEAST_SPREAD, lane] < 0.0:
                    ended = CROSSED
                if ended != RUNNING:
                    outcome[STATUS, lane] = ended
                    outcome[END_TIME, lane] = t
                    Z[alive, lane] = 0.0
                    running -= 1
                    for j in range(n):
                        begun[j, lane] = 0.0
                    for j in range(n_angle):
                        A[j, lane] = 0.0
            if traced < len(trace):
                trace[traced, 0] = t
                for c in range(n_row):
                    trace[traced, 1 + c] = Z[c, 0]
                traced += 1
            last_h = h
            factor = 0.9 * error ** (-1.0 / 3.0)
        else:
            # Safety 0.9 and at most a fifth: Hairer et al., Solving ODEs I, section II.4.
            factor = max(0.2, 0.9 * error ** (-1.0 / 3.0))
        if not (factor > 0.2):  # also if the error is nan
            factor = 0.2
        h = min(h * min(4.0, factor), LONGEST)
        if running > 0 and (h < 1e-10 or steps >= max_steps):
            for lane in range(LANES):
                if Z[alive, lane] != 0.0:
                    outcome[STATUS, lane] = TOO_STIFF
                    outcome[END_TIME, lane] = t
            break
    peaks_within(rhs, Z, ends[0], span[0], gear, outcome[PEAK_GEAR_TORQUE])
    where[13] = traced
    return steps
