"""The brass of the heat-set inserts: their holes are cut from the print, and they are parts of no drawing of their own.

Every screw without a nut ends in one. It is taken as a tube as wide as its hole and as long as its table says, bored to
its thread's pitch diameter; what its knurls stand out of the hole, their grooves lack.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from synth.cad.hardware import Insert, inserts
from synth.cad.joint import BuiltJoint
from synth.cad.kernel import heights
from synth.cad.moments import Moments, Vector
from synth.cad.parts import Group
from synth.cad.standard_part import StandardPart

BRASS = 8.47  # g/cm^3, CuZn39Pb3 (CW614N), of which inserts are turned
PITCH = 0.89  # of the nominal diameter: pitch diameter of coarse ISO 724 threads, 0.87 (M2) to 0.90 (M8)
LEAD_IN = 1.0  # mm of an insert that its screw leaves free; see ``arm_layout.seat_size``


@dataclass(frozen=True)
class InsertBody:
    """One insert: what it moves with, its mass (g), and its moments in the joint's frame at q = 0."""

    group: Group
    mass: float
    moments: Moments


def insert_mass(insert: Insert) -> float:
    """Mass of one insert, g."""
    return BRASS * 1e-3 * _volume(insert)


def _volume(insert: Insert) -> float:
    return math.pi / 4 * (insert.hole**2 - (PITCH * insert.size) ** 2) * insert.length


def insert_bodies(joint: BuiltJoint) -> list[InsertBody]:
    """The inserts of a joint, one for each screw that ends in one.

    Along the hinge their places are within a millimetre: a screw's standard length ends somewhere within its insert.
    """
    found = []
    for part in joint.parts:
        made = part.made
        if not isinstance(made, StandardPart) or not made.has_insert:
            continue
        assert made.thread is not None
        insert, (x, y, z) = inserts()[made.thread], part.moments().centre
        lying = made.kind == "set screw"  # inside its insert, across the hinge
        if not lying:
            low, high = heights(part.solid)
            # The screw's centre of mass is on its head's side, its tip at the other end.
            inward = insert.length / 2 - LEAD_IN
            z = low + inward if z > (low + high) / 2 else high - inward
        found.append(InsertBody(part.group, insert_mass(insert), _tube(insert, (x, y, z), lying=lying)))
    return found


def _tube(insert: Insert, centre: Vector, *, lying: bool) -> Moments:
    """The moments of a tube along z, or along x if it is lying."""
    volume = _volume(insert)
    radii = (insert.hole**2 + (PITCH * insert.size) ** 2) / 4
    about, across = volume * radii / 2, volume * (3 * radii + insert.length**2) / 12
    axes = (about, across, across) if lying else (across, across, about)
    return Moments(volume, centre, (*axes, 0.0, 0.0, 0.0))
