"""The likelihood of coarse encoder counts, against closed forms, and its gain in a fit."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm, truncnorm

from fit.simulated_legs import errors, fitted
from robustness.random_legs import Recorder, random_case
from synth.fit.least_squares import HUBER, _weigh_residuals
from synth.fit.recordings import recordings
from synth.fit.rounding import Rounding, encoder_counts, rounding_of
from synth.motion.counts import COARSE_NOISE

COUNT = 2 * math.pi / 512


@pytest.mark.parametrize("share", [0.05, 0.2, 0.55])
def test_cost_slope_and_curvature_equal_those_of_the_rounding_cell(share: float) -> None:
    """-log(Phi(b) - Phi(a)) by scipy; its slope is the truncated normal's mean, its curvature one less its variance."""
    noise = share * COUNT
    off = np.linspace(-1.0, 1.0, 41) * (0.5 * COUNT + 1.5 * noise)
    cost, slope, curvature = Rounding(noise, COUNT).terms(off, HUBER)
    low, high = (-off - COUNT / 2) / noise, (-off + COUNT / 2) / noise
    exact = -np.log(norm.cdf(high) - norm.cdf(low)) + math.log(norm.cdf(0.5 / share) - norm.cdf(-0.5 / share))
    np.testing.assert_allclose(cost, exact, atol=2e-3)
    np.testing.assert_allclose(slope, -truncnorm.mean(low, high), atol=3e-3)
    np.testing.assert_allclose(curvature, 1.0 - truncnorm.var(low, high), atol=3e-3)


def test_beyond_the_huber_knee_the_slope_is_constant_and_the_cost_smooth() -> None:
    made = Rounding(0.1 * COUNT, COUNT)
    off = np.linspace(0.0, 40.0, 4001) * made.noise
    cost, slope, curvature = made.terms(off, HUBER)
    assert slope.max() == pytest.approx(HUBER)
    np.testing.assert_allclose(np.diff(cost), 0.5 * (slope[1:] + slope[:-1]) * 0.01, atol=2e-4)
    assert np.all(curvature >= 0.0)
    assert np.all(made.terms(-off, HUBER)[1] == -slope)


def test_correlated_counts_tell_less() -> None:
    """A trial whose divisor is twice the noise before rounding has a quarter of the log-likelihood."""
    case = random_case(7, Recorder(noise=0.05, counts=512, rate=200.0, trials=1), links=2)
    (made,) = recordings(case.bare, case.trials)
    item = Rounding(0.1 * COUNT, COUNT)
    prediction = made.rotation + 0.55 * COUNT * np.sin(np.arange(made.rotation.size)).reshape(made.rotation.shape)
    once, twice = (
        _weigh_residuals(made, prediction, factor * item.noise * np.ones(2), (item, item)) for factor in (1.0, 2.0)
    )
    assert twice[0] == pytest.approx(once[0] / 4)
    assert np.sum(twice[2] * twice[1]) == pytest.approx(np.sum(once[2] * once[1]) / 4)  # the slope


@pytest.mark.parametrize("share", [0.1, 0.3, 0.5])
def test_noise_before_rounding_is_estimated(share: float) -> None:
    """A motion over many counts, 4 000 readings: within 6 %."""
    rng = np.random.default_rng(5)
    truth = np.linspace(0.0, 30 * COUNT, 4000)
    read = COUNT * np.round((truth + share * COUNT * rng.standard_normal(4000)) / COUNT)
    found = rounding_of(truth - read, COUNT)
    assert found is not None
    assert found.noise / COUNT == pytest.approx(share, rel=0.06)


def test_rounding_is_not_modelled_for_fine_counts_or_a_wrong_model() -> None:
    rng = np.random.default_rng(5)
    truth = np.linspace(0.0, 30 * COUNT, 4000)
    noisy = truth + 1.5 * COARSE_NOISE * COUNT * rng.standard_normal(4000)
    assert rounding_of(truth - COUNT * np.round(noisy / COUNT), COUNT) is None
    assert rounding_of(truth - noisy, 0.0) is None
    assert rounding_of(5 * COUNT * np.sin(truth), COUNT) is None


def test_encoder_counts_are_detected_only_in_counted_readings() -> None:
    case = random_case(7, Recorder(noise=0.05, counts=1024, rate=200.0, trials=2, lost=0.05), links=2)
    np.testing.assert_allclose(encoder_counts(recordings(case.bare, case.trials)), 2 * math.pi / 1024, rtol=1e-3)
    smooth = random_case(7, Recorder(noise=0.05, counts=0, rate=200.0, trials=2), links=2)
    assert np.all(encoder_counts(recordings(smooth.bare, smooth.trials)) == 0.0)
    # As a file gives them, in degrees of five decimals.
    written = [replace(t, angles=np.radians(np.round(np.degrees(t.angles), 5))) for t in case.trials]
    np.testing.assert_allclose(encoder_counts(recordings(case.bare, written)), 2 * math.pi / 1024, rtol=1e-3)


def test_a_limb_at_rest_on_one_count_does_not_narrow_the_intervals() -> None:
    """Counts of 0.7 deg, noise of 0.1 deg: over 12 legs the errors are as large as said, where they were ten times."""
    scores = []
    for seed in range(12):
        case = random_case(seed, Recorder(noise=0.1, counts=512, rate=200.0, trials=3), links=1)
        scores.append(errors(fitted(case.leg, case.trials), case.leg).scores)
    assert np.sqrt(np.mean(np.square(scores))) < 1.5
