"""Implicit integration of legs with damper curves: sixteen trajectories with adaptive steps of their own.

A concave torque-speed curve is steepest at rest, thirty times its secant for a power law, and bends where it is
measured. An explicit step is limited by the steepest slope wherever any joint of sixteen legs is slow, and its error
estimate by each bend. Here a step is Radau IIA of order 5 (Hairer & Wanner, *Solving Ordinary Differential Equations
II*, 2nd ed. 1996, section IV.8): three coupled stages, stable however steep the curve is. The damper's torque of a
stage is not that at the stage's rate but the average over the step that a discontinuous Galerkin method takes (Thomee,
*Galerkin Finite Element Methods for Parabolic Problems*, 2nd ed. 2006, ch. 12: with Radau quadrature the two are the
same method), so a bend between two stages is felt in proportion.

The stages are found by Newton's method with the damper's slopes exact and everything else that depends on the state,
beyond springs and linear dampers, left out of the matrix. The lanes iterate together, but each ends its own step when
its equations are solved, and starts the next at once (``curve_clocks``).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import float32, float64, int64, njit, types

from synth.compiling.compiled import compiled
from synth.compiling.numba_internals import UNCOUNTED
from synth.swing import curve_bends, curve_clocks
from synth.swing.curve_clocks import CLOCK, COMING, ENDED, ERROR, MOVED, RATIO
from synth.swing.lane_layout import CURVE_POINTS, LANES, PLACE, Layout
from synth.swing.stage_rows import COURSE, INTEGRAL, NODES, RATE_SCALE, STAGES, WIDTH, place, single_place

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
_SINGLE_SPEED, _SINGLE_SLOPE = single_place("curve_speed"), single_place("curve_slope")
# Radau IIA: see ``stage_rows``.
_A, _P = tuple(map(tuple, INTEGRAL.tolist())), tuple(map(tuple, COURSE.tolist()))
_C1, _C2 = NODES[:2].tolist()
# Coefficients of the integral of (1 - s / c1) (1 - s / c2) (1 - s), 1 at the start of a step and 0 at its stages.
_B1, _B2, _B3 = -(1 / _C1 + 1 / _C2 + 1) / 2, (1 / (_C1 * _C2) + 1 / _C1 + 1 / _C2) / 3, -1 / (_C1 * _C2) / 4

SAME_TIME = 1e-12  # s, of a sample and the end of a step
REACHED_END, TOO_MANY_STEPS = 0, 1  # as in ``chain_integrator``; steps that are too short count as too many

_array = float64[::1]
_begin = types.FunctionType(types.void(_array, _array))
_iterate = types.FunctionType(types.void(_array, _array, float32[::1], int64))
_filter = types.FunctionType(types.void(_array, float32[::1]))
_signature = types.UniTuple(int64, 2)(
    types.UniTuple(int64, 2), _begin, _iterate, _filter, _array, int64, _array, types.UniTuple(float64, 2), int64,
    _array, types.UniTuple(int64, 4), _array, float32[::1],
)  # fmt: skip
_called: dict[str, Any] = {"fastmath": True, "error_model": "numpy", "nogil": True, **UNCOUNTED}
_inlined: dict[str, Any] = {"inline": "always", **_called}


@njit(**_inlined)
def _predict(n, S):  # type: ignore[no-untyped-def]
    """Start the stages' rates of lanes whose step has ended on the course of the step before."""
    for j in range(n):
        for lane in range(LANES):
            e, ended = j * LANES + lane, S[ENDED + lane] != 0.0
            ratio, p0, p1, p2 = S[RATIO + lane], S[_P0 + e], S[_P1 + e], S[_P2 + e]
            x1, x2, x3 = 1.0 + _C1 * ratio, 1.0 + _C2 * ratio, 1.0 + ratio
            S[_W1 + e] = p0 + x1 * (p1 + x1 * p2) if ended else S[_W1 + e]
            S[_W2 + e] = p0 + x2 * (p1 + x2 * p2) if ended else S[_W2 + e]
            S[_W3 + e] = p0 + x3 * (p1 + x3 * p2) if ended else S[_W3 + e]


