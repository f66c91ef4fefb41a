"""Autoregressions of correlated series, of which samples may be lost.

From mean products of samples so far apart, by Levinson's recursion (Brockwell & Davis, *Time Series: Theory and
Methods*, 2nd ed. 1991, section 8.2). The predictors of all orders together whiten a stationary series from its first
sample on (the same, section 5.2), so its likelihood is known for any set of samples. Lost ones are drawn given those
that are there: the least squares of the whitened series to white noise has their conditional mean and covariance.
Interpolated ones would be more correlated than the series, and smaller.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np

from synth.arrays import Array, Mask

STEADY = 0.999  # largest reflection coefficient: longer correlations than a thousand samples are not seen in a trial


@dataclass(frozen=True)
class Autoregression:
    """``predictors`` (k,) on the last k samples for k = 0 ... p, and the ``variances`` (p + 1,) that they leave."""

    predictors: tuple[Array, ...]
    variances: Array

    @classmethod
    def of(cls, lags: Array, order: int) -> Autoregression:
        """Of this order; ``lags`` (most + 1,) mean products of samples so far apart, with a positive first."""
        found = list(islice(_recursion(lags), order + 1))
        return cls(tuple(own for own, _ in found), np.array([variance for _, variance in found]))

    @property
    def coefficients(self) -> Array:
        """(p,) on the last p samples."""
        return self.predictors[-1]

    @property
    def variance(self) -> float:
        """What the last p samples leave of a sample's variance."""
        return float(self.variances[-1])

    def filled(self, values: Array, known: Mask, generator: np.random.Generator) -> Array:
        """A series (m,) whose lost samples are drawn given those ``known`` (m,)."""
        from scipy.sparse import csc_array
        from scipy.sparse.linalg import spsolve

        if known.all():
            return values
        m, p = len(values), min(len(self.coefficients), len(values) - 1)
        scale = 1.0 / np.sqrt(self.variances[np.minimum(np.arange(m), p)])
        weights = np.zeros((p + 1, m))  # by lag and row
        weights[0], weights[1:] = 1.0, -self.predictors[p][:, None]
        for order in range(p):
            weights[1:, order] = 0.0
            weights[1 : order + 1, order] = -self.predictors[order]
        weights *= scale
        lag, row = np.nonzero(np.arange(p + 1)[:, None] <= np.arange(m))
        whitening = csc_array((weights[lag, row], (row, row - lag)), shape=(m, m))
        there, lost = whitening[:, np.flatnonzero(known)], whitening[:, np.flatnonzero(~known)]
        aim = generator.normal(size=m) - there @ values[known]
        made = values.copy()
        made[~known] = np.asarray(spsolve(csc_array(lost.T @ lost), lost.T @ aim))
        return made


def best_order(lags: Array, samples: int) -> int:
    """The order of least Akaike criterion for mean products (most + 1,) over so many samples."""
    return int(np.argmin([samples * np.log(left) + 2.0 * p for p, (_, left) in enumerate(_recursion(lags))]))


def _recursion(lags: Array) -> Iterator[tuple[Array, float]]:
    """Coefficients (p,) of order 0, 1 ... and the variance that each leaves, by Levinson's recursion."""
    own, variance = np.zeros(0), float(lags[0])
    yield own, variance
    for order in range(1, len(lags)):
        reflection = float(lags[order] - own @ lags[order - 1 : 0 : -1]) / variance
        reflection = float(np.clip(reflection, -STEADY, STEADY))
        own = np.append(own - reflection * own[::-1], reflection)
        variance *= 1.0 - reflection**2
        yield own, variance


def pair_products(values: Sequence[Array], known: Sequence[Mask], most: int, least: int) -> Array:
    """(most + 1, ...) mean products of values (m, ...) so many samples apart, from pairs of which both are known.

    ``values`` are 0 where not ``known`` (m,). Tapered as sums over all samples divided by their number are, which with
    all samples known they are. Where fewer than ``least`` pairs are there, as with every second sample lost,
    interpolated between the neighbouring distances; 0 beyond the last.
    """
    total = np.zeros((most + 1, *values[0].shape[1:]))
    pairs, taper = np.zeros(most + 1), np.zeros(most + 1)
    for value, good in zip(values, known, strict=True):
        m = len(value)
        for lag in range(min(most + 1, m)):
            total[lag] += (value[lag:] * value[: m - lag]).sum(axis=0)
            pairs[lag] += np.count_nonzero(good[lag:] & good[: m - lag])
            taper[lag] += m - lag
    enough = np.flatnonzero(pairs >= min(least, pairs[0]))
    between = np.array([np.interp(np.arange(most + 1), enough, column, right=0.0) for column in np.eye(len(enough))]).T
    shape = (-1, *[1] * (total.ndim - 1))
    mean = total[enough] / np.maximum(pairs[enough], 1.0).reshape(shape)
    return np.asarray(np.tensordot(between, mean, 1) * (taper / max(taper[0], 1.0)).reshape(shape))


def nearest_possible(lags: Array) -> Array:
    """Mean products (most + 1,) with the negative part of their spectrum removed, which no series has.

    Products from pairs of which others are lost need not belong to any series.
    """
    spectrum = np.fft.rfft(np.concatenate([lags, lags[-2:0:-1]])).real
    found = np.fft.irfft(np.maximum(spectrum, 0.0), 2 * len(lags) - 2)[: len(lags)]
    return np.asarray(found * (lags[0] / found[0]))
