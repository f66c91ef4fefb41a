"""Suggested commands stay within their limits."""

from __future__ import annotations

import numpy as np
import pytest

from synth.diagnosis.plants.swinging_chain.command_menu import CommandLimits
from synth.diagnosis.plants.swinging_chain.command_programme import Programme
from synth.diagnosis.plants.swinging_chain.command_shapes import RATE, shapes

LENGTH = 6.0  # s


@pytest.mark.parametrize("what", list(shapes(LENGTH)))
@pytest.mark.parametrize("speed", [0.8, 6.0])
def test_no_shape_leaves_the_range_or_is_too_fast(what: str, speed: float) -> None:
    limits = CommandLimits(np.array([-0.4]), np.array([1.0]), np.array([speed]), np.array([np.inf]))
    time = np.arange(0.0, LENGTH, 1.0 / RATE)
    command = limits.shaped(shapes(LENGTH)[what], time)
    assert command.min() >= -0.4 - 1e-12
    assert command.max() <= 1.0 + 1e-12
    assert np.abs(np.diff(command, axis=0)).max() * RATE <= speed * (1.0 + 1e-9)
    assert np.ptp(command) > 0.1 * 1.4  # and it moves


def test_a_programme_takes_its_levels_and_its_variations_are_neighbours() -> None:
    levels, dwell = np.array([[0.5], [-0.5], [0.0]]), np.ones((3, 1))
    stepped = np.array([[True], [True], [False]])
    plain = Programme(levels, dwell, stepped)
    time = np.arange(0.0, 3.0 + 1e-9, 0.01)
    made = plain.shape(time)[:, 0]
    np.testing.assert_allclose(made[time < 0.99], 0.5)
    np.testing.assert_allclose(made[(time > 1.01) & (time < 1.99)], -0.5)
    assert made[np.argmin(np.abs(time - 2.5))] == pytest.approx(-0.25)  # half way up the ramp
    rng = np.random.default_rng(1)
    near = [np.abs(plain.varied(rng).shape(time)[:, 0] - made).mean() for _ in range(50)]
    far = [np.abs(Programme.drawn(rng, 1, 3.0).shape(time)[:, 0] - made).mean() for _ in range(50)]
    assert 0.0 < np.mean(near) < 0.7 * np.mean(far)
    assert all(np.abs(Programme.drawn(rng, 2, 3.0).shape(time)).max() <= 1.0 for _ in range(50))
