"""Blind cases of the jumping leg: a design, the built leg, its jumps and pull-ups, and the answer."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from blind.jump_engine import Array, JumpConditions, JumpTruth, jump, pull_up
from blind.jump_sizes import absorber
from synth.files.hopper_gap_project import JumpTolerance
from synth.hopper.motors import motor_of
from synth.jump.hopper_leg import Contact, HopperLeg
from synth.parts.catalogs import Catalogue

PLACES = {
    "winding_inductance": "hip", "voltage_sag": "hip", "torque_constant": "hip", "gear_friction": "hip",
    "joint_damping": "all", "ground_slip": "base", "ground_compliance": "base",
}  # fmt: skip
FORMS = {
    "winding_inductance": "exact winding", "voltage_sag": "capacitor behind the resistance",
    "torque_constant": "falls with the current", "gear_friction": "true sticking, or a loss that grows with speed",
    "joint_damping": "power of the rate", "ground_slip": "bristle, more at rest", "ground_compliance": "stiffens",
}  # fmt: skip
UNLISTED_EFFECTS = ("hip_spring", "current_limit", "encoder_scale")
STRENGTHS = (1.5, 3.0, 6.0, 12.0)
# A usual size of each parameter, and the most that is plausible.
SIZES = {
    "winding_inductance.inductance": (3e-3, 0.02), "voltage_sag.resistance": (0.2, 1.2),
    "torque_constant.share": (0.08, 0.35), "gear_friction.torque": (1.5e-4, 9e-4), "gear_friction.loss": (0.08, 0.35),
    "joint_damping.damping": (2e-4, 1.5e-3), "ground_compliance.stiffness": (1500.0, 250.0),
    "ground_slip.friction": (0.11, 0.04), "hip_spring": (0.05, 0.3), "current_limit": (0.6, 0.35),
    "encoder_scale": (0.04, 0.15),
}  # fmt: skip
FAMILY = "N20 HP 6V {}:1"
RATIOS, LENGTHS = (75, 100, 150), (0.10, 0.12, 0.14)
KINDS = ("single", "two", "none", "unknown")


@dataclass(frozen=True)
class Asked:
    """One trial to make: its keys in ``trials:`` and its conditions."""

    name: str
    ratio: int
    length: float
    kind: str = "jump"
    payload: float = 0.0
    supply: float = 6.0
    lean: float = 0.0
    held_out: bool = False

    def entry(self, base: Asked) -> dict[str, Any]:
        """The differences from the default, as in a project."""
        found: dict[str, Any] = {"file": f"trials/{self.name}.csv"}
        if self.ratio != base.ratio:
            found["motor"] = FAMILY.format(self.ratio)
        if self.length != base.length:
            found["length"] = f"{self.length * 1e3:g} mm"
        if self.payload:
            found["payload"] = f"{self.payload * 1e3:g} g"
        if self.supply != base.supply:
            found["supply"] = f"{self.supply:g} V"
        if self.lean:
            found["lean"] = f"{math.degrees(self.lean):g} deg"
        return found | ({"held_out": True} if self.held_out else {})


@dataclass(frozen=True)
class Errors:
    """Whitened errors of the built leg: shared, and a motor's by its ratio."""

    shared: dict[str, float]
    motors: dict[int, dict[str, float]] = field(default_factory=dict)


def draw_errors(rng: np.random.Generator, ratios: tuple[int, ...] = RATIOS) -> Errors:
    """Standard normal for each quantity that has a tolerance."""
    shared = ("length", "mass", "spring", "damper", "supply", "ground", "stop", "bumper", "angle", "force")
    own = ("motor", "resistance", "inductance", "friction", "rotor_inertia", "efficiency")
    return Errors(
        {name: float(rng.normal()) for name in shared},
        {ratio: {name: float(rng.normal()) for name in own} for ratio in ratios},
    )


def built(asked: Asked, errors: Errors, effects: dict[str, float], catalogue: Catalogue) -> JumpTruth:
    """The true leg of one trial."""
    t = JumpTolerance()
    s = {name: 1.0 + getattr(t, name) * value for name, value in errors.shared.items()}
    m = {name: 1.0 + getattr(t, name) * value for name, value in errors.motors[asked.ratio].items()}
    leg, contact = HopperLeg(), Contact()
    motor = motor_of(catalogue.find_motor(FAMILY.format(asked.ratio)))
    body = leg.structure_mass + 2 * motor.mass
    leg = replace(
        leg,
        length=asked.length * s["length"],
        structure_mass=leg.structure_mass + (s["mass"] - 1.0) * body,
        laminate=replace(leg.laminate, mass_per_length=leg.laminate.mass_per_length * s["mass"]),
        flexures=replace(leg.flexures, rate=leg.flexures.rate * s["spring"],
                         damping=leg.flexures.damping * s["damper"]),
        extended=leg.extended + t.stop * errors.shared["stop"],
        stop_rate=leg.stop_rate * max(s["bumper"], 0.3),
    )  # fmt: skip
    motor = replace(
        motor,
        back_emf_constant=motor.back_emf_constant * m["motor"],
        torque_constant=motor.torque_constant * m["motor"] * m["efficiency"],
        resistance=motor.resistance * m["resistance"],
        inductance=motor.inductance * max(m["inductance"], 0.3),
        friction=motor.friction * max(m["friction"], 0.3),
        rotor_inertia=motor.rotor_inertia * m["rotor_inertia"],
    )
    return JumpTruth(leg, motor, replace(contact, stiffness=contact.stiffness * max(s["ground"], 0.3)), effects)


