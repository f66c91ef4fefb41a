"""The parts along the hinge's shaft: plain arithmetic, no solids; frame of ``cad.layout``.

Upwards: damper end | collar | thrust washer | ear A with its bearing | tongue | coil | seat plate | ear B with its
bearing | thrust washer | collar. Bearings are pressed into the ears from inside, up to a lip; the collars run on
these lips by their thrust washers, so they alone place the shaft along its axis, and clamping them sets the play. The
tongue is pinned to the shaft.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from synth.cad.dimensions import JointDimensions
from synth.cad.hardware import Pin, insert_of, pin_at_least
from synth.cad.layout import JointLayout
from synth.cad.outline import Point, unit

Array = NDArray[np.float64]

AXIAL_GAP = 0.02  # mm, between a lip and its thrust washer as drawn: collars are clamped against them by hand
PIN_WALL = 1.2  # mm of print around a pin's hole: three lines
AMPLE = 2.0  # mm of print between the pin's hole and an insert; more has no advantage
LONGEST_PIN = 3.0  # shaft diameters; a longer pin does not reduce the largest pressure
RIM = 1.0  # mm, on which an encoder's housing lies
FLOOR = 1.2  # mm of print between a collar and an encoder: three lines
BLIND = 0.3  # mm, depth of the pin's hole beyond its end
TURNS = range(0, 360, 5)  # deg, directions that are tried for the pin's hole
WAYS = np.array([unit(turn) for turn in TURNS])
SAMPLES = 8  # points along a horn or the stem, from which the hole keeps a distance


@dataclass(frozen=True)
class ShaftLine:
    """Heights (mm) of the parts on the shaft, canonical, and the pin that holds the tongue."""

    outside_a: float  # of ear A
    outside_b: float
    bottom: float  # of the shaft
    top: float
    pin: Pin
    pin_height: float
    pin_angle: float  # deg, direction from which the pin is pushed in, in the lower half's frame at q = 0

    def washers(self, thickness: float) -> tuple[float, float]:
        """Z of the lower faces of both thrust washers: at ear A, at ear B."""
        return self.outside_a - AXIAL_GAP - thickness, self.outside_b + AXIAL_GAP

    def collars(self, thickness: float, width: float) -> tuple[float, float]:
        """Z of the lower faces of both collars; ``thickness`` of the washers."""
        low, high = self.washers(thickness)
        return low - width, high + thickness


def beyond_collar(dimensions: JointDimensions) -> float:
    """Projection (mm) of the shaft beyond ear B's collar: through the floor under an encoder no wider than that."""
    encoder = dimensions.encoder
    if encoder is None or encoder.body_diameter >= 2 * (dimensions.hardware.radius + dimensions.clearance) + 2 * RIM:
        return 0.0
    return dimensions.clearance + FLOOR


def tongue_pin(dimensions: JointDimensions, tongue_radius: float) -> Pin | None:
    """The pin through tongue and shaft, of a length sold that ends inside; None if the tongue is too small."""
    size, shaft = dimensions.hardware.pin, dimensions.shaft_diameter
    most = min(LONGEST_PIN * shaft, 2 * (tongue_radius - PIN_WALL))
    found = pin_at_least(size, shaft + 2 * size)
    while found is not None and found.length <= most:
        longer = pin_at_least(size, found.length + 1.0)
        if longer is None or longer.length > most:
            return found
        found = longer
    return None


def lay_shaft(dimensions: JointDimensions, layout: JointLayout, bottom: float) -> ShaftLine:
    """The parts along the shaft; ``bottom`` mm of the shaft, from the damper."""
    hardware = dimensions.hardware
    pin = tongue_pin(dimensions, layout.space.tongue_radius)
    assert pin is not None  # checked when the joint was laid out
    outside = layout.gap_b + layout.ear
    return ShaftLine(
        outside_a=-layout.gap_a - layout.ear,
        outside_b=outside,
        bottom=bottom,
        top=outside + AXIAL_GAP + hardware.stack + beyond_collar(dimensions),
        pin=pin,
        pin_height=(layout.floor_top + layout.floor_bottom) / 2,
        pin_angle=_pin_angle(layout, pin),
    )


@lru_cache(maxsize=64)  # asked for by each part on the shaft
def _pin_angle(layout: JointLayout, pin: Pin) -> float:
    """The direction of the pin's hole with enough print beside the inserts, farthest from horns and stem.

    A hole may go through a horn or the stem, which makes it longer; through an insert it may not.
    """
    hole, enough = insert_of(layout.seat.screw).hole / 2, pin.size / 2 + AMPLE
    inserts = [(at, hole) for at in layout.lower.screws]
    beside = np.minimum(_spares(WAYS, inserts), enough)
    clear = beside == beside.max()
    return float(TURNS[int(np.argmax(np.where(clear, _spares(WAYS, _obstacles(layout)), -np.inf)))])


def pin_spare(layout: JointLayout, line: ShaftLine) -> float:
    """Print (mm) between the pin's hole and the nearest insert."""
    hole = insert_of(layout.seat.screw).hole / 2
    way = np.array([unit(line.pin_angle)])
    return float(_spares(way, [(at, hole) for at in layout.lower.screws])[0]) - line.pin.size / 2


def _obstacles(layout: JointLayout) -> list[tuple[Point, float]]:
    """Points (mm) that a hole in the floor's middle should avoid, each with a radius: horns and stem."""
    found: list[tuple[Point, float]] = []
    radius = layout.space.tongue_radius
    for stop in layout.stops:
        along, aside = unit(stop.flank), unit(stop.flank + 90.0 * stop.way)
        for k in range(SAMPLES):
            r = radius + (stop.outer - radius) * k / (SAMPLES - 1)
            n = stop.width / 2
            found.append(((r * along[0] + n * aside[0], r * along[1] + n * aside[1]), n))
    found += [((0.0, -radius - 4.0 * k), layout.socket_outer) for k in range(SAMPLES)]
    return found


def _spares(ways: Array, discs: Sequence[tuple[Point, float]]) -> Array:
    """Distance (n,) mm at which a ray from the hinge along each unit vector ``ways`` (n, 2) passes the nearest disc."""
    x, y = ways[:, :1], ways[:, 1:]
    at, radius = np.array([place for place, _ in discs]), np.array([radius for _, radius in discs])
    passed = np.abs(at[:, 0] * y - at[:, 1] * x)
    ahead = at[:, 0] * x + at[:, 1] * y > 0.0
    return np.asarray((np.where(ahead, passed, np.hypot(at[:, 0], at[:, 1])) - radius).min(axis=1))
