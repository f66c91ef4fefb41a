"""Random legs, and trials as a laboratory would make them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from synth.planting.model import PARAMETERS, PlantedLeg, PlantedTrial
from synth.planting.model import Truth as _Truth
from synth.planting.setup import ENCODER_COUNTS, SENSOR_NOISES, Setup, as_built
from synth.planting.simulation import assemble, equilibrium, fastest

NAMES = ("hip", "knee", "ankle")
ZEROS = (0.0, 90.0, 180.0, -45.0, 105.0, 30.0)
SAMPLES = (200, 250, 500, 1000)  # Hz


def _round(value: float, digits: int = 5) -> float:
    return float(f"{value:.{digits}g}")


def design(rng: np.random.Generator, joints: int) -> PlantedLeg:
    """A leg as designed, its numbers as a file writes them (five digits)."""
    first = math.exp(rng.uniform(math.log(0.016), math.log(0.28)))
    density = math.exp(rng.uniform(math.log(0.8), math.log(3.2)))
    length = first * np.cumprod([1.0, *rng.uniform(0.72, 1.12, joints - 1)])
    mass = (
        density
        * first
        * (first / 0.2) ** rng.uniform(-0.3, 0.3)
        * np.cumprod([1.0, *rng.uniform(0.25, 0.55, joints - 1)])
    )
    com = length * rng.uniform(0.42, 0.56, joints)
    inertia = mass * length**2 / 12 * rng.uniform(0.9, 1.35, joints)
    values = np.stack([length, mass, com, inertia, *3 * [np.zeros(joints)]])
    zero = np.radians([rng.choice(ZEROS) for _ in range(joints)])
    tilt = math.radians(round(float(rng.normal(0, 5)), 1)) if rng.random() < 0.4 else 0.0
    leg = PlantedLeg(NAMES[:joints], zero, rng.choice([-1.0, 1.0], joints), tilt, values)
    for i in range(joints):
        load = leg.outboard(i)
        slow = math.sqrt(9.81 / length[0])  # small legs move fast
        omega = slow * math.exp(rng.uniform(math.log(0.9), math.log(3.2)))
        ratio = math.exp(rng.uniform(math.log(0.04), math.log(0.7)))
        if rng.random() < 0.15:
            ratio = rng.uniform(1.0, 2.5)  # overdamped
        hold = 0.6 * sum(leg.of("mass")[i:]) * 9.81 * leg.of("com")[i] if rng.random() < 0.5 else 0.0
        leg = leg.changed("spring", i, load * omega**2 + hold)
        leg = leg.changed("damper", i, 2 * ratio * load * math.sqrt(omega**2 + hold / load))
        leg = leg.changed("free_angle", i, rng.uniform(-1, 1) * math.radians(40 if i == 0 else 65))
    rounded = np.array([[_round(float(v)) for v in row] for row in leg.values])
    reading = np.array([_round(float(np.degrees(v)), 6) for v in leg.reading(leg.of("free_angle"))])
    rounded[PARAMETERS.index("free_angle")] = leg.sign * (np.radians(reading) - leg.zero)
    return PlantedLeg(leg.names, leg.zero, leg.sign, leg.tilt, rounded)


@dataclass(frozen=True)
class Wish:
    """Special requirements of a case on its trials."""

    one_side: int | None = None  # a joint that is released from the same side of its rest in every trial
    plain: bool = False  # only plain releases given (no tip mass, lock or tilt): few causes are distinguished
    lock: tuple[int, ...] = ()  # locked in every given trial
    reach: float | None = None  # of the releases, instead of one drawn
    noise: float | None = None


def setup(rng: np.random.Generator, joints: int, wish: Wish = Wish()) -> Setup:
    """Leg, trials and sensors, drawn."""
    nominal = design(rng, joints)
    true = as_built(rng, nominal)
    slowest = min(math.sqrt(nominal.of("spring")[i] / nominal.outboard(i)) for i in range(joints))
    base = float(np.clip(round(rng.uniform(3.0, 7.0) * 2 * math.pi / slowest, 1), 1.0, 3.0))
    trials = _trials(rng, true, base, wish)
    quick = max(fastest(_Truth(true), t) for t in trials)
    fast = max(200.0, 8 * quick / (2 * math.pi))
    sampling = float(rng.choice([s for s in SAMPLES if s >= min(fast, 500.0)]))
    noise = float(rng.choice(SENSOR_NOISES)) if wish.noise is None else wish.noise
    counts = int(rng.choice(ENCODER_COUNTS if noise > 0.0005 else ENCODER_COUNTS[1:]))
    missing = float(rng.choice([0.0, 0.0, 0.0, rng.uniform(0.002, 0.02)]))
    return Setup(nominal, true, trials, bool(rng.random() < 0.5), noise, counts, sampling, missing, quick)


def rest_pose(leg: PlantedLeg, trial: PlantedTrial, tilt: float = 0.0) -> NDArray[np.float64]:
    """Rotations (n,) rad of the leg at rest on its springs, with locked joints at the trial's pose."""
    a = assemble(_Truth(leg, tilt=tilt), trial._replace(tip_mass=trial.tip_mass))
    start = leg.of("free_angle").copy()
    start[list(trial.locked)] = trial.pose[list(trial.locked)]
    return equilibrium(a, start, ~a.fixed)


