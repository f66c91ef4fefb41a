"""Voltage sag: battery, leads and driver have a resistance in series with both motors."""

from __future__ import annotations

from typing import TYPE_CHECKING

from synth.estimation.parameters import Parameter, Shape, size
from synth.jump.effects.jump_effect import MotorEffect

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.jump.jump_lanes import JumpLanes


def change(jumps: JumpLanes, resistance: Array) -> None:
    """Add to the supply's resistance (ohm)."""
    jumps.supply_resistance += resistance


EFFECT = MotorEffect(
    name="voltage_sag",
    meaning="the supply's voltage falls with the current drawn from it",
    phrase="have a supply with voltage sag",
    formula="V = V_supply - resistance (i_1 + i_2)",
    source="Thevenin's equivalent of the supply",
    place="hip",
    parameters=(Parameter("resistance", "ohm", prior=size(0.15), meaning="of supply and leads, seen by both motors"),),
    strengths=("resistance",),
    shapes=(Shape(("resistance",), {}),),
)
