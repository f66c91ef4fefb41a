"""One free angle for all trials, or one per trial about a common one, decided from the data.

An animal's rest angle drifts from trial to trial (fatigue, preload); a spring's does not. Shifts per trial are random
effects about the common angle; their spread is estimated by DerSimonian and Laird (Controlled Clinical Trials 7, 1986),
and Cochran's Q (Biometrics 10, 1954) tests whether it is zero. The spread's interval holds all values with which Q
about the mean is as likely as its own chi-squared distribution allows (Viechtbauer, Statistics in Medicine 26, 2007).

A spread that is estimated from a few trials may be far too small. The mean's interval is Hartung and Knapp's
(Statistics in Medicine 20, 2001): the variance that the shifts themselves show, and Student's t of one degree less than
trials. The normal quantile holds 76 % with three trials, and 65 % with two. So is that of another shift, which no trial
shows (Higgins, Thompson and Spiegelhalter, Journal of the Royal Statistical Society A 172, 2009).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from synth.arrays import Array, Mask
from synth.estimation.chi_squared import chi_squared_above, chi_squared_exceeded
from synth.estimation.intervals import NORMAL90, student95

WIDE = np.radians(10.0)  # spread with which shifts are first estimated: almost free
LEAST_SPREAD = np.radians(0.01)  # rad, far below the accuracy of springs and encoders
SIGNIFICANCE = 0.01  # of Cochran's Q, over all joints together
TAIL = 0.05  # probability beyond each end of the spread's 90 % interval
HALVINGS = 60  # of an interval that holds such an end


@dataclass(frozen=True)
class Heterogeneity:
    """Spread (n,) rad of the free angle over trials, and the probability (n,) of such shifts without any spread.

    ``shifts`` (m,) rad and their inverse variances (m,), of each joint, from which both are.
    """

    spread: Array
    probability: Array
    shifts: tuple[tuple[Array, Array], ...]

    @cached_property
    def excess(self) -> Array:
        """(n,) rad^2 by which the mean free angle is less known than with that spread exactly; 0 for common ones.

        Not below 0: shifts that agree by chance are no reason for less than the trials' own errors.
        """
        found = np.zeros(len(self.shifts))
        for j, (value, weight) in enumerate(self.shifts):
            if len(value) > 1:
                spread = float(self.spread[j])
                known = 1.0 / np.sum(1.0 / (1.0 / weight + spread**2))
                found[j] = max(0.0, _variance_of_mean(value, weight, spread) - known)
        return found

    @cached_property
    def of_another(self) -> Array:
        """(n,) rad, see ``spread_of_another``."""
        return spread_of_another(self.spread, [len(value) for value, _ in self.shifts])

    @cached_property
    def ends(self) -> Array:
        """(2, n) rad of the spread's 90 % interval; nan for a joint with fewer than two shifts."""
        found = np.full((2, len(self.shifts)), np.nan)
        for j, (value, weight) in enumerate(self.shifts):
            if len(value) > 1:
                wanted = [chi_squared_exceeded(len(value) - 1, tail) for tail in (TAIL, 1.0 - TAIL)]
                found[:, j] = [_spread_at(value, weight, each) for each in wanted]
        return found


def heterogeneity(shift: Array, variance: Array) -> Heterogeneity:
    """From shifts (n_trial, n) rad and their variances (n_trial, n); nan if a trial does not determine a joint's."""
    n = shift.shape[1]
    spread, probability, shifts = np.zeros(n), np.ones(n), []
    for j in range(n):
        known = np.isfinite(variance[:, j])
        # The shrinkage towards zero by the wide prior is undone, so that estimate and variance match.
        shrink = 1.0 - variance[known, j] / WIDE**2
        usable = shrink > 0.05  # a trial that the prior determines to 95 % tells nothing
        value = shift[known, j][usable] / shrink[usable]
        weight = shrink[usable] / variance[known, j][usable]
        shifts.append((value, weight))
        m = len(value)
        if m < 2:
            continue
        mean = float(np.sum(weight * value) / weight.sum())
        q = float(np.sum(weight * (value - mean) ** 2))
        spread[j] = np.sqrt(max(0.0, (q - (m - 1)) / float(weight.sum() - np.sum(weight**2) / weight.sum())))
        probability[j] = chi_squared_above(m - 1, q)
    return Heterogeneity(spread, probability, tuple(shifts))


def shifts_seen(probability: Array) -> Mask:
    """(n,) whose free angle shifts: shifts of so little ``probability`` (n,) are not of noise, over all joints."""
    return np.asarray(probability < SIGNIFICANCE / len(probability))


def spread_of_another(spread: Array, counts: Sequence[int]) -> Array:
    """(n,) rad, of a normal distribution whose 90 % interval is that of another shift than those of the trials.

    ``spread`` (n,) rad as estimated from the shifts of so many trials; one below ``LEAST_SPREAD`` is none.
    """
    factors = [student95(count - 1) / NORMAL90 if count > 1 else 0.0 for count in counts]
    return np.where(spread > LEAST_SPREAD, spread * factors, 0.0)


def excess_of_common(stated: Array, true: Array) -> Array:
    """(n,) rad^2 by which a common free angle is less known than by the ``stated`` variances of shifts.

    ``stated`` and ``true`` (n_trial, n) rad^2, nan where a trial does not determine a joint's.
    """
    weights = [np.nansum(1.0 / each, axis=0) for each in (true, stated)]
    apart = [np.where(each > 0.0, 1.0 / np.where(each > 0.0, each, 1.0), 0.0) for each in weights]
    return np.asarray(apart[0] - apart[1])


def excess_of_fixed(shift: Array, free: Mask) -> Array:
    """As ``Heterogeneity.excess``, (n,) rad^2, where each trial's shift is fixed and so in no variance yet.

    ``shift`` (n_trial, n) rad; ``free`` (n_trial, n), False for a joint that is locked in a trial.
    """
    found = np.zeros(shift.shape[1])
    for j in range(shift.shape[1]):
        value = shift[free[:, j], j]
        if len(value) > 1:
            found[j] = _variance_of_mean(value, np.full(len(value), np.inf), WIDE)
    return found


def _variance_of_mean(value: Array, weight: Array, spread: float) -> float:
    """rad^2, of a normal distribution whose 90 % interval is that of the mean of shifts (m,) by Hartung and Knapp."""
    freedom = len(value) - 1
    scale = _cochran(value, weight, spread) / freedom
    known = 1.0 / np.sum(1.0 / (1.0 / weight + spread**2))
    return float((student95(freedom) / NORMAL90) ** 2 * scale * known)


def _cochran(value: Array, weight: Array, spread: float) -> float:
    """Q of shifts (m,) rad with inverse variances (m,) that have this spread, rad, about their mean."""
    inverse = 1.0 / (1.0 / weight + spread**2)
    mean = float(np.sum(inverse * value) / inverse.sum())
    return float(np.sum(inverse * (value - mean) ** 2))


def _spread_at(value: Array, weight: Array, wanted: float) -> float:
    """The spread, rad, for which Q is ``wanted``; 0 if it is less without any."""
    if _cochran(value, weight, 0.0) <= wanted:
        return 0.0
    low, high = 0.0, LEAST_SPREAD
    while _cochran(value, weight, high) > wanted:
        low, high = high, 2.0 * high
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _cochran(value, weight, middle) > wanted else (low, middle)
    return float(high)
