"""What a form of an effect is: one size to be found, and the leg and sensors that a size makes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from synth.planting.model import Array, Law, Truth
from synth.planting.sensors import PlantedSensor
from synth.planting.setup import Setup


class Unfit(Exception):
    """The leg, joint or trials drawn cannot show the effect."""


class Scale(NamedTuple):
    """How far and fast each joint goes in the given trials of the leg without the effect; (n,) each."""

    travel: Array  # rad, largest distance from rest at release
    speed: Array  # rad/s, largest
    low: Array  # rad, smallest and largest rotation
    high: Array
    rest: Array  # rad, at the end of a plain release
    slow: float  # 1/s, lowest natural frequency


@dataclass(frozen=True)
class Form:
    """One effect at one joint in one form; ``build(size)`` gives the leg and the sensors, ``tell`` its parameters."""

    name: str
    largest: float
    build: Callable[[float], tuple[Truth, PlantedSensor]]
    tell: Callable[[float], Mapping[str, float | str]]
    fixed_noise: bool = False


Maker = Callable[[np.random.Generator, Setup, Scale, int], Form]


def law_form(setup: Setup, name: str, largest: float, law: Callable[[float], Law], **shape: float) -> Form:
    """A form that is one law at a joint."""
    good = PlantedSensor.good(setup.true.n)
    return Form(
        name,
        largest,
        lambda s: (Truth(setup.true, (law(s),)), good),
        lambda s: {f"p{i}": float(v) for i, v in enumerate(law(s).par)} | shape,
    )


def between(rng: np.random.Generator, low: float, high: float) -> float:
    return float(math.exp(rng.uniform(math.log(low), math.log(high))))


def spring_torque(setup: Setup, scale: Scale, j: int) -> float:
    """N m, what the spring exerts over the joint's travel; without a spring what turns the inertia there as fast."""
    spring = float(setup.true.of("spring")[j] * scale.travel[j])
    return spring if spring > 0.0 else setup.true.outboard(j) * float(scale.speed[j]) ** 2 / float(scale.travel[j])


def sprung(setup: Setup, j: int) -> float:
    """N m/rad of the joint's spring.

    Raises
    ------
    Unfit : it has none, and the effect acts on one.
    """
    rate = float(setup.true.of("spring")[j])
    if rate <= 0.0:
        raise Unfit("the joint has no spring")
    return rate
