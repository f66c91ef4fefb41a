"""Segments' angles, of links themselves in space, as inertial sensors and inclinometers give them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motion.importers.simulated_leg import angles, leg
from synth.arrays import Array
from synth.errors import UserError
from synth.files.import_mapping import JointColumn, Mapping
from synth.files.import_project import read_import_project
from synth.files.leg_file import write_leg
from synth.motion.importers.convert import ImportedRecording, import_file
from synth.swing.leg_model import Leg

TIME, MEASURED = angles()
HIP, KNEE, ANKLE = MEASURED.T
THIGH = HIP - 90.0  # deg from straight down, counter-clockwise; see ``simulated_leg.points``
SHANK = THIGH + KNEE - 180.0
FOOT = SHANK - (ANKLE - 180.0)


def wrapped(degrees: Array) -> Array:
    return (degrees + 180.0) % 360.0 - 180.0


def imported(path: Path, columns: dict[str, Array], limb: Leg, **joints: JointColumn) -> ImportedRecording:
    rows = [",".join(["time [s]", *(f"{name} [deg]" for name in columns)])]
    rows += [",".join(f"{each:.9g}" for each in row) for row in np.column_stack([TIME, *columns.values()])]
    path.write_text("\n".join(rows).replace("nan", "") + "\n")
    return import_file(path, limb, Mapping(joints=joints), name=path.name, cut="keep")


def segment(column: str, zero: float = 0.0, **more: Any) -> JointColumn:
    return JointColumn(column, zero=float(np.radians(zero)), segment=True, **more)


def test_three_sensors_on_three_links(tmp_path: Path) -> None:
    """One of them mounted upside down, one that reads clockwise, all wrapped at 180 deg."""
    sensors = {"thigh": wrapped(THIGH + 170.0), "shank": wrapped(90.0 - SHANK), "foot": wrapped(FOOT)}
    found = imported(tmp_path / "a.csv", sensors, leg(), hip=segment("thigh", 170.0),
                     knee=segment("shank", 90.0, sign=-1), ankle=segment("foot"))  # fmt: skip
    np.testing.assert_allclose(np.degrees(found.angles), MEASURED, atol=1e-5)
    assert not any("turn" in note for note in found.notes)


def test_an_encoder_between_two_sensors_and_a_tilted_base(tmp_path: Path) -> None:
    tilted = replace(leg(), tilt=np.radians(12.0))
    found = imported(tmp_path / "a.csv", {"hip": HIP, "shank": SHANK + 12.0, "ankle": ANKLE}, tilted,
                     knee=segment("shank"))  # fmt: skip
    np.testing.assert_allclose(np.degrees(found.angles), MEASURED, atol=1e-5)


def test_a_sample_that_the_link_above_lacks_is_missing_below(tmp_path: Path) -> None:
    gap = THIGH.copy()
    gap[40:44] = np.nan
    found = imported(tmp_path / "a.csv", {"thigh": gap, "shank": SHANK, "ankle": ANKLE}, leg(),
                     hip=segment("thigh"), knee=segment("shank"))  # fmt: skip
    expected = MEASURED.copy()
    expected[40:44, :2] = np.nan
    np.testing.assert_allclose(np.degrees(found.angles), expected, atol=1e-5)


def test_a_velocity_beside_a_segment_is_left_out(tmp_path: Path) -> None:
    columns = {"thigh": THIGH, "knee": KNEE, "ankle": ANKLE}
    path = tmp_path / "a.csv"
    rows = [",".join(["time [s]", *(f"{name} [deg]" for name in columns), "thigh velocity [deg/s]"])]
    speed = np.gradient(THIGH, TIME)
    rows += [",".join(f"{each:.9g}" for each in row) for row in np.column_stack([TIME, *columns.values(), speed])]
    path.write_text("\n".join(rows) + "\n")
    found = import_file(path, leg(), Mapping(joints={"hip": segment("thigh")}), name="a.csv", cut="keep")
    assert found.inputs == ()
    assert "hip velocity: thigh velocity is left out: thigh is a segment's angle" in found.notes


def test_a_project_states_a_segment_with_its_zero(tmp_path: Path) -> None:
    write_leg(leg(), tmp_path / "leg.yaml")
    (tmp_path / "a.csv").write_text("time [s],thigh [deg]\n0,1\n")
    head = "kind: import\nleg: leg.yaml\nfiles: [a.csv]\njoints:\n"
    file = tmp_path / "import.yaml"
    file.write_text(head + "  hip: {column: thigh, segment: true, zero: 90 deg}\n  knee: knee\n")
    columns = read_import_project(file).mapping.joints
    assert (columns["hip"].segment, columns["knee"].segment) == (True, False)
    assert columns["hip"].convention(leg().joints[0]) == (pytest.approx(np.pi / 2), 1)
    file.write_text(head + "  hip: {column: thigh, segment: true}\n")
    with pytest.raises(UserError, match=r"joints.hip.segment.* needs its zero, .* hangs straight down: zero: 0 deg"):
        read_import_project(file)
