"""How far a joint turns: until its links meet, seen along the hinge axis, and as the arms' sweep allows. No solids.

Web, flange, sockets and tubes all reach over z = 0 and are widest there, so what meets does so in that plane first.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from cad.dimensions import JointDimensions
from cad.limits import DimensionProblem
from cad.outline import Disc, Hull, hull_of
from cad.spring_space import PIN_OVERHANG

if TYPE_CHECKING:
    from cad.layout import JointLayout

ROUNDING = 1e-6  # mm, of a gap that is the clearance by construction
HALVINGS = 20  # of half a turn: to 0.0002 deg


def _block(half: float, start: float, end: float) -> Hull:
    """A rectangle of a half width across the link's line, from ``start`` to ``end`` along it (y), mm."""
    return hull_of([Disc(x, y, 0.0) for x in (-half, half) for y in (start, end)])


def _upper(dimensions: JointDimensions, layout: JointLayout) -> list[Hull]:
    """Web and what stands on it: the socket with its tube, or the flange."""
    from cad.hinge import web_outline  # which itself needs the layout
    from cad.mount import flange_size

    start = layout.upper_bottom
    if dimensions.mount is None:
        return [web_outline(layout), *_link(dimensions, layout, start, 1)]
    across, _ = flange_size(dimensions, layout)
    return [web_outline(layout), _block(across / 2, start, start + dimensions.mount.thickness)]


def _link(dimensions: JointDimensions, layout: JointLayout, start: float, way: int) -> list[Hull]:
    """A socket from y = ``way * start`` outwards and the tube in it, as long as the joint's own link."""
    tube = _block(dimensions.link_width / 2, way * start, way * (start + dimensions.link_length))
    return [_block(layout.socket_outer, way * start, way * (start + layout.socket_depth)), tube]


def link_gap(dimensions: JointDimensions, layout: JointLayout, rotation: float) -> float:
    """Least gap (mm) between both links, lower floor plate and web at a ``rotation`` (deg) from straight.

    Canonical sense; 0 or negative where they meet.
    """
    from cad.hinge import tongue_outlines

    lower = [tongue_outlines(dimensions, layout)[0], *_link(dimensions, layout, layout.lower_bottom, -1)]
    turned = [hull.turned(rotation) for hull in lower]
    return min(a.gap(b) for a in _upper(dimensions, layout) for b in turned)


def _meeting(dimensions: JointDimensions, layout: JointLayout, most: float) -> list[DimensionProblem]:
    """A travel beyond ``most`` deg from straight, or at whose ends the links are nearer than the clearance."""
    least = dimensions.clearance - ROUNDING

    def clear(rotation: float) -> bool:
        return abs(rotation) <= most and link_gap(dimensions, layout, rotation) >= least

    low, high = dimensions.range
    if clear(dimensions.opening(low)) and clear(dimensions.opening(high)):
        return []
    limits = []
    for end in (-180.0, 180.0):
        free, met = 0.0, end
        for _ in range(HALVINGS):
            middle = (free + met) / 2
            free, met = (middle, met) if clear(middle) else (free, middle)
        limits.append(dimensions.zero_angle - dimensions.closes * free)
    limits.sort()
    # Rounded inwards: what is said to be allowed is.
    allowed = f"{math.ceil(100 * limits[0]) / 100:.6g} to {math.floor(100 * limits[1]) / 100:.6g} deg"
    reason = "the links would meet" if dimensions.mount is None else "the link would meet the web or the mount's flange"
    return [DimensionProblem(f"{dimensions.name}.range", (low, high), allowed, reason)]


def _stem_half_width(layout: JointLayout) -> float:
    """Half width (mm) of the lower link's stem where it passes the web: it tapers from the tongue to the socket."""
    taper = max(0.0, layout.tongue_radius - layout.socket_outer)
    return layout.socket_outer + taper * (1.0 - layout.web_radius / layout.lower_bottom)


def travel_problems(dimensions: JointDimensions, layout: JointLayout) -> list[DimensionProblem]:
    """Travel that the hinge cannot give: link against web, upper arm shafts against the lower link."""
    low, high = dimensions.range
    half = _stem_half_width(layout) + dimensions.clearance
    largest = 180.0 - 2 * math.degrees(math.atan2(half, layout.web_radius))
    name, found = dimensions.name, _meeting(dimensions, layout, largest)
    if layout.notch[1] - layout.notch[0] > 300.0:
        found.append(
            DimensionProblem(
                f"{name}.range", (low, high), "a smaller travel", "the arm's sweep would take the whole pocket wall"
            )
        )
    if layout.slips[0] > dimensions.pin_diameter / 2 + PIN_OVERHANG:
        found.append(
            DimensionProblem(
                f"{name}.range",
                (low, high),
                "a smaller travel",
                "the closing coil would pull its arms off their shafts",
            )
        )
    margin = math.degrees(math.asin(min(1.0, _stem_half_width(layout) / layout.web_radius)))
    middle = (layout.notch[0] + layout.notch[1]) / 2
    off = abs((middle - 270.0 + 180.0) % 360.0 - 180.0)
    if not found and off - (layout.notch[1] - layout.notch[0]) / 2 < margin:
        found.append(
            DimensionProblem(
                f"{name}.upper_arm_angle",
                dimensions.upper_arm_angle,
                "a direction in which the travel leaves it free, or a smaller range",
                "the upper arm's shafts would sweep through the lower link",
            )
        )
    return found
