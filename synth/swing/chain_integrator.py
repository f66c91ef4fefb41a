"""Explicit Runge-Kutta steps with dense output for sixteen trajectories that share one adaptive step.

Pairs: ``explicit_pairs``. Error control and step control: Hairer, Norsett & Wanner, *Solving Ordinary Differential
Equations I*, 2nd ed. 1993, section II.4, with their PI controller for mildly stiff problems (Hairer & Wanner, *Solving
ODEs II*, section IV.2). The right-hand side is a function argument, so this file compiles once for all chains.
``chain`` loads its text like generated code, so that all compiled code is in one folder and is recompiled when the
layout changes.

``S`` is one array: the integrator's own blocks, and from ``WORKING`` on the workspace of ``lane_layout``. With constant
indices in one array LLVM can prove that stores and loads do not overlap; several would cost a check in each loop.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import float64, int64, njit, types, uint64

from synth.compiling.compiled import compiled
from synth.compiling.numba_internals import UNCOUNTED
from synth.swing import driven_steps, turning_events, turning_times
from synth.swing.explicit_pairs import DAMPED, DORMAND_PRINCE
from synth.swing.explicit_steps import (
    ACCELERATION,
    ALLOWED,
    BACK,
    DERIVATIVES,
    DUE,
    EXPECTED,
    K1,
    K7,
    MEMORY,
    OF_RATES,
    RATE,
    ROOM,
    ROTATION,
    SLIDES,
    TORQUE,
    XW,
    YW,
    V,
    X,
    Y,
    difference,
    difference_of_memories,
    hardest,
    put_memories,
    samples,
    stage,
    stage_of_memories,
)  # fmt: skip
from synth.swing.lane_layout import HOLDING, LANES, LOAD_PASSES, MOST_LINKS, PLACE, SERVOS, SHARING, WORKING

# ``chain_modules`` reads this file as text and makes further modules of it, for ``LINKS`` links, which compile in a
# quarter of the time. Without ``WHOLE`` no memories, events, known torques or servos; without ``EXTRA`` only springs,
# dampers and gravity, no other function to call.
WHOLE = True
EXTRA = True
LINKS = 0  # a constant length of all loops; 0: any number of links

_WEIGHTS, _OF_DAMPED = DORMAND_PRINCE.weights, DAMPED.weights
# Step times the fastest decay from which ``DAMPED`` is used. Below, errors limit the steps, and those of Dormand and
# Prince's pair are smaller; it is stable up to 3.3.
_FAST = 2.5
_ROUNDS, _NUDGE = 5, 1e-3  # of the power iteration for the fastest decay; its change of the rates, rad/s
# Step control: the exponents of this error and the last one with each pair; the share of the step that the error would
# allow; the smallest and largest change of the step. With 0.04 steps at the limit of stability fail by turns with
# ``DAMPED``.
_EXPONENTS, _EXPONENTS_OF_DAMPED = (0.2 - 0.75 * 0.04, 0.04), (0.2 - 0.75 * 0.07, 0.07)
_SAFE, _LEAST, _MOST = 0.9, 0.2, 5.0

MANY, PATIENCE = 1 << 40, 10  # no limit on knots; steps with few knots after a rejected one, of which more gain nothing
# Of one step at an event: one or two are usual. Rounding may find an event inside each shorter step again, without end.
MOST_CUTS = 20
# Reasons for the end of an integration.
REACHED_END, TOO_MANY_STEPS, STEP_TOO_SMALL = 0, 1, 2

_chain = types.FunctionType(types.void(float64[::1]))
_extra = types.FunctionType(types.void(float64[::1], int64, int64[::1])) if EXTRA else int64
_loaded = _chain if WHOLE else int64
_known = types.Tuple((float64[::1], float64[:, ::1], float64[::1]))
_commands_held = types.Tuple((float64[::1], float64[:, ::1]))
_state = types.Tuple((uint64[::1], uint64[::1], float64[::1], int64[:, ::1], int64[:, ::1]))
_signature = types.UniTuple(int64, 2)(
    _chain, _extra, _loaded, _loaded, float64[::1], int64, _state, int64[:, ::1], _known, _commands_held,
    float64[::1], types.UniTuple(float64, 3), int64, float64[::1], types.UniTuple(int64, 4),
)  # fmt: skip
_called: dict[str, Any] = {"fastmath": True, "error_model": "numpy", "nogil": True, **UNCOUNTED}
# inlining at several call sites would double the compile time
_once: dict[str, Any] = {"inline": "always", **_called}
_often: dict[str, Any] = {"inline": "never" if WHOLE else "always", **_called}


@njit(**_often)
def _derivative(chain, extra, bearing, again, S, flat, n, given, t, cursor, K):  # type: ignore[no-untyped-def]
    """Write the derivatives of rates and memories at the state in the workspace to ``S`` from ``K`` on.

    Friction that grows with the bearing force depends on the accelerations that it changes: these are computed without
    it first, see ``LOAD_PASSES``. Returns the new cursor.
    """
    derivative, active, modes, known = given
    if WHOLE:
        any_active, any_load = modes
        if known[1].shape[1] > n:
            cursor = driven_steps.put_signals(flat, n, known, t, cursor)
        cursor = driven_steps.put_known_torque(flat, n, known, t, cursor)
        if any_active:
            extra(flat, n, active[0])
        driven_steps.add_known_torque(flat, n, any_active, known)
        if any_load:
            for _ in range(LOAD_PASSES):
                bearing(flat)
                extra(flat, n, active[1])
                driven_steps.add_known_torque(flat, n, any_active, known)
                again(flat)
        else:
            chain(flat)
    else:
        if EXTRA:
            extra(flat, n, active[0])
        chain(flat)
    K = K & PLACE
    for e in range((LINKS if LINKS else n & MOST_LINKS) * LANES):
        S[K + e] = S[ACCELERATION + e]
    if WHOLE:
        for m in range(len(derivative)):
            row, place = (WORKING + derivative[m] * LANES) & PLACE, (K + OF_RATES + m * LANES) & PLACE
            for lane in range(LANES):
                S[place + lane] = S[row + lane]
    return cursor


@njit(**_often)
def _put(S, x, n, state):  # type: ignore[no-untyped-def]
    """Copy the state in ``S`` from index ``x`` on to its rows of the workspace."""
    x = x & PLACE
    for e in range((LINKS if LINKS else n & MOST_LINKS) * LANES):
        S[ROTATION + e] = S[x + e]
        S[RATE + e] = S[x + OF_RATES + e]
    if WHOLE:
        put_memories(S, x + MEMORY, state)


@njit(**_once)
def _fastest_decay(chain, S, flat, half):  # type: ignore[no-untyped-def]
    """The largest rate (1/s) at which a change of the rates decays at the start, of all lanes: by power iteration.

    The accelerations at the start are in ``K1``. ``V`` is overwritten, and the rates in the workspace.
    """
    fastest = 0.0
    for e in range(half):
        S[V + e] = 1.0 - 2.0 * ((e // LANES) % 2)
    for _ in range(_ROUNDS):
        for e in range(half):
            S[RATE + e] = S[XW + e] + _NUDGE * S[V + e]
        chain(flat)
        fastest = 0.0
        for lane in range(LANES):
            largest = 1e-30
            for j in range(half // LANES):
                e = j * LANES + lane
                S[V + e] = (S[ACCELERATION + e] - S[K1 + e]) / _NUDGE
                largest = max(largest, abs(S[V + e]))
            for j in range(half // LANES):
                S[V + j * LANES + lane] /= largest
            fastest = max(fastest, largest)
    return fastest


@compiled(_signature, **_called)
def integrate(  # type: ignore[no-untyped-def]
    chain, extra, bearing, again, S, n, states, active, known, commands_held, times, limits, max_steps, out, where
):
    """Integrate from ``times[0]`` and write the state at ``times`` into ``out``.

    Parameters
    ----------
    chain, extra, bearing, again : the compiled right-hand side; the extra torques; the two functions that replace the
        right-hand side if some extra torque needs the bearing forces. Without ``WHOLE`` these two are not used, and
        without ``EXTRA`` only the first is.
    S : the integrator's own numbers, and from ``WORKING`` on the workspace with initial state and parameters; the state
        rows are overwritten.
    states : rows of the memories, rows of their derivatives, factors (n_memory,) on their tolerance, ``bends``
        (n_memory, 2) of bristles and ``plays`` (n_memory, 3) of backlash, see ``turning_events``.
    active : (2, 2 + n_law) switches of the extra torques; all zero skips them. Row 0 excludes those that need the
        bearing force, row 1 includes them.
    known : times (m,) s and torques (m, n) N m that act on q, m = 0 for none; with servos also commands (rad on q),
        supplies (V) and switches, (m, 4 n) in all; and each column's tolerated deviation from a straight line within
        a step, ``HELD_STILL`` for commands that are held instead; commands_held : times (p,) s and commands (p, n) rad
        of these.
    times : (n_time,) s, increasing.
    limits : relative and absolute error per step (rad and rad/s), first step s; max_steps : accepted and rejected.
    out, where : (n_time * n_shown * width,) for the first ``n_shown`` rows of the state, in ``count`` lanes from
        ``first`` on; (n_shown, width, first, count). A count that is not constant lets LLVM vectorise the loop.

    Returns
    -------
    steps, reason : number of steps, and the reason for the end. Unless it is ``REACHED_END``, the remainder is nan.
    """
    state, derivative, factors, bends, plays = states
    links = LINKS if LINKS else n
    half = (links & MOST_LINKS) * LANES
    shown, wide, first, count = where
    flat = S[WORKING:]
    n_memory = 0
    any_bristle, any_play = False, False
    modes = (False, False)
    if WHOLE:
        n_memory = len(state) * LANES
        Z = flat.reshape(len(flat) // LANES, LANES)
        x, y = S[X : X + MEMORY + n_memory], S[Y : Y + MEMORY + n_memory]
        K = S[DERIVATIVES : DERIVATIVES + 7 * ROOM].reshape(7, ROOM)
        back, target = S[BACK : BACK + LANES], S[BACK + LANES : BACK + 2 * LANES]
        turns_room = S[BACK + 2 * LANES : BACK + 5 * LANES].reshape(3, LANES)
        slides, due, expected = S[SLIDES : SLIDES + n_memory], S[DUE : DUE + LANES], S[EXPECTED : EXPECTED + LANES]
        for lane in range(LANES):
            due[lane] = turning_events.NEVER
        for m in range(len(state)):
            any_bristle = any_bristle or bends[m, 0] >= 0
            any_play = any_play or plays[m, 0] >= 0
        any_active, any_load = False, False
        for index in range(active.shape[1]):
            any_active = any_active or active[0, index] != 0 or active[1, index] != 0
            any_load = any_load or active[0, index] != active[1, index]
        modes = (any_active, any_load)
        for m in range(len(state)):
            for lane in range(LANES):
                S[ALLOWED + MEMORY + m * LANES + lane] = factors[m]
                S[X + MEMORY + m * LANES + lane] = Z[state[m], lane]
    for e in range(half):
        S[TORQUE + e] = 0.0
        S[X + e] = S[ROTATION + e]
        S[XW + e] = S[RATE + e]
    for j in range(shown):
        for lane in range(count):
            out[j * wide + first + lane] = S[X + (j if j < links else j - links + MOST_LINKS) * LANES + lane]
    t = times[0]
    end = times[-1]
    h = min(limits[2], end - t)
    i = 1
    previous = 1e-4
    steps = 0
    reason = REACHED_END
    given = (derivative, active, modes, known)
    cursor, k1 = int64(0), int64(K1)  # typed values, because numba would recompile for each literal
    # Whether duties or commands are held; the step size before a cut at a change; place among the held commands.
    holds, wanted, sample = False, 0.0, int64(0)
    if WHOLE:
        holds = active[0, SERVOS] == HOLDING or active[0, SERVOS] == HOLDING + SHARING
        for j in range(n, min(2 * n, len(known[2]))):
            holds = holds or (active[0, SERVOS] != 0 and known[2][j] >= driven_steps.HELD_STILL)
    if WHOLE and holds:
        sample = driven_steps.hold_commands(flat, n, known, commands_held, t, True, sample)
    cursor = _derivative(chain, extra, bearing, again, S, flat, n, given, t, cursor, k1)
    if WHOLE and any_bristle:
        turning_events.slide_from_start(bends, Z, x, K)
        _put(S, int64(X), n, state)
        cursor = _derivative(chain, extra, bearing, again, S, flat, n, given, t, cursor, k1)
    decay, weights, exponents = 0.0, _WEIGHTS, _EXPONENTS
    if n_memory == 0:  # memories are integrated with one pair
        decay = _fastest_decay(chain, S, flat, half)
    any_event, cuts = any_bristle or any_play, 0
    most, patience, passed, nearest = MANY, 0, 0, 0.0  # number of knots of the known torque that a step may pass
    fresh, uncut = any_event, 0.0  # at a new state; the step size before it was cut at an event
    while i < len(times):
        if WHOLE and holds and driven_steps.next_look(flat, n, known) <= t + driven_steps.SAME_TIME:
            _put(S, int64(X), n, state)
            sample = driven_steps.hold_commands(flat, n, known, commands_held, t, False, sample)
            cursor = _derivative(chain, extra, bearing, again, S, flat, n, given, t, cursor, k1)
        if WHOLE and fresh:
            fresh = False
            for m in range(len(state)):
                turns = bends[m, 0] >= 0 and turning_events.find_reversals(bends, m, steps > 0, Z, x, K, back, target)
                meets = plays[m, 0] >= 0 and turning_events.close_contact(plays, m, Z, x, K, back)
                for k in range(1 if turns else 2, 3 if turns or meets else 0):
                    _put(S, int64(X), n, state)
                    if k == 1:
                        for lane in range(LANES):
                            if back[lane] != 0.0:
                                Z[state[m], lane] = target[lane]
                    cursor = _derivative(chain, extra, bearing, again, S, flat, n, given, t, cursor, K1 + k * ROOM)
                    if k == 1:
                        turning_events.hold_joint(bends, m, x, K, back, target)
                if turns:
                    turning_events.correct_reversal(n, bends, m, x, K, back)
                elif meets:
                    turning_events.correct_contact(n, x, K, back)
            turning_events.find_sliding(bends, Z, x, K, slides)
            turning_events.keep_sliding(slides, K[0])
        if t + h > end:
            h = end - t + 1e-15
        if WHOLE and holds:
            wanted, h = h, min(h, driven_steps.next_look(flat, n, known) - t)
        if WHOLE and len(known[0]) > 1:
            h, passed, nearest = driven_steps.within_torque(known, cursor, t, h, most)
        weights = _OF_DAMPED if h * decay > _FAST else _WEIGHTS
        exponents = _EXPONENTS_OF_DAMPED if h * decay > _FAST else _EXPONENTS
        for s in range(1, 7):
            stage(s, h, S, half, weights)
            now = t
            if WHOLE:
                now = t + h * weights[0][s]
                if n_memory > 0:
                    stage_of_memories(s, h, S, state)
            cursor = _derivative(chain, extra, bearing, again, S, flat, n, given, now, cursor, K1 + s * ROOM)
            if WHOLE and any_bristle:
                turning_events.keep_sliding(slides, K[s])
        steps += 1
        difference(h, S, limits[0], limits[1], half, weights)
        if WHOLE and n_memory > 0:
            difference_of_memories(h, bends, S, n_memory, limits[0], limits[1])
        error = hardest(S, links & MOST_LINKS, n_memory)
        if WHOLE and any_event and error <= 1.0:
            cut = turning_times.first_turn(bends, slides, Z, x, y, K, t, h, turns_room, expected)
            if any_play:
                cut = min(cut, turning_events.first_contact(plays, Z, x, y, K, h))
            if cut < h and cuts < MOST_CUTS:
                cuts += 1
                uncut, h = max(uncut, h), cut
                for lane in range(LANES):
                    due[lane] = expected[lane]
                continue
        if error <= 1.0:
            cuts = 0
            if times[i] <= t + h + 1e-12:
                i = samples(h, t, S, half, times, i, out, where, n_memory == 0, weights)
            t += h
            for e in range(half):
                S[X + e] = S[Y + e]
                S[XW + e] = S[YW + e]
                S[K1 + e] = S[K7 + e]
            if WHOLE:
                for e in range(n_memory):
                    S[X + MEMORY + e] = S[Y + MEMORY + e]
                    S[K1 + OF_RATES + e] = S[K7 + OF_RATES + e]
            fresh = any_event
            factor = min(_MOST, _SAFE * error ** -exponents[0] * previous ** exponents[1])
            if WHOLE and uncut > 0.0:
                # Continue to the next expected turn of a lane, otherwise with the step size before the cut.
                coming = turning_events.next_reversal(due, t)
                factor = min(coming - t, uncut) / h
                uncut = uncut if coming < t + uncut else 0.0
            if WHOLE and holds:
                factor = max(factor, wanted / h)
            previous = max(error, 1e-4)  # as ``dopri5``
            if WHOLE and most < MANY:
                patience -= 1
                if patience < 0:
                    most *= 2
        else:
            factor = max(_LEAST, _SAFE * error**-0.2)
            if WHOLE and passed > 0:  # the torque is smooth between knots, so the knots probably caused the error
                most, patience = max((passed + 1) // 2, 1), PATIENCE
                factor = max(factor, nearest / h)
        if not (factor > _LEAST):  # also if the error is nan
            factor = _LEAST
        h *= factor
        if i < len(times) and (h < 1e-10 or steps >= max_steps):
            reason = TOO_MANY_STEPS if steps >= max_steps else STEP_TOO_SMALL
            for k in range(i * shown, len(times) * shown):
                for lane in range(count):
                    out[k * wide + first + lane] = np.nan
            break
    return steps, reason
