"""The chain's mechanics in plain numpy: rest poses, momentum, mass matrix, against what does not use them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from fit.simulated_legs import LINKS, robot
from leg_energy import energy
from peers.mujoco_leg import mechanical_energy, with_tip_mass
from synth.swing.chain import Conditions, simulate
from synth.swing.leg_model import Joint, Leg, Link, Spring
from synth.swing.mechanics import (
    coefficients,
    mass_matrix,
    momentum_and_force,
    outboard_inertia,
    rest_pose,
    static_torque,
)

angles = st.lists(st.floats(-3, 3), min_size=3, max_size=3)


def potential(leg: Leg, rotation: np.ndarray) -> float:
    return float(mechanical_energy(leg, rotation[None, :], np.zeros((1, len(rotation))))[0])


def slopes(function: object, at: np.ndarray, step: float = 1e-6) -> np.ndarray:
    """Central differences of a scalar function."""
    moves = step * np.eye(len(at))
    return np.array([(function(at + m) - function(at - m)) / (2 * step) for m in moves])  # type: ignore[operator]


def test_rest_pose_is_where_a_damped_leg_stops() -> None:
    leg, start = replace(robot(), tilt=0.3), [0.5, -1.5, 1.0]
    stopped = simulate(leg, start, [0.0] * 3, np.array([0.0, 40.0]), tolerance=1e-9)[-1]
    np.testing.assert_allclose(rest_pose(leg), stopped, atol=1e-7)
    loaded = simulate(leg, start, [0.0] * 3, np.array([0.0, 40.0]), Conditions(tip_mass=0.2), tolerance=1e-9)[-1]
    assert np.abs(loaded - stopped).max() > 0.05
    np.testing.assert_allclose(rest_pose(leg, tip_mass=0.2), loaded, atol=1e-7)


@settings(max_examples=40, deadline=None)
@given(st.lists(st.floats(60, 200), min_size=3, max_size=3), st.floats(0.5, 3.0))
def test_at_rest_gravity_and_springs_balance(free: list[float], stiffer: float) -> None:
    leg = robot(free_angle=free, spring=np.array([23.7, 1.7, 0.45]) * stiffer)
    rest = rest_pose(leg)
    np.testing.assert_allclose(slopes(lambda q: potential(leg, q), rest), 0.0, atol=1e-8)


def test_one_link_rests_where_its_torque_equation_says() -> None:
    link = Link(0.2, 0.74, 0.091, 3.5e-3)
    leg = Leg("one", (Joint("hip", link, math.pi, -1, None, Spring(1.2, math.radians(120))),), tilt=0.2)
    unloaded = math.radians(60)
    root = brentq(lambda q: 1.2 * (q - unloaded) + 0.74 * 9.81 * 0.091 * math.sin(0.2 + q), -2, 2, xtol=1e-14)
    assert rest_pose(leg)[0] == pytest.approx(root, abs=1e-12)


def test_the_rest_pose_is_found_from_afar_with_weak_springs() -> None:
    soft = robot(spring=[1e-3, 1e-3, 1e-3])
    found = rest_pose(soft, start=np.array([1.2, -2.0, 2.0]))
    np.testing.assert_allclose(slopes(lambda q: potential(soft, q), found), 0.0, atol=1e-8)


def test_without_springs_and_gravity_every_pose_is_an_equilibrium() -> None:
    leg = robot(gravity=0.0).with_joints(**{name: {"spring": None} for name in robot().joint_names})
    np.testing.assert_array_equal(rest_pose(leg, start=np.array([0.3, -0.2, 0.1])), [0.3, -0.2, 0.1])


@settings(max_examples=40, deadline=None)
@given(angles, angles, st.floats(0, 0.5), st.sampled_from([0.0, 0.05]))
def test_energy_momentum_and_force_agree_with_sums_over_links(
    q: list[float], w: list[float], tip: float, beside: float
) -> None:
    """S = dL/dw and R = dL/dq outboard of each joint, by differences of kinetic and potential energy link by link."""
    own = [replace(link, com_across=beside * sign) for link, sign in zip(LINKS, (1.0, -0.7, 0.4), strict=True)]
    leg = replace(robot(), tilt=0.3)
    leg = replace(leg, joints=tuple(replace(j, link=link) for j, link in zip(leg.joints, own, strict=True)))
    rotation, rate = np.array(q), np.array(w)
    plain = leg.with_joints(**{name: {"spring": None} for name in leg.joint_names})
    links = [*own[:2], with_tip_mass(own[2], tip)]
    heavy = replace(plain, joints=tuple(replace(j, link=link) for j, link in zip(plain.joints, links, strict=True)))

    def lagrangian(q: np.ndarray, w: np.ndarray) -> float:
        both = mechanical_energy(heavy, q[None, :], w[None, :])[0]
        at_rest = mechanical_energy(heavy, q[None, :], np.zeros((1, 3)))[0]
        return float(both - 2 * at_rest)

    found = coefficients(leg, tip)
    momentum, force = momentum_and_force(found, rotation[None], rate[None], leg.tilt)
    np.testing.assert_allclose(momentum[0], slopes(lambda w: lagrangian(rotation, w), rate), atol=1e-7)
    np.testing.assert_allclose(force[0], slopes(lambda q: lagrangian(q, rate), rotation), atol=1e-7)
    np.testing.assert_allclose(mass_matrix(found, rotation, leg.tilt) @ rate, momentum[0], atol=1e-12)
    with_springs = (
        energy(leg, rotation[None], rate[None], tip)[0] - energy(leg, 0 * rotation[None], 0 * rate[None], tip)[0]
    )
    sprung = replace(
        heavy, joints=tuple(replace(a, spring=b.spring) for a, b in zip(heavy.joints, leg.joints, strict=True))
    )
    at_zero = mechanical_energy(sprung, np.zeros((1, 3)), np.zeros((1, 3)))[0]
    assert with_springs == pytest.approx(mechanical_energy(sprung, rotation[None], rate[None])[0] - at_zero, abs=1e-9)


@settings(max_examples=20, deadline=None)
@given(angles)
def test_static_torque_is_the_slope_of_gravity_energy(q: list[float]) -> None:
    leg = replace(robot(), tilt=-0.2).with_joints(**{name: {"spring": None} for name in robot().joint_names})
    torque = static_torque(coefficients(leg), np.array(q), leg.tilt)
    np.testing.assert_allclose(torque, slopes(lambda r: potential(leg, r), np.array(q)), atol=1e-8)


def test_outboard_inertia_of_a_straight_leg_by_parallel_axes() -> None:
    reach = np.array([0.0, 0.222, 0.442])  # of each hinge from the hip, straight
    expected = []
    for first in range(3):
        distance = reach + np.array([link.com for link in LINKS]) - reach[first]
        outboard = range(first, 3)
        tip = 0.1 * (0.602 - reach[first]) ** 2
        expected.append(tip + sum(LINKS[i].inertia + LINKS[i].mass * distance[i] ** 2 for i in outboard))
    np.testing.assert_allclose(outboard_inertia(robot(), 0.1), expected, rtol=1e-12)


@pytest.mark.parametrize(("tilt", "com"), [(0.0, -0.06), (math.pi, 0.06), (math.radians(179.0), 0.06), (0.0, 0.06)])
def test_a_link_without_spring_rests_below_its_joint(tilt: float, com: float) -> None:
    """Newton's method from the aligned pose ends where the link stands upright."""
    leg = Leg("one", (Joint("knee", Link(0.2, 0.2, com, 1e-3), 0.0),), tilt=tilt)
    hangs = -math.copysign(1.0, com) * math.cos(tilt + float(rest_pose(leg)[0]))
    assert hangs == pytest.approx(-1.0, abs=1e-12)


