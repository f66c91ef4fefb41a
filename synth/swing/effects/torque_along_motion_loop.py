"""The compiled loop of ``torque_along_motion``, which loads it like generated code."""

from __future__ import annotations

from numba import float64, int64, types

from synth.compiling.compiled import compiled
from synth.swing.lane_layout import LANES

CONVERGED_ANGLE = 1e-6  # rad: convergence, far below any encoder's count
_extra = types.FunctionType(types.void(float64[::1], int64, int64[::1]))
_signature = types.void(
    _extra, float64[:, ::1], float64[::1], int64[::1], int64[::1], int64, int64, int64, float64, int64, float64[::1],
    float64[:, :, ::1], int64[::1], float64[:, ::1],
)  # fmt: skip


@compiled(_signature, error_model="numpy", nogil=True)
def along(  # type: ignore[no-untyped-def]
    extra, Z, flat, active, rows, torque, memory, change, bound, gap, time, inputs, steps, out
):
    """Fill ``out`` (n_time, 16) with the torque along the motion.

    ``steps`` (n_time,) : number of steps of the memory up to each sample. ``Z`` and ``flat`` are the same workspace.
    ``inputs`` (n_time, n_input, 16) are copied to ``rows``, rotation first, rest third. ``memory``, ``change`` and
    ``gap`` are rows, -1 for none. A memory is clipped to ``bound``, or to half a gap around the deflection. Close to a
    flank it is moved onto it, because interpolation errors would open the contact.
    """
    before = [0.0] * LANES
    for i in range(len(time)):
        for s in range(steps[i]):
            step = (time[i] - time[i - 1]) / steps[i]
            for half in range(2):
                share = (s + 0.5 * half) / steps[i]
                for k in range(len(rows)):
                    for lane in range(LANES):
                        Z[rows[k], lane] = (1.0 - share) * inputs[i - 1, k, lane] + share * inputs[i, k, lane]
                extra(flat, 1, active)
                for lane in range(LANES):
                    if half == 0:
                        before[lane] = Z[memory, lane]
                        Z[memory, lane] += 0.5 * step * Z[change, lane]
                    else:
                        reached = before[lane] + step * Z[change, lane]
                        Z[memory, lane] = max(-bound, min(bound, reached))
                if gap >= 0 and half == 1:
                    done = (s + 1.0) / steps[i]
                    for lane in range(LANES):
                        before_it = inputs[i - 1, 0, lane] - inputs[i - 1, 2, lane]
                        after_it = inputs[i, 0, lane] - inputs[i, 2, lane]
                        lag = before_it + done * (after_it - before_it) - Z[memory, lane]
                        side = 1.0 if lag > 0.0 else -1.0
                        if side * lag > 0.5 * Z[gap, lane] - CONVERGED_ANGLE:
                            Z[memory, lane] += lag - side * (0.5 * Z[gap, lane] + 1e-9)
        for k in range(len(rows)):
            for lane in range(LANES):
                Z[rows[k], lane] = inputs[i, k, lane]
        extra(flat, 1, active)
        for lane in range(LANES):
            out[i, lane] = Z[torque, lane]
