"""Conversion of a vendor's table into catalogue files, one per vendor, in the catalogue's columns and units.

A column is identified by its header (``headers``) or by the user's mapping (``THEIRS=OURS``, ``THEIRS=OURS [unit]``).
Its unit is in the header, in the mapping, or in each cell (``0.08 in``, ``2 mm``); inch and metric may be mixed.
Unknown columns are left out and reported. Semicolons or tabs may separate the columns; decimals may then take a comma.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import Field, dataclass, replace
from math import isclose
from pathlib import Path
from typing import Any

from synth.errors import Problem, UserError
from synth.files.csv_rows import csv_rows, refuse_no_text, separator_of
from synth.files.names import NAME_LENGTH, title_fault
from synth.files.paths import read_bytes
from synth.files.validate import near
from synth.parts.catalog_cells import currency_of, number_cell, require_allowed, scale_of, text_cell
from synth.parts.catalog_table import MAX_BYTES, MAX_PROBLEMS
from synth.parts.catalogue_row import CatalogueRow
from synth.parts.headers import standard, unit_in
from synth.parts.rows import FAMILIES
from synth.units import factor, parse
from synth.units_spelling import plain_signs, read_number

_DECIMAL_COMMA = re.compile(r"^(\s*[^\d,.]{0,3}\d+),(\d+)(?![\d,.])")  # 3,2 and 0,08 in and $ 12,50
IMPORTED = ("torsion_springs", "dampers")  # families whose tables vendors sell from


@dataclass(frozen=True)
class ImportedParts:
    """Rows by the name of their vendor's file, as cells under ``header``.

    ``lines`` : of the rows in the vendor's table; ``used`` : which column became which; ``unused`` : columns left out.
    """

    family: str
    header: tuple[str, ...]
    rows: Mapping[str, tuple[tuple[str, ...], ...]]
    lines: Mapping[str, tuple[int, ...]]
    used: tuple[tuple[str, str], ...]
    unused: tuple[str, ...]

    def columns(self, file: str) -> dict[str, list[str | float | None]]:
        """The columns of one file: numbers under headers with a unit, so that -5 is written as a number; else words."""
        found: dict[str, list[str | float | None]] = {}
        for k, title in enumerate(self.header):
            cells = [row[k] for row in self.rows[file]]
            found[title] = [float(cell) if cell else None for cell in cells] if "[" in title else [*cells]
        return found


@dataclass(frozen=True)
class _SheetColumn:
    """``unit``: of the column, None where each cell carries its own; ``scale``: its factor to SI."""

    index: int
    title: str
    field: Field[Any]
    unit: str | None
    scale: float = 1.0
    currency: str = ""

    @property
    def header(self) -> str:
        """In the catalogue's words; a price carries its currency in each cell."""
        shown = self.field.metadata.get("shown")
        return self.field.name if self.field.metadata["unit"] is None else f"{self.field.name} [{shown}]"


def import_table(path: Path, mapping: Mapping[str, str], vendor: str | None = None) -> ImportedParts:
    """Read a vendor's table.

    Parameters
    ----------
    mapping
        their header to our column, with a unit where theirs has none; another unit than theirs is refused.
    vendor
        of rows without one.

    Raises
    ------
    UserError : the file or its headers cannot be read, with every bad cell and its line.
    """
    name = str(path)
    if vendor is not None and (fault := title_fault(vendor)) is not None:
        raise UserError(Problem(f'"{vendor}" {fault}', key="--vendor"))
    data = read_bytes(path, MAX_BYTES, "no vendor's table is so large")
    refuse_no_text(data, name)
    separator = separator_of(data.decode("utf-8-sig").lstrip().partition("\n")[0])
    found = csv_rows(data, name, separator=separator)
    lines = [(line, cells) for line, cells in found if any(cell.strip() for cell in cells)]
    if len(lines) < 2:
        raise UserError(Problem("contains no rows; the first line must have the headers", name))
    titles = [title.strip() for title in lines[0][1]]
    family, columns, unused = _match_family(titles, mapping, name)
    if vendor is None and not any(column.field.name == "vendor" for column in columns):
        raise UserError(Problem("no column names the vendor; give it with --vendor NAME", name, line=1))
    pointed = [(line, _pointed_cells(cells, columns, separator)) for line, cells in lines[1:]]
    rows = _rows(pointed, columns, len(titles), name, vendor or "")
    header = tuple(column.header for column in columns)
    header = header if "vendor" in header else (*header, "vendor")
    files = defaultdict[str, list[_SheetRow]](list)
    for row in rows:
        files[file_name(row.vendor)].append(row)
    return ImportedParts(
        family,
        header,
        {file: tuple(row.cells for row in held) for file, held in files.items()},
        {file: tuple(row.line for row in held) for file, held in files.items()},
        tuple((column.title, column.header) for column in columns),
        tuple(unused),
    )


