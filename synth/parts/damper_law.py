"""The torque-speed law of a rotary damper below its single published point.

Vendors of oil rotary dampers publish one torque at one speed. Below it the curve is concave, so a
straight line through that point is *too low* at low speed, and a damper chosen by it is too strong.

Evidence for the exponent: drop tests of three McMaster-Carr 6597K oil dampers in a leg (Agile and Adaptive Robotics
Laboratory, Published-Data, the data of the Krnacik thesis) follow ``torque ~ speed^n`` with n = 0.452 (6597K21), 0.440
(6597K19) and 0.498 (6597K8) between 0.05 and 3.7 rad/s; for two of them the law through the vendor's point alone
predicts the torque within about 10 %. Angle and speed are correlated in a drop, so dry friction plus a linear rate is
not excluded. The law is therefore an assumption: exponent 0.47, between 0.44 and 0.50. A measured curve replaces it
(``damper_curves.csv``), and one vendor of shear dampers states torque proportional to speed (``linear``).
"""

from __future__ import annotations

import numpy as np

from synth.swing.leg_model import DamperCurve

TABLE = "table"
CONCAVE = "concave"
LINEAR = "linear"

CONCAVE_EXPONENT = 0.47  # middle of the measured ones, see above
CONCAVE_EXPONENT_RANGE = (0.44, 0.50)  # of the three measured dampers, see above

# The curve is linear below its lowest point. A 500th of the rated speed (0.1 rpm of 50) is below the resolution of a
# leg's encoder, and keeps the slope at rest below 30 times the secant, so that the leg does not become stiff.
LOWEST_SPEED_FRACTION = 1.0 / 500.0


def power_law_curve(
    torque: float,
    speed: float,
    exponent: float = CONCAVE_EXPONENT,
    n_point: int = 12,
    lowest_speed: float | None = None,
) -> DamperCurve:
    """``torque (w / speed)^exponent`` as a curve of logarithmically spaced points.

    Parameters
    ----------
    torque
        N m at ``speed``: a point of the law.
    speed
        rad/s.
    exponent
        1 is linear, below 1 concave.
    n_point
        points from ``lowest_speed`` to ``speed``; the curve is straight between them, within 1 % of
        the law for the default exponent, number and range.
    lowest_speed
        rad/s, straight to (0, 0) below; default a 500th of ``speed``.

    Raises
    ------
    ValueError
        If a number is not positive, or ``lowest_speed`` is not below ``speed``.
    """
    lowest = speed * LOWEST_SPEED_FRACTION if lowest_speed is None else lowest_speed
    if not (torque > 0.0 and exponent > 0.0 and 0.0 < lowest < speed and n_point >= 2):
        raise ValueError(f"no power law through {torque} N m at {speed} rad/s from {lowest} rad/s, {n_point} points")
    speeds = np.geomspace(lowest, speed, n_point)
    speeds[-1] = speed  # geomspace may miss the end by a rounding
    torques = torque * (speeds / speed) ** exponent
    return DamperCurve(tuple(speeds.tolist()), tuple(torques.tolist()))
