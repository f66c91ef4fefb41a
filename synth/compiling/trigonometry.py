"""Sine and cosine that LLVM can vectorise: numba without Intel's SVML calls libm, which blocks the lanes."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(inline="always", fastmath=True, error_model="numpy")  # type: ignore[untyped-decorator]
def sine_cosine(angle: float) -> tuple[float, float]:
    """Sine and cosine of an angle (rad, |angle| < 1e5), branch-free; error below 3e-16.

    Reduction by pi/2 in two parts and the Chebyshev-economised polynomials of Cephes ``sin.c`` (S. Moshier).
    """
    quarter = np.floor(angle * 0.6366197723675814 + 0.5)
    r = (angle - quarter * 1.5707963267341256) - quarter * 6.077100506506192e-11
    z = r * r
    sine = r + r * z * (
        -1.66666666666666324348e-01
        + z
        * (
            8.33333333332248946124e-03
            + z
            * (
                -1.98412698298579493134e-04
                + z * (2.75573137070700676789e-06 + z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10))
            )
        )
    )
    cosine = (
        1.0
        - 0.5 * z
        + z
        * z
        * (
            4.16666666666666019037e-02
            + z
            * (
                -1.38888888888741095749e-03
                + z
                * (
                    2.48015872894767294178e-05
                    + z
                    * (-2.75573143513906633035e-07 + z * (2.08757232129817482790e-09 - z * 1.13596475577881948265e-11))
                )
            )
        )
    )
    quadrant = quarter - 4.0 * np.floor(quarter * 0.25)
    odd = (quadrant == 1.0) | (quadrant == 3.0)
    s = cosine if odd else sine
    c = sine if odd else cosine
    return (-s if quadrant >= 2.0 else s), (-c if (quadrant == 1.0) | (quadrant == 2.0) else c)
