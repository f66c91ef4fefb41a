"""The upper arm's adjustable seat plate, the caps that clamp both arms, and their screws; frame of ``cad.layout``.

The plate is between coil and ear B, around the shaft. Its screws pass slots in the ear, so that it can be turned within
the seat's travel before they are tightened; this sets the spring's free angle. Its marks form a vernier with those on
the ear.
"""

from __future__ import annotations

import math
from typing import Any

from synth.cad import kernel
from synth.cad.arm_layout import ArmLayout
from synth.cad.dimensions import JointDimensions
from synth.cad.hardware import Screw, insert_of, screw_of
from synth.cad.hinge import cylinder, in_arm_frame, v_groove
from synth.cad.kernel import prism
from synth.cad.layout import JointLayout
from synth.cad.outline import Point
from synth.cad.outlines import plate_outline
from synth.cad.seat_scale import plate_marks


def build_plate(dimensions: JointDimensions, layout: JointLayout) -> Any:
    """The seat plate as one cadquery Solid, with the seat in the middle of its travel."""
    plate, arm = layout.plate, layout.upper
    pad = arm.wire_height(arm.middle)
    body = plate_outline(layout).extrude(plate.bottom, plate.top).fuse(arm.outline().extrude(pad, plate.bottom))
    hole = insert_of(layout.seat.screw).hole / 2
    cuts = [
        cylinder(plate_bore(dimensions), plate.bottom - 1, plate.top + 1),
        v_groove(arm, dimensions.spring.wire_diameter, -1),
        *(cylinder(hole, pad - 1, plate.top + 1, at) for at in (*arm.screws, *plate.screws)),
        *plate_marks(layout),
    ]
    return body.cut(*cuts)


def plate_bore(dimensions: JointDimensions) -> float:
    """Radius (mm) of the plate's bore, clear of the shaft."""
    return dimensions.shaft_diameter / 2 + dimensions.clearance


def _wire_side(arm: ArmLayout, wire: float, way: int, s: float) -> float:
    """Z (mm) of the cap's face on the wire."""
    return arm.wire_height(s) + way * wire / 2 * math.hypot(1.0, arm.slope)


def cap_face(arm: ArmLayout, way: int) -> float:
    """Z (mm) of the cap's outer face, under the screws' heads; ``way`` +1: the cap lies above the wire."""
    return arm.wire_height(arm.middle) + way * (arm.seat.gap + arm.seat.cap)


def build_cap(dimensions: JointDimensions, arm: ArmLayout, way: int) -> Any:
    """A cap as one cadquery Solid; ``way`` +1: above the wire."""
    wire, seat = dimensions.spring.wire_diameter, arm.seat
    ends, outer = (arm.free + arm.relief, arm.free + seat.length), cap_face(arm, way)
    side = [(s, -seat.half_width, _wire_side(arm, wire, way, s)) for s in ends]
    points = [*side, (ends[1], -seat.half_width, outer), (ends[0], -seat.half_width, outer)]
    body = in_arm_frame(prism(points, (0.0, 2 * seat.half_width, 0.0)), arm)
    hole = screw_of(seat.screw).hole / 2
    low, high = sorted((outer, arm.wire_height(arm.middle)))
    return body.cut(*(cylinder(hole, low - 5.0, high + 5.0, at) for at in arm.screws))


def cap_volume(dimensions: JointDimensions, arm: ArmLayout) -> float:
    """Volume of :func:`build_cap`, mm^3.

    The thickness at the screws is the mean over their holes. The cap is thinnest at the arm's entry, so its mean
    thickness is larger by the rise over half of the relief.
    """
    seat, wire = arm.seat, dimensions.spring.wire_diameter
    thick = seat.gap + seat.cap - wire / 2 * math.hypot(1.0, arm.slope)
    mean = thick + abs(arm.slope) * arm.relief / 2
    hole = screw_of(seat.screw).hole / 2
    return 2 * seat.half_width * (seat.length - arm.relief) * mean - 2 * math.pi * hole**2 * thick


def build_screw(screw: Screw, length: float, face: float, way: int, at: Point, *, washer: bool = False) -> Any:
    """A screw whose head lies on a face at height ``face``, its head towards ``way``; with or without a washer."""
    return kernel.placed(_screw, (screw, length, way, washer), (*at, face))


def _screw(screw: Screw, length: float, way: int, washer: bool) -> Any:  # noqa: FBT001 - placed() hands on in order
    """A screw on the hinge axis whose head lies at height 0."""
    under = way * (screw.washer_thickness if washer else 0.0)
    low, high = sorted((under, under + way * screw.head_height))
    body = cylinder(screw.head_diameter / 2, low, high)
    low, high = sorted((under, under - way * length))
    body = body.fuse(cylinder(screw.size / 2, low, high))
    if washer:
        low, high = sorted((0.0, under))
        body = body.fuse(cylinder(screw.washer / 2, low, high))
    return body.Solids()[0]


def screw_volume(screw: Screw, length: float, *, washer: bool = False) -> float:
    """Volume of :func:`build_screw`, mm^3."""
    volume = math.pi / 4 * (screw.head_diameter**2 * screw.head_height + screw.size**2 * length)
    return volume + washer * math.pi / 4 * (screw.washer**2 - screw.size**2) * screw.washer_thickness
