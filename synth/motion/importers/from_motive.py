"""OptiTrack Motive: points in space as CSV, written by *Export Tracking Data*.

The first line has settings, each name before its value (``Format Version``, ``Export Frame Rate``, ``Length Units``
...). Above the row ``Frame``, ``Time (Seconds)``, X, Y, Z ... each column has its type, its name and its ID, in newer
versions its parent, and last its quantity: Position, Rotation, an error (OptiTrack documentation, *Data Export: CSV*).
Of markers of a rigid body both the measured and the expected position may be there; the latter goes on where the marker
is hidden. Motive's y is up, unless the export turns its axes.
"""

from __future__ import annotations

import itertools
from pathlib import Path

from synth.errors import Problem, UserError
from synth.files.import_mapping import Mapping
from synth.motion.importers.foreign_data import Markers
from synth.motion.importers.marker_tables import (
    Line,
    column_numbers,
    points_at,
    require_frames,
    require_points,
    required_rate,
    table_lines,
    table_text,
    told_clock,
)
from synth.motion.importers.registry import loader, text_start

UP = "y"
MEASURED = ("Marker",)
SOLVED = ("Rigid Body", "Bone")  # of several markers; in the parent's axes if the coordinate space is Local
EXPORT = "export it with Markers on"
UNITS = {"Millimeters": "mm", "Centimeters": "cm", "Meters": "m"}


def is_motive(start: bytes, path: Path) -> bool:
    """Whether the first line is Motive's."""
    line = text_start(start).lstrip().partition("\n")[0]
    return line.startswith("Format Version,") and ("Take Name" in line or "Frame Rate" in line)


@loader("motive", "OptiTrack Motive CSV", is_motive, "points", space=True)
def read_motive(path: Path, mapping: Mapping, name: str) -> Markers:
    """Points in space with the file's own clock; empty cells are unseen points.

    Raises
    ------
    UserError : an invalid header, fewer frames than it states, no measured point, a cell that is no number, frames out
        of order, or a rate that contradicts the times.
    """
    lines = [each for each in table_lines(table_text(path), name, ",") if any(each[1])]
    at = next((k for k, (_, row) in enumerate(lines) if row[:1] == ["Frame"]), None)
    if at is None or at < 4 or not lines[at][1][1:2] or not lines[at][1][1].startswith("Time"):
        raise UserError(
            Problem('has no row of columns that begins "Frame,Time (Seconds)"; export it with header', name)
        )
    first = lines[0][1]
    settings = dict(itertools.pairwise(first))  # a comma in the take's notes shifts all that follows it
    starts, points, notes = _points(lines[1 : at + 1], settings.get("Coordinate Space", "Global"))
    require_points(points, f"{EXPORT}{''.join(f' ({note})' for note in notes)}", name)
    rows = lines[at + 1 :]
    frames, time = column_numbers(rows, [0, 1], ",", name).T
    stated = settings.get("Total Exported Frames", "")
    require_frames(rows, frames, int(stated) if stated.isascii() and stated.isdigit() else None, name)
    told = settings.get("Export Frame Rate") or settings.get("Capture Frame Rate", "")
    rate = required_rate(told, "Export Frame Rate", 1, name)
    clock = told_clock(time, frames, rate, rows, name)
    positions = points_at(rows, starts, ",", name)
    unit = UNITS.get(settings.get("Length Units", ""), "")
    return Markers(name, tuple(points), positions, frames, rate, unit, notes, up=UP, time=clock)


def _points(header: list[Line], space: str) -> tuple[list[int], list[str], tuple[str, ...]]:
    """First columns and names of the points, and notes; ``header`` : types, names, ..., quantities, axes."""
    width = len(header[-1][1])
    types, names, *_, quantities, axes = ((row + [""] * width)[:width] for _, row in header)
    used = MEASURED + (SOLVED if space == "Global" else ())
    starts, expected = [], 0
    for c in range(2, len(axes) - 2):
        if axes[c : c + 3] != ["X", "Y", "Z"] or quantities[c : c + 3] != ["Position"] * 3:
            continue
        starts += [c] if types[c] in used else []
        expected += types[c] not in (*MEASURED, *SOLVED)
    text = f"{expected} expected positions of markers are not used: they go on where a marker is hidden"
    return starts, [names[c] for c in starts], (text,) if expected else ()
