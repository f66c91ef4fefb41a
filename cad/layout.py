"""The layout of a joint: plain arithmetic from its dimensions, no solids.

Canonical frame, mm: the hinge axis is z, the middle of the tongue z = 0, the upper link points along +y,
the straight lower link along -y. It holds a right-hand spring whose arms open as the lower link turns
counter-clockwise seen from +z. Every other joint is this one mirrored (see ``flips``). The spring is not mirrored but
drawn in its own hand and placed into the joint, so that the contact checks also test the mirroring.

Along z, upwards: damper and bracket | ear A | floor plate of the tongue | coil in its pocket | the upper arm's seat
plate | ear B. What is on the shaft is in ``cad.shaft_line``.

The lower arm leaves the coil at the floor, where a cap clamps it on a pad of the floor plate; the upper
arm leaves it at the top and is clamped under the seat plate, which is screwed to ear B and can be turned about the
hinge.

Of a pair of springs the second is the first mirrored in z, in a pocket below the floor, its upper arm on a seat plate
at ear A. z = 0 is then the middle of the floor: ear A | seat plate | coil | floor plate | coil | seat plate | ear B.

``cad.checked_layout`` checks that all of this fits; ``cad.arm_layout`` describes an arm in its seat.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from synth.cad.arm_layout import OVERHANG, RIM, ArmLayout, SeatSize, lay_arm, seat_size
from synth.cad.dimensions import JointDimensions
from synth.cad.fittings import DamperDimensions, EncoderDimensions
from synth.cad.hardware import Screw, insert_of, screw_of, screw_through
from synth.cad.link_socket import socket_radius
from synth.cad.outline import Point, unit
from synth.cad.spring_space import SpringSpace, spring_space
from synth.cad.stops import Stop, lay_stops

SEAT_SCREWS = (75.0, 180.0, 285.0)  # deg from the arm: round the circle, the seat between two of them
WINDOW = 127.5  # deg from the arm: between two screws' slots
PIN_RIM = 1.2  # mm of print above and below the pin through the tongue
RECESS = 0.3  # mm, of a screw's head under the face it is sunk into
SUNK_ASIDE = 0.2  # mm, clearance of a groove beside the washers in it
VERNIER_STEP = 4.0  # deg, between the seat plate's marks: a fifth less than the ear's, so the vernier reads a degree
VERNIER = (-2, -1, 0, 1, 2)  # the vernier's marks, in steps: five marks divide five degrees
LIP = 1.6  # mm of an ear outside its bearing, on which a thrust washer runs: four lines of 0.4 mm
BEARING_SUNK = 0.2  # mm, bearing below its ear's inner face, so that the seat plate does not touch the inner ring
LEAST_SCALE = 15.0  # mm, radius of a seat's scale: 5 deg are 1.3 mm there, which can be printed and read


@dataclass(frozen=True)
class SeatPlate:
    """The plate that carries an upper arm's seat, and the slots in the ear along which it turns; mm, deg."""

    screw_length: float
    sunk_length: float  # of the second spring's screws, whose heads are sunk in ear A
    radius: float  # of the screws' circle and of the scale
    hub: float  # outer radius round the shaft
    angles: tuple[float, ...]  # of the screws, canonical, with the seat in its middle
    window: float  # direction of the window over the scale
    travel: float  # either way
    bottom: float  # z of its face towards the coil
    top: float  # z of its face on the ear

    @property
    def screws(self) -> tuple[Point, ...]:
        """The screws' axes with the seat at its centre."""
        return tuple((self.radius * x, self.radius * y) for x, y in (unit(angle) for angle in self.angles))


@dataclass(frozen=True)
class JointLayout:
    """Derived lengths (mm) and angles (deg) of one joint; the comments name what each one is."""

    seat: SeatSize
    free_arm: float  # tangent point to seat, seen along z
    arm_length: float  # along the wire
    coil_start: float  # z of the wire's centre at the lower tangent point
    coil_height: float  # lower to upper tangent point
    half_width: float  # of the tongue along z
    ear: float  # thickness of the ears
    gap_a: float  # ear A's inner face below z = 0
    gap_b: float  # ear B's inner face above it
    space: SpringSpace
    floor_top: float
    floor_bottom: float
    web_radius: float  # the upper half's web starts here; all that turns under it is smaller
    socket_radius: float  # the lower half's socket starts here
    bracket_radius: float
    bracket_height: float
    bracket_bore: float  # radius of the sleeve's inside
    seat_radius: float  # of the encoder's seat on ear B; 0: none
    socket_outer: float  # radius of the sockets' outside
    socket_depth: float
    web_thickness: float
    notch_bottom: float  # z from which the pocket's wall is open for the upper arm's sweep
    notch: tuple[float, float]  # deg, from and to, in the lower half's frame at q = 0
    upper: ArmLayout  # in the upper half's frame
    lower: ArmLayout  # in the lower half's frame, at q = 0
    plate: SeatPlate
    stops: tuple[Stop, Stop]  # the lower half's horns, at the low and the high stop
    screws: tuple[Point, ...]  # axes of the damper's screws, which go into ear A
    mirrored: bool  # a second spring below the floor
    flips: tuple[int, int]  # sign of x and of z: canonical to this joint

    @property
    def upper_bottom(self) -> float:
        """Hinge axis to the end of the link tube in the upper socket."""
        return self.web_radius + self.web_thickness

    @property
    def lower_bottom(self) -> float:
        """Hinge axis to the end of the link tube in the lower socket."""
        return self.socket_radius + self.web_thickness


