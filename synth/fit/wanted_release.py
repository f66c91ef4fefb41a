"""The release of a leg from wanted characteristics: what each joint is asked for, and how far a leg is from it.

A joint's response would be that of a damped oscillator of the wanted frequency and damping ratio (Inman,
*Engineering Vibration*, 4th ed., section 1.3). In a coupled leg many springs and dampers show the same characteristics,
so a leg is judged by its characteristics, by how near each joint's whole motion is to the oscillator's, and by how far
its rates are from the usual ones.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.files.wanted_section import WantedCharacteristics
from synth.motion.characteristics import LEAST_PEAK, characteristics
from synth.motion.rest import last_tenths
from synth.swing.chain import Chain, compiled_chain
from synth.swing.leg_lanes import LegLanes
from synth.swing.leg_model import Damper, Leg, Spring
from synth.swing.mechanics import coefficients, mass_matrix, static_torque

KEYS = {"damping_ratio": "1", "damped_frequency": "rad/s", "rise_time": "s"}  # what may be asked
UNITS = KEYS | {"overshoot": "1"}  # of all measures
ENVELOPE_DECAY = 9.0  # of the slowest joint's envelope, exp(-9) or a ten-thousandth remains at the end of the motion
SAMPLES_A_SWING = 60  # samples per period of the fastest joint: extremes and crossings are interpolated between them
MOST_SAMPLES = 4000  # of the motion, if one joint is far slower than another
FINE_TOLERANCE = 1e-8  # the integrator's tolerance, far below the steps of the derivatives
MOST_STEPS = 4000  # of the integrator: a damper that needs more is too strong for the wanted motion
LEAST_SWING = 0.05  # of the amplitude: smaller swings are coupled from other joints
# Relative standard deviations of a leg that counts as wanted. A characteristic: what a table of figures is rounded to.
CHARACTERISTIC_ERROR = 0.02
# Of coupled joints, whose swings are no single decay: decrement and frequency depend on the peaks that are counted.
COUPLED_CHARACTERISTIC_ERROR = 0.05
# A joint's motion off the oscillator's, RMS over that of the oscillator: 0.05 to 1.1 at the joints of 18 coupled legs
# whose own characteristics were asked, half of them below 0.3.
SHAPE_ERROR = 0.6
# The same of a joint that shows no decrement: its damping ratio cannot have been measured, so its shape is a guess.
GUESSED_SHAPE_ERROR = 1.0
# Logarithm of a rate over the usual one: at 90 % a factor of 27 either way, which takes in both ends of its range.
RATE_ERROR = 2.0
MOST_LOGARITHM = 6.0  # three times that: beyond, nothing is searched
LARGEST_EXCURSION = 1.5  # amplitudes to either side of rest: a passive joint alone stays within one
EXCURSION_ERROR = 0.1  # amplitudes, or of the range: how steeply an excursion beyond is penalised
ABSENT_LOGARITHM = 2.0  # logarithm for a characteristic that the motion does not show: a factor of e^2


def rise_of(ratio: float) -> float:
    """10-90 % rise time of an oscillator released at rest, times its natural frequency."""
    # Before the first half period ends: later the motion returns through the level.
    last = min(10.0, np.pi / np.sqrt(1 - ratio**2)) if ratio < 1 else 10.0 * (1 + ratio)
    from scipy.optimize import brentq  # imported here: it takes 0.1 s, and few fits state a wanted motion

    ends = [brentq(lambda t, level=level: oscillation(ratio, t) - level, 0.0, last) for level in (0.9, 0.1)]
    return float(ends[1] - ends[0])


def oscillation(ratio: float, time: float | Array) -> Any:
    """From 1 at rest to 0, of an oscillator of natural frequency 1."""
    if abs(ratio - 1.0) < 1e-6:  # critical damping: the general formula divides by zero
        return (1.0 + time) * np.exp(-time)
    root = np.sqrt(complex(ratio**2 - 1.0))
    slow, fast = -ratio + root, -ratio - root
    return ((slow * np.exp(fast * time) - fast * np.exp(slow * time)) / (slow - fast)).real


def natural_frequency(joint: WantedCharacteristics) -> float:
    """Of the oscillator with the wanted characteristics, rad/s; a given damped frequency takes precedence."""
    if joint.damped_frequency is not None:
        return joint.damped_frequency / float(np.sqrt(1.0 - joint.damping_ratio**2))
    assert joint.rise_time is not None
    return rise_of(joint.damping_ratio) / joint.rise_time


def swing_of(ratio: float, number: int) -> float:
    """Height of the oscillator's swing past rest, the first is 1, over its amplitude; 0 without oscillation."""
    return float(np.exp(-np.pi * number * ratio / np.sqrt(1.0 - ratio**2))) if ratio < 1.0 else 0.0


