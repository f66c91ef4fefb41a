"""The jump of one leg: curves over time, and a strip of its poses."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from synth.reports.figures.palette import BLACK, BLUE, GREY, RULE, VERMILION
from synth.reports.figures.svg import Svg

STRIP_HEIGHT = 250.0  # px


@dataclass(frozen=True)
class Geometry:
    """Lengths in m; ``split``: the upper link is two halves."""

    spacing: float
    upper: float
    lower: float
    split: bool


@dataclass(frozen=True)
class Pose:
    """One instant: time (s), hips' height (m), angles of the upper link's begin and end and the lower link (deg)."""

    time: float
    height: float
    upper: float
    upper_end: float
    lower: float


def strip_figure(geometry: Geometry, poses: Sequence[Pose]) -> Markup:
    """The leg at several instants side by side over the ground."""
    reach = geometry.upper + geometry.lower
    highest = max([pose.height for pose in poses] + [reach]) * 1.08  # 8 % of space above
    scale = min((STRIP_HEIGHT - 46) / highest, 1000.0 / (len(poses) * 2.1 * (geometry.spacing / 2 + geometry.upper)))
    step = 1000.0 / len(poses)
    ground = STRIP_HEIGHT - 26
    svg = Svg(1000.0, STRIP_HEIGHT, "poses of the leg through the jump")
    svg.line((0, ground), (1000, ground), f'stroke="{BLACK}" stroke-width="1.4"')
    for i, pose in enumerate(poses):
        x0 = (i + 0.5) * step
        _draw(svg, geometry, pose, x0, ground, scale)
        label = f'font-size="10.5" fill="{GREY}" text-anchor="middle"'
        svg.text((x0, STRIP_HEIGHT - 9), f"{pose.time * 1e3:.0f} ms", label)
        svg.line((x0 + step / 2, 8), (x0 + step / 2, ground), f'stroke="{RULE}" stroke-width="0.6"')
    return svg.markup


def _draw(svg: Svg, geometry: Geometry, pose: Pose, x0: float, ground: float, scale: float) -> None:
    """One pose: body, upper links (bent where they bend), lower links, joints."""

    def at(x: float, y: float) -> tuple[float, float]:
        return x0 + x * scale, ground - y * scale

    for side in (1.0, -1.0):
        points = [(side * geometry.spacing / 2, pose.height)]
        pieces = [(geometry.upper, pose.upper)]
        if geometry.split:
            pieces = [(geometry.upper / 2, pose.upper), (geometry.upper / 2, pose.upper_end)]
        for length, angle in [*pieces, (geometry.lower, -pose.lower)]:
            x, y = points[-1]
            turn = math.radians(angle)
            points.append((x + side * length * math.sin(turn), y - length * math.cos(turn)))
        drawn = [at(*point) for point in points]
        knee = len(pieces)
        svg.polyline(drawn[: knee + 1], f'stroke="{BLUE}" stroke-width="3" stroke-linejoin="round"')
        svg.polyline(drawn[knee:], f'stroke="{VERMILION}" stroke-width="3"')
        for place in (drawn[0], drawn[knee], drawn[-1]):
            svg.circle(place, 2.6, f'fill="#fff" stroke="{BLACK}" stroke-width="1.1"')
    left, y = at(-geometry.spacing / 2 - 0.006, pose.height + 0.012)
    svg.rectangle((left, y), (geometry.spacing + 0.012) * scale, 0.012 * scale, f'fill="{GREY}"')
