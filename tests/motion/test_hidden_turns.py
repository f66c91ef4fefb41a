"""A gap over a turning point is no release; a hold that a gap hides is one."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from fit.simulated_legs import robot
from motion.driven_releases import free_motion
from synth.motion.hidden_turns import continues
from synth.motion.release import Release, find_release
from synth.swing.leg_model import Leg
from synth.swing.mechanics import outboard_inertia, rest_pose

Array = NDArray[np.float64]
RELEASED, STEP = 0.4, 0.005  # s
TIME = STEP * np.arange(500)


def swinging_leg() -> Leg:
    """Springs of 2 to 3 Hz and a damping ratio of 0.08, each joint as if alone."""
    inertia = outboard_inertia(robot())
    rate = inertia * (2 * np.pi * np.array([2.0, 2.5, 3.0])) ** 2
    return robot(rate, 0.16 * np.sqrt(rate * inertia))


def held_and_released(leg: Leg) -> Array:
    """(n, 3) rad, rotations of a leg that is held and let go at ``RELEASED``."""
    start = rest_pose(leg) + np.radians([30.0, -20.0, 10.0])
    rotation = np.tile(start, (len(TIME), 1))
    after = TIME > RELEASED
    rotation[after] = free_motion(leg, start, TIME[after] - RELEASED, 0.0)
    return rotation


def found(leg: Leg, rotation: Array, first: int, count: int) -> Release:
    """The release of a recording with 0.05 deg of noise and a gap of all joints."""
    angles = leg.to_measured(rotation)
    angles = angles + np.radians(np.random.default_rng(1).normal(0.0, 0.05, angles.shape))
    angles[first : first + count] = np.nan
    return find_release(TIME, angles, leg)


def test_gaps_over_turning_points_are_no_release() -> None:
    """75 and 100 ms, of swings of 0.5 s: where one hid a turning point, all before it was thrown away."""
    leg = swinging_leg()
    rotation = held_and_released(leg)
    for count in (15, 20):
        for first in range(105, 260, 5):
            release = found(leg, rotation, first, count)
            assert release.released == pytest.approx(RELEASED, abs=0.01), (count, first)
            assert release.not_before is None


def test_a_second_hold_within_a_gap_is_a_release() -> None:
    """Caught while it swings, held and let go again, all unseen: the second release counts, as before."""
    leg = swinging_leg()
    rotation = held_and_released(leg)
    caught, again = 170, 230
    start = rotation[caught]
    rotation[caught:] = start
    rotation[again:] = free_motion(leg, start, TIME[again:] - TIME[again] + 1e-9, 0.0)
    release = found(leg, rotation, caught - 2, again - caught + 6)
    assert release.not_before == pytest.approx(TIME[caught - 3])
    assert release.released == pytest.approx(TIME[again + 4])


def test_a_motion_continues_over_a_gap_only_where_both_sides_tell() -> None:
    time = 0.005 * np.arange(100)
    swing = np.cos(2 * np.pi * 2.0 * (time - 0.25))[:, None]  # turns at 0.25 s
    lost = np.zeros(swing.shape, dtype=bool)
    gap = slice(43, 58)
    lost[gap] = True
    stop = float(time[42]), float(time[58])
    assert continues(time, swing, lost, stop, np.array([1e-3]))
    later = swing.copy()
    later[58:] = np.roll(swing, 30, axis=0)[58:]  # of a hold of 150 ms
    assert not continues(time, later, lost, stop, np.array([1e-3]))
    lost[:40] = True
    assert not continues(time, swing, lost, stop, np.array([1e-3]))
