"""What an effect of the motor-driven leg is: one that changes the columns of ``synth.jump.jump_lanes.JumpLanes``.

Its module has ``change(jumps, *parameters)``, parameters (n_lane,) in SI, which changes the columns in place; all
parameters zero (or, for a compliance's stiffness, without bound) leave them as they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from synth.estimation.parameters import PlantEffect

Place = Literal["hip", "all", "base"]


@dataclass(frozen=True)
class MotorEffect(PlantEffect):
    """An effect of the jumping leg.

    ``place`` : where the files say that it sits: the hips, whose motors it is about, all joints, or the ground (base).
    ``leaning`` : only a jump from a leaning start can show it.
    """

    place: Place = "hip"
    leaning: bool = False
