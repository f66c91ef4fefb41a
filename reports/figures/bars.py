"""Horizontal bars: named rows, one or more columns of values, each with a label and, if known, an interval."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from synth.reports.figures.axes import AxisScale
from synth.reports.figures.palette import BLACK, BLUE, GREY, RULE
from synth.reports.figures.svg import Svg, shorten_apart

ROW, HEAD, FOOT = 24.0, 24.0, 4.0  # px
WORDS = 70.0  # right of a bar, for its words
GAP = 18.0  # between columns
LETTER = 6.9  # width of a letter of a label, at most
PALE = "#a9cbe4"


@dataclass(frozen=True)
class Bar:
    """One bar; ``strong``: highlighted; ``apart``: of another kind than the other bars, drawn hollow."""

    value: float
    words: str
    low: float | None = None
    high: float | None = None
    strong: bool = False
    apart: bool = False


@dataclass(frozen=True)
class BarColumn:
    """Bars from 0 to ``most`` under a heading; None: no bar in the row. ``words`` : width for labels, drawing units."""

    heading: str
    bars: Sequence[Bar | None]
    most: float
    words: float = WORDS


def bar_figure(title: str, labels: Sequence[str], columns: Sequence[BarColumn], width: float, label: float) -> Markup:
    """Rows of bars, ``label`` of the ``width`` for the rows' names."""
    svg = Svg(width, HEAD + ROW * len(labels) + FOOT, title)
    each = (width - label - GAP * (len(columns) - 1)) / len(columns)
    bottom = HEAD + ROW * len(labels)
    style = f'font-size="11.5" fill="{BLACK}" text-anchor="end"'
    for index, short in enumerate(shorten_apart(labels, max(4, int((label - 10) / LETTER)))):
        svg.text((label - 8, HEAD + ROW * (index + 0.5) + 4), labels[index], style, short=short)
    for index, column in enumerate(columns):
        start = label + index * (each + GAP)
        scale = AxisScale(0.0, column.most if column.most > 0 else 1.0, start, start + each - column.words)
        svg.text((start, 13), column.heading, f'font-size="11" fill="{GREY}"', most=int(each / 6.6))
        svg.line((start, HEAD - 3), (start, bottom + 1), f'stroke="{GREY}" stroke-width="0.9"')
        for row, bar in enumerate(column.bars):
            if bar is not None:
                _draw(svg, bar, scale, HEAD + ROW * (row + 0.5))
    return svg.markup


def _draw(svg: Svg, bar: Bar, scale: AxisScale, height: float) -> None:
    end = scale(min(max(bar.value, 0.0), scale.high))
    fill = f'fill="{BLUE if bar.strong else PALE}"'
    if bar.apart:
        fill = f'fill="#fff" stroke="{GREY}" stroke-dasharray="3 2"'
    svg.line((scale.start, height + 11.5), (scale.end, height + 11.5), f'stroke="{RULE}" stroke-width="0.5"')
    svg.rectangle((scale.start, height - 7), max(end - scale.start, 0.6), 14, fill)
    reach = end
    if bar.low is not None and bar.high is not None and math.isfinite(bar.low) and math.isfinite(bar.high):
        low, high = (scale(min(max(value, 0.0), scale.high)) for value in (bar.low, bar.high))
        reach = max(end, high)
        # White under black: seen on the bar and beside it.
        svg.line((low, height), (high, height), 'stroke="#fff" stroke-width="4"')
        style = f'stroke="{BLACK}" stroke-width="1.4"'
        svg.line((low, height), (high, height), style)
        for place in (low, high):
            svg.line((place, height - 4), (place, height + 4), style)
    weight = ' font-weight="600"' if bar.strong else ""
    svg.text((reach + 6, height + 4), bar.words, f'font-size="11.5" fill="{BLACK}"{weight}')
