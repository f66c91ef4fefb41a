"""The peer engine itself against closed forms, before anything is compared with it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import ellipk

from peers.mujoco_leg import curve_torque, mechanical_energy, simulate, simulate_states, with_tip_mass
from synth.swing.leg_model import Damper, DamperCurve, Joint, Leg, Link, Spring

LINK = Link(length=0.2, mass=0.74, com=0.091, inertia=3.5e-3)


def pendulum(**joint: object) -> Leg:
    return Leg("pendulum", (Joint("hip", LINK, **joint),))  # type: ignore[arg-type]


def three_links(rate: float = 0.0) -> Leg:
    """Unequal links, one reversed joint, springs."""
    links = (LINK, Link(0.16, 0.31, 0.07, 9e-4), Link(0.11, 0.12, 0.05, 2e-4))
    springs = (Spring(4.0, math.radians(100)), Spring(1.5, math.radians(150)), Spring(0.5, math.radians(160)))
    zeros = (math.radians(90), math.pi, math.pi)
    joints = zip(("hip", "knee", "ankle"), links, zeros, (1, 1, -1), springs, strict=True)
    damper = Damper(rate=rate) if rate else None
    return Leg("leg", tuple(Joint(name, link, zero, sign, None, k, damper) for name, link, zero, sign, k in joints))


def zero_crossings(times: NDArray[np.float64], angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Times at which the angle changes sign, by cubic interpolation."""
    from scipy.interpolate import CubicSpline

    return np.asarray(CubicSpline(times, angle).roots(extrapolate=False))


@pytest.mark.parametrize("amplitude", [0.02, 1.0, 2.8])
def test_pendulum_period_is_the_elliptic_integral(amplitude: float) -> None:
    # T = 4 sqrt(I/(m g c)) K(sin(a/2)); Landau & Lifshitz, Mechanics, section 11, problem 1
    about_hinge = LINK.inertia + LINK.mass * LINK.com**2
    period = 4 * math.sqrt(about_hinge / (LINK.mass * 9.81 * LINK.com)) * ellipk(math.sin(amplitude / 2) ** 2)
    times = np.arange(0.0, 2.2 * period, 1e-3)
    crossings = zero_crossings(times, simulate(pendulum(), [amplitude], [0.0], times, step=2e-4)[:, 0])
    assert crossings[2] - crossings[0] == pytest.approx(period, rel=1e-8)


def test_in_a_tilted_base_a_link_settles_straight_down() -> None:
    # absolute rotation = tilt + q = 0
    times = np.linspace(0.0, 60.0, 601)
    settled = simulate(pendulum(damper=Damper(rate=0.05)), [0.4], [0.0], times, tilt=math.radians(30), step=1e-3)
    assert settled[-1, 0] == pytest.approx(-math.radians(30), abs=1e-8)


def test_spring_rest_angle_follows_sign_and_zero() -> None:
    # without gravity the link settles at q = sign (free_angle - zero)
    joint = Joint("knee", LINK, math.pi, -1, None, Spring(2.0, math.radians(139)), Damper(rate=0.2))
    leg = Leg("one", (joint,), gravity=0.0)
    settled = simulate(leg, [0.0], [0.0], np.array([0.0, 4.0]), step=1e-3)
    assert settled[-1, 0] == pytest.approx(math.radians(180 - 139), abs=1e-8)


def test_damped_oscillation_without_gravity_is_the_textbook_one() -> None:
    rate, damping = 2.0, 0.05
    joint = Joint("knee", LINK, 0.0, 1, None, Spring(rate, 0.0), Damper(rate=damping))
    times = np.array([0.0, 0.0123, 0.2, 0.5001, 0.9])
    got = simulate(Leg("one", (joint,), gravity=0.0), [0.3], [0.0], times, step=1e-4)[:, 0]
    inertia = LINK.inertia + LINK.mass * LINK.com**2
    decay = damping / (2 * inertia)
    omega = math.sqrt(rate / inertia - decay**2)
    expected = 0.3 * np.exp(-decay * times) * (np.cos(omega * times) + decay / omega * np.sin(omega * times))
    np.testing.assert_allclose(got, expected, atol=1e-10)


def test_energy_is_kept_without_damping() -> None:
    leg = three_links()
    times = np.linspace(0.0, 3.0, 61)
    rotation, rate = simulate_states(leg, [0.5, -0.8, 0.4], [1.0, -2.0, 3.0], times, tilt=0.2, step=2e-4)
    energy = mechanical_energy(leg, rotation, rate, tilt=0.2)
    exchanged = np.ptp(mechanical_energy(leg, rotation, np.zeros_like(rate), tilt=0.2))
    assert np.ptp(energy) / exchanged < 1e-8


