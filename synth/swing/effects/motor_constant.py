"""A motor's torque constant, and with it its back-EMF constant, differs from the stated one."""

from __future__ import annotations

from typing import TYPE_CHECKING

from synth.swing.effects.definition import Effect, Parameter, Prior, Shape
from synth.swing.lane_layout import SERVO

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.swing.leg_lanes import LegLanes


def drive(legs: LegLanes, joint: int, sign: int, share: Array) -> None:
    """Increase torque per current, with the limit of the current, and back-EMF per speed by ``share`` (n_lane,)."""
    for name, power in (("servo_strength", 1), ("servo_torque_limit", 1), ("servo_back_emf", 2)):
        legs.servo[SERVO.index(name), joint] *= (1.0 + share) ** power


EFFECT = Effect(
    name="torque_constant",
    former=("motor_constant",),
    meaning="a motor's torque constant differs from the stated one",
    phrase="has another torque constant",
    formula="torque constant = stated (1 + share); back-EMF likewise; a limit stated in A is that of the current",
    source="in SI torque a current equals back-EMF a speed: Hughes & Drury, Electric Motors and Drives, section 3.3",
    way="drive",
    needs=("motor",),
    parameters=(
        Parameter(
            "share",
            "1",
            prior=Prior(0.0, 0.15, lower=-0.9, upper=3.0),
            natural=False,
            meaning="relative excess",
            label="change",
            form="relative change",
            above=-1.0,
        ),
    ),
    strengths=("share",),
    shapes=(Shape(("share",), {}, ({}, {"share": -0.075})),),
)
