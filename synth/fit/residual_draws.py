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

Lost samples are drawn from the autoregression given those that are there, and it is estimated again from the series so
filled, a few times over (stochastic EM: Celeux & Diebolt, Computational Statistics Quarterly 2 (1985) 73). What a refit
leaves is compared at the samples that count alone. Noise of the first order, four trials of 400 samples, 12 data sets,
an ideal refit: the deviation of a trial's mean is 1.01 of the true one (correlation 0.7) and 1.02 (0.9) with a fifth of
the samples lost, 0.98 and 0.99 with half of them. A joint's drawn samples are not correlated with the other joints'.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array, Mask
from synth.estimation.autoregression import Autoregression, best_order, nearest_possible, pair_products
from synth.estimation.correlation import alike_steps, correlation_factors
from synth.noise import MAD_TO_SD
from synth.units import significant

ORDER = 60  # most coefficients of an autoregression; what is left of the correlation is in the blocks
ROUNDS = 3  # corrections of the autocorrelation, a choice: each leaves about the share that the fit absorbs of the last
FILLINGS = 10  # of lost samples and autoregression in turn, a choice; with half of them lost 5 end up to 5 % short
LEAST_PAIRS = 10  # fewest products from which a mean product is taken where samples are lost
UNLIKE_VARIANCE = 0.2  # of the residuals' variance, by which the last draws' may be off after a refit
# draws from which the correlation after a refit is known, to some 3 % for two dozen independent samples
CHECKED_DRAWS = 100
# fewer such draws of long trials, which tell as much: so many samples in all
LEAST_DRAWS, ENOUGH_SAMPLES = 10, 10_000_000
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


