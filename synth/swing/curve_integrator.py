"""Implicit integration of legs with damper curves: sixteen trajectories that share one adaptive step.

A concave torque-speed curve is steepest at rest, thirty times its secant for a power law, and bends where it is
measured. An explicit step is limited by the steepest slope wherever any joint of sixteen legs is slow, and its error
estimate by each bend. Here a step is Radau IIA of order 5 (Hairer & Wanner, *Solving Ordinary Differential Equations
II*, 2nd ed. 1996, section IV.8): three coupled stages, stable however steep the curve is. The damper's torque of a
stage is not that at the stage's rate but the average over the step that a discontinuous Galerkin method takes (Thomee,
*Galerkin Finite Element Methods for Parabolic Problems*, 2nd ed. 2006, ch. 12: with Radau quadrature the two are the
same method), so a bend between two stages is felt in proportion.

The stages are found by Newton's method with the damper's slopes exact and everything else that depends on the state,
beyond springs and linear dampers, left out of the matrix.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import float32, float64, int64, njit, types

from synth.compiling.compiled import compiled
from synth.compiling.numba_internals import UNCOUNTED
from synth.swing.lane_layout import CURVE_POINTS, LANES, Layout
from synth.swing.stage_rows import COURSE, INTEGRAL, NODES, PLACE, STAGES, WIDTH, place

# First indices of blocks of the workspace, and of the working array.
_ROTATION, _RATE, _TORQUE, _SPRING, _DAMPER = (
    Layout(1).row(block) * LANES for block in ("rotation", "rate", "extra_torque", "spring_rate", "damper_rate")
)
# Of the working array: numbers for the whole step, then of the stages.
_STEP, _CHANGE, _ANGLE, _SPEED, _START, _SPRINGS, _DAMPERS = (
    place(block) for block in ("step", "change", "angle", "rate", "start", "spring", "damper")
)
# Of the stages, the rate's course, the estimated errors, and the curves.
_W, _STAGES, _COURSE, _OF_ANGLE, _OF_RATE, _CURVE_SPEED, _CURVE_SLOPE = (
    place(block)
    for block in (
        "stage_rate", "stages", "course", "angle_error", "rate_error", "curve_speed", "curve_slope",
    )
)  # fmt: skip
# Of each stage's rates, and of each coefficient of the course.
_W1, _W2, _W3 = (_W + s * WIDTH for s in range(STAGES))
_P0, _P1, _P2 = (_COURSE + s * WIDTH for s in range(STAGES))
# Radau IIA: see ``stage_rows``.
_A, _P = tuple(map(tuple, INTEGRAL.tolist())), tuple(map(tuple, COURSE.tolist()))
_C1, _C2 = NODES[:2].tolist()
# Coefficients of the integral of (1 - s / c1) (1 - s / c2) (1 - s), 1 at the start of a step and 0 at its stages.
_B1, _B2, _B3 = -(1 / _C1 + 1 / _C2 + 1) / 2, (1 / (_C1 * _C2) + 1 / _C1 + 1 / _C2) / 3, -1 / (_C1 * _C2) / 4

# rad/s of a rate's error that count as 1 rad of an angle's: those of a swing at 3 Hz. Errors of power laws, tables and
# friction-like curves in three links at a tolerance of 1e-6: 10 gives 0.1 to 2e-6 rad in 1.4 times the steps of 20,
# 20 gives 0.1 to 5e-6 rad, 30 up to 1.5e-5 rad; the explicit step 0.6 to 16e-6 rad.
RATE_SCALE = 20.0
FIRST_STEP = 1e-4  # s; from rest a steep curve takes hold within this time
MOST_ITERATIONS = 8  # of Newton's method; two or three are usual, at the bends of a curve five
# Largest change of a rate by an iteration, as a share of its tolerance, after which the next one would be below a
# thousandth of it: the second iteration corrects a twentieth of the first.
FIRST_CHANGE, LATER_CHANGE = 1e-3, 3e-2
SLOW = 0.1  # ratio of two changes above which the matrix is made anew: its slopes are those of other segments
REACHED_END, TOO_MANY_STEPS, STEP_TOO_SMALL = 0, 1, 2  # as in ``chain_integrator``

_array = float64[::1]
_begin = types.FunctionType(types.void(_array, _array))
_iterate = types.FunctionType(types.void(_array, _array, float32[::1], int64))
_filter = types.FunctionType(types.void(_array))
_signature = types.UniTuple(int64, 2)(
    types.UniTuple(int64, 2), _begin, _iterate, _filter, _array, int64, _array, types.UniTuple(float64, 2), int64,
    _array, types.UniTuple(int64, 4), _array, float32[::1],
)  # fmt: skip
_called: dict[str, Any] = {"fastmath": True, "error_model": "numpy", "nogil": True, **UNCOUNTED}
_inlined: dict[str, Any] = {"inline": "always", **_called}


@njit(**_inlined)
def _predict(h, before, half, S):  # type: ignore[no-untyped-def]
    """Start the stages' rates on the course of the step before, of ``before`` s; without one, at the present rate."""
    if before > 0.0:
        x1, x2, x3 = 1.0 + _C1 * h / before, 1.0 + _C2 * h / before, 1.0 + h / before
        for e in range(half):
            S[_W1 + e] = S[_P0 + e] + x1 * (S[_P1 + e] + x1 * S[_P2 + e])
            S[_W2 + e] = S[_P0 + e] + x2 * (S[_P1 + e] + x2 * S[_P2 + e])
            S[_W3 + e] = S[_P0 + e] + x3 * (S[_P1 + e] + x3 * S[_P2 + e])
    else:
        for e in range(half):
            S[_W1 + e] = S[_SPEED + e]
            S[_W2 + e] = S[_SPEED + e]
            S[_W3 + e] = S[_SPEED + e]


