"""Voltage sag at one driven joint: its source has an internal resistance."""

from __future__ import annotations

from typing import TYPE_CHECKING

from synth.swing.effects.definition import Effect, Parameter, Shape, size
from synth.swing.lane_layout import SERVO

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.swing.leg_lanes import LegLanes


def drive(legs: LegLanes, joint: int, sign: int, share: Array) -> None:
    """Add a source resistance of ``share`` (n_lane,) times the winding's stated resistance to the stated one."""
    legs.servo[SERVO.index("servo_sag"), joint] += share * legs.winding[joint]


EFFECT = Effect(
    name="voltage_sag",
    former=("source_resistance",),
    meaning="the supply sags under the drive's current",
    phrase="has a supply that sags",
    formula="voltage = duty (supply - duty current share resistance)",
    source="Thevenin source behind a half bridge, whose supply carries duty times the winding's current",
    way="drive",
    needs=("stated supply",),  # of its own: a measured supply includes its sag, see also ``shared_source_resistance``
    parameters=(
        Parameter(
            "share", "1", prior=size(0.2), natural=False, meaning="source over stated winding resistance", form="share"
        ),
    ),
    strengths=("share",),
    shapes=(Shape(("share",), {}),),
)
