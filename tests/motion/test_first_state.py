"""The state that the first samples show: exact on cubics, its deviation holds on noisy and on curved motion."""

from __future__ import annotations

import numpy as np
import pytest

from synth.estimation.intervals import NORMAL90
from synth.motion.first_state import first_state


def test_a_cubic_is_read_exactly_lost_samples_and_uneven_steps_too() -> None:
    generator = np.random.default_rng(1)
    time = np.sort(generator.uniform(0.0, 0.5, 60))
    since = time - time[0]
    angle = np.stack([0.3 - 2.0 * since + 5.0 * since**3, 1.0 + 0.0 * since], axis=1)
    counts = generator.random(angle.shape) > 0.2
    found = first_state(time, np.where(counts, angle, 7.0), counts, np.zeros(2))
    assert found.angle == pytest.approx([0.3, 1.0], abs=1e-9)
    assert found.rate == pytest.approx([-2.0, 0.0], abs=1e-6)
    assert found.angle_deviation[1] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("frequency", [2.0, 8.0])
@pytest.mark.parametrize("sampling", [100.0, 1000.0])
def test_the_deviation_holds_noise_and_bias_of_a_swing(frequency: float, sampling: float) -> None:
    """Within two deviations in more than nine of ten, over phases of a damped swing with 0.1 deg of noise."""
    generator = np.random.default_rng(2)
    time, noise, hits = np.arange(0.0, 0.5, 1.0 / sampling), np.radians(0.1), []
    for _ in range(200):
        pole = 2 * np.pi * frequency * (-0.2 + 1j) * generator.uniform(0.7, 1.3)
        swing = np.radians(20) * np.exp(1j * generator.uniform(0, 2 * np.pi))
        angle = np.real(swing * np.exp(pole * time))[:, None] + generator.normal(0, noise, (len(time), 1))
        found = first_state(time, angle, np.ones_like(angle, dtype=bool), np.array([noise]))
        off = np.real(swing) - found.angle[0], np.real(swing * pole) - found.rate[0]
        hits.append([abs(off[0]) < 2 * found.angle_deviation[0], abs(off[1]) < 2 * found.rate_deviation[0]])
    assert np.mean(hits, axis=0).min() > 0.9


def test_the_deviation_grows_where_the_first_good_sample_comes_late() -> None:
    """Of 200 joints that settle in 30 ms, read from the third sample on, 2 lie outside 90 %; 9 before."""
    generator, time, off = np.random.default_rng(2), np.arange(0.0, 0.5, 0.005), []
    for _ in range(200):
        decay = 1.0 / generator.uniform(0.02, 0.04)
        angle = np.radians(20.0) * ((1.0 + decay * time) * np.exp(-decay * time))[:, None]
        noisy = angle + generator.normal(0.0, np.radians(0.05), angle.shape)
        counts = (generator.random(angle.shape) > 0.3) & (time > 0.007)[:, None]
        found = first_state(time, noisy, counts, np.array([np.radians(0.05)]))
        off.append(abs(found.angle[0] - angle[0, 0]) / found.angle_deviation[0])
    assert np.mean(np.array(off) > NORMAL90) < 0.02


def test_too_few_samples_give_no_state() -> None:
    time = np.arange(12) * 0.01
    counts = np.ones((12, 1), dtype=bool)
    counts[4:] = False
    found = first_state(time, np.zeros((12, 1)), counts, np.array([0.01]))
    assert np.isinf(found.angle_deviation[0])
    assert np.isinf(found.rate_deviation[0])


def test_joints_read_a_moment_apart_show_the_state_that_they_show_together() -> None:
    """The support is in samples of the joint: of the steps from row to row, 0.1 ms, it was a hundred times as many."""
    frames, noise = np.arange(0.0, 1.5, 0.005), np.radians(0.05)
    time = np.sort(np.r_[frames, frames + 1e-4])
    angle = np.radians(20.0) * np.cos(20.0 * time)[:, None] + [[0.0, 1.0]]
    angle += np.random.default_rng(3).normal(0.0, noise, angle.shape)
    counts = np.zeros(angle.shape, dtype=bool)
    counts[::2, 0] = counts[1::2, 1] = True
    apart = first_state(time, angle, counts, np.full(2, noise))
    alone = first_state(frames, angle[::2, :1], counts[::2, :1], np.full(1, noise))
    assert apart.angle[0] == alone.angle[0]
    assert apart.angle_deviation[0] == alone.angle_deviation[0]
    assert abs(apart.angle[1] - np.radians(20.0) - 1.0) < 2.0 * apart.angle_deviation[1]
    assert apart.angle_deviation[1] < 2.0 * alone.angle_deviation[0]
