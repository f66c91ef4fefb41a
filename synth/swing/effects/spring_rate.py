"""Another spring than designed, or a spring at a joint designed without: a rate far outside its tolerance."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from synth.swing.effects.definition import Effect, Parameter, Shape, signed

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.swing.leg_lanes import LegLanes


def change(legs: LegLanes, joint: int, sign: int, rate: Array, free_angle: Array) -> None:
    """Add ``rate`` (n_lane,) N m/rad, limited so that the sum is not negative; shift the free angle (rad)."""
    legs.spring_rate[joint] = np.maximum(legs.spring_rate[joint] + rate, 0.0)
    legs.rest[joint] += sign * free_angle


EFFECT = Effect(
    name="spring_rate",
    meaning="another spring than the design's, or one where there should be none",
    phrase="has another spring",
    formula="spring rate + rate, at least 0; free angle + free_angle",
    source="definition",
    way="leg",
    changes="`rate` and `free_angle` of `spring:`",
    belongs_to="spring",
    parameters=(
        Parameter(
            "rate",
            "N*m/rad",
            prior=signed(0.4),
            meaning="excess of the rate",
            label="change of rate",
            form="change",
            added_to="spring_rate",
        ),
        # The free angle of a joint without a spring is that of aligned links.
        Parameter(
            "free_angle",
            "rad",
            0.0,
            signed(1.0),
            largest=1.0,  # rad: a soft spring that is unloaded far away is a constant torque
            meaning="difference of the free angle from the design",
            label="change of free angle",
            form="change",
        ),
    ),
    strengths=("rate",),
    shapes=(
        Shape(("rate",), {}, ({}, {"rate": -0.2}), needs=("spring",)),
        Shape(("rate", "free_angle"), {}, needs=("no spring",)),
    ),
)