def _trials(rng: np.random.Generator, leg: PlantedLeg, base: float, wish: Wish) -> tuple[PlantedTrial, ...]:
    """8 to 10 trials; about half are held out, half of these beyond the range of the given ones."""
    n = leg.n
    total = int(rng.integers(8, 11))
    given = (total + 1) // 2 + int(rng.random() < 0.5)
    reach = math.exp(rng.uniform(math.log(0.35), math.log(1.0))) if wish.reach is None else wish.reach
    reach = np.radians(np.array([28.0, 38.0, 40.0][:n])) * reach
    side = rng.choice([-1.0, 1.0])
    rest = rest_pose(leg, PlantedTrial(np.zeros(n), 1.0))
    heavy = _round(float(leg.of("mass").sum() * rng.uniform(0.03, 0.08)), 2)
    tilt = math.radians(float(rng.choice([-40, -30, -20, 20, 30, 40])))
    lock = tuple(sorted(rng.choice(n, int(rng.integers(1, n)), replace=False).tolist())) if n > 1 else ()
    special = []
    if not wish.plain:
        special = [s for s, p in (("mass", 0.75), ("lock", 0.75), ("tilt", 0.55)) if rng.random() < p]
    special = special[: given - 3]
    specials: list[str] = special + [""] * (given - len(special))
    away = ["amplitude", "pose", "load", "tilt"]
    held = ["inside"] * ((total - given + 1) // 2)
    held += [str(rng.choice(away, p=[0.45, 0.2, 0.2, 0.15])) for _ in range(total - given - len(held))]
    trials = []
    for kind in [*specials, *held]:
        scale = rng.uniform(0.35, 1.0)
        if kind == "amplitude":
            scale = rng.uniform(1.2, 1.6)
        direction = rng.uniform(0.35, 1.0, n) * rng.choice([-1.0, 1.0], n)
        if rng.random() < 0.35:
            direction[0] *= 0.3
        if wish.one_side is not None:
            direction[wish.one_side] = side * rng.uniform(0.6, 1.0)
        trial = PlantedTrial(
            pose=np.zeros(n),
            duration=base * float(rng.choice([1.0, 1.0, 1.0, 1.5, 2.0])),
            start=float(rng.choice([0.0, rng.uniform(0.004, 0.05) * base])),
            tip_mass={"mass": heavy, "load": _round(1.8 * heavy, 2)}.get(kind, 0.0),
            locked=lock if kind == "lock" else wish.lock if len(trials) < given else (),
            tilt=tilt if kind == "tilt" and len(trials) < given else (-0.7 * tilt if kind == "tilt" else 0.0),
            held_out=len(trials) >= given,
            outside=kind in away,
        )
        if kind == "pose" and n > 1:
            direction = direction[::-1].copy() * rng.choice([-1.0, 1.0], n)
            if wish.one_side is not None:
                direction[wish.one_side] = side * rng.uniform(0.6, 1.0)
        pose = rest + direction * scale * reach
        if trial.locked:  # locked joints are held near their rest, but not at it
            held_at = list(trial.locked)
            pose[held_at] = (rest + rng.uniform(-0.6, 0.6, n) * reach)[held_at]
        trials.append(trial._replace(pose=pose, duration=round(trial.duration, 3)))
    order = rng.permutation(len(trials))
    return tuple(trials[i] for i in order)
