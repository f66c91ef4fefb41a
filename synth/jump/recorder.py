"""Sixteen jumps in parallel as recorded by an encoder and a force plate: chosen rows at given times.

Uses the pair of ``synth.jump.jump_integrator``. Angles and heights are interpolated between steps
by cubic Hermite polynomials, other outputs of the right-hand side linearly; no step is longer than
``LONGEST``. Lanes share every step, so differences between them are smooth for any step size.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import float64, int64, types

from synth.compiling.compiled import compiled
from synth.jump.jump_layout import LANES
from synth.jump.jump_step import ROOM, compiled_step

LONGEST = 1e-3  # s: at least one step per row of a figure's table
_rhs = types.FunctionType(types.void(float64[:, ::1]))
_signature = int64(
    _rhs, float64[:, ::1], int64[::1], int64[::1], float64[:, ::1], float64, float64, int64, float64[:, :, ::1]
)
# Fast, but without assuming finite numbers: a lane may diverge beside others that do not.
_rules: dict[str, Any] = {
    "fastmath": {"nsz", "arcp", "contract", "afn", "reassoc"}, "error_model": "numpy", "nogil": True,
}  # fmt: skip
views, try_step, take = compiled_step(_rules)


@compiled(_signature, **_rules)
def record(rhs, Z, where, rows, times, tolerance, first_step, max_steps, out):  # type: ignore[no-untyped-def]
    """Integrate from the crouch to the last time of all lanes.

    Parameters
    ----------
    rhs : the compiled right-hand side.
    Z : (n_row, 16) workspace with initial state and parameters.
    where : rows: n_state, derivative, alive, normal.
    rows : (m,) rows to record.
    times : (n, 16) s, rising; before 0 the leg is at rest.
    tolerance : as in ``jump_integrator.jump``.
    max_steps : accepted and rejected; later times stay nan.
    out : (n, m, 16) filled in.

    Returns
    -------
    Number of steps.
    """
    n, d, alive = where[0], where[1], where[2]
    m = len(rows)
    n_time = times.shape[0]
    F, S = Z.reshape(-1), np.empty(ROOM)
    x, begun, reached, _, error_sum = views(S, n)
    old = np.empty((m, LANES))
    following = np.zeros(LANES, dtype=np.int64)
    for lane in range(LANES):
        Z[alive, lane] = 1.0
    out[:] = np.nan
    rhs(Z)
    take(F, S, n, d)
    last = 0.0
    for lane in range(LANES):
        last = max(last, times[n_time - 1, lane])
        for r in range(m):
            old[r, lane] = Z[rows[r], lane]
        while following[lane] < n_time and times[following[lane], lane] <= 0.0:
            for r in range(m):
                out[following[lane], r, lane] = Z[rows[r], lane]
            following[lane] += 1
    t, h, steps = 0.0, first_step, 0
    while t < last and steps < max_steps and h > 1e-10:
        try_step(rhs, Z, F, S, n, d, h, tolerance)
        steps += 1
        error = 1e-30
        for lane in range(LANES):
            if not (error_sum[lane] <= error):  # also if it is nan
                error = error_sum[lane]
        error = math.sqrt(error / n)
        if error <= 1.0:
            for lane in range(LANES):
                while following[lane] < n_time and times[following[lane], lane] <= t + h:
                    u = (times[following[lane], lane] - t) / h
                    for r in range(m):
                        row = rows[r]
                        if row < n:
                            a, b = x[row, lane], Z[row, lane]
                            out[following[lane], r, lane] = (
                                a + u * u * (3.0 - 2.0 * u) * (b - a)
                                + h * u * (1.0 - u) * ((1.0 - u) * begun[row, lane] - u * reached[row, lane])
                            )  # fmt: skip
                        else:
                            out[following[lane], r, lane] = old[r, lane] + u * (Z[row, lane] - old[r, lane])
                    following[lane] += 1
            t += h
            for lane in range(LANES):
                for r in range(m):
                    old[r, lane] = Z[rows[r], lane]
            take(F, S, n, d)
        factor = 0.9 * error ** (-1.0 / 3.0)  # safety 0.9, at most a fifth: as in ``jump_integrator``
        if not (factor > 0.2):
            factor = 0.2
        if error > 1.0 and factor > 1.0:
            factor = 1.0
        h = min(h * min(4.0, factor), LONGEST)
    return steps
