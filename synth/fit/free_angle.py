"""One free angle for all trials, or one per trial about a common one, decided from the data.

An animal's rest angle drifts from trial to trial (fatigue, preload); a spring's does not. Shifts per trial are random
effects about the common angle; their spread is estimated by DerSimonian and Laird (Controlled Clinical Trials 7, 1986),
and
Cochran's Q (Biometrics 10, 1954) tests whether it is zero.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array

WIDE = np.radians(10.0)  # spread with which shifts are first estimated: almost free
LEAST_SPREAD = np.radians(0.01)  # rad, far below the accuracy of springs and encoders
SIGNIFICANCE = 0.01  # of Cochran's Q, over all joints together


@dataclass(frozen=True)
class Heterogeneity:
    """Spread (n,) rad of the free angle over trials, and the probability (n,) of such shifts without any spread."""

    spread: Array
    probability: Array


def heterogeneity(shift: Array, variance: Array) -> Heterogeneity:
    """From shifts (n_trial, n) rad and their variances (n_trial, n); nan if a trial does not determine a joint's."""
    n = shift.shape[1]
    spread, probability = np.zeros(n), np.ones(n)
    for j in range(n):
        known = np.isfinite(variance[:, j])
        # The shrinkage towards zero by the wide prior is undone, so that estimate and variance match.
        shrink = 1.0 - variance[known, j] / WIDE**2
        usable = shrink > 0.05
        value = shift[known, j][usable] / shrink[usable]
        weight = shrink[usable] / variance[known, j][usable]
        m = len(value)
        if m < 2:
            continue
        mean = float(np.sum(weight * value) / weight.sum())
        q = float(np.sum(weight * (value - mean) ** 2))
        spread[j] = np.sqrt(max(0.0, (q - (m - 1)) / float(weight.sum() - np.sum(weight**2) / weight.sum())))
        probability[j] = chi_squared_tail(q, m - 1)
    return Heterogeneity(spread, probability)


def chi_squared_tail(value: float, degrees: int) -> float:
    """P(chi-squared with ``degrees`` > value), the closed form (Abramowitz & Stegun, 26.4.4 and 26.4.5).

    Implemented here because importing scipy's takes a third of a second.
    """
    half = 0.5 * value
    if half <= 0.0:
        return 1.0
    tail, order = (math.erfc(math.sqrt(half)), 0.5) if degrees % 2 else (math.exp(-half), 1.0)
    while order < 0.5 * degrees:
        tail += math.exp(order * math.log(half) - half - math.lgamma(order + 1.0))
        order += 1.0
    return min(tail, 1.0)


def chi_squared_quantile(probability: float, degrees: int) -> float:
    """The quantile of chi-squared with ``degrees`` at this probability, by bisection to rounding accuracy."""
    low, high = 0.0, float(degrees) + 10.0
    while chi_squared_tail(high, degrees) > 1.0 - probability:
        low, high = high, 2.0 * high
    while True:
        middle = 0.5 * (low + high)
        if not low < middle < high:
            return middle
        low, high = (middle, high) if chi_squared_tail(middle, degrees) > 1.0 - probability else (low, middle)
