"""OpenSim: motion and storage files, ``.mot`` and ``.sto``: a header up to ``endheader``, then a table with its labels.

``inDegrees=yes|no`` states the unit of angles (OpenSim documentation, *Storage (.sto) Files*). OpenSim itself assumes
radians without it; older files are nevertheless often in degrees, so here it is required. OpenSense's files of sensors'
orientations (``DataType=Quaternion``) have four numbers w,x,y,z in a cell and need none.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from synth.errors import Problem, UserError
from synth.files.import_mapping import Mapping
from synth.files.paths import read_bytes
from synth.motion.importers.foreign_data import Channels, cut_off, states_otherwise
from synth.motion.importers.registry import loader, text_start, utf8

SIZE_LIMIT = 200_000_000  # bytes; the whole file is read into memory
_PARTS = ("w", "x", "y", "z")
HEADER_LIMIT = 500  # lines; real headers have about ten


def is_opensim(start: bytes, path: Path) -> bool:
    """Whether the file begins with an OpenSim header, complete or not."""
    lines = [line.strip().casefold() for line in text_start(start).splitlines()[:HEADER_LIMIT]]
    return "endheader" in lines or any(line.startswith("indegrees=") for line in lines)


@loader("opensim", "OpenSim .mot, .sto", is_opensim, "channels", own_clock=True)
def read_opensim(path: Path, mapping: Mapping, name: str) -> Channels:
    """All columns beside the clock, in the unit stated by the header.

    Raises
    ------
    UserError : no end of header, ``inDegrees`` neither yes nor no, vectors in cells, or a table cut off or uneven.
    """
    try:
        lines = utf8(read_bytes(path, SIZE_LIMIT, "cut it in OpenSim")).decode("utf-8-sig").splitlines()
    except UnicodeDecodeError:
        raise UserError(Problem("is not text; OpenSim writes .mot and .sto as text", name)) from None
    header, first = _header(lines, name)
    kind = header.get("datatype", "double")
    if kind.casefold() not in ("double", "quaternion"):
        text = f"has cells of type {kind}; one number per cell (double) and quaternions are supported"
        raise UserError(Problem(text, name))
    turns = kind.casefold() == "quaternion"
    in_degrees = not turns and _in_degrees(header, name)
    while first < len(lines) and not lines[first].strip():
        first += 1
    labels = _cells(lines[first]) if first < len(lines) else []
    if not labels or labels[0].casefold() != "time":
        raise UserError(Problem('has no row of labels that begins with "time" after endheader', name, first + 1))
    repeated = next((label for k, label in enumerate(labels) if label in labels[:k]), None)
    if repeated is not None:
        raise UserError(Problem(f'column "{repeated}" is given twice', name, first + 1))
    values = _table(lines, first + 1, labels, name, _PARTS if turns else ("",))
    for key, found, what in (("nrows", len(values), "rows"), ("ncolumns", len(labels), "columns")):
        messages = header.get(key, header.get(key.replace("n", "data", 1)))
        if states_otherwise(messages or "", found):
            raise UserError(cut_off(messages or "", found, what, name))
    unit = "deg" if in_degrees else "rad"
    if turns:
        names = tuple(f"{label} {part}" for label in labels[1:] for part in _PARTS)
        return Channels(name, names, ("",) * len(names), values[:, 1:], values[:, 0])
    note = f"inDegrees={'yes' if in_degrees else 'no'}: angles are read in {unit}"
    units = (unit,) * (len(labels) - 1)
    return Channels(name, tuple(labels[1:]), units, values[:, 1:], values[:, 0], (note,), units_fixed=True)


def _header(lines: list[str], name: str) -> tuple[dict[str, str], int]:
    """Keys and values of the header, keys in lower case, and the index of the line after it."""
    found: dict[str, str] = {}
    for index, line in enumerate(lines[:HEADER_LIMIT]):
        text = line.strip()
        if text.casefold() == "endheader":
            return found, index + 1
        key, equals, value = text.partition("=")
        if not equals:  # `datarows 153` of the older motion files
            key, _, value = text.partition(" ")
        if value.strip():
            found[key.strip().casefold()] = value.strip()
    raise UserError(Problem('has no line "endheader": it is not an OpenSim motion or storage file', name))


def _in_degrees(header: dict[str, str], name: str) -> bool:
    messages = header.get("indegrees")
    if messages is None:
        text = "its header does not state inDegrees, so its angles may be degrees or radians; write the line "
        text += '"inDegrees=yes" or "inDegrees=no" before "endheader"'
        raise UserError(Problem(text, name, key="inDegrees"))
    if messages.casefold() not in ("yes", "no"):
        raise UserError(Problem(f'"{messages}" is not allowed: write yes or no', name, key="inDegrees"))
    return messages.casefold() == "yes"


def _cells(line: str) -> list[str]:
    """A row's cells; labels may hold blanks where tabs separate them."""
    return [cell.strip() for cell in line.strip().split("\t")] if "\t" in line else line.split()


def _table(lines: list[str], first: int, labels: list[str], name: str, parts: Sequence[str]) -> np.ndarray:
    """(n, 1 + the labels' ``parts``); a cell has as many numbers, with commas between them."""
    rows = []
    for index in range(first, len(lines)):
        if not lines[index].strip():
            continue
        cells = lines[index].split()
        if len(cells) != len(labels):
            text = f"has {len(cells)} cells where there are {len(labels)} labels"
            raise UserError(Problem(text, name, index + 1))
        numbers = [number for cell in cells for number in cell.split(",")]
        if len(numbers) != 1 + len(parts) * (len(cells) - 1):
            text = f"has {len(numbers) - 1} numbers in {len(cells) - 1} cells, where each has {len(parts)}"
            raise UserError(Problem(text, name, index + 1))
        try:
            row = [float(number) for number in numbers]
        except ValueError as error:
            raise UserError(Problem(f"is not a number: {error}", name, index + 1)) from None
        rows.append(row)
    values = np.array(rows, dtype=np.float64).reshape(-1, 1 + len(parts) * (len(labels) - 1))
    return np.where(np.isfinite(values), values, np.nan)
