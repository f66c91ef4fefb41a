"""How much less correlated series tell, against autoregressive ones with a known correlation time."""

from __future__ import annotations

import numpy as np
import pytest

from synth.arrays import Array, Mask
from synth.estimation.correlation import (
    alike_steps,
    correlation_factors,
    correlation_factors_by_step,
    independent_errors,
    integrated_time,
)


def autoregressive(a: float, shape: tuple[int, int], seed: int = 1) -> Array:
    """(m, n) independent series x_t = a x_(t-1) + white noise, from their stationary distribution."""
    noise = np.random.default_rng(seed).standard_normal(shape)
    noise[0] /= np.sqrt(1.0 - a**2)
    for k in range(1, len(noise)):
        noise[k] += a * noise[k - 1]
    return noise


@pytest.mark.parametrize("a", [0.0, 0.5, 0.9])
def test_the_time_of_a_decaying_correlation(a: float) -> None:
    """(1 + a) / (1 - a), Priestley, Spectral Analysis and Time Series, 1981, section 5.3.2."""
    wanted = (1.0 + a) / (1.0 - a)
    each = correlation_factors([autoregressive(a, (20_000, 20))])
    assert each.mean() == pytest.approx(wanted, rel=0.05)
    together = correlation_factors([autoregressive(a, (2_000, 20), seed) for seed in range(10)])
    assert together.mean() == pytest.approx(wanted, rel=0.05)


def test_recordings_of_another_rate_have_a_factor_of_their_own() -> None:
    """Noise of a correlation time of 20 ms at 1 kHz and at 50 Hz; together all had the first one's factor, 39."""
    steps = [0.02, 0.001, 0.021, 0.001, 0.02]
    decays = np.exp(-np.array(steps) / 0.02)
    series = [autoregressive(a, (400_000 if a > 0.9 else 20_000, 4), seed) for seed, a in enumerate(decays)]
    found = correlation_factors_by_step(series, steps)
    assert found.shape == (5, 4)
    assert found.mean(axis=1) == pytest.approx([2.16, 40.0, 2.16, 40.0, 2.16], rel=0.06)
    assert alike_steps(steps) == [[1, 3], [0, 4, 2]]


ROWS = np.arange(3000)
MASKS = {
    "every second": ROWS % 2 == 0,
    "every fourth": ROWS % 4 == 0,
    "every fourth, and ten more": (ROWS % 4 == 0) | (ROWS % 299 == 1),
    "a third lost": np.random.default_rng(3).random(3000) > 1 / 3,
    "nine tenths lost": np.random.default_rng(4).random(3000) > 0.9,
    "three to five apart": np.isin(ROWS, np.cumsum(np.random.default_rng(5).integers(3, 6, 1000))),
    "bursts": ROWS % 200 < 50,
}


def of_mean(a: float, known: Mask) -> float:
    """Variance of the mean of the known values over that of as many independent ones: mean of the sums of a^|s - t|."""
    places = np.flatnonzero(known)
    return float(np.mean(np.sum(a ** np.abs(places[:, None] - places), axis=1)))


@pytest.mark.parametrize("name", MASKS)
@pytest.mark.parametrize("a", [0.0, 0.9, 0.97])
def test_the_time_of_values_between_gaps_is_that_of_their_mean(a: float, name: str) -> None:
    """Of every fourth value it was 1: products at lags 2 and 3, of which no pair is known, counted as none."""
    known = MASKS[name]
    series = [np.where(known[:, None], autoregressive(a, (3000, 40), seed), np.nan) for seed in range(3)]
    assert correlation_factors(series).mean() == pytest.approx(of_mean(a, known), rel=0.12)


@pytest.mark.parametrize("every", [2, 3, 4, 10])
def test_rows_without_a_value_change_nothing(every: int) -> None:
    """The sequence over the lags that have pairs is that of the values alone."""
    whole = [autoregressive(0.97, (3000, 4), seed) for seed in range(3)]
    between = [np.where((ROWS % every == 0)[:, None], each, np.nan) for each in whole]
    assert correlation_factors(between) == pytest.approx(correlation_factors([each[::every] for each in whole]))


