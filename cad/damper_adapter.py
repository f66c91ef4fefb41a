"""The coupling between the joint's D-shaft and a damper that has a shaft of its own: two D bores in one sleeve.

Own frame, mm: its face towards the ear is z = 0, it grows along -z; both flats stand on the +x side, in phase.
"""

from __future__ import annotations

import math
from typing import Any

from cad.arm_shaft import build_d_bore, d_section_area
from cad.fittings import AdapterDimensions


def build_adapter(adapter: AdapterDimensions, radius: float, shaft_diameter: float, fit: float) -> Any:
    """The adapter as one cadquery Solid of outer ``radius``."""
    import cadquery as cq

    length = adapter.length
    body = cq.Solid.makeCylinder(radius, length, cq.Vector(0, 0, -length))
    upper = build_d_bore(shaft_diameter, fit, -adapter.shaft_grip, 1.0)
    lower = build_d_bore(adapter.output_diameter, fit, -length - 1.0, -length + adapter.output_grip)
    return body.cut(upper, lower)


def adapter_volume(adapter: AdapterDimensions, radius: float, shaft_diameter: float, fit: float) -> float:
    """Volume of :func:`build_adapter`, mm^3, in closed form."""
    bores = d_section_area(shaft_diameter, fit) * adapter.shaft_grip
    bores += d_section_area(adapter.output_diameter, fit) * adapter.output_grip
    return math.pi * radius**2 * adapter.length - bores
