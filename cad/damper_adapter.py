"""Connections of the hinge's shaft to a damper: the adapter for a damper's own shaft, the insert for its bore.

Adapter: a sleeve pinned on the hinge's shaft. A round output is pinned as well; on the flat of any other form a set
screw in an insert removes the backlash. Insert: a printed square, D or hexagon, pinned on the shaft. Own frame, mm: the
face towards the ear is z = 0 and both extend along -z. Flats are on the +x side, the pin of the hinge's shaft is along
y.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from synth.cad import kernel
from synth.cad.arm_shaft import Form, build_section, cross_hole, cross_volume, flat_distance, section_area
from synth.cad.fittings import AdapterDimensions
from synth.cad.hardware import Pin, insert_of
from synth.cad.screw_places import SET_SCREW

PIN_TURN = 90.0  # deg, direction of the pins' axes
SET_SCREW_LENGTH = 6.0  # mm, of ISO 4026 - M3: from the flat to just inside the insert's end, 5.7 mm


@dataclass(frozen=True)
class Hub:
    """A sleeve pinned on a shaft: outer radius, shaft, fit, pin and its height; mm."""

    radius: float
    shaft: float
    fit: float
    pin: Pin
    pin_height: float


def pin_heights(adapter: AdapterDimensions) -> tuple[float, float]:
    """Z (mm) of the centres of both grips: on the hinge's shaft, on the damper's."""
    return -adapter.shaft_grip / 2, -adapter.length + adapter.output_grip / 2


def build_adapter(adapter: AdapterDimensions, hub: Hub, output_pin: Pin | None) -> Any:
    """The adapter as one cadquery Solid; ``output_pin``: through a round output."""
    length, low = adapter.length, pin_heights(adapter)[1]
    body = kernel.cylinder(hub.radius, length, (0.0, 0.0, -length))
    cuts = [
        build_section("round", hub.shaft, hub.fit, -adapter.shaft_grip, 1.0),
        build_section(adapter.form, adapter.output_diameter, hub.fit, -length - 1.0, -length + adapter.output_grip),
        cross_hole(hub.pin_height, hub.pin.size / 2, 2 * hub.radius, PIN_TURN),
    ]
    if output_pin is not None:
        cuts.append(cross_hole(low, output_pin.size / 2, 2 * hub.radius, PIN_TURN))
    else:
        cuts.append(cross_hole(low, insert_of(SET_SCREW).hole / 2, 2 * hub.radius, 0.0, 0.0))
    return body.cut(*cuts)


def adapter_volume(adapter: AdapterDimensions, hub: Hub, output_pin: Pin | None) -> float | None:
    """Volume of :func:`build_adapter`, mm^3; None if an insert's hole meets a flat, which has no closed form."""
    if output_pin is None:
        return None
    shaft, output = hub.shaft / 2 + hub.fit, adapter.output_diameter / 2 + hub.fit
    bores = section_area("round", hub.shaft, hub.fit) * adapter.shaft_grip
    bores += section_area(adapter.form, adapter.output_diameter, hub.fit) * adapter.output_grip
    holes = cross_volume(hub.radius, shaft, hub.pin.size / 2) + cross_volume(hub.radius, output, output_pin.size / 2)
    return math.pi * hub.radius**2 * adapter.length - bores - holes


def build_insert(form: Form, size: float, length: float, hub: Hub) -> Any:
    """The insert for a damper's bore as one cadquery Solid, smaller than the bore by ``hub.fit`` on every side."""
    body = build_section(form, size, -hub.fit, -length, 0.0)
    bore = build_section("round", hub.shaft, hub.fit, -length - 1.0, 1.0)
    return body.cut(bore, cross_hole(hub.pin_height, hub.pin.size / 2, 2 * size, PIN_TURN)).Solids()[0]


def set_screw_place(adapter: AdapterDimensions) -> tuple[float, float]:
    """Height (mm) of the set screw's axis and the distance of its start from the hinge axis: on the output's flat."""
    return pin_heights(adapter)[1], flat_distance(adapter.form, adapter.output_diameter)
