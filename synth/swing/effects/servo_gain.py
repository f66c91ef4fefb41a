"""A servo's gain differs from the stated one."""

from __future__ import annotations

from typing import TYPE_CHECKING

from synth.swing.effects.definition import Effect, Parameter, Prior, Shape
from synth.swing.lane_layout import SERVO

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.swing.leg_lanes import LegLanes


def drive(legs: LegLanes, joint: int, sign: int, share: Array) -> None:
    """Increase the gain by the share ``share`` (n_lane,)."""
    legs.servo[SERVO.index("servo_gain"), joint] *= 1.0 + share


EFFECT = Effect(
    name="servo_gain",
    meaning="a servo's gain differs from the stated one",
    phrase="has another servo gain",
    formula="gain = stated gain (1 + share)",
    source="definition",
    way="drive",
    needs=("servo",),
    parameters=(
        Parameter(
            "share",
            "1",
            prior=Prior(0.0, 0.3, lower=-0.95, upper=5.0),
            natural=False,
            meaning="relative excess of the gain",
            label="change",
            form="relative change",
            above=-1.0,
        ),
    ),
    strengths=("share",),
    shapes=(Shape(("share",), {}, ({}, {"share": -0.15})),),
)
