"""A lower torque limit of a drive than stated: its controller limits the current."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from synth.swing.effects.definition import Effect, Parameter, Shape, positive

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.swing.leg_lanes import LegLanes


def drive(legs: LegLanes, joint: int, sign: int, torque: Array) -> None:
    """Limit the drive to ``torque`` (n_lane,) N m; 0 for no further limit."""
    limit = legs.torque_limit[joint]
    limit[:] = np.where(torque > 0.0, np.minimum(limit, torque), limit)


EFFECT = Effect(
    name="current_limit",
    former=("drive_torque_limit",),
    meaning="a drive's current, and with it its torque, is limited",
    phrase="has a drive whose current is limited",
    formula="torque of the drive between -torque and torque, whatever its motor's constant",
    source="current limit of position servos, as in Duclusaud et al., BAM, arXiv 2410.08650",
    way="drive",
    needs=("servo", "motor"),
    parameters=(Parameter("torque", "N*m", prior=positive(0.7, 0.5), meaning="largest torque"),),
    strengths=("torque",),
    shapes=(Shape(("torque",), {}, ({"torque": 0.9}, {"torque": 0.6})),),
)
