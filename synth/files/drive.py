"""The key ``drive:`` of a joint in the leg file: conversion to and from ``synth.drives.servo``."""

from __future__ import annotations

from contextlib import suppress
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, model_validator

from synth import units
from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo, TorqueDrive
from synth.errors import UserError
from synth.files.schema import Written
from synth.files.validate import FileModel, Quantity, refusal

Drive = Servo | TorqueDrive
# s, of a winding: within 0.1 deg of its current, 0.2 deg with a damping gain (tests/drives/test_inductance.py)
LONGEST_LAG = 2e-3
LIMITS = {"torque_limit": "N*m", "current_limit": "A", "duty_limit": "1"}  # that ``limit`` may be, by its unit


class MotorKeys(FileModel):
    """A direct-current motor, rotor side, behind its gear."""

    torque_constant: Annotated[float, Quantity("N*m/A", above=0)]
    resistance: Annotated[float, Quantity("ohm", above=0)] | None = None
    gear_ratio: Annotated[float, Quantity("1", above=0)] = 1.0
    efficiency: Annotated[float, Quantity("1", above=0, most=1)] = 1.0
    rotor_inertia: Annotated[float, Quantity("kg*m^2", least=0)] = 0.0
    inductance: Annotated[float, Quantity("H", least=0)] = 0.0

    @model_validator(mode="after")
    def _quick(self) -> MotorKeys:
        if self.inductance > 0.0 and self.resistance is not None and self.inductance > LONGEST_LAG * self.resistance:
            lag = 1e3 * self.inductance / self.resistance
            text = f"inductance over resistance is {lag:.3g} ms; windings are simulated up to {1e3 * LONGEST_LAG:g} ms"
            raise refusal(f"{text}. Is it in H? A small motor has some 0.1 mH to 2 mH")
        return self


