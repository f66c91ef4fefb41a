"""The inputs of a trial's servos as they were recorded, read apart from the diagnosis for the generator's engine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from synth.arrays import Array
from synth.drives.servo import INTEGRAL_GAIN, INTEGRAL_LIMIT, Servo
from synth.files.csv_table import in_si, read_table
from synth.files.drive_columns import SUPPLY, column_units, switched_off
from synth.files.trial_list import Trial
from synth.planting.model import PlantedServo, ServoInputs
from synth.swing.leg_model import Leg

LAW_NUMBERS = 10  # numbers of ``Servo.numbers`` that the generator's servo has: those before its control steps


@dataclass(frozen=True)
class DriveInputs:
    """Columns of a trial's servos by name, (k,) SI at ``time`` (k,) s from its first sample; nan where empty."""

    time: Array
    columns: Mapping[str, Array]

    def planted(self, leg: Leg) -> ServoInputs:
        """For the generator's engine."""
        shape = len(self.time), len(leg.joints)
        command, supply, enabled = np.zeros(shape), np.ones(shape), np.ones(shape)
        measured = np.zeros(shape)
        for j, joint in enumerate(leg.joints):
            drive = joint.drive
            if not isinstance(drive, Servo):
                continue
            if drive.open_duty:
                lag = 0.0 if drive.motor is None else drive.motor.lag
                supply[:, j] = joint.sign * self._interpolated(joint.name + " voltage", lag)
            else:
                column = joint.name + " command"
                measured[:, j] = self._interpolated(column) if drive.linear_commands else self._held_values(column)
                told = SUPPLY in self.columns and drive.motor is not None
                supply[:, j] = self._interpolated(SUPPLY) if told else drive.supply
            if joint.name + " enabled" in self.columns:
                enabled[:, j] = np.clip(self._interpolated(joint.name + " enabled"), 0.0, 1.0)
        command = leg.to_rotation(measured)
        return ServoInputs(self.time, command, supply, enabled)

    def _interpolated(self, name: str, late: float = 0.0) -> Array:
        """Linear between the known values."""
        values = self.columns[name]
        known = np.isfinite(values)
        return np.interp(self.time - late, self.time[known], values[known])

    def _held_values(self, name: str) -> Array:
        """Each known value until the next; the first before it."""
        values = self.columns[name]
        known = np.flatnonzero(np.isfinite(values))
        return np.asarray(values[known[np.maximum(np.searchsorted(known, np.arange(len(values)), "right") - 1, 0)]])


def drive_inputs(folder: Path, trial: Trial, leg: Leg, start: float) -> DriveInputs:
    """From the trial's file in the project's ``folder``; ``start`` s of the file's time becomes zero."""
    table = read_table(folder / trial.name, trial.name)
    values, _ = in_si(table, {"time": "s", **column_units(leg)}, "")
    time = values.pop("time") - start
    off = _drives_off(trial, leg)
    if off:  # the entry says so, and the file may have no column of theirs
        angles = dict(zip(leg.joint_names, trial.angles.T, strict=True))
        told = switched_off(leg, values | angles, off)
        values = {name: column for name, column in told.items() if name not in angles}
    return DriveInputs(time, values)


def _drives_off(trial: Trial, leg: Leg) -> list[str]:
    """Joints whose servo is off throughout."""
    signals = trial.signals
    return [] if signals is None else [n for j, n in enumerate(leg.joint_names) if not signals.enabled[:, j].any()]


def planted_servos(leg: Leg) -> tuple[PlantedServo, ...]:
    """The leg's servos for the generator's engine."""
    drives = ((j, joint.drive) for j, joint in enumerate(leg.joints))
    return tuple(_planted(j, drive) for j, drive in drives if isinstance(drive, Servo))


def _planted(joint: int, drive: Servo) -> PlantedServo:
    numbers = drive.numbers
    period, first_look, duty_steps = numbers[LAW_NUMBERS : LAW_NUMBERS + 3]
    integral_gain, integral_limit = numbers[INTEGRAL_GAIN], numbers[INTEGRAL_LIMIT]
    return PlantedServo(joint, *numbers[:LAW_NUMBERS])._replace(
        integral_gain=integral_gain,
        integral_limit=integral_limit,
        command_rate=drive.command_rate_limit,
        control_period=period,
        first_look=first_look,
        duty_steps=duty_steps,
        linear=float(drive.linear_commands),
    )
