"""Vicon Nexus: points in space as text, the section ``Trajectories`` of *File Export, Export ASCII*.

A section is its title, its rate in Hz, a row of names (each above the first of its columns), a row of columns
(``Frame``, ``Sub Frame``, X, Y, Z ...), a row of units, then a row a frame up to a blank line. Sections of events,
devices, joints and model outputs may stand before it. Vicon's z is up.
"""

from __future__ import annotations

from pathlib import Path

from synth.errors import Problem, UserError
from synth.files.csv_rows import separator_of
from synth.files.import_mapping import Mapping
from synth.motion.importers.foreign_data import Markers, name_list
from synth.motion.importers.marker_tables import (
    Line,
    column_numbers,
    points_at,
    require_frames,
    require_points,
    required_rate,
    table_lines,
    table_text,
)
from synth.motion.importers.registry import loader, text_start

WANTED = "Trajectories"
UP = "z"
LENGTHS = ("mm", "cm", "m", "in")  # of positions; velocities and accelerations stand in the same section
HEADER = 5  # rows of a section above its frames
EXPORT = "export it with File Export, Export ASCII, with Trajectories chosen"


def is_vicon(start: bytes, path: Path) -> bool:
    """Whether the second line is a rate alone, and a later one begins with a section's columns of frames."""
    lines = [line.strip().strip(",;\t") for line in text_start(start).splitlines() if line.strip()]
    if len(lines) < 4 or not lines[1].replace(".", "", 1).replace(",", "", 1).isdigit():
        return False
    return any(line.split(separator_of(line))[:2] == ["Frame", "Sub Frame"] for line in lines[3:])


@loader("vicon", "Vicon Nexus CSV", is_vicon, "points", space=True)
def read_vicon(path: Path, mapping: Mapping, name: str) -> Markers:
    """Points in space with the file's own rate; empty cells are unseen points.

    Raises
    ------
    UserError : there is no section of trajectories, no rate, no point, a cell that is no number; frames out of order.
    """
    text = table_text(path)
    separator = separator_of(next((line for line in text.splitlines() if "Sub Frame" in line), ""))
    section = _section(table_lines(text, name, separator), name)
    (rate_line, rate_cells), (_, names), (_, axes), (_, units) = section[1:HEADER]
    rate = required_rate(rate_cells[0], "second line of Trajectories", rate_line, name)
    starts = [c for c in range(2, len(axes) - 2) if axes[c : c + 3] == ["X", "Y", "Z"]
              and c < len(names) and names[c] and c < len(units) and units[c] in LENGTHS]  # fmt: skip
    points = [names[c] for c in starts]
    require_points(points, EXPORT, name)
    rows = section[HEADER:]
    frames = column_numbers(rows, [0], separator, name)[:, 0]
    require_frames(rows, frames, None, name)
    positions = points_at(rows, starts, separator, name)
    return Markers(name, tuple(points), positions, frames, rate, units[starts[0]], up=UP)


def _section(lines: list[Line], name: str) -> list[Line]:
    """The rows of the trajectories, title and header included, without the blank line at their end."""
    filled = [any(row) for _, row in lines]
    titles = [
        k for k in range(len(lines) - 3) if filled[k] and not (k and filled[k - 1]) and "Frame" in lines[k + 3][1]
    ]
    found = [k for k in titles if lines[k][1][0] == WANTED]
    if not found:
        has = name_list(lines[k][1][0] for k in titles)
        raise UserError(Problem(f"has no section {WANTED} but {has}: {EXPORT}", name))
    if len(found) > 1:
        raise UserError(Problem(f"has the section {WANTED} twice; export one trial a file", name, lines[found[1]][0]))
    start = found[0]
    end = next((k for k in range(start + HEADER, len(lines)) if not filled[k]), len(lines))
    if end - start <= HEADER:
        raise UserError(Problem("has no frames below its header", name, lines[start][0]))
    return lines[start:end]
