"""Columns of a trial with the inputs of its drives: commands, currents, voltages, supply, switches."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from synth.arrays import Array
from synth.drives.servo import Servo, ServoSignals, TorqueDrive
from synth.errors import Problem
from synth.files.csv_table import CsvTable
from synth.swing.leg_model import Joint, Leg

SUFFIXES = {" command": "rad", " voltage": "V", " current": "A", " enabled": "1"}
SUPPLY = "supply"
# Suffix -> a drive that takes such a column, as a leg file states it.
DRIVES = {
    " command": "drive: {kind: servo, gain: 20 N*m/rad}",
    " voltage": "drive: {kind: voltage, motor: {torque_constant: 0.02 N*m/A, resistance: 2 ohm}}",
    " current": "drive: {kind: torque, motor: {torque_constant: 0.02 N*m/A}}",
    " enabled": "drive: {kind: servo, gain: 20 N*m/rad}",
}


def column_units(leg: Leg) -> dict[str, str]:
    """Name of every possible column -> its SI unit."""
    made = {joint + suffix: unit for suffix, unit in SUFFIXES.items() for joint in leg.joint_names}
    return made | {SUPPLY: "V"}


def problems(table: CsvTable, leg: Leg, off: Sequence[str] = ()) -> list[Problem]:
    """Missing columns of a joint's drive, and columns of drives that do not exist; ``off`` : joints whose drive is."""
    present = {column.name for column in table.columns}
    found = []
    for joint in leg.joints:
        wanted, allowed = _columns(joint)
        if joint.name in off:
            found += _problems_off(table, joint)
            wanted = set()
        for suffix in SUFFIXES:
            name = joint.name + suffix
            if name in present and suffix not in allowed:
                text = (
                    f"{joint.name} has no drive that takes it: give the joint one in the leg file, as {DRIVES[suffix]}"
                )
                found.append(Problem(f"{text}, or leave the column out", table.name, 1, name))
        for suffix in wanted - {suffix for suffix in SUFFIXES if joint.name + suffix in present}:
            text = f'column "{joint.name}{suffix} [{EXAMPLES[suffix]}]" is missing: the drive of {joint.name} needs it'
            text += f"; if it was off, its winding open, write drive_off: [{joint.name}] beside the file in the project"
            found.append(Problem(text, table.name, 1))
    return found


def _problems_off(table: CsvTable, joint: Joint) -> list[Problem]:
    """Mistakes of a joint whose drive is said to be off: it has none, or a column says that it acts."""
    if joint.drive is None:
        return [Problem(f"{joint.name} has no drive that could be off; leave it out", table.name, key="drive_off")]
    acts = {joint.name + suffix for suffix in (" current", " enabled")}
    acts |= {f"{joint.name} torque"} if joint.drive == TorqueDrive() else set()  # beside a motor it is another torque
    text = f"is given, though drive_off says that the drive of {joint.name} is off; leave one of them out"
    return [Problem(text, table.name, 1, column.name) for column in table.columns if column.name in acts]


def switched_off(leg: Leg, values: Mapping[str, Array], off: Sequence[str]) -> dict[str, Array]:
    """The columns with those of servos that are ``off``: an open winding, so that no command or voltage acts."""
    made = dict(values)
    for joint in leg.joints:
        if joint.name in off and isinstance(joint.drive, Servo):
            angle = values[joint.name]
            made[joint.name + " enabled"] = np.zeros_like(angle)
            still = 0.0 if joint.drive.open_duty else float(angle[np.isfinite(angle)][0])
            made[joint.name + (" voltage" if joint.drive.open_duty else " command")] = np.full_like(angle, still)
    return made


EXAMPLES = {" command": "deg", " voltage": "V", " current": "A", " enabled": "1"}


def _columns(joint: Joint) -> tuple[set[str], set[str]]:
    """Suffixes that a joint's drive requires, and that it accepts."""
    if isinstance(joint.drive, Servo):
        needed = {" voltage"} if joint.drive.open_duty else {" command"}
        return needed, needed | {" enabled"}
    return set(), {" current"} if isinstance(joint.drive, TorqueDrive) and joint.drive.motor is not None else set()


def signals(leg: Leg, values: Mapping[str, Array], recorded: Array) -> ServoSignals | None:
    """The inputs of the servos, in measured angles; None if no joint has a servo.

    ``values``: column -> (m,) SI; empty cells are nan: a command is held over them, unless its servo interpolates; all
    else is linear; ``recorded`` (m,) s.
    """
    servos = [joint for joint in leg.joints if isinstance(joint.drive, Servo)]
    if not servos:
        return None
    told = {
        index: _samples(recorded, values[joint.name + " command"])
        for index, joint in enumerate(leg.joints)
        if isinstance(joint.drive, Servo) and not joint.drive.open_duty
    }
    time = np.unique(np.concatenate([recorded, *(moments for moments, _ in told.values())]))
    shape = len(time), len(leg.joints)
    command, supply, enabled, held = np.zeros(shape), np.ones(shape), np.ones(shape), []

    def column(name: str, late: float = 0.0) -> Array:
        return np.interp(time - late, recorded, _filled(recorded, values[name]))

    for index, joint in enumerate(leg.joints):
        if not isinstance(joint.drive, Servo):
            continue
        motor = joint.drive.motor
        if joint.drive.open_duty:
            supply[:, index] = joint.sign * column(joint.name + " voltage", 0.0 if motor is None else motor.lag)
        else:
            moments, angles = told[index]
            if joint.drive.linear_commands:
                command[:, index] = np.interp(time, moments, angles)
            else:
                held.append(index)
                command[:, index] = angles[np.clip(np.searchsorted(moments, time, side="right") - 1, 0, None)]
            measured = SUPPLY in values and motor is not None
            supply[:, index] = column(SUPPLY) if measured else joint.drive.supply
        if joint.name + " enabled" in values:
            enabled[:, index] = np.clip(column(joint.name + " enabled"), 0.0, 1.0)
    return ServoSignals(time, command, supply, enabled, tuple(held))


def _samples(time: Array, value: Array) -> tuple[Array, Array]:
    """A command's own samples: an empty cell is none, so a command may have another clock than the angles."""
    known = np.isfinite(value)
    return time[known], value[known]


def torques(leg: Leg, values: Mapping[str, Array]) -> dict[str, Array]:
    """Torques, N m in the measured sense, of joints whose drive's current was recorded, by name."""
    found = {}
    for joint in leg.joints:
        current = values.get(joint.name + " current")
        if current is not None and isinstance(joint.drive, TorqueDrive) and joint.drive.motor is not None:
            found[joint.name] = joint.drive.motor.torque_a_current * current
    return found


def _filled(time: Array, value: Array) -> Array:
    known = np.isfinite(value)
    return np.interp(time, time[known], value[known])
