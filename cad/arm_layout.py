"""The arms of a spring: positions, clamping, and swept regions as the joint turns. Plain arithmetic, no solids.

Seen along z, a tangent arm of direction u starts at the tangent point T, |T| = D/2, T . u = 0. It is free up to its
seat, which begins at the distance ``free`` from T, and clamped from there on: it lies in a V groove of 90 deg in a pad,
and a cap with a screw on either side presses it in. Pad, cap and wire touch without a gap, so an arm has no play for
any tolerance of wire or print. The arms continue the slope of the helix, and groove and cap have the same slope.

In an arm's own frame s runs along u, n outwards (along T) and z along the hinge axis.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from synth.cad.dimensions import JointDimensions
from synth.cad.hardware import insert_of, screw_of
from synth.cad.outline import Disc, Hull, Point, hull_of, unit

OVERHANG = 1.0  # mm, projection of an arm beyond its seat
RIM = 1.6  # mm of print round an insert: four lines of 0.4 mm
V_EDGE = 1.2  # mm of print between the V's mouth and an insert: three lines
# Allowable values of the default print (36 MPa along its layers, half of it across, safety factor 1.5), less 5 %.
SEAT_PRESSURE = 0.95 * 1.5 * 36.0 / 1.5  # MPa
CAP_STRESS = 0.95 * 36.0 / 1.5  # MPa
CORNER = 1.0  # mm, radius of a seat's corners
BITE = 0.1  # of the wire's radius, by which the wire stands out of the pad at a seat's end, so that the cap presses it


@dataclass(frozen=True)
class SeatSize:
    """An arm's seat, equal for both arms: dimensions from wire and screws. Lengths in mm."""

    screw: float  # nominal
    length: float  # along the arm
    half_width: float  # across it
    screw_at: float  # distance of the screws from the arm's axis
    gap: float  # between pad and cap
    cap: float  # thickness of the cap under the screws' heads, at mid length
    screw_length: float
    insert: float  # length of the inserts, which pad and plate behind it must hold


def longest_seat(dimensions: JointDimensions) -> float:
    """Length (mm) of a seat from which on the cap's end would touch the pad instead of clamping the wire.

    The arm rises with the helix across the pad's flat face: over half of the seat by at most the wire's radius, less
    ``BITE`` of it.
    """
    slope = dimensions.spring.drawn_pitch / (2 * math.pi * dimensions.spring.radius)
    return (1.0 - BITE) * dimensions.spring.wire_diameter * math.hypot(1.0, slope) / slope


def seat_size(dimensions: JointDimensions) -> SeatSize:
    """Seat of the arms: screws about as thick as the wire, of a standard length that ends within the insert."""
    wire = dimensions.spring.wire_diameter
    screw = screw_of(wire if dimensions.seat_screw is None else dimensions.seat_screw)
    insert = insert_of(screw.size)
    at = wire / math.sqrt(2) + V_EDGE + insert.hole / 2
    least = max(insert.hole, screw.head_diameter) + 2 * RIM
    moment = dimensions.spring_torque * 1e3 / dimensions.springs
    asked = math.sqrt(12 * moment / (wire * SEAT_PRESSURE))  # of cad.strength: 6 M/l^2 on half of the wire's width
    length = dimensions.seat_length if dimensions.seat_length is not None else math.ceil(max(2.5 * wire, least, asked))
    length = max(length, least)
    gap = wire / 2
    # Thread engagement of 1.5 diameters, or all of the insert but a lead-in of 1 mm.
    engaged = max(1.5 * screw.size, insert.length - 1.0)
    cap = max(dimensions.cap, 3.0 / length * math.sqrt(moment * at / CAP_STRESS))
    wanted = cap + gap + engaged
    stock = screw.length_at_least(wanted)
    return SeatSize(
        screw=screw.size,
        length=length,
        half_width=at + max(insert.hole / 2 + RIM, screw.head_diameter / 2 + 0.3),  # mm, clearance of the head
        screw_at=at,
        gap=gap,
        cap=stock - gap - engaged,
        screw_length=stock,
        insert=insert.length,
    )


