"""Raw counts of encoders as servos, motor drivers and microcontrollers log them: counts a turn, gears, overflow."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from synth.cli import main
from synth.errors import UserError
from synth.files.import_mapping import JointColumn
from synth.files.import_project import read_import_project
from synth.files.leg_file import read_leg
from synth.files.recording import Recorded, read_recording
from synth.motion.importers.import_result import read_files
from synth.motion.importers.raw_counts import without_overflow

Array = NDArray[np.float64]
TIME = 0.01 * np.arange(80)
ANGLE = 0.4 * np.sin(9.0 * TIME) + 0.3  # rad, of the joint
COMMAND = 0.4 * np.sin(9.0 * TIME + 0.2) + 0.3
SPEED = 3.6 * np.cos(9.0 * TIME)
COUNT = 2.0 * np.pi / 4096.0  # rad
SERVO = "drive: {kind: servo, gain: 2 N*m/rad}"
LEG = """kind: leg
name: arm
joints:
  - {{name: knee, zero: 0 deg, sign: +1, link: {{length: 0.1 m, mass: 0.2 kg, com: 0.05 m, inertia: 1e-3 kg*m^2}},
     {more}}}
"""


def project(folder: Path, column: str, header: str, *columns: Array, drive: str = SERVO) -> Path:
    """An import of a CSV with these columns, the joint's ``column`` as in the project."""
    (folder / "arm.leg.yaml").write_text(LEG.format(more=drive))
    np.savetxt(folder / "log.csv", np.column_stack([TIME, *columns]), "%.12g", ",", header=header, comments="")
    path = folder / "import.yaml"
    path.write_text(
        f"kind: import\nleg: arm.leg.yaml\nfiles: [log.csv]\nrelease: keep\n"
        f"time: {{column: t, unit: s}}\njoints: {{knee: {{{column}}}}}\n"
    )
    return path


def imported(path: Path) -> tuple[Recorded, list[str]]:
    """The trial of a project, and the import's notes."""
    out = path.parent / "out"
    assert main(["--quiet", "import", str(path), "--out", str(out)]) == 0
    notes = json.loads((out / "import.json").read_text())["trials"][0]["notes"]
    return read_recording(out / "trials" / "log.csv", read_leg(path.parent / "arm.leg.yaml")), notes


def as_moved(found: Recorded, within: float) -> None:
    """Angle and command of the joint, to the half of a count, rad."""
    np.testing.assert_allclose(found.angles[:, 0], ANGLE, atol=within)
    assert found.signals is not None
    np.testing.assert_allclose(found.signals.command[:, 0], COMMAND, atol=within)


def test_counts_of_a_servo_with_its_command(tmp_path: Path) -> None:
    """Dynamixel and Feetech: 4096 a turn, 2048 in the middle."""
    counts = [np.round(2048.0 - each / COUNT) for each in (ANGLE, COMMAND)]
    column = "column: pos, counts: 4096, zero_count: 2048, sign: -1, command: goal"
    as_moved(imported(project(tmp_path, column, "t,pos,goal", *counts))[0], COUNT / 2 + 1e-9)


def test_a_register_that_is_read_as_unsigned(tmp_path: Path) -> None:
    """Loggers that take a signed register of 32 bits for an unsigned one have 4294967295 in the place of -1."""
    counts = [np.round(-each / COUNT) % 2.0**32 for each in (ANGLE, COMMAND)]
    path = project(tmp_path, "column: pos, counts: 4096, sign: -1, command: goal", "t,pos,goal", *counts)
    found, notes = imported(path)
    as_moved(found, COUNT / 2 + 1e-9)
    told = [note.partition(":")[0] for note in notes if "negative ones of 32 bits" in note]
    assert told == ["knee", "knee command"]


@pytest.mark.parametrize(
    ("column", "scale"),
    [
        ("column: p, unit: turn, gear_ratio: 6, command: q", 6.0 / (2.0 * np.pi)),  # ODrive's turns of the motor
        ("column: p, counts: 2400, gear_ratio: 6, command: q", 2400.0 * 6.0 / (2.0 * np.pi)),
    ],
)
def test_an_encoder_on_the_motor_s_side(tmp_path: Path, column: str, scale: float) -> None:
    found, _ = imported(project(tmp_path, column, "t,p,q", ANGLE * scale, COMMAND * scale))
    as_moved(found, 1e-9)


def test_a_command_with_a_unit_of_its_own(tmp_path: Path) -> None:
    column = "column: p, counts: 4096, gear_ratio: 6, command: {column: q, unit: deg, gear_ratio: 1}"
    found, _ = imported(project(tmp_path, column, "t,p,q", 6.0 * ANGLE / COUNT, np.degrees(COMMAND)))
    as_moved(found, 1e-9)


