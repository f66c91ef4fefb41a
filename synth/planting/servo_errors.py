"""Causes that only a servo has: its command, controller, motor or supply is another than stated."""

from __future__ import annotations

import math

import numpy as np

from synth.planting.forms import Form, Maker, NotApplicable, Scale
from synth.planting.model import PlantedServo, Truth
from synth.planting.sensors import PlantedSensor
from synth.planting.setup import Setup

LATEST, WIDEST = 0.1, 0.2  # s and rad: a command later, a dead band wider than that is seen without any diagnosis
WEAKEST = 5.0  # natural logarithms by which the smallest planted torque limit is below the standing torque


def _servo(setup: Setup, j: int) -> PlantedServo:
    """The joint's servo.

    Raises
    ------
    NotApplicable : it has none that controls.
    """
    found = [servo for servo in setup.true.servos if servo.joint == j and servo.gain > 0.0]
    if not found:
        raise NotApplicable("no servo at this joint")
    return found[0]


def _form(setup: Setup, j: int, name: str, largest: float, what: str, sign: float = 1.0, factor: bool = False) -> Form:
    """A servo's number plus or times one plus the size."""
    _servo(setup, j)
    good = PlantedSensor.good(setup.true.n)

    def value(size: float) -> float:
        return 1.0 + sign * size if factor else size

    return Form(
        what,
        largest,
        lambda s: (Truth(setup.true, servo_errors=((j, name, value(s)),)), good),
        lambda s: {"value": value(s)},
    )


def command_delay(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """The command acts later."""
    return _form(setup, j, "delay", LATEST, "late")


def servo_dead_band(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """Small errors are not seen."""
    return _form(setup, j, "dead_band", WIDEST, "dead band")


def servo_gain(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """Another gain."""
    return _form(setup, j, "gain", 0.8, "gain", float(rng.choice([-1.0, 1.0])), factor=True)


def _motor(setup: Setup, j: int) -> PlantedServo:
    found = _servo(setup, j)
    if found.back_emf <= 0.0:
        raise NotApplicable("no motor at this joint")
    return found


def motor_constant(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """Another torque and back-EMF constant."""
    _motor(setup, j)
    return _form(setup, j, "torque_constant", 0.6, "constant", float(rng.choice([-1.0, 1.0])), factor=True)


def winding_resistance(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """Another resistance of the winding."""
    _motor(setup, j)
    sign = float(rng.choice([-1.0, 1.0]))
    return _form(setup, j, "resistance", 0.6 if sign < 0.0 else 1.5, "winding", sign, factor=True)


def drive_torque_limit(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """A limited current: the larger the size, the lower the limit."""
    servo, good = _motor(setup, j), PlantedSensor.good(setup.true.n)
    supply = max(float(t.inputs.supply[:, j].max()) for t in setup.trials if t.inputs is not None)
    standing = servo.strength * supply * servo.duty_limit

    def limit(size: float) -> float:
        return standing * math.exp(-WEAKEST * size)

    return Form(
        "limit",
        1.0,
        lambda s: (Truth(setup.true, servo_errors=((j, "torque_limit", limit(s)),)), good),
        lambda s: {"value": limit(s)},
    )


SERVO_ERRORS: dict[str, Maker] = {
    "command_delay": command_delay,
    "servo_gain": servo_gain,
    "servo_dead_band": servo_dead_band,
    "motor_constant": motor_constant,
    "winding_resistance": winding_resistance,
    "drive_torque_limit": drive_torque_limit,
}
