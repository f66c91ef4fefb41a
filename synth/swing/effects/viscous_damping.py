"""Another damper than the design's, or one where the design has none: a rate far outside its tolerance."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from synth.swing.damper_curves import UNBOUNDED
from synth.swing.effects.definition import Effect, Parameter, Shape, signed

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.swing.leg_lanes import LegLanes


def change(legs: LegLanes, joint: int, sign: int, rate: Array) -> None:
    """Add ``rate`` (n_lane,) N m s/rad; no less than takes all of the damper away that is there at every speed."""
    curve, least = legs.curves[joint], -legs.damper_rate[joint]
    if curve is not None:  # weakest, a unit of speed, at its first segment or far beyond its last
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
    belongs_to="damper",
    parameters=(Parameter("rate", "N*m*s/rad", prior=signed(0.5), meaning="rate too much"),),
    strengths=("rate",),
    shapes=(Shape(("rate",), {}, ({}, {"rate": -0.2})),),
)
