"""One joint: its parts built in the canonical frame, mirrored to its hand and sign, and assembled."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from synth.cad import damper_bracket, encoder_seat, hinge, spring_seat, standard_part, torsion_spring
from synth.cad.arm_layout import ArmLayout
from synth.cad.bought import bought_parts
from synth.cad.checked_layout import lay_out
from synth.cad.damper_side import damper_side, shaft_end, sleeve_of
from synth.cad.dimensions import JointDimensions
from synth.cad.hardware import screw_of
from synth.cad.layout import JointLayout, sunk_depth
from synth.cad.outline import Point
from synth.cad.parts import BuiltPart, DrawnPart, Group, Mesh, file_name, mesh_of
from synth.cad.pose import loaded_line


@dataclass(frozen=True)
class BuiltJoint:
    """All parts of a joint. Upper half along +y; lower half's parts drawn straight (q = 0); the spring unloaded."""

    dimensions: JointDimensions
    layout: JointLayout
    parts: tuple[BuiltPart, ...]

    @cached_property
    def kept(self) -> dict[object, Any]:
        """Cache of expensive results that checks, files and report use, by module: ``cad.printing``, ``cad.play``."""
        return {}

    def part(self, suffix: str) -> BuiltPart:
        """The part named ``<joint>_<suffix>``."""
        wanted = f"{file_name(self.dimensions.name)}_{suffix}"
        return next(part for part in self.parts if part.name == wanted)

    @property
    def springs(self) -> tuple[BuiltPart, ...]:
        """The spring, or the pair of them: first the one on ear B's side."""
        return tuple(part for part in self.parts if part.group == "spring")

    def seat(self, spring: BuiltPart) -> tuple[JointDimensions, JointLayout]:
        """Dimensions and layout for one of the joint's springs; see :func:`spring_seats`."""
        return spring_seats(self.dimensions, self.layout)[[s.name for s in self.springs].index(spring.name)]

    def turn(self, group: Group, angle: float) -> float:
        """Rotation (deg) of a group of parts at the measured joint ``angle``: only the lower half turns."""
        return self.dimensions.rotation(angle) if group == "lower" else 0.0

    def mesh_at(self, part: BuiltPart, angle: float) -> Mesh:
        """A part's mesh at the measured joint ``angle`` (deg), with the spring loaded accordingly."""
        if part.group == "spring":
            return spring_mesh_at(*self.seat(part), angle)
        return part.mesh.turned(self.turn(part.group, angle))

    def filed_mesh(self, part: BuiltPart) -> Mesh:
        """A part's mesh as in its file: the spring unloaded, all others at the files' angle."""
        return part.mesh if part.group == "spring" else self.mesh_at(part, self.dimensions.filed_angle)

    def solid_at(self, part: BuiltPart, angle: float) -> Any:
        """A part's solid at the measured joint ``angle`` (deg); the spring's unloaded, at the free angle."""
        return part.solid.rotate((0, 0, 0), (0, 0, 1), self.turn(part.group, angle))


def build_joint(dimensions: JointDimensions) -> BuiltJoint:
    """Build every part of a joint.

    Raises
    ------
    DimensionError
        naming every dimension that does not fit.
    """
    return assemble(dimensions, lay_out(dimensions))


def assemble(dimensions: JointDimensions, layout: JointLayout) -> BuiltJoint:
    """Build the parts of a joint with a given layout."""
    name = file_name(dimensions.name)
    parts = [
        _printed_part(name, "upper", "upper", dimensions, layout),
        _printed_part(name, "lower", "lower", dimensions, layout),
        _printed_part(name, "damper_bracket", "upper", dimensions, layout),
        _damper(name, dimensions, layout),
        *_encoder(name, dimensions, layout),
        *_seats(name, dimensions, layout),
        *_springs(name, dimensions, layout),
    ]
    for drawn in (*damper_side(dimensions, layout), *bought_parts(dimensions, layout)):
        parts.append(_finished_part(name, drawn, layout))
    return BuiltJoint(dimensions, layout, tuple(parts))


