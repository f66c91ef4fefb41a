"""Logs whose rows repeat a time: the same row twice is one sample; other values are refused with what to do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from motion.importers.simulated_leg import NAMES, RATE, angles, leg
from synth.errors import UserError
from synth.files.import_mapping import Mapping
from synth.motion.importers.convert import ImportedRecording, import_file

TIME, MEASURED = angles()


def table(time: np.ndarray = TIME) -> pd.DataFrame:
    return pd.DataFrame({"time [s]": time, **{f"{name} [deg]": MEASURED[:, k] for k, name in enumerate(NAMES)}})


def imported(data: pd.DataFrame, path: Path, mapping: Mapping | None = None) -> ImportedRecording:
    data.to_csv(path, index=False)
    return import_file(path, leg(), mapping or Mapping(), name=path.name, cut="keep")


@pytest.mark.parametrize("twice", [[100], [100, 100, 250]])
@pytest.mark.parametrize("begins", [0.0, 1.7e9])
def test_a_row_that_is_there_twice_is_one_sample(tmp_path: Path, twice: list[int], begins: float) -> None:
    data = table(begins + TIME)
    data["hip velocity [deg/s]"] = np.gradient(MEASURED[:, 0], TIME)
    data.loc[50, "ankle [deg]"] = np.nan
    rows = np.sort(np.concatenate([np.arange(len(TIME)), twice]))
    found, plain = imported(data.iloc[rows], tmp_path / "a.csv"), imported(data, tmp_path / "b.csv")
    np.testing.assert_array_equal(found.time, plain.time)
    np.testing.assert_array_equal(found.angles, plain.angles)
    np.testing.assert_array_equal(found.inputs[0].value, plain.inputs[0].value)
    (told,) = [note for note in found.notes if "of the row before" in note]
    assert told.endswith("at 0.500 s: left out")
    assert told.startswith(f"{len(twice)} row")


def test_rounded_times_are_told_the_frame_rate_which_helps(tmp_path: Path) -> None:
    data = table(np.floor(100.0 * TIME + 1e-9) / 100.0)
    moving = data.assign(**{"hip [deg]": MEASURED[:, 0] + 1e-3 * np.arange(len(TIME))})
    with pytest.raises(UserError, match=r"time repeats at sample 3: 0.01 s, then 0.01 s; .* --frame-rate"):
        imported(moving.iloc[1:], tmp_path / "a.csv")
    np.testing.assert_allclose(imported(data, tmp_path / "a.csv", Mapping(frame_rate=RATE)).time, TIME, atol=1e-12)


def test_two_recordings_in_one_file_are_told_apart(tmp_path: Path) -> None:
    data = table()
    with pytest.raises(UserError, match=r"time runs backwards at sample 301: 1.495 s, then 0 s; if two recordings"):
        imported(pd.concat([data, data]), tmp_path / "a.csv")


def test_a_clock_that_stood_still_is_no_row_twice(tmp_path: Path) -> None:
    """At rest the values repeat anyway; the step after it is twice as long, for a sample was taken."""
    data = table()
    data.loc[70, "time [s]"] = data.loc[69, "time [s]"]
    with pytest.raises(UserError, match=r"time repeats at sample 71"):
        imported(data, tmp_path / "a.csv")
