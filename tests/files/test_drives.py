"""``drive:`` in the leg file and the columns of driven trials."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from synth.diagnosis.plants.swinging_chain.trial_checks import check_trials
from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo, TorqueDrive
from synth.errors import UserError
from synth.files.leg_file import read_leg, write_leg
from synth.files.made_in_code import in_code
from synth.files.recording import read_recording
from synth.files.trial_in_code import checked_trials
from synth.files.trial_list import read_trials
from synth.rehearsal.servo_columns import drive_inputs

LEG = """kind: leg
name: arm
joints:
  - name: arm
    zero: 10 deg
    sign: -1
    link: {{length: 0.1 m, mass: 0.5 kg, com: 0.05 m, inertia: 1e-3 kg*m^2}}
    drive: {drive}
"""
MOTOR = "motor: {resistance: 3.5 ohm, torque_constant: 2 mN*m/A, gear_ratio: 200, efficiency: 80 %}"
SERVO = "{kind: servo, gain: 2 1/rad, damping_gain: 0.01 s/rad, delay: 5 ms, dead_band: 1 deg, duty_limit: 90 %, "
SERVO += "current_limit: 1.5 A, supply: 12 V, source_resistance: 0.2 ohm, " + MOTOR + "}"


def leg_file(folder: Path, drive: str) -> Path:
    path = folder / "arm.leg.yaml"
    path.write_text(LEG.format(drive=drive), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("drive", "wanted"),
    [
        (
            SERVO,
            Servo(2.0, 0.01, 0.005, np.radians(1.0), 0.9, np.inf, 1.5, 12.0, 0.2, GearedMotor(3.5, 2e-3, 200.0, 0.8)),
        ),
        (
            "{kind: servo, gain: 20 N*m/rad, damping_gain: 0.5 N*m*s/rad, torque_limit: 3 N*m}",
            Servo(20.0, 0.5, torque_limit=3.0),
        ),
        (
            "{kind: servo, gain: 20 N*m/rad, integral_gain: 30 N*m/(rad*s), integral_limit: 0.8 N*m}",
            Servo(20.0, integral_gain=30.0, integral_limit=0.8),
        ),
        (
            "{kind: servo, gain: 2 1/rad, integral_gain: 6 1/(rad*s), integral_limit: 30 %, supply: 12 V, "
            + MOTOR
            + "}",
            Servo(2.0, supply=12.0, motor=GearedMotor(3.5, 2e-3, 200.0, 0.8), integral_gain=6.0, integral_limit=0.3),
        ),
        (
            "{kind: servo, gain: 20 N*m/rad, command_rate_limit: 180 deg/s}",
            Servo(20.0, command_rate_limit=np.pi),
        ),
        (
            "{kind: servo, gain: 2 1/rad, supply: 12 V, control_period: 8 ms, duty_steps: 885, " + MOTOR + "}",
            Servo(2.0, supply=12.0, motor=GearedMotor(3.5, 2e-3, 200.0, 0.8), control_period=8e-3, duty_steps=885.0),
        ),
        ("{kind: voltage, " + MOTOR + "}", Servo(0.0, motor=GearedMotor(3.5, 2e-3, 200.0, 0.8), open_duty=1.0)),
        (
            "{kind: torque, motor: {torque_constant: 0.1 N*m/A, gear_ratio: 6}}",
            TorqueDrive(GearedMotor(np.inf, 0.1, 6.0)),
        ),
    ],
)
def test_a_drive_is_read_and_written(tmp_path: Path, drive: str, wanted: Servo | TorqueDrive) -> None:
    leg = read_leg(leg_file(tmp_path, drive))
    found = leg.joints[0].drive
    assert found is not None
    assert type(found) is type(wanted)
    if isinstance(found, Servo) and isinstance(wanted, Servo):
        assert found.numbers == pytest.approx(wanted.numbers)
    else:
        assert found == wanted
    write_leg(leg, tmp_path / "again.leg.yaml")
    again = read_leg(tmp_path / "again.leg.yaml").joints[0].drive
    assert again == found


def test_a_torque_known_as_such_needs_no_motor(tmp_path: Path) -> None:
    """FORMATS.md shows ``drive: {kind: torque}``; a motor's constant was asked for. It stays what drives the joint."""
    leg = read_leg(leg_file(tmp_path, "{kind: torque}"))
    assert leg.joints[0].drive == TorqueDrive()
    write_leg(leg, tmp_path / "again.leg.yaml")
    assert read_leg(tmp_path / "again.leg.yaml").joints[0].drive == TorqueDrive()


