"""Data for winding a spring: tolerances, mandrel, turns on it, stress relief, and the hand of the coil.

Spring-back: wire bent to the radius R_m around the mandrel relaxes elastically, ``1/R_m - 1/R = M/(E I)`` with M the
bending moment. Round wire of radius r yields at the stress s except in an elastic core of radius c r. Its moment is
``M = 4 s r^3 { [asin c - c sqrt(1 - c^2)(1 - 2 c^2)] / (8 c) + (1 - c^2)^(3/2) / 3 }`` (bending of an elastic,
perfectly plastic rod). For a thin core this is the handbook form ``1/D_m = 1/D + 1.7 s/(E d)``. Hard-drawn wire yields
near its tensile strength. The resulting mandrel is for a first trial coil and must be corrected by its measurement.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from synth.files.spring_words import Hand
from synth.parts.part_tolerance import free_angle_tolerance

# Outer diameter up to, mm -> plus or minus mm, the tolerance of Lee Spring: http://www.leespring.com/torsion_tol.asp
OUTER = (
    (3.17, 0.10), (5.08, 0.13), (7.62, 0.18), (10.41, 0.26), (12.70, 0.33), (17.78, 0.38), (22.23, 0.51), (28.58, 0.64),
    (30.94, 0.76), (31.75, 0.89),
)  # fmt: skip
OUTER_BEYOND = OUTER[-1][1] / OUTER[-1][0]  # relative tolerance beyond the end of the list

# Wire -> oven temperature in degC, minutes, change of the coil (spring makers' practice, SMI handbook).
RELIEF = {
    "music wire": (230, 30, "shrinks a little in diameter and winds up"),
    "hard drawn": (230, 30, "shrinks a little in diameter and winds up"),
    "oil tempered": (260, 30, "hardly changes"),
    "chrome vanadium": (370, 30, "hardly changes"),
    "chrome silicon": (400, 30, "hardly changes"),
    "stainless 302": (345, 30, "grows a little in diameter and opens"),
}


@dataclass(frozen=True)
class WindingTolerance:
    """Tolerances, plus or minus: diameters in m, ``coils`` as a number, ``rate`` relative, ``free_angle`` in rad."""

    wire_diameter: float
    mean_diameter: float
    coils: float
    rate: float
    free_angle: float


def winding_tolerance(wire: float, mean: float, coils: float, wire_tolerance: float) -> WindingTolerance:
    """Tolerance of a wound spring; of the rate ``dk/k = sqrt((4 dd/d)^2 + (dD/D)^2 + (dN/N)^2)``, as k ~ d^4/(D N).

    Diameters and ``wire_tolerance`` in m.
    """
    outer = (mean + wire) * 1e3
    off = next((plus for most, plus in OUTER if outer <= most), OUTER_BEYOND * outer) * 1e-3
    angle = free_angle_tolerance(coils)
    turns = angle / math.tau
    rate = math.sqrt((4.0 * wire_tolerance / wire) ** 2 + (off / mean) ** 2 + (turns / coils) ** 2)
    return WindingTolerance(wire_tolerance, off, turns, rate, angle)


def plastic_moment(core: float) -> float:
    """Bending moment of a round rod over ``s r^3``; ``core`` (0 to 1): radius of the elastic core over the rod's r."""
    if core <= 0.0:
        return 4.0 / 3.0
    root = math.sqrt(max(0.0, 1.0 - core**2))
    elastic = (math.asin(min(1.0, core)) - core * root * (1.0 - 2.0 * core**2)) / (8.0 * core)
    return 4.0 * (elastic + root**3 / 3.0)


def mandrel_diameter(mean: float, wire: float, modulus: float, flow_stress: float) -> float:
    """Diameter of the mandrel (m) whose coil springs back to the mean diameter ``mean``.

    Lengths in m, stresses in Pa. Bisection on the wound curvature: the relaxed curvature increases with it.
    """
    radius, inertia = wire / 2.0, math.pi * wire**4 / 64.0

    def relaxed(curvature: float) -> float:
        core = min(1.0, flow_stress / (modulus * curvature * radius))
        moment = plastic_moment(core) * flow_stress * radius**3
        return curvature - moment / (modulus * inertia)

    low, high = 2.0 / mean, 2.0 / mean + 4.0 * flow_stress / (modulus * wire)
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if relaxed(middle) < 2.0 / mean else (low, middle)
    return 2.0 / high - wire


def turns_on_mandrel(mean: float, wire: float, coils: float, mandrel: float) -> float:
    """Turns to wind so that ``coils`` are left after spring-back; the wire's length is constant: ``N D / D_m``."""
    return coils * mean / (mandrel + wire)


def stress_relief(material: str) -> str | None:
    """The heat treatment as a sentence; None for a wire without data."""
    if material not in RELIEF:
        return None
    celsius, minutes, does = RELIEF[material]
    return f"{celsius} degC for {minutes} min, then in still air; the coil {does}, so check the angle afterwards"


def hand_for(*, closes_clockwise: bool) -> Hand:
    """The hand of the coil that is wound up by the load, ``right`` or ``left``.

    ``closes_clockwise``: whether the load turns the far leg clockwise relative to the near one, seen from the near end.
    A right-hand helix recedes clockwise from the viewer, so turning its far end clockwise adds turns.
    """
    return "right" if closes_clockwise else "left"
