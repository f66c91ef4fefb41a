"""Another spring or damper than the design's, inertia at the joint, and errors of a known torque's column."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fit.simulated_legs import robot
from leg_energy import energy
from peers.mujoco_leg import simulate as peer
from swing.effects.one_joint import INERTIA, OMEGA, RATE, leg
from synth.arrays import Array
from synth.swing.chain import Conditions, compiled_chain, simulate
from synth.swing.effects import effect_named
from synth.swing.lane_layout import DRIVE, LANES
from synth.swing.leg_lanes import LegLanes
from synth.swing.leg_model import Damper, DamperCurve, Leg, Spring
from synth.swing.mechanics import coefficients, mass_matrix, momentum_and_force, outboard_inertia

TIMES = np.linspace(0.0, 1.0, 101)


def moved(made: Leg, effect: str, *values: float, joint: int = 0, start: float = 0.3) -> Array:
    """Rotation (m,) of the first joint, let go at ``start``, with an effect on the leg's numbers."""
    legs = LegLanes.of(made)
    effect_named(effect).function()(legs, joint, made.joints[joint].sign, *[np.array([value]) for value in values])
    chain = compiled_chain(legs.n)
    lanes = chain.lanes(legs)
    lanes[chain.layout.rows("rotation")] = start
    return chain.run(lanes, TIMES, 1e-9)[:, 0, 0]


@pytest.mark.parametrize("sign", [1, -1])
def test_a_spring_added_to_a_joint_swings_about_its_free_angle(sign: int) -> None:
    # q = rest + (q0 - rest) cos(w t), rest = sign * free angle of the spring that is there
    made = leg({}, rate=None, sign=sign)
    expected = sign * 0.1 + (0.3 - sign * 0.1) * np.cos(OMEGA * TIMES)
    np.testing.assert_allclose(moved(made, "spring_rate", RATE, 0.1), expected, atol=1e-6)


def test_a_removed_spring_leaves_a_rate_of_zero() -> None:
    np.testing.assert_allclose(moved(leg({}), "spring_rate", -2 * RATE, 0.0), 0.3, atol=1e-9)


@pytest.mark.parametrize("own", [None, 0.02])
def test_damping_decays_as_an_exponential_with_and_without_a_damper(own: float | None) -> None:
    extra, total = 0.06 - (own or 0.0), 0.06
    decay = total / (2 * INERTIA)
    fast = np.sqrt(OMEGA**2 - decay**2)
    expected = 0.3 * np.exp(-decay * TIMES) * (np.cos(fast * TIMES) + decay / fast * np.sin(fast * TIMES))
    np.testing.assert_allclose(moved(leg({}, damper=own), "viscous_damping", extra), expected, atol=1e-6)


def test_a_changed_damper_never_drives_the_joint() -> None:
    np.testing.assert_allclose(
        moved(leg({}, damper=0.02), "viscous_damping", -0.5), 0.3 * np.cos(OMEGA * TIMES), atol=1e-6
    )
    made = leg({}, damper=0.02)
    curve = DamperCurve((1.0, 4.0), (0.02, 0.05))
    curved = made.with_joints(joint={"damper": Damper(curve=curve)})
    legs = LegLanes.of(curved)
    effect_named("viscous_damping").function()(legs, 0, 1, np.array([-1.0]))
    assert legs.damper_rate[0, 0] == pytest.approx(-0.01)  # along its last segment: beyond it no more would be left


def test_armature_slows_as_its_share_of_the_inertia_says() -> None:
    expected = 0.3 * np.cos(OMEGA / np.sqrt(1.5) * TIMES)
    np.testing.assert_allclose(moved(leg({}), "armature", 0.5 * INERTIA), expected, atol=1e-6)
    held = leg({}).with_joints(joint={"armature": 0.5 * INERTIA})
    np.testing.assert_allclose(simulate(held, [0.3], [0.0], TIMES)[:, 0], expected, atol=1e-5)


