"""Effects on the leg's numbers and on what the encoders tell: definitions, with signs and zeros."""

from __future__ import annotations

import numpy as np
import pytest

from fit.simulated_legs import robot
from synth.arrays import Array
from synth.swing.effects import effect_named
from synth.swing.leg_lanes import LegLanes

SHARES = np.array([0.0, 0.1, -0.2])


def changed(name: str, joint: int, sign: int, *values: Array) -> tuple[LegLanes, LegLanes]:
    before, legs = LegLanes.of(robot(), 3), LegLanes.of(robot(), 3)
    effect_named(name).function()(legs, joint, sign, *values)
    return before, legs


def test_a_heavier_link_has_its_inertia_in_proportion() -> None:
    before, legs = changed("link_mass", 1, 1, SHARES)
    for field in ("mass", "inertia"):
        np.testing.assert_allclose(getattr(legs, field)[1], getattr(before, field)[1] * (1 + SHARES))
        np.testing.assert_array_equal(getattr(legs, field)[[0, 2]], getattr(before, field)[[0, 2]])
    np.testing.assert_array_equal(legs.com, before.com)


def test_link_inertia_moves_the_centre_and_scales_the_inertia_about_it() -> None:
    before, legs = changed("link_inertia", 2, -1, SHARES, 2 * SHARES, 0.5 * SHARES)
    np.testing.assert_allclose(legs.com[2], before.com[2] * (1 + SHARES))
    np.testing.assert_allclose(legs.inertia[2], before.inertia[2] * (1 + 2 * SHARES))
    np.testing.assert_allclose(legs.com_across[2], 0.5 * SHARES * before.length[2])
    np.testing.assert_array_equal(legs.mass, before.mass)


@pytest.mark.parametrize("sign", [1, -1])
def test_preload_shifts_the_free_angle_as_it_is_measured(sign: int) -> None:
    made = robot()
    made = made.with_joints(knee={"sign": sign})
    legs = LegLanes.of(made, 3)
    effect_named("spring_preload").function()(legs, 1, sign, SHARES)
    spring = made.joints[1].spring
    assert spring is not None
    for lane, shift in enumerate(SHARES):
        moved = made.with_joints(knee={"spring": type(spring)(spring.rate, spring.free_angle + shift)})
        np.testing.assert_allclose(legs.rest[1, lane], LegLanes.of(moved).rest[1, 0], atol=1e-15)


def test_base_tilt_adds_to_the_legs_own() -> None:
    before, legs = changed("base_tilt", 0, 1, SHARES)
    np.testing.assert_allclose(legs.tilt, before.tilt + SHARES)


def told(name: str, rotation: Array, sign: int, zero: float, *values: float, time: Array | None = None) -> Array:
    """The reading in measured angle of a joint at these rotations, one lane."""
    time = np.arange(len(rotation), dtype=float) if time is None else time
    rate = np.gradient(rotation, time)
    wide = [np.array([value]) for value in values]
    read = effect_named(name).function()(time, rotation[:, None], rate[:, None], sign, zero, *wide)
    return np.asarray(zero + sign * read[:, 0])


@pytest.mark.parametrize("sign", [1, -1])
def test_offset_scale_and_counts_act_on_the_measured_angle(sign: int) -> None:
    zero, rotation = 0.7, np.linspace(-1.0, 1.0, 41)
    angle = zero + sign * rotation
    np.testing.assert_allclose(told("encoder_offset", rotation, sign, zero, 0.02, 0.0), angle + 0.02)
    np.testing.assert_allclose(told("encoder_scale", rotation, sign, zero, 0.03, 0.0), 1.03 * angle, atol=1e-15)
    step = 0.1
    read = told("encoder_quantisation", rotation, sign, zero, step)
    np.testing.assert_allclose(read / step, np.round(read / step), atol=1e-9)
    assert np.abs(read - angle).max() <= step / 2 + 1e-12
    np.testing.assert_array_equal(told("encoder_quantisation", rotation, sign, zero, 0.0), angle)


def test_counts_err_by_a_step_over_the_root_of_twelve() -> None:
    # Widrow & Kollar, *Quantization Noise* (2008), ch. 1
    rotation = np.random.default_rng(0).uniform(-1, 1, 200_000)
    error = told("encoder_quantisation", rotation, 1, 0.3, 0.01) - 0.3 - rotation
    assert error.std() == pytest.approx(0.01 / np.sqrt(12), rel=0.01)


@pytest.mark.parametrize("delay", [0.003, 0.0173, 0.05])
def test_a_delayed_channel_reads_the_past_motion(delay: float) -> None:
    # a sinusoid on an uneven grid; cubic Hermite errs by h^4 w^4 / 384: 5e-7 for 10 ms at 12 rad/s
    time = np.unique(np.r_[0.0, 1.0, np.random.default_rng(2).uniform(0, 1, 300)])
    time = time[np.r_[True, np.diff(time) > 1e-4]]
    rotation, rate = np.sin(12 * time + 0.4), 12 * np.cos(12 * time + 0.4)
    read = effect_named("latency").function()
    got = read(time, rotation[:, None], rate[:, None], 1, 0.0, np.array([delay]), np.array([0.0]))[:, 0]
    late = time - delay >= 0.0
    widest = np.diff(time).max()
    limit = (12 * widest) ** 4 / 384
    assert np.abs(got - np.sin(12 * (time - delay) + 0.4))[late].max() < max(limit, 1e-9)
    assert limit < 1e-3


def test_before_the_release_a_delayed_channel_reads_rest() -> None:
    # released at t = 0 from rest: what was earlier is the release's angle
    time = np.linspace(0, 0.5, 501)
    rotation, rate = np.cos(8 * time), -8 * np.sin(8 * time)
    read = effect_named("latency").function()
    got = read(time, rotation[:, None], rate[:, None], 1, 0.0, np.array([0.02]), np.array([0.0]))[:, 0]
    np.testing.assert_allclose(got[:20], 1.0, atol=1e-3)
    np.testing.assert_allclose(got[21:], np.cos(8 * (time[21:] - 0.02)), atol=1e-6)


def test_a_filtered_channel_lags_as_a_first_order_filter_does() -> None:
    # r' = (q - r) / lag of a sinusoid: amplitude 1 / sqrt(1 + (w lag)^2), phase atan(w lag), once it has settled
    lag, omega, time = 0.03, 9.0, np.linspace(0, 3, 3001)
    rotation = np.sin(omega * time)
    read = effect_named("latency").function()
    got = read(time, rotation[:, None], np.gradient(rotation, time)[:, None], 1, 0.0, np.array([0.0]), np.array([lag]))
    settled = time > 1.0
    expected = np.sin(omega * time - np.arctan(omega * lag)) / np.hypot(1, omega * lag)
    np.testing.assert_allclose(got[settled, 0], expected[settled], atol=2e-5)


def test_readings_are_switched_off_by_their_strengths_alone() -> None:
    time = np.linspace(0, 1, 50)
    rotation = np.sin(5 * time)[:, None]
    rate = 5 * np.cos(5 * time)[:, None]
    for name in ("encoder_offset", "encoder_scale", "encoder_quantisation", "latency"):
        effect = effect_named(name)
        off = [np.array([0.0 if p.name in effect.strengths else p.off]) for p in effect.parameters]
        np.testing.assert_allclose(effect.function()(time, rotation, rate, -1, 0.4, *off), rotation, atol=1e-12)