def jaw_height(seat: SeatSize) -> float:
    """From the wire's centre at the seat's middle to the top of the screws' heads, mm."""
    return seat.gap + seat.cap + screw_of(seat.screw).head_height


def seat_radius(dimensions: JointDimensions) -> float:
    """Outside of the encoder's seat, mm; 0 without an encoder."""
    encoder = dimensions.encoder
    return 0.0 if encoder is None else encoder.bolt_circle / 2 + encoder.bolt_diameter / 2 + dimensions.wall


def fixing_screw(hole: float) -> Screw:
    """The screw for a bought part's clearance hole (mm).

    Raises
    ------
    ValueError
        where none passes it; dimensions are checked for that before.
    """
    screw = screw_through(hole)
    if screw is None:
        raise ValueError(f"no screw passes a hole of {hole:g} mm")
    return screw


def ear_of(dimensions: JointDimensions) -> float:
    """Thickness (mm) of the ears: as given, and sufficient for bearing and lip, and for the encoder's inserts."""
    wanted = [dimensions.plate, dimensions.hardware.bearing.width + BEARING_SUNK + LIP]
    if dimensions.encoder is not None:
        wanted.append(insert_of(fixing_screw(dimensions.encoder.bolt_diameter).size).length)
    # Heads of the bracket's screws are sunk from inside, and hold by what is left.
    screw = fixing_screw(dimensions.damper.bolt_diameter)
    wanted.append(bracket_sunk(screw) + dimensions.wall)
    return max(wanted)


def bracket_sunk(screw: Screw) -> float:
    """Depth (mm) of the countersinks of the bracket's screws in ear A's inner face."""
    return screw.head_height + RECESS


def bearing_pocket(dimensions: JointDimensions) -> float:
    """Radius (mm) of an ear's pocket for its bearing."""
    return dimensions.hardware.bearing.outer_diameter / 2 + dimensions.fit


def bracket_bore(dimensions: JointDimensions) -> float:
    """Radius (mm) of the sleeve's inside: space for the damper's body, the collar and the adapter or insert."""
    return max(dimensions.damper.outer_diameter / 2, dimensions.hardware.radius) + dimensions.clearance


def bracket_radius(dimensions: JointDimensions) -> float:
    """Radius (mm) of the sleeve's outside, round its screws and their inserts."""
    damper = dimensions.damper
    hole = max(damper.bolt_diameter, insert_of(fixing_screw(damper.bolt_diameter).size).hole)
    return damper.bolt_circle / 2 + hole / 2 + dimensions.wall


def seat_screws(encoder: EncoderDimensions, direction: float) -> list[Point]:
    """Screw axes (mm) on the encoder's circle; ``direction`` deg: the upper arm's."""
    return _on_circle(encoder.bolt_circle, encoder.bolt_count, direction + 90.0)


def damper_screws(damper: DamperDimensions) -> tuple[Point, ...]:
    """Screw axes (mm) on the damper's circle, turned so that none lies on the link's centre line."""
    return tuple(_on_circle(damper.bolt_circle, damper.bolt_count, 90.0 + 180.0 / damper.bolt_count))


def window_half(travel: float) -> float:
    """Half of the window over the seat plate's marks, deg."""
    return travel + VERNIER_STEP * VERNIER[-1] + 2.0


def _on_circle(diameter: float, count: int, start: float) -> list[Point]:
    corners = [unit(start + 360.0 * index / count) for index in range(count)]
    return [(diameter / 2 * x, diameter / 2 * y) for x, y in corners]


@dataclass(frozen=True)
class _Heights:
    """Along z, mm."""

    half_width: float
    floor_top: float
    floor_bottom: float
    coil_start: float
    coil: float


