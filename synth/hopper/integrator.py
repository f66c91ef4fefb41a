"""Bogacki-Shampine 3(2) for sixteen jumps that share one adaptive step, each stopped where its jump is decided.

Coefficients: Bogacki & Shampine, Applied Mathematics Letters 2 (1989) 321-325; the last stage is the next step's
first.
The motion is stiff by its winding, its foot on the ground and its bending links, so the step is set by stability; a
third-order pair has twice the stable step an evaluation that Dormand-Prince 5(4) has (on the imaginary axis 1.73/3
against 1.0/6), and the accuracy wanted is a thousandth of the height.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import float64, int64, njit, types

from synth.hopper.layout import LANES

# How a jump ended.
RUNNING, LANDED_AGAIN, TOO_WEAK, COLLAPSED, TOO_STIFF = 0, 1, 2, 3, 4

# Rows of a lane's outcome.
OUTCOMES = (
    "status", "clearance", "takeoff_time", "takeoff_speed", "takeoff_height", "apex", "peak_gear_torque",
    "peak_current", "energy", "peak_normal", "peak_bend", "end_time", "start_com", "gear_torque_at_start",
)  # fmt: skip
N_OUTCOME = len(OUTCOMES)

SETTLED = 0.05  # s, from which on a leg that neither moves nor is about to is not going to
CREEP = 0.02  # m/s, of the centre of mass: a self-locking gear that folds does so slowly
LIFTED = 1e-3  # m, the foot's height that counts as off the ground
_rhs = types.FunctionType(types.void(float64[:, ::1]))
_signature = int64(
    _rhs, float64[:, ::1], int64[::1], float64, float64, float64, int64, float64, float64[:, ::1], float64[:, ::1]
)
_options: dict[str, Any] = {"fastmath": True, "error_model": "numpy", "nogil": True, "cache": True}


@njit(_signature, **_options)
def jump(rhs, Z, where, duration, tolerance, first_step, max_steps, fall, outcome, trace):  # type: ignore[no-untyped-def]
    """Integrate from the crouch until every lane's jump is decided.

    Parameters
    ----------
    rhs : the compiled right-hand side.
    Z : (n_row, 16) workspace with initial state and parameters.
    where : rows: n_state, derivative, normal, foot, foot_speed, com_speed, com, gear_torque, drawn, bend, alive,
        height, energy.
    duration : s, a lane that has not left the ground by then is too weak.
    tolerance : error a step relative to 1 in metres, radians, and their rates over 30 per second.
    first_step : s; max_steps : accepted and rejected, a group that needs more is too stiff.
    fall : m/s, a flying lane's jump is decided when its centre of mass falls so fast.
    outcome : (14, 16) filled in, rows as ``OUTCOMES``.
    trace : (m, 1 + n_row) lane 0 at every accepted step, time first, as far as there is room; m = 0 for none.

    Returns
    -------
    Number of steps; of traced rows in ``where[13]``.
    """
    n, d = where[0], where[1]
    normal, foot, foot_speed, com_speed, com = where[2], where[3], where[4], where[5], where[6]
    gear, drawn, bend, alive, height, energy = where[7], where[8], where[9], where[10], where[11], where[12]
    n_row = Z.shape[0]
    x = np.empty((n, LANES))
    K = np.empty((4, n, LANES))
    error_sum = np.empty(LANES)
    weight = np.empty(n)
    n_angle = (n - 3) // 2
    for j in range(n):  # heights and angles, their rates, the current (A), the energy (J)
        weight[j] = 1.0 if j <= n_angle else (1.0 / 30.0 if j < n - 2 else (0.3 if j == n - 2 else 0.0))
    for lane in range(LANES):
        Z[alive, lane] = 1.0
        for c in range(N_OUTCOME):
            outcome[c, lane] = 0.0
        for j in range(n):
            x[j, lane] = Z[j, lane]
    rhs(Z)
    for lane in range(LANES):
        outcome[12, lane] = Z[com, lane]
        outcome[13, lane] = Z[gear, lane]
        for j in range(n):
            K[0, j, lane] = Z[d + j, lane]
    t = 0.0
    h = first_step
    steps = 0
    traced = 0
    running = LANES
    if len(trace) > 0:
        trace[0, 0] = 0.0
        for c in range(n_row):
            trace[0, 1 + c] = Z[c, 0]
        traced = 1
    while running > 0:
        for j in range(n):
            for lane in range(LANES):
                Z[j, lane] = x[j, lane] + 0.5 * h * K[0, j, lane]
        rhs(Z)
        for j in range(n):
            for lane in range(LANES):
                K[1, j, lane] = Z[d + j, lane]
                Z[j, lane] = x[j, lane] + 0.75 * h * K[1, j, lane]
        rhs(Z)
        for j in range(n):
            for lane in range(LANES):
                K[2, j, lane] = Z[d + j, lane]
                Z[j, lane] = x[j, lane] + h * (2.0 * K[0, j, lane] + 3.0 * K[1, j, lane] + 4.0 * K[2, j, lane]) / 9.0
        rhs(Z)
        steps += 1
        for lane in range(LANES):
            error_sum[lane] = 0.0
        for j in range(n):
            w = h * weight[j] / tolerance
            for lane in range(LANES):
                K[3, j, lane] = Z[d + j, lane]
                v = -5.0 / 72.0 * K[0, j, lane] + K[1, j, lane] / 12.0 + K[2, j, lane] / 9.0 - K[3, j, lane] / 8.0
                v *= w
                error_sum[lane] += v * v
        error = 1e-30
        for lane in range(LANES):
            error = max(error, error_sum[lane])
        error = math.sqrt(error / n)
        if error <= 1.0:
            t += h
            for j in range(n):
                for lane in range(LANES):
                    x[j, lane] = Z[j, lane]
                    K[0, j, lane] = K[3, j, lane]
            for lane in range(LANES):
                if Z[alive, lane] == 0.0:
                    continue
                at, speed = Z[foot, lane], Z[com_speed, lane]
                outcome[1, lane] = max(outcome[1, lane], at)
                outcome[5, lane] = max(outcome[5, lane], Z[com, lane] - outcome[12, lane])
                outcome[10, lane] = max(outcome[10, lane], abs(Z[bend, lane]))
                outcome[9, lane] = max(outcome[9, lane], Z[normal, lane])
                if at <= 0.0 and outcome[1, lane] < LIFTED:  # the push that takeoff ends
                    outcome[2, lane] = t
                    outcome[3, lane] = speed
                    outcome[4, lane] = Z[com, lane]
                    outcome[8, lane] = x[energy, lane]
                    outcome[6, lane] = max(outcome[6, lane], abs(Z[gear, lane]))
                    outcome[7, lane] = max(outcome[7, lane], abs(Z[drawn, lane]))
                ended = RUNNING
                if outcome[1, lane] > LIFTED and speed < -fall and (Z[foot_speed, lane] < 0.0 or at <= 0.0):
                    ended = LANDED_AGAIN
                elif x[height, lane] <= 0.0 or abs(Z[bend, lane]) > 0.999:
                    ended = COLLAPSED
                elif t >= duration or (
                    t > SETTLED and at <= 0.0 and abs(speed) < CREEP and abs(K[0, 1 + n_angle, lane]) < 0.5
                ):
                    ended = TOO_WEAK  # by now, or standing still: held, or stretched without leaving the ground
                if ended != RUNNING:
                    outcome[0, lane] = ended
                    outcome[11, lane] = t
                    Z[alive, lane] = 0.0
                    running -= 1
                    for j in range(n):
                        K[0, j, lane] = 0.0
            if traced < len(trace):
                trace[traced, 0] = t
                for c in range(n_row):
                    trace[traced, 1 + c] = Z[c, 0]
                traced += 1
            factor = 0.9 * error ** (-1.0 / 3.0)
        else:
            factor = max(0.2, 0.9 * error ** (-1.0 / 3.0))
        if not (factor > 0.2):  # also when the error is not a number
            factor = 0.2
        h = min(h * min(4.0, factor), 4e-3)
        if running > 0 and (h < 1e-10 or steps >= max_steps):
            for lane in range(LANES):
                if Z[alive, lane] != 0.0:
                    outcome[0, lane] = TOO_STIFF
                    outcome[11, lane] = t
            break
    where[13] = traced
    return steps