def orient(shape: Any, flips: tuple[int, int]) -> Any:
    """A canonical shape mirrored in x and/or z; both together are half a turn about y."""
    if flips == (-1, -1):
        return shape.rotate((0, 0, 0), (0, 1, 0), 180)
    if flips == (-1, 1):
        return shape.mirror("YZ")
    return shape.mirror("XY") if flips == (1, -1) else shape


def _printed_part(joint: str, family: str, group: Group, dimensions: JointDimensions, layout: JointLayout) -> BuiltPart:
    exact: float | None = None
    if family == "upper":
        solid, exact = hinge.build_upper(dimensions, layout), hinge.upper_volume(dimensions, layout)
    elif family == "lower":
        solid = hinge.build_lower(dimensions, layout)
    else:
        sleeve = sleeve_of(dimensions, layout)
        solid = damper_bracket.build_bracket(sleeve, layout.screws).translate((0, 0, -layout.gap_a - layout.ear))
        exact = damper_bracket.bracket_volume(sleeve, layout.screws)
    return _finished_part(joint, DrawnPart(family, family, group, solid, exact, True, "print"), layout)


def _finished_part(joint: str, drawn: DrawnPart, layout: JointLayout) -> BuiltPart:
    """The part mirrored to its joint, its name beginning with the joint's."""
    flips = layout.flips
    mesh = mesh_of(drawn.solid, (flips[0], 1, flips[1]))
    name, solid = f"{joint}_{drawn.suffix}", orient(drawn.solid, flips)
    return BuiltPart(name, drawn.family, drawn.group, solid, mesh, drawn.printed, drawn.exact, drawn.made, drawn.mass)


def _damper(joint: str, dimensions: JointDimensions, layout: JointLayout) -> BuiltPart:
    damper, bore = dimensions.damper, shaft_end(dimensions, layout).damper_bore
    solid = damper_bracket.build_damper(damper, layout.screws, layout.bracket_radius, layout.bracket_height, bore)
    solid = solid.translate((0, 0, -layout.gap_a - layout.ear))
    exact = damper_bracket.damper_volume(damper, layout.bracket_radius, bore)
    made = "buy (envelope only)"
    if damper.unknown:
        made += "; not known, drawn by assumption: " + ", ".join(damper.unknown)
    return _finished_part(joint, DrawnPart("damper", "damper", "upper", solid, exact, False, made), layout)


def _encoder(joint: str, dimensions: JointDimensions, layout: JointLayout) -> list[BuiltPart]:
    """The encoder's seat on ear B with the encoder, if any."""
    encoder = dimensions.encoder
    if encoder is None:
        return []
    shift = (0, 0, layout.gap_b + layout.ear)
    seat = encoder_seat.build_seat(dimensions, layout).translate(shift)
    body = encoder_seat.build_encoder(dimensions, encoder).translate(shift)
    exact, envelope = encoder_seat.seat_volume(dimensions, layout), encoder_seat.encoder_volume(encoder)
    bought = "buy (envelope only)"
    drawn = (
        DrawnPart("encoder_seat", "encoder_seat", "upper", seat, exact, True, "print"),
        DrawnPart("encoder", "encoder", "upper", body, envelope, False, bought),
    )
    return [_finished_part(joint, each, layout) for each in drawn]


def _seats(joint: str, dimensions: JointDimensions, layout: JointLayout) -> list[BuiltPart]:
    """Seat plates, caps and screws; for a pair of springs the second one's too, mirrored in z."""
    drawn = [(layout, each) for each in _seat_parts("", dimensions, layout)]
    if layout.mirrored:
        below = replace(layout, flips=(layout.flips[0], -layout.flips[1]))
        drawn += [(below, each) for each in _seat_parts("_2", dimensions, below)]
    return [_finished_part(joint, each, placed) for placed, each in drawn]


