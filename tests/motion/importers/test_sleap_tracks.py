"""SLEAP's tracks: each animal's own frames, ghosts beside an animal without tracks, and axes in the order stated."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motion.importers.simulated_leg import PARTS, RATE, angles, leg, pixels, points
from synth.arrays import Array
from synth.errors import UserError
from synth.files.import_mapping import Mapping
from synth.motion.importers.convert import ImportedRecording, import_file

COUNT = 40
MOVING = angles()[1][100 : 100 + COUNT]
OTHER = MOVING[::-1]
LOW = slice(10, 15)  # frames in which the toe's score is low


def imported(path: Path, **keys: Any) -> ImportedRecording:
    mapping = Mapping(points=PARTS, frame_rate=RATE, **keys)
    return import_file(path, leg(), mapping, name=path.name, cut="keep")


def seen(found: ImportedRecording) -> Array:
    """The measured angles (n, 3) deg of the samples that are not missing."""
    return np.asarray(np.degrees(found.angles[np.isfinite(found.angles).all(axis=1)]))


class Labels:
    """A ``.slp`` in the making; without a track the instances have none."""

    def __init__(self) -> None:
        self.sio = pytest.importorskip("sleap_io")
        self.skeleton = self.sio.Skeleton(nodes=[self.sio.Node(part) for part in PARTS])
        self.tracks: dict[str, Any] = {}
        self.frames: dict[int, list[Any]] = {}

    def add(self, measured: Array, first: int, track: str | None = None, score: float | None = 0.9) -> None:
        """One animal from the frame ``first`` on; score None: placed by hand."""
        given = None if track is None else self.tracks.setdefault(track, self.sio.Track(track))
        for k, place in enumerate(pixels(points(measured)), first):
            if score is None:
                one = self.sio.Instance.from_numpy(place, skeleton=self.skeleton, track=given)
            else:
                sure = np.full(len(PARTS), score)
                one = self.sio.PredictedInstance.from_numpy(
                    place, skeleton=self.skeleton, point_scores=sure, score=score, track=given
                )
            self.frames.setdefault(k, []).append(one)

    def save(self, path: Path) -> Path:
        video = self.sio.Video(filename="rat.mp4", open_backend=False)
        frames = [self.sio.LabeledFrame(video=video, frame_idx=k, instances=each) for k, each in self.frames.items()]
        labels = self.sio.Labels(frames, videos=[video], skeletons=[self.skeleton], tracks=list(self.tracks.values()))
        labels.save(str(path))
        return path


def test_tracks_that_never_meet_are_two_animals(tmp_path: Path) -> None:
    labels = Labels()
    labels.add(MOVING, 0, "m1")
    labels.add(OTHER, COUNT + 10, "m2")
    path = labels.save(tmp_path / "a.slp")
    for track, measured in (("m1", MOVING), ("m2", OTHER)):
        np.testing.assert_allclose(seen(imported(path, individual=track)), measured, atol=1e-3)
    said = r"contains 2 tracks; choose one: individual: m1, or one of m2\. No frame has two of them: if they are one"
    with pytest.raises(UserError, match=said):
        imported(path)


def test_a_stretch_without_a_track_belongs_to_the_only_one(tmp_path: Path) -> None:
    labels = Labels()
    labels.add(MOVING[:25], 0, "m1")
    labels.add(MOVING[25:], 25)
    found = imported(labels.save(tmp_path / "a.slp"))
    np.testing.assert_allclose(seen(found), MOVING, atol=1e-3)
    assert "15 instances have no track; each is alone in its frame and taken as m1" in found.notes
    labels.add(OTHER[:5], 0)  # a second animal: whose the stretch is, is open
    found = imported(labels.save(tmp_path / "a.slp"))
    np.testing.assert_allclose(seen(found), MOVING[:25], atol=1e-3)
    assert "20 instances without a track are left out" in found.notes


def test_a_ghost_beside_an_animal_without_tracks_is_told_and_left_out_by_its_score(tmp_path: Path) -> None:
    labels = Labels()
    labels.add(OTHER[:8], 5, score=0.3)
    labels.add(MOVING, 0)
    path = labels.save(tmp_path / "a.slp")
    said = "has no tracks, and 8 of its 40 frames have several instances: .*likelihood: 0.6, leaves out those"
    with pytest.raises(UserError, match=said):
        imported(path)
    found = imported(path, likelihood=0.6)
    np.testing.assert_allclose(seen(found), MOVING, atol=1e-3)
    assert "8 instances without a point of a score of 0.6 are left out" in found.notes


def test_what_a_person_placed_replaces_the_prediction(tmp_path: Path) -> None:
    labels = Labels()
    labels.add(OTHER, 0)
    labels.add(MOVING[:20], 0, score=None)
    found = imported(labels.save(tmp_path / "a.slp"))
    np.testing.assert_allclose(seen(found), np.concatenate([MOVING[:20], OTHER[20:]]), atol=1e-3)


def analysis(path: Path, order: tuple[str, ...], tracks: int, dims: str | None) -> Path:
    """As sleap-io 0.9 writes it: every dataset with its axes in the attribute ``dims``."""
    h5py = pytest.importorskip("h5py")
    places = np.stack([pixels(points(MOVING)) + 100.0 * k for k in range(tracks)], axis=1)
    scores = np.full(places.shape[:3], 0.9)
    scores[LOW, :, 3] = 0.05
    axes = ("frame", "track", "node", "xy")
    with h5py.File(path, "w") as file:
        for name, values in (("tracks", places), ("point_scores", scores)):
            own = [axis for axis in order if axis in axes[: values.ndim]]
            file[name] = values.transpose([axes.index(axis) for axis in own])
            if dims is not None:
                file[name].attrs["dims"] = dims or json.dumps(own)
        file["node_names"] = [part.encode() for part in PARTS]
        file["track_names"] = [f"m{k + 1}".encode() for k in range(tracks)]
        file["track_occupancy"] = np.ones((COUNT, tracks), dtype=np.uint8)
        file.attrs["transpose"] = order[0] == "track"
    return path


STANDARD, MATLAB, BEFORE = (tuple(text.split()) for text in
                            ("frame track node xy", "track xy node frame", "frame node xy track"))  # fmt: skip


@pytest.mark.parametrize("tracks", [1, 2, 3])
@pytest.mark.parametrize(("order", "dims"), [(STANDARD, ""), (MATLAB, ""), (MATLAB, None), (BEFORE, None)])
def test_axes_are_in_the_order_that_the_file_states(
    tmp_path: Path, order: tuple[str, ...], dims: str | None, tracks: int
) -> None:
    path = analysis(tmp_path / "a.h5", order, tracks, dims)
    individual = None if tracks == 1 else f"m{tracks}"
    found = imported(path, individual=individual)
    np.testing.assert_allclose(seen(found), MOVING, atol=1e-9)
    assert any("the score of 5 points (all body parts) is below 0.6: all are kept" in note for note in found.notes)
    found = imported(path, individual=individual, likelihood=0.5)
    assert np.flatnonzero(np.isnan(found.angles[:, 2])).tolist() == list(range(LOW.start, LOW.stop))


@pytest.mark.parametrize("dims", ['["frame", "node", "xy"]', "[1, 2", '["frame", "frame", "node", "xy"]', "{}"])
def test_axes_that_are_misnamed_are_told(tmp_path: Path, dims: str) -> None:
    said = r'the attribute dims of "tracks" is .*and not the names frame, track, node, xy'
    with pytest.raises(UserError, match=said):
        imported(analysis(tmp_path / "a.h5", STANDARD, 1, dims))
