"""The torque that a model lacks: samples as dots, and in bins the median with the interquartile range."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from markupsafe import Markup

from synth.reports.figures.axes import Axes, AxisScale, with_margin
from synth.reports.figures.palette import BLACK, BLUE, GREEN, GREY, VERMILION, Line
from synth.reports.figures.svg import Point, Svg, shorten

WIDTH, HEIGHT = 960.0, 236.0  # px
LEFT, RIGHT, TOP, BOTTOM = 56.0, 14.0, 24.0, 40.0  # px
MOST_DOTS = 700  # per plot: more cannot be distinguished and increase the page's size
BINS, LEAST_IN_BIN = 21, 8  # of the median line over speed or deflection, and samples for one to be drawn
OUTER = 0.02  # fraction of the samples that may be outside either end of an axis
LAW_POINTS = 160  # of a drawn law: one every few pixels
NAMED = Line(VERMILION, 2.0, "7 3")
FREE = Line(GREEN, 2.0)
Law = Callable[[float], float]
DOT, BAND = "#c3c9cf", "#bfd9ec"


@dataclass(frozen=True)
class Bin:
    """One bin: its middle sample, the median and the quartiles of the torque in it."""

    place: float
    low: float
    median: float
    high: float


@dataclass(frozen=True)
class Cloud:
    """One panel: samples (abscissa, torque), and the label of the abscissa with its unit."""

    joint: str
    abscissa: str
    points: Sequence[Point]
    law: Law | None = None  # of the named effect, over the abscissa's own unit
    free: Sequence[Sequence[Point]] = ()  # a free-form torque, a curve for each direction of motion


def quantile(ordered: Sequence[float], share: float) -> float:
    """Value below which a share of sorted numbers lies, linear between them (Hyndman & Fan 1996, type 7)."""
    place = share * (len(ordered) - 1)
    below = math.floor(place)
    above = min(below + 1, len(ordered) - 1)
    return ordered[below] + (place - below) * (ordered[above] - ordered[below])


def bins_of(points: Sequence[Point], bins: int = BINS) -> list[Bin]:
    """Bins at least as wide as the range over ``bins``, each with at least ``LEAST_IN_BIN`` samples."""
    ordered = sorted(points)
    if len(ordered) < LEAST_IN_BIN or not ordered[-1][0] > ordered[0][0]:
        return []
    width = (ordered[-1][0] - ordered[0][0]) / bins
    held: list[list[Point]] = [[]]
    for point in ordered:
        if len(held[-1]) >= LEAST_IN_BIN and point[0] - held[-1][0][0] > width:
            held.append([])
        held[-1].append(point)
    if len(held) > 1 and len(held[-1]) < LEAST_IN_BIN:
        rest = held.pop()
        held[-1] += rest
    found = []
    for one in held:
        torques = sorted(y for _, y in one)
        low, median, high = (quantile(torques, share) for share in (0.25, 0.5, 0.75))
        found.append(Bin(quantile([x for x, _ in one], 0.5), low, median, high))
    return found


def missing_torque_figure(title: str, clouds: Sequence[Cloud]) -> Markup:
    """One joint's panels side by side, on one torque axis."""
    torques = sorted(y for cloud in clouds for _, y in cloud.points)
    ends = (quantile(torques, OUTER), quantile(torques, 1 - OUTER), 0.0) if torques else (0.0,)
    bins = [bins_of(_without_outermost(cloud.points)) for cloud in clouds]
    vertical = with_margin([*ends, *(one.median for each in bins for one in each)], 0.1)
    svg = Svg(WIDTH, HEIGHT, title)
    width = WIDTH / len(clouds)
    for index, (cloud, each) in enumerate(zip(clouds, bins, strict=True)):
        _draw(svg, cloud, each, vertical, index * width, width)
    return svg.markup


