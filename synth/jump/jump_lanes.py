"""Many jumping legs as columns of numbers, modified by effects and tolerances, and the workspace made from them.

Motor columns are the rotor's as in ``synth.jump.hopper_leg.Motor``. Without ``electric`` the motor is its
maker's line; a winding with inductance is added as a lag of that line with the time constant L/R.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array
from synth.jump.hopper_leg import PRB_GAMMA, PRB_STIFFNESS
from synth.jump.jump_layout import JumpLayout

REVERSE_SPEED = 0.05  # rad/s at the output, width of the transition of friction and gear loss between directions


@dataclass(eq=False)
class JumpLanes:
    """Columns (n_lane,) in SI; ``electric``, ``may_pull`` and the layout are common.

    ``body_mass`` : structure and both motors. ``start`` : the upper link's angle in the crouch. ``supply_resistance`` :
    of the common supply of both motors. ``gear_friction`` : in addition to that in the motor's free current, N m at the
    rotor. ``driving``, ``braking`` : torque after the gear over that before it, when the motor drives the link and
    when the link drives the motor. ``ground_friction`` : coefficient, relevant for a leaning jump only.
    """

    layout: JumpLayout
    electric: bool
    may_pull: bool
    length: Array
    lower_length: Array
    hip_spacing: Array
    body_mass: Array
    foot_mass: Array
    mass_per_length: Array
    bending_stiffness: Array
    flexure_rate: Array
    joint_damping: Array
    hip_rest: Array
    knee_rest: Array
    foot_rest: Array
    extended: Array
    stop_rate: Array
    stop_dissipation: Array
    gravity: Array
    start: Array
    ratio: Array
    voltage: Array
    supply_resistance: Array
    resistance: Array
    inductance: Array
    back_emf: Array
    torque_constant: Array
    rotor_inertia: Array
    friction: Array
    viscous: Array
    gear_friction: Array
    driving: Array
    braking: Array
    stall_torque: Array
    no_load_speed: Array
    stall_current: Array
    no_load_current: Array
    contact_stiffness: Array
    contact_damping: Array
    contact_dissipation: Array
    ground_friction: Array

    @property
    def count(self) -> int:
        """Number of lanes."""
        return len(self.length)

    def scale_torque_constant(self, factor: Array) -> None:
        """Torque per current and back-EMF per speed together: one number in SI."""
        self.torque_constant *= factor
        self.back_emf *= factor
        self.stall_torque *= factor
        self.no_load_speed /= factor

    def repeat(self, count: int) -> JumpLanes:
        """Each lane repeated so many times."""
        return self._each(lambda values: np.repeat(values, count))

    def take(self, lanes: slice | NDArray[np.int64]) -> JumpLanes:
        """Some of the lanes, as copies."""
        return self._each(lambda values: values[lanes].copy())

    def _each(self, change: Callable[[Array], Array]) -> JumpLanes:
        kept = ("layout", "electric", "may_pull")
        columns: dict[str, Any] = {f.name: change(getattr(self, f.name)) for f in fields(self) if f.name not in kept}
        return replace(self, **columns)

    @property
    def total_mass(self) -> Array:
        """Body, motors, four links and the foot, kg."""
        return np.asarray(
            self.body_mass + self.foot_mass + 2 * self.mass_per_length * (self.length + self.lower_length)
        )

    @property
    def lower_angle(self) -> Array:
        """Lower links' angle b in the crouch by the closure, rad; nan out of reach."""
        share = (0.5 * self.hip_spacing + self.length * np.sin(self.start)) / self.lower_length
        return np.asarray(np.arcsin(np.where(np.abs(share) < 1.0, share, np.nan)))

    def workspace(self) -> Array:
        """(n_row, n_lane) parameters of the compiled jump, and the crouch at rest with the weight on the foot."""
        layout = self.layout
        z = np.zeros((layout.n_row, self.count))
        mass = self._geometry(z)
        self._drive(z)
        for name, values in (
            *((f"{joint}_rate", self.flexure_rate) for joint in ("hip", "knee", "foot")),
            ("joint_damping", self.joint_damping), ("hip_rest", self.hip_rest),
            ("knee_rest", self.knee_rest), ("foot_rest", self.foot_rest), ("stop", self.extended),
            ("stop_rate", self.stop_rate), ("stop_dissipation", self.stop_dissipation), ("gravity", self.gravity),
            ("contact_stiffness", self.contact_stiffness), ("contact_damping", self.contact_damping),
            ("contact_dissipation", self.contact_dissipation),
        ):  # fmt: skip
            z[layout.row(name)] = values
        z[layout.row("may_pull")] = 1.0 if self.may_pull else 0.0
        for i in range(layout.n - 1):
            if i != layout.knee - 1:
                whole = self.length if i < layout.knee else self.lower_length
                z[layout.row("beam", i)] = PRB_GAMMA * PRB_STIFFNESS * self.bending_stiffness / whole
        a, b = self.start, self.lower_angle
        z[layout.block("angle")][: layout.knee] = a
        z[layout.block("angle")][layout.knee :] = -b
        sag = mass * self.gravity / self.contact_stiffness
        z[layout.row("height")] = self.length * np.cos(a) + self.lower_length * np.cos(b) - sag
        return z

    def _geometry(self, z: Array) -> Array:
        """Lengths, and the coefficients A_ij and G_i of one side, rods of even mass; returns the whole mass."""
        layout = self.layout
        n, knee = layout.n, layout.knee
        pieces = [self.length / knee] * knee + [self.lower_length / (n - knee)] * (n - knee)
        masses = [self.mass_per_length * piece for piece in pieces]
        outboard = [sum(masses[i + 1 :], np.zeros(self.count)) + 0.5 * self.foot_mass for i in range(n)]
        moment = [(0.5 * masses[i] + outboard[i]) * pieces[i] for i in range(n)]
        for i in range(n):
            z[layout.inertia_row(i, i)] = (masses[i] / 3.0 + outboard[i]) * pieces[i] ** 2
            for j in range(i + 1, n):
                z[layout.inertia_row(i, j)] = pieces[i] * moment[j]
        z[layout.block("length")] = pieces
        z[layout.block("moment")] = moment
        mass: Array = self.body_mass + self.foot_mass + 2 * sum(masses, np.zeros(self.count))
        z[layout.row("mass")] = 0.5 * mass
        z[layout.row("half_spacing")] = 0.5 * self.hip_spacing
        return mass

    def _drive(self, z: Array) -> None:
        """One motor at full voltage, all at the output."""
        values: dict[str, Array | float] = {
            "driving": self.driving,
            "braking": self.braking,
            "reverse_speed": REVERSE_SPEED,
            "voltage": self.voltage,
            "friction": self.ratio * self.gear_friction,
        }
        values |= self._winding() if self.electric else self._line()
        for name, value in values.items():
            z[self.layout.row(name)] = value

    def _winding(self) -> dict[str, Array | float]:
        ratio = self.ratio
        return {
            "resistance": self.resistance
            + 2.0 * self.supply_resistance,  # both motors' current flows through the supply
            "inverse_inductance": 1.0 / self.inductance,
            "back_emf": ratio * self.back_emf,
            "torque_constant": ratio * self.torque_constant,
            "rotor_inertia": self.rotor_inertia * ratio**2,
            "friction": ratio * self.friction + ratio * self.gear_friction,
            "viscous": ratio**2 * self.viscous,
        }

    def _line(self) -> dict[str, Array | float]:
        """The maker's line with the supply's voltage drop; with inductance, as a lag."""
        resistance = self.voltage / self.stall_current
        left = resistance / (resistance + 2.0 * self.supply_resistance)
        lags = self.inductance > 0.0
        at_once = left * ~lags
        drop = (self.stall_current - self.no_load_current) / self.no_load_speed
        free = self.no_load_current / self.no_load_speed
        return {
            "linear_torque": at_once * self.stall_torque,
            "torque_slope": at_once * self.stall_torque / self.no_load_speed,
            "linear_current": at_once * self.stall_current,
            "current_slope": np.where(lags, -left * free, at_once * drop),
            "resistance": lags * (resistance + 2.0 * self.supply_resistance),
            "inverse_inductance": lags / np.where(lags, self.inductance, 1.0),
            "back_emf": lags * self.voltage / self.no_load_speed,
            "torque_constant": lags * self.stall_torque / self.stall_current,
        }