def test_halving_the_step_changes_less_than_1e_8_rad_and_sampling_does_not_matter() -> None:
    leg = three_links(rate=0.01)
    uneven = np.sort(np.concatenate([[0.0, 1.0], np.random.default_rng(1).uniform(0.0, 1.0, 37)]))
    start = ([0.5, -0.8, 0.4], [1.0, -2.0, 3.0])
    coarse = simulate(leg, *start, uneven, step=2e-4)
    fine = simulate(leg, *start, uneven, step=1e-4)
    assert np.abs(coarse - fine).max() < 1e-8
    only_ends = simulate(leg, *start, np.array([0.0, 1.0]), step=1e-4)
    np.testing.assert_allclose(only_ends[-1], fine[-1], atol=1e-8)


def test_locked_leg_is_one_compound_pendulum() -> None:
    links = [LINK, Link(0.16, 0.31, 0.07, 9e-4)]
    leg = Leg("two", (Joint("hip", links[0]), Joint("knee", links[1])))
    rigid_mass = links[0].mass + links[1].mass
    reach = links[0].length + links[1].com
    com = (links[0].mass * links[0].com + links[1].mass * reach) / rigid_mass
    about_hinge = links[0].inertia + links[0].mass * links[0].com ** 2 + links[1].inertia + links[1].mass * reach**2
    rigid = Leg("one", (Joint("hip", Link(0.36, rigid_mass, com, about_hinge - rigid_mass * com**2)),))
    times = np.linspace(0.0, 2.0, 41)
    locked = simulate(leg, [0.7, 0.0], [0.5, 9.0], times, locked=[1])
    assert np.all(locked[:, 1] == 0.0)
    np.testing.assert_allclose(locked[:, 0], simulate(rigid, [0.7], [0.5], times)[:, 0], atol=1e-11)


def test_locked_at_an_angle_turns_the_link() -> None:
    # second link locked at 90 deg: at rest the centre of mass hangs under the hinge
    link = Link(0.2, 0.5, 0.1, 1e-3)
    leg = Leg("two", (Joint("hip", link, damper=Damper(rate=0.1)), Joint("knee", link)))
    settled = simulate(leg, [0.0, math.pi / 2], [0.0, 0.0], np.array([0.0, 40.0]), locked=[1], step=1e-3)
    # centre of mass in the first link's frame: (across, along) = (0.05, 0.15) m, so it turns back by atan(1/3)
    assert settled[-1, 0] == pytest.approx(-math.atan2(0.05, 0.15), abs=1e-9)


def test_tip_mass_changes_the_small_period_as_a_point_mass_does() -> None:
    heavy = with_tip_mass(LINK, 0.3)
    about_hinge = LINK.inertia + LINK.mass * LINK.com**2 + 0.3 * LINK.length**2
    assert heavy.inertia + heavy.mass * heavy.com**2 == pytest.approx(about_hinge, rel=1e-14)
    moment = LINK.mass * LINK.com + 0.3 * LINK.length
    period = 2 * math.pi * math.sqrt(about_hinge / (9.81 * moment))
    times = np.arange(0.0, 1.2 * period, 1e-3)
    crossings = zero_crossings(times, simulate(pendulum(), [1e-3], [0.0], times, tip_mass=0.3)[:, 0])
    assert 2 * (crossings[1] - crossings[0]) == pytest.approx(period, rel=1e-7)


def test_coulomb_friction_takes_the_amplitude_down_by_a_constant_a_half_swing() -> None:
    # amplitude falls by 2 T / k each half swing; Den Hartog, Mechanical Vibrations, section 8.7
    effects = {"coulomb_friction": {"torque": 0.02}}
    joint = Joint("knee", LINK, 0.0, 1, None, Spring(2.0, 0.0), None, effects)
    leg = Leg("one", (joint,), gravity=0.0)
    half = math.pi * math.sqrt((LINK.inertia + LINK.mass * LINK.com**2) / 2.0)
    got = simulate(leg, [0.5], [0.0], np.array([0.0, half, 2 * half]), friction_width=1e-4)[:, 0]
    np.testing.assert_allclose(got, [0.5, -(0.5 - 0.02), 0.5 - 0.04], atol=2e-6)
    with pytest.raises(ValueError, match="friction_width"):
        simulate(leg, [0.5], [0.0], np.array([0.0, half]))


def test_a_straight_curve_is_a_linear_damper() -> None:
    times = np.linspace(0.0, 1.0, 21)
    curve = Damper(curve=DamperCurve((0.5, 2.0, 4.0), (0.01, 0.04, 0.08)))
    bent = simulate(pendulum(damper=curve), [1.2], [0.0], times)
    np.testing.assert_allclose(bent, simulate(pendulum(damper=Damper(rate=0.02)), [1.2], [0.0], times), atol=1e-12)


def test_curve_is_odd_linear_between_points_and_beyond() -> None:
    curve = DamperCurve((1.0, 2.0), (0.4, 0.5))
    assert [curve_torque(curve, w) for w in (0.5, 1.5, 4.0, -1.5, 0.0)] == pytest.approx([0.2, 0.45, 0.7, -0.45, 0.0])