@dataclass(frozen=True)
class AskedJoint:
    """One joint's request in measures that its motion can show.

    The logarithmic decrement and the damped frequency need two swings past rest. An oscillator so damped that its
    second one is not seen is asked for by its rise time and, if its first one is seen, by that overshoot.
    """

    asked: WantedCharacteristics

    @property
    def swings(self) -> bool:
        """Whether the oscillator shows two swings past rest."""
        return swing_of(self.asked.damping_ratio, 2) >= LEAST_PEAK

    @property
    def counted(self) -> int:
        """Swings past rest from which decrement and frequency are taken, if it shows two."""
        seen = np.log(LEAST_SWING) / np.log(swing_of(self.asked.damping_ratio, 1))
        return max(2, int(seen))

    @property
    def measures(self) -> dict[str, float]:
        """Measure -> its wanted value, SI."""
        asked, ratio = self.asked, self.asked.damping_ratio
        found = {"rise_time": asked.rise_time} if asked.rise_time is not None else {}
        if self.swings:
            found["damping_ratio"] = ratio
            if asked.damped_frequency is not None:
                found["damped_frequency"] = asked.damped_frequency
            return found
        if swing_of(ratio, 1) >= LEAST_SWING:
            found["overshoot"] = swing_of(ratio, 1)
        return {"rise_time": rise_of(ratio) / natural_frequency(asked)} | found

    def shown(self, time: Array, angle: Array) -> dict[str, float]:
        """Measure -> value in a motion (m,) rad; a measure that it does not show is missing."""
        least = (LEAST_PEAK if self.swings else LEAST_SWING) * abs(self.asked.amplitude) / 3.0
        most = self.counted if self.swings else None
        seen = characteristics(time, angle, least, rest=self.asked.rest, most_peaks=most)
        every = {key: getattr(seen, key) for key in UNITS}
        return {key: value for key, value in every.items() if value is not None}

    def logarithms(self, shown: Mapping[str, float]) -> list[float]:
        """Of actual over wanted, of each measure; and of the damping, if the motion swings where it should not."""
        found = [
            float(np.log(shown[key] / asked)) if shown.get(key, 0.0) > 0.0 else ABSENT_LOGARITHM
            for key, asked in self.measures.items()
        ]
        if not self.swings:
            found.append(ABSENT_LOGARITHM if "damping_ratio" in shown else 0.0)
        return found


