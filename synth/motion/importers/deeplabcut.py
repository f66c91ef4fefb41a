"""DeepLabCut: a CSV with three header rows (scorer, bodyparts, coords), or four where there are several animals.

Written by ``analyze_videos(..., save_as_csv=True)`` as pandas writes a table with column levels; x, y in pixels from
the picture's upper left corner, y downward, and the network's likelihood of each point (Mathis et al., *Nature
Neuroscience* 21 (2018) 1281). Lightning Pose writes the same; its ensemble Kalman smoother adds columns of medians and
variances (``x_ens_median``, ``x_posterior_var`` ...), which are not used: x and y are the smoothed position.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.csv_rows import csv_rows
from synth.files.import_mapping import Mapping
from synth.files.paths import read_bytes
from synth.files.validate import near
from synth.motion.importers.foreign_data import Markers, name_list
from synth.motion.importers.likelihood import USUAL, without_unlikely
from synth.motion.importers.registry import loader, text_start, utf8

SIZE_LIMIT = 400_000_000  # bytes: an hour at 200 Hz of 30 points
LEVELS = ("scorer", "individuals", "bodyparts", "coords")


def is_deeplabcut(start: bytes, path: Path) -> bool:
    """Whether the file begins with DeepLabCut's header."""
    lines = text_start(start).splitlines()[:4]
    heads = [line.partition(",")[0].strip() for line in lines]
    return heads[:1] == ["scorer"] and "coords" in heads


@loader("deeplabcut", "DeepLabCut CSV", is_deeplabcut, "points", keys=frozenset({"likelihood", "individual"}))
def read_deeplabcut(path: Path, mapping: Mapping, name: str) -> Markers:
    """Points of one animal, y turned upward, unlikely ones missing.

    Raises
    ------
    UserError : another header, manual labels, a cell that is not a number, or several animals without a choice.
    """
    data = utf8(read_bytes(path, SIZE_LIMIT, "cut the video"))
    rows = [row for _, row in csv_rows(data, name) if row]
    levels = [row[0].strip() for row in rows[:4] if row[0].strip() in LEVELS]
    if levels not in (list(LEVELS), [level for level in LEVELS if level != "individuals"]):
        text = "does not begin with DeepLabCut's header rows scorer, bodyparts, coords; "
        raise UserError(Problem(f"{text}write it with analyze_videos(..., save_as_csv=True)", name, 1))
    if len({len(row) for row in rows[: len(levels)]}) > 1:
        raise UserError(Problem("has header rows of different lengths", name, 1))
    header = {level: [cell.strip() for cell in rows[k][1:]] for k, level in enumerate(levels)}
    frames, values = _numbers(rows[len(levels) :], len(header["coords"]), len(levels), name)
    return markers_of(header, frames, values, mapping, name)


def markers_of(header: dict[str, list[str]], frames: Array, values: Array, mapping: Mapping, name: str) -> Markers:
    """Points of one animal from DeepLabCut's table.

    Parameters
    ----------
    header : level -> its label of each column of ``values`` (n, n_column).
    frames : (n,) frame numbers.
    """
    chosen = _individual(header, mapping.individual, name)
    columns = _columns(header, chosen, name)
    xy = [[places["x"], places["y"]] for places in columns.values()]
    positions = values[:, xy].reshape(len(frames), len(columns), 2)
    scores = values[:, [places["likelihood"] for places in columns.values()]]
    least = USUAL if mapping.likelihood is None else mapping.likelihood
    notes = without_unlikely(positions, scores, least, "likelihood", name)
    positions[..., 1] *= -1.0  # pixels count downward
    return Markers(name, tuple(columns), positions, frames, None, "pixel", notes)


def _individual(header: dict[str, list[str]], wanted: str | None, name: str) -> str | None:
    """The chosen animal."""
    animals = list(dict.fromkeys(header.get("individuals", [])))
    if wanted is not None and wanted not in animals:
        has = f"; the file has {name_list(animals)}" if animals else "; the file has one animal, leave `individual` out"
        raise UserError(Problem(f'there is no individual "{wanted}"{near(wanted, animals) or has}', name))
    if wanted is None and len(animals) > 1:
        text = (
            f"contains {len(animals)} animals; choose one: individual: {animals[0]}, or one of {name_list(animals[1:])}"
        )
        raise UserError(Problem(text, name))
    return wanted or (animals[0] if animals else None)


def _columns(header: dict[str, list[str]], individual: str | None, name: str) -> dict[str, dict[str, int]]:
    """Body part -> coordinate -> column of the numbers."""
    found: dict[str, dict[str, int]] = {}
    for index, (part, coordinate) in enumerate(zip(header["bodyparts"], header["coords"], strict=True)):
        if individual is None or header["individuals"][index] == individual:
            found.setdefault(part, {})[coordinate] = index
    for part, places in found.items():
        if "z" in places:
            raise UserError(Problem("contains points in space (x, y, z); save them as C3D", name, key=part))
        if not {"x", "y", "likelihood"} <= set(places):
            text = f"has the columns {name_list(places)} where x, y, likelihood are needed"
            if set(places) == {"x", "y"}:
                text = "has no likelihood: these are manual training labels, not a tracked video"
            raise UserError(Problem(text, name, key=part))
    return found


def _numbers(rows: list[list[str]], width: int, headers: int, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Frame numbers (n,) and cells (n, width), nan where empty."""
    values = np.full((len(rows), width + 1), np.nan)
    for k, row in enumerate(rows):
        line = k + headers + 1
        if len(row) != width + 1:
            raise UserError(Problem(f"has {len(row)} cells where the header has {width + 1}", name, line))
        for column, cell in enumerate(row):
            if cell.strip():
                try:
                    values[k, column] = float(cell)
                except ValueError:
                    what = "a frame's number" if column == 0 else "a number"
                    hint = "; are these manual training labels?" if column == 0 else ""
                    raise UserError(Problem(f'"{cell[:60]}" is not {what}{hint}', name, line)) from None
    if len(values) < 2:
        raise UserError(Problem("has no frames below its header", name))
    if not np.isfinite(values[:, 0]).all() or (np.diff(values[:, 0]) <= 0).any():
        raise UserError(Problem("has frames without a number, or not in order", name))
    return values[:, 0], np.where(np.isfinite(values[:, 1:]), values[:, 1:], np.nan)