def test_an_armature_that_is_not_there_is_taken_out_and_no_more() -> None:
    stated = leg({}).with_joints(joint={"armature": 0.5 * INERTIA})
    for excess in (-0.5, -2.0):
        np.testing.assert_allclose(moved(stated, "armature", excess * INERTIA), 0.3 * np.cos(OMEGA * TIMES), atol=1e-6)


@pytest.mark.parametrize("locked", [(), (1,), (0, 2)])
def test_a_chain_with_armature_moves_as_in_mujoco(locked: tuple[int, ...]) -> None:
    made = robot()
    own = 0.7 * outboard_inertia(made)
    made = made.with_joints(**{n: {"armature": float(i)} for n, i in zip(made.joint_names, own, strict=True)})
    start, rate = [0.5, -1.8, 1.2], np.where(np.isin(range(3), locked), 0.0, [0.0, 3.0, -4.0])
    ours = simulate(made, start, rate, TIMES, Conditions(locked), tolerance=1e-10)
    theirs = peer(made, start, rate, TIMES, locked, step=5e-5)
    assert np.abs(ours - theirs).max() < 1e-6
    without = made.with_joints(**{n: {"armature": 0.0} for n in made.joint_names})
    assert np.abs(ours - simulate(without, start, rate, TIMES, Conditions(locked))).max() > 0.02


def test_energy_momentum_and_mass_matrix_know_the_armature() -> None:
    made = robot(damper=[0.0, 0.0, 0.0]).with_joints(knee={"armature": 2e-3}, hip={"armature": 1e-3})
    states = simulate(made, [0.5, -1.8, 1.2], [0.0, 3.0, -4.0], TIMES, tolerance=1e-10, rates=True)
    held = energy(made, states[:, :3], states[:, 3:])
    np.testing.assert_allclose(held, held[0], atol=1e-7 * np.ptp(held) + 1e-8)
    known = coefficients(made)
    momentum, _ = momentum_and_force(known, states[:1, :3], states[:1, 3:], made.tilt)
    np.testing.assert_allclose(momentum[0], mass_matrix(known, states[0, :3], made.tilt) @ states[0, 3:], rtol=1e-12)


def test_a_body_at_the_tip_counts_with_inertia_and_place() -> None:
    # one joint, no gravity: frequency from I + m r^2 + J
    mass, inertia, at = 0.3, 4e-3, 0.15
    omega = np.sqrt(RATE / (INERTIA + mass * at**2 + inertia))
    found = simulate(leg({}), [0.3], [0.0], TIMES, Conditions(tip_mass=mass, tip_inertia=inertia, tip_at=at))[:, 0]
    np.testing.assert_allclose(found, 0.3 * np.cos(omega * TIMES), atol=1e-5)
    # in a chain: as the same body made part of the last link
    made = robot()
    link = made.joints[-1].link
    whole = link.mass + mass
    com = (link.mass * link.com + mass * at) / whole
    about = link.inertia + link.mass * (link.com - com) ** 2 + mass * (at - com) ** 2 + inertia
    heavier = made.with_joints(ankle={"link": replace(link, mass=whole, com=com, inertia=about)})
    start, rate = [0.5, -1.8, 1.2], [0.0, 3.0, -4.0]
    hung = simulate(made, start, rate, TIMES, Conditions(tip_mass=mass, tip_inertia=inertia, tip_at=at), tolerance=1e-9)
    np.testing.assert_allclose(hung, simulate(heavier, start, rate, TIMES, tolerance=1e-9), atol=1e-6)


DRIVEN = leg({}, damper=0.03, rate=3.0)
KNOTS = np.linspace(-0.2, 1.2, 57)
COLUMN = 0.4 * np.sin(9.0 * KNOTS) + 0.3 * (KNOTS > 0.4)


