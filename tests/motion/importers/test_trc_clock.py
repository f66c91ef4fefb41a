"""TRC: which clock is taken where the column Time, the frame numbers and DataRate say different things."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from synth.arrays import Array
from synth.errors import UserError
from synth.files.import_mapping import Mapping
from synth.motion.importers.foreign_data import Markers
from synth.motion.importers.from_trc import read_trc
from synth.motion.importers.points import _clock

COUNT = 60
AT = np.arange(COUNT)


def trc(path: Path, rate: str, frames: Array, times: list[str]) -> Path:
    lines = [
        "PathFileType\t4\t(X/Y/Z)\ta.trc",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits",
        f"{rate}\t{rate}\t{COUNT}\t1\tmm",
        "Frame#\tTime\thip",
        "\t\tX1\tY1\tZ1",
        "",
        *(f"{frame:.0f}\t{time}\t1\t2\t3" for frame, time in zip(frames, times, strict=True)),
    ]
    path.write_text("\n".join(lines) + "\n")
    return path


def clock(path: Path, stated: float | None = None) -> tuple[Array, Markers]:
    mapping = Mapping(frame_rate=stated)
    found = read_trc(path, mapping, "a.trc")
    return _clock(found, mapping).time, found


def written(rate: float, digits: int = 5) -> list[str]:
    return [f"{k / rate:.{digits}f}" for k in AT]


def test_a_file_cut_off_by_a_copy_is_refused(tmp_path: Path) -> None:
    path = trc(tmp_path / "a.trc", "200", AT[:30] + 1, written(200.0)[:30])
    with pytest.raises(UserError, match="its header says 60 frames and there are 30: the file is cut off"):
        read_trc(path, Mapping(), "a.trc")


def test_time_is_the_clock_of_a_thinned_file_whose_frames_count_on(tmp_path: Path) -> None:
    time, found = clock(trc(tmp_path / "a.trc", "200", 4 * AT + 1, written(200.0)))
    np.testing.assert_allclose(time, AT / 200.0, atol=1e-9)
    assert found.notes == ("Frame# counts 4 a row; Time and DataRate agree on 200 Hz a row: Time is used",)


def test_time_is_the_clock_where_the_rate_is_of_the_frames(tmp_path: Path) -> None:
    time, found = clock(trc(tmp_path / "a.trc", "200", 4 * AT + 1, written(50.0)))
    np.testing.assert_allclose(time, AT / 50.0, atol=1e-9)
    assert not found.notes


def test_rounded_times_and_rates_are_no_difference(tmp_path: Path) -> None:
    """Milliseconds at 120 Hz are made even; 59.94 Hz that the header rounds to 60 stays as it is."""
    time, _ = clock(trc(tmp_path / "a.trc", "120", AT + 1, written(120.0, 3)))
    np.testing.assert_allclose(time, AT / 120.0, atol=1e-12)
    time, found = clock(trc(tmp_path / "b.trc", "60", AT + 1, written(59.94)))
    np.testing.assert_allclose(time, AT / 59.94, atol=1e-5)
    assert not found.notes


@pytest.mark.parametrize("cell", ["0e400", "0e-400", "0e99999999999999999999", "0.0e+2", "nan", "-0"])
def test_any_number_may_be_the_first_time(cell: str, tmp_path: Path) -> None:
    """0e400 is 0, and 10**400 no double."""
    times = [cell, *written(200.0)[1:]]
    path = trc(tmp_path / "a.trc", "200", AT + 1, times)
    if cell == "nan":
        with pytest.raises(UserError, match="has empty or repeated times"):
            clock(path)
    else:
        np.testing.assert_allclose(clock(path)[0], AT / 200.0, atol=1e-9)


def test_two_clocks_are_refused_until_one_is_stated(tmp_path: Path) -> None:
    path = trc(tmp_path / "a.trc", "100", AT + 1, written(200.0))
    with pytest.raises(UserError, match=r"Time has 200 rows a second, and the header says DataRate 100; state the ri"):
        clock(path)
    time, found = clock(path, 200.0)
    np.testing.assert_allclose(time, AT / 200.0, atol=1e-9)
    assert found.notes == ("the header's DataRate of 100 Hz is wrong; its column Time is used",)
    time, _ = clock(path, 100.0)
    np.testing.assert_allclose(np.diff(time), 0.01, atol=1e-9)
    with pytest.raises(UserError, match="state the right one"):
        clock(path, 130.0)


@pytest.mark.parametrize(("rate", "of_time"), [("25", 24.0), ("50", 49.0), ("100", 101.0)])
def test_rates_that_differ_by_a_few_per_cent_are_two_clocks(tmp_path: Path, rate: str, of_time: float) -> None:
    """Film of 24 pictures a second under a header of PAL's 25 is 4 % fast: every damping rate would be as far off."""
    with pytest.raises(UserError, match=rf"Time has {of_time:g} rows a second, and the header says DataRate {rate};"):
        clock(trc(tmp_path / "a.trc", rate, AT + 1, written(of_time, 9)))


def test_an_empty_time_is_told_and_a_constant_one_refused(tmp_path: Path) -> None:
    time, found = clock(trc(tmp_path / "a.trc", "100", AT + 1, [""] * COUNT))
    np.testing.assert_allclose(np.diff(time), 0.01, atol=1e-9)
    assert found.notes == ("its column Time is empty: the clock is Frame# over the DataRate of 100 Hz",)
    constant = trc(tmp_path / "b.trc", "100", AT + 1, ["0.000"] * COUNT)
    with pytest.raises(UserError, match=r"repeated times.* in its column Time; correct them, or state the frame rate"):
        clock(constant)
    time, _ = clock(constant, 100.0)
    np.testing.assert_allclose(np.diff(time), 0.01, atol=1e-9)
