"""Pieces of an explicit Runge-Kutta step for sixteen lanes: stages, estimated error, dense output.

They are inlined into ``chain_integrator``. ``S`` is its array: the blocks named here, then the workspace of
``lane_layout``. The length ``half`` of the loops is n_link * 16. Sums are written out, because a loop would store and
load the partial sum at each term; angles take the accelerations themselves, see ``explicit_pairs``. ``weights`` : those
of a pair, see ``RungeKuttaPair.weights``.
"""

from __future__ import annotations

import math
from typing import Any

from numba import njit, types
from numba.extending import overload

from synth.compiling.numba_internals import UNCOUNTED
from synth.swing import turning_events
from synth.swing.explicit_pairs import DORMAND_PRINCE
from synth.swing.lane_layout import LANES, MOST_LINKS, MOST_MEMORIES, PLACE, ROOMS, WORKING, Layout

# Weights of the memories; legs with memories are integrated with this pair only.
_, _A1, _A2, _A3, _A4, _A5, _A6 = DORMAND_PRINCE.stages
_E = DORMAND_PRINCE.error

# First indices of these blocks of the workspace, the same for every number of links, and of the links' states there.
ROTATION, RATE, ACCELERATION, TORQUE = (
    WORKING + Layout(1).row(block) * LANES for block in ("rotation", "rate", "acceleration", "extra_torque")
)
# The integrator's own blocks: rooms for a state, of ``MOST_LINKS`` angles, as many rates, and the memories. Derivatives
# have no angles' part, because it is a state's rates.
MEMORY = 2 * MOST_LINKS * LANES
ROOM = MEMORY + MOST_MEMORIES * LANES
X, Y, V, R1, R2, R3, R4, R5, ALLOWED, SLIDES, DUE, EXPECTED, BACK = (k * ROOM for k in range(ROOMS - 7))
OF_RATES = MOST_LINKS * LANES
DERIVATIVES = (ROOMS - 7) * ROOM
K1, K2, K3, K4, K5, K6, K7 = (DERIVATIVES + k * ROOM + OF_RATES for k in range(7))
XW, YW, VW = X + OF_RATES, Y + OF_RATES, V + OF_RATES
# Of the memories in these rooms.
_X, _Y, _V, _ALLOWED = (room + MEMORY for room in (X, Y, V, ALLOWED))
_M1, _M2, _M3, _M4, _M5, _M6, _M7 = (DERIVATIVES + k * ROOM + MEMORY for k in range(7))
_called: dict[str, Any] = {"fastmath": True, "error_model": "numpy", "nogil": True, **UNCOUNTED}
# numba inlines functions with one call site, because LLVM would call them with forty arguments.
_once: dict[str, Any] = {"inline": "always", **_called}


def of_lane(step: Any, S: Any, e: int) -> Any:
    """The step (s) of entry ``e``: ``step`` itself, or where lanes have steps of their own and it is their place."""
    return S[step + e] if isinstance(step, int) else step


@overload(of_lane, inline="always", jit_options=_called)
def _of_lane(step, S, e):  # type: ignore[no-untyped-def]
    """The same for compiled code."""
    return (lambda step, S, e: S[step + e]) if isinstance(step, types.Integer) else (lambda step, S, e: step)


@njit(**_called)
def put_memories(S, x, state):  # type: ignore[no-untyped-def]
    """Copy memories to their rows of the workspace."""
    for m in range(len(state)):
        row, place = (WORKING + state[m] * LANES) & PLACE, (x + m * LANES) & PLACE
        for lane in range(LANES):
            S[row + lane] = S[place + lane]


@njit(inline="never", **_called)
def stage_of_memories(s, step, S, state):  # type: ignore[no-untyped-def]
    """The same for memories; their stage is in ``Y``."""
    size = len(state) * LANES
    if s == 1:
        for e in range(size):
            h = of_lane(step, S, e)
            S[_Y + e] = S[_X + e] + h * (_A1[0] * S[_M1 + e])
    elif s == 2:
        for e in range(size):
            h = of_lane(step, S, e)
            S[_Y + e] = S[_X + e] + h * (_A2[0] * S[_M1 + e] + _A2[1] * S[_M2 + e])
    elif s == 3:
        for e in range(size):
            h = of_lane(step, S, e)
            S[_Y + e] = S[_X + e] + h * (_A3[0] * S[_M1 + e] + _A3[1] * S[_M2 + e] + _A3[2] * S[_M3 + e])
    elif s == 4:
        for e in range(size):
            h = of_lane(step, S, e)
            first = _A4[0] * S[_M1 + e] + _A4[1] * S[_M2 + e]
            S[_Y + e] = S[_X + e] + h * (first + _A4[2] * S[_M3 + e] + _A4[3] * S[_M4 + e])
    elif s == 5:
        for e in range(size):
            h = of_lane(step, S, e)
            first = _A5[0] * S[_M1 + e] + _A5[1] * S[_M2 + e]
            S[_Y + e] = S[_X + e] + h * (first + _A5[2] * S[_M3 + e] + _A5[3] * S[_M4 + e] + _A5[4] * S[_M5 + e])
    else:
        for e in range(size):
            h = of_lane(step, S, e)
            first = _A6[0] * S[_M1 + e] + _A6[2] * S[_M3 + e]
            S[_Y + e] = S[_X + e] + h * (first + _A6[3] * S[_M4 + e] + _A6[4] * S[_M5 + e] + _A6[5] * S[_M6 + e])
    put_memories(S, Y + MEMORY, state)


