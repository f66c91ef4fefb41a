"""A known torque acts later than its column says."""

from __future__ import annotations

from typing import TYPE_CHECKING

from synth.swing.effects.definition import Effect, Parameter, Prior, Shape
from synth.swing.lane_layout import DRIVE

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.swing.leg_lanes import LegLanes


def drive(legs: LegLanes, joint: int, sign: int, delay: Array) -> None:
    """Delay the torque by ``delay`` (n_lane,) s against its column."""
    legs.drive[DRIVE.index("torque_delay"), joint] += delay


EFFECT = Effect(
    name="torque_delay",
    meaning="a known torque acts later than its column says",
    phrase="has a torque that acts late",
    formula="torque on the joint at t = column at t - delay",
    source="definition",
    way="drive",
    needs=("torque",),
    parameters=(Parameter("delay", "s", prior=Prior(0.0, 0.2, lower=0.0, upper=2.0), meaning="later by"),),
    strengths=("delay",),
    shapes=(Shape(("delay",), {}, ({}, {"delay": 0.2})),),
)
