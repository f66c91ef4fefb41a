"""Bending stress of a torsion spring, and its travel before yield.

Symbols as in Shigley, Mechanical Engineering Design, section 10-12: C = D/d is the spring index.
"""

from __future__ import annotations

import math
from typing import Literal

CurvatureForm = Literal["inner", "outer", "handbook", "none"]


def spring_index(mean_diameter: float, wire_diameter: float) -> float:
    """C = D/d."""
    return mean_diameter / wire_diameter


def curvature_factor(index: float, form: CurvatureForm = "inner") -> float:
    """Curvature correction factor of the bending stress.

    ``inner``, ``outer``: Ki, Ko of Wahl, Shigley eq. 10-43. ``handbook``: (4C - 1)/(4C - 4), the spring makers'
    handbooks. ``none``: 1, which the handbooks use for wire that is not stress relieved.

    Raises
    ------
    ValueError
        If the index is not above 1: the coil would have no hole.
    """
    if not index > 1.0:
        raise ValueError(f"a spring index of {index} leaves no hole in the coil")
    if form == "inner":
        return (4.0 * index**2 - index - 1.0) / (4.0 * index * (index - 1.0))
    if form == "outer":
        return (4.0 * index**2 + index - 1.0) / (4.0 * index * (index + 1.0))
    return (4.0 * index - 1.0) / (4.0 * index - 4.0) if form == "handbook" else 1.0


def bending_stress(moment: float, wire_diameter: float, mean_diameter: float, form: CurvatureForm = "inner") -> float:
    """``K 32 M / (pi d^3)``, Pa (Shigley eq. 10-44); ``moment`` in N m, diameters in m."""
    factor = 1.0 if form == "none" else curvature_factor(spring_index(mean_diameter, wire_diameter), form)
    return factor * 32.0 * moment / (math.pi * wire_diameter**3)


def moment_limit(stress: float, wire_diameter: float, mean_diameter: float, form: CurvatureForm = "inner") -> float:
    """The moment, N m, at which the bending stress is ``stress`` Pa; diameters in m."""
    return stress / bending_stress(1.0, wire_diameter, mean_diameter, form)


def free_travel(stress: float, spring_rate: float, wire_diameter: float, mean_diameter: float) -> float:
    """Angle from the free position at which the inner fibre reaches ``stress`` Pa, rad; rate in N m/rad, sizes in m."""
    return moment_limit(stress, wire_diameter, mean_diameter) / spring_rate
