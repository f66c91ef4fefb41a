"""Commands of a joint that turns past half a turn: the same commands, whether the log wraps them or counts on."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from synth.arrays import Array
from synth.files.import_mapping import Mapping
from synth.files.leg_file import read_leg
from synth.motion.importers.convert import ImportedRecording, import_file

LEG = """kind: leg
name: servo
joints:
  - name: knee
    zero: {zero} deg
    sign: +1
    link: {{length: 120 mm, mass: 490 g, com: 100 mm, inertia: 2e-4 kg*m^2}}
    drive: {{kind: servo, gain: 12 N*m/rad}}
"""
TIME = 0.01 * np.arange(400)
STEPS = np.where(TIME < 1.0, 100.0, np.where(TIME < 2.5, 250.0, 60.0))
WAVE = 180.0 + 100.0 * np.sin(2.0 * TIME)


def followed(command: Array, speed: float = 3.0) -> Array:
    """A joint that goes to its command by ``speed`` deg a sample."""
    angle = np.full_like(command, command[0])
    for k in range(1, len(angle)):
        angle[k] = angle[k - 1] + np.clip(command[k - 1] - angle[k - 1], -speed, speed)
    return angle


def half_turn(angle: Array) -> Array:
    return np.asarray((angle + 180.0) % 360.0 - 180.0)


def whole_turn(angle: Array) -> Array:
    return np.asarray(angle % 360.0)


def imported(folder: Path, angle: Array, command: Array, zero: float = 150.0) -> ImportedRecording:
    (folder / "servo.leg.yaml").write_text(LEG.format(zero=zero))
    table = np.column_stack([TIME, angle, command])
    header = "time [s],knee [deg],knee command [deg]"
    np.savetxt(folder / "log.csv", table, "%.9g", ",", header=header, comments="")
    return import_file(folder / "log.csv", read_leg(folder / "servo.leg.yaml"), Mapping(), name="log.csv", cut="keep")


@pytest.mark.parametrize("command", [STEPS, WAVE, STEPS[::-1]])
@pytest.mark.parametrize("wrapped", [True, False])
def test_commands_have_the_turns_of_the_angle(tmp_path: Path, command: Array, wrapped: bool) -> None:
    """The step from 250 to 60 deg is longer than half a turn: the joint goes down by 190 deg, not up by 170."""
    given = half_turn(command) if wrapped else command
    found = imported(tmp_path, half_turn(followed(command)), given)
    np.testing.assert_allclose(np.degrees(found.angles[:, 0]), followed(command), atol=1e-6)
    np.testing.assert_allclose(found.inputs[0].value, command, atol=1e-6)
    unwrapped = [note for note in found.notes if note.startswith("knee command: wraps with the angle; unwrapped at")]
    assert bool(unwrapped) == wrapped


def test_a_range_of_0_to_360_wraps_at_its_own_ends(tmp_path: Path) -> None:
    command = STEPS - 120.0  # -20, 130, -60
    found = imported(tmp_path, whole_turn(followed(command)), whole_turn(command), zero=0.0)
    np.testing.assert_allclose(found.inputs[0].value, command, atol=1e-6)
    counted = imported(tmp_path, whole_turn(followed(command)), command, zero=0.0)
    np.testing.assert_allclose(counted.inputs[0].value, command, atol=1e-6)


def test_a_shifted_angle_shifts_the_whole_command_and_says_so(tmp_path: Path) -> None:
    found = imported(tmp_path, followed(STEPS) + 720.0, STEPS + 720.0)
    np.testing.assert_allclose(found.inputs[0].value, STEPS, atol=1e-6)
    assert "knee command: shifted by -720 deg with the angle" in found.notes


def test_a_command_that_the_joint_does_not_reach_is_named(tmp_path: Path) -> None:
    command = np.where(TIME < 1.0, 100.0, np.where(TIME < 2.5, 250.0, np.where(TIME < 2.6, 60.0, 240.0)))
    found = imported(tmp_path, half_turn(followed(command)), half_turn(command))
    assert any(note.startswith("knee command: its turn is not certain from 2.500 s") for note in found.notes)
