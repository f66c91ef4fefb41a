"""The two printed halves of a hinge, in the canonical frame of ``cad.layout``.

Upper half: a clevis of two ears with round bores in which the shaft turns; ear B carries the upper arm's
shafts, ear A the damper bracket. Lower half: a tongue whose D bore is keyed on the shaft; its cup is the
spring's pocket, its floor plate carries the lower arm's shafts.
"""

from __future__ import annotations

import math
from typing import Any

from cad.arm_layout import ArmLayout
from cad.arm_shaft import build_d_bore
from cad.damper_bracket import PILOT
from cad.dimensions import JointDimensions
from cad.fitting_layout import seat_screws
from cad.layout import JointLayout
from cad.mount import build_flange, flange_volume
from cad.outline import Disc, Hull, Point, hull_of

THINNEST_CHEEK = 2.0  # walls, of what may stand beside the lower arm's slot
CROSS_SCREW = 3.4  # mm, M3 through socket and tube


def bore_radius(dimensions: JointDimensions) -> float:
    """Radius (mm) of the ears' bores: a sliding fit, half of the moving clearance per side."""
    return (dimensions.shaft_diameter + dimensions.clearance) / 2


def _cylinder(radius: float, bottom: float, top: float, at: Point = (0.0, 0.0)) -> Any:
    import cadquery as cq

    return cq.Solid.makeCylinder(radius, top - bottom, cq.Vector(at[0], at[1], bottom))


def _box(x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]) -> Any:
    import cadquery as cq

    return cq.Solid.makeBox(x[1] - x[0], y[1] - y[0], z[1] - z[0], cq.Vector(x[0], y[0], z[0]))


def _lobes(dimensions: JointDimensions, arm: ArmLayout) -> list[Disc]:
    """Material round an arm's two shafts."""
    radius = dimensions.pin_diameter / 2 + dimensions.wall
    return [Disc(x, y, radius) for x, y in (arm.bearing, arm.keeper)]


def _socket(dimensions: JointDimensions, layout: JointLayout, start: float, way: int) -> tuple[Any, list[Any]]:
    """A round socket for the link's tube from y = way * start outwards: its body, and what is cut from it."""
    import cadquery as cq

    direction = cq.Vector(0, way, 0)
    origin = cq.Vector(0, way * start, 0)
    body = cq.Solid.makeCylinder(layout.socket_outer, layout.socket_depth, origin, direction)
    bore = cq.Solid.makeCylinder(dimensions.link_width / 2 + dimensions.fit, layout.socket_depth + 1, origin, direction)
    at = way * (start + layout.socket_depth / 2)
    screw = _cylinder(CROSS_SCREW / 2, -layout.socket_outer - 1, layout.socket_outer + 1, (0.0, at))
    return body, [bore, screw]


def ear_outlines(dimensions: JointDimensions, layout: JointLayout) -> tuple[Hull, Hull]:
    """Outlines of ear A (bracket side) and ear B (arm shaft side; of a pair of springs both are)."""
    hub = dimensions.shaft_diameter / 2 + dimensions.clearance + 2 * dimensions.wall
    radius = layout.web_thickness / 2
    side = layout.socket_outer - radius
    corners = [Disc(x, layout.upper_bottom - radius, radius) for x in (-side, side)]
    lobes = _lobes(dimensions, layout.upper)
    on_a = lobes if layout.mirrored else []
    ear_a = hull_of([Disc(0.0, 0.0, max(hub, layout.bracket_radius)), *corners, *on_a])
    ear_b = hull_of([Disc(0.0, 0.0, max(hub, layout.seat_radius)), *corners, *lobes])
    return ear_a, ear_b


def web_outline(layout: JointLayout) -> Hull:
    """The web between the ears seen along z, its corners as round as it is thick."""
    radius = layout.web_thickness / 2
    side = layout.socket_outer - radius
    return hull_of([Disc(x, layout.upper_bottom - radius, radius) for x in (-side, side)])