def _ends(points: Sequence[Point]) -> tuple[float, float, float]:
    """Both ends of the abscissa without the outermost samples, and zero, which is always shown."""
    xs = sorted(x for x, _ in points)
    return (quantile(xs, OUTER / 4), quantile(xs, 1 - OUTER / 4), 0.0) if xs else (-1.0, 1.0, 0.0)


def _without_outermost(points: Sequence[Point]) -> list[Point]:
    """The samples without the outermost ones, whose bins would extend beyond the axes."""
    low, high, _ = _ends(points)
    return [point for point in points if low <= point[0] <= high]


def _draw(svg: Svg, cloud: Cloud, bins: Sequence[Bin], vertical: Point, left: float, width: float) -> None:
    span = with_margin(_ends(cloud.points), 0.04)
    axes = Axes(
        AxisScale(*span, left + LEFT, left + width - RIGHT),
        AxisScale(*vertical, HEIGHT - BOTTOM, TOP),
    )
    axes.frame(svg, 7, 5)
    zero = axes.y(0.0)
    svg.line((axes.x.start, zero), (axes.x.end, zero), f'stroke="{GREY}" stroke-width="1"')
    svg.line((axes.x(0.0), TOP), (axes.x(0.0), HEIGHT - BOTTOM), f'stroke="{GREY}" stroke-width="0.6"')
    every = max(1, math.ceil(len(cloud.points) / MOST_DOTS))
    inside = [p for p in cloud.points[::every] if span[0] <= p[0] <= span[1] and vertical[0] <= p[1] <= vertical[1]]
    svg.dots(axes.points(inside), 2.6, DOT)
    _medians(svg, axes, bins)
    if cloud.law is not None:
        _law(svg, axes, cloud.law)
    for curve in cloud.free:
        inside = [(x, y if vertical[0] <= y <= vertical[1] and span[0] <= x <= span[1] else math.nan) for x, y in curve]
        svg.polyline(axes.points(inside), FREE.style)
    words = f'font-size="11" fill="{BLACK}" text-anchor="middle"'
    svg.text(((axes.x.start + axes.x.end) / 2, HEIGHT - 8), cloud.abscissa, words)
    middle = (axes.y.start + axes.y.end) / 2
    svg.text((left + 12, middle), "torque [N·m]", f'{words} transform="rotate(-90 {left + 12:.0f} {middle:.0f})"')
    heading = f"{shorten(cloud.joint, 40)}: missing torque"
    svg.text((left + LEFT, 14), heading, f'font-size="11.5" fill="{BLACK}" font-weight="600"')


def _law(svg: Svg, axes: Axes, law: Law) -> None:
    """The named law over the whole axis, broken where it leaves the axis or jumps at zero."""
    points: list[Point] = []
    for k in range(LAW_POINTS + 1):
        x = axes.x.low + (axes.x.high - axes.x.low) * k / LAW_POINTS
        if points and points[-1][0] < 0.0 <= x:
            points += [(-1e-9, law(-1e-9)), (0.0, math.nan), (1e-9, law(1e-9))]
        if x != 0.0:
            points.append((x, law(x)))
    inside = [(x, y if axes.y.low <= y <= axes.y.high else math.nan) for x, y in points]
    svg.polyline(axes.points(inside), NAMED.style)


def _medians(svg: Svg, axes: Axes, bins: Sequence[Bin]) -> None:
    if not bins:
        return
    least, most = axes.y.low, axes.y.high  # the band ends where the axis does
    upper = axes.points([(one.place, min(one.high, most)) for one in bins])
    lower = axes.points([(one.place, max(one.low, least)) for one in reversed(bins)])
    outline = "L".join(f"{x:.1f} {y:.1f}" for x, y in [*upper, *lower])
    svg.path(f"M{outline}Z", f'fill="{BAND}" fill-opacity="0.75"')
    medians = axes.points([(one.place, one.median) for one in bins])
    svg.polyline(medians, f'stroke="{BLUE}" stroke-width="2" stroke-linejoin="round"')
    for point in medians:
        svg.circle(point, 3, f'fill="{BLUE}"')
