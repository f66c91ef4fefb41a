"""Small files that declare to hold much, and large ones of which only the beginning is needed."""

from __future__ import annotations

import sys
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from synth.errors import UserError
from synth.files.csv_table import ROW_LIMIT
from synth.files.import_mapping import Mapping
from synth.motion.importers.c3d import read_c3d
from synth.motion.importers.child import read_in_child
from synth.motion.importers.from_nwb import read_nwb
from synth.motion.importers.matlab import read_matlab
from synth.motion.importers.reading_program import ReadingLimits, TooLargeToRead


def declared(path: Path, rows: int, columns: int) -> Path:
    """NWB whose series holds nothing but declares so many rows and columns."""
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        group = file.create_group("processing/behavior/PoseEstimation/hip")
        group.attrs["neurodata_type"] = "PoseEstimationSeries"
        group.create_dataset("data", shape=(rows, columns), dtype="f8", chunks=(100_000, 2), compression="gzip")
        group.create_dataset("starting_time", data=0.0).attrs["rate"] = 100.0
    assert path.stat().st_size < 200_000
    return path


def test_rows_that_are_only_declared_are_refused_before_they_are_read(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=rf"too large: .*data\" is 10000000 x 2, and at most {ROW_LIMIT} rows"):
        read_nwb(declared(tmp_path / "a.nwb", 10_000_000, 2), Mapping(), "a.nwb")


def test_numbers_that_are_only_declared_are_refused_before_they_are_read(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="too large: it holds more than 100000000 numbers"):
        read_nwb(declared(tmp_path / "a.nwb", ROW_LIMIT, 51), Mapping(), "a.nwb")


def test_series_are_refused_by_their_numbers_together() -> None:
    limits = ReadingLimits(ROW_LIMIT)
    series = SimpleNamespace(shape=(ROW_LIMIT, 25), dtype=np.dtype("f4"), name="data")
    assert limits.held(series) is series
    limits.held(series)
    with pytest.raises(TooLargeToRead, match="more than 100000000 numbers"):
        limits.held(series)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="no other system limits a process's memory")
def test_a_reader_that_takes_all_memory_is_stopped(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"")
    with pytest.raises(UserError, match="too large: to read it takes more than 4 GB"):
        read_in_child("arrays = {'a': numpy.zeros(10**12)}", tmp_path / "a", "a", "MAT")


def test_what_a_library_prints_is_no_part_of_the_answer(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"")
    code = "import os\nprint('a warning')\nos.write(1, b'of a C library')\narrays = {'a': numpy.arange(3)}"
    found = read_in_child(code, tmp_path / "a", "a", "MAT")
    np.testing.assert_array_equal(found["a"], [0, 1, 2])


@pytest.mark.parametrize(("read", "mark"), [(read_matlab, b"MATLAB 7.3"), (read_c3d, b"\x02no C3D")])
def test_of_a_large_file_of_another_kind_the_beginning_is_read(
    read: Callable[[Path, Mapping, str], object], mark: bytes, tmp_path: Path
) -> None:
    with (tmp_path / "a").open("wb") as file:
        file.write(mark)
        file.truncate(100_000_000)  # a sparse file: no disk
    tracemalloc.start()
    try:
        with pytest.raises(UserError, match=r"version 7\.3|not a C3D file"):
            read(tmp_path / "a", Mapping(), "a")
        assert tracemalloc.get_traced_memory()[1] < 1_000_000
    finally:
        tracemalloc.stop()
