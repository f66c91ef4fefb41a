"""The unit of time inside the integrator, scaled to the motion.

Bounds, first steps and the micro-damping of bristles are constants in seconds and radians per second, chosen for limbs
that swing at a few hertz. A fast oscillator or a slow pendulum is integrated in scaled time, in which it swings at a
few hertz too.
"""

from __future__ import annotations

import re

USUAL_PACE = 0.04  # s, see ``synth.pace``: half a radian of a limb at 2 Hz
# Power of time in each unit; a newton is kg m/s^2.
_OF_UNIT = {"s": 1, "ms": 1, "min": 1, "Hz": -1, "rpm": -1, "N": -2, "ozf": -2, "lbf": -2, "J": -2, "W": -3}
_FACTOR = re.compile(r"([*/]?)\s*([A-Za-z]+)(?:\s*\^\s*(-?\d+))?")


def time_unit(pace: float) -> float:
    """The unit, s, for a motion of this ``pace``, s (see ``synth.pace``): 1 at 2 Hz."""
    return pace / USUAL_PACE if pace > 0.0 else 1.0


def time_exponent(unit: str) -> int:
    """Power of time in a unit as effects write it: N*m gives -2, N*m*s/rad -1, s/rad 1."""
    total = 0
    for operator, name, power in _FACTOR.findall(unit):
        total += (-1 if operator == "/" else 1) * _OF_UNIT.get(name, 0) * int(power or 1)
    return total
