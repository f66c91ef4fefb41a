"""Autoregressions: Levinson's recursion against a dense solution, and lost samples against a dense normal law."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import toeplitz

from synth.estimation.autoregression import Autoregression, best_order, nearest_possible, pair_products

LAGS = 2.0 * 0.9 ** np.arange(13) * np.cos(0.6 * np.arange(13))


def extended(law: Autoregression, count: int) -> list[float]:
    """The mean products of the law's own series."""
    lags = list(LAGS[:3])
    while len(lags) < count:
        lags.append(law.coefficients @ lags[:-3:-1])
    return lags


def test_coefficients_solve_the_yule_walker_equations() -> None:
    found = Autoregression.of(LAGS, 4)
    exact = np.linalg.solve(toeplitz(LAGS[:4]), LAGS[1:5])
    np.testing.assert_allclose(found.coefficients, exact, atol=1e-12)
    assert found.variance == pytest.approx(LAGS[0] - exact @ LAGS[1:5])
    assert best_order(np.array(extended(Autoregression.of(LAGS, 2), 12)), 1000) == 2


def test_lost_samples_are_drawn_from_their_law_given_the_others() -> None:
    """Mean and covariance by the dense Gaussian formulas, also at the series' ends."""
    law, m = Autoregression.of(LAGS, 2), 12
    covariance, generator = toeplitz(extended(law, m)), np.random.default_rng(0)
    values = np.linalg.cholesky(covariance) @ generator.normal(size=m)
    known = np.array([0, 1, 1, 0, 0, 1, 1, 1, 0, 1, 0, 0], dtype=bool)
    drawn = np.array([law.filled(values, known, generator) for _ in range(1000)])
    assert np.all(drawn[:, known] == values[known])
    across = covariance[np.ix_(~known, known)] @ np.linalg.inv(covariance[np.ix_(known, known)])
    left = covariance[np.ix_(~known, ~known)] - across @ covariance[np.ix_(known, ~known)]
    np.testing.assert_allclose(drawn[:, ~known].mean(axis=0), across @ values[known], atol=0.15)
    np.testing.assert_allclose(np.cov(drawn[:, ~known], rowvar=False), left, atol=0.3)


def test_products_of_pairs_are_those_of_the_whole_series_where_nothing_is_lost() -> None:
    value = np.random.default_rng(1).normal(size=40)
    found = pair_products([value], [np.ones(40, dtype=bool)], 5, 10)
    np.testing.assert_allclose(found, [value[lag:] @ value[: 40 - lag] / 40 for lag in range(6)])


def test_products_without_pairs_lie_between_their_neighbours() -> None:
    known = np.arange(400) % 2 == 0
    value = np.where(known, np.random.default_rng(1).normal(size=400).cumsum(), 0.0)
    found = pair_products([value], [known], 6, 10) * 400 / (400 - np.arange(7))
    assert found[1] == pytest.approx((found[0] + found[2]) / 2)
    assert found[5] == pytest.approx((found[4] + found[6]) / 2)


def test_impossible_products_get_a_spectrum_without_negative_parts() -> None:
    found = nearest_possible(np.array([1.0, 0.9, 0.2, -0.5, 0.8]))
    assert found[0] == pytest.approx(1.0)
    assert np.linalg.eigvalsh(toeplitz(found)).min() > -1e-12
