"""A known torque's column is shifted."""

from __future__ import annotations

from typing import TYPE_CHECKING

from synth.swing.effects.definition import Effect, Parameter, Shape, signed
from synth.swing.lane_layout import DRIVE

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.swing.leg_lanes import LegLanes


def drive(legs: LegLanes, joint: int, sign: int, offset: Array) -> None:
    """Torque in the measured angle's sense too high by ``offset`` (n_lane,) N m, wherever it is known."""
    legs.drive[DRIVE.index("torque_offset"), joint] += sign * offset


EFFECT = Effect(
    name="torque_offset",
    meaning="a known torque's column is shifted",
    phrase="has a torque column that is shifted",
    formula="torque on the joint = column + offset",
    source="definition",
    way="drive",
    needs=("torque",),
    parameters=(Parameter("offset", "N*m", prior=signed(0.1), meaning="torque above what its column says"),),
    strengths=("offset",),
    shapes=(Shape(("offset",), {}),),
)
