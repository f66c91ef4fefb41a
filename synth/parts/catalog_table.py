"""Rows of a catalogue family's CSV: units from the headers, every bad cell reported with its place."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import Field, dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from synth.errors import Problem, UserError
from synth.files.csv_rows import csv_rows, other_separator
from synth.files.paths import read_bytes
from synth.parts.catalog_cells import currency_of, number_cell, scale_of, text_cell
from synth.parts.catalogue_row import CatalogueRow, declared_state
from synth.parts.headers import NAMES, quantity_unit, standard
from synth.parts.rows import FAMILIES
from synth.units import factor

MAX_BYTES = 50_000_000  # a catalogue of 10^5 rows has 30 MB
MAX_PROBLEMS = 50  # a file of the wrong kind would give one per cell
_OF_A_PART = {"direction", "continuous", "travel", "wire_diameter", "max_deflection"}  # no curve's table has these


@dataclass(frozen=True)
class ReadTable:
    """The readable rows of a file, and the mistakes of the others."""

    family: str | None
    rows: tuple[CatalogueRow, ...]
    problems: tuple[Problem, ...]


@dataclass(frozen=True)
class _TableColumn:
    """One column of the file: its target, and the factor of its numbers or the currency of its prices."""

    index: int
    title: str
    field: Field[Any]
    scale: float
    currency: str


def read_table(path: Path, shown: str | None = None) -> ReadTable:
    """Read one catalogue file; its family is recognised by its headers.

    Nothing is raised for mistakes of the user: they are in ``problems``. Rows with a bad cell are left out.
    ``shown``: the file's name in messages and rows, default the path as given.
    """
    name = shown or str(path)
    try:
        data = read_bytes(path, MAX_BYTES, "no catalogue is so large")
        return _read_lines(csv_rows(data, name, strict=True), name)
    except UserError as error:
        return ReadTable(None, (), tuple(Problem(each.text, name, each.line) for each in error.problems))


def _refuse_table(name: str, text: str) -> ReadTable:
    return ReadTable(None, (), (Problem(text, file=name),))


def _read_lines(lines: Iterator[tuple[int, list[str]]], name: str) -> ReadTable:
    _, titles = next(lines, (1, []))
    if not titles or not any(title.strip() for title in titles):
        return _refuse_table(name, "is empty; the first line holds the headers, name [unit]")
    if fault := other_separator(titles):
        return _refuse_table(name, fault)
    written, titles = titles, _standard(titles)
    family = _recognise(titles)
    if family is None:
        keys = "; ".join(f"{key}: {', '.join(_keys(row))}" for key, row in FAMILIES.items())
        text = f"is not a catalogue: its headers fit no family. The identifying headers are {keys}"
        return ReadTable(None, (), (Problem(text + _near_key(titles), file=name, line=1),))
    row_type = FAMILIES[family]
    columns, problems = _columns(titles, written, row_type, name)
    if problems:
        return ReadTable(family, (), tuple(problems))
    rows: list[CatalogueRow] = []
    for line, cells in lines:
        if not any(cell.strip() for cell in cells):
            continue
        if len(cells) != len(titles):
            problems.append(Problem(f"{len(cells)} cells where the header has {len(titles)}", file=name, line=line))
        else:
            row, bad = _row(cells, columns, row_type, name, line)
            problems.extend(bad)
            if row is not None:
                rows.append(row)
        if len(problems) > MAX_PROBLEMS:
            problems.append(Problem("more mistakes follow; the rest of the file was not read", file=name, line=line))
            break
    if not rows and not problems:
        problems.append(Problem("has headers but no rows", file=name))
    return ReadTable(family, tuple(rows), tuple(problems))


def _name_in_header(title: str) -> str:
    """The name in a header, without its unit."""
    return title.split("[", 1)[0].strip()


def _standard(titles: list[str]) -> list[str]:
    """Headers in the catalogue's words; a column under its own name has priority."""
    known = frozenset(item.name for row in FAMILIES.values() for item in row.columns())
    own = {_name_in_header(title) for title in titles if _name_in_header(title) in known}
    found = []
    for title in titles:
        better = standard(title, known)
        found.append(
            title
            if _name_in_header(title) in known and "(" not in title
            else title
            if _name_in_header(better) in own
            else better
        )
    names = {_name_in_header(title) for title in found}
    if "torque" in names and "max_torque" not in names and names & _OF_A_PART:
        found = ["max_" + title if _name_in_header(title) == "torque" else title for title in found]
    return found


def _keys(row_type: type[CatalogueRow]) -> list[str]:
    return [item.name for item in row_type.columns() if item.metadata.get("key")]


