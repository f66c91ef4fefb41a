"""The rows of a user's CSV, with the line that each begins in: the one place that splits cells.

Every reader of tables (recordings, catalogues, vendors, wound samples, foreign motion) takes its rows from here.
What is no text, and what has cells that cannot be told apart, is refused with its line.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator

from synth.errors import Problem, UserError


def csv_rows(
    data: bytes | str, name: str, *, separator: str = ",", strict: bool = False
) -> Iterator[tuple[int, list[str]]]:
    """(line, cells) of every row, the header among them; blank lines have no cells or blank ones.

    Parameters
    ----------
    data : the file, UTF-8 with or without a mark, or its text.
    name : of the file, in messages.
    strict : refuse what stands behind a closing quote, and a quote that is never closed.

    Raises
    ------
    UserError : while it is iterated over; it is not UTF-8 text, or ``csv`` cannot tell its cells apart.
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


def refuse_no_text(data: bytes, name: str) -> None:
    """Refuse a file's bytes that are no UTF-8 text.

    Raises
    ------
    UserError : with what it looks like, and how to write it.
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
