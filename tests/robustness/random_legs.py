"""Random legs of known springs and dampers, and recordings of them as laboratories make them: noise, counts, losses.

A leg's links, natural frequencies and damping ratios are drawn, over- and underdamped joints mixed; a recording has
white noise, encoder counts, lost samples, and optionally an external torque after the release. The motion
is this program's own engine's at a tight tolerance, which the tests of the model hold against MuJoCo: here the fit is
on trial, not the equations of motion.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from synth.files.tolerance import Tolerance
from synth.files.trial_list import Trial
from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring
from synth.swing.mechanics import outboard_inertia, rest_pose
from synth.swing.tolerances import LINK_QUANTITIES, Tolerances

Array = NDArray[np.float64]

NAMES = ("hip", "knee", "ankle", "toe")
LINK_NUMBERS = (1, 2, 3, 3, 3, 3, 4)
TOLERANCE = 1e-9
TOLERANCE_OF_LINKS = Tolerance()  # the defaults of every project
OVERDAMPED = 1.0  # damping ratio b / (2 sqrt(k I)) from which a joint counts as such


@dataclass(frozen=True)
class Recorder:
    """How the trials of one leg are recorded.

    ``noise`` deg SD; ``counts`` a turn, 0 for none; ``rate`` Hz; ``trials`` how many; ``lost`` share of samples that
    are missing; ``driven`` s from the start with an external torque, 0 for none; ``uneven`` RMS of the steps between
    samples, as a share of the usual one: a computer's logs have 0.03 to 0.24 (``../shared/rigs/servo_bench``).
    """

    noise: float
    counts: int
    rate: float
    trials: int
    lost: float = 0.0
    driven: float = 0.0
    uneven: float = 0.0

    @property
    def scatter(self) -> float:
        """Rad, of one sample: noise and rounding together."""
        rounding = 2 * math.pi / self.counts / math.sqrt(12) if self.counts else 0.0
        return math.hypot(math.radians(self.noise), rounding)


@dataclass(frozen=True)
class Case:
    """One random leg with its trials. ``damping_ratio`` (n,) is each joint's own, b / (2 sqrt(k I)), I outboard.

    ``starts`` : each trial's true rotation and rate at its first sample, (2, n) rad and rad/s.
    """

    seed: int
    leg: Leg
    recorder: Recorder
    trials: tuple[Trial, ...]
    damping_ratio: Array
    starts: tuple[Array, ...] = ()

    @property
    def bare(self) -> Leg:
        """The leg as given to the fit: without springs and dampers."""
        nothing = {"spring": None, "damper": None, "effects": {}}
        return self.leg.with_joints(**dict.fromkeys(self.leg.joint_names, nothing))

    @property
    def off(self) -> Leg:
        """The leg as its file states it: links off by the usual tolerance, without springs and dampers."""
        generator = np.random.default_rng([self.seed, 501])
        widths = TOLERANCE_OF_LINKS.widths(self.leg)
        errors = generator.normal(size=widths.shape)
        errors[len(LINK_QUANTITIES) :] = 0.0
        return Tolerances(widths).leg(self.bare, errors.ravel())

    @property
    def overdamped(self) -> tuple[bool, ...]:
        """For each joint."""
        return tuple(bool(ratio > OVERDAMPED) for ratio in self.damping_ratio)


def random_recorder(generator: np.random.Generator) -> Recorder:
    """Noise 0.05-0.5 deg, 512-8192 counts, 100-1000 Hz, 1-30 trials; some with losses or driven at first."""
    noise, rate = (
        math.exp(generator.uniform(math.log(low), math.log(high))) for low, high in ((0.05, 0.5), (100, 1e3))
    )
    trials = round(math.exp(generator.uniform(0.0, math.log(30.4))))
    lost, driven = 0.05 * (generator.random() < 0.5), 0.15 * (generator.random() < 0.25)
    return Recorder(noise, int(2 ** generator.integers(9, 14)), rate, max(trials, 1), lost, driven)


def random_unevenness(seed: int) -> float:
    """Of the clock: none for half of the seeds, else 0.03 to 0.3 of a step. Nothing else of a case is changed."""
    generator = np.random.default_rng([seed, 502])
    return float(math.exp(generator.uniform(math.log(0.03), math.log(0.3)))) if generator.random() < 0.5 else 0.0


def random_leg(generator: np.random.Generator, links: int | None = None) -> tuple[Leg, Array]:
    """A leg between a rat's and a dog's size, and its joints' damping ratios (n,).

    Spring rates give 1-8 Hz with the inertia outboard, damping ratios are 0.08-3 (log-uniform): both regimes occur at
    every joint. Free angles leave the leg's rest pose within 60 deg of hanging.
    """
    n = int(generator.choice(LINK_NUMBERS)) if links is None else links
    size = math.exp(generator.uniform(math.log(0.03), math.log(0.25)))
    joints = []
    for name, zero in zip(NAMES[:n], (90.0, 180.0, 180.0, 180.0), strict=False):
        length = size * generator.uniform(0.7, 1.3)
        mass = 0.22 * (length / 0.22) ** 2 * generator.uniform(0.5, 2.0) * 0.7 ** len(joints)
        com = length * generator.uniform(0.3, 0.6)
        radius = length * generator.uniform(0.25, 0.33)  # of gyration; a rod's is 0.289 of its length
        sign = int(generator.choice((-1, 1)))
        joints.append(Joint(name, Link(length, mass, com, mass * radius**2), math.radians(zero), sign))
    leg = Leg("random leg", tuple(joints))
    inertia = outboard_inertia(leg)
    frequency = np.exp(generator.uniform(math.log(1.0), math.log(8.0), n))
    ratio = np.exp(generator.uniform(math.log(0.08), math.log(3.0), n))
    rate = inertia * (2 * math.pi * frequency) ** 2
    damping = 2 * ratio * np.sqrt(rate * inertia)
    unloaded = np.radians(generator.uniform(-45, 45, n))
    made = [
        replace(
            joint,
            spring=Spring(float(rate[j]), joint.zero + joint.sign * float(unloaded[j])),
            damper=Damper(float(damping[j])),
        )
        for j, joint in enumerate(joints)
    ]
    return replace(leg, joints=tuple(made)), ratio


def slowest_time(leg: Leg) -> float:
    """S, the slowest joint's time constant by itself: of its decay, or of its creep where it is overdamped."""
    inertia = outboard_inertia(leg)
    times = []
    for j, joint in enumerate(leg.joints):
        assert joint.spring is not None
        assert joint.damper is not None
        assert joint.damper.rate is not None
        natural = math.sqrt(joint.spring.rate / inertia[j])
        ratio = joint.damper.rate / (2 * inertia[j] * natural)
        slow = ratio - math.sqrt(ratio**2 - 1) if ratio > 1 else ratio
        times.append(1.0 / (slow * natural))
    return max(times)


