"""One case: a leg, its trials, an effect of the wanted strength, the recordings, and the answer."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from blind import legs
from blind.legs import Wish
from synth.planting.effect_makers import EFFECTS, EFFECTS_AT_BASE
from synth.planting.effect_size import PlainMotion, PlantedCause, combined
from synth.planting.model import Array, Truth
from synth.planting.refusals import NotApplicable
from synth.planting.sensors import PlantedSensor
from synth.planting.setup import SENSOR_NOISES, Setup
from synth.planting.unlisted_effects import EFFECTS_ON_ALL_CHANNELS, UNLISTED_EFFECTS

STRENGTHS = (1.5, 3.0, 6.0, 12.0)
SAME_CHI = 6.0  # explanations whose chi squared differs by less are not distinguished
CHEAP = (  # tried as parameters of the leg, without an effect's law
    "spring_preload", "link_mass", "link_inertia", "encoder_offset", "encoder_scale", "latency", "base_tilt",
    "encoder_quantisation",
)  # fmt: skip
FAMILIES = (  # of effects that trade off at one joint
    ("coulomb_friction", "stribeck_friction", "load_friction", "shear_thinning_damping", "quadratic_damping"),
    ("hardening_spring", "one_sided_spring", "joint_stop", "spring_hysteresis", "backlash"),
)
KINDS = ("single", "two", "none", "unknown", "tie")
ATTEMPTS = 60
# How ties are made: (effects, one of which is true; joints of the leg; kind of trials).
TIES: tuple[tuple[tuple[str, ...], int, Wish], ...] = (
    (("spring_preload", "base_tilt", "encoder_offset"), 1, Wish(plain=True, reach=0.2)),
    (("link_mass",), 1, Wish(plain=True)),  # the swing of one link depends on its moment and inertia, not on its mass
    (("encoder_offset", "base_tilt"), 2, Wish(plain=True, lock=(0,))),  # no trial shows the direction of the vertical
    (("encoder_offset", "base_tilt"), 3, Wish(plain=True, lock=(0,))),
    (("spring_preload", "base_tilt"), 2, Wish(plain=True, reach=0.3, noise=SENSOR_NOISES[-1])),
)


@dataclass(frozen=True)
class Case:
    """A case's content: recordings (m, n) rad of measured angles, NaN where a sample is missing, and the answer."""

    setup: Setup
    times: tuple[Array, ...]
    readings: tuple[Array, ...]
    states: tuple[Array, ...]  # angles (rotations) and speeds at each recording's start, rad and rad/s
    answer: dict[str, Any]
    truth: Truth
    sensor: PlantedSensor
    rest: Array  # (n,) rad, pose from which the leg was moved to its releases


def make_case(
    seed: int,
    number: int,
    kind: str,
    effect: str | None = None,
    strength: float | None = None,
    joints: int | None = None,
) -> Case:
    """Case ``number`` of a set; the same arguments give the same case. ``joints`` of the leg: drawn if None.

    Raises
    ------
    NotApplicable
        If no leg drawn can show the effect.
    """
    rng = np.random.default_rng([seed, number, KINDS.index(kind)])
    tie = TIES[int(rng.integers(0, len(TIES)))]
    if effect is None:
        pool = UNLISTED_EFFECTS if kind == "unknown" else EFFECTS
        effect = str(rng.choice(tie[0])) if kind == "tie" else str(rng.choice(sorted(pool)))
    if strength is None:
        strength = float(rng.choice(STRENGTHS[1:] if kind in ("unknown", "two") else STRENGTHS))
    for attempt in range(ATTEMPTS):
        if attempt % 6 == 5 and strength > STRENGTHS[0]:  # this strength may be impossible with plausible parameters
            strength = STRENGTHS[STRENGTHS.index(strength) - 1]
        try:
            return _attempt(rng, [seed, number], kind, effect, strength, tie[1:] if kind == "tie" else None, joints)
        except (NotApplicable, ArithmeticError, np.linalg.LinAlgError):
            continue
    raise NotApplicable(f"{kind} {effect}: no case in {ATTEMPTS} attempts")


def _attempt(
    rng: np.random.Generator,
    seed: list[int],
    kind: str,
    effect: str,
    strength: float,
    tie: tuple[int, Wish] | None,
    wanted: int | None,
) -> Case:
    """One random leg; raises if it cannot show the effect."""
    joints = int(rng.choice([1, 2, 3], p=[0.1, 0.35, 0.55]))
    joints = joints if wanted is None else wanted
    side, wish = None, Wish()
    if effect == "joint_stop":
        side = int(rng.integers(0, joints))
        wish = Wish(one_side=side)
    if tie is not None:
        joints, wish = tie
        side = 0
    ground = PlainMotion(legs.setup(rng, joints, wish))
    causes: list[PlantedCause] = []
    if kind != "none":
        causes.append(_cause(rng, ground, effect, side, strength))
    if kind == "two":
        second = str(rng.choice(sorted(set(EFFECTS) - {effect})))
        floor = ground.floor
        causes.append(_cause(rng, ground, second, None, float(rng.choice(STRENGTHS[1:]))))
        if ground.floor != floor:
            causes[0] = ground.find(effect, causes[0].joint, causes[0].form, strength)
    truth, sensor = combined(ground.setup, causes)
    tied, share = _tied(rng, ground, truth, sensor, causes, kind)
    note: dict[str, Any] = {"seed": seed, "kind": kind, "library_leaves": share}
    rivals = [name for family in FAMILIES if effect in family for name in family if name != effect]
    if kind == "single" and rivals:
        name, j, part = ground.nearest(rng, truth, sensor, rivals, [causes[0].joint])
        note["nearest"] = (
            {"effect": name, "joint": ground.setup.true.names[j], "leaves": round(part, 3)} if name else None
        )
    return _record(rng, ground, truth, sensor, causes, tied, note)


