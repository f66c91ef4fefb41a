"""OpenSim's files, written by OpenSim (tools/make_opensim_samples.py): inDegrees obeyed, and refused where missing."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from motion.importers.simulated_leg import leg
from synth.errors import UserError
from synth.files.import_mapping import JointColumn, Mapping
from synth.motion.importers.convert import ImportedRecording, import_file
from synth.motion.importers.foreign_data import states_otherwise

Array = NDArray[np.float64]
DATA = Path(__file__).parent / "data"
# OpenSim's leg: flexion of the hip positive, of the knee negative, straight at zero
COLUMNS = {
    "hip": JointColumn("hip_flexion_r", zero=0.0, sign=1),
    "knee": JointColumn("knee_angle_r", zero=0.0, sign=1),
    "ankle": JointColumn("ankle_angle_r", zero=math.radians(-20.0), sign=-1),
}


def imported(path: Path, joints: dict[str, JointColumn] = COLUMNS) -> ImportedRecording:
    return import_file(path, leg(), Mapping(joints=joints), name=path.name, cut="keep")


def truth() -> tuple[Array, Array]:
    """Clock and the angles that the leg file means: q = sign (value - zero), measured = zero + sign q."""
    time = np.arange(60) / 100.0
    swing = np.exp(-3.0 * time)
    hip = 10.0 + 25.0 * swing * np.cos(9.0 * time)
    knee = -40.0 + 30.0 * swing * np.cos(14.0 * time)
    ankle = 5.0 - 12.0 * swing * np.sin(11.0 * time)
    return time, np.stack([90.0 + hip, 180.0 + knee, 180.0 + (ankle + 20.0)], axis=1)


@pytest.mark.parametrize(("name", "unit"), [("degrees.mot", "deg"), ("radians.sto", "rad")])
def test_degrees_and_radians_are_obeyed(name: str, unit: str) -> None:
    """OpenSim 4 names model states by their path, /jointset/hip_r/hip_flexion_r/value: the last name is enough."""
    time, wanted = truth()
    found = imported(DATA / name)
    np.testing.assert_allclose(found.time, time, atol=1e-12)
    np.testing.assert_allclose(np.degrees(found.angles), wanted, atol=1e-9)
    said = "yes" if unit == "deg" else "no"
    assert found.notes[0] == f"inDegrees={said}: angles are read in {unit}"
    assert any(note.startswith("ankle: 100% of the samples lie outside its range") for note in found.notes)


def test_without_in_degrees_it_is_refused() -> None:
    with pytest.raises(
        UserError, match=r"unsaid.sto: inDegrees: its header does not state inDegrees.*before \"endhead"
    ):
        imported(DATA / "unsaid.sto")


def test_the_older_header_is_read(tmp_path: Path) -> None:
    """As the documentation shows it: the name first, nRows and nColumns, blanks around words."""
    body = (DATA / "degrees.mot").read_text().partition("endheader\n")[2]
    path = tmp_path / "old.sto"
    path.write_text(
        f"Coordinates\nversion=1\nnRows=60\nnColumns=4\ninDegrees=Yes\n\nUnits are S.I.\n endheader \n{body}"
    )
    np.testing.assert_allclose(np.degrees(imported(path).angles), truth()[1], atol=1e-9)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("inDegrees=yes", "inDegrees=maybe", r'inDegrees: "maybe" is not allowed: write yes or no'),
        ("endheader", "endhead", r'has no line "endheader"'),
        ("version=3", "nRows=90", r"says 90 rows and there are 60: the file is cut off"),
        ("time\t", "zeit\t", r'no row of labels that begins with "time"'),
        ("\t35\t", "\tthirty\t", r":8: is not a number"),
        ("\t35\t", "\t", r":8: has 3 cells where there are 4 labels"),
        ("knee_angle_r\t", "hip_flexion_r\t", r'"hip_flexion_r" is given twice'),
    ],
)
def test_damaged_files(tmp_path: Path, old: str, new: str, message: str) -> None:
    text = (DATA / "degrees.mot").read_text()
    assert old in text
    path = tmp_path / "a.mot"
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(UserError, match=message):
        imported(path)


def test_vectors_missing_columns_and_stated_units(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="has cells of type Vec3"):
        imported(DATA / "vectors.sto")
    with pytest.raises(UserError, match='hip: there is no column "hip_r"; the file has hip_flexion_r, knee_an'):
        imported(DATA / "degrees.mot", COLUMNS | {"hip": JointColumn("hip_r")})
    with pytest.raises(UserError, match=r"the header's inDegrees says that .* is in deg, the project says rad"):
        imported(DATA / "degrees.mot", COLUMNS | {"hip": JointColumn("hip_flexion_r", unit="rad")})
    with pytest.raises(UserError, match='there is no column "hip"'):
        imported(DATA / "degrees.mot", {})


def test_a_count_in_the_header_that_is_no_number_states_nothing() -> None:
    assert states_otherwise("7", 8)
    assert states_otherwise("9" * 5000, 8)  # more digits than Python turns into a number
    assert not any(states_otherwise(text, 8) for text in ("8", "008", "²", "٣", "", "-", "8.0"))
    assert not states_otherwise("0", 0)