@njit(**_inlined)
def _find_errors(relative, absolute, n, S):  # type: ignore[no-untyped-def]
    """Find each lane's ratio of estimated error to tolerance: RMS of angles, and of rates by their scale."""
    for lane in range(LANES):
        S[ERROR + lane] = 1e-60
    for j in range(n):
        for lane in range(LANES):
            e = j * LANES + lane
            angle = S[_OF_ANGLE + e] / (absolute + relative * abs(S[_ANGLE + e]))
            rate = S[_OF_RATE + e] / (absolute + relative * max(abs(S[_SPEED + e]), abs(S[_W3 + e])))
            S[ERROR + lane] += angle * angle + rate * rate
    share = 0.5 / n
    for lane in range(LANES):
        S[ERROR + lane] = math.sqrt(S[ERROR + lane] * share)


@njit(**_inlined)
def _samples(n, S, times, out, where):  # type: ignore[no-untyped-def]
    """Write each lane's samples within its step, if that is kept.

    The rate is the stages' parabola and what it misses at the start, d, times a cubic that is 0 at the stages.
    """
    shown, wide, first, count = where
    for lane in range(count):
        if S[MOVED + lane] == 0.0:
            continue
        begin, t, h = int64(S[COMING + lane]) & PLACE, S[CLOCK + lane], S[_STEP + lane]
        last = begin
        while last < len(times) and times[last] <= t + h + SAME_TIME:
            last += 1
        if last == begin:
            continue
        S[COMING + lane], share = last, 1.0 / h
        for j in range(shown):
            e = (j if j < n else j - n) * LANES + lane
            p0, p1, p2 = S[_P0 + e], S[_P1 + e], S[_P2 + e]
            d = S[_SPEED + e] - p0
            c0, c1, c2, c3, c4 = p0 + d, p1 + 2.0 * _B1 * d, p2 + 3.0 * _B2 * d, 4.0 * _B3 * d, 0.0
            if j < n:
                c0, c1, c2, c3, c4 = S[_ANGLE + e], h * c0, h * 0.5 * c1, h * (1.0 / 3.0) * c2, h * 0.25 * c3
            at = ((begin * shown + j) * wide + first + lane) & PLACE
            for i in range(begin, last):
                p = (times[i] - t) * share
                out[at] = c0 + p * (c1 + p * (c2 + p * (c3 + p * c4)))
                at = (at + shown * wide) & PLACE


@njit(**_inlined)
def _take_course(n, S):  # type: ignore[no-untyped-def]
    """The parabola through the stages' rates, of lanes whose step is kept."""
    for j in range(n):
        for lane in range(LANES):
            e, moved = j * LANES + lane, S[MOVED + lane] != 0.0
            w1, w2, w3 = S[_W1 + e], S[_W2 + e], S[_W3 + e]
            S[_P0 + e] = _P[0][0] * w1 + _P[0][1] * w2 + _P[0][2] * w3 if moved else S[_P0 + e]
            S[_P1 + e] = _P[1][0] * w1 + _P[1][1] * w2 + _P[1][2] * w3 if moved else S[_P1 + e]
            S[_P2 + e] = _P[2][0] * w1 + _P[2][1] * w2 + _P[2][2] * w3 if moved else S[_P2 + e]


@njit(**_inlined)
def _move(n, S):  # type: ignore[no-untyped-def]
    """Move the states of lanes whose step is kept to its end."""
    for j in range(n):
        for lane in range(LANES):
            e, moved = j * LANES + lane, S[MOVED + lane] != 0.0
            turned = _A[2][0] * S[_W1 + e] + _A[2][1] * S[_W2 + e] + _A[2][2] * S[_W3 + e]
            S[_ANGLE + e] = S[_ANGLE + e] + S[_STEP + lane] * turned if moved else S[_ANGLE + e]
            S[_SPEED + e] = S[_W3 + e] if moved else S[_SPEED + e]