@dataclass(frozen=True)
class CharacteristicRelease:
    """Unknowns x (2 n,): logarithms of spring and damper rates over the usual ones.

    ``spring`` (n,) N m/rad and ``damper`` (n,) N m s/rad, the usual ones of a joint that swings so. A joint alone moves
    its own inertia; one that is far faster by itself follows the others' swing, and a rate for the largest inertia of
    the chain would do as well. Between the two, the geometric mean: ``usual`` (n,), logarithm over the joint alone.
    ``oscillators`` (m, n) wanted motion of each joint alone at ``time`` (m,) s, from 1 to 0.
    ``gravity`` (n,) N m/rad, gravity's stiffness at rest; ``inertia`` (n,) kg m^2 there.
    """

    leg: Leg
    joints: tuple[AskedJoint, ...]
    chain: Chain
    time: Array
    oscillators: Array
    spring: Array
    damper: Array
    usual: Array
    gravity: Array
    inertia: Array

    @classmethod
    def of(cls, leg: Leg, asked: Mapping[str, WantedCharacteristics]) -> CharacteristicRelease:
        """The release that ``asked`` wants of every joint of ``leg``."""
        joints = [asked[name] for name in leg.joint_names]
        natural = np.array([natural_frequency(joint) for joint in joints])
        ratio = np.array([joint.damping_ratio for joint in joints])
        slowest = np.where(ratio < 1, ratio, ratio - np.sqrt(np.maximum(ratio**2 - 1, 0.0))) * natural
        step = 2 * np.pi / (natural.max() * SAMPLES_A_SWING)
        count = int(min(MOST_SAMPLES, np.ceil(ENVELOPE_DECAY / (slowest.min() * step)))) + 1
        time = np.linspace(0.0, ENVELOPE_DECAY / slowest.min(), count)
        pose = leg.to_rotation(np.array([joint.rest for joint in joints]))
        coefficient = coefficients(leg)
        inertia = np.diag(mass_matrix(coefficient, pose, leg.tilt))
        weight = coefficient.weight_stiffness(leg.tilt + np.cumsum(pose))
        gravity = np.cumsum(weight[::-1])[::-1]
        whole = inertia * natural**2
        # A fiftieth: a start needs a positive rate where gravity alone is stiffer than wanted.
        spring = np.maximum(whole - gravity, 0.02 * whole)
        usual = 0.5 * np.log(inertia.max() / inertia)
        alone = np.column_stack([oscillation(z, w * time) for z, w in zip(ratio, natural, strict=True)])
        return cls(
            leg, tuple(AskedJoint(joint) for joint in joints), compiled_chain(len(joints)), time, alone,
            spring * np.exp(usual), 2 * ratio * natural * inertia * np.exp(usual), usual, gravity, inertia,
        )  # fmt: skip

    @property
    def n(self) -> int:
        """Unknowns."""
        return 2 * len(self.spring)

    @property
    def rest(self) -> Array:
        """(n,) rad, measured, the wanted rest pose."""
        return np.array([joint.asked.rest for joint in self.joints])

    @property
    def amplitude(self) -> Array:
        """(n,) rad, measured, from rest to the release."""
        return np.array([joint.asked.amplitude for joint in self.joints])

    def rates(self, x: Array) -> tuple[Array, Array]:
        """Spring rates (..., n) N m/rad and damper rates N m s/rad."""
        n = len(self.spring)
        return self.spring * np.exp(x[..., :n]), self.damper * np.exp(x[..., n:])

    def free_rotation(self, spring: Array) -> Array:
        """(..., n) rad, rotations at which springs (..., n) N m/rad are unloaded so that the leg rests as wanted."""
        pose = self.leg.to_rotation(self.rest)
        return np.asarray(pose + static_torque(coefficients(self.leg), pose, self.leg.tilt) / spring)

    def leg_of(self, x: Array) -> Leg:
        """The leg with these rates, with the wanted rest pose."""
        k, b = self.rates(x)
        free = self.leg.to_measured(self.free_rotation(k))
        changes = {
            joint.name: {"spring": Spring(float(k[j]), float(free[j])), "damper": Damper(float(b[j]))}
            for j, joint in enumerate(self.leg.joints)
        }
        return self.leg.with_joints(**changes)

    def motions(self, points: Array) -> Array:
        """(k, m, n) rad, measured, of the releases with the unknowns (k, 2 n); nan if a simulation fails."""
        legs = LegLanes.of(self.leg_of(points[0]), len(points))
        k, b = self.rates(points)
        legs.spring_rate[:], legs.damper_rate[:], legs.rest[:] = k.T, b.T, self.free_rotation(k).T
        lanes, layout = self.chain.lanes(legs), self.chain.layout
        lanes[layout.rows("rotation")] = self.leg.to_rotation(self.rest + self.amplitude)[:, None]
        moved = self.chain.run(lanes, self.time, FINE_TOLERANCE, max_steps=MOST_STEPS)
        return np.asarray(self.leg.to_measured(moved.transpose(2, 0, 1)))

    def shown(self, motion: Array) -> dict[str, dict[str, float]]:
        """Joint -> measure -> value in a motion (m, n) rad, evaluated as for a recording."""
        if not np.isfinite(motion).all():
            return {name: {} for name in self.leg.joint_names}
        pairs = zip(self.leg.joint_names, self.joints, strict=True)
        return {name: joint.shown(self.time, motion[:, j]) for j, (name, joint) in enumerate(pairs)}

    def characteristic_logarithms(self, motion: Array) -> Array:
        """Logarithms of actual over wanted of all joints' measures."""
        pairs = zip(self.joints, self.shown(motion).values(), strict=True)
        return np.array([each for joint, shown in pairs for each in joint.logarithms(shown)])

    def residuals(self, points: Array) -> Array:
        """(k, r) of the unknowns (k, 2 n), in standard deviations."""
        motions = self.motions(points)
        return np.array([self._residuals_of(x, motion) for x, motion in zip(points, motions, strict=True)])

    def _residuals_of(self, x: Array, motion: Array) -> Array:
        error = COUPLED_CHARACTERISTIC_ERROR if len(self.joints) > 1 else CHARACTERISTIC_ERROR
        characteristic = self.characteristic_logarithms(motion) / error
        if not np.isfinite(motion).all():
            motion = np.full_like(motion, np.pi) + self.rest
        level = (motion - self.rest) / self.amplitude
        shape, excursion = self.off_oscillators(motion)
        shape /= np.array([SHAPE_ERROR if joint.swings else GUESSED_SHAPE_ERROR for joint in self.joints])
        left = last_tenths(level) / LEAST_SWING
        beyond = np.maximum(excursion - LARGEST_EXCURSION, 0.0) / EXCURSION_ERROR
        beyond_range = self._beyond_range(motion)
        return np.concatenate([characteristic, shape, left, beyond, beyond_range, x / RATE_ERROR])

    def off_oscillators(self, motion: Array) -> tuple[Array, Array]:
        """Of each joint in a motion (m, n) rad, two (n,).

        Its deviation from the wanted oscillation, RMS over that of the oscillation, and its largest way from rest in
        amplitudes.
        """
        level = (motion - self.rest) / self.amplitude
        square = ((level - self.oscillators) ** 2).sum(axis=0) / (self.oscillators**2).sum(axis=0)
        return np.asarray(np.sqrt(square)), np.asarray(np.abs(level).max(axis=0))

    def _beyond_range(self, motion: Array) -> Array:
        """(n,) how far each joint passes the range that its leg states, in standard deviations.

        Where the wanted oscillation itself passes the range, the request holds and not the range.
        """
        found = np.zeros(len(self.spring))
        alone = self.rest + self.amplitude * self.oscillators
        for j, joint in enumerate(self.leg.joints):
            if joint.range is not None:
                low, high = min(joint.range[0], alone[:, j].min()), max(joint.range[1], alone[:, j].max())
                passed = max(low - motion[:, j].min(), motion[:, j].max() - high, 0.0)
                found[j] = passed / abs(self.amplitude[j]) / EXCURSION_ERROR
        return found