@pytest.mark.parametrize(
    ("limit", "key"), [("3 N*m", "torque_limit"), ("1.5 A", "current_limit"), ("85 %", "duty_limit")]
)
def test_a_limit_is_that_of_its_unit(tmp_path: Path, limit: str, key: str) -> None:
    """The key ``limit`` of FORMATS.md."""
    servo = "{kind: servo, gain: 2 1/rad, supply: 12 V, " + MOTOR + ", "
    one, other = (read_leg(leg_file(tmp_path, f"{servo}{name}: {limit}}}")).joints[0].drive for name in ("limit", key))
    assert isinstance(one, Servo)
    assert one == other
    assert getattr(one, key) == pytest.approx(float(limit.split()[0]) * (0.01 if "%" in limit else 1.0))


@pytest.mark.parametrize(
    ("former", "name"),
    [
        ("motor_constant: {share: 0.1}", "torque_constant"), ("servo_dead_band: {angle: 1 deg}", "dead_band"),
        ("source_resistance: {share: 0.1}", "voltage_sag"), ("drive_torque_limit: {torque: 1 N*m}", "current_limit"),
        ("gear_load_friction: {share: 0.1}", "gear_friction"),
    ],
)  # fmt: skip
def test_effects_of_drives_are_read_by_their_former_names(tmp_path: Path, former: str, name: str) -> None:
    path = leg_file(tmp_path, SERVO)
    path.write_text(path.read_text().rstrip() + f"\n    effects: [{{{former}}}]\n")
    leg = read_leg(path)
    assert list(leg.joints[0].effects) == [name]
    write_leg(leg, tmp_path / "again.leg.yaml")
    assert f"- {name}:" in (tmp_path / "again.leg.yaml").read_text()


@pytest.mark.parametrize(
    ("drive", "words"),
    [
        ("{kind: servo}", '"gain" is missing'),
        ("{kind: servo, gain: 20 N*m/rad, duty_limit: 0.8}", "write torque_limit, in N"),
        ("{kind: servo, gain: 20 N*m/rad, limit: 3 A}", "write torque_limit, in N"),
        ("{kind: servo, gain: 20 N*m/rad, limit: 3 kg}", "write a torque"),
        ("{kind: servo, gain: 20 N*m/rad, limit: 3 N*m, torque_limit: 3 N*m}", "keep one"),
        ("{kind: servo, gain: 20 N*m/rad, supply: 12 V}", '"supply" does not apply'),
        ("{kind: servo, gain: 20 N*m/rad, " + MOTOR + ", supply: 12 V}", "with a motor a gain is a duty"),
        ("{kind: servo, gain: 2 1/rad}", "without a motor a gain is a torque"),
        ("{kind: servo, gain: -2 N*m/rad}", "at least 0"),
        ("{kind: servo, gain: 2 1/rad, " + MOTOR + "}", r"with a column supply \[V\] use theirs"),
        ("{kind: voltage}", '"motor" is missing'),
        ("{kind: voltage, motor: {torque_constant: 1 N*m/A}}", '"resistance" of the motor is missing'),
        ("{kind: torque, delay: 5 ms, motor: {torque_constant: 1 N*m/A}}", '"delay" does not apply'),
        ("{kind: servo, gain: 2 1/rad, duty_steps: 885, supply: 12 V, " + MOTOR + "}", '"duty_steps" needs the time'),
        ("{kind: servo, gain: 2 N*m/rad, control_period: 1 ms, duty_steps: 885}", '"duty_steps" does not apply'),
        ("{kind: servo, gain: 2 N*m/rad, command_rate_limit: 2 rad/s, commands: linear}", "needs held commands"),
        ("{kind: voltage, control_period: 1 ms, " + MOTOR + "}", '"control_period" does not apply'),
        ("{kind: hydraulic}", "hydraulic"),
    ],
)
def test_mistakes_of_a_drive(tmp_path: Path, drive: str, words: str) -> None:
    with pytest.raises(UserError, match=words) as caught:
        read_leg(leg_file(tmp_path, drive))
    assert all(problem.line == 8 for problem in caught.value.problems)


