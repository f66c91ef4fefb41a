"""A gear motor's constants from stall and free-speed tests: steady points, no run-up.

At rest V = R i, and the output's torque is G (K_t i - f) with K_t the effective constant at the output and f the
friction there, with the gear's; running freely V = R i + K_e G omega and K_e i = f0 + b G omega (equations 3 to 6 of
Knaup & Aukes without their rates of change). Inductance and rotor inertia are left to run-ups. Stall currents that
hardly differ do not separate K_t and f: then f = f0 K_t/K_e, as for the motors of a catalogue
(``synth.hopper.motors``).

Voltages are exact; currents, torques and speeds are read with errors in proportion to their size, one proportion for
each column of each test. Each constant is a mean, or a line over the voltage, so that no noisy reading is a regressor
(``synth.hopper.steady_readings``): R and K_e by the means of i/V and (V - R i)/(G omega), f0 and b by the line of the
free current, which is i = (f0 + b V/K_e)/(K_e + R b/K_e), K_t and f by that of T/(G i) over 1/V.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.hopper_recordings import HopperRecording
from synth.hopper.identify_motor import IdentifiedConstant
from synth.hopper.steady_readings import Reading, line, mean

SAME = 1.2  # largest over smallest voltage of free runs, or of stall tests; below it they count as one point
FEWEST = 3  # points of a line, of which one degree of freedom is left for their scatter


@dataclass(frozen=True)
class SteadyMotor:
    """Constants at the rotor, except ``torque_constant``, the effective one at the output over ratio and current.

    Where friction at rest is not known, ``torque_per_current_at_stall`` stands for it, less that friction.
    ``not_determined``: constants that these tests, and run-ups where there are some, leave open, and why.
    """

    constants: Mapping[str, IdentifiedConstant]
    not_determined: tuple[str, ...]
    points: int


def steady_motor(
    stall: Sequence[HopperRecording], free: Sequence[HopperRecording], ratio: float, *, with_runs: bool = False
) -> SteadyMotor:
    """Constants from stall (voltage, current, torque) and free running (voltage, current, speed), at the output.

    ``with_runs``: run-ups of the motor are given too, so what they determine is not missing.

    Raises
    ------
    UserError : impossible points: a current against its voltage, a free speed of zero, a free current of a motor that
        stands.
    """
    found: dict[str, IdentifiedConstant] = {}
    not_determined: list[str] = []
    by_runs = ["inductance and rotor inertia: give run-ups under runs"]
    held, running = _join_rows(stall), _join_rows(free)
    for name, columns in (("stall", held), ("free_speed", running)):
        if columns and min(np.min(columns["voltage"] * columns["current"]), np.min(np.abs(columns["voltage"]))) <= 0:
            raise UserError(
                Problem("a current runs against its voltage, or one is 0; are columns exchanged?", key=name)
            )
    resistance = back_emf = friction = None
    if held:
        at_stall = mean(held["current"] / held["voltage"])
        resistance = Reading(1.0 / at_stall.value, at_stall.times(at_stall.value**-2))
        found["resistance"] = resistance.constant(positive=True)
    else:
        by_runs.append("resistance and back-EMF constant apart: give a stall test")
    if running and np.any(running["speed"] <= 0):
        raise UserError(Problem("a free speed is 0 or below", key="free_speed"))
    if not running:
        by_runs.append("back-EMF constant and friction: give a free-speed test")
    elif resistance is not None:
        back_emf = _back_emf(running, ratio, resistance)
        found["back_emf"] = back_emf.constant(positive=True)
        friction, viscous = _friction(running, resistance, back_emf, not_determined)
        found["friction"] = friction.constant()
        if viscous is not None:
            found["viscous"] = viscous.constant()
    if held and "torque" in held:
        lost = None if friction is None or back_emf is None else _lost_current(friction, back_emf)
        found |= _torque_constant(held, ratio, lost, not_determined)
    points = sum(len(columns["voltage"]) for columns in (held, running) if columns)
    return SteadyMotor(found, (*([] if with_runs else by_runs), *not_determined), points)


def _back_emf(running: Mapping[str, Array], ratio: float, resistance: Reading) -> Reading:
    """K_e from free runs, N m/A at the rotor.

    Raises
    ------
    UserError : the winding alone takes the whole voltage.
    """
    left = running["voltage"] - resistance.value * running["current"]
    if np.any(left <= 0):
        worst = int(np.argmin(left))
        text = f"{running['voltage'][worst]:g} V at {running['current'][worst]:g} A leave no voltage for the speed"
        text += f" with the {resistance.value:.3g} ohm of the stall test; are the tests or columns exchanged?"
        raise UserError(Problem(text, key="free_speed"))
    each = left / (ratio * running["speed"])
    level = mean(each)
    of_resistance = -level.value * float(np.mean(running["current"] / left))
    return Reading(level.value, level.scatters + resistance.times(of_resistance))


def _friction(
    running: Mapping[str, Array], resistance: Reading, back_emf: Reading, not_determined: list[str]
) -> tuple[Reading, Reading | None]:
    """Friction at the rotor, and its viscous part if the free runs differ enough in voltage."""
    voltage, current, constant = running["voltage"], running["current"], back_emf.value
    if voltage.max() < SAME * voltage.min() or len(current) < FEWEST:
        not_determined.append("friction's viscous part: give free speeds at two or more voltages; it is assumed zero")
        level = mean(current)
        return Reading(constant * level.value, level.times(constant) + back_emf.times(level.value)), None
    drawn = line(voltage, current, proportional=True)
    # Of i = a + c V: f0 = a K_e / (1 - R c), b = c K_e^2 / (1 - R c)
    turned = 1.0 - resistance.value * drawn.slope
    if turned <= 0.0:
        text = f"the free current grows by {drawn.slope:.3g} A for each V, as if the motor stood still"
        raise UserError(Problem(f"{text}; are the tests or columns exchanged?", key="free_speed"))
    friction, viscous = drawn.intercept * constant / turned, drawn.slope * constant**2 / turned
    share = drawn.slope / turned
    own = drawn.scatter(constant / turned, friction * resistance.value / turned)
    rubbing = Reading(friction, (own, *back_emf.times(friction / constant), *resistance.times(friction * share)))
    own = drawn.scatter(0.0, (constant / turned) ** 2)
    damping = Reading(viscous, (own, *back_emf.times(2.0 * viscous / constant), *resistance.times(viscous * share)))
    return rubbing, damping


def _lost_current(friction: Reading, back_emf: Reading) -> Reading:
    """The current that friction takes, A, which the back-EMF constant's error hardly moves."""
    return Reading(friction.value / back_emf.value, friction.times(1.0 / back_emf.value))


