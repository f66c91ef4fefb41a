"""Recordings of jumps with effects in, by the lanes themselves: quick, where the diagnosis' skill is not at stake."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hopper.hoppers import motor
from synth.arrays import Array
from synth.hopper.fold import fold, parameters_of
from synth.jump.effects import motor_effect_named
from synth.jump.hopper_leg import Contact, HopperLeg
from synth.jump.jump_lanes import JumpLanes
from synth.jump.jump_models import MODELS, columns
from synth.jump.jump_runs import compiled_jump

DESIGN = 'kind: hopper-design\nmotors: {use: ["N20 HP 6V 150:1"]}\n'
PART = "N20 HP 6V {}:1"
Effects = dict[str, dict[str, float]]


def changed(length: float, ratio: int, effects: Effects) -> JumpLanes:
    """The built leg."""
    jumps = columns(HopperLeg(), motor(ratio), Contact(), MODELS["full"], np.array([length]))
    for name, values in effects.items():
        effect = motor_effect_named(name)
        given = [np.array([values.get(p.name, effect.defaults[p.name])]) for p in effect.parameters]
        effect.function("change")(jumps, *given)
    return jumps


def jumped(length: float = 0.12, ratio: int = 150, effects: Effects | None = None, seed: int = 0) -> Array:
    """(n, 3) time, ground force, upper link at 1 kHz, to shortly after takeoff."""
    jumper = compiled_jump("upper")
    rows = jumper.trace(changed(length, ratio, effects or {}).workspace()[:, 0], tolerance=1e-6)
    rng = np.random.default_rng(seed)
    lifted = rows[np.argmax(rows[:, 1 + jumper.layout.row("foot")] > 1e-3), 0]
    time = np.arange(0.0, min(lifted + 0.04, rows[-1, 0]), 1e-3)
    force, angle = (np.interp(time, rows[:, 0], rows[:, 1 + jumper.layout.row(name)]) for name in ("normal", "angle"))
    noisy = angle + rng.normal(0.0, np.radians(0.1), len(time))
    return np.column_stack([time, force + rng.normal(0.0, 0.02, len(time)), noisy])


def pulled(length: float = 0.12, effects: Effects | None = None, seed: int = 0) -> Array:
    """(n, 3) time, hip torque, upper link of an inverted pull-up."""
    time = np.arange(0.0, 0.6, 1e-3)
    torque = 0.045 * (1.0 + 0.5 * np.sin(20.0 * time))
    jumps = changed(length, 150, effects or {})
    angle = fold(parameters_of(jumps), time, torque, np.array([np.radians(15.0)]), np.zeros(1))[:, 0]
    rng = np.random.default_rng(seed)
    return np.column_stack([time, torque, angle + rng.normal(0.0, np.radians(0.1), len(time))])


def write(path: Path, values: Array) -> None:
    """A recording; a pull-up's torque is small."""
    what = "hip torque [N*m]" if np.abs(values[:, 1]).max() < 0.1 else "ground force [N]"
    path.parent.mkdir(parents=True, exist_ok=True)
    fmt = ["%.9g" if values[-1, 0] < 1e6 else "%.6f", "%.9g", "%.9g"]  # Unix time to the microsecond
    np.savetxt(path, values, delimiter=",", header=f"time [s],{what},upper link [rad]", comments="", fmt=fmt)