class DriveKeys(FileModel):
    """A joint's drive: a position servo, a motor with known voltage or known current, or a known torque.

    ``gain``, ``damping_gain`` and ``integral_gain`` are duty per angle, per speed and per angle and time with a
    ``motor`` (1/rad, s/rad, 1/(rad s)), otherwise torques (N m/rad, N m s/rad, N m/(rad s)); ``integral_limit`` is a
    duty or a torque. ``limit`` is one of the three limits, by its unit.
    """

    kind: Literal["servo", "voltage", "torque"]
    gain: Annotated[Any, Field(examples=["20 N*m/rad"]), Written("quantity")] = None
    damping_gain: Annotated[Any, Field(examples=["0.5 N*m*s/rad"]), Written("quantity")] = None
    integral_gain: Annotated[Any, Field(examples=["30 N*m/(rad*s)"]), Written("quantity")] = None
    integral_limit: Annotated[Any, Field(examples=["0.8 N*m"]), Written("quantity")] = None
    delay: Annotated[float, Quantity("s", least=0, most=2)] = 0.0
    dead_band: Annotated[float, Quantity("rad", least=0, most=1)] = 0.0
    limit: Annotated[Any, Field(examples=["2.5 N*m"]), Written("quantity")] = None
    duty_limit: Annotated[float, Quantity("1", above=0, most=1)] | None = None
    torque_limit: Annotated[float, Quantity("N*m", above=0)] | None = None
    current_limit: Annotated[float, Quantity("A", above=0)] | None = None
    supply: Annotated[float, Quantity("V", above=0)] | None = None
    source_resistance: Annotated[float, Quantity("ohm", least=0)] = 0.0
    command_rate_limit: Annotated[float, Quantity("rad/s", least=0)] = 0.0
    control_period: Annotated[float, Quantity("s", above=0, most=0.1)] | None = None
    duty_steps: Annotated[int, Field(ge=1)] | None = None
    commands: Literal["held", "linear"] | None = None
    motor: MotorKeys | None = None

    @model_validator(mode="before")
    @classmethod
    def _which_limit(cls, given: Any) -> Any:
        """``limit`` as the key of its unit."""
        if not isinstance(given, dict) or given.get("limit") is None:
            return given
        written = given["limit"]
        for key, unit in LIMITS.items():
            with suppress(UserError):
                units.parse(written, unit)
                if given.get(key) is not None:
                    raise refusal(f'"limit" and "{key}" are the same: keep one')
                return {**given, "limit": None, key: written}
        raise refusal(
            f'"limit" is {written}: write a torque (2.5 N*m), a current (1.5 A) or a share of the duty (85 %)'
        )

    @model_validator(mode="after")
    def _complete(self) -> DriveKeys:
        given = {name for name in type(self).model_fields if getattr(self, name) not in (None, 0.0)} - {"kind"}
        foreign = (
            given
            - {
                "servo": given if self.motor else set(WITHOUT_MOTOR),
                "voltage": {"motor", "source_resistance", "torque_limit", "current_limit"},
                "torque": {"motor"},
            }[self.kind]
        )
        if foreign:
            key, bare = sorted(foreign)[0], " without a motor" if self.kind == "servo" else ""
            instead = "write torque_limit, in N*m" if bare and key in LIMITS else "leave it out"
            raise refusal(f'"{key}" does not apply to a drive of kind {self.kind}{bare}; {instead}')
        if self.kind == "voltage" and self.motor is None:
            raise refusal('"motor" is missing: write motor: {torque_constant: 0.02 N*m/A, resistance: 2 ohm}')
        if self.kind == "servo" and self.gain is None:
            raise refusal(f'"gain" is missing: write it, for example gain: {"2 1/rad" if self.motor else "20 N*m/rad"}')
        if self.integral_limit is not None and self.integral_gain is None:
            unit = GAIN_UNITS[self.motor is not None]["integral_gain"]
            raise refusal(f'"integral_limit" needs "integral_gain": write it, for example integral_gain: 6 {unit}')
        if self.duty_steps is not None and self.control_period is None:
            raise refusal('"duty_steps" needs the time between two duties: write it, for example control_period: 1 ms')
        if self.command_rate_limit and self.commands == "linear":
            raise refusal('"command_rate_limit" needs held commands; leave out "commands: linear"')
        if self.kind != "torque" and self.motor is not None and self.motor.resistance is None:
            raise refusal('"resistance" of the motor is missing: write it, for example resistance: 2 ohm')
        if self.kind == "servo" and self.motor is not None and self.supply is None:
            text = '"supply" is missing: write it, for example supply: 12 V'
            raise refusal(text + "; recordings with a column supply [V] use theirs")
        return self

    def drive(self) -> Drive:
        """The drive described by these keys.

        Raises
        ------
        UserError : a gain in another unit.
        """
        motor = None
        if self.motor is not None:
            keys = self.motor
            resistance = np.inf if keys.resistance is None else keys.resistance
            gear = keys.gear_ratio, keys.efficiency
            motor = GearedMotor(resistance, keys.torque_constant, *gear, keys.rotor_inertia, keys.inductance)
        if self.kind == "torque":
            return TorqueDrive(motor)
        gain, damping, integral, limit = (
            None if given is None else _gain(key, given, unit)
            for (key, unit), given in zip(
                GAIN_UNITS[motor is not None].items(),
                (self.gain, self.damping_gain, self.integral_gain, self.integral_limit),
                strict=True,
            )
        )
        return Servo(
            gain=gain or 0.0,
            damping_gain=damping or 0.0,
            integral_gain=integral or 0.0,
            integral_limit=np.inf if limit is None else limit,
            delay=self.delay,
            dead_band=self.dead_band,
            duty_limit=1.0 if self.duty_limit is None else self.duty_limit,
            torque_limit=np.inf if self.torque_limit is None else self.torque_limit,
            current_limit=np.inf if self.current_limit is None else self.current_limit,
            supply=1.0 if self.supply is None else self.supply,
            source_resistance=self.source_resistance,
            motor=motor,
            open_duty=1.0 if self.kind == "voltage" else 0.0,
            control_period=self.control_period or 0.0,
            duty_steps=float(self.duty_steps or 0),
            linear_commands=self.commands == "linear",
            command_rate_limit=self.command_rate_limit,
        )


