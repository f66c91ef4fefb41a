"""The seat of an angle encoder on ear B, over the end of the shaft, and the bought encoder's envelope.

A ring screwed to the ear. Its floor keeps the sensor's face at the air gap from the magnet in the shaft's end;
the recess above takes the housing. Own frame, mm: the face on the ear is z = 0, the seat grows along +z.
"""

from __future__ import annotations

import math
from typing import Any

from cad.dimensions import JointDimensions
from cad.fittings import EncoderDimensions
from cad.layout import JointLayout, seat_screws
from cad.outline import Point

LEAST_FLOOR = 1.2  # mm, of print under the encoder's rim


def seat_floor(encoder: EncoderDimensions) -> float:
    """Thickness (mm) between ear and encoder: the magnet is flush with the ear, so it is the air gap."""
    return max(encoder.air_gap, LEAST_FLOOR)


def _bore(dimensions: JointDimensions) -> float:
    return dimensions.shaft_diameter / 2 + dimensions.clearance


def _cylinder(radius: float, bottom: float, top: float, at: Point = (0.0, 0.0)) -> Any:
    import cadquery as cq

    return cq.Solid.makeCylinder(radius, top - bottom, cq.Vector(at[0], at[1], bottom))


def build_seat(dimensions: JointDimensions, layout: JointLayout) -> Any:
    """The seat as one cadquery Solid in its own frame."""
    encoder = dimensions.encoder
    assert encoder is not None
    floor = seat_floor(encoder)
    top = floor + encoder.body_depth
    cuts = [
        _cylinder(encoder.body_diameter / 2 + dimensions.fit, floor, top + 1.0),
        _cylinder(_bore(dimensions), -1.0, floor + 0.5),
        *(
            _cylinder(encoder.bolt_diameter / 2, -1.0, top + 1.0, at)
            for at in seat_screws(encoder, layout.upper.direction)
        ),
    ]
    return _cylinder(layout.seat_radius, 0.0, top).cut(*cuts)


def seat_volume(dimensions: JointDimensions, layout: JointLayout) -> float:
    """Volume of :func:`build_seat`, mm^3, in closed form."""
    encoder = dimensions.encoder
    assert encoder is not None
    area = layout.seat_radius**2 - encoder.bolt_count * (encoder.bolt_diameter / 2) ** 2
    ring = (area - (encoder.body_diameter / 2 + dimensions.fit) ** 2) * encoder.body_depth
    return math.pi * (ring + (area - _bore(dimensions) ** 2) * seat_floor(encoder))


def build_encoder(encoder: EncoderDimensions) -> Any:
    """Envelope of the bought encoder (cadquery Solid) as it lies in the seat, in the seat's frame."""
    floor = seat_floor(encoder)
    return _cylinder(encoder.body_diameter / 2, floor, floor + encoder.body_depth)


def encoder_volume(encoder: EncoderDimensions) -> float:
    """Volume of :func:`build_encoder`, mm^3."""
    return math.pi * encoder.body_diameter**2 / 4 * encoder.body_depth
