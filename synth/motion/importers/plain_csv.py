"""Plain CSV from any logger: other column names, units in brackets or in the project, commas, semicolons or tabs.

Blanks separate the columns where nothing else does. Comment lines before the header are skipped. Where numbers follow
them directly, the last one is the header, as numpy's ``savetxt`` and ROS 1's ``rostopic echo -p`` write it. A second
row of units only (``s;deg;deg``) is recognised, so is one of x, y and z below points' names, and the first line
``sep=;`` by which a spreadsheet is told the separator. A column of dates or times of day is read in seconds.
"""

from __future__ import annotations

import io
import itertools
import re
from decimal import Decimal
from pathlib import Path

import numpy as np

from synth import units
from synth.errors import Problem, UserError
from synth.files.csv_rows import SEPARATORS, csv_rows, pointed
from synth.files.import_mapping import Mapping
from synth.files.log_clock import exact_number
from synth.files.paths import read_bytes
from synth.motion.importers.blank_separated import tabbed
from synth.motion.importers.echoed_joints import echoed_joints
from synth.motion.importers.foreign_data import MISSING, Channels
from synth.motion.importers.likelihood import SCORES
from synth.motion.importers.registry import UTF_16, loader, text_start
from synth.motion.importers.text_clock import text_clock

SIZE_LIMIT = 200_000_000  # bytes; the whole file is read into memory
CLOCKS = ("t", "time")  # names of the first column below a name that stands alone
TRIED = 20  # lines, header included, by which the separator is chosen
COMMENTS = ("#", "%", "//")
_MARK = re.compile(r"\s*(?:#+|%+|//+)\s*")  # with which a comment begins
_TITLE = re.compile(r"\s*(.*?)\s*[\[(]\s*([^\[\]()]*?)\s*[\])]\s*")
_OTHER = re.compile(r"volt|supply|battery|current|torque|effort|moment|velocity|speed", re.IGNORECASE)
_THOUSANDS = {mark: re.compile(rf"[+-]?[1-9]\d{{0,2}}(?:{re.escape(mark)}\d{{3}})+") for mark in ".,"}
_COORDINATES = ("x", "y", "z", *SCORES)
_TOLD = re.compile(r'"?sep=(.)"?[;,\t]*\s*', re.IGNORECASE)  # Excel's first line; saved again, it is a row of cells


def is_table(start: bytes, path: Path) -> bool:
    """Whether a file is text; the reader reports other faults."""
    return bool(text_start(start).strip())


@loader("csv", "CSV with a header", is_table, "channels", last=True)
def read_plain_csv(path: Path, mapping: Mapping, name: str) -> Channels:
    """All columns with their names and, if stated, units; raises as ``csv_channels``."""
    return csv_channels(path, name)


