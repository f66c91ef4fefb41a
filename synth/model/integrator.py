"""Dormand-Prince 5(4) with dense output for sixteen trajectories that share one adaptive step.

Coefficients, error control and dense output: Hairer, Norsett & Wanner, *Solving Ordinary Differential Equations
I*, 2nd ed. 1993, tables 5.2 and section II.6 (``dopri5``); step control with their PI controller (beta = 0.04).
The right-hand side comes in as a function value, so this file compiles once for all chains. ``chain`` loads its text
as it loads generated code, so that all that is compiled lies in one folder and is made anew when the layout changes.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import float64, int64, njit, types, uint64

from synth.model import turning
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
_state = types.Tuple((uint64[::1], uint64[::1], float64[::1], int64[:, ::1], int64[:, ::1]))
_signature = types.UniTuple(int64, 2)(
    _chain, _extra, _bearing, float64[:, ::1], int64, _state, int64[:, ::1], _known, float64[::1], float64[::1],
    float64, int64, float64[:, ::1],
)  # fmt: skip
_called: dict[str, Any] = {"fastmath": True, "error_model": "numpy", "nogil": True}


@njit(**_called)
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


@njit(**_called)
def _derivative(chain, extra, bearing, Z, n, derivative, active, modes, known, t, cursor, K):  # type: ignore[no-untyped-def]
    """Fill K (n_state * 16,) with the time derivative of the state that lies in Z.

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
        row = derivative[j]
        for lane in range(LANES):
            K[j * LANES + lane] = Z[row, lane]
    return cursor


@njit(**_called)
def _put(x, state, Z):  # type: ignore[no-untyped-def]
    """The state into its rows of the workspace."""
    for j in range(len(state)):
        row = state[j]
        for lane in range(LANES):
            Z[row, lane] = x[j * LANES + lane]