def test_few_lost_values_change_little() -> None:
    """Of each value's neighbours a fiftieth is lost too."""
    whole = [autoregressive(0.9, (3000, 40), seed) for seed in range(3)]
    lost = np.random.default_rng(6).random((3000, 40)) < 0.02
    found = correlation_factors([np.where(lost, np.nan, each) for each in whole])
    assert found - 1.0 == pytest.approx(0.98 * (correlation_factors(whole) - 1.0), rel=0.05)


def test_a_series_without_gaps_is_summed_as_it_is() -> None:
    """Shares of one, and none given, are the same to the last digit."""
    white = autoregressive(0.0, (500, 1))[:, 0]
    products = np.correlate(white, white, "full")[499:749]
    assert integrated_time(products) == integrated_time(products, np.ones(250), np.ones(250))


@pytest.mark.parametrize("a", [0.9, 0.97])
def test_values_that_are_left_out_tell_the_correlation_of_those_that_count(a: float) -> None:
    """The beginning and every tenth value count, as with the cost ``transient``."""
    counts = (ROWS < 100) | (ROWS % 10 == 0)
    series = [autoregressive(a, (3000, 40), seed) for seed in range(3)]
    found = correlation_factors(series, 3 * [np.broadcast_to(counts[:, None], (3000, 40))])
    assert found.mean() == pytest.approx(of_mean(a, counts), rel=0.1)
    assert found.std() < 0.3 * found.mean()
    none = np.zeros((3000, 40), dtype=bool)
    assert np.all(correlation_factors(series, 3 * [none]) == 1.0)


def test_lags_without_pairs_are_left_out_of_the_sequence() -> None:
    """Lags 0, 3, 6, 9: pairs of 0 and 3, 6 and 9, of which the second is not positive."""
    products, known = np.zeros(10), np.zeros(10)
    products[::3], known[::3] = [4.0, 2.0, 1.0, -2.0], 0.5
    assert integrated_time(products, known) == pytest.approx(2.0 * 1.5 - 1.0)
    # Of a lag with half of the pairs the mean product is twice as large, and as many values have such a neighbour.
    known[3] = 0.25
    assert integrated_time(products, known) == pytest.approx(2.0 * 1.5 - 1.0)
    assert integrated_time(products, known, np.where(known == 0.25, 0.5, known)) == pytest.approx(2.0 * 2.0 - 1.0)
    # Two lags with 1.2 pairs a value are too few for a term, which ends with the next two: all four.
    known[3] = 0.1
    assert integrated_time(products, known) == pytest.approx(2.0 * 1.25 - 1.0)


def test_lags_count_in_geyers_pairs() -> None:
    """Products of lags 0 and 1, 2 and 3, ... until a pair is not positive, each at most the pair before."""
    assert integrated_time(np.array([4.0, -1.0, 2.0, 0.0, 1.0, 2.0, 0.5, -0.5, 9.0, 9.0])) == pytest.approx(
        2.0 * (0.75 + 0.5 + 0.5) - 1.0
    )
    assert integrated_time(np.array([4.0, -3.0, -2.0, 1.0])) == 1.0
    assert integrated_time(np.zeros(4)) == 1.0


def test_white_noise_counts_nearly_fully() -> None:
    """The excess that the docstring of ``integrated_time`` states."""
    white = np.random.default_rng(0)
    for samples, excess in ((50, 1.34), (200, 1.17), (1000, 1.07)):
        factors = correlation_factors([white.standard_normal((samples, 1000))])
        assert factors.mean() == pytest.approx(excess, abs=0.04)


def test_independent_errors_have_bounds() -> None:
    """At most as many as asked, at least one; an error of constant sign counts as few."""
    white, slow = (autoregressive(a, (20_000, 1))[:, 0] for a in (0.0, 0.9))
    assert independent_errors(white, 1e9) == pytest.approx(len(white), rel=0.1)
    assert independent_errors(slow, 1e9) == pytest.approx(len(slow) * 0.1 / 1.9, rel=0.25)
    assert independent_errors(white, 50.0) == 50.0
    assert independent_errors(np.ones(500), 50.0) < 5.0
    assert [independent_errors(np.ones(count), 50.0) for count in (1, 2, 3)] == [1.0, 2.0, 3.0]
