"""Compliant ground: a spring in series with the foot's contact."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from synth.estimation.parameters import Parameter, Prior, Shape
from synth.jump.effects.jump_effect import MotorEffect

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.jump.jump_lanes import JumpLanes

SOFT = Prior(np.inf, 3.0, lower=0.02, upper=200.0, inverse=True)  # of the contact's stiffness; usually a third


def change(jumps: JumpLanes, stiffness: Array) -> None:
    """Springs in series; 0 stands for none (N/m)."""
    there = stiffness > 0.0
    series = jumps.contact_stiffness / (1.0 + jumps.contact_stiffness / np.where(there, stiffness, np.inf))
    jumps.contact_stiffness[:] = np.where(there, series, jumps.contact_stiffness)


EFFECT = MotorEffect(
    name="ground_compliance",
    meaning="the ground under the foot is more compliant than designed",
    phrase="is compliant under the foot",
    formula="1/k = 1/k_contact + 1/stiffness",
    source="springs in series",
    place="base",
    parameters=(Parameter("stiffness", "N/m", 0.0, SOFT, meaning="of the compliance in series with the contact"),),
    strengths=("stiffness",),
    shapes=(Shape(("stiffness",), {}, ({"stiffness": 0.3},)),),
)
