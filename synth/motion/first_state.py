"""Angle and rate at the start of a recording from its first samples, with their uncertainty.

A local polynomial through noisy samples of a curved motion has noise and bias. The noise follows from the polynomial's
weights; the bias is estimated from the disagreement of polynomials of other degrees and widths (the idea of Lepski's
rule, Theory Probab. Appl. 35 (1990) 454).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from synth.arrays import Array, Mask
from synth.sampling import channel_step

WIDTH = 0.03  # s, support of the narrowest polynomial, as of ``smooth``
LEAST_SAMPLES = 5  # samples of a polynomial: a cubic and one degree of freedom
OTHER_POLYNOMIALS = ((2, 1.0), (2, 1.5), (3, 1.5))  # degree and relative support of the polynomials beside the cubic
NOISE_FACTOR = 3.0  # standard deviations: the samples are also used in the fit, and must hardly count twice


@dataclass(frozen=True)
class FirstState:
    """``angle`` and ``rate`` (n,) rad and rad/s at the first sample, with deviations that include noise and bias."""

    angle: Array
    rate: Array
    angle_deviation: Array
    rate_deviation: Array


def first_state(time: Array, angle: Array, counts: Mask, scatter: Array, *, unit: float = 1.0) -> FirstState:
    """The state at ``time[0]``.

    Parameters
    ----------
    time : (m,) s; angle : (m, n) rad; counts : (m, n) True where a sample may be used.
    scatter : (n,) rad of one sample; at least that of the encoder's counts.
    unit : s, of the polynomials' support, see ``time_step``.
    """
    n = angle.shape[1]
    found = np.zeros((4, n))
    for j in range(n):
        good = np.flatnonzero(counts[:, j])
        if len(good) < LEAST_SAMPLES:
            found[2:, j] = np.inf
            continue
        fewest = max(LEAST_SAMPLES, round(WIDTH * unit / channel_step(time, counts[:, j])) // 2 * 2 + 1)
        good = good[: 2 * fewest]
        since, value = time[good] - time[0], angle[good, j]
        weights = _weights(since[:fewest].tobytes(), 3)
        middle = weights @ value[:fewest]
        noise = NOISE_FACTOR * scatter[j] * np.sqrt((weights**2).sum(axis=1))
        bias = np.zeros(2)
        for degree, share in OTHER_POLYNOMIALS:
            points = round(share * fewest)
            bias = np.maximum(bias, np.abs(_weights(since[:points].tobytes(), degree) @ value[:points] - middle))
        # The first good sample may come late: beyond the samples a cubic's error grows as the fourth power.
        beyond = float((since[fewest - 1 : fewest] / (since[fewest - 1 : fewest] - since[0])).max(initial=1.0)) ** 4
        found[:, j] = *middle, *np.hypot(noise, beyond * bias)
    return FirstState(*found)


@lru_cache(maxsize=256)  # joints and recordings with the same clock share them
def _weights(times: bytes, degree: int) -> Array:
    """(2, points): weights of samples at ``times``, (points,) s as bytes, that give value and slope at time zero."""
    since = np.frombuffer(times)
    scale = float(since[-1]) or 1.0
    inverse = np.linalg.pinv(np.vander(since / scale, degree + 1, increasing=True))
    return np.asarray(np.stack([inverse[0], inverse[1] / scale]))