@njit(**_inlined)
def _take_legs(rows, flat, n, out, where, S, L):  # type: ignore[no-untyped-def]
    """Take the legs and their state from the workspace, and show the state."""
    shown, wide, first, count = where
    half = n * LANES
    for e in range(half):
        flat[_TORQUE + e] = 0.0
        S[_ANGLE + e] = flat[_ROTATION + e]
        S[_SPEED + e] = flat[_RATE + e]
        S[_P0 + e], S[_P1 + e], S[_P2 + e] = flat[_RATE + e], 0.0, 0.0
        S[_SPRINGS + e] = flat[_SPRING + e]
        S[_DAMPERS + e] = flat[_DAMPER + e]
    for e in range(half * CURVE_POINTS):
        S[_CURVE_SPEED + e] = flat[rows[0] * LANES + e]
        S[_CURVE_SLOPE + e] = flat[rows[1] * LANES + e]
        L[_SINGLE_SPEED + e] = float32(S[_CURVE_SPEED + e])
        L[_SINGLE_SLOPE + e] = float32(S[_CURVE_SLOPE + e])
    for j in range(shown):
        for lane in range(count):
            e = (j if j < n else j - n) * LANES + lane
            out[j * wide + first + lane] = S[_ANGLE + e] if j < n else S[_SPEED + e]


@njit(**_inlined)
def _give_up(S, times, out, where):  # type: ignore[no-untyped-def]
    """Write nan to the samples that are left of lost lanes, which are not at the end but have no step."""
    shown, wide, first, count = where
    for lane in range(count):
        if S[_STEP + lane] == 0.0 and S[CLOCK + lane] < times[-1]:
            for k in range(int64(S[COMING + lane]) * shown, len(times) * shown):
                out[k * wide + first + lane] = np.nan


@njit(**_inlined)
def _end_steps(begin, filter_error, flat, limits, sharp, times, out, where, n, S, L):  # type: ignore[no-untyped-def]
    """Keep or reject the steps that have ended, show the samples of those that are kept, and size the next ones."""
    filter_error(S, L)
    _find_errors(limits[0], limits[1], n, S)
    curve_clocks.of_alike(ERROR, S)
    if sharp:
        curve_bends.find_passed(n, S)
    if curve_clocks.keep(S):
        _take_course(n, S)
        _samples(n, S, times, out, where)
        _move(n, S)
        curve_clocks.advance(times[-1], S)
        begin(flat, S)
    curve_clocks.resize(S)


@compiled(_signature, **_called)
def integrate_curves(rows, begin, iterate, filter_error, flat, n, times, limits, max_steps, out, where, S, L):  # type: ignore[no-untyped-def]
    """Integrate legs whose only torques beyond springs, linear dampers and gravity are those of damper curves.

    Parameters
    ----------
    rows : rows of the first curve's speeds and slopes.
    begin, iterate, filter_error : see ``stage_source.stage_functions``.
    flat : the workspace with initial state and parameters; its state rows are overwritten.
    limits : relative and absolute error per step (rad; of rates by their scale, see ``stage_rows.RATE_SCALE``).
    times, max_steps, out, where : as in ``chain_integrator.integrate``; the steps of one lane are counted.
    S, L : (``lane_layout.WORKING``,) and (``stage_rows.SINGLE_ROOM``,) at least, working arrays.

    Returns
    -------
    steps, reason : as in ``chain_integrator.integrate``. ``steps`` counts the steps of all lanes at once.
    """
    _take_legs(rows, flat, n, out, where, S, L)
    end = times[-1]
    steps, reason, fresh, scale = 0, REACHED_END, 1, 1.0 / (RATE_SCALE * limits[1])
    begin(flat, S)
    curve_clocks.start(times[0], end - times[0], S)
    curve_clocks.find_leaders(n, S)
    sharp = curve_bends.find_sharp(n, S)
    under_way, _ = curve_clocks.own_steps(end, max_steps, n, S)
    _predict(n, S)
    while under_way:
        iterate(flat, S, L, fresh)
        ended, anew = curve_clocks.judge(scale, S)
        fresh = 1 if ended or anew else 0
        if not ended:
            continue
        steps += 1
        _end_steps(begin, filter_error, flat, limits, sharp, times, out, where, n, S, L)
        under_way, lost = curve_clocks.own_steps(end, max_steps, n, S)
        if lost:
            reason = TOO_MANY_STEPS
            _give_up(S, times, out, where)
        _predict(n, S)
    return steps, reason
