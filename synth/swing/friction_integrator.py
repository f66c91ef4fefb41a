"""Explicit integration of legs with dry friction: sixteen trajectories with clocks of their own.

A step must end where a sliding joint turns (``turning_events``). If sixteen legs ended their steps together, each
would be cut at the turns of all the others. Here a lane in whose step a joint turns repeats it alone, up to the turn,
while the others go on: a leg takes its own steps and one or two more for each of its own turns. Different legs have
steps of different size; perturbed copies of a leg share it and are cut each at its own turn, so that they remain
smooth functions of the perturbation (``lane_clocks``).

Only for forces that do not depend on time: a known torque or a servo's command would have to be found for each lane.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import float64, int64, njit, types, uint64

from synth.compiling.compiled import compiled
from synth.compiling.numba_internals import UNCOUNTED
from synth.swing import lane_clocks, turning_events
from synth.swing.explicit_pairs import DORMAND_PRINCE
from synth.swing.explicit_steps import (
    ACCELERATION,
    ALLOWED,
    BACK,
    DERIVATIVES,
    K1,
    K7,
    MEMORY,
    OF_RATES,
    R1,
    R2,
    R3,
    R4,
    RATE,
    ROOM,
    ROTATION,
    SLIDES,
    TORQUE,
    XW,
    YW,
    X,
    Y,
    add_up,
    courses,
    difference,
    difference_of_memories,
    put_memories,
    stage,
    stage_of_memories,
)  # fmt: skip
from synth.swing.lane_clocks import CLOCK, COMING, CUT, CUTS, LEADER, LEAST_PREVIOUS, MOVED, OWN, PREVIOUS, SIZE, STEP
from synth.swing.lane_layout import LANES, LOAD_PASSES, MOST_LINKS, PLACE, WORKING
from synth.swing.turning_events import NEVER
from synth.swing.turning_times import turns_within

# Reasons of the end: as in ``chain_integrator``.
REACHED_END, TOO_MANY_STEPS, STEP_TOO_SMALL = 0, 1, 2
SAME_TIME = 1e-12  # s, of a sample and the end of a step
_WEIGHTS = DORMAND_PRINCE.weights

_chain = types.FunctionType(types.void(float64[::1]))
_extra = types.FunctionType(types.void(float64[::1], int64, int64[::1]))
_state = types.Tuple((uint64[::1], uint64[::1], float64[::1], int64[:, ::1], int64[:, ::1]))
_signature = types.UniTuple(int64, 2)(
    _chain, _extra, _chain, _chain, float64[::1], int64, _state, int64[:, ::1], float64[::1],
    types.UniTuple(float64, 3), int64, float64[::1], types.UniTuple(int64, 4),
)  # fmt: skip
_called: dict[str, Any] = {"fastmath": True, "error_model": "numpy", "nogil": True, **UNCOUNTED}


@njit(**_called)
def _derivative(chain, extra, bearing, again, S, n, given, K):  # type: ignore[no-untyped-def]
    """Write the derivatives of rates and memories at the state in the workspace to ``S`` from ``K`` on.

    Friction by load as in ``chain_integrator``.
    """
    derivative, active, any_load = given
    flat = S[WORKING:]
    extra(flat, n, active[0])
    if any_load:
        for _ in range(LOAD_PASSES):
            bearing(flat)
            extra(flat, n, active[1])
            again(flat)
    else:
        chain(flat)
    K = K & PLACE
    for e in range((n & MOST_LINKS) * LANES):
        S[K + e] = S[ACCELERATION + e]
    put_memories_back(S, K + OF_RATES, derivative)


@njit(**_called)
def put_memories_back(S, place, derivative):  # type: ignore[no-untyped-def]
    """Copy rows of the workspace to consecutive rows."""
    for m in range(len(derivative)):
        row, into = (WORKING + derivative[m] * LANES) & PLACE, (place + m * LANES) & PLACE
        for lane in range(LANES):
            S[into + lane] = S[row + lane]


@njit(**_called)
def _put(S, n, state):  # type: ignore[no-untyped-def]
    """Copy the state at the start of the steps to its rows of the workspace."""
    for e in range((n & MOST_LINKS) * LANES):
        S[ROTATION + e] = S[X + e]
        S[RATE + e] = S[XW + e]
    put_memories(S, X + MEMORY, state)


@njit(**_called)
def _accept(S, n, n_memory):  # type: ignore[no-untyped-def]
    """Move the states of lanes whose step is kept to its end."""
    for j in range(n & MOST_LINKS):
        for lane in range(LANES):
            e, kept = j * LANES + lane, S[MOVED + lane] != 0.0
            S[X + e] = S[Y + e] if kept else S[X + e]
            S[XW + e] = S[YW + e] if kept else S[XW + e]
            S[K1 + e] = S[K7 + e] if kept else S[K1 + e]
    for m in range(n_memory):
        for lane in range(LANES):
            e, kept = (m * LANES & PLACE) + lane, S[MOVED + lane] != 0.0
            S[X + MEMORY + e] = S[Y + MEMORY + e] if kept else S[X + MEMORY + e]
            S[K1 + OF_RATES + e] = S[K7 + OF_RATES + e] if kept else S[K1 + OF_RATES + e]


@njit(**_called)
def _samples(S, n, times, out, where):  # type: ignore[no-untyped-def]
    """Write each lane's samples within its step, if that is kept."""
    shown, wide, first, count = where
    for lane in range(count):
        begin, t, h = int64(S[COMING + lane]) & PLACE, S[CLOCK + lane], S[OWN + lane]
        last = begin
        while S[MOVED + lane] != 0.0 and last < len(times) and times[last] <= t + h + SAME_TIME:
            last += 1
        if last == begin:
            continue
        S[COMING + lane], share = last, 1.0 / h
        for j in range(shown):
            e = ((j if j < n else j - n + MOST_LINKS) * LANES + lane) & PLACE
            at_start, rise, bow, skew, top = S[X + e], S[R1 + e], S[R2 + e], S[R3 + e], S[R4 + e]
            place = ((begin * shown + j) * wide + first + lane) & PLACE
            for i in range(begin, last):
                p = (times[i] - t) * share
                u = 1.0 - p
                out[place] = at_start + p * (rise + u * (bow + p * (skew + u * top)))
                place = (place + shown * wide) & PLACE


