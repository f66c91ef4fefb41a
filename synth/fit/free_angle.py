"""One free angle for all trials, or one per trial about a common one, decided from the data.

An animal's rest angle drifts from trial to trial (fatigue, preload); a spring's does not. Shifts per trial are random
effects about the common angle; their spread is estimated by DerSimonian and Laird (Controlled Clinical Trials 7, 1986),
and Cochran's Q (Biometrics 10, 1954) tests whether it is zero.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.estimation.chi_squared import chi_squared_above

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
        usable = shrink > 0.05  # a trial that the prior determines to 95 % tells nothing
        value = shift[known, j][usable] / shrink[usable]
        weight = shrink[usable] / variance[known, j][usable]
        m = len(value)
        if m < 2:
            continue
        mean = float(np.sum(weight * value) / weight.sum())
        q = float(np.sum(weight * (value - mean) ** 2))
        spread[j] = np.sqrt(max(0.0, (q - (m - 1)) / float(weight.sum() - np.sum(weight**2) / weight.sum())))
        probability[j] = chi_squared_above(m - 1, q)
    return Heterogeneity(spread, probability)
