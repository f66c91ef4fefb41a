"""One step of Bogacki and Shampine's 3(2) pair for sixteen jumps with a common step.

Coefficients: Bogacki & Shampine, Applied Mathematics Letters 2 (1989) 321-325; the last stage is the next step's
first. It is inlined into the loops that use it (``integrator.jump``, ``recorder.record``) and into their cached code,
which is recompiled only when their own files change: after a change here, touch those.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numba import njit

from synth.jump.jump_layout import LANES


def compiled_step(rules: Mapping[str, Any]) -> tuple[Any, Any]:
    """``_error_weights`` and ``_try_step``, compiled with a loop's own floating-point ``rules``.

    Inlined as Python they would count references at every step; cached separately they would be shared by
    loops with different rules.
    """
    return njit(**rules)(_error_weights), njit(**rules)(_try_step)


def _error_weights(n):  # type: ignore[no-untyped-def]
    """(n,) error weights of heights and angles, their rates, the current (A) and the energy (J)."""
    n_angle = (n - 3) // 2
    weight = np.empty(n)
    for j in range(n):
        weight[j] = 1.0 if j <= n_angle else (1.0 / 30.0 if j < n - 2 else (0.3 if j == n - 2 else 0.0))
    return weight


def _try_step(rhs, Z, x, K, d, h, weight, tolerance, error_sum):  # type: ignore[no-untyped-def]
    """Advance the state ``x`` (n, 16) with derivative ``K[0]`` (n, 16) by ``h`` s.

    The new state is in the first rows of ``Z``, the derivatives of the stages in ``K`` (4, n, 16), the last of them at
    the new state, and each lane's sum of squared errors over ``tolerance`` in ``error_sum`` (16,). ``d`` : row of the
    derivative in ``Z``; ``weight`` : see ``_error_weights``.
    """
    n = x.shape[0]
    for j in range(n):
        for lane in range(LANES):
            Z[j, lane] = x[j, lane] + 0.5 * h * K[0, j, lane]
    rhs(Z)
    for j in range(n):
        for lane in range(LANES):
            K[1, j, lane] = Z[d + j, lane]
            Z[j, lane] = x[j, lane] + 0.75 * h * K[1, j, lane]
    rhs(Z)
    for j in range(n):
        for lane in range(LANES):
            K[2, j, lane] = Z[d + j, lane]
            Z[j, lane] = x[j, lane] + h * (2.0 * K[0, j, lane] + 3.0 * K[1, j, lane] + 4.0 * K[2, j, lane]) / 9.0
    rhs(Z)
    for lane in range(LANES):
        error_sum[lane] = 0.0
    for j in range(n):
        w = h * weight[j] / tolerance
        for lane in range(LANES):
            K[3, j, lane] = Z[d + j, lane]
            v = -5.0 / 72.0 * K[0, j, lane] + K[1, j, lane] / 12.0 + K[2, j, lane] / 9.0 - K[3, j, lane] / 8.0
            v *= w
            error_sum[lane] += v * v
