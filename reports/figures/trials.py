"""Angle against time, one panel a joint, one drawing a trial."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from markupsafe import Markup

from reports.figures.axes import Axes, Scale, padded
from reports.figures.palette import BLACK, GREY, Line
from reports.figures.svg import Point, Svg, shortened, thinned
from reports.quantities import unit_text

WIDTH = 960.0
HEIGHT = 172.0  # of a row of panels
LEFT, RIGHT, TOP, BOTTOM = 40.0, 12.0, 22.0, 34.0
MOST_COLUMNS = 3
BUCKETS = 150
LEAST_RANGE = 2.0  # degrees on the angle axis, so that noise does not fill a panel of a joint at rest


@dataclass(frozen=True)
class Curve:
    """One curve of a panel: where its numbers stand, how it is drawn, and what the legend calls it."""

    values: Sequence[float]
    line: Line


@dataclass(frozen=True)
class Panel:
    """One joint of one trial: curves of ``what`` over common times, and a remark for its upper right corner."""

    joint: str
    unit: str
    times: Sequence[float]
    curves: Sequence[Curve]
    remark: str
    what: str = "angle"


@dataclass(frozen=True)
class Limits:
    """Axis ranges that panels share: times, and angles by joint."""

    time: Point | None
    angle: Mapping[str, Point]


def shared_limits(panels: Sequence[Panel]) -> Limits:
    """Ranges that hold all panels; times only where the longest trial is at most 2.5 times the shortest."""
    spans = [(panel.times[0], panel.times[-1]) for panel in panels if len(panel.times) > 1]
    lengths = [end - start for start, end in spans]
    alike = bool(lengths) and max(lengths) <= 2.5 * min(lengths)
    time = (min(start for start, _ in spans), max(end for _, end in spans)) if alike else None
    angle: dict[str, Point] = {}
    for joint in dict.fromkeys(panel.joint for panel in panels):
        values = [v for p in panels if p.joint == joint for curve in p.curves for v in curve.values]
        least = math.radians(LEAST_RANGE) if any(p.unit == "rad" for p in panels if p.joint == joint) else LEAST_RANGE
        angle[joint] = padded(values, least=least)
    return Limits(time, angle)


def columns_for(n_joint: int) -> int:
    """Panels side by side: as many as joints, but where a row of them would be too narrow."""
    return n_joint if n_joint <= MOST_COLUMNS else (2 if n_joint == 4 else MOST_COLUMNS)


def trial_figure(title: str, panels: Sequence[Panel], limits: Limits) -> Markup:
    """All joints of one trial."""
    columns = columns_for(len(panels))
    width = WIDTH if columns > 1 else WIDTH * 0.6
    svg = Svg(width, HEIGHT * math.ceil(len(panels) / columns), title)
    for index, panel in enumerate(panels):
        row, column = divmod(index, columns)
        _draw(svg, panel, limits, (column * width / columns, row * HEIGHT), width / columns)
    return svg.markup


def _draw(svg: Svg, panel: Panel, limits: Limits, corner: Point, width: float) -> None:
    left, top = corner
    start, end = limits.time or (panel.times[0], panel.times[-1])
    low, high = limits.angle[panel.joint]
    axes = Axes(
        Scale(start, end if end > start else start + 1.0, left + LEFT, left + width - RIGHT),
        Scale(low, high, top + HEIGHT - BOTTOM, top + TOP),
    )
    axes.frame(svg)
    unit = unit_text(panel.unit)
    most = max(8, int((width - 110) / 6.2))
    svg.text(
        (left + 4, top + 13),
        f"{shortened(panel.joint, most - len(unit) - len(panel.what) - 4)} {panel.what} [{unit}]",
        f'font-size="11.5" fill="{BLACK}" font-weight="600"',
    )
    svg.text((axes.x.end, top + 13), panel.remark, f'font-size="11" fill="{BLACK}" text-anchor="end"')
    middle = (axes.x.start + axes.x.end) / 2
    svg.text((middle, top + HEIGHT - 7), "time [s]", f'font-size="10" fill="{GREY}" text-anchor="middle"')
    for curve in panel.curves:
        points = axes.points(thinned(panel.times, curve.values, BUCKETS))
        if curve.line.dots:
            svg.dots(points, curve.line.width, curve.line.colour)
        else:
            svg.polyline(points, curve.line.style)
