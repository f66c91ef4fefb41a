"""A winding's resistance differs from the stated one: warm, or from another batch."""

from __future__ import annotations

from typing import TYPE_CHECKING

from synth.swing.effects.definition import Effect, Parameter, Prior, Shape
from synth.swing.lane_layout import SERVO

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.swing.leg_lanes import LegLanes


def drive(legs: LegLanes, joint: int, sign: int, share: Array) -> None:
    """Increase the resistance by the share ``share`` (n_lane,)."""
    for name in ("servo_strength", "servo_back_emf", "servo_sag", "servo_conductance"):
        legs.servo[SERVO.index(name), joint] /= 1.0 + share
    legs.winding[joint] /= 1.0 + share
    legs.lag[joint] /= 1.0 + share


EFFECT = Effect(
    name="winding_resistance",
    meaning="a winding's resistance differs from the stated one (heating: 0.39 % per kelvin)",
    phrase="has another winding resistance",
    formula="resistance = stated (1 + share)",
    source="copper, temperature coefficient 0.00393/K at 20 degrees C: IEC 60028",
    way="drive",
    needs=("motor",),
    parameters=(
        Parameter(
            "share",
            "1",
            prior=Prior(0.0, 0.2, lower=-0.8, upper=5.0),
            natural=False,
            meaning="relative excess",
            label="change",
            form="relative change",
            above=-1.0,
        ),
    ),
    strengths=("share",),
    shapes=(Shape(("share",), {}, ({}, {"share": -0.1})),),
)
