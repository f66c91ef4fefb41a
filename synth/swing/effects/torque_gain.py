"""A gain error of a known torque's column: another torque constant or gear."""

from __future__ import annotations

from typing import TYPE_CHECKING

from synth.swing.effects.definition import Effect, Parameter, Prior, Shape
from synth.swing.lane_layout import DRIVE

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.swing.leg_lanes import LegLanes


def drive(legs: LegLanes, joint: int, sign: int, share: Array) -> None:
    """Increase the torque by the share ``share`` (n_lane,) of its column."""
    gain = legs.drive[DRIVE.index("torque_gain"), joint]
    gain += share * (1.0 + gain)  # beside the tolerance of a motor whose current is recorded


EFFECT = Effect(
    name="torque_gain",
    meaning="a known torque's column is scaled",
    phrase="is driven by a torque scaled against its recording",
    formula="torque on the joint = column (1 + share)",
    source="definition",
    way="drive",
    needs=("torque",),
    parameters=(
        Parameter(
            "share",
            "1",
            prior=Prior(0.0, 0.2, lower=-1.0, upper=5.0),
            natural=False,
            meaning="relative excess of the torque",
            label="change",
            form="relative change",
        ),
    ),
    strengths=("share",),
    shapes=(Shape(("share",), {}, ({}, {"share": -0.1})),),
)