def test_a_command_in_counts_beside_an_angle_in_degrees(tmp_path: Path) -> None:
    column = "column: p, unit: deg, command: {column: q, counts: 4096}"
    found, _ = imported(project(tmp_path, column, "t,p,q", np.degrees(ANGLE), COMMAND / COUNT))
    as_moved(found, 1e-9)


def test_a_header_of_counts_and_a_velocity(tmp_path: Path) -> None:
    """``[counts]`` in the header is not part of the name; a velocity in counts has the scale of the angle."""
    path = project(tmp_path, "column: enc, counts: 4096", "t,enc [counts],enc velocity [counts/s],enc speed",
                   ANGLE / COUNT, SPEED / COUNT, SPEED, drive="range: [-90 deg, 90 deg]")  # fmt: skip
    found, notes = imported(path)
    np.testing.assert_allclose(found.angles[:, 0], ANGLE, atol=1e-9)
    table = np.genfromtxt(tmp_path / "out" / "trials" / "log.csv", delimiter=",", names=True)
    np.testing.assert_allclose(table["knee_velocity_degs"], np.degrees(SPEED), atol=1e-6)
    assert "knee velocity: from enc velocity [counts/s]" in notes


@pytest.mark.parametrize(
    ("counts", "gear", "size"), [(4096, 1.0, 2**16), (2400, 1.0, 2**16), (2400, 1.0, 2**32), (4096, 6.0, 4096)]
)
def test_a_counter_that_begins_anew_is_continued(counts: int, gear: float, size: int) -> None:
    """A timer of 16 bits, a register of 32 bits that a program reads as signed, and a motor's encoder of one turn."""
    true = np.round(np.linspace(-900.0, 900.0, 40)) + (size if size < 2**32 else size / 2)
    seen = true % size if size < 2**32 else (true + size / 2) % size - size / 2
    notes: list[str] = []
    made = without_overflow(seen, JointColumn("x", counts=counts, gear_ratio=gear), "knee", notes)
    np.testing.assert_array_equal(np.diff(made), np.diff(true))
    assert len(notes) == 1


def test_an_encoder_of_one_turn_is_left_to_the_turns_of_the_angle() -> None:
    seen = np.r_[np.arange(4000.0, 4096.0), np.arange(0.0, 90.0)]
    notes: list[str] = []
    np.testing.assert_array_equal(without_overflow(seen, JointColumn("x", counts=4096), "knee", notes), seen)
    assert not notes


@pytest.mark.parametrize(
    ("column", "words"),
    [
        ("column: p, unit: count", r'"count" is no unit, .* write its counts a turn, such as counts: 4096'),
        ("column: p, unit: turn/8192", r'"turn/8192" is no unit, .* counts: 8192, instead of `unit`'),
        ("column: p, unit: 0.088 deg", r"counts: 4096, instead of `unit`"),
        ("column: p, unit: 0.1 deg", r"counts: 3600, instead of `unit`"),
        ("column: p, unit: mm", r"where that of an angle is needed.*deg, rad or turn; raw counts .* counts: 4096"),
        ("column: p", r'knee: the file does not state the unit of "p"; .*unit: deg}; raw counts .* counts: 4096'),
        ("column: p, unit: deg, counts: 4096", r'"unit" and "counts" are both given'),
        ("column: p, counts: 1", r"joints.knee.counts"),
        ("column: p, unit: deg, zero_count: 5", r"beside it write its counts a turn"),
        ("column: p, counts: 8, zero_count: 5, zero: 1 deg", r'"zero" and "zero_count" are both given'),
        ("column: p, unit: deg, command: {column: q, unit: tick}", r'knee.command.unit: "tick" is no unit, .* counts'),
        ("column: p, unit: deg, enabled: {column: q, counts: 4096}", r'"counts" is not a key here'),
        ("column: r, counts: 4096", r'the file says that "r" is in rad, the project that it is raw counts'),
    ],
)
def test_mistakes(tmp_path: Path, column: str, words: str) -> None:
    path = project(tmp_path, column, "t,p,q,r [rad]", ANGLE, COMMAND, ANGLE, drive="range: [-90 deg, 90 deg]")
    with pytest.raises(UserError, match=words):
        read_files(read_import_project(path))


@pytest.mark.parametrize("limits", ["", "range: [-90 deg, 90 deg]"])
def test_an_angle_beyond_any_travel_may_be_counts(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], limits: str
) -> None:
    path = project(tmp_path, "column: p, unit: turn", "t,p", ANGLE / COUNT + 1000.0, drive=limits)
    assert main(["--quiet", "import", str(path), "--out", str(tmp_path / "out")]) == 2
    assert "if these are raw counts of an encoder, synth import turns them into angles" in capsys.readouterr().err
