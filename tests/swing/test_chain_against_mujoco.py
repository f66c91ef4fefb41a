"""The compiled chain against MuJoCo: random chains, damper curves, dry friction, locked joints."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from fit.simulated_legs import robot
from peers.mujoco_leg import simulate as peer
from synth.swing.chain import Conditions, simulate
from synth.swing.leg_model import Damper, DamperCurve, Joint, Leg, Link, Spring
from synth.swing.mechanics import outboard_inertia

TIMES = np.linspace(0.0, 1.0, 101)
TIGHT = 1e-10


def random_leg(generator: np.random.Generator, n: int) -> Leg:
    """Uniform-ish rods of unequal size, springs of 1-4 Hz and dampers of 1-30 1/s on the inertia that they carry."""
    joints = []
    for i in range(n):
        length, mass = generator.uniform(0.08, 0.3), generator.uniform(0.1, 0.8)
        own = mass * length**2 / 12 * generator.uniform(0.7, 1.3)
        link = Link(length, mass, length * generator.uniform(0.3, 0.6), own)
        joints.append(Joint(f"joint{i}", link, generator.uniform(0, math.pi), int(generator.choice([-1, 1]))))
    leg = Leg(f"random {n}", tuple(joints), tilt=generator.uniform(-0.5, 0.5))
    changes = {}
    for joint, inertia in zip(leg.joints, outboard_inertia(leg).tolist(), strict=True):
        rate = inertia * (2 * math.pi * generator.uniform(1, 4)) ** 2
        spring = Spring(rate, joint.zero + generator.uniform(-0.8, 0.8))
        changes[joint.name] = {"spring": spring, "damper": Damper(inertia * generator.uniform(1, 30))}
    bare = {name: {"spring": None, "damper": None} for name in leg.joint_names[1::3]}  # some joints hang free
    return leg.with_joints(**(changes | bare))


CASES = [(1, ()), (2, ()), (3, ()), (4, ()), (5, ()), (6, ()), (3, (0,)), (4, (1, 2)), (6, (0, 4)), (2, (1,))]


@pytest.mark.parametrize(("number", "n", "locked"), [(i, *case) for i, case in enumerate(CASES)])
def test_random_smooth_chain_moves_as_in_mujoco(number: int, n: int, locked: tuple[int, ...]) -> None:
    generator = np.random.default_rng(number)
    leg = random_leg(generator, n)
    rotation = generator.uniform(-1.0, 1.0, n)
    rate = np.where(np.isin(np.arange(n), locked), 0.0, generator.uniform(-2.0, 2.0, n))
    tip, tilt = float(generator.uniform(0, 0.2)), float(generator.uniform(-0.3, 0.3))
    ours = simulate(leg, rotation, rate, TIMES, Conditions(locked, tip, tilt), tolerance=TIGHT)
    theirs = peer(leg, rotation, rate, TIMES, locked, tip, tilt, step=5e-5)
    assert np.ptp(theirs, axis=0).max() > 0.1
    assert np.abs(ours - theirs).max() < 1e-6
    np.testing.assert_array_equal(ours[:, list(locked)], np.tile(rotation[list(locked)], (len(TIMES), 1)))


@pytest.mark.parametrize(("n", "locked"), [(1, ()), (2, ()), (3, ()), (6, ()), (4, (1,))])
def test_chain_with_centres_of_mass_beside_its_lines_moves_as_in_mujoco(n: int, locked: tuple[int, ...]) -> None:
    generator = np.random.default_rng(100 + n)
    leg = beside_lines(generator, random_leg(generator, n))
    rotation = generator.uniform(-1.0, 1.0, n)
    rate = np.where(np.isin(np.arange(n), locked), 0.0, generator.uniform(-2.0, 2.0, n))
    tip, tilt = float(generator.uniform(0, 0.2)), float(generator.uniform(-0.3, 0.3))
    ours = simulate(leg, rotation, rate, TIMES, Conditions(locked, tip, tilt), tolerance=TIGHT)
    assert np.abs(ours - peer(leg, rotation, rate, TIMES, locked, tip, tilt, step=5e-5)).max() < 1e-6
    on_lines = replace(leg, joints=tuple(replace(j, link=replace(j.link, com_across=0.0)) for j in leg.joints))
    straight = simulate(on_lines, rotation, rate, TIMES, Conditions(locked, tip, tilt), tolerance=TIGHT)
    assert np.abs(ours - straight).max() > 0.01


def beside_lines(generator: np.random.Generator, leg: Leg) -> Leg:
    """The leg with each centre of mass up to a fifth of its link's length beside the line."""
    links = [replace(j.link, com_across=j.link.length * generator.uniform(-0.2, 0.2)) for j in leg.joints]
    return replace(leg, joints=tuple(replace(j, link=link) for j, link in zip(leg.joints, links, strict=True)))


def test_damper_curve_moves_as_in_mujoco() -> None:
    # 1e-6 rad too, but the peer needs smaller steps: one that crosses a kink of the curve errs in second order
    speed = (0.1, 0.5, 1.0, 2.0, 5.0)
    leg = robot()
    for name, torque in zip(leg.joint_names, (0.5, 0.1, 0.04), strict=True):
        curve = DamperCurve(speed, tuple(torque * s**0.45 for s in speed))
        leg = leg.with_joints(**{name: {"damper": Damper(curve=curve)}})
    start, rate = [0.5, -1.8, 1.2], [0.0, 3.0, -4.0]
    ours = simulate(leg, start, rate, TIMES, tolerance=TIGHT)
    theirs = peer(leg, start, rate, TIMES, step=5e-5)
    assert np.abs(ours - theirs).max() < 1e-6
    linear = simulate(robot(), start, rate, TIMES)
    assert np.abs(ours - linear).max() > 0.1


def test_dry_friction_moves_as_in_mujoco() -> None:
    # The peer has no bristle: friction smoothed over 1e-3 rad/s, which creeps 1e-3 rad a second where it should stick,
    # and its 5e-5 s steps jump over that layer. Ours with hardly any presliding is within 2.6e-4 rad of it; with the
    # default within 2.9e-3, which is the bristle's own give and falls with it.
    leg = robot(damper=[0.3, 0.02, 0.01])
    start, rate = [0.5, -1.8, 1.2], [0.0, 3.0, -4.0]

    def rubbing(**presliding: float) -> Leg:
        given = zip(leg.joint_names, (0.3, 0.1, 0.02), strict=True)
        return leg.with_joints(
            **{name: {"effects": {"coulomb_friction": {"torque": torque} | presliding}} for name, torque in given}
        )

    theirs = peer(rubbing(), start, rate, TIMES, step=5e-5, friction_width=1e-3)
    stiff = simulate(rubbing(presliding=1e-5), start, rate, TIMES)
    soft = simulate(rubbing(), start, rate, TIMES)
    assert np.abs(stiff - theirs).max() < 4e-4
    assert np.abs(soft - theirs).max() < 4e-3
    assert np.abs(stiff - simulate(leg, start, rate, TIMES)).max() > 0.1


def test_samples_of_any_spacing_move_as_in_mujoco() -> None:
    times = np.r_[0.3, np.sort(np.random.default_rng(3).uniform(0.3, 1.1, 40)), 1.1]  # time need not start at 0
    start, rate = [0.5, -1.8, 1.2], [1.0, 2.0, -2.0]
    ours = simulate(robot(), start, rate, times, tolerance=TIGHT)
    assert np.abs(ours - peer(robot(), start, rate, times)).max() < 1e-6
