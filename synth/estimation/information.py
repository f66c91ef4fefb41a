"""Expected information of a further trial about which of the remaining explanations is true.

A lower bound by pairwise distances of Gaussians (Kolchinsky & Tracey, Entropy 19 (2017) 361), with Bhattacharyya's
distance.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from synth.arrays import Array

RIVALS = 4  # explanations that a trial should distinguish
LEAST_WEIGHT = 0.02  # least weight of a rival explanation
F = TypeVar("F")


def rivals_of(explanations: Sequence[tuple[F, float]], most: int = RIVALS) -> tuple[list[F], Array]:
    """The ``most`` explanations with the largest weights, and their weights (n,), which sum to 1."""
    kept = sorted(explanations, key=lambda item: -item[1])[:most]
    weights = np.array([weight for _, weight in kept])
    weights = np.maximum(weights / weights.sum(), LEAST_WEIGHT)
    return [fit for fit, _ in kept], weights / weights.sum()


def expected_information(weights: Array, distance: Callable[[int, int, int], float]) -> float:
    """Expected information of a trial on which rival is true, in bits.

    ``distance(a, b, at)`` : squared Mahalanobis distance of the predictions of two rivals, uncertain as that of rival
    ``at``, one of the two.
    """
    overlap = np.eye(len(weights))
    for a in range(len(weights)):
        for b in range(a):
            mean = 0.5 * (distance(a, b, a) + distance(a, b, b))
            overlap[a, b] = overlap[b, a] = np.exp(-mean / 8.0)
    there = weights > 0.0
    return float(-np.sum(weights[there] * np.log2((overlap @ weights)[there]))) + 0.0  # no -0


def of_unknown_size(squares: float, independent: float) -> float:
    """A squared distance as errors of unknown size count: ``n log(1 + squares / n)`` with ``n`` independent errors."""
    if math.isinf(independent):
        return squares
    return independent * math.log1p(squares / independent)


@dataclass(frozen=True)
class TrialForecast:
    """A hypothesis' prediction of a trial that was not made, whitened by the trial's noise.

    ``mean`` (M,). ``spread`` (M, k) : root of the covariance that is not noise, what earlier trials leave open.
    ``free`` (M, l) : derivatives by what may take any value in that trial, as a release's initial state.
    """

    mean: Array
    spread: Array
    free: Array

    def distance(self, other: TrialForecast, at: TrialForecast, remainder: float = 1.0) -> float:
        """Squared Mahalanobis distance of the means, with the covariance of ``at``, one of the two.

        ``remainder`` : RMS of what no model of the trial predicts, noise included, over the noise.
        """
        q, _ = np.linalg.qr(at.free)
        apart = (self.mean - other.mean) / remainder
        apart = apart - q @ (q.T @ apart)
        spread = (at.spread - q @ (q.T @ at.spread)) / remainder
        # Woodbury: (1 + S S')^-1 = 1 - S (1 + S'S)^-1 S'
        inner = np.eye(spread.shape[1]) + spread.T @ spread
        along = spread.T @ apart
        return max(float(apart @ apart) - float(along @ np.linalg.solve(inner, along)), 0.0)
