"""How much less correlated series tell, against autoregressive ones with a known correlation time."""

from __future__ import annotations

import numpy as np
import pytest

from synth.arrays import Array
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
