"""The zero of a force plate, from the flight of a jump: nothing stands on the plate then.

Charge amplifiers drift and load cells are not tared. What the plate then shows in all samples is no force of the leg:
a tenth of its weight, over a push of 55 ms, makes the rise 8 % too large. The flight shows it alone, next to the push;
a rest before it shows the weight too, which the design's masses only estimate.

The flight is the stretch of ``QUIET`` with the lowest mean in which the force is level, with all that is level beside
it, if that is nearer to zero than to the weight.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array
from synth.files.hopper_recordings import HopperRecording
from synth.noise import white_noise

QUIET = 0.02  # s, least time that a foot in the air leaves the plate quiet
WHITE, RINGING = 5.0, 0.05  # deviations of the noise, share of the weight: beyond, something moves on the plate
LARGEST_ZERO = 0.5  # of the weight: a plate on which the leg stands shows more
SURE = 3.0  # deviations of the level's own noise, beyond which it is no zero of 0
# Parts of a flight, whose medians differ where the plate drifts, or where the foot hardly leaves it: a weak jump that
# lifted by 1.9 mm showed 24 mN, with a white error of 3 mN.
PARTS = 4
MEDIAN = (np.pi / 2.0) ** 0.5  # standard error of a median over that of a mean, of normal noise


@dataclass(frozen=True)
class PlateZero:
    """``value`` N that the plate shows without a load, 0 where none is seen; its standard ``deviation`` N."""

    value: float = 0.0
    deviation: float = 0.0

    def sentence(self, name: str) -> str:
        """What is subtracted, for the user; empty where nothing is."""
        if self.value == 0.0:
            return ""
        return (
            f"{name}: the plate shows {self.value:.3g} N in the flight, when nothing stands on it: this is its zero, "
            "and is subtracted"
        )


def quiet_band(force: Array, weight: float) -> float:
    """Largest distance of a sample (of force (n,) N) from the plate's level while nothing moves on it, N.

    That of its noise, or of the plate's own ringing.
    """
    return max(WHITE * white_noise(force, 1), RINGING * weight)


def without_plate_zero(jump: HopperRecording, weight: float) -> tuple[HopperRecording, PlateZero]:
    """The recording with its force counted from the plate's zero, and that zero; unchanged where it shows none.

    Parameters
    ----------
    jump : with ``time``, and where recorded ``ground force``.
    weight : N, of the leg.
    """
    if "ground force" not in jump.columns:
        return jump, PlateZero()
    zero = _zero(jump["time"], jump["ground force"], weight)
    if zero.value == 0.0:
        return jump, zero
    return replace(jump, columns={**jump.columns, "ground force": jump["ground force"] - zero.value}), zero


def _zero(time: Array, force: Array, weight: float) -> PlateZero:
    """The level of the flight; 0 if none is seen, or if it does not differ from 0 by more than its noise."""
    size = max(PARTS, int(np.ceil(QUIET / float(np.median(np.diff(time))))))
    if len(force) <= size:
        return PlateZero()
    windows = np.lib.stride_tricks.sliding_window_view(force, size)
    means, band = windows.mean(axis=1), quiet_band(force, weight)
    level = np.abs(windows - means[:, None]).max(axis=1) < band
    if not level.any():
        return PlateZero()
    lowest = int(np.argmin(np.where(level, means, np.inf)))
    away = np.abs(force - means[lowest]) >= band
    before, after = np.flatnonzero(away[:lowest]), np.flatnonzero(away[lowest + size :])
    first = int(before[-1]) + 1 if len(before) else 0
    last = lowest + size + (int(after[0]) if len(after) else len(force))
    flight = force[first:last]
    value = float(np.median(flight))
    of_parts = float(np.std([np.median(part) for part in np.array_split(flight, PARTS)], ddof=1))
    deviation = max(MEDIAN * white_noise(force, 1) / np.sqrt(len(flight)), of_parts / np.sqrt(PARTS))
    if abs(value) >= LARGEST_ZERO * weight:
        return PlateZero()
    return PlateZero(value if abs(value) > SURE * deviation else 0.0, float(deviation))