def _seat_parts(which: str, dimensions: JointDimensions, layout: JointLayout) -> list[DrawnPart]:
    plate, seat = layout.plate, layout.seat
    solid = spring_seat.build_plate(dimensions, layout)
    parts = [DrawnPart(f"seat{which}", "seat", "upper", solid, None, True, "print")]
    arms: list[tuple[Group, ArmLayout, int]] = [("upper", layout.upper, -1), ("lower", layout.lower, 1)]
    for group, arm, way in arms:
        cap, exact = spring_seat.build_cap(dimensions, arm, way), spring_seat.cap_volume(dimensions, arm)
        parts.append(DrawnPart(f"{group}_cap{which}", "cap", group, cap, exact, True, "print"))
        face = spring_seat.cap_face(arm, way)
        for index, at in enumerate(arm.screws, start=1):
            suffix = f"{group}_screw{which}_{index}"
            parts.append(_screw(suffix, group, layout, seat.screw_length, face, way, at))
    top, length = layout.gap_b + layout.ear, plate.screw_length
    if which:
        top, length = top - sunk_depth(screw_of(seat.screw)), plate.sunk_length
    for index, at in enumerate(plate.screws, start=1):
        suffix = f"seat_screw{which}_{index}"
        parts.append(_screw(suffix, "upper", layout, length, top, 1, at, washer=True))
    return parts


def _screw(
    suffix: str,
    group: Group,
    layout: JointLayout,
    length: float,
    face: float,
    way: int,
    at: Point,
    *,
    washer: bool = False,
) -> DrawnPart:
    screw = screw_of(layout.seat.screw)
    solid = spring_seat.build_screw(screw, length, face, way, at, washer=washer)
    exact = spring_seat.screw_volume(screw, length, washer=washer)
    made = standard_part.screw(screw.standard, screw.size, length, washer="ISO 7089" if washer else "")
    return DrawnPart(suffix, "screw", group, solid, exact, False, made)


def spring_seats(dimensions: JointDimensions, layout: JointLayout) -> list[tuple[JointDimensions, JointLayout]]:
    """Dimensions and layout for each spring: the second of a pair has the opposite hand and is turned over in z."""
    seats = [(dimensions, layout)]
    if layout.mirrored:
        other = replace(dimensions.spring, hand="left" if dimensions.spring.hand == "right" else "right")
        flips = (layout.flips[0], -layout.flips[1])
        seats.append((replace(dimensions, spring=other), replace(layout, flips=flips)))
    return seats


def spring_placement(dimensions: JointDimensions, layout: JointLayout) -> tuple[float, float]:
    """Rotation (deg about z) and height (mm) that bring an unloaded spring from its own frame into the joint's.

    The joint's x flip takes an arm's direction a to 180 - a; its z flip puts the canonical top, where the
    upper arm leaves, at the bottom.
    """
    flip_x, flip_z = layout.flips
    spring, direction = dimensions.spring, layout.upper.direction
    wanted = direction if flip_x > 0 else 180.0 - direction
    if flip_z > 0:
        return wanted - torsion_spring.top_arm_direction(spring), layout.coil_start
    return wanted - torsion_spring.bottom_arm_direction(spring), -layout.coil_start - layout.coil_height


def spring_mesh_at(dimensions: JointDimensions, layout: JointLayout, angle: float, sides: int | None = None) -> Mesh:
    """The spring's mesh in the joint's frame at the measured ``angle``, deg; ``sides`` of its section."""
    points = loaded_line(dimensions, layout, angle)
    vertices, faces = torsion_spring.tube_mesh(points, dimensions.spring.wire_diameter, sides or torsion_spring.SIDES)
    return Mesh(vertices, faces).scaled((layout.flips[0], 1, layout.flips[1]))


def _springs(name: str, dimensions: JointDimensions, layout: JointLayout) -> list[BuiltPart]:
    titles = (f"{name}_spring", f"{name}_spring_2")
    return [_spring(title, *seat) for title, seat in zip(titles, spring_seats(dimensions, layout), strict=False)]


def _spring(name: str, dimensions: JointDimensions, layout: JointLayout) -> BuiltPart:
    turn, height = spring_placement(dimensions, layout)
    solid = torsion_spring.build_spring(dimensions.spring, layout.arm_length)
    solid = solid.rotate((0, 0, 0), (0, 0, 1), turn).translate((0, 0, height))
    return BuiltPart(
        name=name,
        family="spring",
        group="spring",
        solid=solid,
        mesh=spring_mesh_at(dimensions, layout, dimensions.free_angle),
        printed=False,
        exact_volume=torsion_spring.spring_volume(dimensions.spring, layout.arm_length),
        made="buy or wind",
    )
