"""Points that their tracker thinks unlikely, and files whose points or scores are not as their format has them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from motion.importers import test_more_formats as files
from motion.importers.simulated_leg import PARTS, RATE, angles, leg, pixels, points
from synth.errors import UserError
from synth.files.import_mapping import Mapping
from synth.motion.importers import registry
from synth.motion.importers.convert import ImportedRecording, import_file
from synth.motion.importers.registry import recognise

LOW = slice(100, 105)  # frames in which the tracker lost the toe
COUNT = len(angles()[0])


def scores() -> np.ndarray:
    found = np.full((COUNT, len(PARTS)), 0.9)
    found[LOW, 3] = 0.05
    return found


def nwb(path: Path, confidence: bool = True, flat: bool = False, raw: int = 0) -> Path:
    """The groups of ndx-pose, after ``raw`` bytes of other recordings."""
    h5py = pytest.importorskip("h5py")
    places = pixels(points(angles()[1]))
    with h5py.File(path, "w") as file:
        file.attrs["neurodata_type"] = "NWBFile"
        if raw:
            file["acquisition/raw"] = np.zeros(raw, dtype=np.uint8)
    with h5py.File(path, "a") as file:
        for k, part in enumerate(PARTS):
            group = file.create_group(f"processing/behavior/Pose/{part}")
            group.attrs["neurodata_type"] = "PoseEstimationSeries"
            group["data"] = places[:, k, 0] if flat else places[:, k]
            group["timestamps"] = angles()[0]
            if confidence:
                group["confidence"] = scores()[:, k]
    return path


def sleap(path: Path, scored: bool = True) -> Path:
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        file["tracks"] = pixels(points(angles()[1])).transpose(2, 1, 0)[None]
        file["node_names"] = [part.encode() for part in PARTS]
        file["track_occupancy"] = np.ones((1, COUNT), dtype=np.uint8)
        if scored:
            file["point_scores"] = scores().T[None]
    return path


def anipose(path: Path, scored: bool = True) -> Path:
    rows = [line.split(",") for line in files.anipose(path).read_text().splitlines()]
    for frame, row in enumerate(rows[1:]):
        row[rows[0].index("toe_score")] = f"{scores()[frame, 3]}"
    kept = [k for k, title in enumerate(rows[0]) if scored or not title.endswith("_score")]
    path.write_text("\n".join(",".join(row[k] for k in kept) for row in rows) + "\n")
    return path


MADE = {"a.nwb": nwb, "a.h5": sleap, "a.csv": anipose}


def imported(path: Path, likelihood: float | None) -> ImportedRecording:
    rate = None if path.suffix == ".nwb" else RATE
    mapping = Mapping(points=PARTS, likelihood=likelihood, frame_rate=rate)
    return import_file(path, leg(), mapping, name=path.name, cut="keep")


@pytest.mark.parametrize("file", MADE)
def test_without_a_bound_unlikely_points_stay_and_are_told(tmp_path: Path, file: str) -> None:
    found = imported(MADE[file](tmp_path / file), None)
    assert np.isfinite(found.angles).all()
    assert any(
        "5 points (all body parts) is below 0.6: all are kept; with likelihood: 0.6 they" in n for n in found.notes
    )
    found = imported(tmp_path / file, 0.5)
    assert np.flatnonzero(np.isnan(found.angles[:, 2])).tolist() == list(range(100, 105))


@pytest.mark.parametrize("file", MADE)
def test_a_bound_needs_scores(tmp_path: Path, file: str) -> None:
    path = MADE[file](tmp_path / file, False)
    assert np.isfinite(imported(path, None).angles).all()
    with pytest.raises(UserError, match=r"likelihood: has no (score|confidence) of all its points; leave it out"):
        imported(path, 0.5)


def test_a_series_of_one_coordinate_is_named(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"(hip|knee|ankle|toe): contains a series of shape 300, where frames x 2"):
        imported(nwb(tmp_path / "a.nwb", flat=True), None)


def test_a_point_without_a_coordinate_is_named(tmp_path: Path) -> None:
    path = files.anipose(tmp_path / "a.csv")
    path.write_text(path.read_text().replace("toe_z", "toe_depth", 1))
    with pytest.raises(UserError, match=r"a.csv:1: has no column toe_z: a point in space has x, y and z"):
        imported(path, None)


def test_poses_behind_large_recordings_are_recognised(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "SCANNED", 100_000)
    path = nwb(tmp_path / "a.nwb", raw=300_000)
    with monkeypatch.context() as patch:
        patch.setattr(Path, "read_bytes", lambda self: pytest.fail("the whole file was read"))
        assert recognise(path, "a.nwb").name == "nwb-pose"


def test_unknown_hdf5_names_the_formats_that_may_be_stated(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["data"] = np.zeros(9)
    said = "format: one of deeplabcut-h5, nwb-pose, sleap, sleap-analysis"
    with pytest.raises(UserError, match=f"is HDF5 of an unknown program; if it is of a known one.*{said}"):
        recognise(tmp_path / "a.h5", "a.h5")
