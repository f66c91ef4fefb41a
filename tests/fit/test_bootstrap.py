"""Intervals by block bootstrap: as wide as those by linearisation where both hold, and repeatable."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from fit.simulated_legs import Rig, fitted, releases, robot
from synth.estimation.intervals import NORMAL90
from synth.files.trial_list import Trial
from synth.fit.fit_result import FitResult
from synth.fit.residual_draws import resample

LEG = robot()


def widths(result: FitResult) -> np.ndarray:
    """(9,) widths of the 90 % intervals, rates in logarithms."""
    found = []
    for joint in result.joints.values():
        assert joint.damper_rate is not None
        found += [np.log(e.high / e.low) for e in (joint.spring_rate, joint.damper_rate)]  # type: ignore[operator]
        found.append(joint.free_angle.high - joint.free_angle.low)  # type: ignore[operator]
    return np.array(found)


def both_fits(trials: list[Trial], seed: int = 0) -> tuple[FitResult, FitResult]:
    options = {"free_angle": "common", "seed": seed}
    return fitted(LEG, trials, **options), fitted(LEG, trials, intervals="bootstrap", **options)


@pytest.mark.parametrize(("seed", "rig", "count"), [(1, Rig(noise=0.1), 7), (3, Rig(0.3, 1024, 1.0, 200.0), 3)])
def test_both_intervals_agree_within_a_fifth(seed: int, rig: Rig, count: int) -> None:
    sensitivities, bootstrap = both_fits(releases(LEG, seed, rig, count))
    assert bootstrap.intervals["by"] == "bootstrap"
    assert bootstrap.intervals["settled"] >= 190
    ratio = widths(bootstrap) / widths(sensitivities)
    # 200 refits leave 6.5 % of uncertainty on each width
    assert ratio.min() > 0.8
    assert ratio.max() < 1.25
    assert np.exp(np.log(ratio).mean()) == pytest.approx(1.0, abs=0.08)
    for name, joint in sensitivities.joints.items():
        assert bootstrap.joints[name].spring_rate.value == joint.spring_rate.value


def test_autocorrelated_residuals_widen_both_intervals() -> None:
    """Residuals that swing for many samples say less: blocks keep what single samples would lose."""
    generator = np.random.default_rng(2)
    white = releases(LEG, 2, Rig(noise=0.2, counts=0, rate=250.0), 4)
    coloured = []
    for trial in releases(LEG, 2, Rig(noise=0.0, counts=0, rate=250.0), 4):
        noise = generator.normal(0.0, np.radians(0.2), trial.angles.shape)
        for i in range(1, len(noise)):  # a first-order process of the same variance, correlation time nine samples
            noise[i] = 0.8 * noise[i - 1] + 0.6 * noise[i]
        coloured.append(Trial(trial.name, trial.time, trial.angles + noise))
    plain, _ = both_fits(white)
    sensitivities, bootstrap = both_fits(coloured)
    assert np.median(widths(bootstrap) / widths(plain)) > 1.5
    assert np.exp(np.log(widths(bootstrap) / widths(sensitivities)).mean()) == pytest.approx(1.0, abs=0.3)


def test_noise_that_wanders_slowly_widens_the_free_angles() -> None:
    """Correlated over twenty samples in trials of 120: the free angles are as uncertain as the trials' means."""
    still = Rig(noise=0.0, counts=0, rate=120.0)
    ratios = []
    for seed in (1, 2):
        generator, trials = np.random.default_rng(seed), []
        for trial in releases(LEG, seed, still, 3):
            noise = generator.normal(0.0, np.radians(0.3), trial.angles.shape)
            for i in range(1, len(noise)):
                noise[i] = 0.9 * noise[i - 1] + np.sqrt(1.0 - 0.9**2) * noise[i]
            trials.append(Trial(trial.name, trial.time, trial.angles + noise))
        sensitivities, bootstrap = both_fits(trials)
        ratios.append((widths(bootstrap) / widths(sensitivities))[2::3])
    assert np.exp(np.log(ratios).mean()) > 0.8


def test_a_linear_fit_to_slow_noise_is_as_uncertain_as_its_draws_say() -> None:
    """Three means and a swing, of which the deviation is known; a quarter of the noise's share is lost in residuals."""
    m, trials, slow = 120, 3, 0.9
    time = np.linspace(0.0, 1.5, m)
    swing = np.exp(-4.4 * time)[:, None] * np.column_stack([np.cos(27.0 * time), np.sin(27.0 * time)])
    design = np.hstack([np.ones((trials * m, 1)), np.kron(np.eye(trials), swing)])
    inverse = np.linalg.pinv(design)
    left = np.eye(trials * m) - design @ inverse

    def left_over(drawn: Sequence[np.ndarray]) -> list[np.ndarray]:
        return [each[:, None] for each in np.split(left @ np.concatenate([one[:, 0] for one in drawn]), trials)]

    covariance = np.kron(np.eye(trials), slow ** np.abs(np.subtract.outer(np.arange(m), np.arange(m))))
    true = np.sqrt((inverse @ covariance @ inverse.T)[0, 0])
    root, found = np.linalg.cholesky(covariance), []
    for seed in range(20):
        generator = np.random.default_rng(seed)
        residuals = [each[:, None] for each in np.split(left @ root @ generator.normal(size=trials * m), trials)]
        made = resample(generator, residuals, [0.0125] * trials, np.ones((trials, 1)), left_over, 200)
        drawn = np.concatenate([one.of(np.arange(200))[:, 0] for one in made])
        found.append((inverse @ drawn)[0].std())
    assert np.mean(found) == pytest.approx(true, rel=0.15)


