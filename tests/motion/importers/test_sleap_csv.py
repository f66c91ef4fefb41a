"""SLEAP's analysis CSV, in the layout that sleap-io documents: a row an animal of a frame."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motion.importers.simulated_leg import PARTS, RATE, angles, leg, pixels, points
from synth.arrays import Array
from synth.errors import UserError
from synth.files.import_mapping import Mapping
from synth.motion.importers.convert import ImportedRecording, import_file

TIME, MEASURED = angles()
PLACES = pixels(points(MEASURED))
HEADER = ",".join(["track", "frame_idx", "instance.score", *(f"{p}.{w}" for p in PARTS for w in ("x", "y", "score"))])


def row(track: str, frame: int, places: Array, score: str = "0.9") -> str:
    return ",".join([track, str(frame), score, *(f"{x:.6f},{y:.6f},{score}" for x, y in places)])


def rows(track: str = "rat", score: str = "0.9") -> list[str]:
    return [row(track, k, places, score) for k, places in enumerate(PLACES)]


def imported(path: Path, lines: list[str], **keys: Any) -> ImportedRecording:
    path.write_text("\n".join([HEADER, *lines]) + "\n")
    mapping = Mapping(points=PARTS, frame_rate=RATE, **keys)
    return import_file(path, leg(), mapping, name=path.name, cut="keep")


@pytest.mark.parametrize("track", ["rat", ""])
@pytest.mark.parametrize("score", ["0.9", ""])
def test_one_animal_with_and_without_a_track_by_a_network_and_by_hand(tmp_path: Path, track: str, score: str) -> None:
    found = imported(tmp_path / "a.csv", rows(track, score), likelihood=0.5)
    assert found.format == "sleap-csv"
    np.testing.assert_allclose(found.time, TIME, atol=1e-12)
    np.testing.assert_allclose(np.degrees(found.angles), MEASURED, atol=1e-5)


def test_frames_and_points_that_are_not_there_are_missing(tmp_path: Path) -> None:
    lines = rows()
    cells = lines[60].split(",")
    cells[9:12] = ["", "", ""]  # the ankle
    lines[60] = ",".join(cells)
    found = imported(tmp_path / "a.csv", [line for k, line in enumerate(lines) if not 100 <= k < 110])
    expected = MEASURED.copy()
    expected[100:110], expected[60, 1:] = np.nan, np.nan
    np.testing.assert_allclose(np.degrees(found.angles), expected, atol=1e-5)


def test_one_of_several_animals_is_chosen(tmp_path: Path) -> None:
    lines = [each for k in range(300) for each in (rows()[k], row("mouse", k, PLACES[299 - k]))]
    with pytest.raises(UserError, match="contains 2 tracks; choose one: individual: rat"):
        imported(tmp_path / "a.csv", lines)
    found = imported(tmp_path / "a.csv", lines, individual="mouse")
    np.testing.assert_allclose(np.degrees(found.angles), MEASURED[::-1], atol=1e-5)


def test_what_a_person_placed_replaces_the_prediction(tmp_path: Path) -> None:
    lines = rows()
    found = imported(tmp_path / "a.csv", [*lines[:50], row("rat", 49, PLACES[200], ""), *lines[50:]])
    np.testing.assert_allclose(np.degrees(found.angles[49]), MEASURED[200], atol=1e-5)


def test_a_track_twice_in_a_frame_and_a_missing_frame_are_refused(tmp_path: Path) -> None:
    lines = rows()
    with pytest.raises(UserError, match=r"a.csv:52: has the track \"rat\" twice in frame 49"):
        imported(tmp_path / "a.csv", [*lines[:50], row("rat", 49, PLACES[200]), *lines[50:]])
    with pytest.raises(UserError, match=r"a.csv:4: frame_idx: has no whole number"):
        imported(tmp_path / "a.csv", [*lines[:2], lines[2].replace("rat,2,", "rat,,"), *lines[3:]])


@pytest.mark.parametrize("track", [None, "rat"])
def test_the_table_that_sleap_io_writes(tmp_path: Path, track: str | None) -> None:
    sio = pytest.importorskip("sleap_io")
    skeleton, video = sio.Skeleton(nodes=list(PARTS)), sio.Video(filename="rat.mp4", open_backend=False)
    given = None if track is None else sio.Track(track)
    frames = []
    for k, places in enumerate(PLACES[:60]):
        sure = np.full(len(PARTS), 0.9)
        one = sio.PredictedInstance.from_numpy(places, skeleton=skeleton, point_scores=sure, score=0.9, track=given)
        frames.append(sio.LabeledFrame(video=video, frame_idx=k, instances=[one]))
    sio.save_csv(sio.Labels(frames, videos=[video], skeletons=[skeleton]), str(tmp_path / "a.csv"), format="sleap")
    mapping = Mapping(points=PARTS, frame_rate=RATE)
    found = import_file(tmp_path / "a.csv", leg(), mapping, name="a.csv", cut="keep")
    assert found.format == "sleap-csv"
    np.testing.assert_allclose(np.degrees(found.angles), MEASURED[:60], atol=1e-4)
