"""Static points in the fit: in a held pose, spring, weight and known torque balance at a joint.

``k (q - rest) + g(q) = torque`` with g the torque that holds the pose against gravity. The reading of the angle is
uncertain as well as the torque, so a point's residual is divided by ``sqrt(torque_error^2 + (k angle_error)^2)`` at
the current k: minimised over the true angle, this is the residual of least squares with errors in both variables
(Fuller, *Measurement Error Models*, 1987, section 1.3.3; the second-order change of the leg's weight within the angle's
error is neglected). Free swings of an overdamped joint determine b/k; one such point determines k.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.files.static_points_file import TORQUE_SHARE, StaticPoint
from synth.swing.leg_model import Leg
from synth.swing.mechanics import coefficients, static_torque

STEP = 1e-6  # of a log rate, rad: central differences of a two-variable residual


@dataclass(frozen=True)
class Balance:
    """One joint's balance in one point.

    ``rotation`` rad; ``torque`` N m of the spring, ``k (q - rest)``, in q's sense; errors as standard
    deviations; ``weighed`` whether a known torque or mass acts, not only the leg's own weight. ``applied`` N m in q's
    sense, the known torque.
    """

    name: str
    joint: int
    rotation: float
    torque: float
    torque_error: float
    angle_error: float
    weighed: bool = True
    applied: float = 0.0

    def residual(self, log_rate: float, rest: float) -> float:
        """Residual in standard deviations."""
        rate = np.exp(log_rate)
        return float(
            (rate * (self.rotation - rest) - self.torque) / np.hypot(self.torque_error, rate * self.angle_error)
        )

    def slope(self, log_rate: float, rest: float) -> Array:
        """(2,) derivative of the residual by log rate and rest."""
        by_rate = self.residual(log_rate + STEP, rest) - self.residual(log_rate - STEP, rest)
        by_rest = self.residual(log_rate, rest + STEP) - self.residual(log_rate, rest - STEP)
        return np.array([by_rate, by_rest]) / (2 * STEP)


@dataclass(frozen=True)
class JudgedPoint:
    """A point's balance and its fit: measured and fitted spring torque, N m in q's sense, and their difference.

    ``deviations`` : the difference in standard deviations of the point. ``left_out`` : the recordings contradict it,
    and it is no part of the fit.
    """

    balance: Balance
    fitted: float
    deviations: float
    left_out: bool = False


def balances(leg: Leg, points: Sequence[StaticPoint]) -> tuple[Balance, ...]:
    """The balances of the points, one per joint."""
    found = []
    for point in points:
        rotation = leg.to_rotation(point.angles)
        weight = np.zeros(len(rotation))
        if not point.supported:
            weight = static_torque(coefficients(leg, point.tip_mass), rotation, leg.tilt + point.tilt)
        for j in point.balanced:
            applied = float(leg.sign[j] * point.torques[j])
            torque = applied - float(weight[j])
            error = point.torque_error
            if error is None:
                error = max(TORQUE_SHARE * abs(torque), 1e-9)
            weighed = point.tip_mass > 0.0 or bool(np.any(point.torques != 0.0))
            turned, angle_error = float(rotation[j]), point.angle_error
            found.append(Balance(point.name, j, turned, torque, error, angle_error, weighed, applied))
    return tuple(found)


def judge_points(
    points: Sequence[Balance], rate: Array, rest: Array, *, left_out: bool = False
) -> tuple[JudgedPoint, ...]:
    """Each balance at fitted spring rates (n,) N m/rad and rests (n,) rad."""
    return tuple(
        JudgedPoint(
            point,
            float(rate[point.joint] * (point.rotation - rest[point.joint])),
            point.residual(float(np.log(rate[point.joint])), float(rest[point.joint])),
            left_out,
        )
        for point in points
    )
