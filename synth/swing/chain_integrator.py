"""Dormand-Prince 5(4) with dense output for sixteen trajectories that share one adaptive step.

Coefficients, error control and dense output: Hairer, Norsett & Wanner, *Solving Ordinary Differential Equations
I*, 2nd ed. 1993, tables 5.2 and section II.6 (``dopri5``); step control with their PI controller (beta = 0.04).
The right-hand side is a function argument, so this file compiles once for all chains. ``chain`` loads its text like
generated code, so that all compiled code is in one folder and is recompiled when the layout changes.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import float64, int64, njit, types, uint64

from synth.compiling.compiled import compiled
from synth.compiling.numba_internals import UNCOUNTED
from synth.swing import driven_steps, turning_events
from synth.swing.lane_layout import HOLDING, LANES, MOST_LINKS, MOST_MEMORIES, ROOMS, SERVOS, SHARING, Layout

# Tableau and dense output of Dormand & Prince 5(4): Hairer, Norsett & Wanner, Solving ODEs I, table II.5.2 and
# section II.6.
_C2, _C3, _C4, _C5 = 1 / 5, 3 / 10, 4 / 5, 8 / 9
_A21 = 1 / 5
_A31, _A32 = 3 / 40, 9 / 40
_A41, _A42, _A43 = 44 / 45, -56 / 15, 32 / 9
_A51, _A52, _A53, _A54 = 19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729
_A61, _A62, _A63, _A64, _A65 = 9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656
_A71, _A73, _A74, _A75, _A76 = 35 / 384, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84
_E1, _E3, _E4, _E5, _E6, _E7 = 71 / 57600, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40
_D1, _D3, _D4 = -12715105075 / 11282082432, 87487479700 / 32700410799, -10690763975 / 1880347072
_D5, _D6, _D7 = 701980252875 / 199316789632, -1453857185 / 822651844, 69997945 / 29380423

# ``chain`` reads this file as text and makes a second module of it with False: only springs, dampers and gravity, no
# other function to call and no events. It compiles in half the time.
WHOLE = True

# First indices of these blocks in the workspace, the same for every number of links.
_ROTATION, _RATE, _ACCELERATION, _TORQUE = (
    Layout(1).row(block) * LANES for block in ("rotation", "rate", "acceleration", "extra_torque")
)
# First indices of state, stages and auxiliary arrays in the integrator's own array. With constant indices in one array
# LLVM can prove that stores and loads do not overlap; separate arrays would cost a check in each loop.
_ROOM = (2 * MOST_LINKS + (MOST_MEMORIES if WHOLE else 0)) * LANES
_K1, _K2, _K3, _K4, _K5, _K6, _K7, _X, _Y, _V, _R1, _R2, _R3, _R4, _A, _SLIDES, _DUE, _EXPECTED, _BACK = (
    k * _ROOM for k in range(ROOMS)
)
_PLACE = (1 << 48) - 1  # mask that excludes negative indices; wrap-around indexing would need a gather instruction
MANY, PATIENCE = 1 << 40, 10  # no limit on knots; steps with few knots after a rejected one, of which more gain nothing
# Of one step at an event: one or two are usual. Rounding may find an event inside each shorter step again, without end.
MOST_CUTS = 20
# Reasons for the end of an integration.
REACHED_END, TOO_MANY_STEPS, STEP_TOO_SMALL = 0, 1, 2

_chain = types.FunctionType(types.void(float64[::1]))
_extra = types.FunctionType(types.void(float64[::1], int64, int64[::1])) if WHOLE else int64
_loaded = _chain if WHOLE else int64
_known = types.Tuple((float64[::1], float64[:, ::1], float64[::1]))
_told = types.Tuple((float64[::1], float64[:, ::1]))
_state = types.Tuple((uint64[::1], uint64[::1], float64[::1], int64[:, ::1], int64[:, ::1]))
_signature = types.UniTuple(int64, 2)(
    _chain, _extra, _loaded, _loaded, float64[:, ::1], float64[::1], int64, _state, int64[:, ::1], _known, _told,
    float64[::1], types.UniTuple(float64, 3), int64, float64[::1], types.UniTuple(int64, 3), float64[::1],
)  # fmt: skip
_called: dict[str, Any] = {"fastmath": True, "error_model": "numpy", "nogil": True, **UNCOUNTED}
# numba inlines functions with one call site, because LLVM would call them with forty arguments; inlining at several
# call sites would double the compile time.
_once: dict[str, Any] = {"inline": "always", **_called}
_often: dict[str, Any] = {"inline": "never" if WHOLE else "always", **_called}


@njit(**_often)
def _derivative(chain, extra, bearing, again, Z, flat, n, given, t, cursor, S, K):  # type: ignore[no-untyped-def]
    """Write the time derivative of the state in ``Z`` to ``S`` from index ``K`` on; returns the new cursor.

    Friction that grows with the bearing force depends on the accelerations that it changes. These are computed without
    it first; the error is of second order in the friction coefficient.
    """
    derivative, active, modes, known = given
    if WHOLE:
        any_active, any_load = modes
        if known[1].shape[1] > n:
            cursor = driven_steps.put_signals(flat, n, known, t, cursor)
        if any_active:
            extra(flat, n, active[0])
        cursor = driven_steps.add_known_torque(flat, n, any_active, known, t, cursor)
        if any_load:
            bearing(flat)
            extra(flat, n, active[1])
            cursor = driven_steps.add_known_torque(flat, n, any_active, known, t, cursor)
            again(flat)
        else:
            chain(flat)
    else:
        chain(flat)
    K, half = K & _PLACE, (n & MOST_LINKS) * LANES
    for e in range(half):
        S[K + e] = flat[_RATE + e]
    for e in range(half):
        S[K + half + e] = flat[_ACCELERATION + e]
    if WHOLE:
        for j in range(2 * n, len(derivative)):
            row, place = derivative[j], (K + j * LANES) & _PLACE
            for lane in range(LANES):
                S[place + lane] = Z[row, lane]
    return cursor


@njit(**_often)
def _put(S, x, n, state, Z, flat):  # type: ignore[no-untyped-def]
    """Copy the state in ``S`` from index ``x`` on to its rows of the workspace."""
    x, half = x & _PLACE, (n & MOST_LINKS) * LANES
    for e in range(half):
        flat[_ROTATION + e] = S[x + e]
    for e in range(half):
        flat[_RATE + e] = S[x + half + e]
    if WHOLE:
        for j in range(2 * n, len(state)):
            row, place = state[j], (x + j * LANES) & _PLACE
            for lane in range(LANES):
                Z[row, lane] = S[place + lane]


@njit(**_once)
def _stage(s, h, S, size):  # type: ignore[no-untyped-def]
    """Write the state of stage ``s`` (1 to 6; 6 is the end of the step) to ``S`` at ``_Y``.

    The sums are written out, because a loop would store and load the partial sum at each of the 21 terms.
    """
    if s == 1:
        for e in range(size * LANES):
            S[_Y + e] = S[_X + e] + h * (_A21 * S[_K1 + e])
    elif s == 2:
        for e in range(size * LANES):
            S[_Y + e] = S[_X + e] + h * (_A31 * S[_K1 + e] + _A32 * S[_K2 + e])
    elif s == 3:
        for e in range(size * LANES):
            S[_Y + e] = S[_X + e] + h * (_A41 * S[_K1 + e] + _A42 * S[_K2 + e] + _A43 * S[_K3 + e])
    elif s == 4:
        for e in range(size * LANES):
            first = _A51 * S[_K1 + e] + _A52 * S[_K2 + e]
            S[_Y + e] = S[_X + e] + h * (first + _A53 * S[_K3 + e] + _A54 * S[_K4 + e])
    elif s == 5:
        for e in range(size * LANES):
            first = _A61 * S[_K1 + e] + _A62 * S[_K2 + e] + _A63 * S[_K3 + e]
            S[_Y + e] = S[_X + e] + h * (first + _A64 * S[_K4 + e] + _A65 * S[_K5 + e])
    else:
        for e in range(size * LANES):
            first = _A71 * S[_K1 + e] + _A73 * S[_K3 + e] + _A74 * S[_K4 + e]
            S[_Y + e] = S[_X + e] + h * (first + _A75 * S[_K5 + e] + _A76 * S[_K6 + e])


@njit(**_once)
def _difference(h, S, size):  # type: ignore[no-untyped-def]
    """Write the estimated error of the step to ``S`` at ``_V``."""
    for e in range(size * LANES):
        first = _E1 * S[_K1 + e] + _E3 * S[_K3 + e] + _E4 * S[_K4 + e]
        S[_V + e] = h * (first + _E5 * S[_K5 + e] + _E6 * S[_K6 + e] + _E7 * S[_K7 + e])


@njit(**_once)
def _hardest(S, size, relative, absolute):  # type: ignore[no-untyped-def]
    """The largest ratio of estimated error to tolerance over all lanes."""
    for e in range(size * LANES):
        share = S[_V + e] / (absolute + relative * max(abs(S[_X + e]), abs(S[_Y + e])))
        S[_V + e] = share * share
    for j in range(1, size & 255):
        for lane in range(LANES):
            S[_V + lane] += S[_V + j * LANES + lane]
    largest = 1e-30
    for lane in range(LANES):
        largest = max(largest, S[_V + lane])
    return math.sqrt(largest / size)


@njit(**_once)
def _samples(h, t, S, times, i, out, where):  # type: ignore[no-untyped-def]
    """Write the samples from ``times[i]`` on that lie within the step; returns the index of the next one."""
    shown, wide, first = where
    for e in range(shown * LANES):
        dy = S[_Y + e] - S[_X + e]
        bs = h * S[_K1 + e] - dy
        S[_R1 + e] = dy
        S[_R2 + e] = bs
        S[_R3 + e] = dy - h * S[_K7 + e] - bs
        tail = _D1 * S[_K1 + e] + _D3 * S[_K3 + e] + _D4 * S[_K4 + e]
        S[_R4 + e] = h * (tail + _D5 * S[_K5 + e] + _D6 * S[_K6 + e] + _D7 * S[_K7 + e])
    while i < len(times) and times[i] <= t + h + 1e-12:
        p = (times[i] - t) / h
        u = 1.0 - p
        for j in range(shown):
            place = ((i * shown + j) * wide + first) & _PLACE
            for lane in range(LANES):
                e = j * LANES + lane
                tail = S[_R2 + e] + p * (S[_R3 + e] + u * S[_R4 + e])
                out[place + lane] = S[_X + e] + p * (S[_R1 + e] + u * tail)
        i += 1
    return i


@compiled(_signature, **_called)
def integrate(  # type: ignore[no-untyped-def]
    chain, extra, bearing, again, Z, flat, n, states, active, known, told, times, limits, max_steps, out, where, S
):
    """Integrate from ``times[0]`` and write the state at ``times`` into ``out``.

    Parameters
    ----------
    chain, extra, bearing, again : the compiled right-hand side; the extra torques; the two functions that replace the
        right-hand side if some extra torque needs the bearing forces. Without ``WHOLE`` only the first is used.
    Z, flat : (n_row, 16) workspace with initial state and parameters, and the same memory as a flat array; the state
        rows are overwritten.
    states : rows of the state, rows of its derivative, factors (n_state,) on the tolerance, ``bends`` (n_state, 2) of
        bristles and ``plays`` (n_state, 3) of backlash, see ``turning_events``.
    active : (2, 2 + n_law) switches of the extra torques; all zero skips them. Row 0 excludes those that need the
        bearing force, row 1 includes them.
    known : times (m,) s and torques (m, n) N m that act on q, m = 0 for none; with servos also commands (rad on q),
        supplies (V) and switches, (m, 4 n) in all; and each column's tolerated deviation from a straight line within
        a step, ``HELD_STILL`` for commands that are held instead; told : times (p,) s and commands (p, n) rad of these.
    times : (n_time,) s, increasing.
    limits : relative and absolute error per step (rad and rad/s), first step s; max_steps : accepted and rejected.
    out, where : (n_time * n_shown * width,) for the first ``n_shown`` rows of the state, in lanes from ``first`` to
        ``first + 16``; (n_shown, width, first).

    Returns
    -------
    steps, reason : number of steps, and the reason for the end. Unless it is ``REACHED_END``, the remainder is nan.
    """
    state, derivative, factors, bends, plays = states
    size = len(state) if WHOLE else 2 * n
    shown, wide, first = where
    any_bristle, any_play = False, False
    modes = (False, False)
    if WHOLE:
        width = size * LANES
        x, y, v = S[_X : _X + width], S[_Y : _Y + width], S[_V : _V + width]
        K = S[_K1 : _K1 + 7 * _ROOM].reshape(7, _ROOM)
        allowed, back, target = S[_A : _A + width], S[_BACK : _BACK + LANES], S[_BACK + LANES : _BACK + 2 * LANES]
        n_memory = width - 2 * n * LANES
        slides, due = S[_SLIDES : _SLIDES + n_memory], S[_DUE : _DUE + n_memory]
        expected = S[_EXPECTED : _EXPECTED + n_memory]
        for e in range(n_memory):
            due[e] = turning_events.NEVER
        for j in range(2 * n, size):
            any_bristle = any_bristle or bends[j, 0] >= 0
            any_play = any_play or plays[j, 0] >= 0
        any_active, any_load = False, False
        for index in range(active.shape[1]):
            any_active = any_active or active[0, index] != 0 or active[1, index] != 0
            any_load = any_load or active[0, index] != active[1, index]
        modes = (any_active, any_load)
        for j in range(size):
            for lane in range(LANES):
                allowed[j * LANES + lane] = factors[j]
    for e in range(n * LANES):
        flat[_TORQUE + e] = 0.0
    for j in range(size):
        for lane in range(LANES):
            S[_X + j * LANES + lane] = Z[state[j], lane]
    for j in range(shown):
        for lane in range(LANES):
            out[j * wide + first + lane] = S[_X + j * LANES + lane]
    t = times[0]
    end = times[-1]
    h = min(limits[2], end - t)
    i = 1
    previous = 1e-4
    steps = 0
    reason = REACHED_END
    given = (derivative, active, modes, known)
    cursor, k1 = int64(0), int64(_K1)  # typed values, because numba would recompile for each literal
    # Whether duties or commands are held; the step size before a cut at a change; place among the held commands.
    holds, wanted, sample = False, 0.0, int64(0)
    if WHOLE:
        holds = active[0, SERVOS] == HOLDING or active[0, SERVOS] == HOLDING + SHARING
        for j in range(n, min(2 * n, len(known[2]))):
            holds = holds or (active[0, SERVOS] != 0 and known[2][j] >= driven_steps.HELD_STILL)
    if WHOLE and holds:
        sample = driven_steps.look(flat, n, known, told, t, True, sample)
    cursor = _derivative(chain, extra, bearing, again, Z, flat, n, given, t, cursor, S, k1)
    if WHOLE and any_bristle:
        turning_events.slide_from_start(n, bends, Z, x, K)
        _put(S, int64(_X), n, state, Z, flat)
        cursor = _derivative(chain, extra, bearing, again, Z, flat, n, given, t, cursor, S, k1)
    any_event, cuts = any_bristle or any_play, 0
    most, patience, passed, nearest = MANY, 0, 0, 0.0  # number of knots of the known torque that a step may pass
    fresh, uncut = any_event, 0.0  # at a new state; the step size before it was cut at an event
    while i < len(times):
        if WHOLE and holds and driven_steps.next_look(flat, n, known) <= t + driven_steps.SAME_TIME:
            _put(S, int64(_X), n, state, Z, flat)
            sample = driven_steps.look(flat, n, known, told, t, False, sample)
            cursor = _derivative(chain, extra, bearing, again, Z, flat, n, given, t, cursor, S, k1)
        if WHOLE and fresh:
            fresh = False
            for j in range(2 * n, size):
                turns = bends[j, 0] >= 0 and turning_events.find_reversals(bends, j, steps > 0, Z, x, K, back, target)
                meets = plays[j, 0] >= 0 and turning_events.close_contact(n, plays, j, Z, x, K, back)
                for k in range(1 if turns else 2, 3 if turns or meets else 0):
                    _put(S, int64(_X), n, state, Z, flat)
                    if k == 1:
                        for lane in range(LANES):
                            if back[lane] != 0.0:
                                Z[state[j], lane] = target[lane]
                    cursor = _derivative(chain, extra, bearing, again, Z, flat, n, given, t, cursor, S, _K1 + k * _ROOM)
                    if k == 1:
                        turning_events.hold_joint(bends, j, x, K, back, target)
                if turns:
                    turning_events.correct_reversal(n, bends, j, x, K, back)
                elif meets:
                    turning_events.correct_contact(n, x, K, back)
            turning_events.find_sliding(n, bends, Z, x, K, slides)
            turning_events.keep_sliding(n, slides, K[0])
        if t + h > end:
            h = end - t + 1e-15
        if WHOLE and holds:
            wanted, h = h, min(h, driven_steps.next_look(flat, n, known) - t)
        if WHOLE and len(known[0]) > 1:
            h, passed, nearest = driven_steps.within_torque(known, cursor, t, h, most)
        for s in range(1, 7):
            _stage(s, h, S, size)
            _put(S, int64(_Y), n, state, Z, flat)
            now = t
            if WHOLE:
                now = t + h * (_C2 if s == 1 else _C3 if s == 2 else _C4 if s == 3 else _C5 if s == 4 else 1.0)
            cursor = _derivative(chain, extra, bearing, again, Z, flat, n, given, now, cursor, S, _K1 + s * _ROOM)
            if WHOLE and any_bristle:
                turning_events.keep_sliding(n, slides, K[s])
        steps += 1
        _difference(h, S, size)
        if WHOLE:
            if any_bristle:
                turning_events.bound_bends(n, bends, y, v)
            for e in range(width):
                v[e] /= allowed[e]
        error = _hardest(S, size, limits[0], limits[1])
        if WHOLE and any_event and error <= 1.0:
            cut = turning_events.first_reversal(n, bends, slides, Z, x, y, K, t, h, expected)
            if any_play:
                cut = min(cut, turning_events.first_contact(n, plays, Z, x, y, K, h))
            if cut < h and cuts < MOST_CUTS:
                cuts += 1
                uncut, h = max(uncut, h), cut
                for e in range(n_memory):
                    due[e] = expected[e]
                continue
        if error <= 1.0:
            cuts = 0
            if times[i] <= t + h + 1e-12:
                i = _samples(h, t, S, times, i, out, where)
            t += h
            for e in range(size * LANES):
                S[_X + e] = S[_Y + e]
                S[_K1 + e] = S[_K7 + e]
            fresh = any_event
            # Proportional-integral step control with the constants of Hairer & Wanner, Solving ODEs II, section IV.2.
            factor = min(5.0, 0.9 * error**-0.17 * previous**0.04)
            if WHOLE and uncut > 0.0:
                # Continue to the next expected turn of a lane, otherwise with the step size before the cut.
                coming = turning_events.next_reversal(due, t)
                factor = min(coming - t, uncut) / h
                uncut = uncut if coming < t + uncut else 0.0
            if WHOLE and holds:
                factor = max(factor, wanted / h)
            previous = max(error, 1e-4)  # ibid.
            if WHOLE and most < MANY:
                patience -= 1
                if patience < 0:
                    most *= 2
        else:
            factor = max(0.2, 0.9 * error**-0.2)  # safety 0.9, at most a fifth (ibid.)
            if WHOLE and passed > 0:  # the torque is smooth between knots, so the knots probably caused the error
                most, patience = max((passed + 1) // 2, 1), PATIENCE
                factor = max(factor, nearest / h)
        if not (factor > 0.2):  # also if the error is nan
            factor = 0.2
        h *= factor
        if i < len(times) and (h < 1e-10 or steps >= max_steps):
            reason = TOO_MANY_STEPS if steps >= max_steps else STEP_TOO_SMALL
            for k in range(i * shown, len(times) * shown):
                for lane in range(LANES):
                    out[k * wide + first + lane] = np.nan
            break
    return steps, reason
