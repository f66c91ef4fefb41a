"""Another spring than the design's, or one where the design has none: a rate far outside its tolerance."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from synth.swing.effects.definition import Effect, Parameter, Shape, signed

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.swing.leg_lanes import LegLanes


def change(legs: LegLanes, joint: int, sign: int, rate: Array, free_angle: Array) -> None:
    """Add ``rate`` (n_lane,) N m/rad, down to no spring at all, and shift the free angle by ``free_angle`` rad."""
    legs.spring_rate[joint] = np.maximum(legs.spring_rate[joint] + rate, 0.0)
    legs.rest[joint] += sign * free_angle


EFFECT = Effect(
    name="spring_rate",
    meaning="another spring than the design's, or one where there should be none",
    phrase="has another spring",
    formula="spring rate + rate, at least 0; free angle + free_angle",
    source="definition",
    way="leg",
    belongs_to="spring",
    parameters=(
        Parameter("rate", "N*m/rad", prior=signed(0.4), meaning="rate too much"),
        # A joint without a spring has its free angle where the links are in line.
        Parameter("free_angle", "rad", 0.0, signed(1.0), meaning="free angle, from the design's"),
    ),
    strengths=("rate",),
    shapes=(
        Shape(("rate",), {}, ({}, {"rate": -0.2}), needs=("spring",)),
        Shape(("rate", "free_angle"), {}, needs=("no spring",)),
    ),
)
