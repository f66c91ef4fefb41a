"""The torque-speed law of a rotary damper below its single published point, or below the lowest one of a table.

Vendors of oil rotary dampers publish one torque at one speed. Below it the curve is concave, so a
straight line through that point is *too low* at low speed, and a damper chosen by it is too strong.

Evidence for the exponent: drop tests of three McMaster-Carr 6597K oil dampers in a leg (Agile and Adaptive Robotics
Laboratory, Published-Data, the data of the Krnacik thesis) follow ``torque ~ speed^n`` with n = 0.452 (6597K21), 0.440
(6597K19) and 0.498 (6597K8) between 0.05 and 3.7 rad/s; for two of them the law through the vendor's point alone
predicts the torque within about 10 %. Angle and speed are correlated in a drop, so dry friction plus a linear rate is
not excluded. The law is therefore an assumption: exponent 0.47, between 0.44 and 0.50. A measured curve replaces it
(``damper_curves.csv``), and one vendor of shear dampers states torque proportional to speed (``linear``).

A leg moves slowly most of the time: the joints of the built-in example turn for 83 to 97 % of it below the 10 rpm at
which a test stand begins. A measured table therefore goes on below its lowest point by the power law of its lowest
points (``low_speed_law``); straight to (0, 0) it would have a third of the torque at a tenth of that speed.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, log, pi

import numpy as np

from synth.swing.lane_layout import CURVE_POINTS
from synth.swing.leg_model import DamperCurve

TABLE = "table"
CONCAVE = "concave"
LINEAR = "linear"

CONCAVE_EXPONENT = 0.47  # middle of the measured ones, see above
CONCAVE_EXPONENT_RANGE = (0.44, 0.50)  # of the three measured dampers, see above

# The curve is linear below its lowest point. A 500th of the rated speed (0.1 rpm of 50) is below the resolution of a
# leg's encoder, and keeps the slope at rest below 30 times the secant, so that the leg does not become stiff.
LOWEST_SPEED_FRACTION = 1.0 / 500.0

NEAR_THE_LOWEST = 4.0  # times a table's lowest speed: its points up to there give the exponent below it
# Exponents that a table's lowest points may have. Dry friction or an error of measurement is behind a smaller one, and
# a torque off by 2 at a tenth of the speed (``assumed_laws``) would fall there; 2 is the flow through an orifice.
PLAUSIBLE_EXPONENTS = (1.0 / 3.0, 2.0)
LEAST_LOW_POINTS = 7  # below a table of many points; ``thin`` drops those that matter least


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


@dataclass(frozen=True)
class LowSpeedLaw:
    """How a measured table goes on below its lowest point: by ``torque ~ speed^exponent`` through that point.

    ``found``: whether the exponent is that of the table's lowest points; else it is the assumed one.
    """

    table: DamperCurve
    exponent: float
    found: bool

    @property
    def speed(self) -> float:
        """Rad/s, below which the law holds: the lowest of the table."""
        return self.table.speed[0]

    @property
    def exponents(self) -> tuple[float, float]:
        """Least and greatest exponent: as uncertain as the assumed one, of which no lower speed was measured either."""
        low, high = CONCAVE_EXPONENT_RANGE
        return self.exponent + (low - CONCAVE_EXPONENT), self.exponent + (high - CONCAVE_EXPONENT)

    @property
    def words(self) -> str:
        """From where, and by which exponent."""
        of = "of its lowest points" if self.found else "assumed"
        return f"below {self.speed * 30.0 / pi:.3g} rpm a power law, exponent {self.exponent:.2f} {of}"

    def curve(self, exponent: float | None = None) -> DamperCurve:
        """The table with points below it, down to a 500th of its highest speed; ``exponent``: another one."""
        lowest = self.table.speed[-1] * LOWEST_SPEED_FRACTION
        # As dense as an assumed law's twelve points over a ratio of 500.
        wanted = ceil(11 * log(self.speed / lowest) / log(1.0 / LOWEST_SPEED_FRACTION))
        added = max(1, min(wanted, max(CURVE_POINTS - len(self.table.speed), LEAST_LOW_POINTS)))
        exponent = self.exponent if exponent is None else exponent
        below = power_law_curve(self.table.torque[0], self.speed, exponent, added + 1, lowest)
        return DamperCurve(below.speed[:-1] + self.table.speed, below.torque[:-1] + self.table.torque)


def low_speed_law(table: DamperCurve) -> LowSpeedLaw | None:
    """The law below a table's lowest point; None if that is slow enough (a 500th of the highest), or has no torque."""
    speed, torque = np.array(table.speed), np.array(table.torque)
    if torque[0] <= 0.0 or speed[0] <= speed[-1] * LOWEST_SPEED_FRACTION * (1.0 + 1e-9):  # 1e-9: rounding
        return None
    near = np.flatnonzero(speed[1:] <= NEAR_THE_LOWEST * speed[0])
    near = 1 + (near if len(near) else np.arange(min(1, len(speed) - 1)))
    if not len(near) or torque[near].min() <= 0.0:
        return LowSpeedLaw(table, CONCAVE_EXPONENT, found=False)
    apart, rise = np.log(speed[near] / speed[0]), np.log(torque[near] / torque[0])
    exponent = float(apart @ rise / (apart @ apart))  # least squares of the straight line through the lowest point
    if not PLAUSIBLE_EXPONENTS[0] <= exponent <= PLAUSIBLE_EXPONENTS[1]:
        return LowSpeedLaw(table, CONCAVE_EXPONENT, found=False)
    return LowSpeedLaw(table, exponent, found=True)
