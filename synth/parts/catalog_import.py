"""Conversion of a vendor's table into catalogue files, one per vendor, in the catalogue's columns and units.

A column is identified by its header (``headers``) or by the user's mapping (``THEIRS=OURS``, ``THEIRS=OURS [unit]``).
Its unit is in the header, in the mapping, or in each cell (``0.08 in``, ``2 mm``); inch and metric may be mixed.
Unknown columns are left out and reported.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import Field, dataclass
from pathlib import Path
from typing import Any

from synth.errors import Problem, UserError
from synth.files.csv_rows import csv_rows
from synth.files.paths import read_bytes
from synth.parts.catalog_table import MAX_BYTES
from synth.parts.headers import standard, standard_value
from synth.parts.rows import FAMILIES, CatalogueRow
from synth.units import factor, parse

IMPORTED = ("torsion_springs", "dampers")  # families whose tables vendors sell from


@dataclass(frozen=True)
class ImportedParts:
    """Rows by vendor as cells under ``header``.

    ``used`` : which column became which; ``unused`` : columns left out.
    """

    family: str
    header: tuple[str, ...]
    rows: Mapping[str, tuple[tuple[str, ...], ...]]
    used: tuple[tuple[str, str], ...]
    unused: tuple[str, ...]


@dataclass(frozen=True)
class _SheetColumn:
    index: int
    title: str
    field: Field[Any]
    unit: str | None  # of the column; None where each cell carries its own

    @property
    def header(self) -> str:
        shown = self.field.metadata.get("shown")
        return self.field.name if self.field.metadata["unit"] is None else f"{self.field.name} [{shown}]"


def import_table(path: Path, mapping: Mapping[str, str], vendor: str | None = None) -> ImportedParts:
    """Read a vendor's table.

    Parameters
    ----------
    mapping
        their header to our column, with a unit where theirs has none.
    vendor
        of rows without one.

    Raises
    ------
    UserError : the file or its headers cannot be read, with every bad cell and its line.
    """
    name = str(path)
    data = read_bytes(path, MAX_BYTES, "no vendor's table is so large")
    lines = [(line, cells) for line, cells in csv_rows(data, name) if any(cells)]
    if len(lines) < 2:
        raise UserError(Problem("contains no rows; the first line must have the headers", name))
    titles = [title.strip() for title in lines[0][1]]
    family, columns, unused = _matched(titles, mapping, name)
    if vendor is None and not any(column.field.name == "vendor" for column in columns):
        raise UserError(Problem("no column names the vendor; give it with --vendor NAME", name, line=1))
    rows, problems = defaultdict[str, list[tuple[str, ...]]](list), []
    for line, cells in lines[1:]:
        try:
            made = [_cell(cells[c.index] if c.index < len(cells) else "", c) for c in columns]
        except (ValueError, UserError) as error:
            problems.append(Problem(str(error), name, line=line))
            continue
        at = next((k for k, c in enumerate(columns) if c.field.name == "vendor"), None)
        seller = (made[at] if at is not None else "") or vendor or ""
        if at is None:
            made = [*made, seller]
        else:
            made[at] = seller
        rows[seller or "unknown vendor"].append(tuple(made))
    if problems:
        raise UserError(problems)
    header = tuple(column.header for column in columns)
    header = header if "vendor" in header else (*header, "vendor")
    used = tuple((column.title, column.header) for column in columns)
    return ImportedParts(family, header, {key: tuple(value) for key, value in rows.items()}, used, tuple(unused))


def _matched(titles: Sequence[str], mapping: Mapping[str, str], name: str) -> tuple[str, list[_SheetColumn], list[str]]:
    """The family that most columns fit, these columns, and the other titles."""
    mapped = {theirs.casefold(): ours for theirs, ours in mapping.items()}
    missing = [theirs for theirs in mapping if theirs.casefold() not in {title.casefold() for title in titles}]
    if missing:
        text = f"no column is called {' or '.join(missing)}; there are {', '.join(titles)}"
        raise UserError(Problem(text, name, line=1, key="--map"))
    best: tuple[str, list[_SheetColumn], list[str]] | None = None
    for family in IMPORTED:
        columns, unused = _columns(titles, mapped, FAMILIES[family])
        names = {column.field.name for column in columns}
        if "part" in names and (best is None or len(columns) > len(best[1])):
            best = family, columns, unused
    if best is None or len(best[1]) < 3:
        text = "is not a table of torsion springs or dampers: it needs a part number and two more known columns; "
        raise UserError(Problem(text + "identify them with --map 'THEIRS=OURS [unit]'", name, line=1))
    for column in best[1]:
        if column.unit is not None:
            factor(column.unit, column.field.metadata["unit"])  # raises with what is allowed
    return best


def _columns(
    titles: Sequence[str], mapped: Mapping[str, str], row: type[CatalogueRow]
) -> tuple[list[_SheetColumn], list[str]]:
    known = {item.name: item for item in row.columns()}
    columns: list[_SheetColumn] = []
    unused = []
    for index, title in enumerate(titles):
        ours = mapped.get(title.casefold()) or standard(title, frozenset(known))
        bare, _, unit = ours.partition("[")
        bare = bare.strip().casefold().replace(" ", "_")
        bare = "max_torque" if bare == "torque" and "max_torque" in known else bare
        if bare not in known or any(column.field.name == bare for column in columns):
            unused.append(title)
            continue
        item = known[bare]
        columns.append(_SheetColumn(index, title, item, unit.rstrip("] ").strip() or None))
    return columns, unused


def _cell(text: str, column: _SheetColumn) -> str:
    """A cell in the catalogue's unit; ValueError with the column if it is not such a quantity."""
    text = text.strip()
    rules = column.field.metadata
    if not text or rules["unit"] is None:
        return standard_value(column.field.name, text)
    canonical, shown = rules["unit"], rules["shown"]
    try:
        if column.unit is not None:
            value = float(text) * factor(column.unit, canonical)
        elif canonical == "1":
            value = float(text)
        else:
            value = parse(text, canonical)
    except (ValueError, UserError) as error:
        raise ValueError(f"{column.title}: {error}") from None
    scale = 1.0 if canonical == shown or canonical == "degC" else factor(shown, canonical)
    return f"{value / scale:.10g}"


def file_name(vendor: str) -> str:
    """``lee_spring.csv`` for ``Lee Spring``."""
    kept = "".join(c if c.isalnum() else "_" for c in vendor.casefold())
    return f"{kept.strip('_') or 'vendor'}.csv"