def csv_channels(path: Path, name: str) -> Channels:
    """All columns of a CSV with their names and, if stated, units.

    Raises
    ------
    UserError : no rows, no header, rows of another length, or a cell of a wanted column that is not a number.
    """
    lines = list(io.StringIO(_text(path, name), newline=""))
    told = _told_separator(lines, name)
    above = begin = 0 if told is None else 1
    while above < len(lines) and (not lines[above].strip() or lines[above].lstrip().startswith(COMMENTS)):
        above += 1
    if told is None and (parted := tabbed(lines, above)) is not None:
        told, lines = "\t", parted
    separator = told or _separator(lines[above : above + TRIED], name)
    numbered = [(above + line, row) for line, row in csv_rows("".join(lines[above:]), name, separator=separator)
            if len(row) > 1 or any(cell.strip() for cell in row)]  # fmt: skip
    while numbered and not any(cell.strip() for cell in numbered[-1][1]):
        numbered.pop()  # between others such a row is a missing sample, where the rows are the clock; here it is none
    if numbered and _holds_numbers(numbered[0][1], separator):
        numbered = [*_commented_header(lines[begin:above], numbered[0], separator, name), *numbered]
    rows, numbers = [row for _, row in numbered], [line for line, _ in numbered]
    if len(rows) > 2 and (merged := _of_two_rows(rows[0], rows[1]) or _below_a_name(rows[0], rows[1])):
        rows, numbers = [merged, *rows[2:]], [numbers[0], *numbers[2:]]
    if len(rows) < 2:
        raise UserError(Problem("has no rows below its header", name))
    titles = [cell.strip() for cell in rows[0]]
    while titles and not titles[-1]:
        titles = titles[:-1]
    names, found_units = zip(*map(title_and_unit, titles), strict=True)
    first = 1
    if len(rows) > 2 and all(cell.strip() and _is_unit(cell.strip()) for cell in rows[1][: len(titles)]):
        found_units, first = tuple(cell.strip() for cell in rows[1][: len(titles)]), 2
    joints = echoed_joints(names, rows[first:], numbers[first:], name)
    called = {names[index]: joint for index, (joint, _) in joints.items()}
    names = tuple(joints[index][0] if index in joints else each for index, each in enumerate(names))
    found_units = tuple(joints[index][1] if index in joints else each for index, each in enumerate(found_units))
    found_units, notes = _clocks_in_seconds(rows[first:], titles, found_units)
    values = _values(rows[first:], numbers[first:], titles, separator, name)
    repeated = next((each for k, each in enumerate(names) if each in names[:k]), None)
    if repeated is not None:
        raise UserError(Problem(f'column "{repeated}" is given twice; rename one', name, numbers[0]))

    def exact(column: int) -> list[Decimal | None]:
        return [exact_number(pointed(row[column], separator)) for row in rows[first:]]

    return Channels(name, names, found_units, values, notes=notes, numbers=exact, called=called)


def _of_two_rows(names: list[str], parts: list[str]) -> list[str]:
    """One header of a row of names, each over all or the first of its columns, and below it x, y and z; else empty.

    ``,hip,,knee,`` over ``time,x,y,x,y``, as spreadsheets have it, becomes ``time,hip_x,hip_y,knee_x,knee_y``.
    """
    found, over = [], ""
    for name, part in itertools.zip_longest((each.strip() for each in names), (each.strip() for each in parts)):
        over = name or over
        axis = (part or "").casefold() in _COORDINATES
        if not axis and part and over:
            return []  # a part of another kind under a name: two rows of something else
        found.append(f"{over}_{part}" if axis and over else part or name or "")
    count = sum(each.strip().casefold() in ("x", "y", "z") for each in parts)
    return found if count >= 4 else []  # x and y of two points


def _below_a_name(names: list[str], titles: list[str]) -> list[str]:
    """The header below the name of what was tracked, which alone stands above it; else empty.

    ``mass_A`` over ``t,x,y``, as Tracker exports a mass, becomes ``t,mass_A_x,mass_A_y``.
    """
    name, titles = names[0].strip(), [each.strip() for each in titles]
    if not name or any(each.strip() for each in names[1:]) or title_and_unit(titles[0])[0].casefold() not in CLOCKS:
        return []
    if not {"x", "y"} <= {each.casefold() for each in titles}:
        return []  # a remark above a header
    return [f"{name}_{each}" if each.casefold() in _COORDINATES else each for each in titles]


def _told_separator(lines: list[str], name: str) -> str | None:
    """The separator that the first line states, None if it states none."""
    match = _TOLD.fullmatch(lines[0]) if lines else None
    if match is None:
        return None
    if match[1] not in SEPARATORS:
        text = f'states the separator "{match[1]}"; write it with commas, semicolons or tabs'
        raise UserError(Problem(text, name, 1))
    return match[1]