@njit(**_called)
def _begin(S, n, state, factors, times, first_step, out, where):  # type: ignore[no-untyped-def]
    """Take the state at the start from the workspace, show it, and set the lanes' clocks."""
    shown, wide, first, count = where
    for m in range(len(state)):
        row, place = (WORKING + state[m] * LANES) & PLACE, (X + MEMORY + m * LANES) & PLACE
        for lane in range(LANES):
            S[ALLOWED - X + place + lane] = factors[m]
            S[place + lane] = S[row + lane]
    for e in range((n & MOST_LINKS) * LANES):
        S[TORQUE + e] = 0.0
        S[X + e] = S[ROTATION + e]
        S[XW + e] = S[RATE + e]
    for lane in range(LANES):
        S[CLOCK + lane], S[CUT + lane], S[CUTS + lane] = times[0], NEVER, 0.0
        S[MOVED + lane], S[COMING + lane], S[PREVIOUS + lane] = 1.0, 1.0, LEAST_PREVIOUS
        S[SIZE + lane] = min(first_step, times[-1] - times[0])
        for j in range(shown if lane < count else 0):
            out[j * wide + first + lane] = S[X + (j if j < n else j - n + MOST_LINKS) * LANES + lane]


@njit(**_called)
def _turn_joints(chain, extra, bearing, again, S, n, given, state, bends, started, Z, x, K, slides):  # type: ignore[no-untyped-def]
    """Reverse or hold the joints that turn at the present states of the lanes that have just moved there."""
    back, target = S[BACK : BACK + LANES], S[BACK + LANES : BACK + 2 * LANES]
    for m in range(len(state)):
        if bends[m, 0] < 0 or not turning_events.find_reversals(bends, m, started, Z, x, K, back, target):
            continue
        for k in range(1, 3):
            _put(S, n, state)
            for lane in range(LANES):
                back[lane] = back[lane] if S[MOVED + lane] != 0.0 else 0.0
                if k == 1 and back[lane] != 0.0:
                    Z[state[m], lane] = target[lane]
            _derivative(chain, extra, bearing, again, S, n, given, K1 + k * ROOM)
            if k == 1:
                turning_events.hold_joint(bends, m, x, K, back, target)
        turning_events.correct_reversal(n, bends, m, x, K, back)
    turning_events.find_sliding(bends, Z, x, K, slides)
    turning_events.keep_sliding(slides, K[0])


