"""Dormand-Prince 5(4) with dense output for sixteen trajectories that share one adaptive step.

Coefficients, error control and dense output: Hairer, Norsett & Wanner, *Solving Ordinary Differential Equations
I*, 2nd ed. 1993, tables 5.2 and section II.6 (``dopri5``); step control with their PI controller (beta = 0.04).
The right-hand side comes in as a function value, so this file compiles once for all chains.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import float64, int64, njit, types

from synth.model.layout import LANES, Layout

_A = np.zeros((7, 6))
_A[1, :1] = [1 / 5]
_A[2, :2] = [3 / 40, 9 / 40]
_A[3, :3] = [44 / 45, -56 / 15, 32 / 9]
_A[4, :4] = [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729]
_A[5, :5] = [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656]
_A[6] = [35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84]
_C = np.array([0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0])
_E = np.array([71 / 57600, 0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40])
_D = np.array(
    [
        -12715105075 / 11282082432,
        0,
        87487479700 / 32700410799,
        -10690763975 / 1880347072,
        701980252875 / 199316789632,
        -1453857185 / 822651844,
        69997945 / 29380423,
    ]
)

_TORQUE = Layout(1).row("extra_torque")
REACHED_END, TOO_MANY_STEPS, STEP_TOO_SMALL = 0, 1, 2

_chain = types.FunctionType(types.void(float64[:, ::1]))
_extra = types.FunctionType(types.void(float64[:, ::1], int64, int64[::1]))
_bearing = types.FunctionType(types.void(float64[:, ::1], int64))
_known = types.Tuple((float64[::1], float64[:, ::1]))
_state = types.Tuple((int64[::1], int64[::1], float64[::1], float64[::1]))
_signature = types.UniTuple(int64, 2)(
    _chain, _extra, _bearing, float64[:, ::1], int64, _state, int64[:, ::1], _known, float64[::1], float64[::1],
    float64, int64, float64[:, :, ::1],
)  # fmt: skip
_options: dict[str, Any] = {"fastmath": True, "error_model": "numpy", "nogil": True, "cache": True}


@njit(inline="always", **_options)
def _known_torque(Z, n, any_active, known, t, cursor):  # type: ignore[no-untyped-def]
    """Add a known torque, linear between its samples and the same in every lane; returns the new cursor."""
    times, torques = known
    if len(times) > 1:
        while cursor < len(times) - 2 and times[cursor + 1] < t:
            cursor += 1
        while cursor > 0 and times[cursor] > t:
            cursor -= 1
        share = (t - times[cursor]) / (times[cursor + 1] - times[cursor])
        for j in range(n):
            torque = torques[cursor, j] + share * (torques[cursor + 1, j] - torques[cursor, j])
            for lane in range(LANES):
                before = Z[_TORQUE + j, lane] if any_active else 0.0
                Z[_TORQUE + j, lane] = before + torque
    return cursor


@njit(inline="always", **_options)
def _derivative(chain, extra, bearing, Z, n, derivative, active, modes, known, t, cursor, K):  # type: ignore[no-untyped-def]
    """Fill K (n_state, 16) with the time derivative of the state that lies in Z.

    Friction that grows with the bearing force needs the accelerations that it changes itself: these are found without
    it first. What that leaves out is second order in the friction coefficient.
    """
    any_active, any_load = modes
    if any_active:
        extra(Z, n, active[0])
    cursor = _known_torque(Z, n, any_active, known, t, cursor)
    chain(Z)
    if any_load:
        bearing(Z, n)
        extra(Z, n, active[1])
        cursor = _known_torque(Z, n, any_active, known, t, cursor)
        chain(Z)
    for j in range(len(derivative)):
        for lane in range(LANES):
            K[j, lane] = Z[derivative[j], lane]
    return cursor


@njit(_signature, **_options)
def integrate(chain, extra, bearing, Z, n, states, active, known, times, tolerance, first_step, max_steps, out):  # type: ignore[no-untyped-def]
    """Integrate from ``times[0]`` and write the state at ``times`` into ``out``.

    Parameters
    ----------
    chain, extra, bearing : the compiled right-hand side, the extra torques and the bearing forces.
    Z : (n_row, 16) workspace with initial state and parameters filled in; its state rows are overwritten.
    states : rows of the state, rows of its derivative, and each one's factor (n_state,) on the tolerance and bound:
        a state beyond its bound counts as at it, and is put there after each step (a bristle that slides).
    active : (2, 1 + n_law) which extra torques are on; all zero skips them. First without, then with those that need
        the bearing force; equal where none does.
    known : times (m,) s and torques (m, n) N m that act on q; m = 0 for none.
    times : (n_time,) s, increasing.
    tolerance : (2,) relative, absolute (rad and rad/s); first_step : s; max_steps : accepted and rejected.
    out : (n_time, rows, 16), the first ``rows`` of the state.

    Returns
    -------
    steps, reason : number of steps, and why it stopped. On any other reason than ``REACHED_END`` the rest is nan.
    """
    state, derivative, factors, bounds = states
    size = len(state)
    rows = out.shape[1]
    x = np.empty((size, LANES))
    K = np.empty((7, size, LANES))
    r = np.empty((4, rows, LANES))
    error_sum = np.empty(LANES)
    any_active, any_load = False, False
    for index in range(active.shape[1]):
        any_active = any_active or active[0, index] != 0 or active[1, index] != 0
        any_load = any_load or active[0, index] != active[1, index]
    modes = (any_active, any_load)
    for j in range(n):
        for lane in range(LANES):
            Z[_TORQUE + j, lane] = 0.0
    for j in range(size):
        for lane in range(LANES):
            x[j, lane] = Z[state[j], lane]
    for j in range(rows):
        for lane in range(LANES):
            out[0, j, lane] = x[j, lane]
    t = times[0]
    end = times[-1]
    h = min(first_step, end - t)
    i = 1
    previous = 1e-4
    steps = 0
    reason = REACHED_END
    cursor = _derivative(chain, extra, bearing, Z, n, derivative, active, modes, known, t, 0, K[0])
    while i < len(times):
        if t + h > end:
            h = end - t + 1e-15
        for s in range(1, 7):
            for j in range(size):
                c = h * _A[s, 0]
                row = state[j]
                for lane in range(LANES):
                    Z[row, lane] = x[j, lane] + c * K[0, j, lane]
                for m in range(1, s):
                    c = h * _A[s, m]
                    for lane in range(LANES):
                        Z[row, lane] += c * K[m, j, lane]
            now = t + _C[s] * h
            cursor = _derivative(chain, extra, bearing, Z, n, derivative, active, modes, known, now, cursor, K[s])
        steps += 1
        for lane in range(LANES):
            error_sum[lane] = 0.0
        for j in range(size):
            for lane in range(LANES):
                v = _E[0] * K[0, j, lane] + _E[2] * K[2, j, lane] + _E[3] * K[3, j, lane]
                v += _E[4] * K[4, j, lane] + _E[5] * K[5, j, lane] + _E[6] * K[6, j, lane]
                v = h * v
                if bounds[j] < 1e299:
                    reached = Z[state[j], lane]
                    v = max(-bounds[j], min(bounds[j], reached)) - max(-bounds[j], min(bounds[j], reached - v))
                v = v / (factors[j] * (tolerance[1] + tolerance[0] * max(abs(x[j, lane]), abs(Z[state[j], lane]))))
                error_sum[lane] += v * v
        error = 1e-30
        for lane in range(LANES):
            error = max(error, error_sum[lane])
        error = math.sqrt(error / size)
        if error <= 1.0:
            if times[i] <= t + h + 1e-12:
                for c in range(rows):
                    for lane in range(LANES):
                        dy = Z[state[c], lane] - x[c, lane]
                        bs = h * K[0, c, lane] - dy
                        r[0, c, lane] = dy
                        r[1, c, lane] = bs
                        r[2, c, lane] = dy - h * K[6, c, lane] - bs
                        v = _D[0] * K[0, c, lane] + _D[2] * K[2, c, lane] + _D[3] * K[3, c, lane]
                        v += _D[4] * K[4, c, lane] + _D[5] * K[5, c, lane] + _D[6] * K[6, c, lane]
                        r[3, c, lane] = h * v
                while i < len(times) and times[i] <= t + h + 1e-12:
                    p = (times[i] - t) / h
                    u = 1.0 - p
                    for c in range(rows):
                        for lane in range(LANES):
                            tail = r[1, c, lane] + p * (r[2, c, lane] + u * r[3, c, lane])
                            out[i, c, lane] = x[c, lane] + p * (r[0, c, lane] + u * tail)
                    i += 1
            t += h
            for j in range(size):
                for lane in range(LANES):
                    x[j, lane] = Z[state[j], lane]
                if bounds[j] < 1e299:
                    for lane in range(LANES):
                        x[j, lane] = max(-bounds[j], min(bounds[j], x[j, lane]))
                for lane in range(LANES):
                    K[0, j, lane] = K[6, j, lane]
            factor = 0.9 * error**-0.17 * previous**0.04
            previous = max(error, 1e-4)
        else:
            factor = max(0.2, 0.9 * error**-0.2)
        if not (factor > 0.2):  # also when the error is not a number
            factor = 0.2
        h *= min(5.0, factor)
        if i < len(times) and (h < 1e-10 or steps >= max_steps):
            reason = TOO_MANY_STEPS if steps >= max_steps else STEP_TOO_SMALL
            out[i:] = np.nan
            break
    return steps, reason
