"""Anipose: triangulated points as CSV, columns ``NAME_x``, ``NAME_y``, ``NAME_z``, ``NAME_error``, ``NAME_score``.

Written by ``anipose triangulate`` (Karashchuk et al., *Cell Reports* 36 (2021) 109730), with ``fnum`` the frame's
number. The axes and the unit are those of the user's own calibration board.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from synth.errors import Problem, UserError
from synth.files.csv_rows import csv_rows
from synth.files.import_mapping import Mapping
from synth.files.paths import read_bytes
from synth.motion.importers.foreign_data import Markers
from synth.motion.importers.likelihood import without_unlikely
from synth.motion.importers.registry import loader, text_start, utf8

SIZE_LIMIT = 400_000_000  # bytes; the whole file is read into memory
_COLUMN = re.compile(r"(.+)_([xyz]|error|score|ncams)")
UP = "z"  # if no plane is given: Anipose's default axes have z up


def is_anipose(start: bytes, path: Path) -> bool:
    """Whether the first line has the three coordinates of a point and Anipose's further columns."""
    head = text_start(start).partition("\n")[0].split(",")
    parts = {match[1] for cell in head if (match := _COLUMN.fullmatch(cell.strip())) and match[2] == "ncams"}
    return any({f"{part}_{axis}" for axis in "xyz"} <= {cell.strip() for cell in head} for part in parts)


@loader("anipose", "Anipose CSV", is_anipose, "points", space=True, keys=frozenset({"likelihood"}))
def read_anipose(path: Path, mapping: Mapping, name: str) -> Markers:
    """Points in space; the file has no clock.

    Raises
    ------
    UserError : a cell that is not a number, or frames out of order.
    """
    rows = [row for _, row in csv_rows(utf8(read_bytes(path, SIZE_LIMIT, "cut the video")), name) if row]
    head = [cell.strip() for cell in rows[0]]
    if any(len(row) != len(head) for row in rows):
        raise UserError(Problem("has rows that differ in length from the header", name))
    try:
        values = np.array([[float(cell) if cell.strip() else np.nan for cell in row] for row in rows[1:]])
    except ValueError as error:
        raise UserError(Problem(f"has a cell that is not a number: {error}", name)) from None
    if len(values) < 2:
        raise UserError(Problem("has no frames below its header", name))
    parts = list(dict.fromkeys(match[1] for cell in head if (match := _COLUMN.fullmatch(cell)) and match[2] == "x"))
    missing = [f"{part}_{axis}" for part in parts for axis in "xyz" if f"{part}_{axis}" not in head]
    if missing:
        raise UserError(Problem(f"has no column {missing[0]}: a point in space has x, y and z", name, 1))
    positions = np.stack([values[:, [head.index(f"{part}_{axis}") for axis in "xyz"]] for part in parts], axis=1)
    scored = [head.index(f"{part}_score") for part in parts if f"{part}_score" in head]
    scores = values[:, scored] if len(scored) == len(parts) else None
    notes = without_unlikely(positions, scores, mapping.likelihood, "score", name)
    frames = values[:, head.index("fnum")] if "fnum" in head else np.arange(len(values), dtype=float)
    if not np.isfinite(frames).all() or (np.diff(frames) <= 0).any():
        raise UserError(Problem("has frames without a number, or not in order", name))
    return Markers(name, tuple(parts), positions, frames, None, "", notes, up=UP)
