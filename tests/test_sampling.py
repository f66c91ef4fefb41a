"""The sample step of channels that share a table of times, and which empty cells are missing samples."""

from __future__ import annotations

import numpy as np
import pytest

from synth.sampling import channel_step, densest_clock, own_moments, usual_step

STEP, COUNT = 0.005, 200
FRAMES = STEP * np.arange(COUNT)


@pytest.mark.parametrize("apart", [1e-5, 1e-4, 1e-3, 2.5e-3, 4.9e-3])
def test_two_channels_a_moment_apart_have_their_own_step_and_miss_nothing(apart: float) -> None:
    time = np.sort(np.r_[FRAMES, FRAMES + apart])
    known = np.zeros((2 * COUNT, 2), dtype=bool)
    known[::2, 0] = known[1::2, 1] = True
    assert usual_step(time, known) == pytest.approx(STEP)
    np.testing.assert_array_equal(own_moments(time, known), known)
    np.testing.assert_allclose(densest_clock(time, own_moments(time, known)), FRAMES)
    lost = known.copy()
    lost[100, 0] = False  # a sample that is missing beside one of the other channel
    moments = own_moments(time, lost)
    assert (moments & ~lost).sum() == 1


def test_empty_cells_of_one_clock_are_missing_samples() -> None:
    known = np.random.default_rng(1).random((COUNT, 3)) > 0.3
    jitter = FRAMES + np.random.default_rng(2).uniform(-0.2, 0.2, COUNT) * STEP
    for time in (FRAMES, jitter):
        assert own_moments(time, known).all()
        np.testing.assert_array_equal(densest_clock(time, own_moments(time, known)), time)
        assert usual_step(time, known) == channel_step(time, known[:, 0]) == np.median(np.diff(time))


def test_a_slower_channel_misses_nothing_between_its_samples() -> None:
    known = np.ones((COUNT, 2), dtype=bool)
    known[:, 1] = np.arange(COUNT) % 5 == 0
    np.testing.assert_array_equal(own_moments(FRAMES, known)[: COUNT - 2], known[: COUNT - 2])
    assert channel_step(FRAMES, known[:, 1]) == pytest.approx(5 * STEP)
    assert usual_step(FRAMES, known) == pytest.approx(STEP)


def test_without_two_samples_of_a_channel_the_rows_count() -> None:
    known = np.zeros((COUNT, 1), dtype=bool)
    assert np.isnan(channel_step(FRAMES, known[:, 0]))
    assert usual_step(FRAMES, known) == pytest.approx(STEP)
