"""Hard stops: two horns on the lower half's floor plate, whose flanks meet the corners of the upper half's web.

A horn's flank is a plane through the hinge axis; the web's corner is a cylinder parallel to it, of radius r at the
distance c. They touch along a line if the angle between the flank and the direction of the cylinder's axis is
``asin(r/c)``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from synth.cad.dimensions import JointDimensions
from synth.cad.outline import Point, unit

PAST = 1.0  # mm, projection of a horn beyond its contact line


@dataclass(frozen=True)
class Stop:
    """One horn, in the lower half's frame at q = 0, canonical sense."""

    angle: float  # measured deg at which it touches
    flank: float  # deg, direction of the flank that touches
    way: int  # +1: the horn lies counter-clockwise of its flank; -1: clockwise
    inner: float  # mm from the hinge axis
    outer: float
    width: float  # mm, square to the flank

    def outline(self) -> list[Point]:
        """Corners of the horn seen along z, counter-clockwise."""
        along, aside = unit(self.flank), unit(self.flank + 90.0 * self.way)
        corners = [(self.inner, 0.0), (self.outer, 0.0), (self.outer, self.width), (self.inner, self.width)]
        points = [(r * along[0] + n * aside[0], r * along[1] + n * aside[1]) for r, n in corners]
        return points if self.way > 0 else points[::-1]


def web_corner(web_radius: float, web_thickness: float, socket_outer: float) -> tuple[Point, float]:
    """Axis (mm) of the web's corner at +x and its radius."""
    radius = web_thickness / 2
    return (socket_outer - radius, web_radius + web_thickness - radius), radius


def contact_angle(web_radius: float, web_thickness: float, socket_outer: float) -> float:
    """Angle (deg) from the upper link's line to a horn's flank that touches the web's corner."""
    (x, y), radius = web_corner(web_radius, web_thickness, socket_outer)
    return math.degrees(math.atan2(x, y) + math.asin(radius / math.hypot(x, y)))


def lay_stops(
    dimensions: JointDimensions, web_radius: float, web_thickness: float, socket_outer: float
) -> tuple[Stop, Stop]:
    """The horns for the low and the high stop.

    Turning counter-clockwise (opening) a horn comes to the web from its right; the flank is then at 90 deg less the
    contact's angle.
    """
    beside = contact_angle(web_radius, web_thickness, socket_outer)
    width = max(3 * dimensions.wall, 6.0)
    corner, radius = web_corner(web_radius, web_thickness, socket_outer)
    outer = math.sqrt(corner[0] ** 2 + corner[1] ** 2 - radius**2) + PAST
    stops = []
    for angle in dimensions.stop_angles:
        rotation = dimensions.opening(angle)
        # Which of both ends is reached by turning counter-clockwise follows from the sense of the angle.
        right = rotation >= max(dimensions.opening(end) for end in dimensions.stop_angles) - 1e-9
        flank = 90.0 - beside - rotation if right else 90.0 + beside - rotation
        stops.append(Stop(angle, flank, -1 if right else 1, 0.0, outer, width))
    return stops[0], stops[1]
