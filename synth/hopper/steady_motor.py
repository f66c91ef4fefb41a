"""A gear motor's constants from stall and free-speed tests: steady points, no run-up.

At rest V = R i, and the output's torque is G (K_t i - f) with K_t the effective constant at the output and f the
friction there, with the gear's; running freely V = R i + K_e G omega and K_e i = f0 + b G omega (equations 3 to 6 of
Knaup & Aukes without their rates of change). Each is one linear least squares; inductance and rotor inertia are left to
run-ups. Stall currents that hardly differ do not separate K_t and f: then f = f0 K_t/K_e, as for the motors of a
catalogue (``synth.hopper.motors``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.hopper_recordings import HopperRecording
from synth.hopper.identify_motor import IdentifiedConstant

SAME = 1.2  # largest over smallest voltage of free runs, or current of stall tests; below it they count as one point
LEFT_SHARE = 0.02  # of a value: least deviation assumed for a few readings


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
    UserError : impossible points: a current against its voltage, a free speed of zero.
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
    rows = [np.column_stack([columns["current"], columns.get("speed", np.zeros(len(columns["current"]))) * ratio])
            for columns in (held, running) if columns]  # fmt: skip
    volts = np.concatenate([columns["voltage"] for columns in (held, running) if columns])
    if running:
        if np.any(running["speed"] <= 0):
            raise UserError(Problem("a free speed is 0 or below", key="free_speed"))
        if held:
            (resistance, back_emf), spread = _solve(np.concatenate(rows), volts)
            found["resistance"] = IdentifiedConstant(resistance, spread[0])
            found["back_emf"] = IdentifiedConstant(back_emf, spread[1])
            found |= _friction(running, ratio, found["back_emf"], not_determined)
        else:
            by_runs.append("resistance and back-EMF constant apart: give a stall test")
    else:
        (resistance,), spread = _solve(rows[0][:, :1], volts)
        found["resistance"] = IdentifiedConstant(resistance, spread[0])
        by_runs.append("back-EMF constant and friction: give a free-speed test")
    if held and "torque" in held:
        found |= _torque_constant(held, ratio, found, not_determined)
    return SteadyMotor(found, (*([] if with_runs else by_runs), *not_determined), len(volts))


def _torque_constant(
    held: Mapping[str, Array], ratio: float, found: Mapping[str, IdentifiedConstant], not_determined: list[str]
) -> dict[str, IdentifiedConstant]:
    """Torque at the output over ratio and current, without friction at rest where that can be separated."""
    current, torque = held["current"], held["torque"]
    amount = np.abs(current)
    if len(current) > 2 and amount.max() >= SAME * amount.min():
        (constant, _), spread = _solve(ratio * np.column_stack([current, -np.sign(current)]), torque)
        return {"torque_constant": IdentifiedConstant(constant, spread[0])}
    friction = found.get("friction")
    if friction is None:
        not_determined.append("torque constant apart from friction: give stall currents that differ, or a free speed")
        (constant,), spread = _solve(ratio * current[:, None], torque)
        return {"torque_per_current_at_stall": IdentifiedConstant(constant, spread[0])}
    lost = friction.value / found["back_emf"].value
    if lost >= amount.min():
        text = (
            f"a stall current of {amount.min():g} A is not above the {lost:g} A that friction takes when running free"
        )
        raise UserError(Problem(f"{text}; are columns exchanged?", key="stall"))
    driving = np.sign(current) * (amount - lost)
    (constant,), spread = _solve(ratio * driving[:, None], torque)
    of_friction = constant * friction.deviation / found["back_emf"].value / float(np.mean(amount - lost))
    return {"torque_constant": IdentifiedConstant(constant, float(np.hypot(spread[0], of_friction)))}


def _friction(
    running: Mapping[str, Array], ratio: float, back_emf: IdentifiedConstant, not_determined: list[str]
) -> dict[str, IdentifiedConstant]:
    """Friction at the rotor, and its viscous part if the free runs differ enough in voltage."""
    speed, torque = running["speed"] * ratio, back_emf.value * running["current"]
    share = back_emf.deviation / back_emf.value
    if running["voltage"].max() < SAME * running["voltage"].min() or len(speed) < 3:
        not_determined.append("friction's viscous part: give free speeds at two or more voltages; it is assumed zero")
        level = float(np.mean(torque))
        spread = float(np.std(torque) / np.sqrt(max(1, len(torque) - 1)))
        return {"friction": IdentifiedConstant(level, float(np.hypot(max(spread, LEFT_SHARE * level), share * level)))}
    (friction, viscous), deviations = _solve(np.column_stack([np.ones_like(speed), speed]), torque)
    return {
        "friction": IdentifiedConstant(friction, float(np.hypot(deviations[0], share * friction))),
        "viscous": IdentifiedConstant(viscous, float(np.hypot(deviations[1], share * viscous))),
    }


def _join_rows(records: Sequence[HopperRecording]) -> dict[str, Array]:
    """All records' rows together."""
    names = records[0].columns if records else ()
    return {name: np.concatenate([record[name] for record in records]) for name in names if name != "time"}


def _solve(a: Array, y: Array) -> tuple[list[float], list[float]]:
    """Least squares with standard deviations from the residuals, at least ``LEFT_SHARE`` of each value."""
    size = np.linalg.norm(a, axis=0)
    if len(y) < a.shape[1] or np.linalg.cond(a / size) > 1e6:
        raise UserError(Problem("the points do not separate the constants: vary the voltage", key="stall, free_speed"))
    found, *_ = np.linalg.lstsq(a / size, y, rcond=None)
    left = y - (a / size) @ found
    variance = float(left @ left) / max(1, len(y) - a.shape[1])
    spread = np.sqrt(np.diag(np.linalg.inv((a / size).T @ (a / size))) * variance)
    values = found / size
    deviations = np.maximum(spread / size, LEFT_SHARE * np.abs(values) / np.sqrt(len(y)))
    return [float(value) for value in values], [float(value) for value in deviations]
