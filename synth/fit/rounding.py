"""Readings of an encoder with counts coarser than its noise: each only bounds the angle between two edges.

Rounding to counts of width D adds D^2/12 to the variance and looks like white noise while the noise s itself shakes the
reading over several counts (Sheppard; Widrow & Kollar, *Quantization Noise*, 2008, chapter 4: the error falls as
exp(-2 pi^2 s^2/D^2)). Below s = 0.6 D it does not: a limb at rest always reads the same count, up to half a count off
the true angle, and a fit that takes this for a thousand good samples is wrong by many of its standard deviations. Here
the likelihood of a count is that of its cell, P = Phi((y + D/2 - p)/s) - Phi((y - D/2 - p)/s) for a prediction p
(rounded data: Heitjan, Statistical Science 4 (1989) 164). Minus its logarithm is convex in p; slope and curvature are
those of the truncated normal. Beyond ``HUBER`` the slope is constant, as for all other residuals.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from synth.arrays import Array
from synth.fit.recordings import Recording
from synth.motion.counts import COARSE_NOISE, on_counts, width_of

FINEST = 0.05  # noise over count that can be distinguished from zero
FARTHEST = 3.0  # counts from the prediction; beyond it the error is not due to rounding
CELLS = 600  # steps of the table over distance
LEAST_COUNT = 1e-6  # rad; smaller counts are the rounding of a text file


@dataclass(frozen=True, eq=False)
class Rounding:
    """One joint's readings as counts.

    ``noise`` rad before rounding; ``count`` rad. The table gives cost, slope and curvature over the distance from
    prediction to reading in ``noise``.
    """

    noise: float
    count: float

    def terms(self, off: Array, huber: float) -> tuple[Array, Array, Array]:
        """Cost, slope and curvature per sample, of ``off`` = prediction minus reading (m,) rad, in ``noise`` units."""
        distance, cost, slope, curvature = _table(round(self.count / self.noise, 6), huber)
        size = np.abs(off) / self.noise
        beyond = np.maximum(size - distance[-1], 0.0)
        found = np.interp(size, distance, cost) + huber * beyond
        inside = np.interp(size, distance, curvature)
        # As for Huber's function elsewhere: beyond the knee the curvature of the parabola that touches there.
        weight = np.where(beyond > 0.0, huber / np.maximum(size, huber), inside)
        return found, np.sign(off) * np.interp(size, distance, slope), weight

    def surprise(self, off: Array, huber: float) -> Array:
        """(m,) rad, the slope expressed as a residual: white if the model is right, for any counts."""
        distance, _, slope, _ = _table(round(self.count / self.noise, 6), huber)
        return np.asarray(np.sign(off) * np.interp(np.abs(off) / self.noise, distance, slope) * self.noise)


@lru_cache(maxsize=64)
def _table(ratio: float, huber: float) -> tuple[Array, Array, Array, Array]:
    """Distance in ``noise``, minus log of the cell's probability, its slope and curvature; ``ratio`` = count/noise."""
    distance = np.linspace(0.0, ratio / 2 + huber + 2.0, 4 * CELLS)
    probability, slope, curvature = np.array([_cell(u, ratio) for u in distance]).T
    stop = int(np.searchsorted(slope, huber)) + 1
    cost = -np.log(probability[:stop]) + math.log(probability[0])
    return distance[:stop], cost, np.minimum(slope[:stop], huber), np.maximum(curvature[:stop], 0.0)


def _probability(distance: float, ratio: float) -> float:
    """Probability of the cell of width ``ratio`` about a reading; all in ``noise``."""
    return 0.5 * (math.erfc((distance - ratio / 2) / math.sqrt(2)) - math.erfc((distance + ratio / 2) / math.sqrt(2)))


def _cell(distance: float, ratio: float) -> tuple[float, float, float]:
    """Probability of the cell of width ``ratio`` about a reading, and slope and curvature of minus its logarithm."""
    low, high = distance - ratio / 2, distance + ratio / 2  # mirrored: both tails are on the side of erfc
    probability = _probability(distance, ratio)
    density = [math.exp(-0.5 * x * x) / math.sqrt(2 * math.pi) for x in (low, high)]
    slope = (density[0] - density[1]) / probability
    return probability, slope, slope**2 - (low * density[0] - high * density[1]) / probability


def encoder_counts(recordings: Sequence[Recording]) -> Array:
    """(n,) rad, the width of each joint's counts from its readings; 0 if there are none."""
    n = recordings[0].rotation.shape[1]
    found = np.zeros(n)
    for j in range(n):
        parts = [r.levels[j] for r in recordings if len(r.levels[j])]
        gaps = np.concatenate([np.diff(part) for part in parts]) if parts else np.empty(0)
        width = width_of(gaps, LEAST_COUNT)
        if width == 0.0:
            continue
        found[j] = width if on_counts(np.concatenate(parts), width) else 0.0
    return found


def rounding_of(off: Array, count: float) -> Rounding | None:
    """The most likely noise before rounding for distances ``off`` (m,) rad; None if rounding acts like noise."""
    off = off[np.isfinite(off)]
    if count <= 0.0 or len(off) < 12 or np.mean(np.abs(off) > FARTHEST * count) > 0.02:
        return None
    edges = np.linspace(0.0, FARTHEST, CELLS + 1)
    held, _ = np.histogram(np.abs(off) / count, edges)
    middle = 0.5 * (edges[1:] + edges[:-1])[held > 0]
    held = held[held > 0]
    shares = np.exp(np.linspace(math.log(FINEST), math.log(1.1 * COARSE_NOISE), 36))
    costs = []
    for share in shares:
        cells = np.array([_probability(u, 1.0 / share) for u in middle / share])
        costs.append(-float(held @ np.log(np.maximum(cells, 1e-9))))
    best = int(np.argmin(costs))
    if shares[best] >= COARSE_NOISE:
        return None
    return Rounding(float(shares[best]) * count, count)
