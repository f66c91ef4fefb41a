"""Candidates: an effect of the motor leg in one of its shapes, in natural sizes of motor and ground."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from synth.arrays import Array
from synth.diagnosis.effect_shape import ShapedEffect
from synth.diagnosis.hypotheses import Key
from synth.diagnosis.plants.jumping_leg.jump_data import Jump
from synth.estimation.parameters import Parameter
from synth.jump.effects import MotorEffect, motor_effects
from synth.jump.jump_lanes import JumpLanes


@dataclass(frozen=True)
class JumpCandidate(ShapedEffect):
    """One effect of the motor leg in one shape. ``sizes`` : unit -> its natural size in SI."""

    effect: MotorEffect
    sizes: dict[str, float]

    @property
    def key(self) -> Key:
        """Effect and place, as named in files."""
        return self.effect.name, self.effect.place

    def natural_size(self, parameter: Parameter) -> float:
        """The natural size by motor and ground, see ``natural_sizes``."""
        return self.sizes.get(parameter.unit, 1.0) if parameter.natural else 1.0

    def apply(self, jumps: JumpLanes, x: Array) -> None:
        """Change the columns."""
        self.effect.function("change")(jumps, *self.values(x))


def natural_sizes(jumps: Sequence[Jump]) -> dict[str, float]:
    """Natural sizes from the first motor and the ground, so that priors scale with the size of the leg."""
    of = jumps[0].jumps
    resistance = float(of.voltage[0] / of.stall_current[0])
    return {
        "H": resistance * 1e-3,
        "ohm": resistance,
        "N*m": float(of.torque_constant[0] * of.stall_current[0]),
        "N*m*s/rad": float(of.stall_torque[0] / of.no_load_speed[0]),
        "N/m": float(of.contact_stiffness[0]),
    }


def candidates(jumps: Sequence[Jump]) -> list[JumpCandidate]:
    """Every effect that these trials could show, in every shape."""
    sizes = natural_sizes(jumps)
    jumping = any(jump.trial.kind == "jump" for jump in jumps)
    leaning = any(jump.leaning for jump in jumps)
    made = []
    for effect in motor_effects():
        if (effect.leaning and not leaning) or (effect.name != "joint_damping" and not jumping):
            continue
        made += [JumpCandidate(effect, shape, sizes) for shape in effect.shapes]
    return made
