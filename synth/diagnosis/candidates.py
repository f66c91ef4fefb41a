"""Candidates: an effect at a place in one of its shapes, in natural sizes of the leg's motion there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.diagnosis.effect_shape import ShapedEffect
from synth.diagnosis.gap_trials import GapTrial
from synth.diagnosis.hypotheses import Key
from synth.estimation.parameters import Parameter
from synth.swing.effects import Effect, registered
from synth.swing.lane_layout import MOST_LINKS
from synth.swing.leg_lanes import has_direction, turned_to_rotation
from synth.swing.leg_model import Leg
from synth.swing.mechanics import coefficients


@dataclass(frozen=True)
class Scales:
    """A joint's natural sizes, from its motion: by them a prior fits a flea's leg and an elephant's.

    ``angle`` (n,) rad and ``speed`` (n,) rad/s, amplitudes; ``torque`` (n,) N m of spring and gravity at that angle;
    ``force`` N the leg's weight; ``length`` (n,) m of the link; ``middle`` (n,) rad of the motion's range, ``half``
    (n,) its half width, both in the sense of q.
    """

    angle: Array
    speed: Array
    torque: Array
    force: float
    length: Array
    middle: Array
    half: Array

    def of(self, unit: str, joint: int) -> float:
        """Natural size of a unit at a joint; 1 for units that have none."""
        angle, speed, torque = self.angle[joint], self.speed[joint], self.torque[joint]
        sizes = {
            "rad": angle,
            "rad/s": speed,
            "s": angle / speed,
            "N*m": torque,
            "N*m/rad": torque / angle,
            "N*m*s/rad": torque / speed,
            "N*m*s^2/rad^2": torque / speed**2,
            "m": self.length[joint],
            "N": self.force,
            "1/rad": 1.0 / angle,
            "s/rad": 1.0 / speed,
            "kg": self.force / 9.81,
            "kg*m^2": torque * angle / speed**2,
            "N/m": torque / angle / self.length[joint] ** 2,
        }
        return float(sizes.get(unit, 1.0))


def scales(leg: Leg, trials: Sequence[GapTrial]) -> Scales:
    """Natural sizes of each joint from the trials in which it is free."""
    n = len(leg.joints)
    low, high, speed = np.full(n, np.inf), np.full(n, -np.inf), np.zeros(n)
    for trial in trials:
        smoothed = trial.recording.smoothed
        for j in trial.free:
            low[j] = min(low[j], float(smoothed.angle[:, j].min()))
            high[j] = max(high[j], float(smoothed.angle[:, j].max()))
            speed[j] = max(speed[j], float(np.percentile(np.abs(smoothed.rate[:, j]), 98)))
    moved = np.isfinite(low)
    low, high = np.where(moved, low, -0.1), np.where(moved, high, 0.1)
    rest, rate = leg.rest, leg.spring_rate
    hanging = np.cumsum(coefficients(leg).gravity[::-1])[::-1]  # what gravity adds to the springs' stiffness
    angle = np.maximum(np.maximum(np.abs(low - rest), np.abs(high - rest)), 0.02)
    weight = leg.gravity * sum(j.link.mass for j in leg.joints)
    length = np.array([j.link.length for j in leg.joints])
    torque = (rate + hanging) * angle + 1e-12
    half = np.maximum(0.5 * (high - low), 0.01)
    return Scales(angle, np.maximum(speed, 0.1), torque, weight, length, 0.5 * (low + high), half)


@dataclass(frozen=True)
class Candidate(ShapedEffect):
    """One effect at one joint (0 for the base) in one shape."""

    effect: Effect
    joint: int
    scales: Scales
    leg: Leg

    @property
    def key(self) -> Key:
        """Effect and place, as the files name them."""
        return self.effect.name, "base" if self.effect.where == "base" else self.leg.joints[self.joint].name

    @property
    def links(self) -> int:
        """How many links it adds: one for each way in which a structure gives."""
        ways = {*self.shape.free, *self.shape.held} & {*self.effect.strengths}
        return len(ways) if self.effect.way == "structure" else 0

    def natural_size(self, parameter: Parameter) -> float:
        """By the joint's motion, see ``Scales``."""
        return self.scales.of(parameter.unit, self.joint) if parameter.natural else 1.0

    def in_units(self, parameter: Parameter, value: Array) -> Array:
        """Natural values (n_lane,) of a free parameter in SI and measured sense."""
        if parameter.anchor != "middle":
            return super().in_units(parameter, value)
        joint = self.leg.joints[self.joint]
        middle = joint.zero + joint.sign * self.scales.middle[self.joint]
        return np.asarray(middle + value * self.scales.half[self.joint])

    def named(self, x: Array) -> dict[str, float]:
        """Parameters that say something, by name, from whitened unknowns (size,)."""
        values = self.values(x[:, None])[:, 0]
        shown = {}
        for p, parameter in enumerate(self.effect.parameters):
            freed = parameter.name in self.shape.free or parameter.name in self.shape.held
            if freed or (parameter.default is None):
                shown[parameter.name] = float(values[p])
        return shown

    def in_rotation(self, x: Array) -> Array:
        """As ``values``, turned to the sense of q where direction matters."""
        values = self.values(x)
        if not has_direction(self.effect):
            return values
        joint = self.leg.joints[self.joint]
        turned = [turned_to_rotation(self.effect, joint.sign, joint.zero, lane) for lane in values.T.tolist()]
        return np.array(turned).T


def candidates(leg: Leg, trials: Sequence[GapTrial], found: Scales) -> list[Candidate]:
    """Every effect at every place where it could act and show, in every shape."""
    free = sorted({j for trial in trials for j in trial.free})
    made = []
    for effect in registered():
        # What a link weighs shows where it moves: at a free joint, or beyond one.
        first = min(free, default=0) if effect.way == "leg" else 0
        places = range(first, len(leg.joints)) if effect.shows_locked else free
        for joint in [0] if effect.where == "base" else places:
            for shape in effect.shapes:
                candidate = Candidate(effect, shape, joint, found, leg)
                if len(leg.joints) + candidate.links <= MOST_LINKS:
                    made.append(candidate)
    return made
