"""Static points in the fit: in a held pose, spring, weight and known torque balance at a joint.

``k (q - rest) + g(q) = torque`` with g the torque that holds the pose against gravity; beside k the spring's own effect
where it hardens or softens. The reading of the angle is uncertain as well as the torque, so a point's residual is
divided by ``sqrt(torque_error^2 + (k angle_error)^2)`` at the current k: minimised over the true angle, this is the
residual of least squares with errors in both variables (Fuller, *Measurement Error Models*, 1987, section 1.3.3; the
second-order change of the leg's weight within the angle's error is neglected). Free swings of an overdamped joint
determine b/k; one such point determines k.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from synth.arrays import Array
from synth.files.static_points_file import TORQUE_SHARE, StaticPoint
from synth.swing.effects import effect_named
from synth.swing.leg_model import Joint, Leg
from synth.swing.mechanics import coefficients, static_torque

# The effect of a spring that is not linear: the only one of a spring alone that a fit finds by itself (``joint_laws``).
HARDENING = "hardening_spring"
TURNED = 1e-4  # rad: of a spring's slope, of which ``STEP`` takes differences again
STEP = 1e-6  # of a log rate, rad: central differences of a two-variable residual


@dataclass(frozen=True)
class Balance:
    """One joint's balance in one point.

    ``rotation`` rad; ``torque`` N m of the spring, ``k (q - rest)``, in q's sense; errors as standard
    deviations; ``weighed`` whether a known torque or mass acts, not only the leg's own weight. ``applied`` N m in q's
    sense, the known torque. ``hardening`` : parameters of the spring's effect of this name, none for a linear spring.
    """

    name: str
    joint: int
    rotation: float
    torque: float
    torque_error: float
    angle_error: float
    weighed: bool = True
    applied: float = 0.0
    hardening: tuple[float, ...] = ()

    def spring_torque(self, rate: float, rest: float) -> float:
        """N m of the spring there, of ``rate`` N m/rad at ``rest`` rad, with its effect."""
        deflection = self.rotation - rest
        if not self.hardening:
            return rate * deflection
        return rate * deflection - _hardening()(0.0, 0.0, deflection, rate, 0.0, 0.0, 0.0, 0.0, *self.hardening)[0]

    def error(self, rate: float, rest: float) -> float:
        """N m, standard deviation of the balance, with that of the angle by the spring's slope there."""
        slope = rate
        if self.hardening:
            ends = [self.spring_torque(rate, rest + turned) for turned in (-TURNED, TURNED)]
            slope = (ends[0] - ends[1]) / (2 * TURNED)
        return float(np.hypot(self.torque_error, slope * self.angle_error))

    def residual(self, log_rate: float, rest: float) -> float:
        """Residual in standard deviations."""
        rate = float(np.exp(log_rate))
        return float((self.spring_torque(rate, rest) - self.torque) / self.error(rate, rest))

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
            beyond = _parameters(leg.joints[j])
            found.append(Balance(point.name, j, turned, torque, error, angle_error, weighed, applied, beyond))
    return tuple(found)


def _parameters(joint: Joint) -> tuple[float, ...]:
    """The parameters of a spring that is not linear, in the order of its law; none if the joint has none."""
    given = joint.effects.get(HARDENING)
    if given is None:
        return ()
    return tuple(
        float(given.get(each.name, each.off if each.default is None else each.default))
        for each in effect_named(HARDENING).parameters
    )


@cache
def _hardening() -> Callable[..., tuple[float, float]]:
    """The law of such a spring, compiled at the first call: (torque on the joint in N m, 0)."""
    return effect_named(HARDENING).function()


def judge_points(
    points: Sequence[Balance], rate: Array, rest: Array, *, left_out: bool = False
) -> tuple[JudgedPoint, ...]:
    """Each balance at fitted spring rates (n,) N m/rad and rests (n,) rad."""
    return tuple(
        JudgedPoint(
            point,
            point.spring_torque(float(rate[point.joint]), float(rest[point.joint])),
            point.residual(float(np.log(rate[point.joint])), float(rest[point.joint])),
            left_out,
        )
        for point in points
    )
