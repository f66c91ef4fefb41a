"""A grid of shaded cells with named rows and columns; a larger value is darker, and a cell may have a label."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from synth.reports.figures.palette import BLACK, GREY, RULE
from synth.reports.figures.svg import Svg

LETTER = 6.4  # px of a letter of a label, at most
DARK = 0.55  # shade from which words in a cell are white


@dataclass(frozen=True)
class GridCell:
    """``shade`` from 0 (white) to 1 (full blue); ``words``: its label; ``framed``: the correct cell of the row."""

    shade: float
    words: str = ""
    framed: bool = False


def grid_figure(
    title: str, rows: Sequence[str], columns: Sequence[str], cells: Sequence[Sequence[GridCell]], size: float
) -> Markup:
    """Cells of ``size`` px; column heads stand upright, their first letter at the bottom."""
    left = LETTER * max(map(len, rows), default=0) + 10.0
    top = LETTER * max(map(len, columns), default=0) + 10.0
    svg = Svg(left + size * len(columns) + 8.0, top + size * len(rows) + 8.0, title)
    letter = min(11.0, size - 1.0)
    for index, words in enumerate(columns):
        at = (left + size * (index + 0.5) + 0.35 * letter, top - 4.0)
        turn = f'transform="rotate(-90 {at[0]:.1f} {at[1]:.1f})"'
        svg.text(at, words, f'font-size="{letter:g}" fill="{GREY}" {turn}')
    for r, words in enumerate(rows):
        height = top + size * r
        svg.text((left - 6.0, height + 0.5 * size + 0.35 * letter), words, _label(letter))
        for c, cell in enumerate(cells[r]):
            _draw(svg, cell, (left + size * c, height), size)
    return svg.markup


def _label(letter: float) -> str:
    return f'font-size="{letter:g}" fill="{BLACK}" text-anchor="end"'


def _draw(svg: Svg, cell: GridCell, at: tuple[float, float], size: float) -> None:
    shade = min(max(cell.shade, 0.0), 1.0)
    mixed = "".join(f"{round(255 + (end - 255) * shade):02x}" for end in (0x00, 0x72, 0xB2))
    edge = f'stroke="{BLACK}" stroke-width="1.2"' if cell.framed else f'stroke="{RULE}" stroke-width="0.5"'
    svg.rectangle(at, size, size, f'fill="#{mixed}" {edge}')
    if cell.words:
        colour = "#fff" if shade > DARK else BLACK
        middle = (at[0] + 0.5 * size, at[1] + 0.5 * size + 3.5)
        svg.text(middle, cell.words, f'font-size="{min(10.0, 0.42 * size):.1f}" fill="{colour}" text-anchor="middle"')