def floor_of(dimensions: JointDimensions, seat: SeatSize) -> float:
    """Thickness of the floor plate, mm: as given, and sufficient for pin and inserts; for a pair from both sides."""
    pinned = dimensions.hardware.pin + 2 * PIN_RIM
    return max(dimensions.floor_thickness, dimensions.springs * seat.insert + 0.5 * (dimensions.springs - 1), pinned)


def _heights(dimensions: JointDimensions, space: SpringSpace, seat: SeatSize, drift: float) -> _Heights:
    """Floor, coil and the arms' rise beside it (``drift``), once, or twice with the floor in the middle."""
    spring, clear = dimensions.spring, dimensions.clearance
    floor = floor_of(dimensions, seat)
    coil = spring.drawn_coils * spring.drawn_pitch
    beside = drift + spring.wire_diameter / 2 + clear + space.growth / 2
    # A cap and its screw heads must clear the other half's plate.
    beside = max(beside, jaw_height(seat) + clear + drift - coil)
    room = beside + coil + beside
    pair = dimensions.springs == 2
    half_width = floor / 2 + room if pair else (floor + room) / 2
    floor_top = floor / 2 if pair else floor - half_width
    return _Heights(half_width, floor_top, -floor_top if pair else -half_width, floor_top + beside, coil)


def _notch(dimensions: JointDimensions, upper: ArmLayout, space: SpringSpace) -> tuple[float, float]:
    """Sector (deg, in the lower half's frame) of the pocket's wall swept by the upper arm between the stops.

    If the free angle lies beyond a stop, the sector reaches to it: the spring is put in unloaded, and its upper arm is
    turned with the seat plate before that is screwed on. Either end is farther by the seat's travel: the seat turns the
    arm by as much as the spring's own free angle is off.

    At the radius r an edge of the arm, w off its axis, lies ``asin((D/2 -+ w)/r)`` behind the arm's direction.
    The coil's own quarter turn before the tangent point belongs to the sweep as well.
    """
    width = dimensions.spring.wire_diameter / 2 + dimensions.clearance
    edge = (dimensions.spring.radius - space.sway_in - width) / space.tongue_radius
    ahead = -math.degrees(math.asin(max(-1.0, edge)))
    # In the lower half's frame at q = 0 the upper half stands turned back by the joint's rotation.
    turned = [upper.direction - dimensions.opening(angle) for angle in (*dimensions.ends, dimensions.free_angle)]
    return min(turned) - 90.0 - dimensions.seat_travel, max(turned) + ahead + dimensions.seat_travel


def _seat_plate(
    dimensions: JointDimensions, seat: SeatSize, upper: ArmLayout, bottom: float, outer: float
) -> SeatPlate:
    """The seat plate's screws on a circle outside the hub and the encoder's seat (radius ``outer``)."""
    screw, insert = screw_of(seat.screw), insert_of(seat.screw)
    hub = dimensions.shaft_diameter / 2 + dimensions.clearance + dimensions.wall
    aside = screw.washer / 2 + dimensions.clearance
    between = math.radians(SEAT_SCREWS[1] - WINDOW - dimensions.seat_travel - window_half(dimensions.seat_travel))
    pocket = bearing_pocket(dimensions) + RIM + screw.hole / 2
    radius = max(LEAST_SCALE, hub + aside, outer + aside, pocket, (screw.hole / 2 + RIM) / math.sin(between))
    if dimensions.springs == 2:  # there the heads are sunk, and their grooves end beside the marks
        groove = screw.washer / 2 + SUNK_ASIDE
        radius = max(radius, groove / math.sin(between))
        if ear_of(dimensions) - sunk_depth(screw) - dimensions.hardware.bearing.width - BEARING_SUNK < RIM:
            radius = max(radius, bearing_pocket(dimensions) + RIM + groove)  # no floor between groove and bearing
        circle, beside = dimensions.damper.bolt_circle / 2, beside_damper(dimensions, screw)
        # They are put in when the damper's sleeve is on: inside it, which is open below, or outside.
        if abs(circle - radius) < beside or radius + aside > bracket_bore(dimensions):
            radius = max(radius, circle + beside, bracket_radius(dimensions) + aside)
    ear, thick = ear_of(dimensions) + screw.washer_thickness, max(dimensions.plate, insert.length)
    length = screw.length_at_least(ear + 1.5 * screw.size)
    thick, sunk = max(thick, length - ear), length
    if dimensions.springs == 2:
        ear -= sunk_depth(screw)
        sunk = screw.length_at_least(ear + 1.5 * screw.size)
        thick = max(thick, sunk - ear)
    return SeatPlate(
        screw_length=length,
        sunk_length=sunk,
        radius=radius,
        hub=hub,
        angles=tuple(upper.direction + turn for turn in SEAT_SCREWS),
        window=upper.direction + WINDOW,
        travel=dimensions.seat_travel,
        bottom=bottom,
        top=bottom + thick,
    )


