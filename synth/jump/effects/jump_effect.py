"""An effect of the motor-driven leg: it changes the columns of ``synth.jump.jump_lanes.JumpLanes``.

Its module has ``change(jumps, *parameters)``, parameters (n_lane,) in SI, which changes the columns in place; all
parameters zero (or an infinite stiffness of a compliance) leave them unchanged.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from synth.estimation.parameters import PlantEffect

Place = Literal["hip", "all", "base"]


@dataclass(frozen=True)
class MotorEffect(PlantEffect):
    """An effect of the jumping leg.

    ``place`` : its place in files: the hips (motors), all joints, or the ground (base).
    ``leaning`` : whether only a jump from a leaning start shows it.
    """

    place: Place = "hip"
    leaning: bool = False