def trial(folder: Path, header: str, row: str) -> Path:
    path = folder / "trial.csv"
    rows = [row.format(t=0.01 * k, k=k) for k in range(20)]
    path.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
    return path


def test_columns_of_a_servo(tmp_path: Path) -> None:
    """An empty cell lies on the line between its neighbours; commands are held, and keep the measured angles' sense."""
    leg = read_leg(leg_file(tmp_path, SERVO))
    path = trial(tmp_path, "time [s],arm [deg],arm command [deg],supply [V],arm enabled [1]", "{t},{k},{k},11.{k},1")
    lines = path.read_text(encoding="utf-8").splitlines()
    lines[3] = "0.02,2,,,1"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    signals = read_recording(path, leg).signals
    assert signals is not None
    assert signals.held == (0,)
    np.testing.assert_allclose(signals.command[:, 0], np.radians([0, 1, 1, *range(3, 20)]), atol=1e-12)
    assert signals.supply[2, 0] == pytest.approx(0.5 * (11.1 + 11.3))
    assert signals.enabled.min() == 1.0


def test_current_is_a_known_torque(tmp_path: Path) -> None:
    leg = read_leg(leg_file(tmp_path, "{kind: torque, motor: {torque_constant: 0.1 N*m/A, gear_ratio: 6}}"))
    recorded = read_recording(trial(tmp_path, "time [s],arm [deg],arm current [A]", "{t},{k},2"), leg)
    assert recorded.by_current == ("arm",)
    assert recorded.torques is not None
    np.testing.assert_allclose(recorded.torques, 1.2)


def test_a_torque_drive_without_its_current_is_told(tmp_path: Path) -> None:
    """It counts as free, as ever, and nothing said so."""
    leg = read_leg(leg_file(tmp_path, "{kind: torque, motor: {torque_constant: 0.1 N*m/A, gear_ratio: 6}}"))
    motion = "time [s],arm [deg]", "{t},{k}"
    path = trial(tmp_path, *motion)
    (free,) = read_trials([path.name], tmp_path, leg)
    assert free.torques is None
    (told,) = (text for text in check_trials(leg, [free]) if "no current of its drive" in text)
    assert told.startswith(
        f"arm: no current of its drive in {path.name}: free there. If it was off, write drive_off: ["
    )
    (off,) = read_trials([{"file": path.name, "drive_off": ["arm"]}], tmp_path, leg)
    assert off.drive_off == ("arm",)
    assert not any("no current" in text for text in check_trials(leg, [off]))
    path = trial(tmp_path, "time [s],arm [deg],arm torque [N*m]", "{t},{k},2")  # the drive's torque, already computed
    assert not any("no current" in text for text in check_trials(leg, read_trials([path.name], tmp_path, leg)))


@pytest.mark.parametrize(
    ("header", "words"),
    [
        ("time [s],arm [deg]", 'column "arm command \\[deg\\]" is missing'),
        ("time [s],arm [deg],arm command [deg],arm current [A]", "has no drive that takes it"),
        ("time [s],arm [deg],arm command [deg],arm current [A]", r"as drive: {kind: torque, motor: {torque_constant"),
        ("time [s],arm [deg],arm command [V]", "command"),
        # as ROS names a torque: the nearest by its letters was "arm enabled"
        ("time [s],arm [deg],arm command [deg],arm effort [N*m]", "arm effort .* did you mean arm torque"),
    ],
)
def test_mistakes_of_driven_columns(tmp_path: Path, header: str, words: str) -> None:
    leg = read_leg(leg_file(tmp_path, SERVO))
    row = ",".join(["{t}", *["{k}"] * header.count(",")])
    with pytest.raises(UserError, match=words):
        read_recording(trial(tmp_path, header, row), leg)