def sunk_depth(screw: Screw) -> float:
    """Depth (mm) of the groove for heads and washers under the damper's bracket."""
    return screw.head_height + screw.washer_thickness + RECESS


def beside_damper(dimensions: JointDimensions, screw: Screw) -> float:
    """Least distance (mm) of a pair's seat screws from the damper's circle: both are in ear A."""
    fixing = fixing_screw(dimensions.damper.bolt_diameter)
    return screw.washer / 2 + SUNK_ASIDE + fixing.head_diameter / 2 + SUNK_ASIDE + dimensions.wall / 2


def place(dimensions: JointDimensions) -> JointLayout:
    """Lay out a joint whose dimensions are in range, whether it fits or not."""
    space, seat = spring_space(dimensions), seat_size(dimensions)
    spring, clear, wall = dimensions.spring, dimensions.clearance, dimensions.wall
    slope = spring.drawn_pitch / (2 * math.pi * spring.radius)
    reach = space.free_arm + seat.length + OVERHANG
    heights = _heights(dimensions, space, seat, slope * reach)
    pair = dimensions.springs == 2
    ref = 270.0 + dimensions.closes * (dimensions.zero_angle - dimensions.upper_arm_angle)
    upper = lay_arm(dimensions, seat, ref, -1, space.free_arm, heights.coil_start + heights.coil, space.drop)
    lower_direction = 270.0 + dimensions.closes * dimensions.arm_offset
    lower = lay_arm(dimensions, seat, lower_direction, 1, space.free_arm, heights.coil_start, space.drop)
    plate = _seat_plate(dimensions, seat, upper, heights.half_width + clear, seat_radius(dimensions))
    damper = dimensions.damper
    adapter = damper.adapter.length + clear if damper.adapter is not None else 0.0
    bracket = bracket_radius(dimensions)
    turning = max(upper.reach, lower.reach, space.tongue_radius, plate.radius + insert_of(seat.screw).hole / 2 + RIM)
    # The bracket must not reach the upper socket, and all rotating parts must clear the web.
    web_radius = max(turning + 2 * clear, bracket + clear - 2 * wall, ear_radius(plate, dimensions) - 2 * wall)
    # The bracket's screws are put in from between the ears: their heads lie beside the web.
    heads = fixing_screw(damper.bolt_diameter).head_diameter / 2 + clear
    web_radius = max(web_radius, max(y for _, y in damper_screws(damper)) + heads)
    web_thickness = 2 * wall
    socket_outer = socket_radius(dimensions.link_width, dimensions.fit, wall)
    return JointLayout(
        seat=seat,
        free_arm=space.free_arm,
        arm_length=reach * math.hypot(1.0, slope),
        coil_start=heights.coil_start,
        coil_height=heights.coil,
        half_width=heights.half_width,
        ear=ear_of(dimensions),
        gap_a=heights.half_width + clear + (plate.top - plate.bottom if pair else 0.0),
        gap_b=plate.top,
        space=space,
        floor_top=heights.floor_top,
        floor_bottom=heights.floor_bottom,
        web_radius=web_radius,
        socket_radius=max(web_radius, bracket + clear),
        bracket_radius=bracket,
        bracket_height=dimensions.hardware.stack + 2 * clear + damper.body_length + adapter,
        bracket_bore=bracket_bore(dimensions),
        seat_radius=seat_radius(dimensions),
        socket_outer=socket_outer,
        socket_depth=dimensions.socket_depth,
        web_thickness=web_thickness,
        notch_bottom=upper.height - space.growth / 2 - space.drop - spring.wire_diameter / 2 - clear,
        notch=_notch(dimensions, upper, space),
        upper=upper,
        lower=lower,
        plate=plate,
        stops=lay_stops(dimensions, web_radius, web_thickness, socket_outer),
        screws=damper_screws(damper),
        mirrored=pair,
        flips=(dimensions.opening_sign, dimensions.opening_sign * spring.hand_sign),
    )


def ear_radius(plate: SeatPlate, dimensions: JointDimensions) -> float:
    """Outside of an ear that a seat plate is screwed to, mm: print round the washers, of a pair round their grooves."""
    screw, rim = screw_of(seat_size(dimensions).screw), dimensions.wall / 2
    if dimensions.springs == 2:
        rim = max(rim, SUNK_ASIDE + RIM)
    return plate.radius + screw.washer / 2 + rim
