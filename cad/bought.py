"""Standard parts of a joint as solids: bearings, thrust washers, collars, the tongue's pin, screws and nuts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from synth.cad import arm_shaft, spring_seat, standard_part
from synth.cad.arm_shaft import loose
from synth.cad.damper_side import pin_part, shaft_end
from synth.cad.dimensions import JointDimensions
from synth.cad.encoder_seat import seat_height
from synth.cad.hinge import cross_screw, cylinder, pocket_depth, socket_screw_at
from synth.cad.layout import JointLayout
from synth.cad.link_socket import SocketScrew
from synth.cad.parts import DrawnPart, Group
from synth.cad.screw_places import Place, bracket_screws, damper_screws, encoder_screws
from synth.cad.shaft_line import lay_shaft
from synth.cad.standard_part import StandardPart


def bought_parts(dimensions: JointDimensions, layout: JointLayout) -> list[DrawnPart]:
    """All standard parts except the seats' screws and the parts of the damper's shaft."""
    line = lay_shaft(dimensions, layout, shaft_end(dimensions, layout).bottom)
    return [
        *_bearings(dimensions, layout),
        *_on_the_shaft(dimensions, layout),
        pin_part("pin", line.pin, line.pin_height, line.pin_angle),
        *_fixings("bracket_screw", bracket_screws(dimensions, layout)),
        *_fixings("damper_screw", damper_screws(dimensions, layout)),
        *(_encoder(dimensions, layout) if dimensions.encoder is not None else []),
        *_socket_screws(dimensions, layout),
    ]


def _bearings(dimensions: JointDimensions, layout: JointLayout) -> list[DrawnPart]:
    bearing, deep = dimensions.hardware.bearing, pocket_depth(dimensions)
    bore = loose(bearing.bore)
    volume = arm_shaft.ring_volume(bearing.outer_diameter, bore, bearing.width)
    words = f" ball bearing, {bearing.bore:g} x {bearing.outer_diameter:g} x {bearing.width:g} mm, two shields"
    words += f" (sold as {bearing.sold_as})"
    made = StandardPart("bearing", bearing.standard, bearing.designation, words)
    found = []
    for which, bottom in (("a", -layout.gap_a - deep), ("b", layout.gap_b + deep - bearing.width)):
        solid = arm_shaft.build_ring(bearing.outer_diameter, bore, bottom, bottom + bearing.width)
        found.append(DrawnPart(f"bearing_{which}", "bearing", "upper", solid, volume, False, made, bearing.mass))
    return found


def _on_the_shaft(dimensions: JointDimensions, layout: JointLayout) -> list[DrawnPart]:
    """Thrust washers and collars."""
    washer, collar = dimensions.hardware.washer, dimensions.hardware.collar
    line = lay_shaft(dimensions, layout, shaft_end(dimensions, layout).bottom)
    thin, wide = washer.thickness, collar.width
    section = f"{washer.bore:g} x {washer.outer_diameter:g} x {thin:g}"
    thrust = StandardPart("shim", washer.standard, section, " shim ring, steel")
    words = f" shaft collar, steel, with set screw M{collar.set_screw:g}"
    ring = StandardPart("collar", collar.standard, f"{collar.bore:g}", words)
    found = []
    for which, at_washer, at_collar in zip("ab", line.washers(thin), line.collars(thin, wide), strict=True):
        for suffix, family, outer, bore, bottom, height, made in (
            ("thrust_washer", "washer", washer.outer_diameter, loose(washer.bore), at_washer, thin, thrust),
            ("collar", "collar", collar.outer_diameter, loose(collar.bore), at_collar, wide, ring),
        ):
            solid = arm_shaft.build_ring(outer, bore, bottom, bottom + height)
            volume = arm_shaft.ring_volume(outer, bore, height)
            found.append(DrawnPart(f"{suffix}_{which}", family, "lower", solid, volume, False, made))
    return found


def _encoder(dimensions: JointDimensions, layout: JointLayout) -> list[DrawnPart]:
    return _fixings("encoder_screw", encoder_screws(dimensions, layout, seat_height(dimensions)))


def _fixings(suffix: str, places: Sequence[Place]) -> list[DrawnPart]:
    """Screws of the upper half that end in inserts."""
    found = []
    for index, place in enumerate(places, start=1):
        screw = place.screw
        solid = spring_seat.build_screw(screw, place.length, place.face, place.way, place.at)
        made = standard_part.screw(screw.standard, screw.size, place.length)
        volume = spring_seat.screw_volume(screw, place.length)
        found.append(DrawnPart(f"{suffix}_{index}", "screw", "upper", solid, volume, False, made))
    return found


def _socket_screws(dimensions: JointDimensions, layout: JointLayout) -> list[DrawnPart]:
    """The screw and nut through each tube and its socket."""
    ends: list[tuple[Group, float, int]] = [("lower", layout.lower_bottom, -1)]
    if dimensions.mount is None:
        ends.insert(0, ("upper", layout.upper_bottom, 1))
    through, found = cross_screw(layout), []
    for group, start, way in ends:
        at = (0.0, socket_screw_at(layout, start, way))
        screw = through.screw
        body = spring_seat.build_screw(screw, through.length, through.flat, 1, at)
        made = standard_part.screw(screw.standard, screw.size, through.length, has_nut=True)
        volume = spring_seat.screw_volume(screw, through.length)
        found.append(DrawnPart(f"{group}_socket_screw", "screw", group, body, volume, False, made))
        nut = _nut(through, at)
        bought = StandardPart("nut", through.nut.standard, f"M{through.nut.size:g}", " hexagon nut, steel")
        found.append(DrawnPart(f"{group}_socket_nut", "nut", group, nut, _nut_volume(through), False, bought))
    return found


def _nut(through: SocketScrew, at: tuple[float, float]) -> Any:
    nut = through.nut
    low = -through.flat - nut.height
    body = arm_shaft.build_section("hex", nut.across_flats, 0.0, low, -through.flat).translate((*at, 0))
    return body.cut(cylinder(loose(nut.size) / 2, low - 1, -through.flat + 1, at)).Solids()[0]


def _nut_volume(through: SocketScrew) -> float:
    nut = through.nut
    return (arm_shaft.section_area("hex", nut.across_flats) - math.pi / 4 * loose(nut.size) ** 2) * nut.height
