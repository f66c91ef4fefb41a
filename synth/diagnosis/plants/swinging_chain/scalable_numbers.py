"""Numbers of a leg file, and columns of its trials, that a slip of the unit makes many times too large or too small."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import degrees, isfinite
from typing import Any

from synth.diagnosis.angle_trials import AngleTrial
from synth.drives.servo import Servo
from synth.fit.recordings import Recording
from synth.swing.leg_model import Joint, Leg

A_TURN = degrees(1.0)  # degrees in a radian
# Powers of ten between neighbouring prefixes: milli, centi, deci; a decimal point is seldom farther off.
DECADES = (1e1, 1e-1, 1e2, 1e-2, 1e3, 1e-3)
A_THOUSANDTH = DECADES[-1]  # as written with the prefix milli
PREFIX = "a unit's prefix or a decimal point"
# Of an inertia also kg cm^2, kg mm^2 and g cm^2 for kg m^2.
CLOCKS = (1e3, 1e-3, 1e6, 1e-6)  # of a time in ms or us
SQUARED = {1e4: "cm^2 and m^2", 1e6: "mm^2 and m^2", 1e7: "g*cm^2 and kg*m^2"}
COLUMNS = ("torque", "current", "voltage", "supply")
TIME = "time"  # the column that all joints share


@dataclass(frozen=True)
class _Kind:
    """A number of a joint: its ``words``, its ``unit``, and the sense in which an angle is in it.

    ``angle`` : -1, it is per angle; 1, it is an angle; 0, neither.
    """

    words: str
    unit: str
    angle: int = 0


def _gain_unit(joint: Joint, unit: str) -> str:
    """Of a servo's gain: a duty with a motor, a torque without one."""
    has_motor = joint.drive is not None and joint.drive.motor is not None
    return unit if has_motor else {"1/rad": "N*m/rad", "s/rad": "N*m*s/rad", "1/(rad*s)": "N*m/(rad*s)"}.get(unit, unit)


# Attribute of a joint -> what it is.
KINDS: Mapping[str, _Kind] = {
    "spring.rate": _Kind("spring rate", "N*m/rad", -1),
    "damper.rate": _Kind("damper rate", "N*m*s/rad", -1),
    "damper.curve.torque": _Kind("damper's torques", "N*m"),
    "link.mass": _Kind("link mass", "kg"),
    "link.com": _Kind("distance of the centre of mass", "mm"),
    "link.com_across": _Kind("distance of the centre of mass from the link's line", "mm"),
    "link.length": _Kind("link length", "mm"),
    "link.inertia": _Kind("link inertia", "kg*m^2"),
    "armature": _Kind("armature", "kg*m^2"),
    "drive.gain": _Kind("servo gain", "1/rad", -1),
    "drive.damping_gain": _Kind("damping gain", "s/rad", -1),
    "drive.integral_gain": _Kind("integral gain", "1/(rad*s)", -1),
    "drive.delay": _Kind("delay", "ms"),
    "drive.dead_band": _Kind("dead band", "deg", 1),
    "drive.command_rate_limit": _Kind("rate limit of the command", "deg/s", 1),
    "drive.torque_limit": _Kind("torque limit", "N*m"),
    "drive.current_limit": _Kind("current limit", "A"),
    "drive.motor.resistance": _Kind("winding resistance", "ohm"),
    "drive.motor.torque_constant": _Kind("torque constant", "N*m/A"),
    "drive.motor.gear_ratio": _Kind("gear ratio", "1"),
    "drive.motor.rotor_inertia": _Kind("rotor inertia", "kg*m^2"),
}
DAMPERS = frozenset({"damper.rate", "damper.curve.torque"})
# Numbers that are written in one unit, one below the other: the same slip as a rule makes all of them wrong.
WRITTEN_TOGETHER = (
    ("drive.gain", "drive.damping_gain", "drive.integral_gain"),
    ("spring.rate", "damper.rate"),
    ("link.mass", "link.inertia"),
    ("link.length", "link.com", "link.com_across"),
)