def _recognise(titles: list[str]) -> str | None:
    """The family whose key columns are all present; the one with more keys if two fit."""
    names = {_name_in_header(title) for title in titles}
    if {"max_torque", "max_deflection"} <= names:
        names = names | {"rate"}  # it follows from them
    if "max_speed" in names:
        names = names | {"speed"}  # a torque without a speed of its own is taken at the highest one
    fitting = [(len(_keys(row)), family) for family, row in FAMILIES.items() if set(_keys(row)) <= names]
    return max(fitting)[1] if fitting else None


def _near_key(titles: list[str]) -> str:
    keys = sorted({key for row in FAMILIES.values() for key in _keys(row)})
    for title in titles:
        if _name_in_header(title) not in keys and (
            near := get_close_matches(_name_in_header(title), keys, n=1, cutoff=0.75)
        ):
            return f'. Did you mean "{near[0]}" by "{_name_in_header(title)}"?'
    return ""


def _columns(
    titles: list[str], written: list[str], row_type: type[CatalogueRow], name: str
) -> tuple[list[_TableColumn], list[Problem]]:
    """Match headers with fields; ``written``: as they stand in the file.

    An unknown column of words is ignored, unless it looks like a typing mistake; one of a quantity is refused, because
    its numbers would not count: ``armature_inertia`` beside which the inertia is estimated.
    """
    known = {item.name: item for item in row_type.columns()}
    given = {_name_in_header(title) for title in titles}
    columns: list[_TableColumn] = []
    problems: list[Problem] = []
    seen: set[str] = set()
    for index, title in enumerate(titles):
        bare = _name_in_header(title)
        if bare not in known:
            absent = [item for key, item in known.items() if key not in given]
            if text := _unknown_column(written[index], absent, row_type):
                problems.append(Problem(text, file=name, line=1, key=written[index].strip()))
            continue
        if bare in seen:
            problems.append(Problem(f'the column "{bare}" is given twice', file=name, line=1, key=title))
            continue
        seen.add(bare)
        try:
            scale, currency = scale_of(title, known[bare]), currency_of(title, known[bare])
        except UserError as error:
            problems.append(Problem(str(error), file=name, line=1, key=bare))
            continue
        columns.append(_TableColumn(index, written[index], known[bare], scale, currency))
    return columns, problems


def _unknown_column(title: str, absent: list[Field[Any]], row_type: type[CatalogueRow]) -> str:
    """Why a column that the family does not have is refused; empty if it may be ignored, as another word for one that
    the file has may. ``title`` as written; ``absent``: the family's columns that the file does not have.
    """
    unit, bare = quantity_unit(title), _bare_name(title)
    names = [item.name for item in absent]
    meant = NAMES.get(bare)
    if meant not in (None, *names) and meant in {item.name for item in row_type.columns()}:
        return ""
    near = get_close_matches(bare, names, n=1, cutoff=0.8) or [
        name for name in names if sorted(name.split("_")) == sorted(bare.split("_"))
    ]
    if near:
        return f'there is no column "{bare}"; did you mean "{near[0]}"?'
    if not unit:
        return ""
    family = row_type.family.replace("_", " ")
    text = f'{family} have no column "{bare}", so its numbers would not count; '
    alike = [f"{item.name} [{item.metadata['shown']}]" for item in absent if _of_kind(unit, item)]
    rename = f"rename it to what is meant ({', '.join(alike)}), or " if alike else ""
    return f"{text}{rename}take the column out, or only its unit to keep the numbers as words"


def _bare_name(title: str) -> str:
    """The name in an unknown header in the form of the known ones: without unit, in lower case, with _ for blanks."""
    return re.sub(r"[^a-z0-9]+", "_", re.split(r"[\[(]", title, maxsplit=1)[0].casefold()).strip("_")


def _of_kind(unit: str, item: Field[Any]) -> bool:
    """Whether a column may hold quantities of this unit."""
    if item.metadata["unit"] is None:
        return False
    try:
        factor(unit, item.metadata["unit"])
    except UserError:
        return False  # of another kind: that is the answer
    return True


def _row(
    cells: list[str], columns: list[_TableColumn], row_type: type[CatalogueRow], name: str, line: int
) -> tuple[CatalogueRow | None, list[Problem]]:
    values: dict[str, Any] = {}
    problems: list[Problem] = []
    for column in columns:
        text = cells[column.index].strip()
        if not text:
            continue
        try:
            values[column.field.name] = _cell(text, column)
        except ValueError as error:
            problems.append(Problem(str(error), file=name, line=line, key=column.title))
    if problems:
        return None, problems
    return row_type(file=name, line=line, state=declared_state(values.get("status", "")), **values), []


def _cell(text: str, column: _TableColumn) -> float | str:
    """One cell; the ValueError's text is the user's message."""
    if column.field.metadata["unit"] is None:
        return text_cell(text, column.field, column.currency)
    return number_cell(text, column.scale, column.field.metadata)
