"""C3D written by ezc3d: the plane of motion anywhere in space, unseen points, the missing package."""

from __future__ import annotations

import sys
from pathlib import Path

import ezc3d
import numpy as np
import pytest
from numpy.typing import NDArray

from motion.importers.simulated_leg import PARTS, RATE, angles, leg, points
from synth.cli import main
from synth.errors import UserError
from synth.files.import_mapping import Mapping
from synth.motion.importers.convert import ImportedRecording, import_file

Array = NDArray[np.float64]


def written(path: Path, space: Array, *, first_frame: int = 0, unit: str = "mm") -> Path:
    """Points (n, 4, 3) as C3D, which holds 4-byte floats."""
    made = ezc3d.c3d()
    made["parameters"]["POINT"]["RATE"]["value"] = [RATE]
    made["parameters"]["POINT"]["LABELS"]["value"] = [f"RAT:{part.upper()}" for part in PARTS]
    made["parameters"]["POINT"]["UNITS"]["value"] = [unit]
    made["header"]["points"]["first_frame"] = first_frame
    made["data"]["points"] = np.concatenate([space, np.ones((*space.shape[:2], 1))], axis=2).transpose(2, 1, 0)
    made.write(str(path))
    return path


def in_space(measured: Array) -> Array:
    """The leg walking along -y with z up, 1.5 m from the origin, in mm; x is across."""
    flat = points(measured)
    return 1e3 * np.stack([np.full(flat.shape[:2], 1.5), -flat[..., 0], flat[..., 1] + 0.6], axis=-1)


MAPPING = Mapping(points=tuple(f"RAT:{part.upper()}" for part in PARTS), plane=("-y", "z"))


def imported(path: Path, mapping: Mapping = MAPPING) -> ImportedRecording:
    return import_file(path, leg(), mapping, name=path.name, cut="keep")


def test_angles_are_recovered_unchanged(tmp_path: Path) -> None:
    time, measured = angles()
    found = imported(written(tmp_path / "a.c3d", in_space(measured)))
    np.testing.assert_allclose(np.degrees(found.angles), measured, atol=2e-4)  # 4-byte floats of 1500 mm
    np.testing.assert_allclose(found.time - found.time[0], time, atol=1e-9)
    assert found.tracked is not None
    assert found.tracked.scale == pytest.approx(1e-3, rel=1e-5)


def test_unseen_points_stay_missing(tmp_path: Path) -> None:
    _, measured = angles()
    space = in_space(measured)
    space[30:45, 3] = np.nan
    found = imported(written(tmp_path / "a.c3d", space))
    assert np.isnan(found.angles[30:45, 2]).all()
    assert np.isfinite(found.angles[:, :2]).all()
    assert any(note.startswith("ankle: 15 of 300 samples are missing") for note in found.notes)


def test_a_file_cut_off_by_a_copy_is_refused(tmp_path: Path) -> None:
    """ezc3d reads what is there: half of the motion was imported without a word."""
    path = written(tmp_path / "a.c3d", in_space(angles()[1]))
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(UserError, match=r"its header says 300 frames and there are \d+: the file is cut off"):
        imported(path)


def test_the_byte_order_of_sgi_machines_is_named(tmp_path: Path) -> None:
    """A valid file was "damaged; please open an issue"."""
    path = written(tmp_path / "a.c3d", in_space(angles()[1]))
    whole = bytearray(path.read_bytes())
    whole[512 * (whole[0] - 1) + 3] = 86
    path.write_bytes(whole)
    with pytest.raises(UserError, match=r"byte order of SGI machines .processor 86., .* export it for Intel"):
        imported(path)


def test_unseen_points_written_as_zeros_do_not_turn_the_fitted_plane(tmp_path: Path) -> None:
    space = in_space(angles()[1])
    fit = Mapping(points=MAPPING.points, plane=("fit", "z"))
    plain = imported(written(tmp_path / "a.c3d", space), fit)
    space[30:45] = space[60:70, 1] = 0.0
    found = imported(written(tmp_path / "b.c3d", space), fit)
    seen = np.isfinite(found.angles).all(axis=1)
    assert (~seen).sum() == 25
    np.testing.assert_allclose(found.angles[seen], plain.angles[seen], atol=1e-5)  # 4-byte floats of 1500 mm


def test_the_plane_must_be_stated_and_a_wrong_one_is_reported(tmp_path: Path) -> None:
    path = written(tmp_path / "a.c3d", in_space(angles()[1]))
    with pytest.raises(UserError, match=r"give the axes to the right and up .* \(x \S+ mm, y \S+ mm, z \S+ mm, SD\)"):
        imported(path, Mapping(points=MAPPING.points))
    with pytest.raises(UserError, match=r"\[y, -y\] is not a plane: write two of"):
        imported(path, Mapping(points=MAPPING.points, plane=("y", "-y")))
    found = imported(path, Mapping(points=MAPPING.points, plane=("x", "z")))
    assert any("deg out of the plane [x, z]: is it correct?" in note for note in found.notes)


def test_a_frame_rate_that_contradicts_the_file_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path / "a.c3d", in_space(angles()[1]))
    with pytest.raises(UserError, match="frame_rate: the file says 200 Hz and the project 100 Hz"):
        imported(path, Mapping(points=MAPPING.points, plane=MAPPING.plane, frame_rate=100.0))


def test_a_missing_package_is_reported_and_listed_with_its_installation(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(tmp_path / "a.c3d", in_space(angles()[1]))
    monkeypatch.setitem(sys.modules, "ezc3d", None)
    with pytest.raises(UserError, match=r"a.c3d: is C3D, which ezc3d reads: pip install limb-synth\[c3d\]"):
        imported(path)
    assert main(["import", "--list"]) == 0
    (row,) = [line for line in capsys.readouterr().out.splitlines() if line.startswith("c3d ")]
    assert row.split("points", 1)[1].strip() == "ezc3d, not installed: pip install limb-synth[c3d]"


def test_a_file_that_is_not_c3d_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.c3d"
    path.write_text("no motion")
    with pytest.raises(UserError, match="is not a C3D file"):
        import_file(path, leg(), MAPPING, name=path.name, form="c3d")
    whole = written(tmp_path / "b.c3d", in_space(angles()[1])).read_bytes()
    path.write_bytes(whole[:700])
    with pytest.raises(UserError):
        imported(path)
