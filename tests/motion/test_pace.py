"""The time scale of a recording, and the use of recorded velocities."""

from __future__ import annotations

import numpy as np
import pytest

from synth.arrays import Array
from synth.motion.smoothing import smooth
from synth.motion.velocity import unlike, with_velocities
from synth.pace import own_paces, pace, paces

GRID = np.arange(2001) * 1e-3
OMEGA = 15.0


def swing(decay: float = 1.0) -> Array:
    return 0.4 * np.exp(-decay * GRID) * np.cos(OMEGA * GRID)


@pytest.mark.parametrize("decay", [0.0, 1.0, 4.0])
@pytest.mark.parametrize("noise", [0.0, 0.005])
def test_a_swing_s_pace_is_half_over_its_frequency(decay: float, noise: float) -> None:
    # |e^(i w h) - 1| = 2 sin(w h / 2) is half of the deviation where w h = 2 asin(1/4) = 0.505
    value = swing(decay) + noise * np.random.default_rng(0).standard_normal(len(GRID))
    assert pace(1e-3, value[:, None]) == pytest.approx(2.0 * np.arcsin(0.25) / OMEGA, rel=0.06)


def test_pace_scales_with_time_and_takes_the_fastest_joint_that_moves() -> None:
    still = 1e-4 * np.random.default_rng(1).standard_normal(len(GRID))
    both = np.stack([swing(), np.cos(3.0 * GRID), still, 5.0 * GRID + 0.1 * np.sin(OMEGA * GRID)], axis=1)
    alone = pace(1e-3, both[:, :1])
    assert pace(1e-3, both) == pytest.approx(alone, rel=0.05)
    assert pace(20e-3, both) == pytest.approx(20.0 * pace(1e-3, both), rel=1e-12)


def test_smoothing_scales_with_time() -> None:
    noisy = (swing() + 0.001 * np.random.default_rng(2).standard_normal(len(GRID)))[:, None]
    lost = np.zeros(noisy.shape, dtype=bool)
    usual, slow, fast = (smooth(factor * GRID, noisy, lost) for factor in (1.0, 20.0, 0.05))
    for other, factor in ((slow, 20.0), (fast, 0.05)):
        np.testing.assert_allclose(other.angle, usual.angle, atol=1e-12)
        np.testing.assert_allclose(other.rate * factor, usual.rate, atol=1e-9)
    truth = -0.4 * np.exp(-GRID) * (np.cos(OMEGA * GRID) + OMEGA * np.sin(OMEGA * GRID))
    assert np.sqrt(np.mean((usual.rate[:, 0] - truth) ** 2)) < 0.04 * np.sqrt(np.mean(truth**2))  # noise of 1 mrad


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda rate: rate, ""),
        (lambda rate: 1.05 * rate, ""),
        (lambda rate: -rate, "opposite sign"),
        (lambda rate: np.degrees(rate), "57.3 times the angle's slope; is its unit right"),
        (lambda rate: 0.5 * rate, "0.5 times the angle's slope"),
        (lambda rate: np.roll(rate, 105), "is not the angle's slope"),
    ],
)
def test_a_velocity_that_does_not_match_the_angle_is_reported(change: object, words: str) -> None:
    angle = swing()[:, None]
    smoothed = smooth(GRID, angle, np.zeros(angle.shape, dtype=bool))
    assert callable(change)
    found = unlike(smoothed, GRID, change(smoothed.rate[:, 0].copy()), 0)
    assert (words in found) if words else found == ""


def test_a_quiet_velocity_is_used_and_a_noisy_one_is_not() -> None:
    random = np.random.default_rng(3)
    truth = np.gradient(swing(), GRID)
    angle = (swing() + 0.003 * random.standard_normal(len(GRID)))[:, None]
    smoothed = smooth(GRID, angle, np.zeros(angle.shape, dtype=bool))

    def error(noise: float) -> float:
        told = (truth + noise * random.standard_normal(len(GRID)))[:, None]
        return float(np.std(with_velocities(smoothed, GRID, told).rate[:, 0] - truth))

    assert error(0.01) < 0.2 * float(np.std(smoothed.rate[:, 0] - truth))
    np.testing.assert_array_equal(with_velocities(smoothed, GRID, truth[:, None] + np.nan).rate, smoothed.rate)
    assert error(100.0) == pytest.approx(float(np.std(smoothed.rate[:, 0] - truth)))


def test_a_locked_joint_does_not_set_the_pace() -> None:
    """What a fine sensor reads there, filtered, is above its noise and faster than the swing of the other joint."""
    time = np.arange(0.0, 2.0, 0.002)
    swing = 0.5 * np.cos(6.0 * time) * np.exp(-0.5 * time)
    jitter = 3e-5 * np.convolve(np.random.default_rng(0).standard_normal(len(time) + 8), np.hanning(9), "valid")
    both, lost = np.column_stack([swing, jitter]), np.zeros((len(time), 2), dtype=bool)
    alone = smooth(time, both[:, :1], lost[:, :1])
    assert smooth(time, both, lost).pace < 0.2 * alone.pace
    locked = smooth(time, both, lost, locked=[1])
    assert locked.pace == alone.pace
    np.testing.assert_allclose(locked.rate[:, 0], alone.rate[:, 0], atol=1e-12)


def test_each_joint_has_its_own_pace() -> None:
    """About 0.5 over the angular frequency; none for a joint that rests."""
    both = np.column_stack([swing(), 0.2 * np.cos(5.0 * OMEGA * GRID), np.zeros_like(GRID)])
    slow, fast, resting = paces(1e-3, both)
    assert slow == pytest.approx(0.505 / OMEGA, rel=0.1)
    assert fast == pytest.approx(0.505 / (5.0 * OMEGA), rel=0.1)
    assert np.isnan(resting)
    assert pace(1e-3, both) == fast


def test_channels_of_other_rates_in_one_table_have_the_pace_of_their_own_samples() -> None:
    """Every hundredth sample of the second, a third at rest."""
    time = np.arange(0.0, 2.0, 1e-4)
    swing = np.exp(-time) * np.sin(OMEGA * time)
    table = np.column_stack([swing, np.where(np.arange(len(time)) % 100 == 0, swing, np.nan), np.full(len(time), 2.0)])
    dense, rare, resting = own_paces(time, table)
    assert dense == pytest.approx(pace(1e-4, swing[:, None]), rel=1e-9)
    assert rare == pytest.approx(dense, rel=0.05)
    assert np.isnan(resting)
