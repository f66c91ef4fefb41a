"""Points in the columns of a CSV, an x and a y each, as spreadsheets, DLTdv and scripts around pose estimators write.

Named hip_x, "hip X [mm]", hipX, x_hip or x1, or x below hip in a row of its own; also with a z. Only the project's
``points`` tell such a file from one of angles, whose columns may be named alike.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.import_mapping import Mapping
from synth.motion.importers.channel_clock import channel_clock
from synth.motion.importers.foreign_data import Channels, Markers, name_list
from synth.motion.importers.likelihood import SCORES, without_unlikely
from synth.motion.importers.plain_csv import csv_channels, is_table
from synth.motion.importers.registry import loader
from synth.motion.importers.repeated_rows import without_repeated_rows

_UNIT = re.compile(r"\s*[\[(]\s*([^\[\]()]*?)\s*[\])]\s*")  # behind the name
_AFTER = re.compile(rf"(?P<name>.*[^\s_./:-])[\s_./:-]+(?P<part>[xyz]|{'|'.join(SCORES)})", re.IGNORECASE)
_CAPITAL = re.compile(r"(?P<name>.*[a-z0-9])(?P<part>[XYZ])")
_BEFORE = re.compile(r"(?P<part>[xyz])(?:[\s_./:-]+(?P<name>.+)|(?P<number>\d+))", re.IGNORECASE)

ALONE = "point"  # the name of the only point, where the columns are x and y
FRACTIONS = (
    "its coordinates lie between 0 and 1 and have no unit: fractions of the picture's width and height, as MediaPipe "
    "gives them, make wrong angles unless the picture is square. Multiply x by the width and y by the height in pixels"
)


@loader(
    "csv-points", "CSV with a point's x and y in columns", is_table, "points",
    space=True, last=True, keys=frozenset({"time", "likelihood"}),
)  # fmt: skip
def read_point_columns(path: Path, mapping: Mapping, name: str) -> Markers:
    """Points in a plane, or in space where each has a z; the clock is found as in a file of channels.

    Raises
    ------
    UserError : no point has an x and a y, units differ, there is no clock, or it is not said whether y is upward.
    """
    source = csv_channels(path, name)
    parts, unit_of = _parts(source.names)
    points = _points(parts)
    if not points:
        text = "has no x and y of a point in its columns, such as hip_x and hip_y; it has "
        raise UserError(Problem(text + name_list(source.names), name, key="points"))
    axes = "xyz" if all("z" in parts[point] for point in points) else "xy"
    if axes == "xy" and mapping.plane is None:
        text = (
            "say which way y counts: plane: [x, y] upward (--plane=x,y), [x, -y] downward, as pixels from the top of "
        )
        raise UserError(Problem(f"{text}a picture (--plane=x,-y)", name, key="plane"))
    units = list(dict.fromkeys(unit_of[parts[point][axis]] for point in points for axis in axes))
    if len(units) > 1:
        text = f"its points are in different units: {', '.join(unit or 'none' for unit in units)}; write them in one"
        raise UserError(Problem(text, name))
    notes = list(source.notes)
    source, clock = without_repeated_rows(source, channel_clock(source, mapping, notes), notes)
    positions = np.stack([source.values[:, [parts[point][axis] for axis in axes]] for point in points], axis=1)
    scores, word = _scores(source, parts, points)
    if not units[0] and _may_be_fractions(positions):
        notes.append(FRACTIONS)
    notes += without_unlikely(positions, scores, mapping.likelihood, word, name)
    return Markers(
        name, tuple(points), positions, np.arange(len(positions), dtype=float), None, units[0], tuple(notes),
        time=clock.time + clock.begins, picture=("x", "y") if axes == "xy" else None,
    )  # fmt: skip


def points_in_columns(names: Sequence[str]) -> list[str]:
    """The names of the points that have an x and a y among columns of these names."""
    return _points(_parts(names)[0])


def _parts(names: Sequence[str]) -> tuple[dict[str, dict[str, int]], list[str]]:
    """Each point's columns by part: x, y, z or a word of ``SCORES``; and the unit behind each column's name."""
    found: dict[str, dict[str, int]] = {}
    units = []
    for index, title in enumerate(names):
        behind = _UNIT.search(title)
        last = behind is not None and behind.end() == len(title)
        units.append(behind[1] if last and behind is not None else "")
        plain = title[: behind.start()] if last and behind is not None else title
        if plain.strip().casefold() in ("x", "y", "z"):  # of the only point, which has no name
            found.setdefault(ALONE, {}).setdefault(plain.strip().casefold(), index)
            continue
        match = _AFTER.fullmatch(plain) or _CAPITAL.fullmatch(plain) or _BEFORE.fullmatch(plain)
        if match:
            given = match.groupdict()
            point = given["name"] or given.get("number") or ""
            found.setdefault(point, {}).setdefault(match["part"].casefold(), index)
    return found, units


def _points(parts: dict[str, dict[str, int]]) -> list[str]:
    return [point for point, columns in parts.items() if {"x", "y"} <= columns.keys()]


def _may_be_fractions(positions: Array) -> bool:
    """Whether coordinates (n, n_point, n_axis) may be shares of a picture's sides: 98 of 100 lie between 0 and 1."""
    least, most = np.nanpercentile(positions, [1.0, 99.0])
    return bool(least >= 0.0 and most <= 1.0)


def _scores(source: Channels, parts: dict[str, dict[str, int]], points: list[str]) -> tuple[np.ndarray | None, str]:
    """(n, n_point) the tracker's own scores, None if not every point has them; and what the file calls them."""
    for word in SCORES:
        if all(word in parts[point] for point in points):
            return source.values[:, [parts[point][word] for point in points]], word
    return None, SCORES[0]
