"""The rows of a user's CSV with their line numbers; the only place that splits cells.

Every reader of tables (recordings, catalogues, vendors, wound samples, foreign motion) uses it.
Files that are not text, or whose cells are ambiguous, are refused with the line.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterator, Sequence

from synth.errors import Problem, UserError

SEPARATORS = ",;\t"  # of CSV files, the usual one first
_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+(?:[eE][+-]?\d+)?")


def csv_rows(
    data: bytes | str, name: str, *, separator: str = ",", strict: bool = False
) -> Iterator[tuple[int, list[str]]]:
    """(line, cells) of every row, including the header; a blank line has no cells or blank ones.

    Parameters
    ----------
    data : the file, UTF-8 with or without a byte order mark, or its text.
    name : of the file, in messages.
    strict : refuse text after a closing quote, and an unclosed quote.

    Raises
    ------
    UserError : during iteration; the data are not UTF-8 text, or ``csv`` cannot split the cells.
    """
    if isinstance(data, bytes):
        refuse_no_text(data, name)
        data = data.decode("utf-8-sig")
    reader = csv.reader(io.StringIO(data, newline=""), delimiter=separator, strict=strict)
    last = 0
    while True:
        try:
            cells = next(reader)
        except StopIteration:
            return
        except csv.Error as error:
            raise UserError(Problem(f"cannot be read as CSV: {error}", name, last + 1)) from None
        yield last + 1, cells
        last = reader.line_num


def separator_of(header: str) -> str:
    """The most frequent separator of a header of names and units: comma, semicolon or tab; a comma if there is none."""
    return max(SEPARATORS, key=header.count)


def pointed(cell: str, separator: str) -> str:
    """A cell whose decimals take a point; they may take a comma where semicolons or tabs separate."""
    text = cell.strip()
    return text.replace(",", ".") if separator != "," and _DECIMAL_COMMA.fullmatch(text) else text


def other_separator(titles: Sequence[str]) -> str:
    """What is wrong with titles that commas do not split; empty if nothing is."""
    for separator, word in ((";", "semicolons"), ("\t", "tabs")):
        if len(titles) == 1 and separator in titles[0]:
            return f"is separated by {word}; write it with commas, and with points for decimals"
    return ""


def refuse_no_text(data: bytes, name: str) -> None:
    """Refuse bytes that are not UTF-8 text.

    Raises
    ------
    UserError : with the probable format, and how to export it.
    """
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise UserError(Problem('is UTF-16 text; save it as "CSV UTF-8"', name))
    if data[:4] in (b"PK\x03\x04", b"\xd0\xcf\x11\xe0"):
        raise UserError(Problem("is a spreadsheet or an archive, not a CSV; export it as CSV", name))
    if b"\0" in data:
        line = data[: data.index(b"\0")].count(b"\n") + 1
        raise UserError(Problem("is not text: it holds a zero byte", name, line))
    try:
        data.decode("utf-8")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise UserError(Problem("is not UTF-8 text; save it as UTF-8", name, line)) from None
