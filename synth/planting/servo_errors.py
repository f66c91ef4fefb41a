"""Causes that only a servo has: its command, controller, motor or supply is another than stated.

Those of its motor are a motor's too whose voltage is known, and which nothing controls.
"""

from __future__ import annotations

import math

import numpy as np

from synth.planting import torque_laws
from synth.planting.forms import Form, Maker, Scale, law_form, log_uniform
from synth.planting.model import Law, PlantedServo, Truth
from synth.planting.refusals import NotApplicable
from synth.planting.sensors import PlantedSensor
from synth.planting.setup import Setup

# In s and rad: a command later, a dead band wider than that is seen without any diagnosis.
LARGEST_DELAY, WIDEST_DEAD_BAND = 0.1, 0.2
MOST_TORQUE_LOST = 0.6  # of a drive's torque, in its gear; a self-locking one loses half
LARGEST_HEATING = 1.5  # growth of a copper winding's resistance; at twice that it burns
LEAST_WARMING_TIME = 15.0  # s of a trial, in which a winding warms
SLOWEST_RATE = 5.0  # natural logarithms by which the lowest planted rate is below ten times the joint's own speed
WEAKEST_LIMIT = 5.0  # natural logarithms by which the smallest planted torque limit is below the standing torque


def _drive_of(setup: Setup, j: int) -> PlantedServo:
    """The joint's servo, or the motor whose voltage is known.

    Raises
    ------
    NotApplicable : it has neither.
    """
    found = [servo for servo in setup.true.servos if servo.joint == j]
    if not found:
        raise NotApplicable("no servo at this joint")
    return found[0]


def _servo_of(setup: Setup, j: int) -> PlantedServo:
    """The joint's servo.

    Raises
    ------
    NotApplicable : it has none that controls.
    """
    found = _drive_of(setup, j)
    if found.gain <= 0.0:
        raise NotApplicable("no servo at this joint")
    return found


def _servo_form(
    setup: Setup, j: int, name: str, largest: float, what: str, sign: float = 1.0, *, factor: bool = False
) -> Form:
    """A drive's number plus or times one plus the size."""
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
    _servo_of(setup, j)
    return _servo_form(setup, j, "delay", LARGEST_DELAY, "late")


def dead_band(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """Small errors are not seen."""
    _servo_of(setup, j)
    return _servo_form(setup, j, "dead_band", WIDEST_DEAD_BAND, "dead band")


def servo_gain(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """Another gain."""
    _servo_of(setup, j)
    return _servo_form(setup, j, "gain", 0.8, "gain", float(rng.choice([-1.0, 1.0])), factor=True)


def _motor(setup: Setup, j: int) -> PlantedServo:
    found = _drive_of(setup, j)
    if found.back_emf <= 0.0:
        raise NotApplicable("no motor at this joint")
    return found


def torque_constant(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """Another torque and back-EMF constant."""
    _motor(setup, j)
    return _servo_form(setup, j, "torque_constant", 0.6, "constant", float(rng.choice([-1.0, 1.0])), factor=True)


def winding_resistance(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """Another resistance of the winding."""
    _motor(setup, j)
    sign = float(rng.choice([-1.0, 1.0]))
    return _servo_form(setup, j, "resistance", 0.6 if sign < 0.0 else 1.5, "winding", sign, factor=True)


def current_limit(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """A limited current: the larger the size, the lower the limit."""
    servo, good = _motor(setup, j), PlantedSensor.good(setup.true.n)
    supply = max(float(np.abs(t.inputs.supply[:, j]).max()) for t in setup.trials if t.inputs is not None)
    standing = servo.strength * supply * servo.duty_limit

    def limit(size: float) -> float:
        return standing * math.exp(-WEAKEST_LIMIT * size)

    return Form(
        "limit",
        1.0,
        lambda s: (Truth(setup.true, servo_errors=((j, "torque_limit", limit(s)),)), good),
        lambda s: {"value": limit(s)},
    )


def command_rate_limit(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """A command that is approached at a limited rate: the larger the size, the slower."""
    _servo_of(setup, j)
    quickest, good = 10.0 * float(scale.speed[j]), PlantedSensor.good(setup.true.n)

    def rate(size: float) -> float:
        return quickest * math.exp(-SLOWEST_RATE * size)

    return Form(
        "rate",
        1.0,
        lambda s: (Truth(setup.true, servo_errors=((j, "command_rate", rate(s)),)), good),
        lambda s: {"value": rate(s)},
    )


def voltage_sag(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """A supply that sags under the joint's current, of its source or its leads; a measured supply has its sag."""
    if _motor(setup, j).open_duty > 0.0:
        raise NotApplicable("the voltage was measured")
    if any(t.inputs is not None and np.ptp(t.inputs.supply[:, j]) > 0.0 for t in setup.trials):
        raise NotApplicable("the supply was measured")
    return _servo_form(setup, j, "sag", 2.0, "source")


def gear_friction(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """Dry friction in proportion to the drive's torque, which sticks rigidly (BAM, arXiv 2410.08650, model M3)."""
    _drive_of(setup, j)
    return law_form(setup, "gear, sticking", MOST_TORQUE_LOST, lambda s: Law(torque_laws.GEAR, j, (s, 0.0)))


def winding_heating(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """A winding that warms within the trials; the size is its growth under the torque that holds the leg level."""
    _motor(setup, j)
    longest = max(trial.duration for trial in setup.trials)
    if longest < LEAST_WARMING_TIME:
        raise NotApplicable("the trials are too short")
    if setup.true.gravity == 0.0:
        raise NotApplicable("without gravity no torque holds the leg level")
    masses, reach = setup.true.of("mass")[j:], setup.true.of("length")[j:]
    reference = setup.true.gravity * float(masses.sum() * reach.sum()) / 2.0
    time, good = log_uniform(rng, 0.5 * longest, 4.0 * longest), PlantedSensor.good(setup.true.n)

    def built(size: float) -> Truth:
        errors = ("rise", size), ("reference", reference), ("warming", time)
        return Truth(setup.true, servo_errors=tuple((j, name, value) for name, value in errors))

    return Form("winding", LARGEST_HEATING, lambda s: (built(s), good), lambda s: {"value": s, "time": time})


SERVO_ERRORS: dict[str, Maker] = {
    "command_delay": command_delay,
    "command_rate_limit": command_rate_limit,
    "servo_gain": servo_gain,
    "dead_band": dead_band,
    "torque_constant": torque_constant,
    "winding_resistance": winding_resistance,
    "current_limit": current_limit,
    "voltage_sag": voltage_sag,
    "gear_friction": gear_friction,
    "winding_heating": winding_heating,
}
