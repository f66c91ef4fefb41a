"""Rate of a helical torsion spring of round wire.

Symbols as in Shigley, Mechanical Engineering Design, section 10-12: E modulus, d wire diameter, D mean coil diameter,
Nb body coils, Na active coils, l1, l2 straight legs up to where the load acts.
"""

from __future__ import annotations

import math
from typing import Literal

from synth.parts.coil_angle import Convention

RateForm = Literal["bending", "friction"]

# N m/rad of E d^4 / (x D N). Bending: curved-beam theory, Shigley eq. 10-51 in radians, EN 13906-3. Friction: the
# handbook constant 10.8 *per turn* instead of 10.186, for friction between coils and on the arbor (Shigley
# 10-50); 6.0 % softer. The most common mistake is to read 10.8 as per radian.
_FORM = {"bending": 64.0, "friction": 10.8 * 2.0 * math.pi}
TINY = 1e-9  # of a diameter: no coil, and no division by zero
RATE_FORMULA: dict[RateForm, str] = {"bending": "64", "friction": "10.8"}  # as users write them
RATE_FORMS: dict[str, RateForm] = {"64": "bending", "10.8": "friction"}


def rate(
    modulus: float, wire_diameter: float, mean_diameter: float, active_coils: float, form: RateForm = "bending"
) -> float:
    """Torque per angle, N m/rad, of lengths in m and a modulus in Pa."""
    return modulus * wire_diameter**4 / (_FORM[form] * mean_diameter * active_coils)


def active_coils(
    body_coils: float,
    mean_diameter: float,
    leg_lengths: tuple[float, float] = (0.0, 0.0),
    convention: Convention = "tangent",
) -> float:
    """Active coils: the body's plus what two straight legs bend, ``(l1 + l2) / (3 pi D)`` if tangent (Shigley 10-48).

    Valid for legs loaded by a force at their ends. Catalogue torques are measured close to the body, without legs.
    """
    bent = sum(_equivalent_length(length, mean_diameter, convention) for length in leg_lengths)
    return body_coils + bent / (math.pi * mean_diameter)


def _equivalent_length(length: float, mean_diameter: float, convention: Convention) -> float:
    """Length (m) of wire under the whole moment that turns as far as a leg bends: l/3 if tangent.

    The force of a radial or an axial leg acts R = D/2 + l or R = D/2 from the axis, so it is M/R; it bends the leg as a
    cantilever by F l^3/(3 E I), which turns the spring by that over R: l^3/(3 R^2); EN 13906-3 has it for radial legs.
    """
    if convention == "tangent":
        return length / 3.0
    radius = 0.5 * mean_diameter + (length if convention == "radial" else 0.0)
    return length**3 / (3.0 * radius**2)


def coil_product(modulus: float, wire_diameter: float, wanted_rate: float, form: RateForm = "bending") -> float:
    """``D Na``, m, for the wanted rate: fixed for one wire, with only its split between D and Na free."""
    return modulus * wire_diameter**4 / (_FORM[form] * wanted_rate)


def mean_diameter_for(
    product: float,
    body_coils: float,
    leg_lengths: tuple[float, float] = (0.0, 0.0),
    convention: Convention = "tangent",
) -> float:
    """Mean diameter, m, from ``D Na`` and the body coils: D Na = D Nb + (l1 + l2)/(3 pi) if tangent.

    Not positive where the legs alone are too soft. Of axial legs, which a wide coil bends less, the wider solution.
    """
    widest = product / body_coils  # without legs
    if convention == "tangent":
        return (product - sum(leg_lengths) / (3.0 * math.pi)) / body_coils
    if not any(leg_lengths):
        return widest

    def excess(mean: float) -> float:
        return mean * active_coils(body_coils, mean, leg_lengths, convention) - product

    least = 0.0
    if convention == "axial":  # D Nb + 4 (l1^3 + l2^3) / (3 pi D^2) is least here
        least = (8.0 * sum(length**3 for length in leg_lengths) / (3.0 * math.pi * body_coils)) ** (1.0 / 3.0)
    if least >= widest or excess(least or widest * TINY) > 0.0:
        return 0.0
    if excess(widest) <= 0.0:  # legs whose part is below rounding
        return widest
    from scipy.optimize import brentq  # imported here: it takes 0.4 s, and most legs are tangent

    return float(brentq(excess, least or widest * TINY, widest, xtol=1e-15))


def energy(moment: float, spring_rate: float) -> float:
    """Elastic energy at a moment, J."""
    return moment**2 / (2.0 * spring_rate)
