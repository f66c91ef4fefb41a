"""The supply sags under the current that the drive draws."""

from __future__ import annotations

from typing import TYPE_CHECKING

from synth.swing.effects.definition import Effect, Parameter, Shape, size
from synth.swing.lane_layout import SERVO

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.swing.leg_lanes import LegLanes


def drive(legs: LegLanes, joint: int, sign: int, share: Array) -> None:
    """Source of ``share`` (n_lane,) of the winding's resistance, beside what is stated."""
    legs.servo[SERVO.index("servo_sag"), joint] += share


EFFECT = Effect(
    name="source_resistance",
    meaning="the supply sags under the drive's current",
    phrase="has a supply that sags",
    formula="voltage = duty (supply - duty current share resistance)",
    source="Thevenin source behind a half bridge, whose supply carries duty times the winding's current",
    way="drive",
    needs=("stated supply",),  # a measured one holds its sag already
    parameters=(
        Parameter("share", "1", prior=size(0.2), natural=False, meaning="source's resistance over the winding's"),
    ),
    strengths=("share",),
    shapes=(Shape(("share",), {}),),
)
