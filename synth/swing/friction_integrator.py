"""Explicit integration of legs with dry friction: sixteen trajectories with one step size and clocks of their own.

A step must end where a sliding joint turns (``turning_events``). If sixteen legs ended their steps together, each
would be cut at the turns of all the others. Here a lane in whose step a joint turns repeats it alone, up to the turn,
while the others go on: a leg takes its own steps and one or two more for each of its own turns. The step size of all
lanes that need no shorter one follows the largest error, as in ``chain_integrator``. So perturbed copies of a leg take
the same steps, each cut at its own turn, and remain smooth functions of the perturbation.

Only for forces that do not depend on time: a known torque or a servo's command would have to be found for each lane.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import float64, int64, njit, types, uint64

from synth.compiling.compiled import compiled
from synth.compiling.numba_internals import UNCOUNTED
from synth.swing import turning_events
from synth.swing.explicit_steps import (
    ACCELERATION,
    ALLOWED,
    BACK,
    DERIVATIVES,
    DUE,
    K1,
    K7,
    MEMORY,
    OF_RATES,
    PLACE,
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
    V,
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
from synth.swing.lane_layout import LANES, MOST_LINKS, WORKING
from synth.swing.turning_events import NEVER
from synth.swing.turning_times import turns_within

# Step control and reasons of the end: as in ``chain_integrator``.
_SAFE, _LEAST, _MOST = 0.85, 0.2, 5.0
LEAST_PREVIOUS = 1e-4 ** (5 / 128)
REACHED_END, TOO_MANY_STEPS, STEP_TOO_SMALL = 0, 1, 2
MOST_CUTS = 20  # of one step of a lane, as in ``chain_integrator``
# Differences of two starts that count as those of a leg and its perturbed copy: rad, rad/s, rad/s^2, and a share of the
# accelerations.
ALIKE_ANGLE, ALIKE_RATE, ALIKE_ACCELERATION, ALIKE_SHARE = 0.01, 0.3, 10.0, 0.02
SAME_TIME = 1e-12  # s, of a sample and the end of a step

# Places of numbers of the lanes: their own step, clock and size of the steps, s; the time from the start of the step to
# a turn, s, and how often it was cut there; 1 if the step was kept; the index of the next sample; the share of the
# tolerance and a power of the last one; the lane with the same size of steps.
OWN, CLOCK, SIZE, CUT, CUTS, MOVED, COMING, ERROR, PREVIOUS, LEADER, LONGEST, ANY_MOVED = (
    BACK + k * LANES for k in range(2, 14)
)

STEP = DUE  # of each entry of a state, s

_chain = types.FunctionType(types.void(float64[::1]))
_extra = types.FunctionType(types.void(float64[::1], int64, int64[::1]))
_state = types.Tuple((uint64[::1], uint64[::1], float64[::1], int64[:, ::1], int64[:, ::1]))
_signature = types.UniTuple(int64, 2)(
    _chain, _extra, _chain, _chain, float64[::1], int64, _state, int64[:, ::1], float64[::1],
    types.UniTuple(float64, 3), int64, float64[::1], types.UniTuple(int64, 4),
)  # fmt: skip
_called: dict[str, Any] = {"fastmath": True, "error_model": "numpy", "nogil": True, **UNCOUNTED}
_once: dict[str, Any] = {"inline": "always", **_called}


@njit(**_called)
def _derivative(chain, extra, bearing, again, S, n, given, K):  # type: ignore[no-untyped-def]
    """Write the derivatives of rates and memories at the state in the workspace to ``S`` from ``K`` on.

    As in ``chain_integrator``, friction by load takes the bearing forces without it.
    """
    derivative, active, any_load = given
    flat = S[WORKING:]
    extra(flat, n, active[0])
    if any_load:
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
def _find_leaders(n, S):  # type: ignore[no-untyped-def]
    """Find for each lane the first that starts as it does: perturbed copies of a leg have one leader."""
    for lane in range(LANES):
        S[LEADER + lane] = lane
        for other in range(lane):
            alike, difference, total = S[LEADER + other] == other, 0.0, ALIKE_ACCELERATION / ALIKE_SHARE
            for i in range(n):
                a, b = i * LANES + lane, i * LANES + other
                alike = alike and abs(S[X + a] - S[X + b]) < ALIKE_ANGLE and abs(S[XW + a] - S[XW + b]) < ALIKE_RATE
                difference += abs(S[K1 + a] - S[K1 + b])
                total += abs(S[K1 + a]) + abs(S[K1 + b])
            if alike and difference < ALIKE_SHARE * total:
                S[LEADER + lane] = other
                break


@njit(**_called)
def _own_steps(end, S, rows):  # type: ignore[no-untyped-def]
    """Find each lane's step: its size, up to its turn or the end; 0 of a lane that is at the end.

    It is written to so many rows, for all states.
    """
    for lane in range(LANES):
        S[OWN + lane] = min(S[CUT + lane] if S[CUT + lane] < NEVER else S[SIZE + lane], end - S[CLOCK + lane])
    for j in range(rows):
        for lane in range(LANES):
            S[STEP + (j * LANES & PLACE) + lane] = S[OWN + lane]


@njit(**_called)
def _find_errors(S, n_state):  # type: ignore[no-untyped-def]
    """Find for each lane the largest ratio of error to tolerance of all lanes with the same leader."""
    share = 1.0 / n_state
    for lane in range(LANES):
        S[V + lane] = S[V + lane] * share
        S[ERROR + lane] = 1e-24
    for lane in range(LANES):
        first = ERROR + (int64(S[LEADER + lane]) & (LANES - 1))
        S[first] = S[first] if S[V + lane] <= S[first] else S[V + lane]  # nan stays
    for lane in range(LANES):
        S[V + lane] = S[ERROR + (int64(S[LEADER + lane]) & (LANES - 1))]
    for lane in range(LANES):
        S[ERROR + lane] = math.sqrt(S[V + lane])


@njit(**_called)
def _keep(S):  # type: ignore[no-untyped-def]
    """Decide which lanes keep their step: those without a turn within it whose error is allowed. Whether any does."""
    kept = 0.0
    for lane in range(LANES):
        good, turns = S[ERROR + lane] <= 1.0, S[CUT + lane] < NEVER
        cuts = S[CUTS + lane] + (1.0 if good & turns else 0.0)
        moved = good & (S[OWN + lane] > 0.0) & ((not turns) | (cuts > MOST_CUTS))
        S[CUT + lane] = S[CUT + lane] if good & (not moved) else NEVER
        S[CUTS + lane] = 0.0 if moved else cuts
        S[MOVED + lane] = 1.0 if moved else 0.0
        kept += S[MOVED + lane]
    return kept > 0.0


@njit(**_called)
def _advance(end, S):  # type: ignore[no-untyped-def]
    """Move the clocks of the lanes that keep their step; whether all are at the end."""
    under_way = 0.0
    for lane in range(LANES):
        left = end - S[CLOCK + lane]
        moved = end if S[OWN + lane] >= left else S[CLOCK + lane] + S[OWN + lane]
        S[CLOCK + lane] = moved if S[MOVED + lane] != 0.0 else S[CLOCK + lane]
        under_way += 1.0 if S[CLOCK + lane] < end else 0.0
    return under_way == 0.0


@njit(**_called)
def _resize(S):  # type: ignore[no-untyped-def]
    """Change the size of each lane's steps by its error; returns the smallest. Lanes with one leader have one size.

    As in ``chain_integrator``, but powers are products of square roots, which are vectorised: the exponents are 11/64
    and 5/128 for 0.17 and 0.04, and 13/64 for 0.2.
    """
    for lane in range(LANES):
        S[LONGEST + lane], S[ANY_MOVED + lane] = 0.0, 0.0
    for lane in range(LANES):
        first = int64(S[LEADER + lane]) & (LANES - 1)
        S[LONGEST + first] = max(S[LONGEST + first], S[OWN + lane])
        S[ANY_MOVED + first] = max(S[ANY_MOVED + first], S[MOVED + lane])
    for lane in range(LANES):
        error, own, size = S[ERROR + lane], S[LONGEST + lane], S[SIZE + lane]
        good, moved = error <= 1.0, S[ANY_MOVED + lane] > 0.0
        known = max(error if error < 1e12 else 1e12, 1e-12)  # also if it is nan
        eighth = math.sqrt(math.sqrt(math.sqrt(known)))
        of_16 = math.sqrt(eighth)
        of_32 = math.sqrt(of_16)
        of_64 = math.sqrt(of_32)
        rising = max(_LEAST, min(_MOST, _SAFE * S[PREVIOUS + lane] / (eighth * of_32 * of_64)))
        falling = max(_LEAST, _SAFE / (eighth * of_16 * of_64))
        # A step that was cut at a turn tells only that the next may be longer than it.
        grown = max(own * rising, size if own < size else 0.0)
        S[PREVIOUS + lane] = max(of_32 * math.sqrt(of_64), LEAST_PREVIOUS) if moved else S[PREVIOUS + lane]
        S[SIZE + lane] = grown if moved else (size if good | (own == 0.0) else own * falling)
    least = NEVER
    for lane in range(LANES):
        S[SIZE + lane] = S[SIZE + int64(S[LEADER + lane])]
        least = min(least, S[SIZE + lane])
    return least


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


@compiled(_signature, **_called)
def integrate_rubbing(  # type: ignore[no-untyped-def]
    chain, extra, bearing, again, S, n, states, active, times, limits, max_steps, out, where
):
    """Integrate legs with bristles; arguments and results as of ``chain_integrator.integrate``.

    ``max_steps`` bounds the common steps and those that a lane repeats alone together.
    """
    state, derivative, factors, bends, _ = states
    half, n_memory = (n & MOST_LINKS) * LANES, len(state) * LANES
    shown, wide, first, count = where
    Z = S[WORKING:].reshape((len(S) - WORKING) // LANES, LANES)
    x, y = S[X : X + MEMORY + n_memory], S[Y : Y + MEMORY + n_memory]
    K = S[DERIVATIVES : DERIVATIVES + 7 * ROOM].reshape(7, ROOM)
    slides = S[SLIDES : SLIDES + n_memory]
    back, target = S[BACK : BACK + LANES], S[BACK + LANES : BACK + 2 * LANES]
    own, cut, leader = S[OWN : OWN + LANES], S[CUT : CUT + LANES], S[LEADER : LEADER + LANES]
    any_load = False
    for index in range(active.shape[1]):
        any_load = any_load or active[0, index] != active[1, index]
    for m in range(len(state)):
        for lane in range(LANES):
            S[ALLOWED + MEMORY + m * LANES + lane] = factors[m]
            S[X + MEMORY + m * LANES + lane] = Z[state[m], lane]
    for e in range(half):
        S[TORQUE + e] = 0.0
        S[X + e] = S[ROTATION + e]
        S[XW + e] = S[RATE + e]
    for lane in range(LANES):
        S[CLOCK + lane], S[CUT + lane], S[CUTS + lane], S[MOVED + lane], S[COMING + lane] = (
            times[0],
            NEVER,
            0.0,
            1.0,
            1.0,
        )
        S[SIZE + lane], S[PREVIOUS + lane] = min(limits[2], times[-1] - times[0]), LEAST_PREVIOUS
        for j in range(shown if lane < count else 0):
            out[j * wide + first + lane] = S[X + (j if j < n else j - n + MOST_LINKS) * LANES + lane]
    end, steps, reason, under_way, fresh = times[-1], 0, REACHED_END, True, True
    given, k1 = (derivative, active, any_load), int64(K1)
    _derivative(chain, extra, bearing, again, S, n, given, k1)
    turning_events.slide_from_start(bends, Z, x, K)
    _put(S, n, state)
    _derivative(chain, extra, bearing, again, S, n, given, k1)
    _find_leaders(n, S)
    while under_way:
        if fresh:
            for m in range(len(state)):
                if bends[m, 0] < 0 or not turning_events.find_reversals(bends, m, steps > 0, Z, x, K, back, target):
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
        _own_steps(end, S, max(n, len(state)))
        for s in range(1, 7):
            stage(s, STEP, S, half)
            stage_of_memories(s, STEP, S, state)
            _derivative(chain, extra, bearing, again, S, n, given, K1 + s * ROOM)
            turning_events.keep_sliding(slides, K[s])
        steps += 1
        difference(STEP, S, limits[0], limits[1], half)
        difference_of_memories(STEP, bends, S, n_memory, limits[0], limits[1])
        add_up(S, n & MOST_LINKS, n_memory)
        _find_errors(S, 2 * n + len(state))
        turns_within(bends, slides, Z, x, y, K, own, cut, leader)
        fresh = _keep(S)
        if fresh:
            courses(STEP, S, half, shown > n)
            _samples(S, n, times, out, where)
            _accept(S, n, len(state))
            under_way = not _advance(end, S)
        least = _resize(S)
        if under_way and (least < 1e-10 or steps >= max_steps):
            reason = TOO_MANY_STEPS if steps >= max_steps else STEP_TOO_SMALL
            for lane in range(count):
                for k in range(int64(S[COMING + lane]) * shown, len(times) * shown):
                    out[k * wide + first + lane] = np.nan
            break
    return steps, reason
