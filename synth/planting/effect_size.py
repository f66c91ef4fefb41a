"""The gap that a cause leaves, the size of a cause for a wanted gap, and the cause that resembles it most."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.planting.effect_makers import EFFECTS, EFFECTS_AT_BASE
from synth.planting.explained_gap import PlainFit, PlainModel
from synth.planting.forms import Form, Scale
from synth.planting.model import Array, Law, Truth
from synth.planting.refusals import NotApplicable, TooSmall
from synth.planting.sensors import PlantedSensor
from synth.planting.setup import ENCODER_COUNTS, SENSOR_NOISES, Setup
from synth.planting.simulation import Motion, fastest, release
from synth.planting.torque_laws import CROSS, FADING_DAMPER, PLATEAU


@dataclass(frozen=True)
class PlantedCause:
    """One effect with the size that leaves the wanted gap; ``strength`` wanted and ``reached`` in noise floors."""

    effect: str
    joint: int  # -1: the base, -2: all channels
    strength: float
    reached: float
    form: Form
    size: float


class PlainMotion:
    """The motion of a case without effects, its linearised model, and the gap that a true leg leaves.

    Raises
    ------
    NotApplicable : the leg hardly moves, or is too stiff to simulate.
    """

    def __init__(self, setup: Setup) -> None:
        self.setup = setup
        self.floor = setup.floor
        self.step = self.step_for(Truth(setup.true))
        self.plain = [release(Truth(setup.true), t, self.step) for t in setup.trials]
        self.times = [setup.times(i) for i in range(len(setup.trials))]
        self.scale = self._scale()
        if self.scale.travel.max() < 12 * self.floor:
            raise NotApplicable("the leg hardly moves")
        states = [self._state(m, t.start) for m, t in zip(self.plain, setup.trials, strict=True)]
        self.model = PlainModel(setup, self.floor, states)

    def step_for(self, truth: Truth) -> float:
        """Step size, s, that resolves the fastest mode and all events.

        Raises
        ------
        NotApplicable : too stiff to simulate.
        """
        quick = max(fastest(truth, t) for t in self.setup.trials)
        if quick > 2.5e4:  # 1/s: beyond it the engine's steps take minutes
            raise NotApplicable("too stiff to simulate")
        return float(np.clip(0.7 / quick, 2.5e-5, 2.5e-4))  # the modes of a stiff link need only stability

    def _state(self, motion: Motion, start: float) -> Array:
        at = np.array([start])
        speed = Motion(motion.step, motion.speed, np.gradient(motion.speed, motion.step, axis=0))
        return np.concatenate([motion.at(at)[0], speed.at(at)[0]])

    def _scale(self) -> Scale:
        given = [i for i, t in enumerate(self.setup.trials) if not t.held_out]
        free = {i: [j for j in range(self.setup.true.n) if j not in self.setup.trials[i].locked] for i in given}
        travel, speed = np.zeros(self.setup.true.n), np.zeros(self.setup.true.n)
        low, high = np.full(self.setup.true.n, 99.0), np.full(self.setup.true.n, -99.0)
        rests = []
        for i in given:
            j, motion = free[i], self.plain[i]
            travel[j] = np.maximum(travel[j], np.ptp(motion.angle, axis=0)[j])
            speed[j] = np.maximum(speed[j], np.abs(motion.speed).max(axis=0)[j])
            low[j] = np.minimum(low[j], motion.angle.min(axis=0)[j])
            high[j] = np.maximum(high[j], motion.angle.max(axis=0)[j])
            if not self.setup.trials[i].tilt and not self.setup.trials[i].tip_mass:
                rests.append(motion.angle[-1])
        leg = self.setup.true
        slow = min(self._natural_frequency(j, travel, speed) for j in range(leg.n))
        if not rests:
            rests = [self.plain[i].angle[-1] for i in given]
        return Scale(travel, speed, low, high, np.mean(rests, axis=0), slow)

    def _natural_frequency(self, j: int, travel: Array, speed: Array) -> float:
        """Natural frequency of a joint, rad/s: of spring and outboard inertia, without a spring 2 speed / travel."""
        k = float(self.setup.true.of("spring")[j])
        if k > 0.0:
            return math.sqrt(k / self.setup.true.outboard(j))
        return 2.0 * float(speed[j] / travel[j]) if travel[j] > 0.0 else math.inf

    def run(self, truth: Truth, sensor: PlantedSensor, *, every: bool) -> list[Motion | None]:
        """Motion of each trial; None for held-out trials unless ``every``."""
        simple = (
            not truth.laws
            and truth.base is None
            and not truth.bends
            and not truth.tilt
            and truth.leg is self.setup.true
            and not truth.rotors
            and not any(truth.drive)
            and not truth.servo_errors
        )
        if simple and sensor.reach == 0:
            return list(self.plain)
        step = self.step if simple else self.step_for(truth)
        found: list[Motion | None] = []
        for trial in self.setup.trials:
            if trial.held_out and not every:
                found.append(None)
                continue
            longer = trial._replace(duration=trial.duration + sensor.reach)
            found.append(release(truth, longer, step, self.scale.rest))
        return found

    def targets(self, motions: list[Motion | None], sensor: PlantedSensor) -> tuple[list[Array], list[Array]]:
        """Noise-free readings as rotations (m, n) rad at the fit's times, and each trial's initial state (2 n,)."""
        leg, seen, states = self.setup.true, [], []
        for i, (motion, trial) in enumerate(zip(motions, self.setup.trials, strict=True)):
            if motion is None:
                seen.append(np.zeros(0))
                states.append(np.zeros(0))
                continue
            rotation = (sensor.read(leg, motion, self.model.times[i], trial.start) - leg.zero) * leg.sign
            state = self._state(motion, trial.start)
            locked = list(trial.locked)
            state[locked] = rotation[:, locked].mean(axis=0)
            seen.append(rotation)
            states.append(state)
        return seen, states

    def gap(self, truth: Truth, sensor: PlantedSensor) -> PlainFit:
        """The gap: residual of the given trials after tolerances and initial states are fitted."""
        return self.model.fit(*self.targets(self.run(truth, sensor, every=False), sensor))

    def _take_better_sensor(self, share: float) -> bool:
        """Take the next better sensor that lowers the noise floor to less than 0.9 ``share`` of it; False if none."""
        if self.setup.keeps_sensor:
            return False
        for noise in sorted(SENSOR_NOISES, reverse=True):
            floor = math.sqrt(noise**2 + (2 * math.pi / ENCODER_COUNTS[-1]) ** 2 / 12)
            if noise < float(np.max(self.setup.noise)) and floor < 0.9 * share * self.floor:
                self.setup = replace(self.setup, noise=noise, counts=ENCODER_COUNTS[-1])
                self.floor = floor
                self.model.lower_noise(floor)
                return True
        return False

    def find(self, effect: str, joint: int, form: Form, strength: float, near: float = 0.04) -> PlantedCause:
        """The size whose gap is ``strength`` noise floors, within the relative tolerance ``near``.

        Where the largest size leaves less, the case gets the next better sensor, unless its setup keeps its own:
        ``setup`` and ``floor`` are then that sensor's, and causes found before have other strengths.

        Bracketed false position on the logarithms of size and gap. The gap is not a power of the size: the tolerances
        may explain a small effect completely, and the gap rises steeply once they are used up.

        Raises
        ------
        NotApplicable : the largest size leaves a smaller gap, or the search does not converge.
        """
        if form.largest <= 0.0:
            raise NotApplicable(f"{effect}: the joint lacks what it changes")
        top = math.log(form.largest)
        # A start only: 3 % of the largest size for each floor wanted.
        x = top + math.log(min(0.5, 0.03 * strength))
        low: tuple[float, float] | None = None  # (log size, log gap / strength), below
        high: tuple[float, float] | None = None
        for _ in range(12):
            size = math.exp(x)
            reached = self.gap(*form.build(size)).rms / self.floor
            miss = math.log(max(reached, 1e-6) / strength)
            if abs(miss) < near:
                return PlantedCause(effect, joint, strength, reached, form, size)
            if miss < 0 and x >= top - 1e-9:
                if not self._take_better_sensor(reached / strength):
                    raise TooSmall(f"{effect}: {reached:.2g} floors at most")
                low = high = None
                continue
            if miss < 0:
                low = (x, miss)
            else:
                high = (x, miss)
            if low is None or high is None:
                # Logarithms: at most a factor of 4.5 up and 12 down in a step.
                x = min(x - float(np.clip(miss, -1.5, 2.5)), top)
            else:
                # Regula falsi, kept off the ends.
                share = float(np.clip(-low[1] / (high[1] - low[1]), 0.15, 0.85))
                x = low[0] + share * (high[0] - low[0])
        raise NotApplicable(f"{effect}: no size found")

    def nearest(
        self, rng: np.random.Generator, truth: Truth, sensor: PlantedSensor, names: Sequence[str], joints: Sequence[int]
    ) -> tuple[str, int, float]:
        """The effect among ``names`` that explains most of the gap: effect, joint, share of the gap that remains.

        Each effect is simulated in one of the generator's forms at a size with a similar gap; its motion is then scaled
        linearly.
        """
        targets, states = self.targets(self.run(truth, sensor, every=False), sensor)
        gap = self.model.fit(targets, states).rms / self.floor
        best = ("", -1, 1.0)
        for name in names:
            for j in [-1] if name in EFFECTS_AT_BASE else joints:
                try:
                    form = EFFECTS[name](rng, self.setup, self.scale, max(j, 0))
                    size = 0.1 * form.largest
                    for _ in range(2):
                        seen = self.targets(self.run(*(built := form.build(size)), every=False), built[1])[0]
                        reached = self.model.fit(seen, states).rms / self.floor
                        # At most a factor of 20 in a step.
                        size, last = min(size * float(np.clip(gap / max(reached, 1e-6), 0.05, 20)), form.largest), size
                        if abs(size / last - 1) < 0.4:  # a rough size is enough to begin with
                            break
                    share = self.model.explained(targets, seen, states) / gap
                except (NotApplicable, ArithmeticError, np.linalg.LinAlgError):
                    continue
                if share < best[2]:
                    best = (name, j, share)
        return best


def combined(setup: Setup, causes: Sequence[PlantedCause]) -> tuple[Truth, PlantedSensor]:
    """True leg and sensors with all causes; changes of the leg and errors of the sensors add up.

    Raises
    ------
    NotApplicable : two causes each have a moving mount, or together take more than a joint's damper.
    """
    _check_dampers(setup, causes)
    truth, sensor = Truth(setup.true), PlantedSensor.good(setup.true.n)
    for cause in causes:
        t, s = cause.form.build(cause.size)
        if t.base is not None and truth.base is not None:
            raise NotApplicable("two causes have a moving mount")
        leg = truth.leg
        if t.leg is not setup.true:
            leg = replace(leg, values=leg.values + t.leg.values - setup.true.values)
        truth = Truth(
            leg,
            truth.laws + t.laws,
            truth.base or t.base,
            truth.bends + t.bends,
            truth.tilt + t.tilt,
            truth.bare + t.bare,
            truth.rotors + t.rotors,
            (truth.drive[0] + t.drive[0], truth.drive[1] + t.drive[1], truth.drive[2] + t.drive[2]),
            max(truth.drive_joint, t.drive_joint),
            truth.servo_errors + t.servo_errors,
        )
        sensor = PlantedSensor(
            sensor.offset + s.offset,
            sensor.scale + s.scale,
            np.maximum(sensor.width, s.width),
            sensor.latency + s.latency,
            sensor.lag + s.lag,
            sensor.talk + s.talk,
            sensor.talk_about + s.talk_about,
            s.wobble or sensor.wobble,
            sensor.drops + s.drops,
        )
    return truth, sensor


def _check_dampers(setup: Setup, causes: Sequence[PlantedCause]) -> None:
    """Raise if causes together take more of a joint's damper than there is: it would drive the joint.

    A damper of half its rate and shear thinning, each 0.2 deg of gap alone, made a leg that swung by itself.
    """
    taken = np.zeros(setup.true.n)
    for cause in causes:
        truth, _ = cause.form.build(cause.size)
        rate, less = setup.true.of("damper"), truth.leg.of("damper")
        taken += np.where(rate > 0.0, 1.0 - less / np.where(rate > 0.0, rate, 1.0), 0.0).clip(min=0.0)
        for law in truth.laws:
            taken[law.joint] += _weakening(law, cause.size)
    if np.any(taken > 1.0):
        raise NotApplicable("two causes take more than the damper")


def _weakening(law: Law, size: float) -> float:
    """Share of the damper that a law takes at the largest speed, ``size`` times that at which it begins."""
    if law.law == FADING_DAMPER:
        return law.par[1]
    if law.law == CROSS:
        return float(1.0 - 1.0 / (1.0 + size ** law.par[2]))
    if law.law == PLATEAU:
        return float(1.0 - min(1.0, size ** (law.par[2] - 1.0)))
    return 0.0