def _pointed_cells(cells: list[str], columns: Sequence[_SheetColumn], separator: str) -> list[str]:
    """The cells of a line with points for the decimals of its numbers and prices; words keep their commas."""
    if separator == ",":
        return cells
    numbers = {column.index for column in columns if _is_number(column.field)}
    return [_DECIMAL_COMMA.sub(r"\1.\2", cell) if k in numbers else cell for k, cell in enumerate(cells)]


def _is_number(item: Field[Any]) -> bool:
    return item.metadata["unit"] is not None or bool(item.metadata.get("currency"))


@dataclass(frozen=True)
class _SheetRow:
    """Cells in the catalogue's words and units, the vendor among them, and the line in the vendor's table."""

    cells: tuple[str, ...]
    vendor: str
    line: int


def _rows(
    lines: Sequence[tuple[int, list[str]]], columns: Sequence[_SheetColumn], width: int, name: str, vendor: str
) -> list[_SheetRow]:
    """All rows; ``width``: cells of each; ``vendor``: of those that name none.

    UserError with every bad cell and every part that stands twice.
    """
    at = {column.field.name: k for k, column in enumerate(columns)}
    rows: list[_SheetRow] = []
    problems: list[Problem] = []
    seen: dict[tuple[str, str], int] = {}
    made: list[str]
    for line, cells in lines:
        if len(cells) != width:  # they may be shifted, also by one that is empty
            text = f"has {len(cells)} cells where the header has {width}; decimals take a point, and a cell with a "
            made, bad = [], [Problem(text + "comma (or what separates) stands in quotes", name, line)]
        else:
            made, bad = _convert_cells(cells, columns, name, line)
        problems += bad
        if len(problems) > MAX_PROBLEMS:
            text = "more mistakes follow; the rest of the table was not read"
            raise UserError([*problems, Problem(text, name, line=line)])
        if bad:
            continue
        seller = (made[at["vendor"]] if "vendor" in at else "") or vendor
        if "vendor" in at:
            made[at["vendor"]] = seller
        else:
            made.append(seller)
        part, title = made[at["part"]], columns[at["part"]].title
        first = seen.setdefault((seller.casefold(), part.casefold()), line)
        if not part:
            problems.append(Problem("is empty; write the part's number, or take the row out", name, line, title))
        elif first != line:
            text = f"{seller} {part}".strip() + f" is given twice in this table, first in line {first}"
            problems.append(Problem(text, name, line, title))
        rows.append(_SheetRow(tuple(made), seller, line))
    if problems:
        raise UserError(problems)
    return rows


def _convert_cells(
    cells: Sequence[str], columns: Sequence[_SheetColumn], name: str, line: int
) -> tuple[list[str], list[Problem]]:
    """The cells of a row in the catalogue's words and units, and the mistakes of those that cannot be read."""
    made: list[str] = []
    problems: list[Problem] = []
    for column in columns:
        try:
            made.append(_cell(cells[column.index].strip(), column))
        except (ValueError, UserError) as error:
            problems.append(Problem(str(error), name, line, column.title))
    return made, problems


def _match_family(
    titles: Sequence[str], mapping: Mapping[str, str], name: str
) -> tuple[str, list[_SheetColumn], list[str]]:
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
    family, found, unused = best
    problems = _unmapped_problems(mapping, found, family, name)
    for k, matched in enumerate(found):
        try:
            column = _with_own_unit(matched)
        except UserError as error:
            problems.append(Problem(str(error), name, line=1, key="--map"))
            continue
        title = column.field.name if column.unit is None else f"{column.field.name} [{column.unit}]"
        try:
            scale = 1.0 if column.unit is None else scale_of(title, column.field)
            found[k] = replace(column, scale=scale, currency=currency_of(title, column.field))
        except UserError as error:
            problems.append(Problem(str(error), name, line=1, key=column.title))
    if problems:
        raise UserError(problems)
    return family, found, unused


