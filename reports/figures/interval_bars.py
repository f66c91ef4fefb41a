"""Estimates with their 90 % intervals relative to a reference, one row each: what a choice does to them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from synth.reports.figures.axes import Axes, AxisScale, tick_text
from synth.reports.figures.palette import BLACK, BLUE, GREY, RULE, VERMILION
from synth.reports.figures.svg import Svg

WIDTH, LABEL, RIGHT, ROW, TOP, BOTTOM = 760.0, 230.0, 20.0, 22.0, 8.0, 38.0  # px
COLOURS = (BLUE, VERMILION, "#009e73", "#cc79a7")
OPEN = 1e3  # factor at which an open end of an interval is cut


@dataclass(frozen=True)
class IntervalRow:
    """One estimate: its label, group (colour and marker), ratio to the reference and the interval's ends."""

    label: str
    group: int
    ratio: float
    low: float | None
    high: float | None
    first: bool = False  # of a block, drawn with a rule above


def interval_figure(title: str, axis: str, rows: Sequence[IntervalRow]) -> Markup:
    """Rows on a logarithmic axis of ratios; 1 is marked."""
    ends = [1.0 / 1.3, 1.3]
    for row in rows:
        ends += [row.ratio, max(row.low or 1 / OPEN, 1 / OPEN), min(row.high or OPEN, OPEN)]
    low, high = min(ends) / 1.1, max(ends) * 1.1
    svg = Svg(WIDTH, TOP + ROW * len(rows) + BOTTOM, title)
    bottom = TOP + ROW * len(rows)
    x = AxisScale(low, high, LABEL, WIDTH - RIGHT, logarithmic=True)
    axes = Axes(x, AxisScale(0, 1, bottom, TOP))
    at = x.ticks(9)
    for tick in at:
        svg.line((x(tick), TOP), (x(tick), bottom + 3), f'stroke="{RULE}" stroke-width="0.7"')
        svg.text((x(tick), bottom + 14), tick_text(tick, at), f'font-size="10" fill="{GREY}" text-anchor="middle"')
    svg.line((x(1.0), TOP), (x(1.0), bottom), f'stroke="{GREY}" stroke-width="1.2"')
    svg.line((axes.x.start, bottom), (axes.x.end, bottom), f'stroke="{GREY}" stroke-width="0.9"')
    svg.text(((x.start + x.end) / 2, bottom + 31), axis, f'font-size="11" fill="{BLACK}" text-anchor="middle"')
    for index, row in enumerate(rows):
        _draw(svg, row, x, TOP + ROW * (index + 0.5))
    return svg.markup


def _draw(svg: Svg, row: IntervalRow, x: AxisScale, height: float) -> None:
    colour = COLOURS[row.group % len(COLOURS)]
    if row.first:
        svg.line((4, height - ROW / 2), (x.end, height - ROW / 2), f'stroke="{RULE}" stroke-width="0.7"')
    svg.text((LABEL - 8, height + 4), row.label, f'font-size="11" fill="{BLACK}" text-anchor="end"', most=38)
    low = x(max(row.low, x.low)) if row.low else x.start
    high = x(min(row.high, x.high)) if row.high is not None and math.isfinite(row.high) else x.end
    svg.line((low, height), (high, height), f'stroke="{colour}" stroke-width="2"')
    for end, known in ((low, row.low), (high, row.high)):
        if known:
            svg.line((end, height - 4), (end, height + 4), f'stroke="{colour}" stroke-width="1.5"')
    if row.group % 2:
        svg.rectangle((x(row.ratio) - 3.6, height - 3.6), 7.2, 7.2, f'fill="#fff" stroke="{colour}" stroke-width="2"')
    else:
        svg.circle((x(row.ratio), height), 4.2, f'fill="{colour}"')
