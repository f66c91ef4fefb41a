"""Tables whose columns blanks separate, as numpy's ``savetxt``, MATLAB's ``save -ascii`` and gnuplot have them."""

from __future__ import annotations

import re
from collections.abc import Sequence

from synth.motion.importers.foreign_data import MISSING

TRIED = 20  # lines that must be rows of one width
_UNIT = re.compile(r"\s+(?=[\[(])")  # ``hip [deg]`` is one name


def tabbed(lines: Sequence[str], first: int) -> list[str] | None:
    """The lines with tabs between their columns; None where blanks do not separate them.

    ``first`` : index of the first line that is neither blank nor a comment. It holds a number or a name for each of
    the columns below, and none of the lines has another separator.
    """
    tried = [line for line in lines[first : first + TRIED] if line.strip()]
    if len(tried) < 2 or any(mark in line for line in tried for mark in ",;\t"):
        return None
    head, *rows = map(_words, tried)
    body = rows[1:] if len(rows) > 1 and not any(map(_is_number, rows[0])) else rows  # below a row of units
    width = len(head)
    if (
        width < 2
        or any(len(row) != width for row in rows)
        or not all(map(_is_number, (c for row in body for c in row)))
    ):
        return None
    return ["\t".join(_words(line)) + "\n" for line in lines]


def _words(line: str) -> list[str]:
    return _UNIT.sub("", line).split()


def _is_number(cell: str) -> bool:
    if cell.casefold() in MISSING:
        return True
    try:
        float(cell)
    except ValueError:
        return False
    return True