WITHOUT_MOTOR = ("gain", "damping_gain", "delay", "dead_band", "torque_limit", "control_period", "commands",
                 "command_rate_limit", "integral_gain", "integral_limit")  # fmt: skip
GAIN_UNITS = {
    True: {"gain": "1/rad", "damping_gain": "s/rad", "integral_gain": "1/(rad*s)", "integral_limit": "1"},
    False: {
        "gain": "N*m/rad", "damping_gain": "N*m*s/rad", "integral_gain": "N*m/(rad*s)", "integral_limit": "N*m",
    },
}  # with a motor, without  # fmt: skip


def _gain(key: str, value: object, unit: str) -> float:
    try:
        found = units.parse(value, unit)
    except UserError as error:
        hint = (
            "with a motor a gain is a duty"
            if unit in GAIN_UNITS[True].values()
            else "without a motor a gain is a torque"
        )
        raise UserError(f"{key}: {error.problems[0].text} ({hint})") from None
    if found < 0.0:
        raise UserError(f"{key}: {value} is not allowed: it must be at least 0")
    return found


def drive_text(drive: Drive) -> dict[str, Any]:
    """The mapping from which this drive can be read again."""
    motor = drive.motor
    made: dict[str, Any] = {"kind": "torque"}
    if isinstance(drive, Servo):
        of_gain = GAIN_UNITS[motor is not None]
        made = {"kind": "voltage" if drive.open_duty else "servo"}
        numbers = {
            "gain": (drive.gain, 0.0, of_gain["gain"]),
            "damping_gain": (drive.damping_gain, 0.0, of_gain["damping_gain"]),
            "integral_gain": (drive.integral_gain, 0.0, of_gain["integral_gain"]),
            "integral_limit": (drive.integral_limit, np.inf, of_gain["integral_limit"]),
            "delay": (drive.delay, 0.0, "s"), "dead_band": (drive.dead_band, 0.0, "deg"),
            "duty_limit": (drive.duty_limit, 1.0, ""), "torque_limit": (drive.torque_limit, np.inf, "N*m"),
            "current_limit": (drive.current_limit, np.inf, "A"), "supply": (drive.supply, 1.0, "V"),
            "source_resistance": (drive.source_resistance, 0.0, "ohm"),
            "control_period": (drive.control_period, 0.0, "s"),
            "command_rate_limit": (drive.command_rate_limit, 0.0, "deg/s"),
        }  # fmt: skip
        bare = {"supply"} if motor is None or drive.open_duty else set()
        made |= {
            key: units.write(value, unit) if unit else float(value)
            for key, (value, absent, unit) in numbers.items()
            if key not in bare and (value != absent or (key == "supply") or (key == "gain" and not drive.open_duty))
        }
        made |= {"duty_steps": round(drive.duty_steps)} if drive.duty_steps else {}
        made |= {"commands": "linear"} if drive.linear_commands else {}
    if motor is not None:
        made["motor"] = {"torque_constant": units.write(motor.torque_constant, "N*m/A")}
        if np.isfinite(motor.resistance):
            made["motor"]["resistance"] = units.write(motor.resistance, "ohm")
        made["motor"] |= {"gear_ratio": float(motor.gear_ratio), "efficiency": float(motor.efficiency)}
        made["motor"] |= {"rotor_inertia": units.write(motor.rotor_inertia, "kg*m^2")}
        if motor.inductance:
            made["motor"]["inductance"] = units.write(motor.inductance, "H")
    return made
