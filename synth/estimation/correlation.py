"""How much less correlated residuals tell than independent ones."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synth.arrays import Array


def correlation_factors(residuals: Sequence[Array]) -> Array:
    """(n,) factor >= 1 by which correlation reduces the information of residuals (m, n) of several recordings.

    1 + 2 sum of autocorrelations, summed while pairs of neighbouring lags stay positive (Geyer, Statistical Science 7,
    1992, initial positive sequence). White noise gives 1; a model error that oscillates with a leg gives tens.
    """
    longest = max(map(len, residuals)) // 2
    summed = np.zeros((longest, residuals[0].shape[1]))
    for value in residuals:
        lags = _autocorrelation(value)[:longest]
        summed[: len(lags)] += lags
    return np.array([_factor(column) for column in summed.T])


def _autocorrelation(value: Array) -> Array:
    """(m, n) sums of products of (m, n) values that are so many samples apart."""
    m = len(value)
    size = 1 << (2 * m - 1).bit_length()
    transformed = np.fft.rfft(np.ascontiguousarray(value.T), size)
    power = transformed.real**2 + transformed.imag**2
    return np.asarray(np.fft.irfft(power, size)[:, :m].T)


def _factor(summed: Array) -> float:
    """The factor from one column's autocorrelation (longest,), not normalised."""
    if summed[0] <= 0.0:
        return 1.0
    rho = summed / summed[0]
    pairs = rho[1:-1:2] + rho[2::2]
    ends = pairs <= 0
    stop = int(np.argmax(ends)) if ends.any() else len(pairs)
    return max(1.0, 1.0 + 2.0 * float(pairs[:stop].sum()))
