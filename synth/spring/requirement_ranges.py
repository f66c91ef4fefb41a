"""The range of every number that can be required of a spring; command line and library hold it to the same."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Range:
    """Allowed values, in SI: from ``low`` to ``high``; ``words`` complete a sentence about the value."""

    low: float
    high: float
    words: str
    without_low: bool = False
    without_high: bool = False

    def has(self, value: float) -> bool:
        """Whether the value is allowed; NaN is not."""
        above = value > self.low if self.without_low else value >= self.low
        return above and (value < self.high if self.without_high else value <= self.high)


LARGEST = 1.0  # m; a coil of the thickest stock wire (20 mm) and index 20 has 0.42 m. Lengths in mm pass it
FAR_BEYOND = 10_000.0  # coils, and the spring index: far beyond any coil, but finite

MOST_TURNED = math.radians(3600.0)  # ten turns: of all stock wire, 30 coils of index 20 yield by 2413 deg

_FINITE = math.nextafter(math.inf, 0.0)  # the largest number: no limit but that the value is finite
# The ranges that several requirements share; their words are the reason.
_POSITIVE = Range(0.0, _FINITE, "must be above 0", without_low=True)
_SIZE = Range(0.0, LARGEST, "must be above 0 and at most 1 m", without_low=True)
_SIZE_OR_NONE = Range(0.0, LARGEST, "must be from 0 to 1 m")
_COUNT = Range(0.0, FAR_BEYOND, "must be from 0 to 10 000")
_INDEX = Range(1.0, FAR_BEYOND, "must be from 1, a coil without a hole, to 10 000")

# Of each number, named as in ``SpringRequirements`` and ``SpringLimits``: what is above or at most is in its words.
RANGES: Mapping[str, Range] = {
    "rate": _POSITIVE,
    "travel": Range(0.0, MOST_TURNED, "must be above 0 and at most 3600 deg", without_low=True),
    "opening_travel": Range(0.0, MOST_TURNED, "must be from 0 to 3600 deg"),
    "included_angle": Range(0.0, math.tau, "must be from 0 to below 360 deg", without_high=True),
    "held_wire": _SIZE,
    "pitch": Range(1.0, 100.0, "must be from 1, touching coils, to 100"),
    "leg_lengths": _SIZE_OR_NONE,
    "wire_range": Range(0.0, math.inf, "must be 0 or more"),
    "arbor_diameter": _SIZE,
    "arbor_gap": Range(0.0, 1.0, "must be from 0 to below 1, a fraction of the inside diameter", without_high=True),
    "min_inside_diameter": _SIZE_OR_NONE,
    "max_outer_diameter": _SIZE,
    "max_body_length": _SIZE,
    "index_range": _INDEX,
    "min_coils": _COUNT,
    "max_coils": _COUNT,
    "safety": Range(1.0, _FINITE, "must be 1 or more: below, the spring would yield"),
    "cycles": Range(1.0, 1e6, "must be from 1 to 1e6: fatigue is known up to 1e6 cycles"),
    "fatigue_safety": _POSITIVE,
    "bend_radius": _SIZE,
    "min_outer_diameter": _SIZE_OR_NONE,
    "min_body_length": _SIZE_OR_NONE,
}
# The lower and the upper of two requirements.
RISING = (
    ("min_coils", "max_coils"),
    ("min_outer_diameter", "max_outer_diameter"),
    ("min_inside_diameter", "max_outer_diameter"),
    ("min_body_length", "max_body_length"),
)
