"""Candidates: an effect of the motor leg in one of its shapes, its unknowns whitened by their priors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synth.effects import Shape
from synth.effects.motor_leg import MotorEffect, motor_effects
from synth.hopper.jump_lanes import JumpLanes
from synth.hopper.leg import Array
from synth.hopper_gap.data import Jump

SMALL = 0.05  # of its prior's width: where a strength starts
STRONGEST, FARTHEST = 40.0, 6.0  # deviations from its prior's centre that a strength, a shape may go


@dataclass(frozen=True)
class JumpCandidate:
    """One effect in one shape; the unknowns are the shape's free parameters, whitened. ``sizes`` : unit -> SI size."""

    effect: MotorEffect
    shape: Shape
    sizes: dict[str, float]

    @property
    def key(self) -> tuple[str, str]:
        """Effect and place, as the files name them."""
        return self.effect.name, self.effect.place

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return len(self.shape.free)

    def scale(self, name: str) -> float:
        """Natural size of a parameter."""
        parameter = self.effect.parameters[self.effect.index(name)]
        return self.sizes.get(parameter.unit, 1.0) if parameter.natural else 1.0

    def starts(self) -> list[Array]:
        """Whitened starting points (size,)."""
        made = []
        for start in self.shape.starts or ({},):
            point = []
            for name in self.shape.free:
                prior = self.effect.parameters[self.effect.index(name)].prior
                assert prior is not None
                point.append(float(prior.coordinate(start[name])) if name in start else SMALL)
            made.append(np.array(point))
        return made

    def values(self, x: Array) -> Array:
        """(n_parameter, n_lane) all parameters in SI from whitened unknowns (size, n_lane)."""
        found = np.empty((len(self.effect.parameters), x.shape[1]))
        for p, parameter in enumerate(self.effect.parameters):
            if parameter.name in self.shape.free:
                assert parameter.prior is not None
                found[p] = parameter.prior.value(x[self.shape.free.index(parameter.name)]) * self.scale(parameter.name)
            else:
                found[p] = self.effect.defaults[parameter.name]
        return found

    def apply(self, jumps: JumpLanes, x: Array) -> None:
        """Change the columns."""
        self.effect.function("change")(jumps, *self.values(x))

    def bounds(self) -> tuple[Array, Array]:
        """Whitened least and greatest values (size,)."""
        low, high = np.empty(self.size), np.empty(self.size)
        for k, name in enumerate(self.shape.free):
            prior = self.effect.parameters[self.effect.index(name)].prior
            assert prior is not None
            low[k], high[k] = prior.span(FARTHEST if prior.log else STRONGEST)
        return low, high


def natural_sizes(jumps: Sequence[Jump]) -> dict[str, float]:
    """By the first motor and ground: by them a prior fits a cricket's leg and an ostrich's."""
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
