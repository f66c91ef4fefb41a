"""Gear friction: a torque independent of speed, or a share of the transmitted torque."""

from __future__ import annotations

from typing import TYPE_CHECKING

from synth.estimation.parameters import Parameter, Prior, Shape, size
from synth.jump.effects.jump_effect import MotorEffect

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.jump.jump_lanes import JumpLanes


def change(jumps: JumpLanes, torque: Array, loss: Array) -> None:
    """Add dry friction (N m at the rotor) and remove a share of the transmitted torque, in both directions."""
    jumps.gear_friction += torque
    jumps.driving *= 1.0 - loss
    jumps.braking /= 1.0 - loss


EFFECT = MotorEffect(
    name="gear_friction",
    meaning="more gear friction than designed: dry friction, or a share of the load",
    phrase="have gear friction",
    formula="-torque sign(omega) at the rotor; transmitted torque times (1 - loss)",
    source="Knaup & Aukes, equation 4 (f_0, the same for all their gearboxes); loss: Shigley, Mechanical Engineering "
    "Design, ch. 13",
    place="hip",
    parameters=(
        Parameter("torque", "N*m", 0.0, size(0.15), meaning="dry friction at the rotor"),
        Parameter(
            "loss",
            "1",
            0.0,
            Prior(0.0, 0.2, lower=0.0, upper=0.7),
            meaning="share of the transmitted torque",
            form="share",
        ),
    ),
    strengths=("torque", "loss"),
    shapes=(Shape(("torque",), {}), Shape(("loss",), {})),
)