def build_upper(dimensions: JointDimensions, layout: JointLayout) -> Any:
    """The clevis as a cadquery Solid; the upper link points along +y."""
    gap, outside = layout.gap, layout.gap + dimensions.plate
    ear_a, ear_b = ear_outlines(dimensions, layout)
    web = web_outline(layout).extrude(-gap, gap)
    if dimensions.mount is None:
        end, cuts = _socket(dimensions, layout, layout.upper_bottom, 1)
    else:
        end, cuts = build_flange(dimensions, layout)
    cuts.append(_cylinder(bore_radius(dimensions), -outside - 1, outside + 1))
    pin = dimensions.pin_diameter / 2 + dimensions.fit
    ears = ((gap, outside + 1), (-outside - 1, -gap))[: 2 if layout.mirrored else 1]
    cuts += [_cylinder(pin, *ear, at) for ear in ears for at in (layout.upper.bearing, layout.upper.keeper)]
    pilot = PILOT * dimensions.damper.bolt_diameter / 2
    cuts += [_cylinder(pilot, -outside - 1, -gap, at) for at in layout.screws]
    if dimensions.encoder is not None:
        pilot = PILOT * dimensions.encoder.bolt_diameter / 2
        cuts += [_cylinder(pilot, gap, outside + 1, at) for at in seat_screws(dimensions.encoder, layout.upper)]
    body = ear_a.extrude(-outside, -gap).fuse(ear_b.extrude(gap, outside), web, end)
    return body.cut(*cuts)


def tongue_outlines(dimensions: JointDimensions, layout: JointLayout) -> tuple[Hull, Hull]:
    """Outlines of the tongue's floor plate, which reaches round the arm's shafts, and of the cup above it."""
    radius = layout.web_thickness / 2
    side = layout.socket_outer - radius
    cup = [
        Disc(0.0, 0.0, layout.tongue_radius),
        *(Disc(x, radius - layout.lower_bottom, radius) for x in (-side, side)),
    ]
    return hull_of([*cup, *_lobes(dimensions, layout.lower)]), hull_of(cup)


def build_lower(dimensions: JointDimensions, layout: JointLayout) -> Any:
    """The tongue as a cadquery Solid; the lower link points along -y."""
    half = layout.half_width
    floor, cup = tongue_outlines(dimensions, layout)
    socket, cuts = _socket(dimensions, layout, layout.lower_bottom, -1)
    # Prisms that share a face only: kernels stumble over cylinders that coincide.
    cups = [cup.extrude(layout.floor_top, half)]
    pocket = _cylinder(layout.pocket_radius, layout.floor_top, half + 1)
    if layout.arbor_radius:
        pocket = pocket.cut(_cylinder(layout.arbor_radius, layout.floor_top, half + 1))
    rooms = [pocket, _lower_slot(dimensions, layout), _lower_mouth(dimensions, layout)]
    rooms.append(_upper_notch(dimensions, layout))
    if layout.mirrored:
        cups, rooms = ([*shapes, *(shape.mirror("XY") for shape in shapes)] for shapes in (cups, rooms))
    floor_bottom = -layout.floor_top if layout.mirrored else -half
    body = floor.extrude(floor_bottom, layout.floor_top).fuse(*cups, socket)
    cuts += rooms
    cuts.append(build_d_bore(dimensions.shaft_diameter, dimensions.fit, -half - 1, half + 1))
    pin = dimensions.pin_diameter / 2 + dimensions.fit
    cuts += [_cylinder(pin, -half - 1, half + 1, at) for at in (layout.lower.bearing, layout.lower.keeper)]
    return body.cut(*cuts)


def _lower_slot(dimensions: JointDimensions, layout: JointLayout) -> Any:
    """The way of the lower arm out of the pocket, open to the top so that the spring drops in."""
    arm, spring = layout.lower, dimensions.spring
    width = spring.wire_diameter / 2 + dimensions.clearance
    # The coil's radius, and with it the arm's line near the coil and its tip, moves over the joint's travel.
    end = layout.arm_reach + max(0.0, -layout.slips[1]) + 2 * dimensions.clearance
    outside = layout.radius_open - spring.radius + width
    towards_keeper = end * math.tan(math.radians(max(0.0, -layout.arm_turns[1])))
    # What the slot leaves on its outer side is a blade when thin: then the slot is open to that side.
    _, cup = tongue_outlines(dimensions, layout)
    if cup.reach(arm.direction + 90.0) - spring.radius - outside < THINNEST_CHEEK * dimensions.wall:
        outside = layout.web_radius
    slot = _box(
        (0.0, end),
        (layout.radius_closed - spring.radius - width - towards_keeper, outside),
        (layout.floor_top, layout.half_width + 1),
    )
    # Round the shafts it widens, or thin horns of print would stand between slot and shaft holes.
    pin, side = dimensions.pin_diameter, 2 * dimensions.clearance
    lateral = (spring.wire_diameter + pin) / 2
    well = _box(
        (layout.pin_reach - pin / 2 - dimensions.clearance, end),
        (-lateral - dimensions.keeper_gap - pin / 2 - side, lateral + pin / 2 + side),
        (layout.floor_top, layout.half_width + 1),
    )
    return slot.fuse(well).rotate((0, 0, 0), (0, 0, 1), arm.direction).translate((*arm.tangent, 0))


