"""The unit of time inside the integrator: the motion's own.

Bounds, first steps and the micro-damping of bristles are numbers in seconds and radians a second, chosen for limbs of
some hertz. A fast oscillator or a slow pendulum is integrated in a time of its own, in which it is such a limb.
"""

from __future__ import annotations

import re

USUAL_PACE = 0.04  # s, see ``motion.pace``: half a radian of a limb at 2 Hz
# power of time in each: a newton is kg m/s^2
_OF_UNIT = {"s": 1, "ms": 1, "min": 1, "Hz": -1, "rpm": -1, "N": -2, "ozf": -2, "lbf": -2, "J": -2, "W": -3}
_FACTOR = re.compile(r"([*/]?)\s*([A-Za-z]+)(?:\s*\^\s*(-?\d+))?")


def time_unit(pace: float) -> float:
    """The unit, s, for a motion of this pace, s: 1 at 2 Hz."""
    return pace / USUAL_PACE if pace > 0.0 else 1.0


def time_exponent(unit: str) -> int:
    """Power of time in a unit as effects write it: -2 of N*m, -1 of N*m*s/rad, 1 of s/rad."""
    total = 0
    for operator, name, power in _FACTOR.findall(unit):
        total += (-1 if operator == "/" else 1) * _OF_UNIT.get(name, 0) * int(power or 1)
    return total
