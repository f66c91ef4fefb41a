"""The bracket that holds a rotary damper coaxial with the joint, and the bought damper's envelope.

A sleeve closed by a base plate. The base lies on ear A, the damper's body hangs in the sleeve, its flange
seats on the sleeve's open end, and the same screws go through flange and sleeve into the ear, so flange and
hinge share one screw circle. Own frame, mm: the base's face on the ear is z = 0, the bracket grows along -z.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from cad.fittings import DamperDimensions
from cad.outline import Point

FLANGE_THICKNESS = 3.0  # mm, of the damper's flange as drawn; vendors give none
ROTOR_GRIP = 0.8  # of the body's length that the shaft goes in
PILOT = 0.8  # of the clearance hole's diameter: a screw cuts its thread in print


def _cylinder(radius: float, bottom: float, top: float, at: Point = (0.0, 0.0)) -> Any:
    import cadquery as cq

    return cq.Solid.makeCylinder(radius, top - bottom, cq.Vector(at[0], at[1], bottom))


def build_bracket(
    damper: DamperDimensions,
    screws: Sequence[Point],
    radius: float,
    height: float,
    wall: float,
    clearance: float,
    shaft_diameter: float,
) -> Any:
    """The bracket as one cadquery Solid: ``screws`` at, outer ``radius`` and ``height``, base ``wall`` thick, mm."""
    body = _cylinder(radius, -height, 0.0)
    cuts = [
        _cylinder(damper.outer_diameter / 2 + clearance, -height - 1.0, -wall),
        _cylinder(shaft_diameter / 2 + 2 * clearance, -wall - 1.0, 1.0),
        *(_cylinder(damper.bolt_diameter / 2, -height - 1.0, 1.0, at) for at in screws),
    ]
    return body.cut(*cuts)


def bracket_volume(
    damper: DamperDimensions, radius: float, height: float, wall: float, clearance: float, shaft_diameter: float
) -> float:
    """Volume of :func:`build_bracket`, mm^3, in closed form."""
    area = radius**2 - damper.bolt_count * (damper.bolt_diameter / 2) ** 2
    sleeve = area - (damper.outer_diameter / 2 + clearance) ** 2
    base = area - (shaft_diameter / 2 + 2 * clearance) ** 2
    return math.pi * (sleeve * (height - wall) + base * wall)


def build_damper(damper: DamperDimensions, screws: Sequence[Point], radius: float, height: float, bore: float) -> Any:
    """Envelope of the bought damper seated on the bracket: body and flange round a bore of radius ``bore``, mm.

    The rotor, which is keyed on the shaft and turns with it, is not drawn.
    """
    top = -height + damper.body_length
    flange = _cylinder(radius, -height - FLANGE_THICKNESS, -height)
    body = _cylinder(damper.outer_diameter / 2, -height, top)
    holes = [_cylinder(damper.bolt_diameter / 2, -height - FLANGE_THICKNESS - 1.0, -height + 0.5, at) for at in screws]
    return flange.fuse(body).cut(*holes, _cylinder(bore, -height - FLANGE_THICKNESS - 1.0, top + 1.0))


def rotor_bottom(damper: DamperDimensions, height: float) -> float:
    """Z (mm) of the shaft's end in the damper."""
    return -height + (1.0 - ROTOR_GRIP) * damper.body_length


def damper_volume(damper: DamperDimensions, radius: float, bore: float) -> float:
    """Volume of :func:`build_damper`, mm^3, in closed form."""
    flange = radius**2 - damper.bolt_count * (damper.bolt_diameter / 2) ** 2 - bore**2
    body = (damper.outer_diameter / 2) ** 2 - bore**2
    return math.pi * (flange * FLANGE_THICKNESS + body * damper.body_length)