def _lower_mouth(dimensions: JointDimensions, layout: JointLayout) -> Any:
    """The pocket's wall where the slot leaves it at a grazing angle: cut away, it would be a feather edge."""
    width = dimensions.spring.wire_diameter / 2 + dimensions.clearance
    near = math.degrees(math.asin((layout.radius_closed - width) / layout.tongue_radius))
    near -= max(0.0, -layout.arm_turns[1])
    sector = (layout.lower.direction + near, layout.lower.direction + 90.0)
    return _ring_sector(layout, dimensions.clearance, sector, layout.tongue_radius, layout.floor_top)


def _upper_notch(dimensions: JointDimensions, layout: JointLayout) -> Any:
    """The sector that the upper arm and its shafts sweep, cut out of the pocket's wall."""
    return _ring_sector(layout, dimensions.clearance, layout.notch, layout.web_radius, layout.notch_bottom)


def _ring_sector(
    layout: JointLayout, clearance: float, sector: tuple[float, float], outside: float, bottom: float
) -> Any:
    """A cut from inside the pocket to radius ``outside``, between two angles (deg), from ``bottom`` upwards."""
    import cadquery as cq

    height = layout.half_width + 1 - bottom
    whole = cq.Solid.makeCylinder(
        outside, height, cq.Vector(0, 0, bottom), cq.Vector(0, 0, 1), sector[1] - sector[0]
    ).rotate((0, 0, 0), (0, 0, 1), sector[0])
    return whole.cut(_cylinder(layout.pocket_radius - clearance / 2, bottom - 1, bottom + height + 1))


def upper_volume(dimensions: JointDimensions, layout: JointLayout) -> float:
    """Volume of :func:`build_upper`, mm^3, in closed form but for the cross screw's one integral."""
    ear_a, ear_b = ear_outlines(dimensions, layout)
    plate, damper = dimensions.plate, dimensions.damper
    bore = math.pi * bore_radius(dimensions) ** 2
    pins = 2 * math.pi * (dimensions.pin_diameter / 2 + dimensions.fit) ** 2
    pilots = damper.bolt_count * math.pi * (PILOT * damper.bolt_diameter / 2) ** 2
    encoder = dimensions.encoder
    seat = 0.0 if encoder is None else encoder.bolt_count * math.pi * (PILOT * encoder.bolt_diameter / 2) ** 2
    on_a = pins if layout.mirrored else 0.0
    ears = (ear_a.area - bore - pilots - on_a) * plate + (ear_b.area - bore - pins - seat) * plate
    web = 2 * layout.gap * web_outline(layout).area
    if dimensions.mount is not None:
        return ears + web + flange_volume(dimensions, layout)
    outer = layout.socket_outer
    inner = dimensions.link_width / 2 + dimensions.fit
    socket = math.pi * (outer**2 - inner**2) * layout.socket_depth
    return ears + web + socket - _cross_hole(outer, inner)


def _cross_hole(outer: float, inner: float) -> float:
    """Volume (mm^3) that a radial screw hole takes from a tube: the integral of the chords over the hole."""
    import numpy as np

    # x = a sin t turns the disc's edge into a smooth periodic integrand, on which the trapezoid rule is exact.
    t = (np.arange(400) + 0.5) / 400 * math.pi - math.pi / 2
    a = CROSS_SCREW / 2
    x, width = a * np.sin(t), 2 * a * np.cos(t)
    chord = 2 * (np.sqrt(outer**2 - x**2) - np.sqrt(inner**2 - x**2))
    return float(np.sum(chord * width * a * np.cos(t)) * math.pi / 400)