def resample(
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

    Raises
    ------
    ArithmeticError : no autoregression is found of whose draws a refit leaves as much as the fit did of the noise.
    """
    scaled = [left / own for left, own in zip(residuals, noise, strict=True)]
    pools = [_AlikeTrials.of(generator, trials, [scaled[t] for t in trials]) for trials in alike_steps(steps)]
    lags = [pool.wanted.copy() for pool in pools]
    some = np.arange(
        min(draws, CHECKED_DRAWS, max(LEAST_DRAWS, ENOUGH_SAMPLES // sum(left.size for left in residuals)))
    )
    for turn in range(ROUNDS + 1):
        made: dict[int, Draw] = {}
        for pool, each in zip(pools, lags, strict=True):
            made |= pool.draws(generator, each, noise, draws)
        found = [made[t] for t in range(len(residuals))]
        drawn = [draw.of(some) for draw in found]
        left = left_over(drawn)
        for pool, each in zip(pools, lags, strict=True):
            before, after = ([values[t] / noise[t][:, None] for t in pool.trials] for values in (drawn, left))
            draw_lags = pool.lags_after_refit(before, after)
            if turn == ROUNDS:
                _require_alike(draw_lags[0], pool.wanted[0])
            each += pool.wanted - draw_lags
    return found


def _require_alike(draw_lags: Array, wanted: Array) -> None:
    """Variances (n,) of what a refit leaves of the last draws, and of the residuals."""
    known = wanted > 0.0
    off = draw_lags[known] / wanted[known]
    if np.any(np.abs(off - 1.0) > UNLIKE_VARIANCE):
        worst = off[np.argmax(np.abs(off - 1.0))]
        raise ArithmeticError(
            f"no noise is found of which the fit would leave residuals like these: of the resampled it leaves "
            f"{significant(worst, 2)} times their variance"
        )


@dataclass(frozen=True)
class _AlikeTrials:
    """``trials`` of one sample step, and their residuals in units of the noise.

    ``filled`` (m, n) a trial, lost samples drawn, 0 for a joint without any; ``counted`` (m, n) those that are no such
    draws, ``present`` (m, n) all of a joint that has some. ``wanted`` (most + 1, n) mean products of residuals so many
    samples apart, and ``orders`` (n,) of the autoregressions.
    """

    trials: Sequence[int]
    filled: Sequence[Array]
    counted: Sequence[Mask]
    present: Sequence[Mask]
    wanted: Array
    orders: Sequence[int]

    @classmethod
    def of(cls, generator: np.random.Generator, trials: Sequence[int], scaled: Sequence[Array]) -> _AlikeTrials:
        """Of residuals (m, n) in units of the noise, nan where no sample counts."""
        counted = [np.isfinite(left) for left in scaled]
        filled = [np.where(good, left, 0.0) for left, good in zip(scaled, counted, strict=True)]
        present = [np.broadcast_to(good.any(axis=0), good.shape) for good in counted]
        most = min(ORDER, min(map(len, scaled)) // 4)  # coefficients: at most a quarter of the shortest trial
        lags, orders = _lags(filled, counted, most), []
        for j in range(lags.shape[1]):
            number = sum(int(good[:, j].sum()) for good in counted)
            lost = any(not good[:, j].all() for good in counted if good[:, j].any())
            if lost and most > 0 and lags[0, j] > 0.0:
                lags[:, j] = nearest_possible(lags[:, j])
            for _ in range(FILLINGS if lost and lags[0, j] > 0.0 else 0):
                law = Autoregression.of(lags[:, j], best_order(lags[:, j], number))
                for series, good in zip(filled, counted, strict=True):
                    if good[:, j].any():
                        series[:, j] = law.filled(series[:, j], good[:, j], generator)
                lags[:, j] = _lags([each[:, [j]] for each in filled], [each[:, [j]] for each in present], most)[:, 0]
            orders.append(best_order(lags[:, j], number) if lags[0, j] > 0.0 else 0)
        return cls(trials, filled, counted, present, lags, orders)

    def lags_after_refit(self, drawn: Sequence[Array], left: Sequence[Array]) -> Array:
        """(most + 1, n) mean products of what a refit leaves of draws (m, n, c), as of all samples.

        At lost samples it leaves what its estimates miss there, which no residual shows. So what it takes at the others
        is subtracted from the draws' products.
        """
        most = len(self.wanted) - 1
        found = _lags(left, self.counted, most)
        if any(np.any(good != all_) for good, all_ in zip(self.counted, self.present, strict=True)):
            found += _lags(drawn, self.present, most) - _lags(drawn, self.counted, most)
        return np.asarray(found.mean(axis=2))

    def draws(self, generator: np.random.Generator, lags: Array, noise: Array, draws: int) -> dict[int, Draw]:
        """Trial -> its draws, coloured as these mean products (most + 1, n) say; ``noise`` (n_trial, n) rad."""
        laws = [Autoregression.of(lags[:, j], most) if lags[0, j] > 0.0 else None for j, most in enumerate(self.orders)]
        colour = np.zeros((max(self.orders), len(laws)))
        for j, law in enumerate(laws):
            if law is not None:
                colour[: self.orders[j], j] = law.coefficients
        white = [_innovations(each, colour) for each in self.filled]
        number = sum(len(each) * good[0] for each, good in zip(white, self.present, strict=True))
        size = np.sqrt(sum((each**2).sum(axis=0) for each in white) / np.maximum(number, 1))
        wanted = np.sqrt([0.0 if law is None else law.variance for law in laws])
        scale = np.where(size > 0.0, wanted / np.where(size > 0.0, size, 1.0), 0.0)
        longest = float(correlation_factors(white).max())
        if longest <= 1.0 + 4.0 * np.sqrt(2.0 / sum(map(len, white))):
            longest = 0.0  # white but for chance: two deviations of a pair of autocorrelations, which counts twice
        made = {}
        for t, filled, each in zip(self.trials, self.filled, white, strict=True):
            m = len(filled)
            block = int(np.clip(np.ceil(longest * m ** (1 / 3)), 1, max(1, m // 3)))  # grows with m^(1/3): Künsch 1989
            starts = generator.integers(0, len(each), (-(-2 * m // block), draws))
            made[t] = Draw(each * scale * noise[t], colour, block, m, starts)
        return made


def _lags(values: Sequence[Array], known: Sequence[Mask], most: int) -> Array:
    """(most + 1, n, ...) mean products of truncated values (m, n, ...) so many samples apart, of known (m, n)."""
    columns = []
    for j in range(values[0].shape[1]):
        goods = [np.ascontiguousarray(good[:, j]) for good in known]
        held = []
        for value, good in zip(values, goods, strict=True):
            size = _usual(value[good, j])
            mask = good.reshape(-1, *[1] * (value.ndim - 2))
            held.append(np.where(mask, np.clip(value[:, j], -size, size), 0.0))
        columns.append(pair_products(held, goods, most, LEAST_PAIRS))
    return np.stack(columns, axis=1)


def _usual(value: Array) -> Array:
    """The size at which values (m, ...) of one joint are truncated, along the first axis; 0 without values."""
    return CUT * MAD_TO_SD * np.asarray(np.median(np.abs(value), axis=0) if len(value) else np.zeros(value.shape[1:]))


def _innovations(filled: Array, colour: Array) -> Array:
    """(m - p, n), what the last p samples do not predict, about its mean."""
    p = len(colour)
    white = filled[p:].copy()
    for lag, own in enumerate(colour, 1):
        white -= own * filled[p - lag : len(filled) - lag]
    return np.asarray(white - white.mean(axis=0), dtype=np.float64)
