"""Heights by model side by side, with intervals, and the published numbers as lines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from synth.reports.figures.axes import TICK, Axes, AxisScale
from synth.reports.figures.palette import BLACK, BLUE, GREY, VERMILION
from synth.reports.figures.svg import Svg

WIDTH, HEIGHT = 620.0, 250.0  # px
LEFT, RIGHT, TOP, BOTTOM = 52.0, 120.0, 16.0, 44.0  # px


@dataclass(frozen=True)
class ModelBar:
    """One model: name, height in m, its 90 % interval if there is one."""

    name: str
    height: float
    low: float | None = None
    high: float | None = None


def models_figure(title: str, bars: Sequence[ModelBar], lines: Sequence[tuple[str, float]]) -> Markup:
    """Bars in centimetres; ``lines``: words and heights (m) to draw across."""
    svg = Svg(WIDTH, HEIGHT, title)
    top = 100 * max([bar.high or bar.height for bar in bars] + [value for _, value in lines] + [1e-3]) * 1.08
    axes = Axes(AxisScale(0, len(bars), LEFT, WIDTH - RIGHT), AxisScale(0.0, top, HEIGHT - BOTTOM, TOP))
    for tick in axes.y.ticks(6):
        y = axes.y(tick)
        svg.line((LEFT, y), (WIDTH - RIGHT, y), 'stroke="#d4d8dd" stroke-width="0.7"')
        svg.text((LEFT - 4, y + 3.5), f"{tick:g}", f'text-anchor="end" {TICK}')
    svg.text((14, HEIGHT / 2), "height [cm]", f'font-size="11" fill="{BLACK}" text-anchor="middle" '
             f'transform="rotate(-90 14 {HEIGHT / 2:.0f})"')  # fmt: skip
    for i, bar in enumerate(bars):
        x = axes.x(i + 0.5)
        y = axes.y(100 * bar.height)
        reach = y  # of bar and whisker: the number stands above both
        svg.rectangle((x - 14, y), 28, HEIGHT - BOTTOM - y, f'fill="{BLUE}" fill-opacity="0.75"')
        if bar.low is not None and bar.high is not None:
            style = f'stroke="{BLACK}" stroke-width="1.3"'
            svg.line((x, axes.y(100 * bar.low)), (x, axes.y(100 * bar.high)), style)
            reach = min(y, axes.y(100 * bar.high))
            for end in (bar.low, bar.high):
                svg.line((x - 5, axes.y(100 * end)), (x + 5, axes.y(100 * end)), style)
        svg.text((x, reach - 4), f"{100 * bar.height:.1f}", f'font-size="10" fill="{GREY}" text-anchor="middle"')
        words = bar.name.split(", ")
        for line, word in enumerate(words):
            svg.text((x, HEIGHT - BOTTOM + 14 + 12 * line), word, f'text-anchor="middle" {TICK}', most=18)
    svg.line((LEFT, HEIGHT - BOTTOM), (WIDTH - RIGHT, HEIGHT - BOTTOM), f'stroke="{GREY}"')
    for label, value in lines:
        y = axes.y(100 * value)
        svg.line((LEFT, y), (WIDTH - RIGHT, y), f'stroke="{VERMILION}" stroke-width="1.5" stroke-dasharray="6 3"')
        svg.text((WIDTH - RIGHT + 4, y + 3.5), label, f'font-size="10.5" fill="{BLACK}"')
    return svg.markup
