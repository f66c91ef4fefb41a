"""Tolerances of cold-coiled torsion springs by DIN 2194 (2002-08): diameter, torque, free angle, length of legs.

The standard was not available to us. The formulas are those of class ``TDIN2194`` in
https://github.com/melchiorrecaruso/springone, a public programme for springs by the standards. Lengths are in mm,
w = D/d is the spring index and n the number of coils; Q is 0.63, 1 or 1.6 for grade 1, 2 or 3:

- mean diameter ``A_D = 0.025 D / d^0.17 Q``
- torque at a given angle ``A_M = 1.3 k d^3 / (n^0.24 sqrt(w)) Q`` N mm, k = 104 for steel of EN 10270-1 and -2, 90 for
  stainless steel of EN 10270-3, 54 for bronze of EN 12166
- angle between the free legs ``2.4 n^0.76 sqrt(w) Q`` deg
- length of a leg ``A_l = (0.2 d + Q) c``, c = 0.3 up to 6 mm, 0.8 to 30, 1.3 to 120, 1.9 to 400, 3.2 to 1000

The second and the third agree with each other: for steel, the rate ``E d^3/(64 w n)`` times the deviation of the angle
is that of the torque with E = 206.6 GPa. No other public source was found that confirms the remaining two.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from synth.units import quantity

STANDARD = "DIN 2194"
SOURCE = "formulas of TDIN2194 in https://github.com/melchiorrecaruso/springone; the standard was not available to us"
FACTOR = {1: 0.63, 2: 1.0, 3: 1.6}  # Q
STEEL = 104.0  # k of EN 10270-1 and -2
# k of other wires: EN 10270-3 and EN 12166
TORQUE_FACTOR = {"stainless 302": 90.0, "stainless 316": 90.0, "stainless 17-7": 90.0, "phosphor bronze": 54.0}
LEGS = ((6.0, 0.3), (30.0, 0.8), (120.0, 1.3), (400.0, 1.9), (1000.0, 3.2))  # length up to, mm -> c
# The standard's scope
WIRE = (0.07, 17.0)  # mm
MOST_DIAMETER = 340.0  # mm
INDEX = (4.0, 20.0)
FEWEST_COILS = 2.0
LEG = (0.5, 1000.0)  # mm


@dataclass(frozen=True)
class GradeTolerance:
    """Plus or minus, of one quality ``grade``: diameters and legs m, torque N m, free angle rad."""

    grade: int
    mean_diameter: float
    torque: float
    free_angle: float
    leg_lengths: tuple[float, ...]

    def as_json(self) -> dict[str, object]:
        """Every number with its unit."""
        return {
            "grade": str(self.grade),
            "torque": quantity(self.torque, "N*m"),
            "free_angle": quantity(self.free_angle, "deg"),
            "mean_diameter": quantity(self.mean_diameter, "mm"),
            "leg_lengths": [quantity(length, "mm") for length in self.leg_lengths],
        }


def grade_tolerances(
    material: str, wire: float, mean: float, coils: float, legs: tuple[float, ...]
) -> tuple[GradeTolerance, ...]:
    """Tolerances of grades 1, 2 and 3; empty outside the standard's scope.

    Lengths in m; ``material`` is a name of the catalogues.
    """
    d, diameter = wire * 1e3, mean * 1e3
    index = mean / wire
    long = [length * 1e3 for length in legs]
    inside = WIRE[0] <= d <= WIRE[1] and diameter <= MOST_DIAMETER and coils >= FEWEST_COILS
    if not (inside and INDEX[0] <= index <= INDEX[1] and all(LEG[0] <= length <= LEG[1] for length in long)):
        return ()
    torque = 1.3 * TORQUE_FACTOR.get(material, STEEL) * d**3 / (coils**0.24 * math.sqrt(index))
    angle = 2.4 * coils**0.76 * math.sqrt(index)
    return tuple(
        GradeTolerance(
            grade,
            0.025 * diameter / d**0.17 * factor * 1e-3,
            torque * factor * 1e-3,
            math.radians(angle * factor),
            tuple(leg_tolerance(wire, length, grade) for length in legs),
        )
        for grade, factor in FACTOR.items()
    )


def suitable_grade(grades: tuple[GradeTolerance, ...], free_angle: float) -> GradeTolerance | None:
    """The coarsest grade with a free angle within ``free_angle`` (rad), else the finest; None without grades."""
    if not grades:
        return None
    enough = [each for each in grades if each.free_angle <= free_angle]
    return max(enough, key=lambda each: each.grade) if enough else grades[0]


def leg_tolerance(wire: float, length: float, grade: int) -> float:
    """Tolerance of a leg's length, m, plus or minus, of wire and leg in m; of the longest legs beyond the scope."""
    factor = next((factor for most, factor in LEGS if length * 1e3 <= most), LEGS[-1][1])
    return (0.2 * wire * 1e3 + FACTOR[grade]) * factor * 1e-3
