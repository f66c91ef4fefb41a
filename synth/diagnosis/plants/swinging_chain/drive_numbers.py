"""The number of a drive that a cause makes, beside the one that the leg file states: 0.75 A for 1.5 A stated."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from synth.diagnosis.diagnosis_result import Cause
from synth.diagnosis.sentences import estimate_text
from synth.drives.servo import Servo, TorqueDrive
from synth.estimation.intervals import Estimate
from synth.swing.leg_model import Leg

Drive = Servo | TorqueDrive


@dataclass(frozen=True)
class DriveNumber:
    """A number of the leg file that a parameter of a cause changes; all in SI.

    ``word`` : what it is. ``stated`` : its value in the file, not above 0 or infinite if it states none. ``factor``,
    ``offset`` : it is factor times the parameter, plus offset. ``in_sentence`` : it stands for the parameter there;
    a relative change does without.
    """

    word: str
    unit: str
    stated: float
    factor: float = 1.0
    offset: float = 0.0
    in_sentence: bool = True

    @property
    def is_stated(self) -> bool:
        """Whether the file states it."""
        return 0.0 < self.stated < np.inf

    def of(self, parameter: Estimate) -> Estimate:
        """The number with the cause, with its interval."""
        value, low, high = (
            None if each is None else self.factor * each + self.offset
            for each in (parameter.value, parameter.low, parameter.high)
        )
        assert value is not None
        return Estimate(value, self.unit, low, high)


def _added(word: str, unit: str, stated: float) -> DriveNumber:
    """A number to which the parameter adds."""
    return DriveNumber(word, unit, stated, offset=stated)


def _multiplied(word: str, unit: str, stated: float) -> DriveNumber:
    """A number that the parameter changes relatively."""
    return DriveNumber(word, unit, stated, factor=stated, offset=stated, in_sentence=False)


def _gain(servo: Servo) -> DriveNumber:
    return _multiplied("gain", "N*m/rad" if servo.motor is None else "1/rad", servo.gain)


def _current_limit(servo: Servo) -> DriveNumber | None:
    """In A, but for a servo that states its limit in N m alone."""
    if servo.motor is None or (np.isfinite(servo.torque_limit) and not np.isfinite(servo.current_limit)):
        return DriveNumber("torque", "N*m", servo.torque_limit)
    return DriveNumber("limit", "A", servo.current_limit, factor=1.0 / servo.motor.torque_a_current)


def _source(servo: Servo) -> DriveNumber | None:
    if servo.motor is None:
        return None
    stated = servo.source_resistance
    return DriveNumber("source", "ohm", stated, factor=servo.motor.resistance, offset=stated)


def _constant(drive: Drive) -> DriveNumber | None:
    return None if drive.motor is None else _multiplied("torque constant", "N*m/A", drive.motor.torque_constant)


def _winding(servo: Servo) -> DriveNumber | None:
    return None if servo.motor is None else _multiplied("resistance", "ohm", servo.motor.resistance)


# Effect -> its parameter, and the number of a servo that it changes.
OF_SERVO: dict[str, tuple[str, Callable[[Servo], DriveNumber | None]]] = {
    "command_delay": ("delay", lambda servo: _added("delay", "ms", servo.delay)),
    "dead_band": ("angle", lambda servo: _added("angle", "deg", servo.dead_band)),
    "command_rate_limit": ("rate", lambda servo: DriveNumber("rate", "deg/s", servo.command_rate_limit)),
    "servo_gain": ("share", _gain),
    "current_limit": ("torque", _current_limit),
    "voltage_sag": ("share", _source),
    "torque_constant": ("share", _constant),
    "winding_resistance": ("share", _winding),
}
# The same where a recorded current tells the torque.
OF_CURRENT: dict[str, tuple[str, Callable[[TorqueDrive], DriveNumber | None]]] = {"torque_gain": ("share", _constant)}


def drive_number(cause: Cause, leg: Leg) -> tuple[str, DriveNumber] | None:
    """A cause's parameter and the number of its drive that it changes; None if it changes none."""
    drive = leg.joints[leg.joint_names.index(cause.joint)].drive if cause.joint in leg.joint_names else None
    found: DriveNumber | None = None
    parameter = ""
    if isinstance(drive, Servo) and cause.effect in OF_SERVO:
        parameter, of_servo = OF_SERVO[cause.effect]
        found = of_servo(drive)
    elif isinstance(drive, TorqueDrive) and cause.effect in OF_CURRENT:
        parameter, of_current = OF_CURRENT[cause.effect]
        found = of_current(drive)
    return None if found is None or parameter not in cause.parameters else (parameter, found)


def drive_words(cause: Cause, leg: Leg) -> str:
    """``delay 15 ms for 5 ms stated``; empty where the cause's own parameters say as much."""
    found = drive_number(cause, leg)
    if found is None or not found[1].in_sentence:
        return ""
    parameter, number = found
    told = f"{number.word} {estimate_text(number.of(cause.parameters[parameter]))}"
    return f"{told} for {estimate_text(Estimate(number.stated, number.unit))} stated" if number.is_stated else told


def with_drive_numbers(entry: Mapping[str, Any], cause: Cause, leg: Leg) -> dict[str, Any]:
    """An entry of ``gap.json`` for a cause with ``gives`` and ``stated``, if it changes a number of a drive."""
    found = drive_number(cause, leg)
    if found is None:
        return dict(entry)
    parameter, number = found
    made = {**entry, "gives": {parameter: number.of(cause.parameters[parameter]).as_json()}}
    return {**made, "stated": {parameter: Estimate(number.stated, number.unit).as_json()}} if number.is_stated else made


def all_with_drive_numbers(
    entries: Sequence[Mapping[str, Any]], causes: Sequence[Cause], leg: Leg
) -> list[dict[str, Any]]:
    """Entries of ``gap.json`` for several causes, see ``with_drive_numbers``."""
    return [with_drive_numbers(entry, cause, leg) for entry, cause in zip(entries, causes, strict=True)]