@njit(inline="never", **_called)
def difference_of_memories(step, bends, S, n_memory, relative, absolute):  # type: ignore[no-untyped-def]
    """Write the same of memories to their part of ``V``; clips bends."""
    y, v = S[Y : Y + ROOM], S[V : V + ROOM]
    for e in range(n_memory):
        h = of_lane(step, S, e)
        first = _E[0] * S[_M1 + e] + _E[2] * S[_M3 + e] + _E[3] * S[_M4 + e]
        S[_V + e] = h * (first + _E[4] * S[_M5 + e] + _E[5] * S[_M6 + e] + _E[6] * S[_M7 + e])
    turning_events.bound_bends(bends, y, v)
    for e in range(n_memory):
        share = S[_V + e] / (S[_ALLOWED + e] * (absolute + relative * max(abs(S[_X + e]), abs(S[_Y + e]))))
        S[_V + e] = share * share


@njit(**_once)
def add_up(S, links, n_memory):  # type: ignore[no-untyped-def]
    """Add the squared ratios of error to tolerance of all states to the first sixteen entries of ``V``, one a lane."""
    for j in range(1, links):
        for lane in range(LANES):
            S[V + lane] += S[V + j * LANES + lane]
    for m in range(n_memory // LANES):
        for lane in range(LANES):
            S[V + lane] += S[V + MEMORY + m * LANES + lane]


@njit(**_once)
def hardest(S, links, n_memory):  # type: ignore[no-untyped-def]
    """The largest ratio of estimated error to tolerance over all lanes."""
    add_up(S, links, n_memory)
    largest = 1e-30
    for lane in range(LANES):
        largest = max(largest, S[V + lane])
    return math.sqrt(largest / (2 * links + n_memory // LANES))


@njit(**_once)
def stage(s, step, S, half, weights):  # type: ignore[no-untyped-def]
    """Write angles and rates of stage ``s`` to the workspace; those of 6, the end of the step, to ``Y`` too."""
    C, A, B, _, _, _, _ = weights
    if s == 1:
        for e in range(half):
            h = of_lane(step, S, e)
            w, a1 = S[XW + e], S[K1 + e]
            S[ROTATION + e] = S[X + e] + h * (C[1] * w)
            S[RATE + e] = w + h * (A[0][0] * a1)
    elif s == 2:
        for e in range(half):
            h = of_lane(step, S, e)
            w, a1 = S[XW + e], S[K1 + e]
            S[ROTATION + e] = S[X + e] + h * (C[2] * w + h * (B[1][0] * a1))
            S[RATE + e] = w + h * (A[1][0] * a1 + A[1][1] * S[K2 + e])
    elif s == 3:
        for e in range(half):
            h = of_lane(step, S, e)
            w, a1, a2 = S[XW + e], S[K1 + e], S[K2 + e]
            S[ROTATION + e] = S[X + e] + h * (C[3] * w + h * (B[2][0] * a1 + B[2][1] * a2))
            S[RATE + e] = w + h * (A[2][0] * a1 + A[2][1] * a2 + A[2][2] * S[K3 + e])
    elif s == 4:
        for e in range(half):
            h = of_lane(step, S, e)
            w, a1, a2, a3 = S[XW + e], S[K1 + e], S[K2 + e], S[K3 + e]
            S[ROTATION + e] = S[X + e] + h * (C[4] * w + h * (B[3][0] * a1 + B[3][1] * a2 + B[3][2] * a3))
            S[RATE + e] = w + h * (A[3][0] * a1 + A[3][1] * a2 + A[3][2] * a3 + A[3][3] * S[K4 + e])
    elif s == 5:
        for e in range(half):
            h = of_lane(step, S, e)
            w, a1, a2, a3, a4 = S[XW + e], S[K1 + e], S[K2 + e], S[K3 + e], S[K4 + e]
            turned = B[4][0] * a1 + B[4][1] * a2 + B[4][2] * a3 + B[4][3] * a4
            S[ROTATION + e] = S[X + e] + h * (w + h * turned)
            S[RATE + e] = w + h * (A[4][0] * a1 + A[4][1] * a2 + A[4][2] * a3 + A[4][3] * a4 + A[4][4] * S[K5 + e])
    else:
        for e in range(half):
            h = of_lane(step, S, e)
            w, a1, a3, a4, a5 = S[XW + e], S[K1 + e], S[K3 + e], S[K4 + e], S[K5 + e]
            q = S[X + e] + h * (w + h * (B[5][0] * a1 + B[5][2] * a3 + B[5][3] * a4 + B[5][4] * a5))
            w += h * (A[5][0] * a1 + A[5][2] * a3 + A[5][3] * a4 + A[5][4] * a5 + A[5][5] * S[K6 + e])
            S[Y + e] = q
            S[YW + e] = w
            S[ROTATION + e] = q
            S[RATE + e] = w


@njit(**_once)
def difference(step, S, relative, absolute, half, weights):  # type: ignore[no-untyped-def]
    """Write the squared ratios of estimated error to tolerance of angles and rates together to ``V``."""
    _, _, _, E, EE, _, _ = weights
    for e in range(half):
        h = of_lane(step, S, e)
        a1, a3, a4, a5, a6 = S[K1 + e], S[K3 + e], S[K4 + e], S[K5 + e], S[K6 + e]
        q = h * h * (EE[0] * a1 + EE[2] * a3 + EE[3] * a4 + EE[4] * a5 + EE[5] * a6)
        w = h * (E[0] * a1 + E[2] * a3 + E[3] * a4 + E[4] * a5 + E[5] * a6 + E[6] * S[K7 + e])
        q /= absolute + relative * max(abs(S[X + e]), abs(S[Y + e]))
        w /= absolute + relative * max(abs(S[XW + e]), abs(S[YW + e]))
        S[V + e] = q * q + w * w


@njit(**_once)
def courses(step, S, half, with_rates, smooth, weights):  # type: ignore[no-untyped-def]
    """Write the coefficients of the angles' courses over the step to ``R1`` to ``R5``, also the rates' if wanted.

    The dense output, or of ``smooth`` courses Hermite's polynomial of degree 5 with the angles, rates and accelerations
    of both ends, which is nearer. Not with friction, where fits stopped early with it (``test_many_minima``), probably
    because the acceleration at a step's end where a joint turns is that after the turn.
    """
    D, DD = weights[5], weights[6]
    for e in range(half):
        h = of_lane(step, S, e)
        a1, a3, a4, a5, a6 = S[K1 + e], S[K3 + e], S[K4 + e], S[K5 + e], S[K6 + e]
        dy = S[Y + e] - S[X + e]
        bs = h * S[XW + e] - dy
        skew = dy - h * S[YW + e] - bs
        S[R1 + e] = dy
        S[R2 + e] = bs
        S[R3 + e] = skew
        if smooth:
            first = 0.5 * h * h * a1 + bs - skew
            S[R4 + e] = first
            S[R5 + e] = 0.5 * h * h * S[K7 + e] + bs + 2.0 * skew - first
        else:
            S[R4 + e] = h * h * (DD[0] * a1 + DD[2] * a3 + DD[3] * a4 + DD[4] * a5 + DD[5] * a6)
            S[R5 + e] = 0.0
    if with_rates:
        for e in range(half):
            h = of_lane(step, S, e)
            a1, a3, a4, a5, a6 = S[K1 + e], S[K3 + e], S[K4 + e], S[K5 + e], S[K6 + e]
            a7, dy = S[K7 + e], S[YW + e] - S[XW + e]
            bs = h * a1 - dy
            S[R1 + OF_RATES + e] = dy
            S[R2 + OF_RATES + e] = bs
            S[R3 + OF_RATES + e] = dy - h * a7 - bs
            S[R5 + OF_RATES + e] = 0.0
            S[R4 + OF_RATES + e] = h * (D[0] * a1 + D[2] * a3 + D[3] * a4 + D[4] * a5 + D[5] * a6 + D[6] * a7)


@njit(**_once)
def samples(h, t, S, half, times, i, out, where, smooth, weights):  # type: ignore[no-untyped-def]
    """Write the samples from ``times[i]`` on that lie within the step; returns the index of the next one."""
    shown, wide, first, count = where
    courses(h, S, half, shown * LANES > half, smooth, weights)
    while i < len(times) and times[i] <= t + h + 1e-12:
        p = (times[i] - t) / h
        u = 1.0 - p
        for part in range(shown * LANES // half):
            place, row = ((i * shown + part * (half // LANES)) * wide + first) & PLACE, (part * OF_RATES) & PLACE
            for _ in range(half // LANES):
                for lane in range(count):
                    e = row + lane
                    tail = S[R2 + e] + p * (S[R3 + e] + u * (S[R4 + e] + p * S[R5 + e]))
                    out[place + lane] = S[X + e] + p * (S[R1 + e] + u * tail)
                place = (place + wide) & PLACE
                row = (row + LANES) & PLACE
        i += 1
    return i
