"""Tables of points in space that motion capture systems write as text: their rows, cells and clock."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.csv_rows import csv_rows, pointed
from synth.files.paths import read_bytes
from synth.motion.importers.foreign_data import MISSING, cut_off
from synth.motion.importers.registry import text_start

SIZE_LIMIT = 400_000_000  # bytes; the whole file is read into memory
SAME_RATE = 5e-3  # relative; 60 Hz is also written for the 59.94 Hz of NTSC video, a difference of 1e-3
ROUNDING = 1e-5  # s, of written times: Qualisys writes five decimals, Motive six
Line = tuple[int, list[str]]


def table_text(path: Path) -> str:
    """The whole file as text.

    Raises
    ------
    UserError : it cannot be read, or is too large.
    """
    return text_start(read_bytes(path, SIZE_LIMIT, "cut it in the capture software"))


def table_lines(text: str, name: str, separator: str) -> list[Line]:
    """(line, cells without blanks around them) of every row of a text, those of blank lines too."""
    return [(line, [cell.strip() for cell in row]) for line, row in csv_rows(text, name, separator=separator)]


def points_at(lines: Sequence[Line], starts: Sequence[int], separator: str, name: str) -> Array:
    """(n, n_point, 3) of rows whose points begin at the columns ``starts``; nan where a cell is empty."""
    columns = [start + axis for start in starts for axis in range(3)]
    return column_numbers(lines, columns, separator, name).reshape(len(lines), len(starts), 3)


def column_numbers(lines: Sequence[Line], columns: Sequence[int], separator: str, name: str) -> Array:
    """(n, n_column) of the rows' cells; nan where one is empty, a word for that, or missing.

    Raises
    ------
    UserError : a cell that is not a number, with its line.
    """
    values = np.full((len(lines), len(columns)), np.nan)
    for k, (line, row) in enumerate(lines):
        for c, column in enumerate(columns):
            cell = row[column] if column < len(row) else ""
            if cell.casefold() not in MISSING:
                try:
                    values[k, c] = float(pointed(cell, separator))
                except ValueError:
                    raise UserError(Problem(f'"{cell[:40]}" is not a number', name, line)) from None
    return np.where(np.isfinite(values), values, np.nan)


def without_zeros(positions: Array) -> str:
    """Make points (n, n_point, 3) at 0, 0, 0 exactly, as unseen ones are written, missing; a note, empty if none."""
    unseen = (positions == 0.0).all(axis=2)
    positions[unseen] = np.nan
    return f"{int(unseen.sum())} points at 0, 0, 0 are unseen ones: missing" if unseen.any() else ""


def require_frames(lines: Sequence[Line], frames: Array, stated: int | None, name: str) -> None:
    """Refuse rows that are fewer than ``stated`` or two, or whose numbers (n,) do not count up.

    Raises
    ------
    UserError : with the line, where it is one row.
    """
    if stated is not None and len(lines) < stated:
        raise UserError(cut_off(stated, len(lines), "frames", name))
    if len(lines) < 2:
        raise UserError(Problem("has no frames below its header", name))
    require_increasing(frames, "frame number", lines, name)


def require_increasing(values: Array, what: str, lines: Sequence[Line], name: str) -> None:
    """Refuse values (n,) of the rows that are missing or not above the row before.

    Raises
    ------
    UserError : with the line.
    """
    wrong = ~np.isfinite(values) | (np.diff(values, prepend=-np.inf) <= 0)
    if wrong.any():
        text = f"has no {what}, or none after that of the row before; export it again"
        raise UserError(Problem(text, name, lines[int(np.argmax(wrong))][0]))


def told_clock(time: Array, frames: Array, rate: float, lines: Sequence[Line], name: str) -> Array | None:
    """The times (n,) s, None where they are the frames (n,) over the rate, Hz, but for rounding.

    Raises
    ------
    UserError : times that are missing or do not increase, or that contradict the rate.
    """
    require_increasing(time, "time", lines, name)
    if (np.abs((frames - frames[0]) / rate - (time - time[0])) <= ROUNDING).all():
        return None
    rows = (len(time) - 1) / (time[-1] - time[0])
    paces = (float(np.median(1.0 / np.diff(time))), rows, (frames[-1] - frames[0]) / (time[-1] - time[0]))
    if all(abs(pace / rate - 1.0) >= SAME_RATE for pace in paces):
        text = f"has two clocks: its times have {rows:.5g} rows a second, and its header says {rate:g} Hz; correct the "
        raise UserError(Problem(f"{text}wrong one, or export it again", name))
    return time


def require_points(names: Sequence[str], what: str, name: str) -> None:
    """Refuse a file without points; ``what`` : how to export them."""
    if not names:
        raise UserError(Problem(f"has no positions of markers: {what}", name))


def required_rate(text: str, what: str, line: int, name: str) -> float:
    """The rate that a header states, Hz; ``what`` : its name there.

    Raises
    ------
    UserError : it is no number above 0.
    """
    try:
        rate = float(text.replace(",", "."))
    except ValueError:
        rate = 0.0
    if not 0.0 < rate < 1e6:
        raise UserError(Problem(f'states no rate above 0 as its {what}: "{text[:40]}"', name, line))
    return rate
