"""The shafts: steel dowels that the spring's arms bear on, and the joint's D-shaft."""

from __future__ import annotations

import math
from typing import Any

from cad.outline import Point

FLAT_DEPTH = 0.1  # of the shaft's diameter: what is taken off a D-shaft


def build_arm_shaft(diameter: float, bottom: float, top: float, at: Point) -> Any:
    """A dowel (cadquery Solid) parallel to the hinge axis; all mm."""
    import cadquery as cq

    return cq.Solid.makeCylinder(diameter / 2, top - bottom, cq.Vector(at[0], at[1], bottom))


def arm_shaft_volume(diameter: float, length: float) -> float:
    """Volume of a dowel, mm^3: pi d^2/4 L."""
    return math.pi * diameter**2 / 4 * length


def build_d_shaft(
    diameter: float, bottom: float, flat_top: float, top: float, pocket: tuple[float, float] = (0.0, 0.0)
) -> Any:
    """The hinge shaft on the z axis: D-shaped from ``bottom`` to ``flat_top``, round from there to ``top``.

    ``pocket``: diameter and depth of a magnet's pocket in the upper end; a depth of zero: none.
    """
    import cadquery as cq

    round_shaft = cq.Solid.makeCylinder(diameter / 2, top - bottom, cq.Vector(0, 0, bottom))
    cuts = [_beyond_flat(diameter, 0.0, bottom, flat_top)]
    if pocket[1] > 0.0:
        cuts.append(cq.Solid.makeCylinder(pocket[0] / 2, pocket[1] + 1.0, cq.Vector(0, 0, top - pocket[1])))
    return round_shaft.cut(*cuts).Solids()[0]


def build_d_bore(diameter: float, fit: float, bottom: float, top: float) -> Any:
    """The tool that cuts a bore in which a D-shaft is keyed, ``fit`` mm wider on every side."""
    import cadquery as cq

    tool = cq.Solid.makeCylinder(diameter / 2 + fit, top - bottom, cq.Vector(0, 0, bottom))
    return tool.cut(_beyond_flat(diameter, fit, bottom, top)).Solids()[0]


def _beyond_flat(diameter: float, fit: float, bottom: float, top: float) -> Any:
    """The block on the +x side of the flat."""
    import cadquery as cq

    flat = diameter * (0.5 - FLAT_DEPTH) + fit
    return cq.Solid.makeBox(diameter, 2 * diameter, top - bottom, cq.Vector(flat, -diameter, bottom))


def d_section_area(diameter: float, fit: float = 0.0) -> float:
    """Area (mm^2) of a D: a disc less the circular segment beyond the flat."""
    radius, flat = diameter / 2 + fit, diameter * (0.5 - FLAT_DEPTH) + fit
    half_angle = math.acos(flat / radius)
    return math.pi * radius**2 - radius**2 * (half_angle - math.sin(half_angle) * math.cos(half_angle))


def d_shaft_volume(
    diameter: float, flat_length: float, round_length: float, pocket: tuple[float, float] = (0.0, 0.0)
) -> float:
    """Volume (mm^3) of a shaft that is D-shaped over ``flat_length`` and round over ``round_length``, less a pocket."""
    full = d_section_area(diameter) * flat_length + math.pi * diameter**2 / 4 * round_length
    return full - math.pi * pocket[0] ** 2 / 4 * pocket[1]
