"""The seat of an angle encoder on ear B, over the end of the shaft, and the bought encoder's envelope.

A ring around the shaft's collar, screwed to the ear. A step in it keeps the air gap between the sensor's face and the
magnet in the shaft's end; the recess above it holds the housing. A housing no wider than the collar lies on a floor
above the collar, through which the shaft passes. Own frame, mm: the face on the ear is z = 0, the seat extends along
+z.
"""

from __future__ import annotations

import math
from typing import Any

from synth.cad import kernel
from synth.cad.dimensions import JointDimensions
from synth.cad.fittings import EncoderDimensions
from synth.cad.layout import SUNK_ASIDE, JointLayout
from synth.cad.outline import Point
from synth.cad.screw_places import encoder_screws
from synth.cad.shaft_line import AXIAL_GAP, beyond_collar

LEAST_STEP = 1.2  # mm, least height of the sensor's face above the shaft's end: the tolerance of printed heights


def seat_step(dimensions: JointDimensions) -> float:
    """Height (mm) of the step: up to the shaft's end with the magnet, and the air gap."""
    encoder = dimensions.encoder
    assert encoder is not None
    over = AXIAL_GAP + dimensions.hardware.stack + beyond_collar(dimensions)
    return over + max(encoder.air_gap, LEAST_STEP)


def seat_height(dimensions: JointDimensions) -> float:
    """Height (mm) of the whole seat."""
    assert dimensions.encoder is not None
    return seat_step(dimensions) + dimensions.encoder.body_depth


def seat_bore(dimensions: JointDimensions) -> float:
    """Radius (mm) of the space around collar and thrust washer."""
    return dimensions.hardware.radius + dimensions.clearance


def collar_room(dimensions: JointDimensions) -> float:
    """Height (mm) of the space around collar and thrust washer: the whole step, or up to the floor above the collar."""
    if beyond_collar(dimensions) > 0.0:
        return AXIAL_GAP + dimensions.hardware.stack + dimensions.clearance
    return seat_step(dimensions)


def floor_bore(dimensions: JointDimensions) -> float:
    """Radius (mm) of the shaft's hole in the floor above the collar."""
    return dimensions.shaft_diameter / 2 + dimensions.clearance


def _sunk(dimensions: JointDimensions, layout: JointLayout) -> tuple[float, float]:
    """Depth (mm) of the countersinks of the screws' heads, and their radius."""
    place = encoder_screws(dimensions, layout, seat_height(dimensions))[0]
    depth = layout.gap_b + layout.ear + seat_height(dimensions) - place.face
    return depth, place.screw.head_diameter / 2 + SUNK_ASIDE


def _cylinder(radius: float, bottom: float, top: float, at: Point = (0.0, 0.0)) -> Any:
    return kernel.cylinder(radius, top - bottom, (at[0], at[1], bottom))


def build_seat(dimensions: JointDimensions, layout: JointLayout) -> Any:
    """The seat as one cadquery Solid in its own frame."""
    encoder = dimensions.encoder
    assert encoder is not None
    step, top = seat_step(dimensions), seat_height(dimensions)
    cuts = [_cylinder(encoder.body_diameter / 2 + dimensions.fit, step, top + 1.0)]
    room = collar_room(dimensions)
    floor = room < step
    cuts.append(_cylinder(seat_bore(dimensions), -1.0, room if floor else step + 0.5))
    if floor:
        cuts.append(_cylinder(floor_bore(dimensions), room - 0.5, step + 0.5))
    depth, wide = _sunk(dimensions, layout)
    for place in encoder_screws(dimensions, layout, top):
        cuts.append(_cylinder(encoder.bolt_diameter / 2, -1.0, top + 1.0, place.at))
        if depth > 0.0:
            cuts.append(_cylinder(wide, top - depth, top + 1.0, place.at))
    return _cylinder(layout.seat_radius, 0.0, top).cut(*cuts)


def seat_volume(dimensions: JointDimensions, layout: JointLayout) -> float | None:
    """Volume of :func:`build_seat`, mm^3, in closed form; None if countersinks cut into its recess."""
    encoder = dimensions.encoder
    assert encoder is not None
    depth, _ = _sunk(dimensions, layout)
    if depth > 0.0:
        return None
    area = layout.seat_radius**2 - encoder.bolt_count * (encoder.bolt_diameter / 2) ** 2
    ring = (area - (encoder.body_diameter / 2 + dimensions.fit) ** 2) * encoder.body_depth
    step, room = seat_step(dimensions), collar_room(dimensions)
    below = area * step - seat_bore(dimensions) ** 2 * room - floor_bore(dimensions) ** 2 * (step - room)
    return math.pi * (ring + below)


def build_encoder(dimensions: JointDimensions, encoder: EncoderDimensions) -> Any:
    """Envelope of the bought encoder (cadquery Solid) in the seat's frame."""
    step = seat_step(dimensions)
    return _cylinder(encoder.body_diameter / 2, step, step + encoder.body_depth)


def encoder_volume(encoder: EncoderDimensions) -> float:
    """Volume of :func:`build_encoder`, mm^3."""
    return math.pi * encoder.body_diameter**2 / 4 * encoder.body_depth
