"""Fatigue of a torsion spring in repeated bending, by the Gerber criterion.

Symbols as in Shigley, Mechanical Engineering Design, section 10-12 (eqs 10-57 to 10-60). Sr is the largest stress,
cycling from zero, that the wire bears for the number of cycles (table 10-10, stress relieved, with the curvature factor
in the stress). Se is the endurance amplitude about zero mean stress. Sa is the amplitude at failure on the load line,
and r the ratio of amplitude to mean.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from synth.parts.wire import Fatigue


@dataclass(frozen=True)
class Life:
    """Stress amplitude and mean (Pa) of a spring, and for each life its safety factor against fatigue.

    The factor is the amplitude at failure over the actual amplitude; with 1 or more the spring lasts that many cycles.
    ``repeated_1e5``, ``repeated_1e6``: stress from zero (Pa) that the wire bears for so many cycles. Yield is checked
    separately.
    """

    amplitude: float
    mean: float
    repeated_1e5: float
    repeated_1e6: float
    factor_1e5: float
    factor_1e6: float
    source: str

    def repeated(self, cycles: float) -> float:
        """Stress from zero (Pa) that the wire bears for 1e5 cycles, or for 1e6 if ``cycles`` is above 1e5."""
        return self.repeated_1e5 if cycles <= 1e5 else self.repeated_1e6

    def factor(self, cycles: float) -> float:
        """The safety factor for 1e5 cycles, or for 1e6 if ``cycles`` is above 1e5."""
        return self.factor_1e5 if cycles <= 1e5 else self.factor_1e6


def endurance_about_zero(repeated: float, strength: float) -> float:
    """``Se = (Sr/2) / (1 - (Sr/2/Sut)^2)`` (10-58), Pa."""
    half = repeated / 2.0
    return half / (1.0 - (half / strength) ** 2)


def gerber_amplitude(endurance: float, strength: float, amplitude: float, mean: float) -> float:
    """Amplitude at failure on the load line through (mean, amplitude), Pa: ``Sa/Se + (Sm/Sut)^2 = 1`` (10-59).

    With zero mean stress it is ``Se``. With zero amplitude there is no fatigue: the wire fails at its strength.
    """
    if amplitude <= 0.0:
        return math.inf
    root = math.hypot(1.0, 2.0 * endurance * mean / (amplitude * strength))
    return 2.0 * endurance / (1.0 + root)  # the root less one, multiplied out: exact for small mean stresses too


def life(fatigue: Fatigue | None, strength: float, least: float, greatest: float) -> Life | None:
    """Life under stress that cycles between ``least`` and ``greatest`` (Pa, negative where the coil opens).

    None if ``fatigue`` is None: no fatigue data are known for the wire. ``strength``: tensile strength, Pa.
    """
    if fatigue is None:
        return None
    amplitude, mean = (greatest - least) / 2.0, (greatest + least) / 2.0
    repeated = [share * strength for share in (fatigue.at_1e5, fatigue.at_1e6)]
    factors = [math.inf, math.inf]
    if amplitude > 0.0:
        borne = (gerber_amplitude(endurance_about_zero(sr, strength), strength, amplitude, mean) for sr in repeated)
        factors = [value / amplitude for value in borne]
    return Life(amplitude, mean, repeated[0], repeated[1], factors[0], factors[1], fatigue.source)
