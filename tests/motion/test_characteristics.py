"""Response characteristics against the closed form of a second-order system released at rest."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import brentq

from synth.arrays import zero_crossings
from synth.motion.characteristics import CUT, NEAR_REST, characteristics
from synth.motion.rest import FROM_LEG, FROM_SWINGS, MOVES_AT_END

Array = NDArray[np.float64]
NATURAL = 20.0  # rad/s


def released(time: Array | float, ratio: float) -> Array:
    """Level of a release at rest from 1; Inman, Engineering Vibration, 4th ed., section 1.3."""
    t = np.asarray(time)
    if ratio < 1:
        damped = NATURAL * math.sqrt(1 - ratio**2)
        swing = np.cos(damped * t) + ratio * NATURAL / damped * np.sin(damped * t)
        return np.exp(-ratio * NATURAL * t) * swing
    if ratio == 1:
        return np.exp(-NATURAL * t) * (1 + NATURAL * t)
    root = NATURAL * math.sqrt(ratio**2 - 1)
    slow, fast = -ratio * NATURAL + root, -ratio * NATURAL - root
    return (fast * np.exp(slow * t) - slow * np.exp(fast * t)) / (fast - slow)


def times(ratio: float) -> Array:
    """(n,) s, until all has died away."""
    slowest = ratio if ratio < 1 else ratio - math.sqrt(ratio**2 - 1)
    return np.arange(0.0, 25.0 / (slowest * NATURAL), 5e-4)


def rise_time(ratio: float) -> float:
    first, last = (
        brentq(lambda t, level=level: float(released(t, ratio)) - level, 0, 3 * math.pi * max(1, ratio) / NATURAL / 2)
        for level in (0.9, 0.1)
    )
    return last - first


@pytest.mark.parametrize("ratio", [0.02, 0.1, 0.3, 0.5])
@pytest.mark.parametrize("amplitude", [0.4, -0.05])
def test_underdamped_release_shows_its_ratio_frequency_overshoot_and_times(ratio: float, amplitude: float) -> None:
    time = times(ratio)
    found = characteristics(time + 3.0, 1.2 + amplitude * released(time, ratio))
    assert found.validity.startswith("valid")
    assert found.amplitude == pytest.approx(amplitude, rel=1e-6)
    assert found.damping_ratio == pytest.approx(ratio, rel=2e-3)
    assert found.damped_frequency == pytest.approx(NATURAL * math.sqrt(1 - ratio**2), rel=1e-3)
    assert found.overshoot == pytest.approx(math.exp(-math.pi * ratio / math.sqrt(1 - ratio**2)), rel=1e-4)
    assert found.rise_time == pytest.approx(rise_time(ratio), rel=1e-4)
    outside = np.abs(released(time, ratio)) > 0.1
    assert found.settling_time == pytest.approx(time[np.flatnonzero(outside)[-1] + 1], abs=1e-9)


def test_a_ratio_from_one_half_cycle_is_marked() -> None:
    # exp(-pi 0.5/0.866) = 16 %, its square 2.7 %, its cube 0.4 %: two peaks above the least of 2 %
    found = characteristics(times(0.5), released(times(0.5), 0.5))
    assert found.validity == "valid, from one half cycle"


@pytest.mark.parametrize("ratio", [0.8, 1.0, 1.5, 4.0])
def test_well_damped_release_has_rise_time_but_no_ratio(ratio: float) -> None:
    time = times(ratio)
    found = characteristics(time, 0.3 * released(time, ratio))
    assert found.rise_time == pytest.approx(rise_time(ratio), rel=1e-3)
    assert found.damping_ratio is None
    assert found.damped_frequency is None
    assert found.validity == "fewer than two swings past rest"
    assert found.overshoot == pytest.approx(math.exp(-math.pi * 0.8 / 0.6) if ratio == 0.8 else 0.0, abs=1e-6)
    assert found.settling_time is not None


def test_noise_alone_is_no_swing() -> None:
    time = times(1.5)
    noise = np.random.default_rng(0).normal(0, 0.002, len(time))
    found = characteristics(time, 0.1 * released(time, 1.5) + noise, noise=0.002)
    assert found.damping_ratio is None


def test_dry_friction_decays_by_steps_and_is_called_doubtful() -> None:
    # Coulomb: half cycles lose the same amount each, not the same share; Inman, section 1.10
    pieces = [(1.0 - 0.2 * m - 0.1) for m in range(5)]
    half = np.linspace(0, 1, 200, endpoint=False)
    swing = np.concatenate([(-1) ** m * (a * np.cos(np.pi * half) + 0.1) for m, a in enumerate(pieces)])
    angle = np.r_[swing, np.zeros(2000)]
    found = characteristics(np.arange(len(angle)) / 200, angle)
    assert found.validity.startswith("doubtful")
    assert found.damping_ratio is not None


def test_growing_swings_have_no_ratio() -> None:
    time = np.linspace(0, 6 * math.pi, 3000)
    angle = np.r_[np.cos(time) * np.exp(0.05 * time), np.zeros(3000)]
    found = characteristics(np.arange(6000) / 1000, angle)
    assert (found.damping_ratio, found.validity) == (None, "the swings grow")


def test_a_motion_that_starts_at_rest_has_no_characteristics() -> None:
    time = np.linspace(0, 1, 200)
    found = characteristics(time, np.full(200, 0.7))
    assert found.validity == "starts at rest"
    assert (found.rise_time, found.damping_ratio, found.overshoot, found.settling_time) == (None,) * 4
    assert characteristics(time, 0.001 * np.exp(-9 * time), noise=0.002).validity == "starts at rest"


def test_a_recording_that_ends_while_it_moves_has_no_settling_time() -> None:
    time = np.arange(0.0, 1.5, 1e-3)
    assert characteristics(time, released(time, 0.02)).settling_time is None


def test_a_curve_that_only_touches_its_rest_has_no_swings() -> None:
    """Read in coarse counts an overdamped joint comes to rest exactly and never crosses it."""
    time = np.linspace(0.0, 1.0, 101)
    found = characteristics(time, np.round(8 * np.exp(-12 * time)) * 0.01)
    assert found.damping_ratio is None
    assert found.rise_time is not None
    assert found.validity == "fewer than two swings past rest"


@pytest.mark.parametrize("ratio", [0.03, 0.1, 0.2])
@pytest.mark.parametrize("periods", [1.3, 1.6, 2.1, 2.6])
def test_a_recording_that_ends_in_motion_is_measured_about_the_rest_that_its_swings_tell(
    ratio: float, periods: float
) -> None:
    """The mean of the last tenth is no rest: 1.3 periods at a ratio of 0.03 gave 0.107, at 0.2 0.36."""
    damped = NATURAL * math.sqrt(1 - ratio**2)
    time = np.arange(0.0, periods * 2 * math.pi / damped, 5e-4)
    found = characteristics(time, 0.7 - 0.3 * released(time, ratio))
    assert found.damping_ratio == pytest.approx(ratio, rel=5e-3)
    assert found.amplitude == pytest.approx(-0.3, rel=1e-3)
    assert found.overshoot == pytest.approx(math.exp(-math.pi * ratio / math.sqrt(1 - ratio**2)), abs=2e-3)
    assert found.rise_time == pytest.approx(rise_time(ratio), rel=2e-3)
    assert found.validity.startswith("valid")
    assert found.validity.endswith(FROM_SWINGS)


def test_without_enough_swings_rest_is_the_fitted_legs_or_unknown() -> None:
    """Started with speed: two extremes do not tell rest, but half a period."""
    damped = NATURAL * math.sqrt(1 - 0.1**2)
    time = np.arange(0.0, 1.2 * 2 * math.pi / damped, 5e-4)
    angle = 0.2 + np.exp(-0.1 * NATURAL * time) * np.cos(damped * time - 1.2)
    found = characteristics(time, angle)
    assert found.validity == MOVES_AT_END
    assert math.isnan(found.amplitude)
    assert (found.rise_time, found.damping_ratio, found.overshoot, found.settling_time) == (None,) * 4
    assert found.damped_frequency == pytest.approx(damped, rel=1e-3)
    known = characteristics(time, angle, equilibrium=0.2)
    assert known.validity.endswith(FROM_LEG)
    outside = characteristics(time, angle, equilibrium=3.0)
    assert outside.validity == MOVES_AT_END


def test_a_creeping_joint_has_no_rest_before_it_ends() -> None:
    time = np.arange(0.0, 0.2, 1e-3)
    found = characteristics(time, np.exp(-10 * time))
    assert found.validity == MOVES_AT_END
    assert (found.rise_time, found.damped_frequency, found.settling_time) == (None,) * 3
    assert characteristics(time, np.exp(-10 * time), equilibrium=0.0).rise_time is None  # not seen to the 10 %


def test_swings_of_two_modes_do_not_tell_rest() -> None:
    time = np.arange(0.0, 0.9, 1e-3)
    angle = np.exp(-time) * np.cos(20 * time) + 0.6 * np.exp(-0.5 * time) * np.cos(7 * time)
    assert characteristics(time, angle).validity == MOVES_AT_END


def test_a_cut_start_gives_no_time_and_share_that_need_the_start() -> None:
    """From just before a crossing on: the overshoot was 8.5 and the rise took 4 ms."""
    time = times(0.1)
    whole = released(time, 0.1)
    first = int(np.argmax(whole < 0.1))
    found = characteristics(time[first:], whole[first:], cut=True)
    assert (found.rise_time, found.overshoot, found.settling_time) == (None,) * 3
    assert found.damping_ratio == pytest.approx(0.1, rel=5e-3)
    assert found.validity == f"valid; {CUT}"
    assert abs(found.amplitude) == pytest.approx(np.abs(whole[first:]).max(), rel=1e-6)


@pytest.mark.parametrize("zero", [0.0, -0.0])
def test_a_crossing_on_a_sample_is_a_crossing(zero: float) -> None:
    """80 samples a second of 2 Hz: each crossing falls on a sample; closed form of the exponential envelope."""
    time = np.arange(0.0, 3.0, 0.0125)
    swing = np.exp(-time) * np.cos(4.0 * np.pi * time)
    found = characteristics(time, np.where(np.abs(swing) < 1e-12, zero, swing), rest=0.0)
    assert found.damping_ratio == pytest.approx(1.0 / math.hypot(1.0, 4.0 * np.pi), rel=0.01)
    assert found.damped_frequency == pytest.approx(4.0 * np.pi, rel=1e-3)
    beside = characteristics(time, swing + 1e-9, rest=0.0)
    assert found.damping_ratio == pytest.approx(beside.damping_ratio, rel=1e-6)
    assert found.validity == beside.validity == "valid"


@pytest.mark.parametrize(
    ("value", "crossings"),
    [
        ([1.0, -1.0, 2.0], [[0, 1], [1, 2]]),
        ([1.0, 0.0, -1.0, -0.0, -0.0, 3.0], [[0, 2], [2, 5]]),
        ([0.0, 1.0, 0.0, 2.0, -0.0, 1.0, 0.0], []),
        ([0.0, 0.0, -1.0, 1e-300, -0.0], [[2, 3]]),
        ([0.0, -0.0], []),
        ([], []),
    ],
)
def test_zero_samples_have_no_sign(value: list[float], crossings: list[list[int]]) -> None:
    assert zero_crossings(np.array(value)).tolist() == crossings


@pytest.mark.parametrize(("start", "near_rest"), [(0.05, True), (0.15, True), (0.3, False), (0.8, False)])
def test_a_swing_that_starts_near_rest_with_speed_is_said_to_be_one(start: float, near_rest: bool) -> None:
    """A recording from the middle of a swing: the overshoot is 13, the rise takes 11 ms, of a step of 1 deg.

    Joints that others move swing a few times as far as they start away, and have a rise time.
    """
    time = times(0.1)
    damped = NATURAL * math.sqrt(1 - 0.1**2)
    swing = np.exp(-0.1 * NATURAL * time) * np.cos(damped * time + math.acos(start))
    found = characteristics(time, swing)
    assert found.starts_near_rest == near_rest
    assert found.validity == (f"valid; {NEAR_REST}" if near_rest else "valid")
    assert None not in (found.rise_time, found.overshoot, found.settling_time)
    less = found.without_step()
    assert (less.rise_time, less.overshoot, less.settling_time) == (None, None, None)
    assert found.damping_ratio == less.damping_ratio == pytest.approx(0.1, rel=0.02)
    assert found.damped_frequency == pytest.approx(damped, rel=1e-3)
    assert not characteristics(time, swing, rest=0.0).starts_near_rest  # where the rest is asked for
