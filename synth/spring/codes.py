"""The same spring by several codes: what each takes as stress, and how much of it each allows.

Codes differ in the curvature factor and in the strength that they start from, so a stress of one must not be held
against the limit of another. Each pair here belongs together:

- Shigley: inner-fibre factor Ki, a share of the least tensile strength of this wire (Mechanical Engineering Design,
  section 10-12, table 10-6).
- the spring makers' handbook (ODOP): factor (4C - 1)/(4C - 4) of stress relieved springs, their share of their law.
- EN 13906-3: no factor for static load, 0.70 of the strength by EN 10270; for load that changes, the range with
  q = (w + 0.07)/(w - 0.75), w = D/d. The fatigue diagrams that EN 13906-3 holds this range against could not be had;
  the repeated-bending limits of Shigley's table 10-10 stand beside it (``fatigue``).
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

# Winding leaves residual stresses that help a coil that closes and hurt one that opens. The handbook allows 100 % of
# the strength closing where they are left in and 85 % where heat took them out (music wire): they are worth 15 points,
# so opening has as much less, 70 of 85. Heat takes most of them out, so this is on the safe side.
OPENING = (2.0 * 85.0 - 100.0) / 85.0


@dataclass(frozen=True)
class CodeCheck:
    """One code's view: its ``stress`` at full travel and what it allows, Pa; ``source`` of the allowance."""

    code: str
    stress: float
    allowed: float
    source: str

    @property
    def safety(self) -> float:
        """Allowed stress over stress."""
        return self.allowed / self.stress if self.stress > 0.0 else math.inf

    def as_json(self) -> dict[str, Any]:
        """Every number beside its unit."""
        return {
            "code": self.code,
            "stress": quantity(self.stress, "MPa"),
            "allowed": quantity(self.allowed, "MPa"),
            **({"safety": quantity(self.safety, "1")} if math.isfinite(self.safety) else {}),
            "source": self.source,
        }


def code_checks(allowables: Sequence[Allowable], moment: float, wire: float, mean: float) -> tuple[CodeCheck, ...]:
    """Each code's stress under ``moment`` (N m) and what it allows."""
    return tuple(
        CodeCheck(each.code, bending_stress(moment, wire, mean, FORM[each.code]), each.stress, each.source)
        for each in allowables
    )


def dynamic_factor(index: float) -> float:
    """``q = (w + 0.07) / (w - 0.75)``, w = D/d: the stress factor of EN 13906-3 for load that changes."""
    return (index + 0.07) / (index - 0.75)


def surge_frequency(wire: float, mean: float, coils: float, modulus: float, density: float) -> float:
    """Lowest frequency at which the coils swing by themselves between held ends, Hz.

    A turn of the cross-section about the coil's axis runs along the wire as a wave: inertia ``rho A D^2/4`` a length,
    stiffness ``E I``, so ``c = d/(2 D) sqrt(E/rho)``; over the wire's length ``pi D N``, both ends held, half a wave
    fits: ``f = c / (2 pi D N) = d / (4 pi D^2 N) sqrt(E/rho)``. For steel 1260 d/(pi D^2 N) in metres, the handbooks'
    form.
    """
    return wire / (4.0 * math.pi * mean**2 * coils) * math.sqrt(modulus / density)
