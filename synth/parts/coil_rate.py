"""Rate of a helical torsion spring of round wire.

Symbols as in Shigley, Mechanical Engineering Design, section 10-12: E modulus, d wire diameter, D mean coil diameter,
Nb body coils, Na active coils, l1, l2 straight legs up to where the load acts.
"""

from __future__ import annotations

import math
from typing import Literal

RateForm = Literal["bending", "friction"]

# N m/rad of E d^4 / (x D N). Bending: curved-beam theory, Shigley eq. 10-51 in radians, EN 13906-3. Friction: the
# handbook constant 10.8 *per turn* instead of 10.186, for friction between coils and on the arbor (Shigley
# 10-50); 6.0 % softer. The most common mistake is to read 10.8 as per radian.
_FORM = {"bending": 64.0, "friction": 10.8 * 2.0 * math.pi}
RATE_FORMULA: dict[RateForm, str] = {"bending": "64", "friction": "10.8"}  # as users write them
RATE_FORMS: dict[str, RateForm] = {"64": "bending", "10.8": "friction"}


def rate(
    modulus: float, wire_diameter: float, mean_diameter: float, active_coils: float, form: RateForm = "bending"
) -> float:
    """Torque per angle, N m/rad, of lengths in m and a modulus in Pa."""
    return modulus * wire_diameter**4 / (_FORM[form] * mean_diameter * active_coils)


def active_coils(body_coils: float, mean_diameter: float, leg_lengths: tuple[float, float] = (0.0, 0.0)) -> float:
    """Active coils: the body's plus the contribution of two straight legs, ``(l1 + l2) / (3 pi D)`` (Shigley 10-48).

    Valid for legs loaded by a force at their ends. Catalogue torques are measured close to the body, without legs.
    """
    return body_coils + sum(leg_lengths) / (3.0 * math.pi * mean_diameter)


def coil_product(modulus: float, wire_diameter: float, wanted_rate: float, form: RateForm = "bending") -> float:
    """``D Na``, m, for the wanted rate: fixed for one wire, with only its split between D and Na free."""
    return modulus * wire_diameter**4 / (_FORM[form] * wanted_rate)


def mean_diameter_for(product: float, body_coils: float, leg_lengths: tuple[float, float] = (0.0, 0.0)) -> float:
    """Mean diameter, m, from ``D Na`` and the body coils: D Na = D Nb + (l1 + l2)/(3 pi).

    Not positive where the legs alone are too soft.
    """
    return (product - sum(leg_lengths) / (3.0 * math.pi)) / body_coils


def energy(moment: float, spring_rate: float) -> float:
    """Elastic energy at a moment, J."""
    return moment**2 / (2.0 * spring_rate)