def plan(rng: np.random.Generator, leaning: bool) -> list[Asked]:
    """Trials to learn from and held out: the held-out ones partly outside the range of the given."""
    ratio, length = int(rng.choice(RATIOS)), float(rng.choice(LENGTHS))
    base = Asked("base", ratio, length)
    other = int(rng.choice([r for r in RATIOS if r != ratio]))
    shorter, longer = round(length - 0.02, 3), round(length + 0.02, 3)
    given = [base, replace(base, name="again"), replace(base, name="low supply", supply=5.0)]
    extra = [
        replace(base, name="loaded", payload=0.01), replace(base, name="other length", length=shorter),
        replace(base, name="other ratio", ratio=other),
    ]  # fmt: skip
    kept = rng.permutation(3)[: int(rng.integers(1, 4))]
    given += [extra[int(k)] for k in sorted(kept)]
    held = [replace(base, name="check base", held_out=True),
            replace(base, name="check length", length=longer, held_out=True),
            replace(base, name="check supply", supply=6.6, held_out=True)]  # fmt: skip
    if rng.random() < 0.3:
        given.append(replace(base, name="pull-up", kind="pull-up"))
    if leaning or rng.random() < 0.15:
        given += [replace(base, name=f"leaning {k}", lean=math.radians(d)) for k, d in enumerate((8.0, 12.0))]
    return [replace(item, name=item.name.replace(" ", "_")) for item in given + held]


@dataclass(frozen=True)
class Sensors:
    """Noise (SI) by channel; ``extra``: current and supply are recorded too."""

    noise: dict[str, float]
    extra: bool

    @classmethod
    def drawn(cls, rng: np.random.Generator) -> Sensors:
        """One of three levels."""
        level = float(rng.choice([0.5, 1.0, 2.0]))
        noise = {"upper link": math.radians(0.1), "ground force": 0.02, "current": 0.01, "supply": 0.01,
                 "pitch": math.radians(0.1), "foot slide": 2e-4, "hip torque": 1e-3}  # fmt: skip
        return cls({name: level * value for name, value in noise.items()}, bool(rng.random() < 0.4))

    def channels(self, asked: Asked) -> list[str]:
        """The recorded channels of a trial, besides time."""
        if asked.kind == "pull-up":
            return ["upper link", "hip torque"]
        return ["upper link", "ground force", *(["current", "supply"] * self.extra),
                *(["pitch", "foot slide"] * bool(asked.lean))]  # fmt: skip


def record(
    asked: Asked, errors: Errors, effects: dict[str, float], sensors: Sensors, rng: np.random.Generator,
    catalogue: Catalogue,
) -> dict[str, Array]:  # fmt: skip
    """A recording with noise, at 1 kHz."""
    tolerance = JumpTolerance()
    late = max(0.0, float(rng.normal(0.0, tolerance.start))) if asked.kind == "jump" else 0.0
    crouch = float(rng.normal(0.0, math.radians(1.0)))
    told = simulated(asked, errors, effects, catalogue, crouch)
    time = np.arange(0.0, told["time"][-1], 1e-3)
    found = {"time": time}
    for name in sensors.channels(asked):
        clean = np.interp(time - late, told["time"], told[name])
        found[name] = clean + rng.normal(0.0, sensors.noise[name], len(time))
    found["upper link"] *= 1.0 + effects.get("encoder_scale", 0.0)
    found["upper link"] += tolerance.angle * errors.shared["angle"]
    if "ground force" in found:
        found["ground force"] *= 1.0 + tolerance.force * errors.shared["force"]
    return found


def simulated(
    asked: Asked, errors: Errors, effects: dict[str, float], catalogue: Catalogue, crouch: float = 0.0
) -> dict[str, Array]:
    """Without noise."""
    truth = built(asked, errors, effects, catalogue)
    if asked.kind == "pull-up":
        weight = truth.leg.gravity * truth.leg.total_mass(truth.motor)
        return pull_up(truth, 0.5 * weight * truth.leg.leverage(math.radians(20.0)) * 2.0)
    supply = asked.supply * (1.0 + JumpTolerance().supply * errors.shared["supply"])
    return jump(truth, JumpConditions(supply, asked.payload, asked.lean, crouch))


