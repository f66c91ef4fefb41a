"""Recordings of known legs for the tests of the fit: simulated by MuJoCo, then noise and encoder counts.

The robot is that of Krnacik's thesis: springs and dampers of its Table 3, free angles of its Table 4.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from peers.mujoco_leg import ExtraTorque, simulate
from synth.files.trial_list import Trial
from synth.fit.estimate import fit_leg
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_result import FitResult
from synth.fit.recordings import Recording, recordings
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

Array = NDArray[np.float64]

SPRING = np.array([23.667, 1.7062, 0.4538])  # N m/rad
DAMPER = np.array([1.2903, 0.1054, 0.0634])  # N m s/rad
FREE_ANGLE = np.array([105.0, 108.0, 139.0])  # deg
NAMES = ("hip", "knee", "ankle")
LINKS = (
    Link(0.222, 0.222, 0.080, 1.1251e-3),
    Link(0.220, 0.207, 0.075, 1.0885e-3),
    Link(0.160, 0.090, 0.030, 4.17e-4),
)
ZERO = (math.radians(90), math.pi, math.pi)
SIGN = (1, 1, -1)
# deg from the free angles, hip, knee, ankle: flexed and extended, near and far
RELEASES = ((-13, 31, 16), (9, -17, -24), (14, 22, -18), (-9, -24, 21), (6, 35, 27), (-15, 18, -29), (11, -21, 24))
COUNTS = 8192  # a turn


def robot(
    spring: Sequence[float] | Array = SPRING,
    damper: Sequence[float] | Array = DAMPER,
    free_angle: Sequence[float] | Array = FREE_ANGLE,
    gravity: float = 9.81,
) -> Leg:
    """The robot's links with springs (N m/rad, free angles in deg) and dampers (N m s/rad)."""
    joints = []
    for i, name in enumerate(NAMES):
        unloaded = math.radians(float(free_angle[i]))
        parts = Spring(float(spring[i]), unloaded), Damper(float(damper[i]))
        joints.append(Joint(name, LINKS[i], ZERO[i], SIGN[i], None, *parts))
    return Leg("robot", tuple(joints), gravity=gravity)


def bare(leg: Leg) -> Leg:
    """The leg as the fit is given it: nothing at the joints."""
    return leg.with_joints(**{name: {"spring": None, "damper": None} for name in leg.joint_names})


@dataclass(frozen=True)
class Rig:
    """How trials are recorded. ``noise`` deg SD; ``counts`` a turn, 0 for none; ``duration`` s; ``rate`` Hz."""

    noise: float = 0.1
    counts: int = COUNTS
    duration: float = 1.0
    rate: float = 500.0
    step: float = 5e-4  # s, of the simulation

    def read(self, angle: Array, generator: np.random.Generator) -> Array:
        """Angles (rad) as they are read."""
        read = angle + np.radians(generator.normal(0.0, self.noise, angle.shape)) if self.noise else angle
        count = 2 * math.pi / self.counts if self.counts else 0.0
        return count * np.round(read / count) if count else read

    @property
    def times(self) -> Array:
        """(m,) s."""
        return np.arange(round(self.duration * self.rate) + 1) / self.rate


def release(
    leg: Leg,
    away: Sequence[float] | Array,
    generator: np.random.Generator,
    rig: Rig = Rig(),
    *,
    name: str = "release",
    rate: Sequence[float] | Array | None = None,
    locked: Sequence[str] = (),
    tip_mass: float = 0.0,
    tilt: float = 0.0,
    extra_torque: ExtraTorque | None = None,
) -> Trial:
    """One trial from ``away`` (deg, measured) off the free angles, at rest or at ``rate`` (rad/s of q)."""
    unloaded = np.array([joint.spring.free_angle if joint.spring else joint.zero for joint in leg.joints])
    start = leg.to_rotation(unloaded + np.radians(np.asarray(away, dtype=float)))
    first = np.zeros(len(start)) if rate is None else np.asarray(rate, dtype=float)
    held = [leg.joint_names.index(joint) for joint in locked]
    rotation = simulate(leg, start, first, rig.times, held, tip_mass, tilt, rig.step, extra_torque)
    angles = rig.read(leg.to_measured(rotation), generator)
    return Trial(name, rig.times, angles, locked=tuple(locked), tip_mass=tip_mass, tilt=tilt)


def releases(leg: Leg, seed: int, rig: Rig = Rig(), count: int = 7, first: int = 0) -> list[Trial]:
    """``count`` of the standard releases, from number ``first`` on, and round."""
    generator = np.random.default_rng(seed)
    numbers = range(first, first + count)
    return [release(leg, RELEASES[i % 7], generator, rig, name=f"release {i}") for i in numbers]


def recorded(leg: Leg, trials: Sequence[Trial]) -> list[Recording]:
    """Trials as the fit takes them."""
    return recordings(bare(leg), trials)


def fitted(leg: Leg, trials: Sequence[Trial], **options: object) -> FitResult:
    """Fit the bare leg to trials."""
    return fit_leg(bare(leg), recorded(leg, trials), LegFitOptions(**options))  # type: ignore[arg-type]


@dataclass(frozen=True)
class Errors:
    """What a fit misses: ``spring`` and ``damper`` (n,) as logarithms, ``angle`` (n,) rad.

    The standard deviations are the fit's own, from its 90 % intervals.
    """

    spring: Array
    damper: Array
    angle: Array
    spring_sd: Array
    damper_sd: Array
    angle_sd: Array

    @property
    def scores(self) -> Array:
        """(3 n,) errors over standard deviations."""
        errors = np.r_[self.spring, self.damper, self.angle]
        return errors / np.r_[self.spring_sd, self.damper_sd, self.angle_sd]


def errors(result: FitResult, leg: Leg) -> Errors:
    """A fit against the leg that made its trials."""
    joints = [result.joints[name] for name in leg.joint_names]
    half = 1.6448536269514722  # of a normal 90 % interval, in standard deviations

    def log(estimates: list, truth: list) -> tuple[Array, Array]:  # type: ignore[type-arg]
        value = np.array([np.log(e.value) for e in estimates]) - np.log(truth)
        return value, np.array([np.log(e.high / e.low) / 2 / half for e in estimates])

    spring, spring_sd = log([j.spring_rate for j in joints], [j.spring.rate for j in leg.joints if j.spring])
    damper, damper_sd = log([j.damper_rate for j in joints], [j.damper.rate for j in leg.joints if j.damper])
    truth = np.array([j.spring.free_angle for j in leg.joints if j.spring])
    angle = np.array([j.free_angle.value for j in joints]) - truth
    angle_sd = np.array([(j.free_angle.high - j.free_angle.low) / 2 / half for j in joints])
    return Errors(spring, damper, angle, spring_sd, damper_sd, angle_sd)
