"""The two printed halves of a hinge, in the canonical frame of ``cad.layout``.

Upper half: a clevis of two ears with the shaft's bearings; ear B carries the upper arm's seat plate, ear A the damper
bracket. Lower half: a tongue that is pinned to the shaft; its cup is the spring's pocket, its floor plate carries the
lower arm's seat and the horns of the hard stops.
"""

from __future__ import annotations

import math
from typing import Any

from synth.cad import kernel
from synth.cad.arm_layout import OVERHANG, ArmLayout
from synth.cad.arm_shaft import cross_hole, cross_volume
from synth.cad.dimensions import JointDimensions
from synth.cad.encoder_seat import seat_height
from synth.cad.hardware import insert_of, screw_of
from synth.cad.kernel import prism
from synth.cad.layout import (
    BEARING_SUNK,
    SUNK_ASIDE,
    JointLayout,
    bearing_pocket,
    fixing_screw,
    sunk_depth,
    window_half,
)
from synth.cad.link_socket import SocketScrew, socket_screw
from synth.cad.mount import build_flange, flange_volume
from synth.cad.outline import Hull, Point
from synth.cad.outlines import cup_outline, ear_outlines, floor_outline, web_outline
from synth.cad.screw_places import bracket_screws, encoder_screws
from synth.cad.seat_scale import ear_marks, ear_marks_volume
from synth.cad.shaft_line import BLIND, ShaftLine, lay_shaft

THINNEST_CHEEK = 2.0  # walls; least thickness of print beside the lower arm's slot and seat


def bore_radius(dimensions: JointDimensions) -> float:
    """Radius (mm) of the ears' bores outside their bearings, with clearance to the shaft.

    At least half of a thrust washer's width rests on the lip. The shaft runs in the bearing, so less clearance than
    elsewhere does no harm.
    """
    washer = dimensions.hardware.washer
    return dimensions.shaft_diameter / 2 + min(dimensions.clearance, (washer.outer_diameter - washer.bore) / 4)


def pocket_depth(dimensions: JointDimensions) -> float:
    """Depth (mm) of an ear's pocket for its bearing, from inside."""
    return dimensions.hardware.bearing.width + BEARING_SUNK


def cylinder(radius: float, bottom: float, top: float, at: Point = (0.0, 0.0)) -> Any:
    """A cylinder parallel to the hinge axis."""
    return kernel.cylinder(radius, top - bottom, (at[0], at[1], bottom))


def box(x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]) -> Any:
    """A cuboid along the axes, between two places on each."""
    return kernel.block((x[1] - x[0], y[1] - y[0], z[1] - z[0]), (x[0], y[0], z[0]))


def in_arm_frame(solid: Any, arm: ArmLayout) -> Any:
    """A solid drawn along x from the tangent point, brought to an arm."""
    return solid.rotate((0, 0, 0), (0, 0, 1), arm.direction).translate((*arm.tangent, 0))


def ring_sector(inner: float, outer: float, sector: tuple[float, float], bottom: float, top: float) -> Any:
    """A sector of a ring between two angles, deg."""
    whole = kernel.cylinder(outer, top - bottom, (0.0, 0.0, bottom), angle=sector[1] - sector[0])
    return whole.rotate((0, 0, 0), (0, 0, 1), sector[0]).cut(cylinder(inner, bottom - 1, top + 1))


def v_groove(arm: ArmLayout, wire: float, way: int) -> Any:
    """The tool that cuts an arm's V of 90 deg into its pad: open towards ``way`` (+1: up), along the sloped wire."""
    norm = math.hypot(1.0, arm.slope)
    start = arm.free - 0.5
    length = arm.seat.length + OVERHANG + 1.5
    deep = wire / math.sqrt(2)
    wide = deep + 0.75 * wire
    up = (-arm.slope / norm * way, way / norm)  # square to the wire, in the plane of s and z, out of the pad
    s, z = start, arm.wire_height(start)

    def corner(n: float, b: float) -> tuple[float, float, float]:
        return s + b * up[0], n, z + b * up[1]

    points = [corner(0.0, -deep), corner(wide, wide - deep), corner(-wide, wide - deep)]
    return in_arm_frame(prism(points, (length, 0.0, length * arm.slope)), arm)


