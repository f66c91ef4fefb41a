"""Damping of the flexure joints, equal for all five."""

from __future__ import annotations

from typing import TYPE_CHECKING

from synth.estimation.parameters import Parameter, Shape, size
from synth.jump.effects.jump_effect import MotorEffect

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.jump.jump_lanes import JumpLanes


def change(jumps: JumpLanes, damping: Array) -> None:
    """Add to each joint's own (N m s/rad)."""
    jumps.joint_damping += damping


EFFECT = MotorEffect(
    name="joint_damping",
    meaning="the flexure joints have more damping than designed",
    phrase="have more damping than the design",
    formula="-damping times each joint's own rate",
    source="Knaup & Aukes, Simulation D and Experiment C",
    place="all",
    parameters=(Parameter("damping", "N*m*s/rad", prior=size(0.05), meaning="of each of the five joints"),),
    strengths=("damping",),
    shapes=(Shape(("damping",), {}),),
)
