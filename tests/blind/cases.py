"""One case: a leg, its trials, an effect of the wanted strength, the recordings, and the answer."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from blind import legs
from blind.effects import AT_BASE, EFFECTS, Form, Scale, Unfit
from blind.fitting import Fitted, Plain
from blind.legs import COUNTS, NOISE, Setup, Wish
from blind.model import Array, Motion, Truth, fastest, release
from blind.outsiders import EVERYWHERE, OUTSIDERS
from blind.sensors import Sensor

STRENGTHS = (1.5, 3.0, 6.0, 12.0)
SAME_CHI = 6.0  # explanations whose chi squared differ by less are not told apart
KINDS = ("single", "two", "none", "unknown", "tie")
ATTEMPTS = 60
# How ties are made: (effects of which one is true, joints of the leg, what the trials are like).
TIES: tuple[tuple[tuple[str, ...], int, Wish], ...] = (
    (("spring_preload", "base_tilt", "encoder_offset"), 1, Wish(plain=True, reach=0.2)),
    (("link_mass",), 1, Wish(plain=True)),  # one link swings by its moment and its inertia, whatever its mass
    (("encoder_offset", "base_tilt"), 2, Wish(plain=True, lock=(0,))),  # nothing shows where the base is level
    (("encoder_offset", "base_tilt"), 3, Wish(plain=True, lock=(0,))),
    (("spring_preload", "base_tilt"), 2, Wish(plain=True, reach=0.3, noise=NOISE[-1])),
)


@dataclass(frozen=True)
class Cause:
    """One effect with its size found."""

    effect: str
    joint: int  # -1: base, -2: all
    strength: float
    reached: float
    form: Form
    size: float


@dataclass(frozen=True)
class Case:
    """All that is written: recordings (m, n) rad of measured angles, NaN where a sample is missing, and the answer."""

    setup: Setup
    times: tuple[Array, ...]
    readings: tuple[Array, ...]
    answer: dict[str, Any]


class Ground:
    """Leg, trials and sensors before any effect: plain motions, columns, and the gap that a truth leaves."""

    def __init__(self, setup: Setup) -> None:
        self.setup = setup
        self.floor = math.sqrt(setup.noise**2 + (2 * math.pi / setup.counts) ** 2 / 12)
        self.step = self.fine(Truth(setup.true))
        self.plain = [release(Truth(setup.true), t, self.step) for t in setup.trials]
        self.times = [np.arange(round(t.duration * setup.sampling) + 1) / setup.sampling for t in setup.trials]
        self.scale = self._scale()
        if self.scale.travel.max() < 12 * self.floor:
            raise Unfit("hardly moves")
        states = [self._state(m, t.start) for m, t in zip(self.plain, setup.trials, strict=True)]
        self.model = Plain(setup, self.floor, states)

    def fine(self, truth: Truth) -> float:
        """A step that follows the fastest mode and every event."""
        quick = max(fastest(truth, t) for t in self.setup.trials)
        if quick > 2.5e4:
            raise Unfit("too stiff to simulate")
        return float(np.clip(0.7 / quick, 2.5e-5, 2.5e-4))  # a stiff link's own modes need stability only

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
        slow = min(math.sqrt(leg.of("spring")[j] / leg.outboard(j)) for j in range(leg.n))
        return Scale(travel, speed, low, high, np.mean(rests, axis=0), slow)

    def run(self, truth: Truth, sensor: Sensor, every: bool) -> list[Motion | None]:
        """Motions of the trials (only the given ones unless ``every``)."""
        simple = (
            not truth.laws
            and truth.base is None
            and not truth.bends
            and not truth.tilt
            and truth.leg is self.setup.true
        )
        if simple and sensor.reach == 0:
            return list(self.plain)
        step = self.step if simple else self.fine(truth)
        found: list[Motion | None] = []
        for trial in self.setup.trials:
            if trial.held_out and not every:
                found.append(None)
                continue
            longer = trial._replace(duration=trial.duration + sensor.reach)
            found.append(release(truth, longer, step, self.scale.rest))
        return found

    def targets(self, motions: list[Motion | None], sensor: Sensor) -> tuple[list[Array], list[Array]]:
        """Noise-free readings turned into rotations at the fit's times, and the states to start the fit from."""
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

    def gap(self, truth: Truth, sensor: Sensor) -> Fitted:
        """What the truth leaves on the given trials after tolerances and initial states."""
        return self.model.fit(*self.targets(self.run(truth, sensor, False), sensor))

    def _quieten(self, share: float) -> bool:
        """Take the next better sensor, if it is worth it: the floor falls at least to ``share`` of what it is."""
        for noise in sorted(NOISE, reverse=True):
            floor = math.sqrt(noise**2 + (2 * math.pi / COUNTS[-1]) ** 2 / 12)
            if noise < self.setup.noise and floor < 0.9 * share * self.floor:
                self.setup = replace(self.setup, noise=noise, counts=COUNTS[-1])
                self.floor = floor
                self.model.quieter(floor)
                return True
        return False

    def find(self, effect: str, joint: int, form: Form, strength: float) -> Cause:
        """The size whose gap is ``strength`` floors: false position in the logarithms of both, kept in its bracket.

        The gap is no power of the size: it may be nothing until the tolerances are used up, and then rise steeply.
        """
        top = math.log(form.largest)
        x = top + math.log(min(0.5, 0.03 * strength))
        low: tuple[float, float] | None = None  # (log size, log gap / strength), below
        high: tuple[float, float] | None = None
        for _ in range(12):
            size = math.exp(x)
            reached = self.gap(*form.build(size)).rms / self.floor
            miss = math.log(max(reached, 1e-6) / strength)
            if abs(miss) < 0.04:
                return Cause(effect, joint, strength, reached, form, size)
            if miss < 0 and x >= top - 1e-9:
                if not self._quieten(reached / strength):
                    raise Unfit(f"{effect}: {reached:.2g} floors at most")
                low = high = None
                continue
            if miss < 0:
                low = (x, miss)
            else:
                high = (x, miss)
            if low is None or high is None:
                x = min(x - float(np.clip(miss, -1.5, 2.5)), top)
            else:
                share = float(np.clip(-low[1] / (high[1] - low[1]), 0.15, 0.85))
                x = low[0] + share * (high[0] - low[0])
        raise Unfit(f"{effect}: no size found")


