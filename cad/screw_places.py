"""Positions and lengths of the screws of brackets and encoder: plain arithmetic, no solids.

Heads of the damper bracket's screws are sunk in ear A's inner face; they end in inserts in the top of the bracket's
sleeve. The damper's own screws end in inserts in its open end. The encoder's end in inserts in ear B.
"""

from __future__ import annotations

from dataclasses import dataclass

from synth.cad.dimensions import JointDimensions
from synth.cad.hardware import Screw, insert_of
from synth.cad.layout import JointLayout, bracket_sunk, fixing_screw, seat_screws
from synth.cad.outline import Point

SET_SCREW = 3.0  # mm, nominal, on the flat of a damper's shaft; ISO 4026
FLANGE_THICKNESS = 3.0  # mm, of the damper's flange as drawn; vendors give none
ENGAGED = 1.5  # diameters, least engagement of a screw in its insert or nut
BEYOND = 1.0  # mm, depth of an insert's hole beyond the screw's end
SHORT = 0.2  # mm, least distance of a screw's end below the far face of its part


@dataclass(frozen=True)
class Place:
    """One screw along the hinge axis, canonical: from its head's face into an insert; mm."""

    screw: Screw
    length: float
    at: Point
    face: float  # z under the head
    way: int  # +1: the head lies above its face

    @property
    def tip(self) -> float:
        """Z of its end."""
        return self.face - self.way * self.length


def bracket_screws(dimensions: JointDimensions, layout: JointLayout) -> list[Place]:
    """From between the ears through ear A into the sleeve of the damper's bracket."""
    screw = fixing_screw(dimensions.damper.bolt_diameter)
    sunk = bracket_sunk(screw)
    length = screw.length_at_least(layout.ear - sunk + ENGAGED * screw.size)
    return [Place(screw, length, at, -layout.gap_a - sunk, 1) for at in layout.screws]


def damper_screws(dimensions: JointDimensions, layout: JointLayout) -> list[Place]:
    """Through the damper's flange into the open end of its bracket's sleeve."""
    screw = fixing_screw(dimensions.damper.bolt_diameter)
    length = screw.length_at_least(FLANGE_THICKNESS + ENGAGED * screw.size)
    low = -layout.gap_a - layout.ear - layout.bracket_height - FLANGE_THICKNESS
    return [Place(screw, length, at, low, -1) for at in layout.screws]


def bracket_depths(dimensions: JointDimensions, layout: JointLayout) -> tuple[float, float]:
    """Depths (mm) of the inserts' holes in the sleeve: from ear A, and from its open end."""
    screw = fixing_screw(dimensions.damper.bolt_diameter)
    insert = insert_of(screw.size)
    above = bracket_screws(dimensions, layout)[0]
    below = damper_screws(dimensions, layout)[0]
    in_top = above.length - (layout.ear - bracket_sunk(screw))
    return max(in_top, insert.length) + BEYOND, max(below.length - FLANGE_THICKNESS, insert.length) + BEYOND


def encoder_screws(dimensions: JointDimensions, layout: JointLayout, seat_height: float) -> list[Place]:
    """Through the encoder's seat, ``seat_height`` mm high, into ear B; none without an encoder.

    If no length that is sold ends inside the ear, the heads are countersunk in the seat.
    """
    encoder = dimensions.encoder
    if encoder is None:
        return []
    screw = fixing_screw(encoder.bolt_diameter)
    least = seat_height + ENGAGED * screw.size
    length = next((found for found in screw.lengths if least <= found <= seat_height + layout.ear - SHORT), None)
    if length is None:
        length = max((found for found in screw.lengths if found <= least), default=screw.lengths[0])
    sunk = max(0.0, least - length)
    face = layout.gap_b + layout.ear + seat_height - sunk
    return [Place(screw, length, at, face, 1) for at in seat_screws(encoder, layout.upper.direction)]