def _socket(dimensions: JointDimensions, layout: JointLayout, start: float, way: int) -> tuple[Any, list[Any]]:
    """A round socket for the link's tube from y = way * start outwards: its body, and what is cut from it."""
    along = ((0.0, way * start, 0.0), (0.0, way, 0.0))
    body = kernel.cylinder(layout.socket_outer, layout.socket_depth, *along)
    bore = kernel.cylinder(dimensions.link_width / 2 + dimensions.fit, layout.socket_depth + 1, *along)
    at = (0.0, socket_screw_at(layout, start, way))
    screw, far = cross_screw(layout), layout.socket_outer + 1
    cuts = [bore, cylinder(screw.screw.hole / 2, -far, far, at)]
    cuts += [cylinder(screw.spot, low, high, at) for low, high in ((screw.flat, far), (-far, -screw.flat))]
    return body, cuts


def socket_screw_at(layout: JointLayout, start: float, way: int) -> float:
    """Y (mm) of the screw through a socket."""
    return way * (start + layout.socket_depth / 2)


def cross_screw(layout: JointLayout) -> SocketScrew:
    """The screw through a socket and its tube."""
    found = socket_screw(layout.socket_outer)
    assert found is not None  # checked when the joint was laid out
    return found


def build_upper(dimensions: JointDimensions, layout: JointLayout) -> Any:
    """The clevis as a cadquery Solid; the upper link points along +y."""
    low, high = -layout.gap_a, layout.gap_b
    bottom, top = low - layout.ear, high + layout.ear
    ear_a, ear_b = ear_outlines(dimensions, layout)
    web = web_outline(layout).extrude(low, high)
    if dimensions.mount is None:
        end, cuts = _socket(dimensions, layout, layout.upper_bottom, 1)
    else:
        end, cuts = build_flange(dimensions, layout)
    cuts.append(cylinder(bore_radius(dimensions), bottom - 1, top + 1))
    pocket, deep = bearing_pocket(dimensions), pocket_depth(dimensions)
    cuts += [cylinder(pocket, low - deep, low + 1), cylinder(pocket, high - 1, high + deep)]
    for place in bracket_screws(dimensions, layout):
        cuts.append(cylinder(place.screw.hole / 2, bottom - 1, low, place.at))
        cuts.append(cylinder(place.screw.head_diameter / 2 + SUNK_ASIDE, place.face, low + 0.3, place.at))
    if dimensions.encoder is not None:
        hole = insert_of(fixing_screw(dimensions.encoder.bolt_diameter).size).hole / 2
        places = encoder_screws(dimensions, layout, seat_height(dimensions))
        cuts += [cylinder(hole, high, top + 1, place.at) for place in places]
    cuts += _scale(dimensions, layout, high, top)
    if layout.mirrored:
        cuts += [cut.mirror("XY") for cut in _scale(dimensions, layout, -low, -bottom)]
        cuts += [cut.mirror("XY") for cut in _sunk(layout, -bottom)]
    body = ear_a.extrude(bottom, low).fuse(ear_b.extrude(high, top), web, end)
    return body.cut(*cuts)


def _arcs(layout: JointLayout, half_width: float) -> list[tuple[float, float]]:
    """Sectors (deg) of the seat plate's screws, to ``half_width`` mm beside their axes."""
    plate = layout.plate
    half = plate.travel + math.degrees(math.asin(half_width / plate.radius))
    return [(angle - half, angle + half) for angle in plate.angles]


def _window(layout: JointLayout) -> tuple[float, float]:
    """Sector (deg) of the window over the seat plate's marks."""
    half = window_half(layout.plate.travel)
    return layout.plate.window - half, layout.plate.window + half


def _scale(dimensions: JointDimensions, layout: JointLayout, low: float, top: float) -> list[Any]:
    """Cuts in an ear: the screws' slots, the window, its marks and its pit."""
    plate, half = layout.plate, screw_of(layout.seat.screw).hole / 2
    inner, outer = plate.radius - half, plate.radius + half
    cuts = [ring_sector(inner, outer, arc, low - 1, top + 1) for arc in _arcs(layout, half)]
    cuts.append(ring_sector(inner, outer, _window(layout), low - 1, top + 1))
    return [*cuts, *ear_marks(dimensions, layout, top)]


