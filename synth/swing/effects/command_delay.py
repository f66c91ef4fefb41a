"""A servo follows its command later than stated."""

from __future__ import annotations

from typing import TYPE_CHECKING

from synth.swing.effects.definition import Effect, Parameter, Prior, Shape
from synth.swing.lane_layout import SERVO

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.swing.leg_lanes import LegLanes


def drive(legs: LegLanes, joint: int, sign: int, delay: Array) -> None:
    """Add ``delay`` (n_lane,) s to the servo's command delay of the leg file."""
    legs.servo[SERVO.index("servo_delay"), joint] += delay


EFFECT = Effect(
    name="command_delay",
    meaning="a servo follows its command later than stated",
    phrase="follows its command late",
    formula="command of the servo at t = column at t - delay",
    source="definition; bus round trip and control period: Duclusaud et al., BAM, arXiv 2410.08650",
    way="drive",
    needs=("servo",),
    parameters=(Parameter("delay", "s", prior=Prior(0.0, 0.2, lower=0.0, upper=2.0), meaning="later by"),),
    strengths=("delay",),
    shapes=(Shape(("delay",), {}, ({}, {"delay": 0.2})),),
)
