"""Clearance over gear ratio and link length as cells, with the Pareto front and the picked design."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from synth.reports.figures.axes import TICK
from synth.reports.figures.palette import BLACK, GREY, VERMILION
from synth.reports.figures.svg import Svg

WIDTH, LEFT, TOP, BOTTOM = 620.0, 66.0, 26.0, 46.0  # px
KEY = 92.0  # room for the colour key
# Light to dark blue, even steps of lightness, readable in grey (ColorBrewer "Blues", Brewer 2003).
SHADES = ("#f7fbff", "#deebf7", "#c6dbef", "#9ecae1", "#6baed6", "#4292c6", "#2171b5", "#08519c", "#08306b")
DARK = SHADES[5:]  # a white mark shows better


@dataclass(frozen=True)
class Map:
    """Heights (m) by ratio and length (m); None without such a design. ``feasible``: the same cells; empty: all."""

    ratios: Sequence[float]
    lengths: Sequence[float]
    heights: Sequence[Sequence[float | None]]
    feasible: Sequence[Sequence[bool]] = ()

    def barred(self, row: int, column: int) -> bool:
        """Whether the design of a cell exceeds a limit."""
        return bool(self.feasible) and not self.feasible[row][column]


def map_figure(
    title: str,
    data: Map,
    front: Sequence[tuple[float, float]],
    picked: tuple[float, float] | None,
    other: tuple[float, float] | None = None,
) -> Markup:
    """Cells by (ratio, length in m); designs beyond a limit as triangles, ``front`` as dots, ``picked`` as a ring,
    ``other`` as a diamond.
    """
    rows, columns = len(data.ratios), len(data.lengths)
    cell = (WIDTH - LEFT - KEY) / columns
    high = 22.0 if rows < 20 else 14.0  # so that up to 40 motors fit on a screen
    height = TOP + rows * high + BOTTOM
    svg = Svg(WIDTH, height, title)
    values = [value for row in data.heights for value in row if value is not None]
    top = max([*values, 1e-6])
    for i, row in enumerate(data.heights):
        y = TOP + (rows - 1 - i) * high
        for k, value in enumerate(row):
            colour = "#ffffff" if value is None else SHADES[min(len(SHADES) - 1, int(value / top * len(SHADES)))]
            svg.rectangle((LEFT + k * cell, y), cell, high, f'fill="{colour}" stroke="#fff" stroke-width="0.4"')
            if data.barred(i, k):
                _triangle(svg, (LEFT + (k + 0.5) * cell, y + high / 2), on_dark=colour in DARK)
        svg.text((LEFT - 5, y + high / 2 + 3.5), f"{data.ratios[i]:.0f}:1", f'text-anchor="end" {TICK}')
    every = max(1, columns // 8)
    for k in range(0, columns, every):
        place = (LEFT + (k + 0.5) * cell, TOP + rows * high + 13)
        svg.text(place, f"{data.lengths[k] * 1000:.4g}", f'text-anchor="middle" {TICK}')
    axis = f'font-size="11" fill="{BLACK}" text-anchor="middle"'
    svg.text((LEFT + (WIDTH - LEFT - KEY) / 2, height - 12), "upper link length [mm]", axis)
    svg.text((LEFT - 5, TOP - 10), "gear ratio", f'font-size="11" fill="{BLACK}" text-anchor="end"')

    def centre(design: tuple[float, float]) -> tuple[float, float] | None:
        ratio, length = design
        i = min(range(rows), key=lambda m: abs(data.ratios[m] - ratio))
        k = min(range(columns), key=lambda m: abs(data.lengths[m] - length))
        if abs(data.ratios[i] - ratio) > 0.01 * ratio:  # the same nominal ratio
            return None  # of another family
        return LEFT + (k + 0.5) * cell, TOP + (rows - 0.5 - i) * high

    for design in front:
        if (at := centre(design)) is not None:
            svg.circle(at, 3.2, f'fill="{VERMILION}" stroke="#fff" stroke-width="0.8"')
    if picked is not None and (at := centre(picked)) is not None:
        svg.circle(at, 7.5, f'fill="none" stroke="{VERMILION}" stroke-width="2.4"')
    if other is not None and (at := centre(other)) is not None:
        x, y = at
        svg.path(f"M{x - 7:.1f} {y:.1f}L{x:.1f} {y - 7:.1f} {x + 7:.1f} {y:.1f} {x:.1f} {y + 7:.1f}Z",
                 f'fill="none" stroke="{BLACK}" stroke-width="2"')  # fmt: skip
    _key(svg, top)
    return svg.markup


def _triangle(svg: Svg, at: tuple[float, float], *, on_dark: bool) -> None:
    """The mark of a design that exceeds a limit."""
    (x, y), colour = at, "#fff" if on_dark else BLACK
    svg.path(f"M{x - 3:.1f} {y + 2.6:.1f}L{x:.1f} {y - 2.6:.1f} {x + 3:.1f} {y + 2.6:.1f}Z",
             f'fill="none" stroke="{colour}" stroke-width="0.9"')  # fmt: skip


def _key(svg: Svg, top: float) -> None:
    x = WIDTH - KEY + 22
    for step, colour in enumerate(reversed(SHADES)):
        y = TOP + step * 13
        svg.rectangle((x, y), 14, 13, f'fill="{colour}" stroke="{GREY}" stroke-width="0.3"')
        upper = top * (len(SHADES) - step) / len(SHADES)
        svg.text((x + 19, y + 4), f"{upper * 100:.1f}", TICK)
    svg.text((x + 19, TOP + len(SHADES) * 13 + 4), "0 cm", TICK)
