"""MATLAB files written by scipy; version 7.3 written by hdf5storage, to be refused."""

from __future__ import annotations

from pathlib import Path

import hdf5storage
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.io import savemat

from motion.importers.simulated_leg import angles, leg
from synth.drives.servo import Servo
from synth.errors import UserError
from synth.files.import_mapping import InputColumn, JointColumn, Mapping
from synth.motion.importers.convert import ImportedRecording, import_file

Array = NDArray[np.float64]
COLUMNS = {name: JointColumn(f"theta(:,{k})", unit="rad") for k, name in enumerate(("hip", "knee", "ankle"), 1)}
MAPPING = Mapping(time="t", time_unit="ms", joints=COLUMNS)


def imported(path: Path, mapping: Mapping = MAPPING) -> ImportedRecording:
    return import_file(path, leg(), mapping, name=path.name, cut="keep")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    time, measured = angles()
    struct = {"hip": measured[:, 0], "leg": {"rows": measured.T}, "name": "rat"}
    path = tmp_path / "run 1.mat"
    savemat(path, {"t": 1e3 * time, "theta": np.radians(measured), "trial": struct}, do_compression=True)
    return path


def test_columns_of_a_matrix(file: Path) -> None:
    time, measured = angles()
    found = imported(file)
    np.testing.assert_allclose(found.time, time, atol=1e-12)
    np.testing.assert_allclose(np.degrees(found.angles), measured, atol=1e-9)


def test_fields_of_structs_rows_and_a_rate_instead_of_a_clock(file: Path) -> None:
    columns = {"hip": JointColumn("trial.hip", unit="deg")}
    columns |= {name: JointColumn(f"trial.leg.rows({k}, :)", unit="deg") for k, name in ((2, "knee"), (3, "ankle"))}
    found = imported(file, Mapping(frame_rate=200.0, joints=columns))
    np.testing.assert_allclose(np.degrees(found.angles), angles()[1], atol=1e-9)
    np.testing.assert_allclose(found.time, angles()[0], atol=1e-12)


def test_complex_angles_are_missing_and_reported(tmp_path: Path) -> None:
    """As acos of a ratio beyond one gives them."""
    time, measured = angles()
    theta = np.radians(measured).astype(complex)
    theta[20:23, 2] = np.emath.arccos(np.array([1.01, 1.02, 1.01]))
    savemat(tmp_path / "a.mat", {"t": 1e3 * time, "theta": theta})
    found = imported(tmp_path / "a.mat")
    assert np.isnan(found.angles[20:23, 2]).all()
    assert np.isfinite(found.angles[:, :2]).all()
    assert found.notes[0] == "3 values of theta(:,3) are complex: taken as missing"


def test_version_7_3_is_refused_with_the_command_that_converts_it(tmp_path: Path) -> None:
    hdf5storage.savemat(str(tmp_path / "a.mat"), {"theta": np.radians(angles()[1])}, format="7.3")
    with pytest.raises(UserError, match=r"version 7.3 \(HDF5\); save it as version 7, in MATLAB: s = load\('a.mat'"):
        imported(tmp_path / "a.mat")


def test_variables_are_found_by_name_as_columns_of_any_file(tmp_path: Path) -> None:
    """A joint that the project does not list, a driven joint's command, rows and columns with an index."""
    time, measured = angles()
    hip, knee, ankle = np.radians(measured.T)
    content = {"t": 1e3 * time, "row": hip[None, :], "knee": knee[:, None], "column": ankle[:, None]}
    savemat(tmp_path / "a.mat", content | {"knee_cmd": knee + 0.1, "goal": knee + 0.2, "other": np.arange(7.0)})
    columns = {"hip": JointColumn("row(1,:)", unit="rad"), "ankle": JointColumn("column(:,1)", unit="rad")}
    mapping = Mapping(time="t", time_unit="ms", joints=columns)
    with pytest.raises(UserError, match='knee: the file does not state the unit of "knee"'):
        imported(tmp_path / "a.mat", mapping)
    driven = leg().with_joints(knee={"drive": Servo(gain=10.0)})
    for inputs, offset in (({}, 0.1), ({"command": InputColumn("goal")}, 0.2)):
        columns["knee"] = JointColumn("knee", unit="rad", inputs=inputs)
        found = import_file(tmp_path / "a.mat", driven, mapping, name="a.mat", cut="keep")
        np.testing.assert_allclose(np.degrees(found.angles), measured, atol=1e-9)
        np.testing.assert_allclose(np.radians(found.inputs[0].value), knee + offset, atol=1e-9)
    with pytest.raises(UserError, match=r'"row\(2,:\)" reaches outside: it is one row or column of 300'):
        imported(tmp_path / "a.mat", Mapping(frame_rate=200.0, joints={"hip": JointColumn("row(2,:)", unit="rad")}))


@pytest.mark.parametrize(
    ("column", "message"),
    [
        ("thetas(:,1)", r'hip: |there is no "thetas"; did you mean theta\?'),
        ("theta", r'"theta" is 300 x 3; choose a column, like theta\(:,1\)'),
        ("theta(:,4)", r'"theta\(:,4\)" reaches outside: it is 300 x 3, and counting begins at 1'),
        ("theta(:,0)", r"counting begins at 1"),
        ("theta(:,:)", r"one index is a colon and the other a number"),
        ("theta[:,1]", r"is not a column; write it like angles\(:,2\)"),
        ("trial", r'"trial" is a struct, where a matrix of numbers is needed'),
        ("trial.nam", r'no "nam" in trial; did you mean name\?'),
        ("trial.name", r'"trial.name" is of type str'),
        ("trial.leg.rows(1,:)(2)", r"is not a column"),
    ],
)
def test_names_that_lead_nowhere(file: Path, column: str, message: str) -> None:
    mapping = Mapping(frame_rate=200.0, joints=COLUMNS | {"hip": JointColumn(column, unit="deg")})
    with pytest.raises(UserError, match=message):
        imported(file, mapping)


def test_lengths_units_and_no_mapping_at_all(file: Path, tmp_path: Path) -> None:
    with pytest.raises(
        UserError, match=r'hip: there is no column "hip".*t \(300\), theta \(300 x 3\), trial.hip \(300\)'
    ):
        imported(file, Mapping(frame_rate=200.0))
    savemat(tmp_path / "a.mat", {"theta": np.ones((30, 3))})
    with pytest.raises(UserError, match=r"choose the variables of the joints' angles: theta \(30 x 3\)"):
        imported(tmp_path / "a.mat", Mapping(frame_rate=200.0))
    with pytest.raises(UserError, match=r'hip: the file does not state the unit of "theta\(:,1\)"'):
        imported(file, Mapping(frame_rate=200.0, joints=COLUMNS | {"hip": JointColumn("theta(:,1)")}))
    savemat(tmp_path / "b.mat", {"t": np.arange(20.0), "theta": np.ones((30, 3))})
    with pytest.raises(UserError, match=r"columns differ in length \(theta\(:,1\): 30"):
        imported(tmp_path / "b.mat")
    (tmp_path / "c.mat").write_text("text")
    with pytest.raises(UserError, match=r"is damaged or not a MAT file \(.*(truncated|out of range)"):
        import_file(tmp_path / "c.mat", leg(), MAPPING, name="c.mat", form="matlab")
