"""Voltage sag of the whole leg: one source with an internal resistance feeds several driven joints."""

from __future__ import annotations

from typing import TYPE_CHECKING

from synth.swing.effects.definition import Effect, Parameter, Shape, size

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.swing.leg_lanes import LegLanes


def drive(legs: LegLanes, joint: int, sign: int, resistance: Array) -> None:
    """Add ``resistance`` (n_lane,) ohm to that of the source of the servos that have one stated supply."""
    legs.source += resistance


EFFECT = Effect(
    name="shared_source_resistance",
    meaning="the supply of several driven joints sags under the current of all",
    phrase="feeds several joints from a supply that sags",
    formula="voltage = duty (supply - resistance sum(duty current)), the sum over the joints of that supply",
    source="Thevenin source behind half bridges, whose supply carries each duty times its winding's current",
    way="drive",
    where="base",
    needs=("shared supply",),  # a measured supply includes its sag
    parameters=(Parameter("resistance", "ohm", prior=size(0.2), meaning="internal resistance of the source"),),
    strengths=("resistance",),
    shapes=(Shape(("resistance",), {}),),
)