def make_case(seed: int, number: int, kind: str, effect: str | None = None, strength: float | None = None) -> Case:
    """Case ``number`` of a set; the same arguments give the same case.

    Raises
    ------
    Unfit
        If no leg drawn can show the effect.
    """
    rng = np.random.default_rng([seed, number, KINDS.index(kind)])
    tie = TIES[int(rng.integers(0, len(TIES)))]
    if effect is None:
        pool = OUTSIDERS if kind == "unknown" else EFFECTS
        effect = str(rng.choice(tie[0])) if kind == "tie" else str(rng.choice(sorted(pool)))
    if strength is None:
        strength = float(rng.choice(STRENGTHS[1:] if kind == "unknown" else STRENGTHS))
    for attempt in range(ATTEMPTS):
        if attempt % 6 == 5 and strength > STRENGTHS[0]:  # this strength may not be had with plausible parameters
            strength = STRENGTHS[STRENGTHS.index(strength) - 1]
        try:
            return _attempt(rng, [seed, number], kind, effect, strength, tie[1:] if kind == "tie" else None)
        except (Unfit, ArithmeticError, np.linalg.LinAlgError):
            continue
    raise Unfit(f"{kind} {effect}: no case in {ATTEMPTS} attempts")


def _attempt(
    rng: np.random.Generator, seed: list[int], kind: str, effect: str, strength: float, tie: tuple[int, Wish] | None
) -> Case:
    """One leg drawn; raises if it cannot show what is wanted."""
    joints = int(rng.choice([1, 2, 3], p=[0.1, 0.35, 0.55]))
    side, wish = None, Wish()
    if effect == "joint_stop":
        side = int(rng.integers(0, joints))
        wish = Wish(one_side=side)
    if tie is not None:
        joints, wish = tie
        side = 0
    ground = Ground(legs.setup(rng, joints, wish))
    causes: list[Cause] = []
    if kind != "none":
        causes.append(_cause(rng, ground, effect, side, strength))
    if kind == "two":
        second = str(rng.choice(sorted(set(EFFECTS) - {effect})))
        floor = ground.floor
        causes.append(_cause(rng, ground, second, None, float(rng.choice(STRENGTHS[1:]))))
        if ground.floor != floor:
            causes[0] = ground.find(effect, causes[0].joint, causes[0].form, strength)
    truth, sensor = _together(ground.setup, causes)
    tied = _tied(ground, truth, sensor, causes, kind)
    return _record(rng, ground, truth, sensor, causes, tied, {"seed": seed, "kind": kind})


def _cause(rng: np.random.Generator, ground: Ground, effect: str, joint: int | None, strength: float) -> Cause:
    """The effect at a joint (drawn if None) with its size found; each joint is tried before the leg is given up."""
    maker = OUTSIDERS.get(effect) or EFFECTS[effect]
    order = rng.permutation(ground.setup.true.n).tolist() if joint is None else [joint]
    failed = Unfit("no joint")
    for j in [-1] if effect in AT_BASE else order:
        try:
            form = maker(rng, ground.setup, ground.scale, max(j, 0))
            return ground.find(effect, -2 if effect in EVERYWHERE else j, form, strength)
        except Unfit as why:
            failed = why
    raise failed