def _clocks_in_seconds(
    rows: list[list[str]], titles: list[str], units_of: tuple[str, ...]
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Put columns of dates or times of day in seconds, in place; the columns' units, and a note on each."""
    found, notes = list(units_of), []
    for column, title in enumerate(titles):
        clock = text_clock([row[column] if column < len(row) else "" for row in rows])
        if clock is None:
            continue
        for row, cell in zip(rows, clock[0], strict=True):
            row[column : column + 1] = [cell] if column < len(row) else []
        found[column] = "s"
        notes.append(f'"{title}" holds {clock[1]}: read in seconds')
    return tuple(found), tuple(notes)


def _holds_numbers(row: list[str], separator: str) -> bool:
    return any(_number(cell, separator) is not None for cell in row)


def _commented_header(
    above: list[str], first: tuple[int, list[str]], separator: str, name: str
) -> list[tuple[int, list[str]]]:
    """The header (line, cells), and below it the row of units if there is one, of comments above the first numbers.

    ``above`` : the lines before the first numbers, all of them comments or blank; ``first`` : the line and cells of
    these numbers.

    Raises
    ------
    UserError : the last comment does not name each column.
    """
    width = len(first[1])
    while width and not first[1][width - 1].strip():
        width -= 1
    comments = [(line, _titles(text, separator, name)) for line, text in enumerate(above, 1) if text.strip()]
    named = [(line, row) for line, row in comments[-2:]
             if len(row) == width and all(row) and not _holds_numbers(row, separator)]  # fmt: skip
    if not named or named[-1] != comments[-1]:
        text = "begins with numbers; its first line must name the columns"
        if comments:
            text = f"begins with numbers, and the comment above does not name their {width} columns; write a header"
        raise UserError(Problem(text, name, first[0]))
    return named if len(named) == 2 and all(map(_is_unit, named[-1][1])) else named[-1:]


def _titles(comment: str, separator: str, name: str) -> list[str]:
    """The cells of a comment without its mark and without empty ones at its end."""
    text = _MARK.sub("", comment, count=1)
    cells = [cell.strip() for cell in next((row for _, row in csv_rows(text, name, separator=separator)), [])]
    while cells and not cells[-1]:
        cells.pop()
    return cells


def _separator(lines: list[str], name: str) -> str:
    """The separator of which the rows make the most numbers and the fewest other cells; then that of most columns.

    A comma may also stand in a quoted name, an unquoted one (``hip, deg``), and in every decimal.
    """
    scores: dict[str, tuple[int, int]] = {}
    for separator in SEPARATORS:
        try:
            rows = [row for _, row in csv_rows("".join(lines), name, separator=separator)]
        except UserError:
            continue  # a cell is too long; the right separator's error is raised when the whole file is read
        heads = rows[: 2 if rows and len(rows[0]) == 1 else 1]  # a name may stand alone above the header
        width = max(map(len, heads), default=0)
        if width > 1:
            cells = [cell for row in rows[1:] for cell in row if cell.strip().casefold() not in MISSING]
            numbers = sum(_number(cell, separator) is not None for cell in cells)
            scores[separator] = 2 * numbers - len(cells), width
    return max(scores, key=scores.__getitem__, default=",")


def _text(path: Path, name: str) -> str:
    data = read_bytes(path, SIZE_LIMIT, "thin it")
    if data[:4] in (b"PK\x03\x04", b"\xd0\xcf\x11\xe0"):
        raise UserError(Problem("is a spreadsheet or an archive, not a CSV; export it as CSV", name))
    for encoding in ("utf-16",) if data.startswith(UTF_16) else ("utf-8-sig", "cp1252"):
        try:
            return data.decode(encoding)  # a degree sign often comes in Windows' encoding
        except UnicodeDecodeError:
            continue
    raise UserError(Problem("is not text", name))


def title_and_unit(title: str) -> tuple[str, str]:
    """Name and unit of ``Hip angle (deg)``; brackets without a unit belong to the name."""
    match = _TITLE.fullmatch(title)
    if not match:
        return title, ""
    # Beside angles and times only of what its name tells: "Hip (L)" is the left one, "Hip (A)" may be one too.
    known = ("rad", "s", *(("V", "A", "N*m", "rad/s") if "[" in title or _OTHER.search(match[1]) else ()))
    return (match[1], match[2]) if any(_is_unit(match[2], of) for of in known) else (title, "")


def _is_unit(text: str, of: str | None = None) -> bool:
    """Whether ``text`` is a unit, of the same dimension as ``of`` if given; a bare number is none."""
    try:
        units.factor(text, of or text)
    except UserError:
        return False
    return not text.strip().isdigit()


def _values(rows: list[list[str]], lines: list[int], titles: list[str], separator: str, name: str) -> np.ndarray:
    """(n, n_column), nan for an empty cell or text such as a remark."""
    values = np.full((len(rows), len(titles)), np.nan)
    numeric = [False] * len(titles)  # whether a column has held a number: text below one is a fault
    for k, (row, line) in enumerate(zip(rows, lines, strict=True)):
        if len(row) < len(titles) or any(cell.strip() for cell in row[len(titles) :]):
            text = f"has {len(row)} cells where the header has {len(titles)} columns"
            if len(titles) == 1 and len(row) > 1:
                text += f' ("{titles[0][:40]}"): remove the lines above the header, or begin each of them with #'
            raise UserError(Problem(text, name, line))
        for column in range(len(titles)):
            number = _number(row[column], separator)
            if number is not None:
                values[k, column] = number
                numeric[column] |= number == number
            elif row[column].strip().casefold() not in MISSING and numeric[column]:
                raise UserError(Problem(_no_number(row[column].strip()), name, line, titles[column]))
    if separator != ",":
        _refuse_thousands(rows, lines, titles, numeric, name)
    if separator == ",":
        _refuse_commas(rows, lines, [None if has else title for has, title in zip(numeric, titles, strict=True)], name)
    return np.where(np.isfinite(values), values, np.nan)


def _refuse_commas(rows: list[list[str]], lines: list[int], titles: list[str | None], name: str) -> None:
    """Refuse columns of quoted numbers with a comma, which would count as missing; ``titles`` None: of numbers."""
    problems = []
    for column, title in enumerate(titles):
        cells = [(row[column].strip(), line) for row, line in zip(rows, lines, strict=True)]
        filled = [(cell, line) for cell, line in cells if cell.casefold() not in MISSING]
        if title is not None and filled and all(pointed(cell, ";") != cell for cell, _ in filled):
            problems.append(Problem(_no_number(filled[0][0]), name, filled[0][1], title))
    if problems:
        raise UserError(problems)


def _refuse_thousands(
    rows: list[list[str]], lines: list[int], titles: list[str], numeric: list[bool], name: str
) -> None:
    """Refuse columns of 1.234 beside others of 12,3, and the reverse: a spreadsheet wrote the thousands."""
    cells = [[row[column].strip() for row in rows] if has else [] for column, has in enumerate(numeric)]
    problems = []
    for mark, other in (".,", ",."):
        decimal = next((cell for column in cells for cell in column if other in cell), None)
        for title, column in zip(titles, cells, strict=True):
            marked = [(line, cell) for line, cell in zip(lines, column, strict=False) if mark in cell]
            if decimal is None or not marked or not all(_THOUSANDS[mark].fullmatch(cell) for _, cell in marked):
                continue
            line, cell = marked[0]
            text = f'"{cell}" has a "{mark}" where "{decimal}" has a "{other}": write {cell.replace(mark, "")} if it '
            text += f"separates thousands, {cell.replace(mark, other)} if decimals"
            problems.append(Problem(text, name, line, title))
    if problems:
        raise UserError(problems)


def _no_number(cell: str) -> str:
    """What is wrong with a cell among numbers, and the correct form."""
    if pointed(cell, ";") != cell:
        return f'"{cell[:40]}" is a number with a comma; write {pointed(cell, ";")[:40]}, or semicolons between columns'
    return f'"{cell[:40]}" is not a number; leave the cell empty where a sample is missing'


def _number(cell: str, separator: str) -> float | None:
    """A cell's number; decimals take a comma where semicolons or tabs separate."""
    text = pointed(cell, separator)
    try:
        return float(text) if "_" not in text and text.casefold() not in MISSING else None
    except ValueError:
        return None