@dataclass(frozen=True)
class ArmLayout:
    """One arm and its seat in the frame of the half that carries it, canonical sense."""

    direction: float  # deg, of the arm, seen along z
    side: int  # +1: the tangent point lies 90 deg counter-clockwise of the direction; -1: clockwise
    tangent: Point  # mm, where coil and arm meet
    height: float  # mm, z of the wire's centre at the tangent point
    slope: float  # dz/ds along the arm
    free: float  # mm, tangent point to seat
    relief: float  # mm, by which the cap begins behind the pad
    seat: SeatSize

    def at(self, s: float, n: float) -> Point:
        """The point at ``s`` mm along the arm and ``n`` mm outwards of it."""
        along, outward = unit(self.direction), unit(self.direction + 90.0 * self.side)
        return (
            self.tangent[0] + s * along[0] + n * outward[0],
            self.tangent[1] + s * along[1] + n * outward[1],
        )

    def wire_height(self, s: float) -> float:
        """Z (mm) of the wire's centre."""
        return self.height + self.slope * s

    @property
    def middle(self) -> float:
        """S (mm) of the seat's middle."""
        return self.free + self.seat.length / 2

    @property
    def screws(self) -> tuple[Point, Point]:
        """Axes of the seat's screws: the inner, the outer."""
        return self.at(self.middle, -self.seat.screw_at), self.at(self.middle, self.seat.screw_at)

    @property
    def reach(self) -> float:
        """Largest distance (mm) from the hinge axis of the seat's corners and the wire's tip."""
        end, wide = self.free + self.seat.length, self.seat.half_width
        corners = [self.at(end, wide), self.at(end, -wide), self.at(end + OVERHANG, 0.0)]
        return max(math.hypot(*corner) for corner in corners)

    def outline(self, more: float = 0.0) -> Hull:
        """The seat seen along z, ``more`` mm larger on every side."""
        radius, wide = CORNER + more, self.seat.half_width - CORNER
        ends = (self.free + CORNER, self.free + self.seat.length - CORNER)
        return hull_of([Disc(*self.at(s, n), radius) for s in ends for n in (-wide, wide)])


def lay_arm(
    dimensions: JointDimensions, seat: SeatSize, direction: float, side: int, free: float, height: float, drop: float
) -> ArmLayout:
    """An arm in the given direction; the lower arm falls, the upper rises.

    ``height`` mm: z at its tangent point; ``drop`` mm: by which the coil is shorter when it opens to its stop.
    """
    spring = dimensions.spring
    outward = unit(direction + 90.0 * side)
    slope = spring.drawn_pitch / (2 * math.pi * spring.radius)
    return ArmLayout(
        direction=direction,
        side=side,
        tangent=(outward[0] * spring.radius, outward[1] * spring.radius),
        height=height,
        slope=-side * slope,
        free=free,
        relief=_cap_relief(dimensions, slope + drop / 2 / free),
        seat=seat,
    )


def _cap_relief(dimensions: JointDimensions, slope: float) -> float:
    """Distance (mm) from the edge of the pad to the cap, so that half of the clearance remains at the cap's edge.

    The arm is inclined towards the cap, most at one of the stops: ``tan(beta) = slope``. In the arm's section at the
    clearance c before the seat, the point next to the cap is ``d/2 sin(beta)`` nearer to it than the centre. For a
    thick wire or a steep arm, ``c cos(beta) - d/2 sin(beta)`` is less than c/2; the relief is the difference.
    """
    clear, lean = dimensions.clearance, math.atan(slope)
    left = clear * math.cos(lean) - dimensions.spring.wire_diameter / 2 * math.sin(lean)
    return max(0.0, clear / 2 - left)