@pytest.mark.parametrize(("command", "refused"), [("395", False), ("2048", True), ("-2048", True)])
def test_a_command_beyond_any_joint_is_refused(tmp_path: Path, command: str, refused: bool) -> None:
    """Counts taken for degrees: an ideal servo had an error of 1900 deg, explained by a spring that is not there."""
    leg = read_leg(leg_file(tmp_path, "{kind: servo, gain: 20 N*m/rad}"))
    path = trial(tmp_path, "time [s],arm [deg],arm command [deg]", "{t},{k}," + command)
    if not refused:
        (made,) = read_trials([path.name], tmp_path, leg)
        assert made.signals is not None
        assert np.degrees(made.signals.command).max() == pytest.approx(395.0)
        return
    with pytest.raises(
        UserError, match=rf"arm command \[deg\]: {command} deg is beyond any joint's travel.*counts: 4096"
    ):
        read_recording(path, leg)


def test_a_command_made_in_code_that_is_beyond_any_joint_is_refused(tmp_path: Path) -> None:
    leg = read_leg(leg_file(tmp_path, "{kind: servo, gain: 20 N*m/rad}"))
    path = trial(tmp_path, "time [s],arm [deg],arm command [deg]", "{t},{k},20")
    (made,) = read_trials([path.name], tmp_path, leg)
    assert made.signals is not None
    far = replace(made, signals=replace(made.signals, command=np.full_like(made.signals.command, 20.0)))
    assert checked_trials([made], leg, in_code(tmp_path))
    with pytest.raises(UserError, match=r"signals.command\[0, 0\].*: 20 rad is beyond the joint's travel, 6.98 rad"):
        checked_trials([far], leg, in_code(tmp_path))


def test_a_drive_that_is_off_needs_no_column_of_it(tmp_path: Path) -> None:
    """A winding that is open is no motor at 0 V: that brakes."""
    leg = read_leg(leg_file(tmp_path, "{kind: voltage, " + MOTOR + "}"))
    path = trial(tmp_path, "time [s],arm [deg]", "{t},{k}")
    with pytest.raises(UserError, match=r"if it was off, its winding open, write drive_off: \[arm\]"):
        read_recording(path, leg)
    entry = {"file": path.name, "drive_off": ["arm"]}
    (made,) = read_trials([entry], tmp_path, leg)
    assert made.signals is not None
    assert not made.signals.enabled.any()
    planted = drive_inputs(tmp_path, made, leg, 0.0).planted(leg)  # of a rehearsal
    assert not planted.enabled.any()
    assert not planted.supply.any()


@pytest.mark.parametrize(
    ("drive", "columns", "off", "words"),
    [
        ("{kind: voltage, " + MOTOR + "}", "", "arn", "no joint of the leg; did you mean arm"),
        ("{kind: voltage, " + MOTOR + "}", ",arm enabled [1]", "arm", "is given, though drive_off says"),
        ("{kind: torque, " + MOTOR + "}", ",arm current [A]", "arm", "is given, though drive_off says"),
        ("{kind: torque}", ",arm torque [N*m]", "arm", "is given, though drive_off says"),
        ("null", "", "arm", "has no drive that could be off"),
    ],
)
def test_mistakes_of_a_drive_that_is_off(tmp_path: Path, drive: str, columns: str, off: str, words: str) -> None:
    leg = read_leg(leg_file(tmp_path, drive))
    path = trial(tmp_path, "time [s],arm [deg]" + columns, "{t},{k}" + ",1" * columns.count(","))
    with pytest.raises(UserError, match=words):
        read_trials([{"file": path.name, "drive_off": [off]}], tmp_path, leg)