def _together(setup: Setup, causes: list[Cause]) -> tuple[Truth, Sensor]:
    """All causes at once; changes of the leg and of the sensors add up."""
    truth, sensor = Truth(setup.true), Sensor.good(setup.true.n)
    for cause in causes:
        t, s = cause.form.build(cause.size)
        if t.base is not None and truth.base is not None:
            raise Unfit("two mounts")
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
        )
        sensor = Sensor(
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


def _tied(ground: Ground, truth: Truth, sensor: Sensor, causes: list[Cause], kind: str) -> list[tuple[str, int, float]]:
    """Other single causes that do as well as the true one: (effect, joint, chi squared more than the truth's)."""
    if kind == "none":
        return []
    model = ground.model
    targets, states = ground.targets(ground.run(truth, sensor, False), sensor)
    plain = ground.targets(list(ground.plain), Sensor.good(ground.setup.true.n))
    trueness = model.fit(*plain).cost  # the truth's own: the price of its tolerance errors
    fits = []
    for other in model.alternatives():
        if any(other.effect == c.effect and other.joint == c.joint for c in causes):
            continue
        linear = model.linear_cost(targets, states, other.freed) - trueness
        if linear > 400.0 and kind != "unknown":
            continue
        fitted = model.fit(targets, states, other.freed)
        if model.plausible(other, fitted.change):
            fits.append((other, fitted))
    if kind == "unknown":  # what the library explains is no case of the unknown
        before = model.fit(targets, states)
        if any(f.rms < max(0.5 * before.rms, 1.2 * ground.floor) for _, f in fits):
            raise Unfit("the library would do")
        return []
    tied = [(o.effect, o.joint, f.cost - trueness) for o, f in fits if f.cost - trueness < SAME_CHI]
    if kind == "tie" and not tied:
        raise Unfit("told apart")
    return tied


def _record(
    rng: np.random.Generator,
    ground: Ground,
    truth: Truth,
    sensor: Sensor,
    causes: list[Cause],
    tied: list[tuple[str, int, float]],
    note: dict[str, Any],
) -> Case:
    setup, leg = ground.setup, ground.setup.true
    motions = ground.run(truth, sensor, True)
    targets, states = ground.targets(motions, sensor)
    fitted = ground.model.fit(targets, states)
    before = ground.model.held_out(targets, states, fitted.change)
    readings, floors, best, counted = [], [], [], []
    plain = Sensor.good(leg.n)
    for motion, trial, times in zip(motions, setup.trials, ground.times, strict=True):
        assert motion is not None
        clean = sensor.read(leg, motion, times, trial.start, counted=False)
        noise = np.random.default_rng(rng.integers(0, 2**63))
        reading = sensor.record(clean, setup.noise, setup.counts, noise)
        free = [j for j in range(leg.n) if j not in trial.locked]
        again = plain.record(clean, setup.noise, setup.counts, np.random.default_rng(rng.integers(0, 2**63)))
        floors.append((again - clean)[:, free].ravel())
        if trial.held_out:
            best.append((reading - clean)[:, free].ravel())
            counted.append((reading - sensor.read(leg, motion, times, trial.start))[:, free].ravel())
        if setup.missing:
            reading = np.where(rng.random(reading.shape) < setup.missing, np.nan, reading)
        readings.append(reading)
    floor = _rms(floors)
    names = {-1: "base", -2: "all", **dict(enumerate(leg.names))}
    single = [(c.effect, c.joint) for c in causes]
    answer = {
        "kind": "tie" if tied and note["kind"] == "single" else note["kind"],
        "effects": [
            {
                "effect": c.effect,
                "joint": names[c.joint],
                "strength": c.strength,
                "in_library": c.effect in EFFECTS,
                "reached": round(c.reached, 3),
                "form": c.form.name,
                "parameters": c.form.tell(c.size),
            }
            for c in causes
        ],
        "cannot_be_told_apart": [[e, names[j]] for e, j, _ in tied]
        + ([[single[0][0], names[single[0][1]]]] if tied else []),
        "chi_squared_more": [round(x, 2) for *_, x in tied],
        "noise_floor_deg": round(math.degrees(floor), 5),
        "before_deg": round(math.degrees(math.hypot(before, floor)), 5),
        "best_possible_deg": round(math.degrees(min(_rms(best), _rms(counted))), 5),
        "given_gap_over_floor": round(fitted.rms / ground.floor, 3),
        "seed": note["seed"],
    }
    return Case(setup, tuple(ground.times), tuple(readings), answer)


def _rms(parts: list[Array]) -> float:
    joined = np.concatenate(parts)
    return float(np.sqrt(np.mean(joined**2)))
