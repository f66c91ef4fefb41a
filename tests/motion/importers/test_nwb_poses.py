"""NWB files with several poses, of animals or cameras: ``individual`` chooses one, and without it they are listed."""

from __future__ import annotations

from collections.abc import Mapping as Dictionary
from pathlib import Path

import numpy as np
import pytest

from motion.importers.simulated_leg import PARTS, RATE, angles, leg, pixels, points
from synth.errors import UserError
from synth.files.import_mapping import Mapping
from synth.motion.importers.convert import import_file

TIME, MEASURED = angles()
OTHER = MEASURED * 0.5 + 60.0  # deg, of another animal


def nwb(path: Path, poses: Dictionary[str, np.ndarray], *, skeletons: bool = False) -> Path:
    """A file with poses at these places, measured angles (n, 3) deg each; each with a skeleton and video of its own."""
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        for number, (place, measured) in enumerate(poses.items()):
            places = pixels(points(measured))
            for k, part in enumerate(PARTS):
                group = file.create_group(f"processing/{place}/{part}")
                group.attrs["neurodata_type"] = "PoseEstimationSeries"
                group["data"] = places[:, k]
                group["data"].attrs["unit"] = "pixels"
                group["starting_time"] = 0.0
                group["starting_time"].attrs["rate"] = RATE
            if skeletons:
                pose = file[f"processing/{place}"]
                own = file.create_group(f"processing/Skeletons/bones{number}")
                own.attrs["neurodata_type"] = "Skeleton"
                pose[f"bones{number}"] = h5py.SoftLink(own.name)
                pose["original_videos"] = [f"C:\\films\\cam{number}.mp4"]
                subject = file.create_group(f"general/subjects/animal{number}")
                subject.attrs["neurodata_type"] = "Subject"
                own["subject"] = h5py.SoftLink(subject.name)
    return path


def read(path: Path, individual: str | None) -> np.ndarray:
    """Measured angles, deg."""
    mapping = Mapping(points=PARTS, individual=individual)
    return np.degrees(import_file(path, leg(), mapping, name=path.name, cut="keep").angles)


@pytest.mark.parametrize("individual", ["ratB", "bones1", "animal1", "cam1.mp4"])
def test_an_animal_by_its_pose_skeleton_subject_or_film(tmp_path: Path, individual: str) -> None:
    path = nwb(tmp_path / "a.nwb", {"behavior/ratA": MEASURED, "behavior/ratB": OTHER}, skeletons=True)
    np.testing.assert_allclose(read(path, individual), OTHER, atol=1e-6)


def test_cameras_whose_poses_have_one_name(tmp_path: Path) -> None:
    """As sleap-io writes them: a module for each film, in it a pose for each track."""
    poses = {f"SLEAP_VIDEO_00{k}_{film}/track=rat": found for k, film, found in ((0, "a", MEASURED), (1, "b", OTHER))}
    path = nwb(tmp_path / "a.nwb", poses)
    with pytest.raises(UserError, match="of SLEAP_VIDEO_000_a/track=rat, SLEAP_VIDEO_001_b/track=rat"):
        read(path, None)
    with pytest.raises(UserError, match=r'"rat" is that of several poses; choose one: SLEAP_VIDEO_000_a/track=rat, '):
        read(path, "rat")
    np.testing.assert_allclose(read(path, "SLEAP_VIDEO_001_b/track=rat"), OTHER, atol=1e-6)


def test_without_a_choice_the_names_are_listed_with_what_differs(tmp_path: Path) -> None:
    path = nwb(tmp_path / "a.nwb", {"behavior/ratA": MEASURED, "behavior/ratB": OTHER}, skeletons=True)
    with pytest.raises(UserError, match=r"contains 2 poses; choose one, individual: NAME, of ratA \(bones0, animal0"):
        read(path, None)
    with pytest.raises(UserError, match=r'there is no individual "ratC"; did you mean rat[AB]'):
        read(path, "ratC")


def test_a_single_pose_needs_no_choice(tmp_path: Path) -> None:
    path = nwb(tmp_path / "a.nwb", {"behavior/ratA": MEASURED})
    for individual in (None, "ratA"):
        np.testing.assert_allclose(read(path, individual), MEASURED, atol=1e-6)
    with pytest.raises(UserError, match='there is no individual "left"; the file has ratA; leave it out'):
        read(path, "left")
