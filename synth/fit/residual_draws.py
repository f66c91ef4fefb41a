"""Resampled residuals: as correlated as the noise that the fit met, of which it has absorbed a part.

Residuals of neighbouring samples are correlated (a model error oscillates with the leg, a tracked point wanders). They
are whitened by an autoregression of each joint, blocks of the white ones are drawn and coloured again
("post-blackening": Davison & Hinkley, *Bootstrap Methods and their Application*, 1997, section 8.2.3; circular blocks:
Politis & Romano, in *Exploring the Limits of Bootstrap*, 1992). Blocks of the residuals themselves would have to be
several correlation times long and yet short beside the trial; and as blocks of a trial have its mean, a free angle,
which is little else than the mean of all trials, would hardly vary.

The residuals of a fit are less correlated than the noise, because it follows the noise's slow part. So the
autoregression is chosen such that what a (linear) refit leaves of the draws is as correlated as the fit's residuals.

Measured: one joint, three trials, exact links, noise of 0.3 deg of the first order, 100 data sets each. The 90 %
interval of the free angle holds the truth in 80 % (120 samples a trial, correlation 0.9 from one to the next), 86 %
(0.7), 87 % (white) and 90 % (300 samples, 0.9); with blocks of the residuals themselves 62, 75, 84 and 78 %. Six
independent samples a trial tell too little of how far they are correlated.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array
from synth.estimation.correlation import correlation_factors
from synth.motion.noise import MAD_TO_SD

ORDER = 60  # most coefficients of an autoregression; what is left of the correlation is in the blocks
ROUNDS = 3  # corrections of the autocorrelation, a choice: each leaves about the share that the fit absorbs of the last
ALIKE = 0.2  # of a log sample step, between recordings whose residuals are put together
STEADY = 0.999  # largest reflection coefficient: longer correlations than a thousand samples are not seen in a trial
CHECKED = 100  # draws from which the correlation after a refit is known, to some 3 % for two dozen independent samples
LEAST, ENOUGH = 10, 10_000_000  # fewer such draws of long trials, which tell as much: so many samples in all
CUT = 6.0  # robust standard deviations at which residuals are truncated for the autocorrelation, as in ``clipped_rms``

Places = NDArray[np.intp]
LeftOver = Callable[[Sequence[Array]], list[Array]]  # draws (m, n, c) rad of each trial -> what a refit leaves of them


@dataclass(frozen=True)
class Draw:
    """White residuals (m, n) rad of one trial, the coefficients (p, n) that colour them, and each draw's blocks.

    ``length`` samples of the trial; ``starts`` (n_block, n_draw) of blocks of ``block`` samples.
    """

    white: Array
    colour: Array
    block: int
    length: int
    starts: Places

    def of(self, which: Places) -> Array:
        """(length, n, c) rad, the residuals of these draws."""
        from scipy.signal import lfilter

        every = 2 * self.length  # as much before the trial: a correlation that outlasts it is not seen in it
        places = self.starts[:, None, which] + np.arange(self.block)[None, :, None]
        white = self.white[places.reshape(-1, len(which))[:every] % len(self.white)]
        made = np.empty((self.length, self.white.shape[1], len(which)))
        for j in range(made.shape[1]):
            poles = np.concatenate([[1.0], -self.colour[:, j]])
            made[:, j] = lfilter([1.0], poles, white[:, :, j], axis=0)[self.length :]
        return made


def resampled(
    generator: np.random.Generator,
    residuals: Sequence[Array],
    steps: Sequence[float],
    noise: Array,
    left_over: LeftOver,
    draws: int,
) -> list[Draw]:
    """Draws of every trial's residuals.

    Parameters
    ----------
    residuals : (m, n) rad of each trial, nan where no sample counts.
    steps : s, usual sample step of each trial.
    noise : (n_trial, n) rad, the fit's divisors of the residuals.
    """
    pools = _alike(steps)
    counted = [np.isfinite(left) for left in residuals]
    scaled = [np.where(good, left / own, 0.0) for left, good, own in zip(residuals, counted, noise, strict=True)]
    seen = [_lags([scaled[t] for t in pool], [counted[t] for t in pool], _most(residuals, pool)) for pool in pools]
    orders = [[_order(each[:, j], sum(len(residuals[t]) for t in pool)) for j in range(each.shape[1])]
              for pool, each in zip(pools, seen, strict=True)]  # fmt: skip
    lags = [each.copy() for each in seen]
    found: list[Draw] = []
    for turn in range(ROUNDS + 1):
        made: dict[int, Draw] = {}
        for pool, each, most in zip(pools, lags, orders, strict=True):
            made |= _draws(generator, [residuals[t] for t in pool], noise[pool], each, most, pool, draws)
        found = [made[t] for t in range(len(residuals))]
        if turn == ROUNDS:
            break
        some = np.arange(min(draws, CHECKED, max(LEAST, ENOUGH // sum(left.size for left in residuals))))
        left = left_over([draw.of(some) for draw in found])
        for pool, each, wanted in zip(pools, lags, seen, strict=True):
            own = [np.where(counted[t][:, :, None], left[t] / noise[t][:, None], 0.0) for t in pool]
            each += wanted - _lags(own, [counted[t] for t in pool], len(each) - 1).mean(axis=2)
    return found


def _alike(steps: Sequence[float]) -> list[list[int]]:
    """Trials of nearly equal sample steps, together."""
    pools: list[list[int]] = []
    for t in np.argsort(steps).tolist():
        if pools and np.log(steps[t] / steps[pools[-1][0]]) < ALIKE:
            pools[-1].append(t)
        else:
            pools.append([t])
    return pools


def _most(residuals: Sequence[Array], pool: Sequence[int]) -> int:
    """The most coefficients: a quarter of the shortest trial."""
    return min(ORDER, min(len(residuals[t]) for t in pool) // 4)


def _lags(values: Sequence[Array], counted: Sequence[NDArray[np.bool_]], most: int) -> Array:
    """(most + 1, n, ...) mean products of values (m, n, ...) so many samples apart, by their number of samples."""
    count = np.maximum(sum(good.sum(axis=0) for good in counted), 1)
    total = np.zeros((most + 1, *values[0].shape[1:]))
    for value, good in zip(values, counted, strict=True):
        size = np.array([_usual(value[own, j]) for j, own in enumerate(good.T)])
        held = np.clip(value, -size, size)
        for lag in range(most + 1):
            total[lag] += (held[lag:] * held[: len(held) - lag]).sum(axis=0)
    return np.asarray(total / count.reshape(-1, *[1] * (total.ndim - 2)))


def _usual(value: Array) -> Array:
    """The size at which values (m, ...) of one joint are truncated, along the first axis; 0 without values."""
    return CUT * MAD_TO_SD * np.asarray(np.median(np.abs(value), axis=0) if len(value) else np.zeros(value.shape[1:]))


def _draws(
    generator: np.random.Generator,
    residuals: Sequence[Array],
    noise: Array,
    lags: Array,
    orders: Sequence[int],
    pool: Sequence[int],
    draws: int,
) -> dict[int, Draw]:
    """Trial -> its draws, from trials of one sample step."""
    fitted = [_autoregression(lags[:, j], most) for j, most in enumerate(orders)]
    colour = np.zeros((max(len(own) for own, _ in fitted), len(fitted)))
    for j, (own, _) in enumerate(fitted):
        colour[: len(own), j] = own
    white = [_whitened(left, colour) / own for left, own in zip(residuals, noise, strict=True)]
    size = np.sqrt(sum((each**2).sum(axis=0) for each in white) / sum(len(each) for each in white))
    wanted = np.sqrt([variance for _, variance in fitted])
    scale = np.where(size > 0.0, wanted / np.where(size > 0.0, size, 1.0), 0.0)
    longest = float(correlation_factors(white).max())
    if longest <= 1.0 + 4.0 * np.sqrt(2.0 / sum(len(each) for each in white)):
        longest = 0.0  # white but for chance: two deviations of a pair of autocorrelations, which counts twice
    made = {}
    for t, left, own, each in zip(pool, residuals, noise, white, strict=True):
        m = len(left)
        block = int(np.clip(np.ceil(longest * m ** (1 / 3)), 1, max(1, m // 3)))  # grows with m^(1/3): Künsch 1989
        starts = generator.integers(0, len(each), (-(-2 * m // block), draws))
        made[t] = Draw(each * scale * own, colour, block, m, starts)
    return made


def _whitened(left: Array, colour: Array) -> Array:
    """(m - p, n) rad, what the last p samples do not predict, about its mean; zero for a joint without samples."""
    filled = np.zeros_like(left)
    for j in range(left.shape[1]):
        known = np.flatnonzero(np.isfinite(left[:, j]))
        if len(known):
            filled[:, j] = np.interp(np.arange(len(left)), known, left[known, j])
    p = len(colour)
    white = filled[p:].copy()
    for lag, own in enumerate(colour, 1):
        white -= own * filled[p - lag : len(filled) - lag]
    return np.asarray(white - white.mean(axis=0), dtype=np.float64)


def _recursion(lags: Array) -> Iterator[tuple[Array, float]]:
    """Coefficients (p,) of order 0, 1 ... and the variance that each leaves, by Levinson's recursion.

    ``lags`` (most + 1,) mean products of samples so far apart.
    """
    own, variance = np.zeros(0), float(lags[0])
    yield own, variance
    for order in range(1, len(lags)):
        reflection = float(lags[order] - own @ lags[order - 1 : 0 : -1]) / variance
        reflection = float(np.clip(reflection, -STEADY, STEADY))
        own = np.append(own - reflection * own[::-1], reflection)
        variance *= 1.0 - reflection**2
        yield own, variance


def _order(lags: Array, samples: int) -> int:
    """The order of least Akaike criterion."""
    if lags[0] <= 0.0:
        return 0
    return int(np.argmin([samples * np.log(left) + 2.0 * p for p, (_, left) in enumerate(_recursion(lags))]))


def _autoregression(lags: Array, order: int) -> tuple[Array, float]:
    """The coefficients (order,) and the variance that they leave."""
    if lags[0] <= 0.0:
        return np.zeros(0), 0.0
    return next(islice(_recursion(lags), order, None))
