"""Read a CSV of numbers whose header carries the units; every bad cell is reported with line and column.

Plain files go through numpy's C reader (100 MB/s, without importing pandas); files that it refuses are read cell by
cell to locate the mistake.
"""

from __future__ import annotations

import io
import math
import re
from array import array
from collections.abc import Mapping
from dataclasses import dataclass, field
from decimal import Decimal
from hashlib import sha256
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from synth.errors import Problem, UserError
from synth.files.csv_rows import csv_rows, other_separator, refuse_no_text
from synth.files.log_clock import LogClock, exact_number, log_clock
from synth.files.paths import read_bytes
from synth.files.validate import near
from synth.units import factor, header

Array = NDArray[np.float64]

SIZE_LIMIT = 64_000_000  # bytes: 2 million rows of four columns
ROW_LIMIT = 2_000_000  # of any table; a larger one is probably the wrong file
COLUMN_LIMIT = 200  # of any table: six joints with all channels have fewer than 50
REPORT_LIMIT = 20  # bad cells reported individually: a screen
THIN = "keep every tenth row, for example with: awk 'NR==1 || NR%10==0' long.csv > short.csv"
_MISSING = frozenset({"nan", "+nan", "-nan"})


@dataclass(frozen=True)
class CsvColumn:
    """One column's name, unit and 0-based index."""

    name: str
    unit: str
    index: int

    @property
    def title(self) -> str:
        """The column's title as in the header."""
        return f"{self.name} [{self.unit}]"


@dataclass(frozen=True, eq=False)
class CsvTable:
    """A CSV of numbers.

    ``values``: (n_row, n_column) in the units of the header, nan where a cell is empty; ``data`` the file's bytes.
    """

    name: str  # the file as the user named it
    columns: tuple[CsvColumn, ...]
    values: Array
    data: bytes = field(repr=False)

    @property
    def sha256(self) -> str:
        """Hash of the file, hexadecimal."""
        return sha256(self.data).hexdigest()

    def line(self, row: int) -> int:
        """The 1-based line of a row of ``values``."""
        lines = (number for number, cells in csv_rows(self.data, self.name) if any(cell.strip() for cell in cells))
        next(lines)  # the header
        return next(number for count, number in enumerate(lines) if count == row)

    def clock(self, column: CsvColumn) -> LogClock:
        """The clock of a column of times; see ``log_clock``."""

        def numbers() -> list[Decimal | None]:
            rows = (cells for _, cells in csv_rows(self.data, self.name) if any(cell.strip() for cell in cells))
            next(rows)  # the header
            return [exact_number(cells[column.index]) for cells in rows]

        values = self.values[:, self.columns.index(column)]
        whole = np.isfinite(values).all()  # else the check of the times refuses the file
        return log_clock(values, factor(column.unit, "s"), numbers if whole else None)


def in_si(table: CsvTable, wanted: Mapping[str, str], foreign: str) -> tuple[dict[str, Array], list[Problem]]:
    """Columns (n_row,) by name in SI, and problems: unknown columns, units of another dimension.

    The column ``time`` counts from its first row where the clock is a large one (``log_clock``).

    ``foreign`` : the message for an unknown column.
    """
    values: dict[str, Array] = {}
    problems: list[Problem] = []
    for index, column in enumerate(table.columns):
        if column.name not in wanted:
            text = f'column "{column.title}" {foreign}{_meant(column, wanted)}'
            problems.append(Problem(text, table.name, 1))
            continue
        try:
            scale = factor(column.unit, wanted[column.name])
            clock = column.name == "time"
            values[column.name] = table.clock(column).time if clock else table.values[:, index] * scale
        except UserError as error:
            problems.append(Problem(error.problems[0].text, table.name, 1, column.title))
    return values, problems


def _meant(column: CsvColumn, wanted: Mapping[str, str]) -> str:
    """``; did you mean hip torque?``: of ``hip effort [N*m]`` what is in such a unit, not what is spelt alike."""
    alike = [name for name, unit in wanted.items() if _is_in(column.unit, unit)]
    same = [name for name in alike if name.partition(" ")[0] == column.name.partition(" ")[0]]
    hint = near(column.name, alike or list(wanted))
    return hint or (f"; did you mean {same[0]}?" if len(same) == 1 else "")


def _is_in(written: str, unit: str) -> bool:
    """Whether a column's unit is of the dimension of an SI unit."""
    try:
        factor(written, unit)
    except UserError:
        return False
    return True


def read_table(path: Path, name: str | None = None) -> CsvTable:
    """Read a CSV whose every column is ``name [unit]``.

    Raises
    ------
    UserError
        With every mistake of the file: size, encoding, separator, header, cells.
    """
    name = name or str(path)
    try:
        data = read_bytes(path, SIZE_LIMIT, THIN)
    except UserError as error:
        raise UserError([Problem(problem.text, name) for problem in error.problems]) from None
    refuse_no_text(data, name)
    columns, width = _columns(data, name)
    lines = data if b"\n" in data else data.replace(b"\r", b"\n")  # line ends of old Macintosh spreadsheets
    if lines.count(b"\n") > ROW_LIMIT + 1:
        raise UserError(Problem(f"has more than {ROW_LIMIT} rows: {THIN}", name))
    values = _fast(lines, width)
    if values is None:
        values = _slow(data, name, columns, width)
    if not len(values):
        raise UserError(Problem("has a header and no rows", name))
    return CsvTable(name, columns, np.ascontiguousarray(values[:, [column.index for column in columns]]), data)


