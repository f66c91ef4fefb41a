"""A form of an effect: one variant with a scalar size, and the true leg and sensors for each size."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from synth.planting.model import Array, Law, Truth
from synth.planting.refusals import NotApplicable
from synth.planting.sensors import PlantedSensor
from synth.planting.setup import Setup


class Scale(NamedTuple):
    """Range and speed of each joint in the given trials of the leg without the effect; (n,) each."""

    travel: Array  # rad, largest peak-to-peak rotation
    speed: Array  # rad/s, largest
    low: Array  # rad, smallest rotation
    high: Array  # rad, largest rotation
    rest: Array  # rad, at the end of a release
    slow: float  # 1/s, lowest natural frequency


@dataclass(frozen=True)
class Form:
    """One effect at one joint in one form.

    ``largest`` : upper bound of the size. ``build`` : size -> true leg and sensors. ``tell`` : size -> parameters for
    the case's record.
    """

    name: str
    largest: float
    build: Callable[[float], tuple[Truth, PlantedSensor]]
    tell: Callable[[float], Mapping[str, float | str]]


Maker = Callable[[np.random.Generator, Setup, Scale, int], Form]


def law_form(setup: Setup, name: str, largest: float, law: Callable[[float], Law], **shape: float) -> Form:
    """A form that consists of one torque law at a joint; ``shape`` : further parameters for its record."""
    good = PlantedSensor.good(setup.true.n)
    return Form(
        name,
        largest,
        lambda s: (Truth(setup.true, (law(s),)), good),
        lambda s: {f"p{i}": float(v) for i, v in enumerate(law(s).par)} | shape,
    )


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    """A log-uniform random number from ``low`` to ``high``."""
    return float(math.exp(rng.uniform(math.log(low), math.log(high))))


def spring_torque(setup: Setup, scale: Scale, j: int) -> float:
    """Spring torque over the joint's travel, N m; without a spring, outboard inertia times speed^2 over travel."""
    spring = float(setup.true.of("spring")[j] * scale.travel[j])
    return spring if spring > 0.0 else setup.true.outboard(j) * float(scale.speed[j]) ** 2 / float(scale.travel[j])


def spring_rate_of(setup: Setup, j: int) -> float:
    """Rate of the joint's spring, N m/rad.

    Raises
    ------
    NotApplicable : the joint has no spring.
    """
    rate = float(setup.true.of("spring")[j])
    if rate <= 0.0:
        raise NotApplicable("the joint has no spring")
    return rate
