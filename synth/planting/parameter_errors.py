"""Causes that are parameter errors: another spring or damper, a rotor, an error of the known torque's column."""

from __future__ import annotations

import numpy as np

from synth.planting.forms import Form, Maker, Scale, spring_rate_of, spring_torque
from synth.planting.model import Truth
from synth.planting.refusals import NotApplicable
from synth.planting.sensors import PlantedSensor
from synth.planting.setup import Setup


def spring_rate(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """A spring of another rate with the same free angle."""
    k, good = spring_rate_of(setup, j), PlantedSensor.good(setup.true.n)
    sign = float(rng.choice([-1.0, 1.0]))
    return Form(
        "another rate",
        0.85 if sign < 0 else 3.0,
        lambda s: (Truth(setup.true.changed("spring", j, k * (1 + sign * s))), good),
        lambda s: {"ratio": 1 + sign * s},
    )


def viscous_damping(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """A damper of another rate; an increase is a share of critical damping, so it can be far from the design's."""
    b, good = float(setup.true.of("damper")[j]), PlantedSensor.good(setup.true.n)
    critical = 2.0 * float(np.sqrt(setup.true.of("spring")[j] * setup.true.outboard(j)))
    critical = critical if critical > 0.0 else 2.0 * scale.slow * setup.true.outboard(j)
    sign = float(rng.choice([-1.0, 1.0])) if b > 0.0 else 1.0
    most, unit = (0.9, b) if sign < 0 else (1.0, critical)
    return Form(
        "another rate",
        most,
        lambda s: (Truth(setup.true.changed("damper", j, b + sign * s * unit)), good),
        lambda s: {"rate": b + sign * s * unit},
    )


def armature(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """The inertia of a rotor behind a gear."""
    good, load = PlantedSensor.good(setup.true.n), setup.true.outboard(j)
    return Form(
        "rotor",
        1.5,
        lambda s: (Truth(setup.true, rotors=((j, s * load),)), good),
        lambda s: {"inertia": s * load},
    )


def _largest_known_torque(setup: Setup, j: int) -> float:
    """Largest known torque at the joint, N m.

    Raises
    ------
    NotApplicable : there is none.
    """
    found = setup.driven(j)
    if found <= 0.0:
        raise NotApplicable("no known torque at this joint")
    return found


def torque_offset(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """A constant offset between the true torque and its column."""
    good, sign = PlantedSensor.good(setup.true.n), float(rng.choice([-1.0, 1.0]))
    most = min(_largest_known_torque(setup, j), 0.5 * spring_torque(setup, scale, j))
    return Form(
        "offset",
        most,
        lambda s: (Truth(setup.true, drive=(0.0, sign * s, 0.0), drive_joint=j), good),
        lambda s: {"offset": sign * s},
    )


def torque_gain(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """A gain error: the column was computed with another torque constant."""
    good, sign = PlantedSensor.good(setup.true.n), float(rng.choice([-1.0, 1.0]))
    _largest_known_torque(setup, j)
    return Form(
        "gain",
        0.6,
        lambda s: (Truth(setup.true, drive=(sign * s, 0.0, 0.0), drive_joint=j), good),
        lambda s: {"share": sign * s},
    )


def torque_delay(rng: np.random.Generator, setup: Setup, scale: Scale, j: int) -> Form:
    """The torque acts later than its column says."""
    good = PlantedSensor.good(setup.true.n)
    _largest_known_torque(setup, j)
    most = 0.6 / scale.slow
    return Form(
        "late", most, lambda s: (Truth(setup.true, drive=(0.0, 0.0, s), drive_joint=j), good), lambda s: {"delay_s": s}
    )


PARAMETER_ERRORS: dict[str, Maker] = {
    "spring_rate": spring_rate,
    "viscous_damping": viscous_damping,
    "armature": armature,
    "torque_offset": torque_offset,
    "torque_gain": torque_gain,
    "torque_delay": torque_delay,
}
TORQUE_ERRORS = ("torque_offset", "torque_gain", "torque_delay")
