"""Sine and cosine that LLVM can vectorise: numba without Intel's SVML calls libm, which blocks the lanes."""

from __future__ import annotations

import numpy as np
from numba import njit

TURNS = 1.0 / (2.0 * np.pi)  # in one rad
# 2 pi as a sum of two doubles: the second is the rounding error of the first.
TURN, REST_OF_TURN = 2.0 * np.pi, 2.4492935982947064e-16


@njit(inline="always", fastmath=True, error_model="numpy")  # type: ignore[untyped-decorator]
def sine_cosine(angle: float) -> tuple[float, float]:
    """Sine and cosine of an angle (rad, |angle| < 1e5), branch-free; error below 3e-14.

    Reduction by whole turns, polynomials for a quarter of the angle, and its fourth multiple: De Moivre's formula. A
    reduction by quarter turns would need shorter polynomials, but comparisons and selections cost more than they do.
    The polynomials in the square of the angle interpolate ``sin(r/4) / r`` and ``(cos(r/4) - 1) / r^2`` at the
    Chebyshev nodes of 0 to pi^2; their errors, 3e-15 and 2e-16, grow fourfold and sixteenfold.
    """
    r = angle - np.rint(angle * TURNS) * TURN
    z = r * r
    s = r * (
        0.24999999999999892
        + z
        * (
            -0.0026041666666588572
            + z
            * (
                8.138020824099756e-06
                + z * (-1.211014605614655e-08 + z * (1.0511502034526755e-11 + z * -5.902423565859888e-15))
            )
        )
    )
    c = 1.0 + z * (
        -0.03124999999999998
        + z
        * (
            0.00016276041666652707
            + z
            * (
                -3.3908420122382696e-07
                + z * (3.784421176658928e-10 + z * (-2.627931166832877e-13 + z * 1.231760076887771e-16))
            )
        )
    )
    square = c * c
    twice = 8.0 * square - 4.0
    return s * c * twice, 1.0 + square * (twice - 4.0)
