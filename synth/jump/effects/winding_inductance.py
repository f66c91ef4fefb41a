"""Winding inductance beyond the design's, which may have none."""

from __future__ import annotations

from typing import TYPE_CHECKING

from synth.estimation.parameters import Parameter, Shape, size
from synth.jump.effects.jump_effect import MotorEffect

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.jump.jump_lanes import JumpLanes


def change(jumps: JumpLanes, inductance: Array) -> None:
    """Add to the winding's own (H)."""
    jumps.inductance += inductance


EFFECT = MotorEffect(
    name="winding_inductance",
    meaning="the winding's current rises more slowly than designed",
    phrase="have more winding inductance",
    formula="(L + inductance) di/dt = V - i R - K_e G omega",
    source="Knaup & Aukes, equation 3; any text on DC motors",
    place="hip",
    parameters=(Parameter("inductance", "H", prior=size(1.0), meaning="beyond the design's"),),
    strengths=("inductance",),
    shapes=(Shape(("inductance",), {}),),
)
