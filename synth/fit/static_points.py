"""Static points in the fit: in a held pose, spring, weight and known torque balance at a joint.

``k (q - rest) + g(q) = torque`` with g the torque that holds the pose against gravity; beside k the spring's own effect
where it hardens or softens. The reading of the angle is uncertain as well as the torque, so a point's residual is
divided by ``sqrt(torque_error^2 + (k angle_error)^2)`` at the current k: minimised over the true angle, this is the
residual of least squares with errors in both variables (Fuller, *Measurement Error Models*, 1987, section 1.3.3; the
second-order change of the leg's weight within the angle's error is neglected). Free swings of an overdamped joint
determine b/k; one such point determines k.

Where free angles shift from trial to trial, a point's is shifted too, with the same spread s. Points of one
``session`` share a shift: they tell k by the difference of their torques, and the free angle no better than one of
them. Of n others it is not known whether they do. Their shifts' covariance is taken as s^2 (I + (1 - 1/n) 11'), the
least that is below neither s^2 I (each has its own) nor s^2 11' (all share one), nor any mixture of the two: their mean
scatters as a single shift does, and their differences as those of separate ones.
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
    ``session`` : see ``StaticPoint``.
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
    session: str | None = None

    def spring_torque(self, rate: float, rest: float) -> float:
        """N m of the spring there, of ``rate`` N m/rad at ``rest`` rad, with its effect."""
        deflection = self.rotation - rest
        if not self.hardening:
            return rate * deflection
        return rate * deflection - _hardening()(0.0, 0.0, deflection, rate, 0.0, 0.0, 0.0, 0.0, *self.hardening)[0]

    def stiffness(self, rate: float, rest: float) -> float:
        """N m/rad, slope of the spring's torque there."""
        if not self.hardening:
            return rate
        ends = [self.spring_torque(rate, rest + turned) for turned in (-TURNED, TURNED)]
        return (ends[0] - ends[1]) / (2 * TURNED)

    def error(self, rate: float, rest: float, spread: float = 0.0) -> float:
        """N m, standard deviation of the balance, with that of the angle and of the free angle, ``spread`` rad."""
        return float(np.hypot(self.torque_error, self.stiffness(rate, rest) * np.hypot(self.angle_error, spread)))

    def residual(self, log_rate: float, rest: float, spread: float = 0.0) -> float:
        """Residual in standard deviations."""
        rate = float(np.exp(log_rate))
        return float((self.spring_torque(rate, rest) - self.torque) / self.error(rate, rest, spread))


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


def groups(points: Sequence[Balance]) -> tuple[tuple[int, ...], ...]:
    """Numbers of the balances whose shifts go together: those of one joint and session, or of none."""
    found: dict[tuple[int, str | None], list[int]] = {}
    for number, point in enumerate(points):
        found.setdefault((point.joint, point.session), []).append(number)
    return tuple(tuple(numbers) for numbers in found.values())


def independent_residuals(group: Sequence[Balance], log_rate: float, rest: float, spread: float) -> Array:
    """(m,) residuals of one group's balances, with unit variances and independent of one another.

    ``spread`` rad of the free angles' shifts. With z the residuals of covariance I + uu', they are (I + uu')^(-1/2) z.
    """
    shared = group[0].session is not None
    own = 0.0 if shared else spread
    residual = np.array([point.residual(log_rate, rest, own) for point in group])
    share = spread if shared else spread * np.sqrt(1.0 - 1.0 / len(group))
    if share == 0.0:
        return residual
    rate = float(np.exp(log_rate))
    common = np.array([share * point.stiffness(rate, rest) / point.error(rate, rest, own) for point in group])
    size = float(common @ common)
    # 1 / (1 + size + root) is (1 - 1 / root) / size, without the difference of two numbers near 1.
    root = np.sqrt(1.0 + size)
    return np.asarray(residual - common * (common @ residual) / (1.0 + size + root))


def linearised(group: Sequence[Balance], log_rate: float, rest: float, spread: float) -> tuple[Array, Array]:
    """``independent_residuals`` (m,), and their derivatives (m, 2) by log rate and rest."""
    ends = [
        independent_residuals(group, log_rate + turned, rest + moved, spread)
        for turned, moved in ((STEP, 0.0), (-STEP, 0.0), (0.0, STEP), (0.0, -STEP))
    ]
    slopes = np.stack([ends[0] - ends[1], ends[2] - ends[3]], axis=1) / (2 * STEP)
    return independent_residuals(group, log_rate, rest, spread), slopes


def spread_at(spread: Array | None, joint: int) -> float:
    """rad, of a joint's free angle at static points, (n,) or None where they have the common one."""
    return 0.0 if spread is None else float(spread[joint])


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
            found.append(
                Balance(point.name, j, turned, torque, error, angle_error, weighed, applied, beyond, point.session)
            )
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
    points: Sequence[Balance], rate: Array, rest: Array, spread: Array | None = None, *, left_out: bool = False
) -> tuple[JudgedPoint, ...]:
    """Each balance at fitted spring rates (n,) N m/rad and rests (n,) rad; ``spread`` as in ``spread_at``."""
    return tuple(
        JudgedPoint(
            point,
            point.spring_torque(float(rate[point.joint]), float(rest[point.joint])),
            point.residual(float(np.log(rate[point.joint])), float(rest[point.joint]), spread_at(spread, point.joint)),
            left_out,
        )
        for point in points
    )