def test_intervals_of_a_linear_fit_hold_the_truth_where_samples_are_lost() -> None:
    """Slow noise, every trial's mean, a third of the samples lost: 90 % of 120 intervals by 7 %; it was 67 %."""
    m, trials, held = 150, 4, []
    for seed in range(30):
        generator = np.random.default_rng(seed)
        noise = generator.normal(size=(trials, m))
        noise[:, 1:] *= np.sqrt(1.0 - 0.8**2)
        for i in range(1, m):
            noise[:, i] += 0.8 * noise[:, i - 1]
        known = generator.random((trials, m)) > 0.33

        def left_over(drawn: Sequence[np.ndarray], known: np.ndarray = known) -> list[np.ndarray]:
            return [each - each[good].mean(axis=0) for each, good in zip(drawn, known, strict=True)]

        means = [own[good].mean() for own, good in zip(noise, known, strict=True)]
        residuals = [
            np.where(good, own - mean, np.nan)[:, None] for own, good, mean in zip(noise, known, means, strict=True)
        ]
        made = resample(generator, residuals, [0.01] * trials, np.ones((trials, 1)), left_over, 100)
        refits = [draw.of(np.arange(100))[good, 0].mean(axis=0) for draw, good in zip(made, known, strict=True)]
        held += [abs(mean) < NORMAL90 * each.std() for mean, each in zip(means, refits, strict=True)]
    assert 0.83 < np.mean(held) < 0.97


def test_draws_of_a_joint_that_was_lost_most_of_the_time_are_as_large_as_its_residuals() -> None:
    """The lost samples count for nothing; taken for zeros they left draws of size 0, and intervals without width."""
    generator = np.random.default_rng(0)
    residuals = [generator.normal(0.0, 0.01, (400, 2)) for _ in range(3)]
    for left in residuals:
        left[generator.random(400) < 0.6, 1] = np.nan
    made = resample(generator, residuals, [0.01] * 3, np.full((3, 2), 0.01), lambda drawn: list(drawn), 50)
    size = np.sqrt(np.mean([each.of(np.arange(50)) ** 2 for each in made], axis=(0, 1, 3)))
    np.testing.assert_allclose(size, 0.01, rtol=0.1)


@pytest.mark.parametrize("lost", [0.0, 0.2, 0.5])
def test_draws_of_correlated_noise_are_as_correlated_where_samples_are_lost(lost: float) -> None:
    """Correlation 0.9: the mean of a trial's samples varies as that of such noise does, known from 2000 series."""

    def noise(generator: np.random.Generator, count: int) -> np.ndarray:
        made = generator.normal(size=(300, count))
        made[1:] *= np.sqrt(1.0 - 0.9**2)
        for i in range(1, 300):
            made[i] += 0.9 * made[i - 1]
        return made

    found, true = [], []
    for seed in range(3):
        generator = np.random.default_rng(seed)
        residuals = [0.01 * noise(generator, 1) for _ in range(6)]
        for left in residuals:
            left[generator.random(300) < lost] = np.nan
        made = resample(generator, residuals, [0.01] * 6, np.full((6, 1), 0.01), lambda drawn: list(drawn), 100)
        for draw, left in zip(made, residuals, strict=True):
            known = np.isfinite(left[:, 0])
            found.append(draw.of(np.arange(100))[known, 0].mean(axis=0).std() / 0.01)
            true.append(noise(generator, 2000)[known].mean(axis=0).std())
    assert np.mean(found) == pytest.approx(np.mean(true), rel=0.15)
    by_seed = np.reshape(found, (3, -1)).mean(axis=1)
    np.testing.assert_allclose(by_seed, np.mean(true), rtol=0.35)


def test_a_joint_that_is_locked_in_some_trials_has_its_noise_in_the_others() -> None:
    """Counted as residuals of zero, the locked trials made the draws 1e14 times too large."""
    generator = np.random.default_rng(0)
    residuals = [generator.normal(0.0, 0.01, (300, 2)) for _ in range(4)]
    for left in residuals[:2]:
        left[:, 1] = np.nan
    made = resample(generator, residuals, [0.01] * 4, np.full((4, 2), 0.01), lambda drawn: list(drawn), 50)
    size = [each.of(np.arange(50))[:, 1].std() for each in made]
    np.testing.assert_allclose(size, [0.0, 0.0, 0.01, 0.01], rtol=0.1)


def test_noise_that_no_draws_reproduce_is_reported() -> None:
    """Of these draws a refit leaves a hundredth whatever their size is: the residuals are not such noise."""
    generator = np.random.default_rng(0)
    residuals = [generator.normal(0.0, 0.01, (200, 1)) for _ in range(2)]
    with pytest.raises(ArithmeticError, match="no noise is found of which the fit would leave residuals like these"):
        resample(
            generator, residuals, [0.01] * 2, np.full((2, 1), 0.01), lambda drawn: [0.1 * one for one in drawn], 50
        )


def test_coarse_counts_are_refused_with_the_reason() -> None:
    """Counts of 0.35 deg, noise of 0.1 deg: the refits took them for plain samples, and none of 200 converged."""
    sensitivities, bootstrap = both_fits(releases(LEG, 1, Rig(0.1, 1024, 1.0, 200.0), 2))
    assert bootstrap.intervals == {"by": "sensitivities"}
    assert any("are coarser than the noise" in text for text in bootstrap.warnings)
    assert np.array_equal(widths(bootstrap), widths(sensitivities))


def test_the_same_seed_gives_the_same_intervals() -> None:
    trials = releases(LEG, 1, Rig(noise=0.2, rate=200.0), 2)
    first, again = (fitted(LEG, trials, intervals="bootstrap", seed=4) for _ in range(2))
    other = fitted(LEG, trials, intervals="bootstrap", seed=5)
    assert np.array_equal(widths(first), widths(again))
    assert not np.array_equal(widths(first), widths(other))
