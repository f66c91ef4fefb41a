"""NWB poses as ``h5py`` writes them: the clock that begins at ``starting_time``, and the way in which y grows."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from motion.importers.simulated_leg import PARTS, RATE, angles, leg, pixels, points
from synth.errors import UserError
from synth.files.import_mapping import Mapping
from synth.motion.importers.convert import ImportedRecording, import_file
from synth.remarks import Remark

TIME, MEASURED = angles()
DOWN = pixels(points(MEASURED))
ABOVE, BELOW = (f"(0,0) corresponds to the {end} left corner of the video" for end in ("top", "bottom"))


def nwb(path: Path, sentence: str = ABOVE, start: float = 0.0, *, upward: bool = False) -> Path:
    """A pose with a rate and a first time, s."""
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        for k, part in enumerate(PARTS):
            group = file.create_group(f"processing/behavior/PoseEstimation/{part}")
            group.attrs["neurodata_type"] = "PoseEstimationSeries"
            group["data"] = DOWN[:, k] * [1.0, -1.0] + [0.0, 480.0] if upward else DOWN[:, k]
            group["data"].attrs["unit"] = "pixels"
            group["reference_frame"] = sentence
            group["starting_time"] = start
            group["starting_time"].attrs["rate"] = RATE
    return path


def read(path: Path, plane: tuple[str, str] | None = None, **options: object) -> ImportedRecording:
    mapping = Mapping(points=PARTS, plane=plane)
    return import_file(path, leg(), mapping, name=path.name, cut="keep", **options)  # type: ignore[arg-type]


@pytest.mark.parametrize("start", [0.5, 100.0])
def test_a_window_counts_from_starting_time(tmp_path: Path, start: float) -> None:
    found = read(nwb(tmp_path / "a.nwb", start=start), window=(start + 0.5, start + 1.0))
    np.testing.assert_allclose(found.time, start + TIME[100:201], atol=1e-9)
    np.testing.assert_allclose(np.degrees(found.angles), MEASURED[100:201], atol=1e-6)


@pytest.mark.parametrize("upward", [False, True])
def test_an_origin_below_is_asked_for_its_axes(tmp_path: Path, upward: bool) -> None:
    """DeepLabCut's exporters write this sentence of positions that count from the top."""
    path = nwb(tmp_path / "a.nwb", BELOW, upward=upward)
    (said,) = [note for note in read(path).notes if "reference_frame" in note]
    assert "(0,0) corresponds to the bottom left" in said
    assert isinstance(said, Remark)
    assert said.severity == "decide"
    assert re.search(r"plane: \[x, y\] .*\[x, -y\]", said.remedy)
    found = read(path, ("x", "y" if upward else "-y"))
    np.testing.assert_allclose(np.degrees(found.angles), MEASURED, atol=1e-6)
    assert not any("reference_frame" in note for note in found.notes)
    if not upward:
        np.testing.assert_allclose(np.degrees(read(path).angles), MEASURED, atol=1e-6)


def test_an_origin_above_counts_downward_and_a_plane_must_be_of_the_picture(tmp_path: Path) -> None:
    path = nwb(tmp_path / "a.nwb")
    np.testing.assert_allclose(np.degrees(read(path).angles), MEASURED, atol=1e-6)
    with pytest.raises(UserError, match=r"plane: \[x, z\] is not a plane: write two of x, y, such as \[x, y\]"):
        read(path, ("x", "z"))