def reference(share: float, offset: float, delay: float) -> Array:
    """The driven joint by scipy, from knot to knot."""
    found, state, time = [0.2], np.array([0.2, 0.0]), 0.0
    stops = np.unique(np.concatenate([TIMES, KNOTS + delay]).round(12))
    for stop in stops[(stops > 1e-12) & (stops <= 1.0)]:

        def slope(t: float, y: Array) -> list[float]:
            torque = (1 + share) * np.interp(t - delay, KNOTS, COLUMN) + offset
            return [y[1], (torque - 3.0 * y[0] - 0.03 * y[1]) / INERTIA]

        state = solve_ivp(slope, (time, stop), state, rtol=1e-10, atol=1e-12).y[:, -1]
        time = stop
        if np.any(np.isclose(TIMES, stop, rtol=0.0, atol=1e-11)):
            found.append(state[0])
    return np.array(found)


def driven(lanes_of: list[tuple[float, float, float]], column: Array = COLUMN, sign: int = 1) -> Array:
    """(m, n_lane) the driven joint with these shares, offsets and delays side by side, all in one group of lanes."""
    legs = LegLanes.of(DRIVEN, len(lanes_of))
    for name, values in zip(DRIVE, np.array(lanes_of).T, strict=True):
        effect_named(name).function()(legs, 0, sign, values)
    chain = compiled_chain(1)
    lanes = chain.lanes(legs)
    lanes[chain.layout.rows("rotation")] = 0.2
    return chain.run(lanes, TIMES, 1e-8, known_torque=(KNOTS, column[:, None]))[:, 0]


def test_gain_offset_and_delay_of_a_known_torque_are_those_of_the_equation() -> None:
    given = [(0.0, 0.0, 0.0), (0.2, 0.0, 0.0), (0.0, 0.07, 0.0), (0.0, 0.0, 0.031), (-0.3, 0.05, 0.11)]
    found = driven(given)
    for lane, values in enumerate(given):
        np.testing.assert_allclose(found[:, lane], reference(*values), atol=2e-5)
    assert np.abs(found - found[:, :1]).max(axis=0)[1:].min() > 0.01
    late = driven([given[3], *given[:3]])  # the first lane's delay sets where the steps end
    np.testing.assert_allclose(late[:, 0], reference(*given[3]), atol=2e-6)
    np.testing.assert_allclose(late[:, 1:], found[:, :3], atol=2e-5)


def test_an_offset_needs_a_torque_column_and_has_the_sense_of_the_measured_angle() -> None:
    still = driven([(0.5, 0.1, 0.02)], np.zeros(len(KNOTS)))
    np.testing.assert_allclose(still[:, 0], driven([(0.0, 0.0, 0.0)], np.zeros(len(KNOTS)))[:, 0], atol=1e-9)
    np.testing.assert_allclose(driven([(0.0, 0.07, 0.0)], sign=-1)[:, 0], reference(0.0, -0.07, 0.0), atol=2e-6)


def test_lanes_without_errors_do_not_depend_on_lanes_with_errors() -> None:
    alone, beside = driven([(0.0, 0.0, 0.0)] * LANES), driven([(0.0, 0.0, 0.0), (0.1, 0.0, 0.0)])
    np.testing.assert_allclose(alone[:, 0], beside[:, 0], atol=1e-6)


def test_a_joint_of_the_leg_file_may_hold_an_error_of_the_column() -> None:
    held = DRIVEN.with_joints(joint={"effects": {"torque_gain": {"share": 0.2}, "torque_offset": {"offset": 0.03}}})
    found = simulate(held, [0.2], [0.0], TIMES, tolerance=1e-8, known_torque=(KNOTS, COLUMN[:, None]))
    np.testing.assert_allclose(found[:, 0], reference(0.2, 0.03, 0.0), atol=2e-6)


def test_the_spring_of_a_joint_is_a_number_of_the_leg() -> None:
    held = leg({"spring_rate": {"rate": 1.0}})
    with pytest.raises(ValueError, match="changes numbers of the leg"):
        LegLanes.of(held)
    assert held.joints[0].spring == Spring(RATE, 0.0)