def _sunk(layout: JointLayout, top: float) -> list[Any]:
    screw = screw_of(layout.seat.screw)
    half, depth = screw.washer / 2 + SUNK_ASIDE, sunk_depth(screw)
    radius = layout.plate.radius
    return [ring_sector(radius - half, radius + half, arc, top - depth, top + 1) for arc in _arcs(layout, half)]


def build_lower(dimensions: JointDimensions, layout: JointLayout) -> Any:
    """The tongue as a cadquery Solid; the lower link points along -y."""
    half, floor_top, floor_bottom = layout.half_width, layout.floor_top, layout.floor_bottom
    cup = cup_outline(layout)
    socket, cuts = _socket(dimensions, layout, layout.lower_bottom, -1)
    horns = [
        prism([(x, y, floor_bottom) for x, y in stop.outline()], (0.0, 0.0, floor_top - floor_bottom))
        for stop in layout.stops
    ]
    pad_top = layout.lower.wire_height(layout.lower.middle)
    # Prisms that share only a face, because kernels fail on coincident cylinders.
    cups = [cup.extrude(floor_top, half), layout.lower.outline().extrude(floor_top, pad_top)]
    pocket = cylinder(layout.space.pocket_radius, floor_top, half + 1)
    if layout.space.arbor_radius:
        pocket = pocket.cut(cylinder(layout.space.arbor_radius, floor_top, half + 1))
    rooms = [pocket, _lower_slot(dimensions, layout, cup), _seat_room(dimensions, layout, cup, pad_top)]
    rooms += [v_groove(layout.lower, dimensions.spring.wire_diameter, 1), _upper_notch(dimensions, layout)]
    if layout.mirrored:
        cups, rooms = ([*shapes, *(shape.mirror("XY") for shape in shapes)] for shapes in (cups, rooms))
    body = floor_outline(layout).extrude(floor_bottom, floor_top).fuse(*cups, *horns, socket)
    cuts += rooms
    cuts.append(cylinder(dimensions.shaft_diameter / 2 + dimensions.fit, -half - 1, half + 1))
    cuts.append(_pin_hole(layout, lay_shaft(dimensions, layout, 0.0)))
    hole = insert_of(layout.seat.screw).hole / 2
    cuts += [cylinder(hole, -half - 1, half + 1, at) for at in layout.lower.screws]
    return body.cut(*cuts)


def _pin_hole(layout: JointLayout, line: ShaftLine) -> Any:
    """The hole for pushing the pin through floor and shaft: open on one side, blind on the other."""
    reach = floor_outline(layout).reach(line.pin_angle) + 1.0
    start = -line.pin.length / 2 - BLIND
    return cross_hole(line.pin_height, line.pin.size / 2, reach, line.pin_angle, start)


def _open_edge(edge: float, hull: Hull, arm: ArmLayout, way: int, start: float, wall: float) -> float:
    """The edge of a cut across an arm, ``edge`` mm from it; farther out if a thin wall would remain beside it.

    ``way`` +1: outwards; -1: inwards. ``start`` mm: distance of the arm's line from the hinge.
    """
    outside = hull.reach(arm.direction + 90.0 * arm.side * way) - way * start
    return outside + 1.0 if outside - edge < THINNEST_CHEEK * wall else edge


def _lower_slot(dimensions: JointDimensions, layout: JointLayout, cup: Hull) -> Any:
    """The path of the lower arm out of the pocket to its seat, open at the top for inserting the spring."""
    arm, spring = layout.lower, dimensions.spring
    width = spring.wire_diameter / 2 + dimensions.clearance
    outside = _open_edge(width + layout.space.sway_out, cup, arm, 1, spring.radius, dimensions.wall)
    inside = width + layout.space.sway_in
    slot = box((0.0, arm.free + 0.5), (-inside, outside), (layout.floor_top, layout.half_width + 1))
    return in_arm_frame(slot, arm)


def _seat_room(dimensions: JointDimensions, layout: JointLayout, cup: Hull, pad_top: float) -> Any:
    """Space over the lower arm's pad for cap, screws and a driver."""
    arm, radius, wall = layout.lower, dimensions.spring.radius, dimensions.wall
    edge = arm.seat.half_width + dimensions.clearance
    outside = _open_edge(edge, cup, arm, 1, radius, wall)
    end = arm.free + arm.seat.length + OVERHANG + dimensions.clearance
    far = cup.reach(arm.direction)
    end = far + 1.0 if far - end < THINNEST_CHEEK * wall else end
    room = box((arm.free - dimensions.clearance, end), (-edge, outside), (pad_top, layout.half_width + 1))
    return in_arm_frame(room, arm)


