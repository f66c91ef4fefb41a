"""Qualisys Track Manager: points in space as TSV, with the header that *Include TSV header* writes.

A row a setting, its name and its value (``NO_OF_FRAMES``, ``FREQUENCY`` ...), the last of them ``MARKER_NAMES`` and,
if asked for, ``TRAJECTORY_TYPES``; a row of columns' names if asked for; then a row a frame, with its number and its
time before the coordinates if asked for (QTM user manual, *Motion data (.tsv)*). Lengths are in mm, and z is up, unless
the calibration says otherwise.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.import_mapping import Mapping
from synth.motion.importers.foreign_data import MISSING, Markers, states_otherwise
from synth.motion.importers.marker_tables import (
    Line,
    column_numbers,
    points_at,
    require_frames,
    require_increasing,
    require_points,
    required_rate,
    table_lines,
    table_text,
    told_clock,
    without_zeros,
)
from synth.motion.importers.registry import loader, text_start

NAMES, TYPES = "MARKER_NAMES", "TRAJECTORY_TYPES"
UP = "z"
BEFORE = {0: (), 1: ("frame",), 2: ("frame", "time")}  # columns before the coordinates, unless a row names them
EXTERNAL = "EXT"  # a frequency that an external trigger gave


def is_qualisys(start: bytes, path: Path) -> bool:
    """Whether the file begins with Qualisys' settings."""
    lines = [line.partition("\t")[0].strip() for line in text_start(start).splitlines()[:3]]
    return "NO_OF_FRAMES" in lines and lines[0] in ("NO_OF_FRAMES", "FILE_VERSION")


@loader("qualisys", "Qualisys TSV", is_qualisys, "points", space=True)
def read_qualisys(path: Path, mapping: Mapping, name: str) -> Markers:
    """Points in space with the file's own rate; empty cells and 0, 0, 0 are unseen points.

    Raises
    ------
    UserError : the data are not 3D, the header states another number of markers or frames, no rate, or another than the
        times have, a cell that is no number, or frames out of order.
    """
    lines = [each for each in table_lines(table_text(path), name, "\t") if any(each[1])]
    at = next((k for k, (_, row) in enumerate(lines) if row[0] == NAMES), None)
    settings = {row[0]: (line, row[1] if len(row) > 1 else "") for line, row in lines[:at]}
    if at is None or settings.get("DATA_INCLUDED", (0, "3D"))[1] != "3D":
        text = "has no 3D positions of markers; export them as TSV, data type 3D, with its header"
        raise UserError(Problem(text, name))
    points = [cell for cell in lines[at][1][1:] if cell]
    require_points(points, "export them as TSV, data type 3D", name)
    stated = settings.get("NO_OF_MARKERS", (0, ""))[1]
    if states_otherwise(stated, len(points)):
        raise UserError(Problem(f"states {stated} markers but names {len(points)}", name, lines[at][0]))
    rows = lines[at + 1 :]
    rows = rows[1:] if rows and rows[0][1][0] == TYPES else rows
    before, rows = _columns_before(rows, 3 * len(points), name)
    told = column_numbers(rows, range(len(before)), "\t", name)
    frames = told[:, before.index("frame")] if "frame" in before else np.arange(1.0, len(rows) + 1)
    count = settings.get("NO_OF_FRAMES", (0, ""))[1]
    require_frames(rows, frames, int(count) if count.isascii() and count.isdigit() else None, name)
    time = told[:, before.index("time")] if "time" in before else None
    rate, time = _clock(settings.get("FREQUENCY", (1, "")), time, frames, rows, name)
    positions = points_at(rows, range(len(before), len(before) + 3 * len(points), 3), "\t", name)
    unseen = without_zeros(positions)
    return Markers(name, tuple(points), positions, frames, rate, "mm", (unseen,) if unseen else (), up=UP, time=time)


def _columns_before(rows: list[Line], width: int, name: str) -> tuple[tuple[str, ...], list[Line]]:
    """What stands before the ``width`` coordinates of a row: frame, time; and the rows without that of their names."""
    if rows and any(cell[:1].isalpha() and cell.casefold() not in MISSING for cell in rows[0][1]):
        titles = tuple(cell.casefold() for cell in rows[0][1])
        before = titles[: len([cell for cell in titles if cell]) - width]
        if len(set(before) & {"frame", "time"}) < len(before):
            text = f"names {len(titles)} columns where frame, time and {width} coordinates are expected"
            raise UserError(Problem(text, name, rows[0][0]))
        return before, rows[1:]
    extra = (len(rows[0][1]) if rows else width) - width
    while rows and extra > 0 and not rows[0][1][width + extra - 1] and extra not in BEFORE:
        extra -= 1  # tabs at the end of a row
    if extra not in BEFORE:
        text = f"has {len(rows[0][1])} cells where {width // 3} markers have {width} coordinates"
        raise UserError(Problem(text, name, rows[0][0]))
    return BEFORE[extra], rows


def _clock(
    stated: tuple[int, str], time: Array | None, frames: Array, rows: list[Line], name: str
) -> tuple[float | None, Array | None]:
    """The rate, Hz, and the times (n,) s where they are not the frames over it.

    The rate is None if an external trigger is the clock: the times stand alone, or are not written.
    """
    if stated[1].casefold().startswith(EXTERNAL.casefold()):
        if time is not None:
            require_increasing(time, "time", rows, name)
        return None, time
    rate = required_rate(stated[1], "FREQUENCY", stated[0], name)
    return rate, None if time is None else told_clock(time, frames, rate, rows, name)
