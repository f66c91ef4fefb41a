"""A servo's own command approaches the given one at a limited rate: its profile velocity."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from synth.swing.effects.definition import Effect, Parameter, Shape, positive
from synth.swing.lane_layout import SERVO

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.swing.leg_lanes import LegLanes


def drive(legs: LegLanes, joint: int, sign: int, rate: Array) -> None:
    """Limit the rate of the command to ``rate`` (n_lane,) rad/s; 0 for no further limit."""
    limit = legs.servo[SERVO.index("servo_command_rate"), joint]
    lower = np.where(limit > 0.0, np.minimum(limit, rate), rate)
    limit[:] = np.where(rate > 0.0, lower, limit)


EFFECT = Effect(
    name="command_rate_limit",
    meaning="a servo approaches its command at a limited rate",
    phrase="has a servo that limits its command's rate",
    formula="dc/dt = rate sign(command - c) until c = command; the servo holds c, at first the first command",
    source="profile velocity of position servos without an acceleration limit (Robotis e-Manual, XL330, address 112)",
    way="drive",
    needs=("held commands",),
    parameters=(Parameter("rate", "rad/s", prior=positive(1.0, 0.7), meaning="largest rate of the command"),),
    strengths=("rate",),
    shapes=(Shape(("rate",), {}, ({"rate": 1.5}, {"rate": 0.7})),),
)
