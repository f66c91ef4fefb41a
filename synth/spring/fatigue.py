"""Fatigue of a torsion spring in repeated bending: Gerber's parabola about the strength for so many cycles.

Symbols as in Shigley, Mechanical Engineering Design, section 10-12 (eqs 10-57 to 10-60): Sr the greatest stress from
zero that the wire bears so often (table 10-10, stress relieved, curvature factor in the stress), Se the amplitude that
it would bear about zero, Sa the one that it bears along the load line, r = amplitude over mean.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from synth.parts.wire import Fatigue


@dataclass(frozen=True)
class Life:
    """Stress amplitude and mean (Pa) of a spring, and for each life the amplitude that it bears over that which it has.

    ``repeated_1e5``, ``repeated_1e6``: stress from zero (Pa) that the wire bears so often. A factor of 1 or more: it
    lasts so many cycles. Yield is checked by itself.
    """

    amplitude: float
    mean: float
    repeated_1e5: float
    repeated_1e6: float
    factor_1e5: float
    factor_1e6: float
    source: str

    def repeated(self, cycles: float) -> float:
        """Stress from zero that the wire bears up to 1e5, or up to 1e6 times."""
        return self.repeated_1e5 if cycles <= 1e5 else self.repeated_1e6

    def factor(self, cycles: float) -> float:
        """The factor for up to 1e5, or up to 1e6 cycles."""
        return self.factor_1e5 if cycles <= 1e5 else self.factor_1e6


def endurance_about_zero(repeated: float, strength: float) -> float:
    """``Se = (Sr/2) / (1 - (Sr/2/Sut)^2)`` (10-58), Pa."""
    half = repeated / 2.0
    return half / (1.0 - (half / strength) ** 2)


def gerber_amplitude(endurance: float, strength: float, amplitude: float, mean: float) -> float:
    """Amplitude at failure on the load line through (mean, amplitude), Pa: ``Sa/Se + (Sm/Sut)^2 = 1`` (10-59).

    Without a mean it is ``Se``; without an amplitude the wire fails at its strength, which is no matter of fatigue.
    """
    if amplitude <= 0.0:
        return math.inf
    if mean == 0.0:
        return endurance
    slope = amplitude / abs(mean)
    root = math.sqrt(1.0 + (2.0 * endurance / (slope * strength)) ** 2)
    return (slope * strength) ** 2 / (2.0 * endurance) * (root - 1.0)


def life(fatigue: Fatigue | None, strength: float, least: float, greatest: float) -> Life | None:
    """Life under stress that goes between ``least`` and ``greatest`` (Pa, negative where the coil opens)."""
    if fatigue is None:
        return None
    amplitude, mean = (greatest - least) / 2.0, (greatest + least) / 2.0
    repeated = [share * strength for share in (fatigue.at_1e5, fatigue.at_1e6)]
    factors = [math.inf, math.inf]
    if amplitude > 0.0:
        borne = (gerber_amplitude(endurance_about_zero(sr, strength), strength, amplitude, mean) for sr in repeated)
        factors = [value / amplitude for value in borne]
    return Life(amplitude, mean, repeated[0], repeated[1], factors[0], factors[1], fatigue.source)
