"""Whatever a file holds, the answer is a recording or one message; never a traceback, a warning or a crash."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from motion.importers import (
    test_c3d,
    test_deeplabcut,
    test_marker_tables,
    test_matlab,
    test_more_formats,
    test_opensim,
    test_point_columns,
    test_sleap_csv,
)
from motion.importers.simulated_leg import PARTS, RATE, angles, leg, pixels, points
from synth.errors import UserError
from synth.files.import_mapping import Mapping
from synth.motion.importers.convert import import_file

WORDS = (b"nan", b"inf", b"1e400", b",,", b"\t", b"\n", b'"', b"-1")


def deeplabcut(folder: Path) -> tuple[Path, Mapping]:
    places = test_deeplabcut.parts(pixels(points(angles()[1])))
    return test_deeplabcut.written(folder / "a.csv", places), test_deeplabcut.MAPPING


def opensim(folder: Path) -> tuple[Path, Mapping]:
    path = folder / "a.mot"
    path.write_bytes((test_opensim.DATA / "degrees.mot").read_bytes())
    return path, Mapping(joints=test_opensim.COLUMNS)


def matlab(folder: Path) -> tuple[Path, Mapping]:
    time, measured = angles()
    savemat(folder / "a.mat", {"t": 1e3 * time, "theta": np.radians(measured), "s": {"a": 1, "b": "x"}})
    return folder / "a.mat", test_matlab.MAPPING


def c3d(folder: Path) -> tuple[Path, Mapping]:
    return test_c3d.written(folder / "a.c3d", test_c3d.in_space(angles()[1])), test_c3d.MAPPING


def plain(folder: Path) -> tuple[Path, Mapping]:
    rows = np.column_stack(angles())
    header = "time [s],hip [deg],knee [deg],ankle [deg]"
    np.savetxt(folder / "a.csv", rows, delimiter=",", header=header, comments="")
    return folder / "a.csv", Mapping()


def anipose(folder: Path) -> tuple[Path, Mapping]:
    mapping = Mapping(points=PARTS, frame_rate=RATE, likelihood=0.5)
    return test_more_formats.anipose(folder / "a.csv"), mapping


def vicon(folder: Path) -> tuple[Path, Mapping]:
    return test_marker_tables.vicon(folder / "a.csv"), test_marker_tables.MAPPING


def qualisys(folder: Path) -> tuple[Path, Mapping]:
    return test_marker_tables.qualisys(folder / "a.tsv"), test_marker_tables.MAPPING


def motive(folder: Path) -> tuple[Path, Mapping]:
    return test_marker_tables.motive(folder / "a.csv", "1.23"), test_marker_tables.MAPPING


def sleap_csv(folder: Path) -> tuple[Path, Mapping]:
    (folder / "a.csv").write_text("\n".join([test_sleap_csv.HEADER, *test_sleap_csv.rows()]) + "\n")
    return folder / "a.csv", Mapping(points=PARTS, frame_rate=RATE)


def point_columns(folder: Path) -> tuple[Path, Mapping]:
    text = test_point_columns.table(test_point_columns.HEAD, test_point_columns.with_time(points(angles()[1])))
    (folder / "a.csv").write_text(text)
    return folder / "a.csv", Mapping(points=PARTS, plane=("x", "y"))


def records(folder: Path) -> tuple[Path, Mapping]:
    time, measured = angles()
    titles = ("time [s]", "hip [deg]", "knee [deg]", "ankle [deg]")
    entries = [dict(zip(titles, map(float, (t, *row)), strict=True)) for t, row in zip(time, measured, strict=True)]
    (folder / "a.json").write_text(json.dumps({"note": "first", "entries": entries}))
    return folder / "a.json", Mapping()


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('{"time [s]": 0.0,', '{"big": ' + "1" * 5000 + ', "time [s]": 0.0,'),
        ('"first"', '"\\ud800 first"'),
        ('"note"', '"\\ud800k": 3, "note"'),
        ('{"time [s]": 0.0,', '{"\\udfff": 1, "time [s]": 0.0,'),
    ],
)
def test_json_that_python_does_not_write_or_read_again(tmp_path: Path, old: str, new: str) -> None:
    path, mapping = records(tmp_path)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    found = import_file(path, leg(), mapping, name="a.json", cut="keep")
    np.testing.assert_allclose(np.degrees(found.angles), angles()[1], atol=1e-9)
    "".join(found.notes).encode()
    lines = path.read_text().partition("[{")[2].removesuffix("]}").replace("}, {", "}\n{")
    (tmp_path / "b.json").write_text("{" + lines + "\n")
    assert len(import_file(tmp_path / "b.json", leg(), mapping, name="b.json", cut="keep").time) == len(angles()[0])


def damaged(whole: bytes, generator: np.random.Generator) -> bytes:
    """Bytes changed, lost, doubled or replaced, mostly near the beginning, where headers are."""
    data = bytearray(whole)
    for _ in range(generator.integers(1, 8)):
        at = int(generator.integers(min(len(data), 3000 if generator.random() < 0.7 else len(data))))
        kind = generator.integers(4)
        if kind == 0:
            data[at] = int(generator.integers(256))
        elif kind == 1:
            del data[at : at + int(generator.integers(1, 50))]
        elif kind == 2:
            data[at:at] = generator.integers(0, 256, 5).astype(np.uint8).tobytes()
        else:
            data[at:at] = WORDS[generator.integers(len(WORDS))]
    return bytes(data)


@pytest.mark.parametrize(("made", "count"), [(deeplabcut, 60), (opensim, 60), (matlab, 6), (plain, 60), (c3d, 6),
                                              (anipose, 30), (records, 60), (vicon, 40), (qualisys, 40), (motive, 40),
                                              (sleap_csv, 40), (point_columns, 40)])  # fmt: skip
def test_a_damaged_file_gives_a_recording_or_a_message(
    made: Callable[[Path], tuple[Path, Mapping]], count: int, tmp_path: Path
) -> None:
    path, mapping = made(tmp_path)
    whole = path.read_bytes()
    assert len(import_file(path, leg(), mapping, name="whole").time) > 20
    generator = np.random.default_rng(5)
    refused = 0
    for _ in range(count):
        path.write_bytes(damaged(whole, generator))
        try:
            found = import_file(path, leg(), mapping, name="damaged")
        except UserError:
            refused += 1
        else:
            assert not np.isinf(found.angles).any()
    assert refused > 0
