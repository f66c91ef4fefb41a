"""The generator's engine against MuJoCo, closed forms, and itself at half the step."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from peers import mujoco_leg
from synth.planting import bodies, engine, torque_laws
from synth.planting.model import Base, Bend, Law, PlantedLeg, PlantedTrial, Truth
from synth.planting.simulation import assemble, release, swing
from synth.swing.leg_model import Damper, Joint, Link, Spring
from synth.swing.leg_model import Leg as PeerLeg


def a_leg(generator: np.random.Generator, n: int) -> PlantedLeg:
    """Uneven rods, springs of 1-4 Hz."""
    length, mass = generator.uniform(0.08, 0.3, n), generator.uniform(0.1, 0.8, n)
    values = np.stack([length, mass, length * generator.uniform(0.3, 0.6, n), mass * length**2 / 12] + 3 * [0 * length])
    leg = PlantedLeg(tuple(f"j{i}" for i in range(n)), np.zeros(n), np.ones(n), generator.uniform(-0.5, 0.5), values)
    for i in range(n):
        inertia = leg.outboard(i)
        leg = leg.changed("spring", i, inertia * (2 * math.pi * generator.uniform(1, 4)) ** 2)
        leg = leg.changed("damper", i, inertia * generator.uniform(1, 10))
        leg = leg.changed("free_angle", i, generator.uniform(-0.8, 0.8))
    return leg


def as_peer(leg: PlantedLeg) -> PeerLeg:
    beside = np.zeros(leg.n) if leg.com_across is None else leg.com_across
    joints = [
        Joint(name, Link(*v[:4], com_across=x), 0.0, 1, spring=Spring(v[4], v[6]), damper=Damper(v[5]))
        for name, v, x in zip(leg.names, leg.values.T.tolist(), beside.tolist(), strict=True)
    ]
    return PeerLeg("leg", tuple(joints), gravity=leg.gravity, tilt=leg.tilt)


@pytest.mark.parametrize("beside", [0.0, -0.03])
@pytest.mark.parametrize(("n", "locked"), [(1, ()), (2, ()), (3, ()), (3, (0,)), (3, (1,)), (3, (1, 2))])
def test_a_leg_moves_as_in_mujoco(n: int, locked: tuple[int, ...], beside: float) -> None:
    generator = np.random.default_rng(n)
    leg = a_leg(generator, n)
    if beside:
        leg = replace(leg, com_across=beside * np.array([1.0, -0.7, 0.4])[:n])
    pose, speed = generator.uniform(-1, 1, n), generator.uniform(-2, 2, n)
    speed[list(locked)] = 0.0
    trial = PlantedTrial(pose, 1.0, tip_mass=0.07, locked=locked, tilt=0.3)
    times = np.linspace(0, 1, 51)
    ours = swing(leg, trial, pose, speed, 2e-4).at(times)
    theirs = mujoco_leg.simulate(as_peer(leg), pose, speed, times, locked, 0.07, 0.3, step=1e-4)
    assert np.ptp(theirs, axis=0).max() > 0.1
    assert np.abs(ours - theirs).max() < 1e-7


def test_a_sliding_mount_is_a_longer_chain() -> None:
    """Momentum along a free slide is kept, and energy: the chain's own conservation laws, without damping."""
    generator = np.random.default_rng(5)
    leg = a_leg(generator, 2)
    leg = leg.changed("damper", 0, 0.0).changed("damper", 1, 0.0)
    slide = (bodies.SLIDE, 0.0, 0.0, 0.6, 0.0, 0.0, 0.0)
    trial = PlantedTrial(np.array([0.6, -0.9]), 1.5)
    a = assemble(Truth(leg, base=Base((slide,))), trial)
    none = np.zeros(0, dtype=np.int64)
    q0 = np.array([0.0, 0.6, -0.9])
    q, w = engine.simulate(
        a.body,
        a.gravity,
        a.fixed,
        a.law,
        a.at,
        a.par,
        a.table,
        none,
        np.zeros((0, 2)),
        q0,
        np.zeros(3),
        0.0,
        1e-4,
        15000,
    )
    phi, spin = leg.tilt + np.cumsum(q[:, 1:], axis=1), np.cumsum(w[:, 1:], axis=1)
    length, mass, com, inertia, rate, _, free = leg.values
    momentum, energy = 0.6 * w[:, 0], 0.3 * w[:, 0] ** 2
    along, height, vx, vy = np.zeros(len(q)), np.zeros(len(q)), np.cos(leg.tilt) * w[:, 0], np.sin(leg.tilt) * w[:, 0]
    vx, vy, height = w[:, 0].copy(), np.zeros(len(q)), along
    for i in range(2):
        cx, cy = vx + com[i] * spin[:, i] * np.cos(phi[:, i]), vy + com[i] * spin[:, i] * np.sin(phi[:, i])
        momentum = momentum + mass[i] * cx
        energy = energy + 0.5 * mass[i] * (cx**2 + cy**2) + 0.5 * inertia[i] * spin[:, i] ** 2
        energy = energy + mass[i] * 9.81 * (height - com[i] * np.cos(phi[:, i]))
        energy = energy + 0.5 * rate[i] * (q[:, i + 1] - free[i]) ** 2
        vx, vy = vx + length[i] * spin[:, i] * np.cos(phi[:, i]), vy + length[i] * spin[:, i] * np.sin(phi[:, i])
        height = height - length[i] * np.cos(phi[:, i])
    assert np.ptp(q[:, 0]) > 0.02
    assert np.abs(momentum).max() < 1e-8
    assert np.ptp(energy) < 1e-7