@njit(**_inlined)
def _error(relative, absolute, half, h, S):  # type: ignore[no-untyped-def]
    """The largest ratio of estimated error to tolerance over all lanes: RMS of angles, and of rates by their scale."""
    for e in range(half):
        angle = S[_OF_ANGLE + e] / (absolute + relative * abs(S[_ANGLE + e]))
        rate = S[_OF_RATE + e] / (RATE_SCALE * (absolute + relative * max(abs(S[_SPEED + e]), abs(S[_W3 + e]))))
        S[_OF_ANGLE + e] = angle * angle + rate * rate
    largest = 1e-30
    for lane in range(LANES):
        total = 0.0
        for j in range(half // LANES):
            total += S[(_OF_ANGLE + j * LANES + lane) & PLACE]
        largest = max(largest, total)
    return math.sqrt(largest * LANES / (2 * half))


@njit(**_inlined)
def _samples(h, t, half, S, times, i, out, where):  # type: ignore[no-untyped-def]
    """Write the samples from ``times[i]`` on that lie within the step; returns the index of the next one."""
    shown, wide, first, count = where
    while i < len(times) and times[i] <= t + h + 1e-12:
        p = (times[i] - t) / h
        bow = (1.0 - p / _C1) * (1.0 - p / _C2) * (1.0 - p)
        swept = p * (1.0 + p * (_B1 + p * (_B2 + p * _B3)))
        for j in range(half // LANES):
            place = ((i * shown + j) * wide + first) & PLACE
            for lane in range(count):
                e = j * LANES + lane
                turned = p * (S[_P0 + e] + p * (0.5 * S[_P1 + e] + p * (1.0 / 3.0) * S[_P2 + e]))
                out[place + lane] = S[_ANGLE + e] + h * (turned + swept * (S[_SPEED + e] - S[_P0 + e]))
        for j in range(shown - half // LANES):
            place = ((i * shown + half // LANES + j) * wide + first) & PLACE
            for lane in range(count):
                e = j * LANES + lane
                rate = S[_P0 + e] + p * (S[_P1 + e] + p * S[_P2 + e])
                out[place + lane] = rate + bow * (S[_SPEED + e] - S[_P0 + e])
        i += 1
    return i


@njit(**_inlined)
def _advance(h, half, S):  # type: ignore[no-untyped-def]
    """Move the state to the end of the step; the course is kept."""
    for e in range(half):
        S[_ANGLE + e] += h * (_A[2][0] * S[_W1 + e] + _A[2][1] * S[_W2 + e] + _A[2][2] * S[_W3 + e])
        S[_SPEED + e] = S[_W3 + e]


@njit(**_inlined)
def _take_course(half, S):  # type: ignore[no-untyped-def]
    """The parabola through the stages' rates."""
    for e in range(half):
        S[_P0 + e] = _P[0][0] * S[_W1 + e] + _P[0][1] * S[_W2 + e] + _P[0][2] * S[_W3 + e]
        S[_P1 + e] = _P[1][0] * S[_W1 + e] + _P[1][1] * S[_W2 + e] + _P[1][2] * S[_W3 + e]
        S[_P2 + e] = _P[2][0] * S[_W1 + e] + _P[2][1] * S[_W2 + e] + _P[2][2] * S[_W3 + e]


@compiled(_signature, **_called)
def integrate_curves(rows, begin, iterate, filter_error, flat, n, times, limits, max_steps, out, where, S, L):  # type: ignore[no-untyped-def]
    """Integrate legs whose only torques beyond springs, linear dampers and gravity are those of damper curves.

    Parameters
    ----------
    rows : rows of the first curve's speeds and slopes.
    begin, iterate, filter_error : see ``stage_source.stage_functions``.
    flat : the workspace with initial state and parameters; its state rows are overwritten.
    limits : relative and absolute error per step (rad; of rates times ``RATE_SCALE``).
    times, max_steps, out, where : as in ``chain_integrator.integrate``.
    S, L : (``stage_rows.ROOM``,) and (``stage_rows.FACTORS``,) at least, working arrays.

    Returns
    -------
    steps, reason : as in ``chain_integrator.integrate``.
    """
    shown, wide, first, count = where
    half = n * LANES
    for e in range(half):
        flat[_TORQUE + e] = 0.0
        S[_ANGLE + e] = flat[_ROTATION + e]
        S[_SPEED + e] = flat[_RATE + e]
        S[_SPRINGS + e] = flat[_SPRING + e]
        S[_DAMPERS + e] = flat[_DAMPER + e]
    for e in range(half * CURVE_POINTS):
        S[_CURVE_SPEED + e] = flat[rows[0] * LANES + e]
        S[_CURVE_SLOPE + e] = flat[rows[1] * LANES + e]
    for j in range(shown):
        for lane in range(count):
            e = (j if j < n else j - n) * LANES + lane
            out[j * wide + first + lane] = S[_ANGLE + e] if j < n else S[_SPEED + e]
    t, end, i = times[0], times[-1], 1
    h, before = min(FIRST_STEP, end - t), 0.0
    previous, steps, reason = 1e-4, 0, REACHED_END
    scale = 1.0 / (RATE_SCALE * limits[1])
    begin(flat, S)
    while i < len(times):
        if t + h > end:
            h = end - t + 1e-15
        for lane in range(LANES):
            S[_STEP + lane] = h
        _predict(h, before, half, S)
        found, new, last = False, 1, 1e300
        for iteration in range(MOST_ITERATIONS):
            iterate(flat, S, L, new)
            change = 0.0
            for lane in range(LANES):
                change = max(change, S[_CHANGE + lane])
            if change * scale < (FIRST_CHANGE if iteration == 0 else LATER_CHANGE):
                found = True
                break
            new, last = 1 if change > SLOW * last else 0, change
        steps += 1
        factor = 0.5
        if found:
            filter_error(S)
            error = _error(limits[0], limits[1], half, h, S)
            if error <= 1.0:
                _take_course(half, S)
                i = _samples(h, t, half, S, times, i, out, where)
                _advance(h, half, S)
                t += h
                before = h
                # Proportional-integral step control for an estimate of order 3, as in ``chain_integrator``.
                factor = min(4.0, 0.9 * error**-0.2125 * previous**0.05)
                previous = max(error, 1e-4)
                if i < len(times):
                    begin(flat, S)
            else:
                factor = 0.9 * error**-0.25
        if not (factor > 0.2):  # also if the error is nan
            factor = 0.2
        h *= factor
        if i < len(times) and (h < 1e-10 or steps >= max_steps):
            reason = TOO_MANY_STEPS if steps >= max_steps else STEP_TOO_SMALL
            for k in range(i * shown, len(times) * shown):
                for lane in range(count):
                    out[k * wide + first + lane] = np.nan
            break
    return steps, reason
