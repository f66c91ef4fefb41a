"""Angle against time, one panel per joint, one drawing per trial."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from markupsafe import Markup

from synth.reports.figures.axes import Axes, AxisScale, with_margin
from synth.reports.figures.palette import BLACK, GREY, Line
from synth.reports.figures.svg import Point, Svg, shorten_apart, thin_curve
from synth.reports.quantities import unit_text
from synth.reports.scripts import data_block

WIDTH, HEIGHT = 340.0, 172.0  # of a panel: as wide as a telephone
LEFT, RIGHT, TOP, BOTTOM = 40.0, 12.0, 22.0, 34.0  # px
TITLE_LETTER, REMARK_LETTER = 7.3, 6.4  # px, of a bold letter of 11.5 px and one of 11, on average
BUCKETS = 150  # least and greatest value of each are drawn: one every 2 px
MOST_SAMPLES = 600  # of a curve for the page's cursor and tables; the folder's file has all samples
LEAST_RANGE = 2.0  # degrees on the angle axis, so that noise does not fill a panel of a joint at rest


@dataclass(frozen=True)
class Curve:
    """One curve of a panel: its numbers, how it is drawn, and what the legend and the cursor call it."""

    values: Sequence[float]
    line: Line
    name: str = ""
    hidden: bool = False  # until it is switched on in the page


@dataclass(frozen=True)
class TrialPanel:
    """One joint of one trial: curves of ``what`` over common times, and a remark for its upper right corner.

    ``clock`` : what the times are, s.
    """

    joint: str
    unit: str
    times: Sequence[float]
    curves: Sequence[Curve]
    remark: str
    what: str = "angle"
    clock: str = "time"


@dataclass(frozen=True)
class AxisRanges:
    """Axis ranges that panels share: times, and angles by joint."""

    time: Point | None
    angle: Mapping[str, Point]


def shared_limits(panels: Sequence[TrialPanel]) -> AxisRanges:
    """Ranges for all panels; of times only if the longest trial is at most 2.5 times as long as the shortest."""
    spans = [(panel.times[0], panel.times[-1]) for panel in panels if len(panel.times) > 1]
    lengths = [end - start for start, end in spans]
    alike = bool(lengths) and max(lengths) <= 2.5 * min(lengths)
    time = (min(start for start, _ in spans), max(end for _, end in spans)) if alike else None
    angle: dict[str, Point] = {}
    for joint in dict.fromkeys(panel.joint for panel in panels):
        values = [v for p in panels if p.joint == joint for curve in p.curves if not curve.hidden for v in curve.values]
        least = math.radians(LEAST_RANGE) if any(p.unit == "rad" for p in panels if p.joint == joint) else LEAST_RANGE
        angle[joint] = with_margin(values, least=least)
    return AxisRanges(time, angle)


def trial_figure(title: str, panels: Sequence[TrialPanel], limits: AxisRanges, trial: str = "") -> Markup:
    """All joints of one trial, a drawing each, side by side if there is space.

    ``trial`` names the recording; plots of the same one share the page's cursor.
    """
    most = min((_letters(panel) for panel in panels), default=0)
    names = shorten_apart([panel.joint for panel in panels], most)
    shown = Markup("").join(
        _drawing(f"{title}, {panel.joint}", panel, limits, name) for panel, name in zip(panels, names, strict=True)
    )
    return Markup('<div class="panels" data-trial="{}">{}</div>').format(trial, shown)


def _letters(panel: TrialPanel) -> int:
    """Letters of a joint's name that fit before what is drawn, its unit and the panel's remark."""
    room = WIDTH - RIGHT - 4 - 10 - REMARK_LETTER * len(panel.remark)
    return max(6, int(room / TITLE_LETTER) - len(unit_text(panel.unit)) - len(panel.what) - 4)


def _drawing(title: str, panel: TrialPanel, limits: AxisRanges, name: str) -> Markup:
    """The panel's drawing and its numbers for the cursor."""
    start, end = limits.time or (panel.times[0], panel.times[-1])
    low, high = limits.angle[panel.joint]
    axes = Axes(
        AxisScale(start, end if end > start else start + 1.0, LEFT, WIDTH - RIGHT),
        AxisScale(low, high, HEIGHT - BOTTOM, TOP),
    )
    svg = Svg(WIDTH, HEIGHT, title)
    axes.frame(svg)
    unit = unit_text(panel.unit)
    words = f"{panel.what} [{unit}]"
    style = f'font-size="11.5" fill="{BLACK}" font-weight="600"'
    svg.text((4, 13), f"{panel.joint} {words}", style, short=f"{name} {words}")
    svg.text((axes.x.end, 13), panel.remark, f'font-size="11" fill="{BLACK}" text-anchor="end"')
    middle = (axes.x.start + axes.x.end) / 2
    svg.text((middle, HEIGHT - 7), f"{panel.clock} [s]", f'font-size="10" fill="{GREY}" text-anchor="middle"')
    for curve in panel.curves:
        points = axes.points(thin_curve(panel.times, curve.values, BUCKETS))
        with svg.named(curve.name, hidden=curve.hidden):
            if curve.line.dots:
                svg.dots(points, curve.line.width, curve.line.colour)
            else:
                svg.polyline(points, curve.line.style)
    return Markup('<div class="plot">{}<script type="application/json">{}</script></div>').format(
        svg.markup, data_block(_numbers(panel, axes, unit))
    )


def _numbers(panel: TrialPanel, axes: Axes, unit: str) -> dict[str, Any]:
    """Data for the cursor: both scales and every curve, at most ``MOST_SAMPLES`` samples each."""
    every = max(1, math.ceil(len(panel.times) / MOST_SAMPLES))
    return {
        "joint": panel.joint,
        "what": panel.what,
        "unit": unit,
        "x": [axes.x.low, axes.x.high, axes.x.start, axes.x.end],
        "y": [axes.y.low, axes.y.high, axes.y.start, axes.y.end],
        "time": _short(panel.times[::every]),
        "curves": [{"name": c.name, "dots": c.line.dots, "values": _short(c.values[::every])} for c in panel.curves],
    }


def _short(values: Sequence[float]) -> list[float | None]:
    """Five digits of each; None for what is missing."""
    texts = ("%.5g " * len(values) % tuple(values)).split()
    if math.isfinite(sum(values)):
        return list(map(float, texts))
    return [float(text) if math.isfinite(value) else None for text, value in zip(texts, values, strict=True)]