def one_joint(rate: float, damping: float, law: tuple[Law, ...], bare: tuple[int, ...] = ()) -> Truth:
    values = np.array([[0.2], [0.5], [0.1], [0.002], [rate], [damping], [0.0]])
    return Truth(PlantedLeg(("j",), np.zeros(1), np.ones(1), 0.0, values, gravity=0.0), law, bare=bare)


def test_dry_friction_reduces_each_swing_by_a_constant_and_then_sticks() -> None:
    """On a spring each half swing is 2 T / k shorter than the one before; it stops for good where k |q| <= T."""
    k, dry = 8.0, 0.25
    motion = release(
        one_joint(k, 0.0, (Law(torque_laws.STICK_SLIP, 0, (dry, dry, 1.0, 0.0)),)),
        PlantedTrial(np.array([0.5]), 3.0),
        2e-4,
    )
    q, w = motion.angle[:, 0], motion.speed[:, 0]
    turns = np.flatnonzero((w[1:] * w[:-1] <= 0) & (w[:-1] != 0))
    expected = [0.5 - 2 * dry / k * (i + 1) for i in range(7)]
    np.testing.assert_allclose(np.abs(q[turns + 1])[:7], expected, atol=1e-5)  # the turn falls between two steps
    still = int(turns[-1]) + 1
    assert abs(k * q[still]) <= dry
    assert np.all(q[still:] == q[still])  # exactly at rest
    assert np.all(w[still:] == 0.0)


def test_backlash_coasts_across_its_gap() -> None:
    """Between the flanks the speed is constant; in contact the spring acts from the flank."""
    k, gap = 8.0, 0.05
    law = Law(torque_laws.SLACK, 0, (k, 0.0, gap, 1e-4))
    motion = release(one_joint(0.0, 0.0, (law,), bare=(0,)), PlantedTrial(np.array([0.3]), 1.0), 1e-4)
    q, w = motion.angle[:, 0], motion.speed[:, 0]
    omega = math.sqrt(k / (0.002 + 0.5 * 0.01))
    quarter = math.pi / 2 / omega + 2 * gap / (0.25 * omega)
    inside = np.flatnonzero(np.abs(q) < 0.9 * gap)[:50]
    np.testing.assert_allclose(w[inside], -0.25 * omega, rtol=2e-3)
    assert quarter == pytest.approx(float(np.flatnonzero(q < -gap)[0]) * 1e-4, abs=1e-3)


STEPPED = [
    Law(torque_laws.STICK_SLIP, 1, (0.05, 0.09, 0.4, 1.0)),
    Law(torque_laws.BRISTLES, 1, (0.05, 0.08, 0.4, 0.0, 2e-3, 0.0)),
    Law(torque_laws.BEARING, 0, (0.006, 0.0)),
    Law(torque_laws.GEAR_MESH, 1, (0.1, 3.0, 0.2, 0.0, 2e-3, 0.0)),
    Law(torque_laws.BOUC_WEN, 1, (1.0, 0.1, 2.0, 0.3)),
    Law(torque_laws.TWO_MAXWELL, 1, (1.0, 0.3, 0.5, 0.05)),
    Law(torque_laws.HUNT_CROSSLEY, 1, (60.0, 0.3, 1.0, 1.5, 0.3)),
    Law(torque_laws.RUBBER_STOP, 1, (30.0, 0.3, 1.0, 0.05, 0.02)),
    Law(torque_laws.SLACK_ARM, 1, (3.0, 0.2, 0.03, 0.02, 1e-4, 2000.0, 0.3)),
    Law(torque_laws.SLACK, 1, (3.0, 0.2, 0.03, 0.02)),
]


@pytest.mark.parametrize("law", STEPPED, ids=lambda law: str(law.law))
def test_halving_the_step_changes_little(law: Law) -> None:
    """Discontinuous and stiff laws: half the step moves the leg by less than a thirtieth of the finest noise floor."""
    leg = a_leg(np.random.default_rng(3), 3)
    bare = (law.joint,) if law.law in (torque_laws.SLACK, torque_laws.SLACK_ARM) else ()
    trial = PlantedTrial(np.array([0.5, -0.6, 0.4]), 2.0)
    motions = [release(Truth(leg, (law,), bare=bare), trial, step) for step in (2e-4, 1e-4)]
    plain = release(Truth(leg), trial, 2e-4)
    times = np.linspace(0, 2, 400)
    assert np.abs(motions[0].at(times) - plain.at(times)).max() > 5e-3
    assert np.sqrt(np.mean((motions[0].at(times) - motions[1].at(times)) ** 2)) < 7e-6


def test_a_stiff_bending_link_and_mount_are_the_rigid_leg() -> None:
    leg = a_leg(np.random.default_rng(8), 3)
    trial = PlantedTrial(np.array([0.4, -0.5, 0.3]), 1.0)
    times = np.linspace(0, 1, 100)
    rigid = release(Truth(leg), trial, 2e-4).at(times)
    bend = Bend(1, (0.25, 0.75), (3e3, 3e3), (0.3, 0.3))
    bent = release(Truth(leg, bends=(bend,)), trial, 1e-5).at(times)
    softer = release(Truth(leg, bends=(bend._replace(rates=(300.0, 300.0)),)), trial, 1e-5).at(times)
    assert np.abs(bent - rigid).max() < 0.2 * np.abs(softer - rigid).max()
    mount = Base(((bodies.SLIDE, 0.0, 0.0, 2.0, 0.0, 1e6, 1e3), (bodies.HINGE, 0.0, 0.2, 1.0, 0.01, 1e5, 50.0)))
    moved = release(Truth(leg, base=mount), trial, 1e-5).at(times)
    assert np.abs(moved - rigid).max() < 1e-3
