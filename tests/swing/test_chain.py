"""The compiled chain against closed forms: periods, energy, rest, known torques, lanes, and what it does when lost."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.special import ellipk

from fit.simulated_legs import DAMPER, SPRING, robot
from leg_energy import energy
from peers.mujoco_leg import mechanical_energy
from synth.swing.chain import Conditions, compiled_chain, simulate
from synth.swing.lane_layout import LANES, MOST_MEMORIES
from synth.swing.leg_model import Damper, DamperCurve, Joint, Leg, Link, Spring

LINK = Link(0.2, 0.74, 0.091, 3.5e-3)
ABOUT_HINGE = LINK.inertia + LINK.mass * LINK.com**2


def one_link(gravity: float = 9.81, **joint: object) -> Leg:
    return Leg("one link", (Joint("hip", LINK, **joint),), gravity=gravity)  # type: ignore[arg-type]


@pytest.mark.parametrize("amplitude", [1e-3, math.radians(120)])
def test_pendulum_period_is_the_elliptic_integral(amplitude: float) -> None:
    # T = 4 sqrt(I/(m g c)) K(sin(a/2)); Landau & Lifshitz, Mechanics, section 11, problem 1
    period = 4 * math.sqrt(ABOUT_HINGE / (LINK.mass * 9.81 * LINK.com)) * ellipk(math.sin(amplitude / 2) ** 2)
    times = np.arange(41) * period / 4  # ten periods; each quarter passes the bottom or turns
    angle = simulate(one_link(), [amplitude], [0.0], times, tolerance=1e-12)[:, 0]
    np.testing.assert_allclose(angle / amplitude, np.resize([1.0, 0.0, -1.0, 0.0], 41), atol=2e-8)


def test_small_spring_swing_is_the_textbook_one() -> None:
    # q = exp(-s t)(cos w t + s/w sin w t), without gravity exact at any amplitude
    leg = one_link(0.0, spring=Spring(2.0, 0.0), damper=Damper(0.05))
    times = np.linspace(0, 1, 50)
    decay = 0.05 / (2 * ABOUT_HINGE)
    omega = math.sqrt(2.0 / ABOUT_HINGE - decay**2)
    got = simulate(leg, [1.3], [0.0], times, tolerance=1e-11)[:, 0]
    expected = 1.3 * np.exp(-decay * times) * (np.cos(omega * times) + decay / omega * np.sin(omega * times))
    np.testing.assert_allclose(got, expected, atol=1e-9)


def undamped() -> Leg:
    return robot().with_joints(**{name: {"damper": None} for name in robot().joint_names})


def test_energy_is_kept_for_ten_seconds() -> None:
    """Within 1e-8 of the largest kinetic energy at tolerance 1e-11; by our sum and by one written link by link."""
    leg = undamped()
    times = np.linspace(0, 10, 200)
    start = lane(leg, [0.6, -1.6, 1.0], [0.0, 0.0, 0.0])[:, None]
    states = compiled_chain(3).run(start, times, 1e-11, rates=True, max_steps=100_000)[:, :, 0]
    rotation, rate = states[:, :3], states[:, 3:]
    ours, theirs = energy(leg, rotation, rate), mechanical_energy(leg, rotation, rate)
    np.testing.assert_allclose(ours - ours[0], theirs - theirs[0], atol=1e-12)
    kinetic = theirs - mechanical_energy(leg, rotation, np.zeros_like(rate))
    assert np.ptp(ours) < 1e-8 * kinetic.max()


def test_locked_as_one_link_it_swings_as_a_compound_pendulum() -> None:
    # the thesis' own check of its model: T = 2 pi sqrt(I/(M g d)) times the elliptic factor of the amplitude
    leg, held = undamped().with_joints(hip={"spring": None}), np.array([0.0, -1.1, 0.7])
    absolute = np.cumsum(held)
    hinge, masses, centres, own = np.zeros(2), [], [], 0.0
    for joint, turned in zip(leg.joints, absolute, strict=True):
        along = np.array([math.sin(turned), -math.cos(turned)])
        masses.append(joint.link.mass)
        centres.append(hinge + joint.link.com * along)
        own += joint.link.inertia
        hinge = hinge + joint.link.length * along
    mass, centre = np.array(masses), np.array(centres)
    inertia = own + float(mass @ (centre**2).sum(axis=1))
    of_all = mass @ centre / mass.sum()
    down = -math.atan2(of_all[0], -of_all[1])  # hip rotation with the centre of mass under the hip
    amplitude = 0.4
    period = 4 * math.sqrt(inertia / (mass.sum() * 9.81 * np.hypot(*of_all))) * ellipk(math.sin(amplitude / 2) ** 2)
    times = np.arange(9) * period / 4
    start = held + np.array([down + amplitude, 0, 0])
    swing = simulate(leg, start, [0.0, 5.0, 5.0], times, Conditions(locked=(1, 2)), tolerance=1e-12)
    expected = amplitude * np.resize([1.0, 0.0, -1.0, 0.0], 9)
    np.testing.assert_allclose(swing[:, 0] - down, expected, atol=1e-8)
    np.testing.assert_array_equal(swing[:, 1:], np.tile(held[1:], (9, 1)))


def test_constant_torque_shifts_the_rest_by_torque_over_rate() -> None:
    leg = one_link(0.0, spring=Spring(2.0, 0.1), damper=Damper(0.3))
    known = (np.array([0.0, 20.0]), np.full((2, 1), 0.5))
    settled = simulate(leg, [0.0], [0.0], np.array([0.0, 10.0]), known_torque=known, tolerance=1e-10)
    assert settled[-1, 0] == pytest.approx(0.1 + 0.5 / 2.0, abs=1e-8)


@pytest.mark.parametrize("curve", [False, True])
def test_a_sampled_torque_agrees_with_scipy(curve: bool) -> None:
    """A sine sampled at uneven times, linear between samples, alone and together with a damper curve."""
    damper = Damper(curve=DamperCurve((1.0, 3.0), (0.05, 0.08))) if curve else Damper(0.04)
    leg = one_link(spring=Spring(1.5, 0.2), damper=damper)
    moments = np.r_[0.0, np.sort(np.random.default_rng(1).uniform(0, 2, 30)), 2.0]
    torque = 0.8 * np.sin(7 * moments)

    def derivative(time: float, state: np.ndarray) -> list[float]:
        speed = abs(state[1])
        drag = np.interp(speed, [0.0, 1.0, 3.0], [0.0, 0.05, 0.08]) + 0.015 * max(speed - 3.0, 0.0)
        against = np.sign(state[1]) * drag if curve else 0.04 * state[1]
        gravity = LINK.mass * 9.81 * LINK.com * math.sin(state[0])
        total = np.interp(time, moments, torque) - 1.5 * (state[0] - 0.2) - against - gravity
        return [state[1], total / ABOUT_HINGE]

    times = np.linspace(0.0, 2.0, 41)
    expected = solve_ivp(derivative, (0, 2), [0.3, -1.0], "DOP853", times, rtol=1e-10, atol=1e-11, max_step=2e-3).y[0]
    got = simulate(leg, [0.3], [-1.0], times, known_torque=(moments, torque[:, None]), tolerance=1e-10)[:, 0]
    assert np.ptp(expected) > 0.5
    np.testing.assert_allclose(got, expected, atol=1e-6)


def lane(leg: Leg, rotation: list[float], rate: list[float]) -> np.ndarray:
    chain = compiled_chain(len(leg.joints))
    made = chain.parameters(leg)
    made[chain.layout.rows("rotation")], made[chain.layout.rows("rate")] = rotation, rate
    return made


def test_37_lanes_equal_37_single_runs() -> None:
    generator = np.random.default_rng(5)
    times = np.linspace(0, 1, 21)
    legs = [robot(SPRING * f, DAMPER * f, generator.uniform(90, 140, 3)) for f in generator.uniform(0.6, 1.4, 37)]
    lanes = np.stack([lane(leg, [0.3, -1.0, 0.7], [1.0, 0.0, -2.0]) for leg in legs], axis=1)
    chain = compiled_chain(3)
    together = chain.run(lanes, times, 1e-10, rates=True)
    alone = np.concatenate([chain.run(lanes[:, i : i + 1], times, 1e-10, rates=True) for i in range(37)], axis=2)
    assert together.shape == (21, 6, 37)
    assert np.ptp(together[-1], axis=1).min() > 1e-3
    np.testing.assert_allclose(together, alone, atol=2e-8)
    np.testing.assert_array_equal(chain.run(lanes, times, 1e-10), together[:, :3])


def test_groups_of_lanes_in_one_run_equal_runs_of_their_own() -> None:
    """To the last bit, with and without an effect: each group has its own steps, and only the effects of its lanes."""
    chain, times = compiled_chain(3), np.linspace(0, 1, 21)
    rubbing = robot().with_joints(knee={"effects": {"coulomb_friction": {"torque": 0.05}}})
    legs = [robot(SPRING * f) for f in (1.0, 1.1, 0.9)] + [rubbing, rubbing] + [robot(DAMPER * f) for f in (1.0, 2.0)]
    lanes = np.stack([lane(leg, [0.3, -1.0, 0.7], [1.0, 0.0, -2.0]) for leg in legs], axis=1)
    groups = chain.acting.groups(lanes, [3, 5])
    together = chain.run(groups, times, 1e-8)
    apart = [chain.run(group, times, 1e-8) for group in np.split(lanes, [3, 5], axis=1)]
    np.testing.assert_array_equal(together, np.concatenate(apart, axis=2))
    assert np.ptp(together[-1], axis=1).min() > 1e-3


@pytest.mark.parametrize("friction", [0.0, 0.05])
def test_many_groups_give_what_each_gives_alone(friction: float) -> None:
    """More lanes than are copied at once, in groups of sixteen and of other widths; the last group is not full."""
    chain, times, count = compiled_chain(3), np.linspace(0, 1, 11), 9 * LANES + 5
    leg = robot().with_joints(knee={"effects": {"coulomb_friction": {"torque": friction}}}) if friction else robot()
    lanes = np.repeat(lane(leg, [0.3, -1.0, 0.7], [1.0, 0.0, -2.0])[:, None], count, axis=1)
    lanes[chain.layout.row("spring_rate")] *= np.linspace(0.7, 1.4, count)
    firsts = list(range(LANES, count, LANES))
    apart = [chain.run(group, times, 1e-6, rates=True) for group in np.split(lanes, firsts, axis=1)]
    np.testing.assert_array_equal(chain.run(lanes, times, 1e-6, rates=True), np.concatenate(apart, axis=2))
    uneven = [3, 19, 20, 31, 47, 60, 76, 80, 96, 112, 128, 140]
    apart = [chain.run(group, times, 1e-6) for group in np.split(lanes, uneven, axis=1)]
    groups = chain.acting.groups(lanes, uneven)
    np.testing.assert_array_equal(chain.run(groups, times, 1e-6), np.concatenate(apart, axis=2))


def test_the_integrator_without_effects_moves_the_leg_as_the_one_with_all_of_them() -> None:
    chain, times = compiled_chain(3), np.linspace(0, 1, 21)
    one = np.repeat(lane(robot(), [0.3, -1.0, 0.7], [1.0, 0.0, -2.0])[:, None], 17, axis=1)
    one[chain.layout.row("spring_rate")] *= np.linspace(1.0, 1.2, 17)
    plain = chain.run(one, times, 1e-8, rates=True)
    nothing = (np.array([0.0, 1.0]), np.zeros((2, 3)))  # a known torque of nothing asks for the whole integrator
    whole = chain.run(one, times, 1e-8, rates=True, known_torque=nothing)
    np.testing.assert_allclose(plain, whole, atol=1e-11)


def test_too_many_memories_are_refused() -> None:
    chain = compiled_chain(3)
    with pytest.raises(ValueError, match="can hold 56"):
        chain.acting._rows((("coulomb_friction", 0),) * (MOST_MEMORIES + 1))


def test_lanes_that_are_alike_give_the_same_bits() -> None:
    one = lane(robot(), [0.3, -1.0, 0.7], [0.0, 0.0, 0.0])[:, None]
    times = np.linspace(0, 1, 11)
    many = compiled_chain(3).run(np.repeat(one, 19, axis=1), times)
    np.testing.assert_array_equal(many, np.repeat(compiled_chain(3).run(one, times), 19, axis=2))


@settings(max_examples=30, deadline=None)
@given(st.lists(st.floats(1e-3, 0.999), max_size=30, unique=True))
def test_the_sample_times_do_not_change_the_motion(inner: list[float]) -> None:
    times = np.array([0.0, *sorted(inner), 1.0])
    marks = np.linspace(0, 1, 5)
    both = np.union1d(times, marks)
    leg, start = robot(), [0.3, -1.0, 0.7]
    sparse, full = simulate(leg, start, [0.0] * 3, marks), simulate(leg, start, [0.0] * 3, both)
    np.testing.assert_allclose(full[np.searchsorted(both, marks)], sparse, atol=1e-12)


def test_dense_output_is_as_accurate_as_the_steps() -> None:
    times = np.linspace(0, 1, 1001)
    leg, start, rate = robot(), [0.3, -1.0, 0.7], [1.0, -3.0, 5.0]
    exact = simulate(leg, start, rate, times, tolerance=1e-12, rates=True)
    for tolerance in (1e-5, 1e-7, 1e-9):
        error = np.abs(simulate(leg, start, rate, times, tolerance=tolerance, rates=True) - exact).max(axis=0)
        assert error[:3].max() < 10 * tolerance
        assert error[3:].max() < 300 * tolerance


def test_too_many_steps_give_nan() -> None:
    chain, one = compiled_chain(3), lane(robot(), [0.3, -1.0, 0.7], [0.0, 0.0, 0.0])[:, None]
    times = np.linspace(0, 1, 101)
    cut = chain.run(one, times, 1e-8, max_steps=20)[:, 0, 0]
    whole = chain.run(one, times, 1e-8)[:, 0, 0]
    reached = int(np.argmax(np.isnan(cut)))
    assert 0 < reached < 101
    assert np.isnan(cut[reached:]).all()
    np.testing.assert_array_equal(cut[:reached], whole[:reached])


@pytest.mark.parametrize("damper", [Damper(1e9), Damper(float("nan"))])
def test_a_leg_too_stiff_to_integrate_raises(damper: Damper) -> None:
    with pytest.raises(ArithmeticError, match="diverged or is too stiff"):
        simulate(one_link(damper=damper), [0.5], [0.0], np.linspace(0, 1, 5))