def _upper_notch(dimensions: JointDimensions, layout: JointLayout) -> Any:
    """The sector of the pocket's wall that the upper arm sweeps."""
    inner = layout.space.pocket_radius - dimensions.clearance / 2
    return ring_sector(inner, layout.web_radius, layout.notch, layout.notch_bottom, layout.half_width + 1)


def upper_volume(dimensions: JointDimensions, layout: JointLayout) -> float:
    """Volume of :func:`build_upper`, mm^3, in closed form except for one integral of the cross screw."""
    ear_a, ear_b = ear_outlines(dimensions, layout)
    plate = layout.ear
    bore, pocket = math.pi * bore_radius(dimensions) ** 2, math.pi * bearing_pocket(dimensions) ** 2
    deep = pocket_depth(dimensions)
    ears = (ear_a.area + ear_b.area) * plate - 2 * (bore * (plate - deep) + pocket * deep)
    for place in bracket_screws(dimensions, layout):
        sunk = -layout.gap_a - place.face
        head = place.screw.head_diameter / 2 + SUNK_ASIDE
        ears -= math.pi * (head**2 * sunk + (place.screw.hole / 2) ** 2 * (plate - sunk))
    if dimensions.encoder is not None:
        hole = insert_of(fixing_screw(dimensions.encoder.bolt_diameter).size).hole / 2
        ears -= dimensions.encoder.bolt_count * math.pi * hole**2 * plate
    scale = _scale_volume(dimensions, layout, plate)
    ears -= scale
    if layout.mirrored:
        screw = screw_of(layout.seat.screw)
        half, depth, hole = screw.washer / 2 + SUNK_ASIDE, sunk_depth(screw), screw.hole / 2
        slots = sum(_sector_area(layout, arc, hole) for arc in _arcs(layout, hole))
        ears -= scale + depth * (sum(_sector_area(layout, arc, half) for arc in _arcs(layout, half)) - slots)
    web = (layout.gap_a + layout.gap_b) * web_outline(layout).area
    if dimensions.mount is not None:
        return ears + web + flange_volume(dimensions, layout)
    outer = layout.socket_outer
    inner = dimensions.link_width / 2 + dimensions.fit
    socket = math.pi * (outer**2 - inner**2) * layout.socket_depth
    return ears + web + socket - _socket_cuts(layout, inner)


def _sector_area(layout: JointLayout, arc: tuple[float, float], half: float) -> float:
    return math.radians(arc[1] - arc[0]) * layout.plate.radius * 2 * half


def _scale_volume(dimensions: JointDimensions, layout: JointLayout, plate: float) -> float:
    """Volume (mm^3) of slots, window, marks and pit in an ear."""
    half = screw_of(layout.seat.screw).hole / 2
    through = sum(_sector_area(layout, arc, half) for arc in (*_arcs(layout, half), _window(layout)))
    return through * plate + ear_marks_volume(dimensions, layout)


def _socket_cuts(layout: JointLayout, inner: float) -> float:
    """Volume (mm^3) of the cross screw's hole and the flats for its head and nut in a socket."""
    screw = cross_screw(layout)
    outer = layout.socket_outer
    # Above the flats, hole and spot overlap: the spot's cap is counted in full and the hole only below it.
    hole = screw.screw.hole / 2
    cap = cap_volume(outer, screw.flat, screw.spot) - cap_volume(outer, screw.flat, hole)
    return cross_volume(outer, inner, hole) + 2 * cap


def cap_volume(outer: float, flat: float, radius: float) -> float:
    """Volume (mm^3) of a cylinder of a ``radius`` between a plane at ``flat`` and a larger one, square to it."""
    import numpy as np

    t = (np.arange(400) + 0.5) / 400 * math.pi - math.pi / 2
    x, width = radius * np.sin(t), 2 * radius * np.cos(t)
    height = np.sqrt(outer**2 - x**2) - flat
    return float(np.sum(height * width * radius * np.cos(t)) * math.pi / 400)