@njit(**_called)
def _give_up(S, times, out, where):  # type: ignore[no-untyped-def]
    """Write nan to the samples that are left."""
    shown, wide, first, count = where
    for lane in range(count):
        for k in range(int64(S[COMING + lane]) * shown, len(times) * shown):
            out[k * wide + first + lane] = np.nan


@compiled(_signature, **_called)
def integrate_rubbing(  # type: ignore[no-untyped-def]
    chain, extra, bearing, again, S, n, states, active, times, limits, max_steps, out, where
):
    """Integrate legs with bristles; arguments and results as of ``chain_integrator.integrate``.

    ``max_steps`` bounds the steps of all lanes at once, of which some may be repeated by one lane only.
    """
    state, derivative, factors, bends, _ = states
    half, n_memory = (n & MOST_LINKS) * LANES, len(state) * LANES
    Z = S[WORKING:].reshape((len(S) - WORKING) // LANES, LANES)
    x, y = S[X : X + MEMORY + n_memory], S[Y : Y + MEMORY + n_memory]
    K = S[DERIVATIVES : DERIVATIVES + 7 * ROOM].reshape(7, ROOM)
    slides = S[SLIDES : SLIDES + n_memory]
    own, cut, leader = S[OWN : OWN + LANES], S[CUT : CUT + LANES], S[LEADER : LEADER + LANES]
    any_load = False
    for index in range(active.shape[1]):
        any_load = any_load or active[0, index] != active[1, index]
    given, k1 = (derivative, active, any_load), int64(K1)
    _begin(S, n, state, factors, times, limits[2], out, where)
    _derivative(chain, extra, bearing, again, S, n, given, k1)
    turning_events.slide_from_start(bends, Z, x, K)
    _put(S, n, state)
    _derivative(chain, extra, bearing, again, S, n, given, k1)
    lane_clocks.find_leaders(n, S)
    steps, reason, under_way, fresh = 0, REACHED_END, True, True
    while under_way:
        if fresh:
            _turn_joints(chain, extra, bearing, again, S, n, given, state, bends, steps > 0, Z, x, K, slides)
        lane_clocks.own_steps(times[-1], S, max(n, len(state)))
        for s in range(1, 7):
            stage(s, STEP, S, half, _WEIGHTS)
            stage_of_memories(s, STEP, S, state)
            _derivative(chain, extra, bearing, again, S, n, given, K1 + s * ROOM)
            turning_events.keep_sliding(slides, K[s])
        steps += 1
        difference(STEP, S, limits[0], limits[1], half, _WEIGHTS)
        difference_of_memories(STEP, bends, S, n_memory, limits[0], limits[1])
        add_up(S, n & MOST_LINKS, n_memory)
        lane_clocks.find_errors(S, 2 * n + len(state))
        turns_within(bends, slides, Z, x, y, K, own, cut, leader)
        fresh = lane_clocks.keep(S)
        if fresh:
            courses(STEP, S, half, where[0] > n, False, _WEIGHTS)
            _samples(S, n, times, out, where)
            _accept(S, n, len(state))
            under_way = not lane_clocks.advance(times[-1], S)
        least = lane_clocks.resize(S)
        if under_way and (least < 1e-10 or steps >= max_steps):
            reason = TOO_MANY_STEPS if steps >= max_steps else STEP_TOO_SMALL
            _give_up(S, times, out, where)
            break
    return steps, reason
