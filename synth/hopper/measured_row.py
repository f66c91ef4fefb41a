"""A measured motor as a catalogue row, which a design takes like any other.

The row is at the voltage of the catalogue's motor that was measured, with what its maker alone knows: mass, shaft, the
gear's limit. From the constants at the rotor (ratio G), with the current of dry friction f/K_e:

    I_stall = V/R,   w = (V - f R/K_e)/(K_e + b R/K_e),   I_free = (f + b w)/K_e,   T_stall = K_t G (I_stall - f/K_e)

the inverse of ``synth.hopper.motors``. K_t holds the gear's loss: from a stall test, else K_e with the efficiency at
stall of the catalogue's row.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from synth.errors import Problem, UserError
from synth.hopper.hopper_tolerances import UNIFORM
from synth.hopper.identify_motor import IdentifiedConstant, MotorEstimate
from synth.hopper.motor_response import CONSTANTS
from synth.hopper.steady_motor import SteadyMotor
from synth.jump.hopper_leg import HopperTolerances
from synth.parts.rows import GearMotorRow
from synth.units import factor

SAME_RATIO = 0.02  # relative difference of the written gear ratio from the catalogue's: rounded tooth counts
NEEDED = ("resistance", "back_emf", "friction")
MOST_HALF = 0.8  # of a constant: what a tolerance may be at most, 0.9, less the step from a half width to a limit
STALL = ("torque_constant", "torque_per_current_at_stall")


@dataclass(frozen=True)
class MeasuredRow:
    """The row; ``friction_share`` : of the no-load current, its dry part; ``tolerances`` : 90 % half widths, shares."""

    row: GearMotorRow
    friction_share: float
    tolerances: Mapping[str, float]

    @property
    def columns(self) -> dict[str, list[str | float]]:
        """Header -> the one cell, for a CSV of gear motors."""
        found: dict[str, list[str | float]] = {}
        for item in GearMotorRow.columns():
            unit, shown, value = item.metadata["unit"], item.metadata.get("shown", ""), getattr(self.row, item.name)
            if value in (None, ""):
                continue
            title = item.name if unit is None else f"{item.name} [{shown}]"
            found[title] = [value if unit in (None, shown) else value / factor(shown, unit)]
        return found

    @property
    def lines(self) -> list[str]:
        """What a design writes to use it."""
        tolerances = ", ".join(f"{name}: {100 * share:.2g} %" for name, share in self.tolerances.items())
        return [
            f'motors: {{use: ["{self.row.part}"], catalogs: [motor.csv], friction_share: {self.friction_share:.6g}}}',
            f"tolerance: {{{tolerances}}}",
        ]


def measured_row(
    made: GearMotorRow, ratio: float, found: MotorEstimate | None, steady: SteadyMotor | None
) -> MeasuredRow:
    """The row of the motor ``made`` by its maker, as measured by run-ups ``found``, ``steady`` tests, or both.

    Raises
    ------
    UserError : resistance, back-EMF constant or friction are not determined, the ratio is not the maker's, or the
        maker's row lacks its voltage or the gear's efficiency.
    """
    constants: dict[str, IdentifiedConstant] = dict(steady.constants) if steady is not None else {}
    if found is not None:
        constants |= {name: getattr(found, name) for name in CONSTANTS}
    if missing := [name.replace("_", " ") for name in NEEDED if name not in constants]:
        raise UserError(Problem(f"the tests leave {', '.join(missing)} open, so there is no row of it", key="motor"))
    if made.gear_ratio is None or abs(ratio / made.gear_ratio - 1.0) > SAME_RATIO:
        text = f"{made.part} has a gear ratio of {made.gear_ratio or 0.0:g}; gear_ratio is {ratio:g}"
        raise UserError(Problem(text, key="motor"))
    if made.voltage is None or made.mass is None:
        raise UserError(Problem(f"the catalogue states no voltage or mass of {made.part}", key="motor"))
    resistance, back_emf, friction = (constants[name].value for name in NEEDED)
    viscous = max(constants["viscous"].value, 0.0) if "viscous" in constants else 0.0
    dry, stalled = friction / back_emf, made.voltage / resistance
    speed = (made.voltage - dry * resistance) / (back_emf + viscous / back_emf * resistance)
    free = dry + viscous / back_emf * speed
    if not 0.0 < dry < stalled:
        raise UserError(Problem(f"at {made.voltage:g} V the measured motor does not turn freely", key="motor"))
    torque, half, basis = _stall_torque(made, ratio, constants, dry, stalled)
    halves = {name: _relative_half(constants[name]) for name in constants if constants[name].value > 0.0}
    open_ = constants["inductance"].interval90[0] <= 0.0 if "inductance" in constants else True
    row = replace(
        made, part=f"{made.part} measured", gear_ratio=ratio,
        no_load_speed=speed / ratio, stall_torque=torque, stall_current=stalled, no_load_current=free,
        speed_tolerance=halves["back_emf"] / UNIFORM, current_tolerance=halves["friction"] / UNIFORM,
        resistance=resistance, inductance=None if open_ else constants["inductance"].value,
        rotor_inertia=constants["rotor_inertia"].value if "rotor_inertia" in constants else None,
        basis=f"found; measured, stall torque from {basis}", note="made by synth hopper",
        speed_at_best_efficiency=None, torque_at_best_efficiency=None, current_at_best_efficiency=None,
        price="", as_published="",
        source=f"measured; mass, shaft and torque limit are those of {made.part}",
    )  # fmt: skip
    tolerances = {"torque": half}
    if "rotor_inertia" in halves:
        tolerances["rotor_inertia"] = halves["rotor_inertia"]
    return MeasuredRow(row, dry / free, tolerances)


def _stall_torque(
    made: GearMotorRow, ratio: float, constants: Mapping[str, IdentifiedConstant], dry: float, stalled: float
) -> tuple[float, float, str]:
    """Stall torque N m, its relative 90 % half width, and where it is from."""
    for name, lost in zip(STALL, (dry, 0.0), strict=True):
        if name in constants:
            return constants[name].value * ratio * (stalled - lost), _relative_half(constants[name]), "the stall test"
    if made.torque_gain is None:
        text = f"the catalogue states no efficiency of {made.part}: give a stall test with torque"
        raise UserError(Problem(text, key="motor"))
    torque = made.torque_gain * constants["back_emf"].value * ratio * (stalled - dry)
    return torque, HopperTolerances.torque, "the catalogue's efficiency"


def _relative_half(found: IdentifiedConstant) -> float:
    low, high = found.interval90
    return min(MOST_HALF, 0.5 * (high - low) / found.value)
