"""Noise that lasts, in short recordings: no shift of a free angle is seen where none is."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest

from synth.files.trial_list import Trial
from synth.fit.estimate import fit_leg
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_result import FitResult
from synth.fit.free_angle import excess_of_common
from synth.fit.recordings import recordings
from synth.swing.leg_model import Joint, Leg, Link

INERTIA, FREQUENCY, RATIO = 1e-3, 2 * np.pi * 4.0, 0.4  # kg m^2 about the joint, rad/s, damping ratio
LASTS, NOISE = 0.04, np.radians(0.3)  # s, rad: a tenth of each recording
SEEDS = 16


def oscillator() -> Leg:
    """One link without weight: its swing has a closed form."""
    return Leg("oscillator", (Joint("knee", Link(0.2, 0.1, 0.05, INERTIA - 0.1 * 0.05**2), 0.0, 1),), gravity=0.0)


def fitted_with_noise(
    seed: int,
    spread: float = 0.0,
    release: Literal["free", "recorded"] = "recorded",
    noise: float = NOISE,
    count: int = 4,
) -> FitResult:
    """``count`` releases of 0.4 s at 250 Hz whose free angle shifts by ``spread`` rad."""
    generator = np.random.default_rng(seed)
    time = np.arange(0.0, 0.4, 0.004)
    damped, kept = FREQUENCY * np.sqrt(1 - RATIO**2), np.exp(-0.004 / LASTS)
    swing = np.exp(-RATIO * FREQUENCY * time) * (
        np.cos(damped * time) + RATIO / np.sqrt(1 - RATIO**2) * np.sin(damped * time)
    )
    trials = []
    for k in range(count):
        fresh = generator.normal(size=len(time))
        lasting = [fresh[0]]
        for each in fresh[1:]:
            lasting.append(kept * lasting[-1] + np.sqrt(1 - kept**2) * each)
        rest = 0.3 + spread * generator.normal()
        angle = rest + (-1) ** k * (0.3 + 0.05 * k) * swing + noise * np.array(lasting)
        trials.append(Trial(f"release {k}", time, angle[:, None]))
    leg = oscillator()
    return fit_leg(leg, recordings(leg, trials), LegFitOptions(release=release, laws="linear"))


def test_a_free_angle_that_stays_is_common_and_its_interval_holds_it() -> None:
    found = [fitted_with_noise(seed) for seed in range(SEEDS)]
    assert sum(each.free_angle == "per_trial" for each in found) <= 1  # by the noise of the residuals
    angles = [each.joints["knee"].free_angle for each in found]
    held = [each.low is not None and each.high is not None and each.low <= 0.3 <= each.high for each in angles]
    assert sum(held) >= SEEDS - 4  # 90 %: fewer than 13 of 16 by chance in 7 of 100


def test_a_shift_above_such_noise_is_still_seen() -> None:
    found = [fitted_with_noise(seed, spread=np.radians(2.0)) for seed in range(4)]
    assert all(each.free_angle == "per_trial" for each in found)
    assert np.degrees([each.joints["knee"].free_angle_spread.value for each in found]) == pytest.approx(2.0, abs=1.5)


def test_the_mean_of_shifts_errs_by_their_true_variances() -> None:
    stated, true = (
        np.array([[1.0, 4.0, np.nan], [1.0, np.nan, np.nan]]),
        np.array([[3.0, 8.0, np.nan], [6.0, np.nan, np.nan]]),
    )
    assert excess_of_common(stated, true) == pytest.approx([2.0 - 0.5, 8.0 - 4.0, 0.0])


def test_such_noise_is_not_taken_for_a_hand() -> None:
    """By the noise of the residuals a start was cut, or a hand or another law named, in five of these legs."""
    found = [fitted_with_noise(seed, release="free", noise=np.radians(0.5), count=3) for seed in range(SEEDS)]
    assert sum(each.cut > 0.0 for each in found) <= 1
    assert sum("do not fit one leg" in text for each in found for text in each.warnings) <= 1
    unsure = [each for each in found if any("fit one leg if the noise lasts" in text for text in each.warnings)]
    rates = [each.joints["knee"].spring_rate for each in unsure]
    assert len(unsure) >= 3
    assert all(rate.low is not None and rate.low <= INERTIA * FREQUENCY**2 <= (rate.high or 0.0) for rate in rates)
