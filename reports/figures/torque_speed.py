"""A damper's torque against speed: its law, the competing laws, the vendor's point and the secant through it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from markupsafe import Markup

from synth.reports.figures.axes import Axes, AxisScale
from synth.reports.figures.palette import BLACK, GREY, SECANT, Line
from synth.reports.figures.svg import Point, Svg

WIDTH, HEIGHT = 620.0, 300.0  # px
LEFT, RIGHT, TOP, BOTTOM = 58.0, 16.0, 18.0, 44.0  # px
RPM = math.pi / 30  # rad/s
SAMPLES = 160  # points per curve: one every 4 px

# name of a law -> its torque (N m) at a speed (rad/s), from its parameters in SI. The names are those of design.json.
LAWS: Mapping[str, Callable[[Mapping[str, float], float], float]] = {
    "linear": lambda p, w: p["rate"] * w,
    "power": lambda p, w: p["torque_at_1_rad_per_s"] * w ** p["exponent"],
    "coulomb_viscous": lambda p, w: p["friction"] + p["rate"] * w,
}


@dataclass(frozen=True)
class DrawnLaw:
    """A law to draw: points in (rpm, N m) and how."""

    points: Sequence[Point]
    line: Line


@dataclass(frozen=True)
class Vendor:
    """The vendor's point in (rpm, N m)."""

    speed: float
    torque: float


def law_points(law: str, parameters: Mapping[str, float], fastest: float) -> list[Point] | None:
    """A law from its parameters, up to ``fastest`` rpm; None if it is not in ``LAWS`` or a parameter is missing."""
    formula = LAWS.get(law)
    if formula is None:
        return None
    speeds = [fastest * (i / SAMPLES) ** 2 for i in range(1, SAMPLES + 1)]  # denser where a power law bends
    try:
        return [(speed, formula(parameters, speed * RPM)) for speed in speeds]
    except (KeyError, OverflowError, ZeroDivisionError):
        return None


def torque_speed_figure(title: str, laws: Sequence[DrawnLaw], vendor: Vendor | None, measured: Point | None) -> Markup:
    """One damper. ``measured``: range of speeds (rpm) in the data, shaded."""
    # 6 % beyond the vendor's point.
    fastest = max([x for law in laws for x, _ in law.points] + ([vendor.speed * 1.06] if vendor else []), default=1.0)
    torques = [y for law in laws for x, y in law.points if x <= fastest and math.isfinite(y)]
    highest = max([*torques, *([vendor.torque * 1.06] if vendor else [])], default=1.0)  # as above
    svg = Svg(WIDTH, HEIGHT, title)
    axes = Axes(
        AxisScale(0.0, fastest, LEFT, WIDTH - RIGHT), AxisScale(0.0, highest * 1.05 or 1.0, HEIGHT - BOTTOM, TOP)
    )
    if measured:
        start, end = axes.x(measured[0]), axes.x(min(measured[1], fastest))
        svg.rectangle((start, TOP), max(end - start, 1.0), HEIGHT - BOTTOM - TOP, 'fill="#e8eef5"')
        at_left = end - start < 130
        place = (end + 5, TOP + 11) if at_left else (start + 5, TOP + 11)
        svg.text(place, "speeds in the data", f'font-size="10.5" fill="{GREY}" text-anchor="start"')
    axes.frame(svg, 8, 6)
    axis = f'font-size="11" fill="{BLACK}" text-anchor="middle"'
    svg.text(((axes.x.start + axes.x.end) / 2, HEIGHT - 8), "speed [rpm]", axis)
    middle = (axes.y.start + axes.y.end) / 2
    svg.text((14, middle), "torque [N·m]", f'{axis} transform="rotate(-90 14 {middle:.0f})"')
    if vendor:
        svg.polyline(axes.points([(0.0, 0.0), (vendor.speed, vendor.torque)]), SECANT.style)
    for law in laws:
        svg.polyline(axes.points(law.points), law.line.style)
    if vendor:
        x, y = axes.x(vendor.speed), axes.y(vendor.torque)
        svg.path(f"M{x - 6:.1f} {y:.1f}L{x:.1f} {y - 6:.1f} {x + 6:.1f} {y:.1f} {x:.1f} {y + 6:.1f}Z",
                 f'fill="#fff" stroke="{SECANT.colour}" stroke-width="2"')  # fmt: skip
    return svg.markup
