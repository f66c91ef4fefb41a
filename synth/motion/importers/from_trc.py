"""TRC: points in space as text, written by Motion Analysis' systems, OpenSim and Pose2Sim.

Three lines of header (``PathFileType``, names of settings, settings), two of labels (markers, X1 Y1 Z1 ...), then a row
a frame: number, time, coordinates (OpenSim documentation, *Marker (.trc) Files*). OpenSim's y is up.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from synth.errors import Problem, UserError
from synth.files.import_project import Mapping
from synth.files.paths import read_bytes
from synth.motion.importers.foreign_data import Markers
from synth.motion.importers.registry import loader, text_start

SIZE_LIMIT = 400_000_000  # bytes; the whole file is read into memory
UP = "y"


def is_trc(start: bytes, path: Path) -> bool:
    """Whether the first line is TRC's."""
    return text_start(start).startswith("PathFileType")


@loader("trc", "TRC", is_trc, "points", space=True)
def read_trc(path: Path, mapping: Mapping, name: str) -> Markers:
    """Points in space with the file's own rate.

    Raises
    ------
    UserError : an invalid header, a wrong number of markers, or a cell that is not a number.
    """
    lines = text_start(read_bytes(path, SIZE_LIMIT, "cut it in the capture software")).splitlines()
    if len(lines) < 7:
        raise UserError(Problem("ends within its header", name, len(lines)))
    settings = dict(zip(lines[1].split("\t"), lines[2].split("\t"), strict=False))
    rate, count = _number(settings.get("DataRate"), "DataRate", name), settings.get("NumMarkers", "").strip()
    labels = [cell.strip() for cell in lines[3].rstrip("\r\n\t ").split("\t")]
    names = [label for label in labels[2:] if label]
    if labels[:1] != ["Frame#"] or not names:
        raise UserError(Problem('has no row of markers that begins with "Frame#"', name, 4))
    if count.isdigit() and int(count) != len(names):
        raise UserError(Problem(f"states {count} markers but names {len(names)}", name, 4))
    rows, numbers = [], []
    for number, line in enumerate(lines[5:], start=6):
        if not line.strip():
            continue
        cells = line.rstrip("\r\n").split("\t")
        rows.append((cells + [""] * (2 + 3 * len(names)))[: 2 + 3 * len(names)])
        numbers.append(number)
    values = np.full((len(rows), 2 + 3 * len(names)), np.nan)
    for k, row in enumerate(rows):
        for c, cell in enumerate(row):
            if cell.strip():
                try:
                    values[k, c] = float(cell)
                except ValueError:
                    raise UserError(Problem(f'"{cell[:40]}" is not a number', name, numbers[k])) from None
    if len(values) < 2 or not np.isfinite(values[:, 0]).all() or (np.diff(values[:, 0]) <= 0).any():
        raise UserError(Problem("has frames without a number, or not in order", name))
    positions = values[:, 2:].reshape(len(values), len(names), 3).copy()
    unit = settings.get("Units", "").strip()
    return Markers(name, tuple(names), positions, values[:, 0], rate, unit, (), up=UP)


def _number(text: str | None, what: str, name: str) -> float:
    try:
        value = float(text or "")
    except ValueError:
        value = 0.0
    if not 0.0 < value < 1e6:
        raise UserError(Problem(f'states no {what} above 0 in its third line: "{text}"', name, 3))
    return value