def record(
    leg: Leg, recorder: Recorder, generator: np.random.Generator, name: str, duration: float
) -> tuple[Trial, Array]:
    """One release from 8-30 deg off the rest pose, every joint in its own direction, with a small initial rate.

    Also its true start (2, n): rotation and rate.
    """
    n = len(leg.joints)
    away = np.radians(generator.uniform(8, 30, n)) * generator.choice((-1, 1), n)
    start, first = rest_pose(leg) + away, generator.normal(0.0, 0.2, n)
    steps = np.ones(round(duration * recorder.rate))
    if recorder.uneven:  # the stamps are right
        clock = np.random.default_rng(generator.bit_generator.seed_seq.spawn(1)[0])  # type: ignore[attr-defined]
        steps += np.clip(recorder.uneven * clock.normal(size=len(steps)), -2.5 * recorder.uneven, 2.5 * recorder.uneven)
    times = np.concatenate([[0.0], np.cumsum(steps)]) / recorder.rate
    pushed = None
    if recorder.driven:
        stiffness = np.array([joint.spring.rate if joint.spring else 0.0 for joint in leg.joints])
        push = stiffness * np.radians(15.0) * generator.choice((-1, 1), n)
        shape = np.where(times < recorder.driven, np.sin(np.pi * times / recorder.driven) ** 2, 0.0)
        pushed = (times, np.ascontiguousarray(shape[:, None] * push))
    rotation = simulate(leg, start, first, times, tolerance=TOLERANCE, known_torque=pushed)
    angle = leg.to_measured(rotation) + np.radians(generator.normal(0.0, recorder.noise, rotation.shape))
    if recorder.counts:
        count = 2 * math.pi / recorder.counts
        angle = count * np.round(angle / count)
    angle[generator.random(angle.shape) < recorder.lost] = np.nan
    return Trial(name, times, angle), np.array([start, first])


def random_case(seed: int, recorder: Recorder | None = None, links: int | None = None) -> Case:
    """The case of one seed; a given ``recorder`` does not change the leg."""
    generator = np.random.default_rng([seed, 500])
    leg, ratio = random_leg(generator, links)
    drawn = random_recorder(generator)
    recorder = recorder or replace(drawn, uneven=random_unevenness(seed))
    # Recordings end after the motion has decayed, but not later than is usual for a creeping leg.
    duration = float(np.clip(4.0 * slowest_time(leg), 0.6, 3.0))
    made = [record(leg, recorder, generator, f"release {i}", duration) for i in range(recorder.trials)]
    return Case(seed, leg, recorder, tuple(trial for trial, _ in made), ratio, tuple(start for _, start in made))


def with_law(case: Case, effect: str) -> Case:
    """The case let go freely, every joint with another law; the true leg has it, ``off`` and ``bare`` do not.

    Dry friction of 8 % of the spring's torque at 15 deg, quadratic damping of half the damper's rate at 1 rad/s, or a
    spring whose cubic torque at 1 rad is that of its rate: at 15 deg it is 7 % stiffer.
    """
    effects = {}
    for joint in case.leg.joints:
        assert joint.spring is not None
        assert joint.damper is not None
        assert joint.damper.rate is not None
        size = {
            "coulomb_friction": ("torque", 0.08 * joint.spring.rate * math.radians(15.0)),
            "quadratic_damping": ("coefficient", 0.5 * joint.damper.rate),
            "hardening_spring": ("stiffening", joint.spring.rate),
        }[effect]
        effects[joint.name] = {"effects": {effect: dict([size])}}
    recorder, generator = replace(case.recorder, driven=0.0), np.random.default_rng(case.seed)
    leg, names = case.leg.with_joints(**effects), [(trial.name, float(trial.time[-1])) for trial in case.trials]
    made = [record(leg, recorder, generator, name, duration) for name, duration in names]
    trials, starts = zip(*made, strict=True)
    return replace(case, leg=leg, recorder=recorder, trials=trials, starts=starts)
