"""The test of a loose spring: how a maker holds it, the rate that it has then, and the two torques to measure.

The coil sits on an arbor, and a pin presses square on each arm at a stated distance from the coil (where the straight
arm leaves it). An arm so loaded bends as a cantilever and adds a third of that distance to the coil's length
(Shigley eq. 10-48). A joint clamps both arms instead, which is stiffer or softer than that: the rate in the joint
(``cad.flexed_wire``) is not the one to expect on the bench.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from synth.parts.coil_rate import active_coils
from synth.spring.din_2194 import leg_tolerance
from synth.units import quantity

HOW_HELD = "loose on an arbor, a pin pressing square on each arm"
WHOLE = 0.5e-3  # m, to which a test's distance is rounded: what a pin can be set to
# Wire diameters by which an arm passes the load at least: half a pin as thick as the wire, and two beyond it. As much
# as a joint holds of an arm at least, with screws about as thick as the wire (``cad.arm_layout.seat_size``).
BEYOND_LOAD = 2.5
COARSEST = 3  # grade of DIN 2194, as which the arms may be made


@dataclass(frozen=True)
class LooseTest:
    """A test with pins at ``distances`` (m, from the coil, near and far arm); ``rate`` in N m/rad is the one there."""

    distances: tuple[float, float]
    active_coils: float
    rate: float

    def rate_at(self, distance: float, body_coils: float, mean_diameter: float) -> float:
        """Rate (N m/rad) with both pins ``distance`` m from the coil; k N is that of the wire, k ~ 1/N."""
        return self.rate * self.active_coils / active_coils(body_coils, mean_diameter, (distance, distance))

    def force(self, angle: float) -> float | None:
        """Force (N) of the far arm's pin at ``angle`` rad; None if it presses at the coil."""
        return self.rate * angle / self.distances[1] if self.distances[1] > 0.0 else None

    def as_json(self, travel: float | None = None) -> dict[str, Any]:
        """Every number with its unit; ``travel`` rad: with the pin's force there."""
        force = None if travel is None else self.force(travel)
        return {
            "held": HOW_HELD,
            "distances": [quantity(distance, "mm") for distance in self.distances],
            "active_coils": quantity(self.active_coils, "1"),
            "rate": quantity(self.rate, "N*m/rad"),
            **({} if force is None else {"force": quantity(force, "N")}),
        }


def loose_test(body_rate: float, body_coils: float, mean_diameter: float, distance: float) -> LooseTest:
    """The test with both pins at ``distance`` m of a spring whose coil alone has ``body_rate`` N m/rad."""
    active = active_coils(body_coils, mean_diameter, (distance, distance))
    return LooseTest((distance, distance), active, body_rate * body_coils / active)


def arm_to_end(wire_diameter: float, load: float) -> float:
    """Length of an arm to its end (m) that a load or pin ``load`` m from the coil presses: it must not slip off.

    The shortest arm within its tolerance still passes the load by ``BEYOND_LOAD`` wire diameters; rounded up to
    ``WHOLE``. An arm of length 0, loaded at the coil, is none.
    """
    if load <= 0.0:
        return 0.0
    needed = load + BEYOND_LOAD * wire_diameter
    needed += leg_tolerance(wire_diameter, needed, COARSEST)
    return math.ceil(needed / WHOLE - 1e-9) * WHOLE


def arms_to_ends(wire_diameter: float, loads: tuple[float, float]) -> tuple[float, float]:
    """``arm_to_end`` of both arms."""
    near, far = (arm_to_end(wire_diameter, load) for load in loads)
    return near, far


def pin_distance(free_arm: float, seat: float) -> float:
    """Where the pins press (m): the middle of the length ``seat`` m by which the joint clamps an arm, rounded down."""
    return math.floor((free_arm + seat / 2.0) / WHOLE + 1e-9) * WHOLE


@dataclass(frozen=True)
class LoadPoint:
    """A torque (N m) to measure at an angle (rad) from the free position, and its tolerance ``within`` (N m)."""

    angle: float
    torque: float
    within: float

    def as_json(self) -> dict[str, Any]:
        """Every number beside its unit."""
        return {
            "angle": quantity(self.angle, "deg"),
            "torque": quantity(self.torque, "N*m"),
            "within": quantity(self.within, "N*m"),
        }


def load_points(rate: float, travel: float, tolerance: float) -> tuple[LoadPoint, LoadPoint]:
    """The two angles at which to measure the torque, T1 and T2; ``tolerance`` relative, that of the rate.

    T2 is at the full travel. T1 is at a third of it, where the coils have separated and static friction between them no
    longer acts. Angles are from the free position.
    """
    first, second = (LoadPoint(a, rate * a, rate * a * tolerance) for a in (travel / 3.0, travel))
    return first, second