def _torque_constant(
    held: Mapping[str, Array], ratio: float, lost: Reading | None, not_determined: list[str]
) -> dict[str, IdentifiedConstant]:
    """Torque at the output over ratio and current, without friction at rest where that can be separated."""
    current, torque, voltage = np.abs(held["current"]), held["torque"] * np.sign(held["current"]), held["voltage"]
    amount = np.abs(voltage)
    if len(current) >= FEWEST and amount.max() >= SAME * amount.min():
        # The voltage stands for the current beside friction: a reading on both sides would pass its error for friction
        found = line(1.0 / amount, torque / (ratio * current), proportional=False)
        return {"torque_constant": Reading(found.intercept, (found.scatter(1.0, 0.0),)).constant()}
    if lost is None:
        not_determined.append("torque constant apart from friction: give stall currents that differ, or a free speed")
        return {"torque_per_current_at_stall": mean(torque / (ratio * current), 2).constant()}
    driving = current - lost.value
    if driving.min() <= 0.0:
        text = f"a stall current of {current.min():g} A is not above the {lost.value:g} A that friction takes"
        raise UserError(Problem(f"{text} when running free; are columns exchanged?", key="stall"))
    level = mean(torque / (ratio * driving), 2)
    of_lost = level.value * float(np.mean(1.0 / driving))
    return {"torque_constant": Reading(level.value, level.scatters + lost.times(of_lost)).constant()}


def _join_rows(records: Sequence[HopperRecording]) -> dict[str, Array]:
    """All records' rows together."""
    names = records[0].columns if records else ()
    return {name: np.concatenate([record[name] for record in records]) for name in names if name != "time"}
