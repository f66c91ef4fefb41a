"""A motor constant other than designed: torque per current and back-EMF per speed change by the same share."""

from __future__ import annotations

from typing import TYPE_CHECKING

from synth.estimation.parameters import Parameter, Prior, Shape
from synth.jump.effects.jump_effect import MotorEffect

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.jump.jump_lanes import JumpLanes


def change(jumps: JumpLanes, share: Array) -> None:
    """Scale both by 1 + ``share``."""
    jumps.scale_torque_constant(1.0 + share)


EFFECT = MotorEffect(
    name="torque_constant",
    meaning="the motors' torque and back-EMF constant differ from the design",
    phrase="have another torque constant than the design",
    formula="K_t (1 + share), K_e (1 + share)",
    source="K_t = K_e in SI by conservation of energy; magnets lose strength with heat",
    place="hip",
    parameters=(
        Parameter(
            "share",
            "1",
            prior=Prior(0.0, 0.15, lower=-0.6, upper=1.0),
            meaning="relative deviation of the constant",
            label="change",
            form="relative change",
        ),
    ),
    strengths=("share",),
    shapes=(Shape(("share",), {}),),
)
