"""Columns of a trial with the inputs of its drives: commands, currents, voltages, supply, switches."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array
from synth.drives.servo import Servo, ServoSignals, TorqueDrive
from synth.errors import Problem
from synth.files.csv_table import CsvTable
from synth.swing.leg_model import Joint, Leg

SUFFIXES = {" command": "rad", " voltage": "V", " current": "A", " enabled": "1"}
SUPPLY = "supply"


def column_units(leg: Leg) -> dict[str, str]:
    """Name of every possible column -> its SI unit."""
    made = {joint + suffix: unit for suffix, unit in SUFFIXES.items() for joint in leg.joint_names}
    return made | {SUPPLY: "V"}


def problems(table: CsvTable, leg: Leg) -> list[Problem]:
    """Missing columns of a joint's drive, and columns of drives that do not exist."""
    present = {column.name for column in table.columns}
    found = []
    for joint in leg.joints:
        wanted, allowed = _columns(joint)
        for suffix in SUFFIXES:
            name = joint.name + suffix
            if name in present and suffix not in allowed:
                text = f"{joint.name} has no drive that takes it: give the joint a drive in the leg file, or leave the "
                found.append(Problem(text + "column out", table.name, 1, name))
        for suffix in wanted - {suffix for suffix in SUFFIXES if joint.name + suffix in present}:
            text = f'column "{joint.name}{suffix} [{EXAMPLES[suffix]}]" is missing: the drive of {joint.name} needs it'
            found.append(Problem(text, table.name, 1))
    return found


EXAMPLES = {" command": "deg", " voltage": "V", " current": "A", " enabled": "1"}


def _columns(joint: Joint) -> tuple[set[str], set[str]]:
    """Suffixes that a joint's drive requires, and that it accepts."""
    if isinstance(joint.drive, Servo):
        needed = {" voltage"} if joint.drive.open_duty else {" command"}
        return needed, needed | {" enabled"}
    return set(), {" current"} if isinstance(joint.drive, TorqueDrive) else set()


def signals(leg: Leg, values: Mapping[str, Array], recorded: Array) -> ServoSignals | None:
    """The inputs of the servos, in measured angles; None if no joint has a servo.

    ``values``: column -> (m,) SI; empty cells are nan: a command is held over them, all else is interpolated
    linearly; ``recorded`` (m,) s.
    """
    servos = [joint for joint in leg.joints if isinstance(joint.drive, Servo)]
    if not servos:
        return None
    commands = {
        index: _samples(recorded, values[joint.name + " command"])
        for index, joint in enumerate(leg.joints)
        if isinstance(joint.drive, Servo) and not joint.drive.open_duty
    }
    time = _knots(recorded, list(commands.values()))
    shape = len(time), len(leg.joints)
    command, supply, enabled = np.zeros(shape), np.ones(shape), np.ones(shape)

    def column(name: str, late: float = 0.0) -> Array:
        return np.interp(time - late, recorded, _filled(recorded, values[name]))

    for index, joint in enumerate(leg.joints):
        if not isinstance(joint.drive, Servo):
            continue
        motor = joint.drive.motor
        if joint.drive.open_duty:
            supply[:, index] = joint.sign * column(joint.name + " voltage", 0.0 if motor is None else motor.lag)
        else:
            command[:, index] = _held(*commands[index], time, joint.drive.control_period > 0.0)
            measured = SUPPLY in values and motor is not None
            supply[:, index] = column(SUPPLY) if measured else joint.drive.supply
        if joint.name + " enabled" in values:
            enabled[:, index] = np.clip(column(joint.name + " enabled"), 0.0, 1.0)
    return ServoSignals(time, command, supply, enabled)


# Rad, and ratio to the changes before and after: a larger change of the command between samples is held as a step.
JUMP, SUDDEN = 0.01, 3.0
EDGE = 1e-4  # of the sample interval, duration of such a step


def _samples(time: Array, value: Array) -> tuple[Array, Array]:
    """A command's own samples: an empty cell is none, so a command may have another clock than the angles."""
    known = np.isfinite(value)
    return time[known], value[known]


def _knots(recorded: Array, commands: Sequence[tuple[Array, Array]]) -> Array:
    """(k,) s, break points of the straight lines that represent held commands."""
    middles = [time + 0.5 * _step(time) for time, _ in commands]
    jumps = [(time[_jumps(command)], EDGE * _step(time)) for time, command in commands]
    return np.unique(np.concatenate([recorded, *middles, *(t for t, _ in jumps), *(t - edge for t, edge in jumps)]))


def _step(time: Array) -> float:
    return float(np.median(np.diff(time))) if len(time) > 1 else 0.0


def _held(recorded: Array, command: Array, time: Array, exactly: bool) -> Array:
    """A command held from each of its samples to the next, at ``time`` (k,) s of ``_knots``.

    A staircase of small steps equals its samples' polygon delayed by half a step, apart from a ripple at the
    sampling frequency, which no joint follows (a zero-order hold delays by half its period: Franklin, Powell & Workman,
    *Digital Control of Dynamic Systems*, 3rd ed., section 5.3). A hold weakens a sine by sin(x)/x, x = half a sample's
    phase, its polygon by the square of that: the samples' corners are sharpened by as much. A jump remains a jump: if
    the controller saturates, a ramp with the same centre would act earlier. ``exactly`` : for a servo with control
    steps, which reads its samples.
    """
    half = 0.5 * _step(recorded)
    smooth = np.interp(time, recorded + half, _sharpened(recorded, command))
    last = np.clip(np.searchsorted(recorded, time, side="right") - 1, 0, len(recorded) - 1)
    jumps = _jumps(command)
    near = exactly | jumps[last] | jumps[np.minimum(last + 1, len(recorded) - 1)]
    return np.where(near, command[last], smooth)


def _sharpened(time: Array, command: Array) -> Array:
    """(m,) samples less a 24th of their second difference: 1 + x^2/6 of a sine, for the polygon's (sin(x)/x)^2."""
    bend, step = np.zeros_like(command), np.diff(time)
    slope = np.diff(command) / step
    bend[1:-1] = 2.0 * np.diff(slope) * step[1:] * step[:-1] / (step[1:] + step[:-1])
    jumps = _jumps(command)
    bend[jumps | np.r_[jumps[1:], False]] = 0.0
    return np.asarray(command - bend / 24.0)


def _jumps(command: Array) -> NDArray[np.bool_]:
    """(m,) True at a sample to which the command jumps, as opposed to a coarsely sampled ramp."""
    change = np.abs(np.diff(command, prepend=command[0]))
    before, after = np.r_[0.0, change[:-1]], np.r_[change[1:], 0.0]
    return np.asarray(change > JUMP + SUDDEN * np.maximum(before, after))


def torques(leg: Leg, values: Mapping[str, Array]) -> dict[str, Array]:
    """Torques, N m in the measured sense, of joints whose drive's current was recorded, by name."""
    found = {}
    for joint in leg.joints:
        current = values.get(joint.name + " current")
        if current is not None and isinstance(joint.drive, TorqueDrive):
            found[joint.name] = joint.drive.motor.torque_a_current * current
    return found


def _filled(time: Array, value: Array) -> Array:
    known = np.isfinite(value)
    return np.interp(time, time[known], value[known])
