"""Stress and allowable stress of a spring by several design codes.

Codes differ in the curvature factor and in the strength to which they refer. A stress by one code must therefore not be
compared with the limit of another. The pairs are:

- Shigley: inner-fibre factor Ki; allowable stress as a fraction of the minimum tensile strength of this wire
  (Mechanical Engineering Design, section 10-12, table 10-6).
- The spring makers' handbook (ODOP): factor (4C - 1)/(4C - 4) for stress-relieved springs; allowable stress as a
  fraction of the handbook's own strength law.
- EN 13906-3: no factor for static load; allowable stress 0.70 of the strength by EN 10270. For varying load the stress
  range has the factor q = (w + 0.07)/(w - 0.75), w = D/d. The fatigue diagrams of EN 13906-3 for this range were not
  available to us; fatigue is checked by the repeated-bending limits of Shigley's table 10-10 instead (``fatigue``).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from synth.parts.wire import Allowable
from synth.spring.stress import CurvatureForm, bending_stress
from synth.units import quantity

FORM: dict[str, CurvatureForm] = {"Shigley": "inner", "spring makers' handbook": "handbook", "EN 13906-3": "none"}

# Winding leaves residual stresses that reduce the stress of a coil that closes and add to that of one that opens. For
# closing, the handbook allows 100 % of the strength with these stresses and 85 % after stress relief (music wire). They
# are therefore worth 15 points, and opening is allowed 15 points less: 70 of 85. Heat treatment removes most of them,
# so this is conservative.
OPENING = (2.0 * 85.0 - 100.0) / 85.0


@dataclass(frozen=True)
class CodeCheck:
    """The check by one code: ``stress`` at full travel and allowable stress, Pa; ``source`` of the allowable stress."""

    code: str
    stress: float
    allowed: float
    source: str

    @property
    def safety(self) -> float:
        """Allowable stress over stress; infinite without stress."""
        return self.allowed / self.stress if self.stress > 0.0 else math.inf

    def as_json(self) -> dict[str, Any]:
        """Every number with its unit, for a result file."""
        return {
            "code": self.code,
            "stress": quantity(self.stress, "MPa"),
            "allowed": quantity(self.allowed, "MPa"),
            **({"safety": quantity(self.safety, "1")} if math.isfinite(self.safety) else {}),
            "source": self.source,
        }


def code_checks(allowables: Sequence[Allowable], moment: float, wire: float, mean: float) -> tuple[CodeCheck, ...]:
    """Stress under ``moment`` (N m) and allowable stress by each code; diameters in m."""
    return tuple(
        CodeCheck(each.code, bending_stress(moment, wire, mean, FORM[each.code]), each.stress, each.source)
        for each in allowables
    )


def dynamic_factor(index: float) -> float:
    """``q = (w + 0.07) / (w - 0.75)``, w = D/d: the stress factor of EN 13906-3 for varying load."""
    return (index + 0.07) / (index - 0.75)


def surge_frequency(wire: float, mean: float, coils: float, modulus: float, density: float) -> float:
    """Lowest natural frequency of the coils between fixed ends, Hz.

    A rotation of the cross-section about the coil's axis travels along the wire as a wave. Its inertia per length is
    ``rho A D^2/4`` and its stiffness ``E I``, so its speed is ``c = d/(2 D) sqrt(E/rho)``. In the first mode with both
    ends fixed, the wire's length ``pi D N`` is half a wavelength:
    ``f = c / (2 pi D N) = d / (4 pi D^2 N) sqrt(E/rho)``. For steel this is 1260 d/(pi D^2 N) with lengths in metres,
    the form of the handbooks. Lengths in m, ``modulus`` in Pa, ``density`` in kg/m^3.
    """
    return wire / (4.0 * math.pi * mean**2 * coils) * math.sqrt(modulus / density)
