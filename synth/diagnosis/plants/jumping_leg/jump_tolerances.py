"""Tolerances of manufacturing and measurement of a jumping leg, as whitened unknowns on its columns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.files.hopper_gap_project import JumpTolerance
from synth.jump.jump_lanes import JumpLanes

SHARED_TOLERANCES = ("length", "mass", "spring", "damper", "supply", "ground", "stop", "bumper", "angle", "force")
MOTOR_TOLERANCES = ("motor", "resistance", "inductance", "friction", "rotor_inertia", "efficiency")


@dataclass(frozen=True)
class JumpTolerances:
    """Standard normal unknowns: ``SHARED_TOLERANCES`` by all trials, then ``MOTOR_TOLERANCES`` for each of ``motors``
    motors.
    """

    tolerance: JumpTolerance
    motors: int

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return len(SHARED_TOLERANCES) + self.motors * len(MOTOR_TOLERANCES)

    def at(self, name: str, group: int) -> int:
        """Index of an unknown."""
        if name in SHARED_TOLERANCES:
            return SHARED_TOLERANCES.index(name)
        return len(SHARED_TOLERANCES) + group * len(MOTOR_TOLERANCES) + MOTOR_TOLERANCES.index(name)

    def shift(self, x: Array, name: str, group: int) -> Array:
        """Relative error or angle (n_lane,) from unknowns ``x`` (size, n_lane)."""
        return np.asarray(getattr(self.tolerance, name) * x[self.at(name, group)])

    def apply(self, jumps: JumpLanes, x: Array, group: int) -> None:
        """Change the columns; relative errors enter as exponentials. ``angle`` and ``force`` are sensor errors."""

        def factor(name: str) -> Array:
            return np.asarray(np.exp(self.shift(x, name, group)))

        for column, name in (
            ("length", "length"), ("lower_length", "length"), ("body_mass", "mass"), ("mass_per_length", "mass"),
            ("flexure_rate", "spring"), ("stop_rate", "bumper"), ("joint_damping", "damper"),
            ("contact_stiffness", "ground"),
            ("inductance", "inductance"), ("friction", "friction"), ("viscous", "friction"),
            ("rotor_inertia", "rotor_inertia"), ("driving", "efficiency"), ("voltage", "supply"),
            ("resistance", "resistance"), ("stall_torque", "supply"), ("stall_current", "supply"),
            ("no_load_speed", "supply"),
        ):  # fmt: skip
            values = getattr(jumps, column)
            values *= factor(name)
        jumps.braking[:] /= factor("efficiency")
        jumps.extended[:] += self.shift(x, "stop", group)
        jumps.stall_torque[:] /= factor("resistance")
        jumps.stall_current[:] /= factor("resistance")
        jumps.scale_torque_constant(factor("motor"))

    def against_design(self, effect: str, values: Mapping[str, float], jumps: JumpLanes, x: Array) -> dict[str, float]:
        """Parameters of an effect with what the tolerances ``x`` (size,) of the same numbers add to them.

        ``jumps`` : a trial as designed. Of several motors the mean of their tolerances.
        """
        found = dict(values)

        def factor(name: str) -> float:
            groups = range(self.motors if name in MOTOR_TOLERANCES else 1)
            return float(np.exp(np.mean([self.shift(x, name, group) for group in groups])))

        if effect == "torque_constant":
            found["share"] = factor("motor") * (1.0 + found["share"]) - 1.0
        elif effect == "gear_friction" and "torque" in found:
            found["torque"] += float(jumps.friction[0]) * (factor("friction") - 1.0)
        elif effect == "gear_friction" and "loss" in found:
            found["loss"] = 1.0 - factor("efficiency") * (1.0 - found["loss"])
        elif effect == "joint_damping":
            found["damping"] += float(jumps.joint_damping[0]) * (factor("damper") - 1.0)
        elif effect == "winding_inductance":
            found["inductance"] += float(jumps.inductance[0]) * (factor("inductance") - 1.0)
        return found
