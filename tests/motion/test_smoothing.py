"""Smoothing against scipy, lost samples detected without mistaking fast swings, the noise estimated."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.signal import savgol_coeffs, savgol_filter

from synth.motion.smoothing import initial_state, lost_samples, polynomial_noise, savitzky_golay, smooth

Array = NDArray[np.float64]


def swing(time: Array, frequency: float = 3.0, amplitude: float = 0.4) -> Array:
    """(n, 1) rad, a decaying swing."""
    return (amplitude * np.exp(-2 * time) * np.cos(2 * np.pi * frequency * time))[:, None]


@pytest.mark.parametrize(("missing", "seen"), [(3, False), (4, True), (6, True)])
def test_four_samples_in_a_row_that_are_missing_are_a_gap(missing: int, *, seen: bool) -> None:
    """Fewer are bridged by the polynomials. The gap is all that lies between the samples beside it."""
    time = np.arange(200) * 0.005
    lost = np.zeros((200, 1), dtype=bool)
    lost[100 : 100 + missing] = True
    found = smooth(time, swing(time), lost).gap
    assert np.all(found[100 : 100 + missing] == seen)
    assert found.sum() == (missing + 1 if seen else 0)  # with the sample at one end


def test_the_noise_of_a_polynomial_is_the_norm_of_scipys_coefficients() -> None:
    wanted = [float(np.linalg.norm(savgol_coeffs(11, 3, deriv=order, delta=0.01))) for order in (0, 1)]
    assert polynomial_noise(11, 3, 0.01) == pytest.approx(wanted)


@settings(max_examples=40, deadline=None)
@given(st.integers(2, 12), st.integers(1, 4), st.integers(25, 80), st.integers(0, 99), st.floats(1e-4, 0.1))
def test_savitzky_golay_is_scipys(half: int, degree: int, count: int, seed: int, step: float) -> None:
    degree = min(degree, 2 * half)
    value = np.random.default_rng(seed).normal(size=(count, 2))
    smoothed, rate, kept = savitzky_golay(value, 2 * half + 1, degree, step)
    wanted = {"window_length": 2 * half + 1, "polyorder": degree, "axis": 0, "mode": "interp"}
    np.testing.assert_allclose(smoothed, savgol_filter(value, **wanted), atol=1e-10)
    np.testing.assert_allclose(rate * step, savgol_filter(value, deriv=1, delta=1.0, **wanted), atol=1e-10)
    # the residual's variance is that of 1 - H in the middle row
    row = np.eye(2 * half + 1)[half] - savgol_filter(np.eye(2 * half + 1), 2 * half + 1, degree, axis=0)[half]
    assert kept == pytest.approx(row @ row, abs=1e-12)


def test_a_cubic_passes_unchanged_to_its_ends() -> None:
    time = np.linspace(0.2, 0.7, 101)
    angle = np.stack([1 - time + 3 * time**2 - 2 * time**3, 0.5 * time], axis=1)
    rate = np.stack([-1 + 6 * time - 6 * time**2, np.full(101, 0.5)], axis=1)
    found = smooth(time, angle, np.zeros_like(angle, dtype=bool))
    np.testing.assert_allclose(found.time, time, atol=1e-12)
    np.testing.assert_allclose(found.angle, angle, atol=1e-12)
    np.testing.assert_allclose(found.rate, rate, atol=1e-10)
    first, speed = initial_state(found)
    np.testing.assert_allclose([first, speed], [angle[0], rate[0]], atol=1e-10)
    assert found.noise.max() < 1e-12
    assert not found.gap.any()


@pytest.mark.parametrize("frequency", [1.0, 3.0])
def test_noise_of_uneven_samples_is_theirs_not_that_of_the_interpolated_grid(frequency: float) -> None:
    generator = np.random.default_rng(11)
    told = []
    for _ in range(200):
        time = np.cumsum(0.004 * (1 + 0.2 * generator.integers(-2, 3, 200)))
        angle = swing(time, frequency) + generator.normal(0, 1e-3, (200, 1))
        told.append(smooth(time, angle, np.zeros_like(angle, dtype=bool)).noise)
    assert np.sqrt(np.mean(np.square(told))) == pytest.approx(1e-3, rel=0.05)


def test_a_gap_says_nothing_of_the_noise() -> None:
    generator = np.random.default_rng(12)
    time = np.arange(0.0, 1.0, 0.004)
    told = []
    for _ in range(100):
        angle = swing(time, 1.0) + generator.normal(0, 1e-3, (len(time), 1))
        lost = np.zeros_like(angle, dtype=bool)
        lost[80:230] = True
        told.append(smooth(time, angle, lost, width=0.05).noise)
    assert np.sqrt(np.mean(np.square(told))) == pytest.approx(1e-3, rel=0.05)


@pytest.mark.parametrize(("rate", "joints"), [(100.0, 1), (500.0, 3), (1000.0, 1)])
def test_noise_is_estimated_within_five_per_cent(rate: float, joints: int) -> None:
    time = np.arange(0, 1.0 + 0.5 / rate, 1 / rate)
    generator = np.random.default_rng(7)
    told = []
    for _ in range(round(60_000 / rate / joints)):
        angle = np.tile(swing(time, 1.5), joints) + generator.normal(0, 1.7e-3, (len(time), joints))
        told.append(smooth(time, angle, np.zeros_like(angle, dtype=bool)).noise)
    assert np.sqrt(np.mean(np.square(told))) == pytest.approx(1.7e-3, rel=0.05)


def test_glitches_that_are_not_found_are_not_counted_as_noise() -> None:
    time = np.arange(0, 1, 0.002)
    generator = np.random.default_rng(3)
    angle = swing(time) + generator.normal(0, 1.7e-3, (len(time), 1))
    for first in range(20, 500, 80):
        angle[first : first + 5] += 1.0  # longer than what is found as lost
    assert not lost_samples(time, angle).any()
    assert smooth(time, angle, lost_samples(time, angle)).noise[0] == pytest.approx(1.7e-3, rel=0.4)


def test_missing_and_lone_samples_are_found_in_noise() -> None:
    time = np.arange(0, 1, 0.002)
    generator = np.random.default_rng(2)
    angle = np.tile(swing(time), 2) + generator.normal(0, 1.7e-3, (len(time), 2))
    wrong = np.zeros_like(angle, dtype=bool)
    for sample, height in zip((40, 90, 200, 333, 460), (0.05, -0.08, 0.5, -6.28, 0.06), strict=True):
        angle[sample, 0] += height
        wrong[sample, 0] = True
    angle[100:104, 1] = np.nan
    wrong[100:104, 1] = True
    np.testing.assert_array_equal(lost_samples(time, angle), wrong)


@pytest.mark.parametrize("noise", [0.0, 1.7e-3])
@pytest.mark.parametrize("frequency", [1.0, 8.0, 25.0])
def test_fast_swings_and_jumps_of_speed_are_no_lost_samples(frequency: float, noise: float) -> None:
    time = np.arange(0, 1, 0.002)
    generator = np.random.default_rng(4)
    moving = np.where(time[:, None] < 0.3, 0.4, swing(time - 0.3, frequency))  # held, then let go
    angle = moving + generator.normal(0, 1, moving.shape) * noise
    assert not lost_samples(time, angle).any()
    stopped = np.minimum(np.abs(swing(time, frequency)), 0.2)  # corners where it hits something
    assert not lost_samples(time, stopped + generator.normal(0, 1, moving.shape) * noise).any()


@pytest.mark.parametrize("noise", [0.0, 0.002, 0.005, 0.01, 0.02, 0.1])
@pytest.mark.parametrize("rate", [100.0, 500.0, 1000.0])
def test_flicker_of_one_count_is_no_lost_sample_but_a_spike_is(noise: float, rate: float) -> None:
    time = np.arange(0, 2, 1 / rate)
    generator = np.random.default_rng(1)
    angle = 100.013 + np.degrees(swing(time)) + generator.normal(0, 1, (len(time), 1)) * noise
    count = 360 / 8192
    read = count * np.round(angle / count)
    assert not lost_samples(time, np.radians(read)).any()
    read[-30] += 30 * count
    np.testing.assert_array_equal(np.flatnonzero(lost_samples(time, np.radians(read))), [len(time) - 30])


@pytest.mark.parametrize("length", [2, 3])
@pytest.mark.parametrize("rate", [100.0, 500.0])
def test_a_short_run_beside_the_series_is_lost(length: int, rate: float) -> None:
    time = np.arange(0, 1, 1 / rate)
    generator = np.random.default_rng(3)
    for at in range(10, 80, 10):
        angle = swing(time, 1.0) + generator.normal(0, 1e-3, (len(time), 1))
        angle[at : at + length] += 0.35
        np.testing.assert_array_equal(np.flatnonzero(lost_samples(time, angle)), np.arange(at, at + length))


@pytest.mark.parametrize("frequency", [2.0, 5.0, 7.0, 8.0])
def test_a_coarsely_sampled_swing_has_no_lost_runs(frequency: float) -> None:
    """Four to fifteen samples a period, as of a video; held and let go, or swinging from the first sample on."""
    time = np.arange(0, 3, 1 / 30)
    for start in (*np.arange(0.3, 0.3 + 1 / 30, 1 / 300), 0.0):
        assert not lost_samples(time, swing(np.maximum(time - start, 0.0), frequency)).any()


def test_a_spike_in_a_joint_that_stands_still_is_found() -> None:
    time, angle = 0.004 * np.arange(100), np.full((100, 1), 0.3)
    angle[50] += 0.1
    np.testing.assert_array_equal(np.flatnonzero(lost_samples(time, angle)), [50])


@pytest.mark.parametrize("at", [0, 1, 2, 197, 198, 199])
@pytest.mark.parametrize("height", [5.0, -30.0])
def test_a_spike_at_an_end_is_lost(at: int, height: float) -> None:
    """The first two and the last two have no neighbours on one side; 13 of 20 sets of recordings got a false hand."""
    time = 0.005 * np.arange(200)
    angle = np.radians(20.0 * np.exp(-2.0 * time) * np.cos(2 * np.pi * 3.0 * time))
    angle = (angle + np.radians(0.1) * np.random.default_rng(1).normal(size=200))[:, None]
    assert not lost_samples(time, angle).any()
    angle[at] += np.radians(height)
    assert np.flatnonzero(lost_samples(time, angle)[:, 0]).tolist() == [at]


def test_lost_samples_are_bridged_and_a_hole_is_marked() -> None:
    time = np.arange(0, 1, 0.002)
    angle = swing(time)
    lost = np.zeros_like(angle, dtype=bool)
    lost[[50, 51, 120]] = True
    lost[300:310] = True
    broken = np.where(lost, np.nan, angle)
    found = smooth(time, broken, lost)
    np.testing.assert_allclose(found.angle[:290], angle[:290], atol=5e-4)
    assert found.gap[300:310].all()
    assert not found.gap[:299].any()
    assert not found.gap[311:].any()  # its edges may count, two lost samples do not make a hole


def test_uneven_times_are_resampled_evenly() -> None:
    generator = np.random.default_rng(8)
    time = np.arange(0, 1, 0.002) + np.r_[0, generator.uniform(-4e-4, 4e-4, 498), 0]
    found = smooth(time, swing(time), np.zeros((500, 1), dtype=bool))
    np.testing.assert_allclose(np.diff(found.time), np.median(np.diff(time)), rtol=1e-9)
    np.testing.assert_allclose(found.angle, swing(found.time), atol=3e-4)


def test_too_few_samples_are_refused() -> None:
    with pytest.raises(ValueError, match="at least 7"):
        smooth(np.arange(6) * 0.01, np.zeros((6, 1)), np.zeros((6, 1), dtype=bool))
    lost = np.zeros((50, 2), dtype=bool)
    lost[5:, 1] = True
    with pytest.raises(ValueError, match="joint 1: 5 good samples"):
        smooth(np.arange(50) * 0.01, np.zeros((50, 2)), lost)


@pytest.mark.parametrize("noise", [0.0, 1.7e-4])
def test_samples_beside_lost_frames_are_no_outliers_but_a_spike_is(noise: float) -> None:
    """Frames lost from the clock, or without a value: the neighbours of the samples beside are not equally far."""
    generator = np.random.default_rng(7)
    time = np.arange(0, 2, 0.004)
    angle = swing(time) + generator.normal(0, 1, (len(time), 1)) * noise
    for kept in (
        generator.random(500) > 0.1,
        ~np.isin(np.arange(500), [*range(40, 45), 1, 498]),
        np.arange(500) % 10 > 0,
    ):
        assert not lost_samples(time[kept], angle[kept]).any()
        assert not lost_samples(time, np.where(kept[:, None], angle, np.nan))[kept].any()
        row = int(np.argmax(np.diff(time[kept][30:]) > 0.006)) + 30  # before a gap
        spoilt = angle[kept]
        spoilt[row] += 0.2
        assert np.flatnonzero(lost_samples(time[kept], spoilt)).tolist() == [row]


def test_a_series_of_which_lone_spikes_leave_a_few_samples_is_searched_for_lost_ones() -> None:
    """The search for runs of lost samples needed more samples than were left, and ended in a traceback."""
    draws = np.random.default_rng(0)
    for count in range(7, 12):
        for _ in range(200):
            time = np.cumsum(draws.choice([0.004, 0.01, 0.02], count))
            angle = draws.normal(0.0, 0.01, (count, 1))
            angle[draws.random((count, 1)) < 0.2] += 3.0
            lost = lost_samples(time, angle)
            assert lost.shape == angle.shape
            assert not lost.all()
