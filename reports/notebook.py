"""A result in a notebook's cell: a sentence, the table, a small figure, no script; in a console two of them as text."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from synth.reports.figures.axes import Axes, AxisScale, with_margin
from synth.reports.figures.palette import BLUE, GREEN, GREY, ORANGE, PURPLE, RECORDED, SKY, VERMILION, Line
from synth.reports.figures.svg import Svg, thin_curve

WIDTH, HEIGHT = 460.0, 250.0  # view box; a notebook's cell is some 700 pixels wide
MOST_ROWS = 30
MOST_POINTS = 400  # of a curve: more than a pixel each
# Of the text: a console's usual height and width hold it beside what was typed.
TEXT_ROWS, TEXT_WIDTH, TEXT_CELL, TEXT_HEADLINE = 8, 100, 30, 400
LETTER = 6.2  # width of one at 11 units
COLOURS = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY)


def notebook_html(headline: str, columns: Mapping[str, Sequence[Any]], panel: Mapping[str, Any] | None) -> str:
    """The cell's HTML.

    Parameters
    ----------
    columns : header -> cells, of equal length.
    panel : ``title``, ``x_label``, ``y_label``, ``curves`` (name -> x, y) and ``dots``, the names drawn as points.
    """
    parts = [f"<p><b>{escape(headline)}</b></p>", _table(columns)]
    if panel is not None and panel["curves"]:
        parts.append(f'<div style="max-width:{WIDTH:.0f}px">{_figure(panel)}</div>')
    return f"<div>{''.join(parts)}</div>"


def notebook_text(headline: str, columns: Mapping[str, Sequence[Any]]) -> str:
    """The headline and as much of the table as a console's window shows; ``columns`` as of ``notebook_html``."""
    whole = [
        [_short(head, TEXT_CELL), *(_short(_cell(cell), TEXT_CELL) for cell in cells[:TEXT_ROWS])]
        for head, cells in columns.items()
    ]
    rows = max(map(len, columns.values()), default=0)
    shown: list[list[str]] = []
    used = 0
    for column in whole if rows else ():
        width = max(map(len, column))
        if shown and used + 2 + width > TEXT_WIDTH:
            break
        used += width + (2 if shown else 0)
        shown.append([text.rjust(width) if shown else text.ljust(width) for text in column])
    lines = ["  ".join(row).rstrip() for row in zip(*shown, strict=True)]
    more = [
        f"{count} more {word}"
        for count, word in ((rows - TEXT_ROWS, "rows"), (len(whole) - len(shown), "columns"))
        if count > 0 and rows
    ]
    rest = [f"and {' and '.join(more)}: to_frame()"] if more else []
    return "\n".join([_short(headline, TEXT_HEADLINE), *lines, *rest])


def _short(text: str, most: int) -> str:
    """One line of at most so many characters."""
    line = " ".join(text.split())
    return line if len(line) <= most else f"{line[: most - 1]}…"


def _table(columns: Mapping[str, Sequence[Any]]) -> str:
    heads = "".join(f'<th style="text-align:left">{escape(head)}</th>' for head in columns)
    rows = list(zip(*columns.values(), strict=True))
    body = "".join(f"<tr>{''.join(f'<td>{escape(_cell(cell))}</td>' for cell in row)}</tr>" for row in rows[:MOST_ROWS])
    rest = f"<p>and {len(rows) - MOST_ROWS} more rows: to_frame()</p>" if len(rows) > MOST_ROWS else ""
    return f"<table><thead><tr>{heads}</tr></thead><tbody>{body}</tbody></table>{rest}"


def _cell(value: Any) -> str:
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _figure(panel: Mapping[str, Any]) -> str:
    """The panel as SVG, with curves of different colours, named below it."""
    svg = Svg(WIDTH, HEIGHT, panel["title"])
    xs = [value for x, _ in panel["curves"].values() for value in x]
    ys = [value for _, y in panel["curves"].values() for value in y]
    x_low, x_high = with_margin(xs, share=0.0)
    y_low, y_high = with_margin(ys)
    axes = Axes(AxisScale(x_low, x_high, 52.0, WIDTH - 10.0), AxisScale(y_low, y_high, HEIGHT - 76.0, 22.0))
    axes.frame(svg)
    text = f'font-size="11" fill="{GREY}"'
    svg.text((4.0, 13.0), panel["y_label"], text)
    svg.text((WIDTH - 10.0, HEIGHT - 48.0), panel["x_label"], f'text-anchor="end" {text}')
    curves, dots = panel["curves"], panel["dots"]
    drawn = {name: axes.points(thin_curve(x, y, MOST_POINTS // 2)) for name, (x, y) in curves.items()}
    for name in (name for name in curves if name in dots):
        svg.dots(drawn[name], RECORDED.width, RECORDED.colour)
    entries = [("points: " + ", ".join(name for name in curves if name in dots), GREY)] if dots else []
    for index, name in enumerate(name for name in curves if name not in dots):
        colour = COLOURS[index % len(COLOURS)]
        svg.polyline(drawn[name], Line(colour).style)
        entries.append((name, colour))
    place, row = 52.0, 0
    for name, colour in entries:
        wide = LETTER * len(name) + 14.0
        if place + wide > WIDTH and place > 52.0:  # the left margin
            place, row = 52.0, row + 1
        svg.text((place, HEIGHT - 30.0 + 15.0 * row), name, f'font-size="11" fill="{colour}"', most=70)
        place += wide
    return str(svg.markup)
