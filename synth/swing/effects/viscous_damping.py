"""Another damper than designed, or a damper at a joint designed without: a rate far outside its tolerance."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from synth.swing.damper_curves import UNBOUNDED
from synth.swing.effects.definition import Effect, Parameter, Shape, signed

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.swing.leg_lanes import LegLanes


def change(legs: LegLanes, joint: int, sign: int, rate: Array) -> None:
    """Add ``rate`` (n_lane,) N m s/rad, limited so that the damper's torque never becomes negative."""
    curve, least = legs.curves[joint], -legs.damper_rate[joint]
    if curve is not None:  # its smallest torque over speed is that of its first segment or of its continuation
        speed, slope = curve
        least = least - max(min(float(slope.sum()), float(slope[speed >= UNBOUNDED].sum())), 0.0)
    legs.damper_rate[joint] += np.maximum(rate, least)


EFFECT = Effect(
    name="viscous_damping",
    meaning="another damper than the design's, or one where there should be none",
    phrase="has another damper",
    formula="torque of the damper - rate w, at least 0",
    source="definition",
    way="leg",
    changes="`rate` or `curve` of `damper:`",
    belongs_to="damper",
    parameters=(
        Parameter(
            "rate",
            "N*m*s/rad",
            prior=signed(0.5),
            meaning="excess of the rate",
            label="change of rate",
            form="change",
            added_to="damper_rate",
        ),
    ),
    strengths=("rate",),
    shapes=(Shape(("rate",), {}, ({}, {"rate": -0.2})),),
)
