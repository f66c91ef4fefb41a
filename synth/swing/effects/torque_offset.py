"""An offset error of a known torque's column."""

from __future__ import annotations

from typing import TYPE_CHECKING

from synth.swing.effects.definition import Effect, Parameter, Shape, signed
from synth.swing.lane_layout import DRIVE

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.swing.leg_lanes import LegLanes


def drive(legs: LegLanes, joint: int, sign: int, offset: Array) -> None:
    """Add ``offset`` (n_lane,) N m, in the sense of the measured angle, where a torque is known."""
    legs.drive[DRIVE.index("torque_offset"), joint] += sign * offset


EFFECT = Effect(
    name="torque_offset",
    meaning="a known torque's column is shifted",
    phrase="is driven by a torque shifted against its recording",
    formula="torque on the joint = column + offset",
    source="definition",
    way="drive",
    needs=("torque",),
    parameters=(
        Parameter("offset", "N*m", prior=signed(0.1), meaning="torque in excess of its column", form="change"),
    ),
    strengths=("offset",),
    shapes=(Shape(("offset",), {}),),
)