@njit(_signature, cache=True, **_called)
def integrate(chain, extra, bearing, Z, n, states, active, known, times, tolerance, first_step, max_steps, out):  # type: ignore[no-untyped-def]
    """Integrate from ``times[0]`` and write the state at ``times`` into ``out``.

    Parameters
    ----------
    chain, extra, bearing : the compiled right-hand side, the extra torques and the bearing forces.
    Z : (n_row, 16) workspace with initial state and parameters filled in; its state rows are overwritten.
    states : rows of the state, rows of its derivative, each one's factor (n_state,) on the tolerance, what bends
        bristles (n_state, 2) and which memories lie behind play (n_state, 3), see ``turning``.
    active : (2, 1 + n_law) which extra torques are on; all zero skips them. First without, then with those that need
        the bearing force; equal where none does.
    known : times (m,) s and torques (m, n) N m that act on q; m = 0 for none.
    times : (n_time,) s, increasing.
    tolerance : (2,) relative, absolute (rad and rad/s); first_step : s; max_steps : accepted and rejected.
    out : (n_time, rows * 16), the first ``rows`` of the state.

    Returns
    -------
    steps, reason : number of steps, and why it stopped. On any other reason than ``REACHED_END`` the rest is nan.
    """
    state, derivative, factors, bends, plays = states
    size = len(state)
    width, shown = size * LANES, out.shape[1]
    # Flat: a loop of 16 would spend more on the check that its arrays do not overlap than on its arithmetic.
    x, y, v = np.empty(width), np.empty(width), np.empty(width)
    allowed = np.empty(width)
    n_memory = width - 2 * n * LANES
    slides, due, expected, back = np.empty(n_memory), np.empty(n_memory), np.empty(n_memory), np.empty(LANES)
    target = np.empty(LANES)
    for e in range(n_memory):
        due[e] = turning.NEVER
    any_bristle, any_play = False, False
    for j in range(2 * n, size):
        any_bristle = any_bristle or bends[j, 0] >= 0
        any_play = any_play or plays[j, 0] >= 0
    K = np.empty((7, width))
    r = np.empty((4, shown))
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
            e = j * LANES + lane
            x[e], allowed[e] = Z[state[j], lane], factors[j]
    for e in range(shown):
        out[0, e] = x[e]
    t = times[0]
    end = times[-1]
    h = min(first_step, end - t)
    i = 1
    previous = 1e-4
    steps = 0
    reason = REACHED_END
    cursor = _derivative(chain, extra, bearing, Z, n, derivative, active, modes, known, t, 0, K[0])
    if any_bristle:
        turning.slide_from_start(n, bends, Z, x, K)
        _put(x, state, Z)
        cursor = _derivative(chain, extra, bearing, Z, n, derivative, active, modes, known, t, cursor, K[0])
    any_event = any_bristle or any_play
    fresh, uncut = any_event, 0.0  # at a new place; the step that was cut at a joint's turn
    while i < len(times):
        if fresh:
            fresh = False
            for j in range(2 * n, size):
                if bends[j, 0] >= 0 and turning.turn_back(bends, j, steps > 0, Z, x, K, back, target):
                    _put(x, state, Z)
                    for lane in range(LANES):
                        if back[lane] != 0.0:
                            Z[state[j], lane] = target[lane]
                    cursor = _derivative(chain, extra, bearing, Z, n, derivative, active, modes, known, t, cursor, K[1])
                    turning.take_hold(bends, j, x, K, back, target)
                    _put(x, state, Z)
                    cursor = _derivative(chain, extra, bearing, Z, n, derivative, active, modes, known, t, cursor, K[2])
                    turning.make_up(n, bends, j, x, K, back)
                elif plays[j, 0] >= 0 and turning.meet(n, plays, j, Z, x, K, back):
                    _put(x, state, Z)
                    cursor = _derivative(chain, extra, bearing, Z, n, derivative, active, modes, known, t, cursor, K[2])
                    turning.make_up_contact(n, x, K, back)
            turning.find_sliding(n, bends, Z, x, K, slides)
            turning.keep_sliding(n, slides, K[0])
        if t + h > end:
            h = end - t + 1e-15
        for s in range(1, 7):
            c = h * _A[s, 0]
            for e in range(width):
                y[e] = x[e] + c * K[0, e]
            for m in range(1, s):
                c = h * _A[s, m]
                for e in range(width):
                    y[e] += c * K[m, e]
            _put(y, state, Z)
            now = t + _C[s] * h
            cursor = _derivative(chain, extra, bearing, Z, n, derivative, active, modes, known, now, cursor, K[s])
            if any_bristle:
                turning.keep_sliding(n, slides, K[s])
        steps += 1
        for e in range(width):
            v[e] = _E[0] * K[0, e] + _E[2] * K[2, e] + _E[3] * K[3, e]
        for e in range(width):
            v[e] = h * (v[e] + _E[4] * K[4, e] + _E[5] * K[5, e] + _E[6] * K[6, e])
        if any_bristle:
            turning.bound_bends(n, bends, y, v)
        for e in range(width):
            v[e] /= allowed[e] * (tolerance[1] + tolerance[0] * max(abs(x[e]), abs(y[e])))
        for lane in range(LANES):
            error_sum[lane] = 0.0
        for j in range(size):
            for lane in range(LANES):
                error_sum[lane] += v[j * LANES + lane] * v[j * LANES + lane]
        error = 1e-30
        for lane in range(LANES):
            error = max(error, error_sum[lane])
        error = math.sqrt(error / size)
        if any_event and error <= 1.0:
            cut = turning.first_turn(n, bends, slides, Z, x, y, K, t, h, expected)
            if any_play:
                cut = min(cut, turning.first_contact(n, plays, Z, x, y, K, h))
            if cut < h:
                uncut, h = max(uncut, h), cut
                for e in range(n_memory):
                    due[e] = expected[e]
                continue
        if error <= 1.0:
            if times[i] <= t + h + 1e-12:
                for e in range(shown):
                    dy = y[e] - x[e]
                    bs = h * K[0, e] - dy
                    r[0, e] = dy
                    r[1, e] = bs
                    r[2, e] = dy - h * K[6, e] - bs
                for e in range(shown):
                    r[3, e] = h * (_D[0] * K[0, e] + _D[2] * K[2, e] + _D[3] * K[3, e])
                for e in range(shown):
                    r[3, e] += h * (_D[4] * K[4, e] + _D[5] * K[5, e] + _D[6] * K[6, e])
                while i < len(times) and times[i] <= t + h + 1e-12:
                    p = (times[i] - t) / h
                    u = 1.0 - p
                    for e in range(shown):
                        tail = r[1, e] + p * (r[2, e] + u * r[3, e])
                        out[i, e] = x[e] + p * (r[0, e] + u * tail)
                    i += 1
            t += h
            for e in range(width):
                x[e] = y[e]
                K[0, e] = K[6, e]
            fresh = any_event
            factor = min(5.0, 0.9 * error**-0.17 * previous**0.04)
            if uncut > 0.0:  # go on to the next lane's turn, if that is known, or else as if nothing had been
                coming = turning.next_due(due, t)
                factor = min(coming - t, uncut) / h
                uncut = uncut if coming < t + uncut else 0.0
            previous = max(error, 1e-4)
        else:
            factor = max(0.2, 0.9 * error**-0.2)
        if not (factor > 0.2):  # also when the error is not a number
            factor = 0.2
        h *= factor
        if i < len(times) and (h < 1e-10 or steps >= max_steps):
            reason = TOO_MANY_STEPS if steps >= max_steps else STEP_TOO_SMALL
            for k in range(i, len(times)):
                for e in range(shown):
                    out[k, e] = np.nan
            break
    return steps, reason
