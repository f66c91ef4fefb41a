"""The clock of channels: a stated frame rate beside the file's own times, and frames that a camera lost."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from motion.importers.simulated_leg import RATE, angles, leg
from synth.errors import UserError
from synth.files.import_mapping import Mapping
from synth.motion.importers.convert import ImportedRecording, import_file

NAMES = ("hip [deg]", "knee [deg]", "ankle [deg]")


def imported(data: pd.DataFrame, path: Path, rate: float) -> ImportedRecording:
    if path.suffix == ".json":
        data.to_json(path, orient="records")
    else:
        data.to_csv(path, index=False)
    return import_file(path, leg(), Mapping(frame_rate=rate), name=path.name, cut="keep")


def table(title: str, values: np.ndarray) -> pd.DataFrame:
    measured = angles()[1]
    return pd.DataFrame({title: values, **{name: measured[:, k] for k, name in enumerate(NAMES)}})


@pytest.mark.parametrize("file", ["a.csv", "a.json"])
def test_a_frame_rate_that_contradicts_the_file_s_times_is_refused(tmp_path: Path, file: str) -> None:
    data = table("time [s]", angles()[0])
    with pytest.raises(UserError, match=r'frame_rate: its column "time" has 200 rows a second, and 100 Hz is stated'):
        imported(data, tmp_path / file, 100.0)
    np.testing.assert_allclose(imported(data, tmp_path / file, RATE).time, angles()[0], atol=1e-9)


def test_times_rounded_to_a_quarter_of_a_step_agree_with_the_rate(tmp_path: Path) -> None:
    """240 Hz in whole milliseconds steps by 4, 4 and 5 ms."""
    time = np.round(np.arange(300) / 240.0, 3)
    np.testing.assert_allclose(imported(table("time [s]", time), tmp_path / "a.csv", 240.0).time, time, atol=1e-12)


def test_a_clock_without_a_unit_has_the_one_that_the_rate_tells(tmp_path: Path) -> None:
    found = imported(table("t", 1e3 * angles()[0]), tmp_path / "a.csv", RATE)
    np.testing.assert_allclose(found.time, angles()[0], atol=1e-9)
    assert "the clock is the column t, in ms, as the frame rate tells" in found.notes
    with pytest.raises(
        UserError, match=r'its column "t", without a unit, steps by 5, which is 120 Hz in none of s, ms'
    ):
        imported(table("t", 1e3 * angles()[0]), tmp_path / "b.csv", 120.0)


def test_times_that_stand_still_are_not_the_clock(tmp_path: Path) -> None:
    """A logger's time of day in whole seconds."""
    found = imported(table("time [s]", np.floor(angles()[0])), tmp_path / "a.csv", RATE)
    np.testing.assert_allclose(found.time, angles()[0], atol=1e-12)
    assert found.notes[0] == "its column time does not increase: it is not the clock"


@pytest.mark.parametrize("file", ["a.csv", "a.json"])
def test_lost_frames_leave_a_gap(tmp_path: Path, file: str) -> None:
    data = table("Frame Number", np.arange(300)).drop(index=range(100, 150))
    found = imported(data, tmp_path / file, RATE)
    np.testing.assert_allclose(found.time, np.delete(angles()[0], np.s_[100:150]), atol=1e-12)
    assert any(note.startswith("50 frames are lost in 1 gap of the clock, after") for note in found.notes)


def test_a_column_of_frames_that_does_not_count_up_is_refused(tmp_path: Path) -> None:
    frames = np.arange(300)
    frames[7] = 6
    with pytest.raises(UserError, match=r'column "frame" does not count the frames: sample 8 has 6 after 6'):
        imported(table("frame", frames), tmp_path / "a.csv", RATE)


def told_by(path: Path, title: str, scale: float) -> tuple[str, ...]:
    """The notes on the recording with its times multiplied by ``scale`` under that header."""
    table(title, scale * angles()[0]).to_csv(path, index=False)
    return import_file(path, leg(), Mapping(), name=path.name, cut="keep").notes


def test_seconds_labelled_as_milliseconds_are_told_where_they_are_read(tmp_path: Path) -> None:
    doubt = "would: is the clock right?"
    assert any(note.endswith(doubt) for note in told_by(tmp_path / "a.csv", "time [ms]", 1.0))
    assert not any(doubt in note for note in told_by(tmp_path / "a.csv", "time [ms]", 1e3))


@pytest.mark.parametrize(("title", "scale", "unit"), [("time [s]", 1e3, "ms"), ("time [ms]", 1e6, "us")])
def test_the_unit_that_a_refused_clock_has_is_that_of_the_file_s_own_header(
    tmp_path: Path, title: str, scale: float, unit: str
) -> None:
    with pytest.raises(UserError) as caught:
        told_by(tmp_path / "a.csv", title, scale)
    assert f"a.csv: {title}: the samples are 5 s apart" in str(caught.value)
    assert f"say so in the header: with time [{unit}] they would be 0.005 s apart" in str(caught.value)
