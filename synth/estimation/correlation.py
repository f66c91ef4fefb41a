"""How much less correlated residuals tell than independent ones."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synth.arrays import Array

ALIKE_STEP = 0.2  # of a log sample step, up to which recordings are taken together; a choice


def correlation_factors_by_step(residuals: Sequence[Array], steps: Sequence[float]) -> Array:
    """(n_recording, n) factor >= 1 by which correlation reduces the information of each recording's residuals (m, n).

    One factor for all recordings of nearly equal sample step, see ``alike_steps`` and ``correlation_factors``: noise of
    a correlation time of 20 ms counts 39 times less at 1 kHz, and 2 times less at 50 Hz. ``steps`` : s.
    """
    factors = np.ones((len(residuals), residuals[0].shape[1]))
    for alike in alike_steps(steps):
        factors[alike] = correlation_factors([residuals[t] for t in alike])
    return factors


def alike_steps(steps: Sequence[float]) -> list[list[int]]:
    """Indices of recordings of nearly equal sample steps, s, together."""
    groups: list[list[int]] = []
    for t in np.argsort(steps, kind="stable").tolist():
        if groups and np.log(steps[t] / steps[groups[-1][0]]) < ALIKE_STEP:
            groups[-1].append(t)
        else:
            groups.append([t])
    return groups


def correlation_factors(residuals: Sequence[Array]) -> Array:
    """(n,) factor >= 1 by which correlation reduces the information of residuals (m, n) of recordings of one step.

    The integrated autocorrelation time of each column, in samples, see ``integrated_time``, from lags up to half of the
    longest.
    """
    longest = max(map(len, residuals)) // 2
    summed = np.zeros((longest, residuals[0].shape[1]))
    for value in residuals:
        lags = _autocorrelation(value)[:longest]
        summed[: len(lags)] += lags
    return np.array([integrated_time(column) for column in summed.T])


def independent_errors(error: Array, most: float) -> float:
    """Number of independent errors in a series (m,), at least 1 and at most ``most``.

    ``m`` over the integrated autocorrelation time about zero: an error of constant sign counts fully.
    """
    (factor,) = correlation_factors([error[:, None]])
    return float(min(max(len(error) / factor, 1.0), most))


def integrated_time(products: Array) -> float:
    """Integrated autocorrelation time, samples, at least 1.

    ``products`` (longest,) : sums of products of values so many samples apart, from 0 on, not normalised.

    1 + 2 sum rho_k, with Geyer's initial monotone sequence (Statistical Science 7 (1992) 473, section 3.3): the sums
    rho_0 + rho_1, rho_2 + rho_3, ... of a reversible chain are positive and fall, so they count until the first that is
    not positive, each at most as much as the one before. A model error that oscillates with a leg gives tens.

    The scatter of the pairs and the bound of 1 make the result too large: of white noise it is 1.34, 1.17 and 1.07 in
    the mean over 4000 series of 50, 200 and 1000 samples (median 1.15, 1.09, 1.04).
    """
    if not len(products) or products[0] <= 0.0:
        return 1.0
    rho = products / products[0]
    pairs = rho[: len(rho) // 2 * 2].reshape(-1, 2).sum(axis=1)
    ends = pairs <= 0.0
    stop = int(np.argmax(ends)) if ends.any() else len(pairs)
    return max(1.0, 2.0 * float(np.minimum.accumulate(pairs[:stop]).sum()) - 1.0)


def _autocorrelation(value: Array) -> Array:
    """(m, n) sums of products of (m, n) values that are so many samples apart."""
    m = len(value)
    size = 1 << (2 * m - 1).bit_length()
    transformed = np.fft.rfft(np.ascontiguousarray(value.T), size)
    power = transformed.real**2 + transformed.imag**2
    return np.asarray(np.fft.irfft(power, size)[:, :m].T)