@settings(max_examples=40, deadline=None)
@given(
    st.lists(st.tuples(st.floats(-0.1, 0.2), st.floats(0.05, 1.0), st.floats(-3, 1)), min_size=1, max_size=6),
    st.one_of(st.just(math.pi), st.floats(-3.2, 3.2)),
)
def test_every_rest_pose_is_a_minimum_of_energy(links: list[tuple[float, float, float]], tilt: float) -> None:
    """Of links with a centre of mass on either side, upright or not, springs of 1e-3 to 10 N m/rad."""
    joints = [Joint(f"j{k}", Link(0.2, mass, com, 1e-3), 0.0, 1, None, Spring(10.0**power, 0.0))
              for k, (com, mass, power) in enumerate(links)]  # fmt: skip
    leg = Leg("some", tuple(joints), tilt=tilt)
    rest = rest_pose(leg)
    here = potential(leg, rest)
    for way in np.random.default_rng(1).normal(size=(20, len(rest))):
        assert potential(leg, rest + 1e-3 * way) > here - 1e-10


def test_an_armature_s_energy_is_that_of_its_own_joint_s_rate() -> None:
    """A rotor turns with its joint and not with the links before it: half of it times the joint's rate squared."""
    leg = robot()
    geared = replace(leg, joints=tuple(replace(joint, armature=2e-3) for joint in leg.joints))
    rotation, rate = np.array([[0.3, -0.4, 0.7]]), np.array([[2.0, -3.0, 5.0]])
    more = energy(geared, rotation, rate) - energy(leg, rotation, rate)
    assert more == pytest.approx(0.5 * 2e-3 * (4.0 + 9.0 + 25.0))


def test_an_indifferent_pose_is_a_rest_pose() -> None:
    """A second link that hangs in its centre of mass stays where it is when the first falls from upright."""
    link = Link(0.2, 0.5, 0.1, 2e-3)
    leg = Leg("leg", (Joint("hip", link), Joint("knee", replace(link, com=0.0))))
    found = rest_pose(leg, start=np.array([math.pi, 0.7]))
    assert math.cos(found[0]) == pytest.approx(1.0, abs=1e-9)
    assert found[1] == pytest.approx(0.7, abs=1e-6)
    np.testing.assert_array_equal(rest_pose(leg, start=np.array([0.0, 0.7])), [0.0, 0.7])