def _columns(data: bytes, name: str) -> tuple[tuple[CsvColumn, ...], int]:
    """The header's columns, and their number without unnamed ones at the end (trailing commas)."""
    try:
        line, titles = next((number, cells) for number, cells in csv_rows(data, name) if any(c.strip() for c in cells))
    except StopIteration:
        raise UserError(Problem("is empty; the first line is the header, such as time [s],hip [deg]", name)) from None
    if titles[0].lstrip().startswith("#"):
        text = "begins with a comment; remove such lines, the header comes first; of a header itself remove the # alone"
        raise UserError(Problem(text, name, line))
    while titles and not titles[-1].strip():
        titles = titles[:-1]
    if len(titles) > COLUMN_LIMIT:
        raise UserError(Problem(f"has {len(titles)} columns; at most {COLUMN_LIMIT}", name, line))
    if fault := other_separator(titles):
        raise UserError(Problem(fault, name, line))
    problems: list[Problem] = []
    columns: list[CsvColumn] = []
    for index, title in enumerate(titles):
        try:
            columns.append(CsvColumn(*header(title), index))
        except UserError as error:
            problems.append(Problem(error.problems[0].text, name, line, f"column {index + 1}"))
    names = [column.name for column in columns]
    for column in columns:
        if column.name in names[: columns.index(column)]:
            problems.append(Problem(f'column "{column.name}" is given twice; keep one', name, line))
    if problems:
        raise UserError(problems)
    return tuple(columns), len(titles)


def _fast(data: bytes, width: int) -> Array | None:
    """All values by numpy's reader, or None for a file that must be read cell by cell."""
    data = data.removeprefix(b"\xef\xbb\xbf").lstrip(b"\r\n \t")
    if b'"' in data.partition(b"\n")[0] and data.partition(b"\n")[0].count(b'"') % 2:
        return None  # a header cell that continues on the next line
    written = body = data.partition(b"\n")[2]
    if not body.strip():
        return np.empty((0, width))
    if body.startswith(b",") or b"\n," in body:
        body = re.sub(rb"(?m)^[, \t]*\r?(?:\n|\Z)", b"", body)  # rows without a number, as ``line`` has them
        if not body.strip():
            return np.empty((0, width))
    if b",," in body or body.startswith(b",") or b"\n," in body or re.search(rb",\r?(\n|\Z)", body):
        body = re.sub(rb"(?m),(?=[,\r\n]|\Z)", b",nan", re.sub(rb"(?m)^(?=,)", b"nan", body))
    try:
        values = np.loadtxt(io.BytesIO(body), delimiter=",", comments=None, ndmin=2, encoding="utf-8")
    except (ValueError, OverflowError):
        return None
    usable = values.shape[1] >= width and np.isnan(values[:, width:]).all() and not np.isinf(values).any()
    if values.shape[1] > width and b"n" in written.lower():
        return None  # beyond the last column only empty cells are allowed, and these may say nan
    return np.asarray(values, dtype=np.float64) if usable else None


def _slow(data: bytes, name: str, columns: tuple[CsvColumn, ...], width: int) -> Array:
    """The same cell by cell; raises all mistakes, or reads what numpy refused (quotes, blanks)."""
    problems: list[Problem] = []
    values = array("d")  # boxed floats of the largest file would take 0.5 GB
    rows = ((line, cells) for line, cells in csv_rows(data, name) if any(cell.strip() for cell in cells))
    next(rows)
    for line, cells in rows:
        problem, numbers = _row(line, cells, name, columns, width)
        problems.extend(problem)
        values.extend(numbers)
        if len(problems) >= REPORT_LIMIT:
            problems = [*problems[:REPORT_LIMIT], Problem("the rest of the file was not checked", name, line)]
            break
    if problems:
        raise UserError(problems)
    return np.array(values, dtype=np.float64).reshape(-1, width)


def _row(
    line: int, cells: list[str], name: str, columns: tuple[CsvColumn, ...], width: int
) -> tuple[list[Problem], list[float]]:
    """Mistakes and numbers of one row."""
    if cells[0].lstrip().startswith("#"):
        return [Problem("is a comment; remove such lines", name, line)], []
    if len(cells) < width or any(cell.strip() for cell in cells[width:]):
        hint = "; decimals take a point, not a comma" if len(cells) == 2 * width else ""
        return [Problem(f"has {len(cells)} cells where the header has {width} columns{hint}", name, line)], []
    problems: list[Problem] = []
    numbers: list[float] = []
    for column, cell in zip(columns, cells, strict=False):
        number = _number(cell)
        if number is not None:
            numbers.append(number)
        else:
            text = cell.strip()
            shown = text if len(text) <= 40 else text[:37] + "..."  # so that the message stays on one line
            found = f'"{shown}" is not a number; leave the cell empty where a sample is missing'
            problems.append(Problem(found, name, line, column.title))
    return problems, numbers


def _number(cell: str) -> float | None:
    """A cell's value, nan for an empty cell or ``nan`` as MATLAB and pandas write it, None for a bad one."""
    try:
        number = float(cell)
    except ValueError:
        return np.nan if not cell.strip() else None
    if number != number:
        return np.nan if cell.strip().lower() in _MISSING else None
    # Python's float also accepts 1_000 and inf, which are not valid readings.
    return number if math.isfinite(number) and "_" not in cell else None