@dataclass(frozen=True)
class ScalableNumbers:
    """Numbers that one slip makes wrong: attributes ``paths``, or the column ``column``, of the joints ``joints``."""

    joints: tuple[int, ...]
    paths: tuple[str, ...] = ()
    column: str = ""

    def of_leg(self, leg: Leg, factor: float) -> Leg:
        """The leg with the numbers ``factor`` times as large."""
        if not self.paths:
            return leg
        made = list(leg.joints)
        for j in self.joints:
            for path in self.paths:
                if _value(made[j], path):
                    made[j] = _scaled(made[j], path.split("."), factor)
        return replace(leg, joints=tuple(made))

    def of_trial(self, trial: AngleTrial, factor: float) -> AngleTrial:
        """The trial with the columns ``factor`` times as large."""
        if self.column == TIME:
            return _with_time(trial, factor)
        recording, chosen = trial.recording, list(self.joints)
        known, signals = recording.known_torque, recording.signals
        if self.column in ("torque", "current") and known is not None:
            torque = known[1].copy()
            torque[:, chosen] *= factor
            recording = replace(recording, known_torque=(known[0], torque))
        if self.column in ("voltage", "supply") and signals is not None:
            supply = signals.supply.copy()
            supply[:, chosen] *= factor
            recording = replace(recording, signals=replace(signals, supply=supply))
        return replace(trial, recording=recording)

    @property
    def factors(self) -> tuple[float, ...]:
        """The factors by which slips of the unit make such numbers wrong."""
        angles = (A_TURN, 1.0 / A_TURN) if any(KINDS[path].angle for path in self.paths) else ()
        if self.column == TIME:
            return CLOCKS
        squared = tuple(f for each in SQUARED for f in (each, 1.0 / each)) if self.paths == ("link.inertia",) else ()
        return (*angles, *DECADES, *squared)

    @property
    def only_damping(self) -> bool:
        """Whether nothing but dampers is changed."""
        return bool(self.paths) and DAMPERS.issuperset(self.paths)

    def words(self, leg: Leg) -> str:
        """``servo gain and damping gain of arm``."""
        if self.column == TIME:
            return "time columns"
        names, many = _listed([leg.joint_names[j] for j in self.joints]), "s" if len(self.joints) > 1 else ""
        if self.column:
            return f"supply voltage of {names}" if self.column == "supply" else f"{self.column} column{many} of {names}"
        stated = [path for path in self.paths if any(_value(leg.joints[j], path) for j in self.joints)]
        return f"{_listed([KINDS[path].words for path in stated])} of {names}"

    @property
    def given(self) -> str:
        """Whether the leg file or the recordings give it; both may give a supply."""
        return "recorded" if self.column not in ("", "supply") else "stated"

    def value(self, leg: Leg) -> tuple[float, str] | None:
        """The stated number in SI and its unit, if it is a single one."""
        if len(self.joints) != 1 or len(self.paths) != 1:
            return None
        joint, path = leg.joints[self.joints[0]], self.paths[0]
        value = _value(joint, path)
        return (value, _gain_unit(joint, KINDS[path].unit)) if isinstance(value, float) else None

    def slip(self, factor: float) -> str:
        """What was mistaken if ``factor`` times the stated numbers are the true ones."""
        if factor in (A_TURN, 1.0 / A_TURN):
            senses = {KINDS[path].angle for path in self.paths} - {0}
            meant, written = ("radian", "degree") if factor > 1.0 else ("degree", "radian")
            if senses == {1}:
                return f"{meant}s written as {written}s"
            return f"a value per {written} written as per {meant}"
        if self.paths == ("drive.delay",) and factor == A_THOUSANDTH:
            return "milliseconds written as seconds"
        if self.column == TIME:
            return "another unit of the clock"
        squared = next((words for each, words in SQUARED.items() if factor in (each, 1.0 / each)), "")
        return f"{squared} exchanged" if squared else PREFIX


def scalable_numbers(leg: Leg, trials: Sequence[AngleTrial]) -> list[ScalableNumbers]:
    """All numbers and columns that may be wrong by a slip: each alone, of all joints, and those written together."""
    sets = [(path,) for path in KINDS] + list(WRITTEN_TOGETHER)
    found: list[ScalableNumbers] = []
    for paths in sets:
        have = [j for j, joint in enumerate(leg.joints) if all(_value(joint, path) for path in _needed(paths))]
        if paths in (("link.length",), ("link.length", "link.com", "link.com_across")):
            have = have[:-1]  # the last link's length moves nothing
        found += [ScalableNumbers((j,), paths) for j in have]
        found += [ScalableNumbers(tuple(have), paths)] if len(have) > 1 else []
    for column, joints in _columns(leg, trials).items():
        found += [ScalableNumbers((j,), column=column) for j in joints]
        found += [ScalableNumbers(tuple(joints), column=column)] if len(joints) > 1 else []
    return [*found, ScalableNumbers(tuple(range(len(leg.joints))), column=TIME)]


def _needed(paths: tuple[str, ...]) -> tuple[str, ...]:
    """Those of numbers written together without which they are no more than one alone."""
    return paths[:2]


def _columns(leg: Leg, trials: Sequence[AngleTrial]) -> dict[str, list[int]]:
    """Column -> the joints that it drives in some trial."""
    found: dict[str, list[int]] = {}
    for j, joint in enumerate(leg.joints):
        for name in COLUMNS:
            if any(_drives(name, joint, j, trial.recording) for trial in trials):
                found.setdefault(name, []).append(j)
    return found


def _drives(column: str, joint: Joint, j: int, recording: Recording) -> bool:
    known, signals, servo = recording.known_torque, recording.signals, joint.drive
    if column in ("torque", "current"):
        return known is not None and bool(known[1][:, j].any()) and (j in recording.by_current) == (column == "current")
    if signals is None or not isinstance(servo, Servo) or servo.motor is None or not signals.enabled[:, j].any():
        return False
    return bool(servo.open_duty) == (column == "voltage")


def _with_time(trial: AngleTrial, factor: float) -> AngleTrial:
    """With the times of readings and inputs that many times as large, rates as much smaller."""
    recording, old = trial.recording, trial.recording.smoothed
    smoothed = replace(
        old, time=old.time * factor, rate=old.rate / factor, width=old.width * factor, pace=old.pace * factor
    )
    known, signals = recording.known_torque, recording.signals
    recording = replace(
        recording,
        time=recording.time * factor,
        smoothed=smoothed,
        known_torque=None if known is None else (known[0] * factor, known[1]),
        signals=None if signals is None else replace(signals, time=signals.time * factor),
    )
    return replace(trial, recording=recording, time=trial.time * factor)


def _value(joint: Joint, path: str) -> Any:
    """The number, or the tuple of numbers; None or 0 where the joint states none."""
    found: Any = joint
    for name in path.split("."):
        found = getattr(found, name, None)
    return None if isinstance(found, float) and not isfinite(found) else found


def _scaled(owner: Any, names: Sequence[str], factor: float) -> Any:
    """A copy of a dataclass with the number at the end of ``names`` that many times as large."""
    if not names:
        return tuple(each * factor for each in owner) if isinstance(owner, tuple) else owner * factor
    return replace(owner, **{names[0]: _scaled(getattr(owner, names[0]), names[1:], factor)})


def _listed(words: Sequence[str]) -> str:
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)