def _unmapped_problems(
    mapping: Mapping[str, str], found: Sequence[_SheetColumn], family: str, name: str
) -> list[Problem]:
    """What the user mapped, and no column came of it."""
    used = {column.title.casefold() for column in found}
    known = [item.name for item in FAMILIES[family].columns()]
    problems = []
    for theirs, ours in mapping.items():
        if theirs.casefold() not in used:
            bare = ours.partition("[")[0].strip()
            twice = [
                other
                for other in mapping
                if other.casefold() in used and mapping[other].partition("[")[0].strip() == bare
            ]
            text = f"{twice[0]} and {theirs} are both mapped to {bare}; keep one" if twice else ""
            text = text or f'"{theirs}={ours}": {family.replace("_", " ")} have no column {bare}{near(bare, known)}'
            problems.append(Problem(text, name, line=1, key="--map"))
    return problems


def _columns(
    titles: Sequence[str], mapped: Mapping[str, str], row: type[CatalogueRow]
) -> tuple[list[_SheetColumn], list[str]]:
    """The columns of a family, and the other titles; the user's mapping comes before what a header is known as."""
    known = {item.name: item for item in row.columns()}
    columns: list[_SheetColumn] = []
    for index in sorted(range(len(titles)), key=lambda index: titles[index].casefold() not in mapped):
        title = titles[index]
        ours = mapped.get(title.casefold()) or standard(title, frozenset(known))
        bare, _, unit = ours.partition("[")
        bare = bare.strip().casefold().replace(" ", "_")
        bare = "max_torque" if bare == "torque" and "max_torque" in known else bare
        if bare in known and not any(column.field.name == bare for column in columns):
            columns.append(_SheetColumn(index, title, known[bare], unit.rstrip("] ").strip() or None))
    columns.sort(key=lambda column: column.index)
    used = {column.index for column in columns}
    return columns, [title for index, title in enumerate(titles) if index not in used]


def _with_own_unit(column: _SheetColumn) -> _SheetColumn:
    """The column with the unit of the vendor's header, which a mapping may leave out; UserError if they differ."""
    canonical = column.field.metadata["unit"]
    own = None if canonical in (None, "1", "degC") else unit_in(column.title, canonical)
    if own is None:
        return column
    stated = own if column.unit is None else column.unit
    if not isclose(factor(stated, canonical), factor(own, canonical), rel_tol=1e-9):
        header = f"{column.title}={column.field.name}"
        raise UserError(f'"{header} [{stated}]": the header says {own}; leave the unit out, "{header}"')
    return replace(column, unit=stated)


def _cell(text: str, column: _SheetColumn) -> str:
    """A cell in the catalogue's words and unit; ValueError or UserError if it is not such a word or quantity."""
    rules = column.field.metadata
    if not text:
        return ""
    if rules["unit"] is None:
        return text_cell(text, column.field, column.currency)
    canonical, shown = rules["unit"], rules["shown"]
    scale = 1.0 if canonical == shown or canonical == "degC" else factor(shown, canonical)
    return f"{require_allowed(_number(text, column), text, rules) / scale:.10g}"


def _number(text: str, column: _SheetColumn) -> float:
    """A quantity in SI units, by the unit of its column or its own, decimal or with a fraction (5/64)."""
    rules = column.field.metadata
    canonical, shown = rules["unit"], rules["shown"]
    number = read_number(plain_signs(text))
    if number is None:  # raises, with how to write it
        return number_cell(text, 1.0, rules) if column.unit is not None else parse(text, canonical)
    value, unit = number[0], number[1].strip()
    if column.unit is not None:
        if unit:
            raise ValueError(f'"{text}": its column is in [{column.unit}]; leave the unit out of the cell')
        return value * column.scale
    if not unit and shown != "1":  # a tolerance of 10 may be 10 % or ten times the value
        either = f"write it into each cell, such as {text} {shown}"
        raise ValueError(f'"{text}" has no unit: {either}, or --map "{column.title}={column.header}"')
    return value if canonical == "degC" and unit in ("degC", "°C") else parse(text, canonical)


def file_name(vendor: str) -> str:
    """``lee_spring.csv`` for ``Lee Spring``, ``unknown_vendor.csv`` without one."""
    kept = "".join(c if c.isalnum() else "_" for c in vendor.casefold())
    return f"{kept[:NAME_LENGTH].strip('_') or 'unknown_vendor'}.csv"