def _cause(
    rng: np.random.Generator, ground: PlainMotion, effect: str, joint: int | None, strength: float
) -> PlantedCause:
    """The effect at a joint (drawn if None) with its size found; each joint is tried before the leg is given up."""
    maker = UNLISTED_EFFECTS.get(effect) or EFFECTS[effect]
    order = rng.permutation(ground.setup.true.n).tolist() if joint is None else [joint]
    failed = NotApplicable("no joint")
    for j in [-1] if effect in EFFECTS_AT_BASE else order:
        try:
            form = maker(rng, ground.setup, ground.scale, max(j, 0))
            return ground.find(effect, -2 if effect in EFFECTS_ON_ALL_CHANNELS else j, form, strength)
        except NotApplicable as why:
            failed = why
    raise failed


def _tied(
    rng: np.random.Generator,
    ground: PlainMotion,
    truth: Truth,
    sensor: PlantedSensor,
    causes: list[PlantedCause],
    kind: str,
) -> tuple[list[tuple[str, int, float]], float | None]:
    """Other single causes that explain as well as the true one: (effect, joint, chi squared minus the truth's).

    For an unknown, instead, the share of its gap that the library's best leaves.
    """
    if kind == "none":
        return [], None
    model = ground.model
    targets, states = ground.targets(ground.run(truth, sensor, every=False), sensor)
    plain = ground.targets(list(ground.plain), PlantedSensor.good(ground.setup.true.n))
    trueness = model.fit(*plain).cost  # the truth's own: the cost of its tolerance errors
    fits = []
    own = {(cause.effect, cause.joint) for cause in causes}
    others = [other for other in model.alternatives() if (other.effect, other.joint) not in own]
    linear = model.linear_costs(targets, states, [other.freed for other in others])
    for other, cost in zip(others, linear, strict=True):
        if cost - trueness > 400.0 and kind != "unknown":
            continue
        fitted = model.fit(targets, states, other.freed)
        if model.plausible(other, fitted.change):
            fits.append((other, fitted))
    if kind == "unknown":  # a case that the library explains is not one of an unknown cause
        before = model.fit(targets, states)
        if any(f.rms < max(0.5 * before.rms, 1.2 * ground.floor) for _, f in fits):
            raise NotApplicable("the library would do")
        torques = [name for name in EFFECTS if name not in CHEAP]
        share = ground.nearest(rng, truth, sensor, torques, range(ground.setup.true.n))[2]
        if share < max(0.4, 1.2 * ground.floor / before.rms):
            raise NotApplicable("the library would do")
        return [], round(share, 3)
    tied = [(o.effect, o.joint, f.cost - trueness) for o, f in fits if f.cost - trueness < SAME_CHI]
    if kind == "tie" and not tied:
        raise NotApplicable("told apart")
    return tied, None


def _record(
    rng: np.random.Generator,
    ground: PlainMotion,
    truth: Truth,
    sensor: PlantedSensor,
    causes: list[PlantedCause],
    tied: list[tuple[str, int, float]],
    note: dict[str, Any],
) -> Case:
    setup, leg = ground.setup, ground.setup.true
    motions = ground.run(truth, sensor, every=True)
    targets, states = ground.targets(motions, sensor)
    fitted = ground.model.fit(targets, states)
    before = ground.model.held_out(targets, states, fitted.change)
    plain_seen = ground.targets(list(ground.plain), PlantedSensor.good(leg.n))
    unseen = ground.model.held_out(*plain_seen, ground.model.fit(*plain_seen).change)
    readings, floors, best, counted = [], [], [], []
    plain = PlantedSensor.good(leg.n)
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
        # with the effect known exactly, but the tolerances only as estimated from the given trials
        "best_fitted_deg": round(math.degrees(math.hypot(unseen, min(_rms(best), _rms(counted)))), 5),
        "library_leaves": note["library_leaves"],  # of an unknown's gap, the best single effect of the library
        "nearest": note.get("nearest"),  # of the same family at the same joint, and the share of the gap it leaves
        "given_gap_over_floor": round(fitted.rms / ground.floor, 3),
        "seed": note["seed"],
    }
    return Case(
        setup, tuple(ground.times), tuple(readings), tuple(states), answer, truth, sensor, ground.scale.rest
    )  # fmt: skip


def _rms(parts: list[Array]) -> float:
    joined = np.concatenate(parts)
    return float(np.sqrt(np.mean(joined**2)))
