"""Sampling uncertainty of a share, a median, a percentile, a calibration error; all 90 % intervals."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

NORMAL90 = 1.6448536269514722
DRAWS = 2000
BINS = 10
Array = NDArray[np.float64]


def wilson(right: int, count: int) -> tuple[float, float]:
    """Interval of a share (Wilson, J. Am. Stat. Assoc. 22 (1927) 209); the whole range without any count."""
    if count == 0:
        return 0.0, 1.0
    share, z2 = right / count, NORMAL90**2
    middle = (share + z2 / (2 * count)) / (1 + z2 / count)
    half = NORMAL90 / (1 + z2 / count) * float(np.sqrt(share * (1 - share) / count + z2 / (4 * count**2)))
    return max(middle - half, 0.0), min(middle + half, 1.0)


def bootstrap(rows: Array, statistic: Callable[[Array], float], seed: int = 0) -> tuple[float, float]:
    """Percentile interval of a statistic of rows (n, ...) resampled with replacement (Efron, 1979)."""
    rng = np.random.default_rng(seed)
    drawn = [statistic(rows[rng.integers(0, len(rows), len(rows))]) for _ in range(DRAWS)]
    return float(np.percentile(drawn, 5)), float(np.percentile(drawn, 95))


def calibration_error(rows: Array) -> float:
    """Expected calibration error of (probability, right) rows: bins of one tenth, each weighted by its cases.

    Naeini, Cooper & Hauskrecht, AAAI 2015.
    """
    return float(sum(count * abs(said - was) for _, count, said, was in reliability(rows)) / max(len(rows), 1))


def reliability(rows: Array) -> list[tuple[float, int, float, float]]:
    """For each bin with cases: its lower edge, number of cases, mean stated probability, share of right ones."""
    index = np.minimum((rows[:, 0] * BINS).astype(int), BINS - 1)
    found = []
    for k in range(BINS):
        part = rows[index == k]
        if len(part):
            found.append((k / BINS, len(part), float(part[:, 0].mean()), float(part[:, 1].mean())))
    return found


def calibrated_by_chance(probabilities: Sequence[float], seed: int = 0) -> float:
    """Calibration error that exactly right probabilities would show on so few cases."""
    rng, said = np.random.default_rng(seed), np.asarray(probabilities, dtype=float)
    drawn = [calibration_error(np.stack([said, rng.random(len(said)) < said], axis=1)) for _ in range(400)]
    return float(np.mean(drawn))
