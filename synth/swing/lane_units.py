"""Lanes in another unit of time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from synth.arrays import Array
from synth.swing.effects import Effect
from synth.swing.lane_groups import Switches
from synth.swing.lane_layout import FIRST_LAW, LANES, Layout
from synth.swing.time_unit import time_exponent

# Power of time in the unit of each block of rows outside the effects; 0 for all other blocks.
IN_TIME = {
    "rate": -1, "spring_rate": -2, "damper_rate": -1, "gravity": -2, "gravity_across": -2, "weight": -2,
    "curve_speed": -1, "curve_slope": -1, "torque_offset": -2, "torque_delay": 1, "servo_damping_gain": 1,
    "servo_strength": -2, "servo_back_emf": -1, "servo_torque_limit": -2, "servo_delay": 1, "servo_period": 1,
    "servo_phase": 1, "servo_command_rate": -1, "servo_integral_gain": -1, "slew_short": 1, "slew_slope": -1,
    "drive_torque": -2, "known_torque": -2,
}  # fmt: skip


@dataclass(frozen=True)
class LaneUnits:
    """Converts the rows of a chain's lanes; ``effects`` in the order of ``layout.laws``."""

    layout: Layout
    effects: tuple[Effect, ...]

    def factors(self, unit: float) -> Array:
        """(n_row * 16,) factors that convert lanes to a unit of time, s; cached, because trials share few units."""
        if unit not in self._factors:
            self._factors[unit] = np.repeat(unit**-self._time_exponents, LANES)
        return self._factors[unit]

    def seconds(self, switched: Sequence[Switches]) -> bool:
        """Whether lanes must stay in seconds: an effect from outside this package acts, which may contain some."""
        return bool(self._users_own) and any(active[1, self._users_own].any() for active in switched)

    @cached_property
    def _factors(self) -> dict[float, Array]:
        """The results of ``factors``."""
        return {}

    @cached_property
    def _time_exponents(self) -> Array:
        """(n_row,) power of time in the unit of each row's quantity."""
        found, layout = np.zeros(self.layout.n_row), self.layout
        for block, exponent in IN_TIME.items():
            first, count = layout.blocks[block]
            found[first : first + count] = exponent
        for effect in self.effects:
            for p, parameter in enumerate(effect.parameters):
                found[layout.parameter_rows(effect.name, p)] = time_exponent(parameter.unit)
        return found

    @cached_property
    def _users_own(self) -> list[int]:
        """Indices of the effects from outside this package among the switches."""
        return [FIRST_LAW + i for i, effect in enumerate(self.effects) if not effect.module.startswith("synth.")]
