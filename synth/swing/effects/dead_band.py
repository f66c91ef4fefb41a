"""A servo does nothing about small errors."""

from __future__ import annotations

from typing import TYPE_CHECKING

from synth.swing.effects.definition import Effect, Parameter, Shape, size
from synth.swing.lane_layout import SERVO

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.swing.leg_lanes import LegLanes


def drive(legs: LegLanes, joint: int, sign: int, angle: Array) -> None:
    """Add ``angle`` (n_lane,) rad to the dead band: errors up to it give no torque."""
    legs.servo[SERVO.index("servo_dead_band"), joint] += angle


EFFECT = Effect(
    name="dead_band",
    former=("servo_dead_band",),
    meaning="a servo ignores small errors",
    phrase="has a dead band",
    formula="error = 0 up to angle, |error| - angle beyond",
    source="definition; dead-zone register of position servos",
    way="drive",
    needs=("servo",),
    parameters=(Parameter("angle", "rad", prior=size(0.03), meaning="error on either side that it ignores"),),
    strengths=("angle",),
    shapes=(Shape(("angle",), {}, ({}, {"angle": 0.03})),),
)
