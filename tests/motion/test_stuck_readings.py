"""A sensor that drops out to one value is no motion; servos that step, stops and coarse counts do not drop out."""

import numpy as np
import pytest

from synth.motion.release import find_release
from synth.motion.smoothing import lost_samples
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

TIME = np.arange(0.0, 1.2, 0.005)


def swing(noise: float) -> np.ndarray:
    """Readings (n, 1) rad of a free swing about 105 deg, 240 samples."""
    angle = np.radians(105.0 + 25.0 * np.exp(-2.5 * TIME) * np.cos(2 * np.pi * 2.0 * TIME))
    return (angle + np.radians(noise) * np.random.default_rng(1).normal(size=len(TIME)))[:, None]


@pytest.mark.parametrize("noise", [0.0, 0.05])
@pytest.mark.parametrize("length", [4, 6, 12, 40])
@pytest.mark.parametrize("at", [30, 66, 150])
def test_a_sensor_that_drops_out_to_one_value_is_lost(length: int, noise: float, at: int) -> None:
    angle = swing(noise)
    angle[at : at + length] = 0.0
    np.testing.assert_array_equal(np.flatnonzero(lost_samples(TIME, angle)), np.arange(at, at + length))


@pytest.mark.parametrize(("noise", "at", "length"), [
    (0.0, 20, 4), (0.05, 20, 3), (0.05, 20, 4), (0.05, 20, 8), (0.05, 20, 12),
    (0.05, 45, 8),  # across the turning point at 0.25 s
    (0.05, 66, 6),
])  # fmt: skip
def test_readings_that_repeat_the_last_one_in_motion_are_lost(noise: float, at: int, length: int) -> None:
    """Of ``length`` equal ones the first was measured. A bus that holds for 15 to 60 ms looked like a hand."""
    angle = swing(noise)
    angle[at : at + length] = angle[at]
    np.testing.assert_array_equal(np.flatnonzero(lost_samples(TIME, angle)), np.arange(at + 1, at + length))


@pytest.mark.parametrize("rate", [50.0, 100.0, 200.0, 500.0])
def test_a_joint_that_leaves_a_stop_or_a_slow_sensor_repeats_nothing(rate: float) -> None:
    time = np.arange(0.0, 1.2, 1.0 / rate)
    angle = 25.0 * np.cos(2 * np.pi * 2.0 * time) + 6.0 * np.cos(2 * np.pi * 4.7 * time + 1.0)
    stopped = np.radians(np.clip(angle, -14.0, 17.0))
    every_third = np.radians(angle)[np.arange(len(time)) // 3 * 3]
    for read in (stopped, every_third):
        assert not lost_samples(time, read[:, None]).any()


def test_a_drop_out_is_no_release() -> None:
    """The recording begins in motion: the search found the release at the drop-out and 0.45 s of motion were cut."""
    knee = Joint("knee", zero=np.pi, sign=1, link=Link(0.22, 0.207, 0.075, 1.09e-3), spring=Spring(1.7, 1.9),
                 damper=Damper(rate=0.1))  # fmt: skip
    leg, angle = Leg("shank", joints=(knee,), gravity=9.81), swing(0.05)
    angle[100:108] = 0.0
    assert find_release(TIME, angle, leg).released is None


def square(rate: float, lag: float, count: float) -> np.ndarray:
    """Readings (n, 1) rad of a servo that follows a square wave of 1 Hz with a lag of so many s, in counts of deg."""
    time = np.arange(0.0, 3.8, 1.0 / rate)
    command = np.where(np.sin(2 * np.pi * (time - 0.3) - 0.1) > 0.0, 20.0, 0.0)  # no step beside an end
    angle = np.zeros_like(time)
    for k in range(1, len(time)):
        angle[k] = command[k] + (angle[k - 1] - command[k]) * np.exp(-1.0 / rate / lag)
    return np.radians(count * np.round(angle / count))[:, None]


@pytest.mark.parametrize("rate", [10.0, 20.0, 100.0])
@pytest.mark.parametrize("lag", [0.002, 0.02, 0.1])
def test_a_servo_that_steps_is_not_stuck(rate: float, lag: float) -> None:
    angle = square(rate, lag, 0.088)
    assert not lost_samples(np.arange(len(angle)) / rate, angle).any()


def test_a_stop_and_coarse_counts_are_not_stuck() -> None:
    assert not lost_samples(TIME, np.clip(swing(0.0), 1.6, 1.95)).any()
    assert not lost_samples(TIME, np.radians(0.4 * np.round(np.degrees(swing(0.05)) / 0.4))).any()


def test_a_channel_that_is_frozen_for_long_is_left_to_the_checks() -> None:
    """A hold is left out; a tenth of the recording is told of as frozen (``fit.plausibility``, ``gap --check``)."""
    whole = swing(0.0)
    for samples, lost in ((len(TIME) // 25, True), (len(TIME) // 10, False)):
        value = whole.copy()
        first = len(TIME) // 2
        value[first : first + samples] = value[first]
        assert lost_samples(TIME, value).any() == lost