def sized(
    name: str, wanted: float, shows: Sequence[Asked], errors: Errors, others: dict[str, float], sensors: Sensors,
    rng: np.random.Generator, catalogue: Catalogue,
) -> tuple[float, float]:  # fmt: skip
    """The plausible parameter whose gap is nearest to so many floors, and that gap."""
    usual, most = SIZES[name]
    sign = -1.0 if name == "torque_constant.share" and rng.random() < 0.6 else 1.0
    inverse = name in ("ground_compliance.stiffness", "current_limit", "ground_slip.friction")
    clean = [simulated(item, errors, others, catalogue) for item in shows]
    seen = ["time", *sensors.channels(shows[0])]

    def write(folder: Path) -> None:
        _write_trials(folder, [(a, {n: told[n] for n in seen}) for a, told in zip(shows, clean, strict=True)])

    absorb = absorber(clean, write, sensors.noise)
    # A foot slides or does not: its friction is drawn, not searched for.
    size, reached, value = float(rng.uniform(0.9, 2.0)) if name == "ground_slip.friction" else 1.0, 0.0, usual
    for _ in range(1 if name == "ground_slip.friction" else 4):
        value = sign * (usual / size if inverse else usual * size)
        value = max(value, most) if inverse else sign * min(abs(value), most)
        effects = others | {name: value}
        told = [simulated(item, errors, effects, catalogue) for item in shows]
        reached = absorb.floors(told, effects.get("encoder_scale", 0.0))
        if abs(math.log(max(reached, 1e-6) / wanted)) < 0.2 or value == (most if inverse else sign * most):
            break
        size = float(np.clip(size * wanted / max(reached, 0.1 * wanted), 0.02, 50.0))
    return value, reached


def make_case(seed: int, number: int, kind: str, folder: Path, effect: str | None = None) -> dict[str, Any]:
    """Write one case into ``folder`` and give its answer."""
    rng = np.random.default_rng([seed, number, KINDS.index(kind), 7])
    catalogue = Catalogue.load()
    pool = sorted(PLACES) if kind != "unknown" else list(UNLISTED_EFFECTS)
    chosen = [effect or str(rng.choice(pool))] if kind != "none" else []
    if kind == "two":
        rest = [name for name in pool if name not in (*chosen, "ground_slip")]
        chosen = [chosen[0], str(rng.choice(rest))]
    trials = plan(rng, leaning="ground_slip" in chosen)
    errors, sensors = draw_errors(rng), Sensors.drawn(rng)
    effects: dict[str, float] = {}
    told = []
    for name in chosen:
        strength = float(rng.choice(STRENGTHS if kind == "single" else STRENGTHS[1:]))
        options = [key for key in SIZES if key == name or key.startswith(f"{name}.")]
        key = str(rng.choice(options))
        leans = name == "ground_slip"
        shows = [t for t in trials if bool(t.lean) == leans and t.kind == "jump" and not t.held_out][1:3]
        effects[key], reached = sized(key, strength, shows, errors, dict(effects), sensors, rng, catalogue)
        told.append({
            "effect": name, "joint": PLACES.get(name, "?"), "form": FORMS.get(name, name), "parameter": key,
            "value": effects[key], "strength": max(s for s in (0.0, *STRENGTHS) if s <= 1.15 * reached),
            "reached": reached,
        })  # fmt: skip
    _write_trials(folder, [(item, record(item, errors, effects, sensors, rng, catalogue)) for item in trials])
    noise = math.degrees(sensors.noise["upper link"])
    left = max((item["reached"] for item in told), default=0.0)
    return {
        "kind": kind, "effects": told, "seed": [seed, number], "noise_floor_deg": noise,
        "before_deg": noise * math.hypot(1.0, left),
        "best_possible_deg": noise, "best_fitted_deg": noise, "cannot_be_told_apart": [],
    }  # fmt: skip


UNITS = {"time": "s", "upper link": "rad", "ground force": "N", "current": "A", "supply": "V", "pitch": "rad",
         "foot slide": "m", "hip torque": "N*m"}  # fmt: skip


def _write(path: Path, columns: dict[str, Array]) -> None:
    header = ",".join(f"{name} [{UNITS[name]}]" for name in columns)
    np.savetxt(path, np.column_stack(list(columns.values())), delimiter=",", header=header, comments="", fmt="%.7g")


def _write_trials(folder: Path, made: Sequence[tuple[Asked, dict[str, Array]]]) -> None:
    """Recordings and the project that lists them; the first trial's design is the project's."""
    (folder / "trials").mkdir(parents=True)
    base = made[0][0]
    for item, columns in made:
        wanted = {name: values for name, values in columns.items() if item.lean or name not in ("pitch", "foot slide")}
        _write(folder / "trials" / f"{item.name}.csv", wanted)
    part = FAMILY.format(base.ratio)
    (folder / "hopper.yaml").write_text(f'kind: hopper-design\nmotors: {{use: ["{part}"]}}\nmodel: full\n')
    lines = ["kind: gap", "leg: hopper.yaml", f'motor: "{part}"', f"length: {base.length * 1e3:g} mm", "trials:"]
    lines += [f"  - {json.dumps(item.entry(base))}" for item, _ in made]
    (folder / "gap.yaml").write_text("\n".join(lines) + "\n")
