"""Tables for the screen: plain text, columns as wide as their longest cell."""

from __future__ import annotations

from collections.abc import Sequence

from synth.commands.progress import printable


def table_text(rows: Sequence[Sequence[str]], *, numbers_right: bool = True, words_last: bool = False) -> str:
    """Rows of equal length as lines, the first as heading.

    ``numbers_right``: columns but the first are right-aligned, and with ``words_last`` but the last.
    """
    cells = [[printable(cell) for cell in row] for row in rows]
    widths = [max(len(cell) for cell in column) for column in zip(*cells, strict=True)]
    words = len(widths) - 1 if words_last else len(widths)  # index of the first column of words after the numbers
    lines = []
    for row in cells:
        shown = [
            cell.rjust(width) if numbers_right and index and index < words else cell.ljust(width)
            for index, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        lines.append("  ".join(shown).rstrip())
    lines.insert(1, "-" * min(max(map(len, lines)), 160))  # a rule of the widest usual terminal
    return "\n".join(lines)
