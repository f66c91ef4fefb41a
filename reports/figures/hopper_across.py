"""Errors of predicted jumps against a design's length or ratio: dots a trial, a line for the trend."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from synth.reports.figures.axes import Axes, AxisScale, with_margin
from synth.reports.figures.palette import AFTER, BEFORE, BLACK, GREY, Line
from synth.reports.figures.svg import Svg

WIDTH, HEIGHT = 420.0, 210.0  # px
LEFT, RIGHT, TOP, BOTTOM = 44.0, 12.0, 14.0, 40.0  # px


@dataclass(frozen=True)
class Trend:
    """Errors in per cent against ``x``; ``slope`` in per cent a unit of ``x``, None where it is not known."""

    x: Sequence[float]
    errors: Sequence[float]
    slope: float | None
    line: Line


def across_figure(title: str, axis: str, trends: Sequence[Trend]) -> Markup:
    """Both stages in one panel, the line of no error in grey."""
    svg = Svg(WIDTH, HEIGHT, title)
    places = [x for trend in trends for x in trend.x]
    values = [error for trend in trends for error in trend.errors]
    axes = Axes(
        AxisScale(*with_margin(places), LEFT, WIDTH - RIGHT),
        AxisScale(*with_margin([*values, 0.0]), HEIGHT - BOTTOM, TOP),
    )
    axes.frame(svg)
    zero = axes.y(0.0)
    svg.line((LEFT, zero), (WIDTH - RIGHT, zero), f'stroke="{GREY}" stroke-dasharray="4 3"')
    words = f'font-size="11" fill="{BLACK}" text-anchor="middle"'
    svg.text((0.5 * (LEFT + WIDTH - RIGHT), HEIGHT - 6), axis, words)
    svg.text((12, 0.5 * HEIGHT), "error of the rise [%]", f'{words} transform="rotate(-90 12 {0.5 * HEIGHT:.0f})"')
    for trend in trends:
        svg.dots(axes.points(zip(trend.x, trend.errors, strict=True)), 6.0, trend.line.colour)
        if trend.slope is not None and max(trend.x) > min(trend.x):
            middle, mean = sum(trend.x) / len(trend.x), sum(trend.errors) / len(trend.errors)
            ends = [(x, mean + trend.slope * (x - middle)) for x in (min(trend.x), max(trend.x))]
            svg.polyline(axes.points(ends), f'stroke="{trend.line.colour}" stroke-width="1.4"')
    return svg.markup


STAGES = {"as_designed": BEFORE, "after": AFTER}
