"""Moving bases and bending links: the longer chain written out by hand, two-body frequencies, and the rigid limit."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigh

from fit.simulated_legs import robot
from swing.effects.one_joint import INERTIA, LINK, RATE
from synth.arrays import Array
from synth.files.leg_file import read_leg, write_leg
from synth.swing.chain import Conditions, simulate
from synth.swing.effects import effect_named
from synth.swing.effects.base_compliance import LEVER
from synth.swing.effects.link_flexibility import DAMPING_RATIO, HUB
from synth.swing.leg_lanes import LegLanes
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring, Tip

START = [0.5, -1.8, 1.2]


def bending(place: float, stiffness: float = 8.0) -> Leg:
    """The robot with a knee link that bends."""
    return robot(damper=[0.3, 0.02, 0.01]).with_joints(
        knee={"effects": {"link_flexibility": {"stiffness": stiffness, "place": place}}}
    )


def inertias(legs: LegLanes, first: int, count: int) -> tuple[float, float, float]:
    """Mass, first moment and inertia about the first joint of ``count`` links in a straight line."""
    mass = moment = inertia = reach = 0.0
    for i in range(first, first + count):
        com = reach + float(legs.com[i, 0])
        mass += float(legs.mass[i, 0])
        moment += float(legs.mass[i, 0]) * com
        inertia += float(legs.inertia[i, 0] + legs.mass[i, 0] * com**2)
        reach += float(legs.length[i, 0])
    return mass, moment, inertia


@pytest.mark.parametrize("place", [0.0, 0.3, 0.6])
def test_a_cut_link_keeps_mass_moment_inertia_and_length(place: float) -> None:
    whole, rigid = LegLanes.whole(bending(place)), LegLanes.of(robot())
    assert whole.own == (0, 1, 3)
    assert inertias(whole, 1, 2) == pytest.approx(inertias(rigid, 1, 1), rel=1e-12)
    assert whole.length[1, 0] + whole.length[2, 0] == pytest.approx(rigid.length[1, 0])


@pytest.mark.parametrize("place", [0.0, 0.4])
def test_a_bending_link_in_a_file_moves_as_the_longer_leg_written_by_hand(place: float, tmp_path: Path) -> None:
    made, link = bending(place), robot().joints[1].link
    about = link.inertia + link.mass * link.com**2
    # a rod, a weight at its end and a hub at the joint with the link's mass, first moment and inertia
    rod, _, hub = np.linalg.solve(
        [[1, 1, 1], [0.5, 1, 0], [1 / 3, 1, 0]],
        [link.mass, link.mass * link.com / link.length, about / link.length**2],
    )
    assert min(rod, hub) > 0.0
    near_mass = place * rod + (hub if place > 0.0 else 0.0)
    near_com = 0.5 * place**2 * rod * link.length / near_mass if place > 0.0 else 0.0
    near_inertia = (
        rod * place**3 * link.length**2 / 3 - near_mass * near_com**2 + (HUB * about if place == 0.0 else 0.0)
    )
    far_mass = link.mass - near_mass
    far_com = (link.mass * link.com - near_mass * near_com) / far_mass - place * link.length
    reach = far_com + place * link.length
    far_inertia = about - near_inertia - near_mass * near_com**2 - far_mass * reach**2
    damping = 2 * DAMPING_RATIO * math.sqrt(8.0 * (far_inertia + far_mass * far_com**2))
    hip, knee, ankle = made.joints
    near_link = Link(place * link.length, near_mass, near_com, near_inertia)
    near = Joint("knee", near_link, knee.zero, knee.sign, None, knee.spring, knee.damper)
    far_link = Link((1 - place) * link.length, far_mass, far_com, far_inertia)
    far = Joint("bend", far_link, spring=Spring(8.0, 0.0), damper=Damper(damping))
    longer = Leg("by hand", (hip, near, far, ankle))
    times = np.linspace(0, 1, 51)
    path = tmp_path / "x.leg.yaml"
    write_leg(made, path)
    got = simulate(read_leg(path), START, [0.0, 3.0, -4.0], times, tolerance=1e-9)
    assert knee.spring is not None
    rest = knee.sign * (knee.spring.free_angle - knee.zero)
    bent = (1 - place) * knee.spring.rate * (START[1] - rest) / 8.0  # a force holds the link's end
    expected = simulate(longer, [0.5, -1.8, bent, 1.2], [0.0, 3.0, 0.0, -4.0], times, tolerance=1e-9)
    np.testing.assert_allclose(got, expected[:, [0, 1, 3]], atol=1e-7)
    assert np.abs(got - simulate(robot(damper=[0.3, 0.02, 0.01]), START, [0.0, 3.0, -4.0], times)).max() > 0.01


def test_a_stiffer_link_approaches_the_rigid_leg() -> None:
    # the difference falls with the compliance
    times = np.linspace(0, 0.5, 51)
    plain = simulate(robot(), START, [0.0, 0.0, 0.0], times, tolerance=1e-9)
    differences = []
    for stiffness in (1000.0, 4000.0):
        held = {"link_flexibility": {"stiffness": stiffness, "place": 0.4}}
        bent = simulate(robot().with_joints(knee={"effects": held}), START, [0.0] * 3, times, tolerance=1e-9)
        differences.append(np.abs(bent - plain).max())
    assert differences[1] < 1e-3
    assert differences[0] / differences[1] == pytest.approx(4.0, rel=0.2)


@pytest.mark.parametrize("place", [0.0, 0.5])
def test_a_held_link_rings_at_its_first_bending_frequency(place: float) -> None:
    # the joint locked: the far part on its torsion spring, damped lightly: w sqrt(1 - zeta^2)
    stiffness = 60.0
    joint = Joint("joint", LINK, effects={"link_flexibility": {"stiffness": stiffness, "place": place}})
    legs = LegLanes.whole(Leg("one", (joint,), gravity=0.0))
    far = float(legs.inertia[1, 0] + legs.mass[1, 0] * legs.com[1, 0] ** 2)
    omega = math.sqrt(stiffness / far)
    near_link, far_link = (
        Link(*(float(getattr(legs, name)[i, 0]) for name in ("length", "mass", "com", "inertia"))) for i in (0, 1)
    )
    bend = Joint("bend", far_link, spring=Spring(stiffness, 0.0), damper=Damper(float(legs.damper_rate[1, 0])))
    ringing = Leg("held", (Joint("joint", near_link), bend), gravity=0.0)
    period = 2 * math.pi / (omega * math.sqrt(1 - DAMPING_RATIO**2))
    moved = simulate(ringing, [0.0, 0.01], [0.0, 0.0], np.arange(4) * period, Conditions(locked=(0,)), tolerance=1e-10)
    expected = 0.01 * np.exp(-DAMPING_RATIO * omega * np.arange(4) * period)
    np.testing.assert_allclose(moved[:, 1], expected, rtol=1e-6)
    if place == 0.0:
        assert far == pytest.approx((1 - HUB) * INERTIA)


def mounted(**base: float) -> Leg:
    """One free link on a mount that moves, without gravity."""
    joint = Joint("joint", LINK, spring=Spring(RATE, 0.0))
    return Leg("mounted", (joint,), gravity=0.0, effects={"base_compliance": {"damping_ratio": 0.0, **base}})


def modes(mass: Array, stiffness: Array, start: Array, times: Array) -> Array:
    """(m, n) free vibration from rest at ``start``: M x'' + K x = 0."""
    squares, shapes = eigh(mass, stiffness)
    omega = 1 / np.sqrt(squares)
    amplitude = np.linalg.solve(shapes, start)
    return np.asarray((shapes @ (amplitude[:, None] * np.cos(np.outer(omega, times)))).T)


def rocking_masses(inertia: float, arm: float) -> Array:
    """Of a mount that turns about a point ``arm`` above the joint, and the link: in the mount's turn and q."""
    both = LINK.mass * (arm + LINK.com) ** 2 + LINK.inertia
    coupled = LINK.mass * (arm + LINK.com) * LINK.com + LINK.inertia
    return np.array([[inertia + both, coupled], [coupled, INERTIA]])


def test_a_sliding_mount_and_the_link_swing_as_two_bodies() -> None:
    # x of the mount, q of the link: kinetic energy 1/2 (M + m) x'^2 + m c x' q' + 1/2 I q'^2 for small q; the mount is
    # the end of a link of 100 leg lengths, so that frequencies are 0.2 % off; with that lever the motion is exact
    mount, stiffness, times = 0.4, 600.0, np.linspace(0, 2, 201)
    coupled = LINK.mass * LINK.com
    straight = np.array([[mount + LINK.mass, coupled], [coupled, INERTIA]])
    lever = LEVER * LINK.length
    round_about = rocking_masses(mount * lever**2, lever)
    rates, levered = np.diag([stiffness, RATE]), np.diag([stiffness * lever**2, RATE])
    wanted, found = (1 / np.sqrt(eigh(m, k)[0]) for m, k in ((straight, rates), (round_about, levered)))
    np.testing.assert_allclose(found, wanted, rtol=2e-3)
    assert np.abs(wanted / 20.0 - 1).min() > 0.05
    expected = modes(round_about, levered, np.array([0.0, 1e-3]), times)
    got = simulate(mounted(stiffness=stiffness, mass=mount), [1e-3], [0.0], times, tolerance=1e-11)
    np.testing.assert_allclose(got[:, 0], expected[:, 1], atol=1e-8)


@pytest.mark.parametrize("arm", [0.15, -0.1, 0.0])
def test_a_rocking_mount_and_the_link_swing_as_two_bodies(arm: float) -> None:
    # theta of the mount about a point ``arm`` above the joint: the joint goes sideways by arm theta, and turns by theta
    inertia, stiffness, times = 0.02, 40.0, np.linspace(0, 2, 201)
    mass = rocking_masses(inertia, arm)
    start = np.array([-RATE * -1e-3 / stiffness, 1e-3])  # the held link's spring has turned the mount
    expected = modes(mass, np.diag([stiffness, RATE]), start, times)
    made = mounted(rocking_stiffness=stiffness, arm=arm, inertia=inertia)
    legs = LegLanes.whole(made)
    bent = effect_named("base_compliance").function("start")(legs, 0, np.array([[0.0], [1e-3]]))
    assert bent == pytest.approx(start[0])
    rested = modes(mass, np.diag([stiffness, RATE]), np.array([0.0, 1e-3]), times)
    got = simulate(made, [1e-3], [0.0], times, tolerance=1e-10)
    np.testing.assert_allclose(got[:, 0], expected[:, 1], atol=1e-8)
    assert np.abs(expected - rested).max() > 1e-5


def test_a_mount_is_kept_as_fast_as_it_must_be() -> None:
    """Alone under the rigid leg it then sways at that rate; a stiffer one, and a direction that is rigid, stay."""
    inertia, mass, arm, slowest = 0.02, 0.4, -0.1, 12.0
    soft = np.array([[0.0, 50.0, 0.0], [mass] * 3, [1.0, 0.0, 500.0], [arm] * 3, [inertia] * 3, [0.05] * 3])
    kept = effect_named("base_compliance").function("bounded")(mounted(), 0, slowest, soft)
    rocks = kept[2, 0] / rocking_masses(inertia, arm)[0, 0]
    slides = kept[0, 1] / (mass + LINK.mass)
    assert np.sqrt([rocks, slides]) == pytest.approx(slowest)
    assert kept[2, 1] == kept[0, 0] == 0.0
    np.testing.assert_array_equal(kept[:, 2], soft[:, 2])
    np.testing.assert_array_equal(kept[[1, 3, 4, 5]], soft[[1, 3, 4, 5]])


def test_a_mount_that_slides_and_rocks_swings_with_the_link_as_three_bodies() -> None:
    # x of the pivot, theta of the mount about it, q of the link, the joint at ``arm`` below the pivot: for small motion
    # the joint goes sideways by x + arm theta and the link's centre of mass by that and com (theta + q)
    mount, inertia, arm, times = 0.3, 0.02, 0.15, np.linspace(0, 2, 201)
    lever = LEVER * LINK.length
    sideways = np.array([lever + arm + LINK.com, arm + LINK.com, LINK.com])  # of the centre of mass, by all three
    turn = np.ones(3)
    mass = LINK.mass * np.outer(sideways, sideways) + LINK.inertia * np.outer(turn, turn)
    mass[0, 0] += mount * lever**2 + inertia
    mass[0, 1] += inertia
    mass[1, 0] += inertia
    mass[1, 1] += inertia
    slide, rock = 700.0, 30.0
    made = mounted(stiffness=slide, mass=mount, rocking_stiffness=rock, arm=arm, inertia=inertia)
    legs = LegLanes.whole(made)
    assert (legs.n, legs.own) == (3, (2,))
    start = np.array([0.0, RATE * 1e-3 / rock, 1e-3])
    expected = modes(mass, np.diag([slide * lever**2, rock, RATE]), start, times)
    got = simulate(made, [1e-3], [0.0], times, tolerance=1e-11)
    np.testing.assert_allclose(got[:, 0], expected[:, 2], atol=1e-8)
    rocking = simulate(mounted(rocking_stiffness=rock, arm=arm, inertia=inertia), [1e-3], [0.0], times)
    assert np.abs(rocking[:, 0] - got[:, 0]).max() > 1e-5


def test_a_nearly_rigid_mount_moves_like_a_rigid_one() -> None:
    times = np.linspace(0, 1, 51)
    plain = simulate(robot(), START, [0.0] * 3, times, tolerance=1e-9)
    base = robot()
    for effects in ({"stiffness": 1e6}, {"rocking_stiffness": 3e4, "arm": 0.1}):
        made = Leg(base.name, base.joints, base.gravity, base.tilt, {"base_compliance": effects})
        assert np.abs(simulate(made, START, [0.0] * 3, times, tolerance=1e-7) - plain).max() < 2e-3


def test_base_and_links_may_both_be_compliant_with_a_joint_locked(tmp_path: Path) -> None:
    made = bending(0.3, 30.0)
    made = Leg(made.name, made.joints, made.gravity, 0.2, {"base_compliance": {"rocking_stiffness": 50.0}})
    path = tmp_path / "x.leg.yaml"
    write_leg(made, path)
    again = read_leg(path)
    assert again.effects == {"base_compliance": {"rocking_stiffness": pytest.approx(50.0)}}
    legs = LegLanes.whole(again)
    assert (legs.n, legs.own) == (5, (1, 2, 4))
    times = np.linspace(0, 0.5, 26)
    moved = simulate(again, START, [0.0, 9.0, 0.0], times, Conditions(locked=(1,)))
    np.testing.assert_array_equal(moved[:, 1], -1.8)
    assert np.ptp(moved[:, 0]) > 0.01


@pytest.mark.parametrize("place", [0.0, 0.4, 0.9])
@pytest.mark.parametrize("spread", [1e-4, 0.01, 1.0 / 12.0, 0.3])
@pytest.mark.parametrize("com", [0.05, 0.5, 1.0])
@pytest.mark.parametrize("beside", [0.0, 0.1])
def test_a_link_that_bends_keeps_mass_moment_and_inertia(
    place: float, spread: float, com: float, beside: float
) -> None:
    """Also that of a pendulum's bob, whose inertia about its centre of mass is ``spread`` m l^2."""
    length, mass = 0.3, 0.5
    link = Link(length, mass, com * length, spread * mass * length**2, com_across=beside * length)
    one = LegLanes.of(Leg("one", (Joint("j", link),)))
    both = effect_named("link_flexibility").function()(one, 0, np.array([10.0]), np.array([place]), np.array([0.1]))
    lengths, masses, centres, about = (getattr(both, n)[:, 0] for n in ("length", "mass", "com", "inertia"))
    away = np.array([centres[0], lengths[0] + centres[1]])
    across = both.com_across[:, 0]
    sums = masses.sum(), (masses * away).sum(), (masses * across).sum(), (about + masses * (away**2 + across**2)).sum()
    assert sums == pytest.approx((mass, mass * link.com, mass * link.com_across, link.about_joint), rel=1e-12)
    assert lengths.sum() == pytest.approx(length)
    assert bool((about >= 0.0).all())
    assert about[1] > 0.0


@pytest.mark.parametrize("place", [0.2, 0.5, 0.9])
def test_a_uniform_rod_is_cut_into_two_uniform_rods(place: float) -> None:
    length, mass = 0.22, 0.35
    rod = Link(length, mass, length / 2, mass * length**2 / 12)
    legs = LegLanes.whole(
        Leg("rod", (Joint("hip", rod, effects={"link_flexibility": {"stiffness": 8.0, "place": place}}),))
    )
    for part, share in enumerate((place, 1.0 - place)):
        expected = share * length, share * mass, share * length / 2, share * mass * (share * length) ** 2 / 12
        found = [float(getattr(legs, name)[part, 0]) for name in ("length", "mass", "com", "inertia")]
        assert found == pytest.approx(expected, rel=1e-9)


def test_a_bend_near_the_free_end_matters_less() -> None:
    """Its part is short and light, and the force that holds the end bends it little."""
    times = np.linspace(0, 1, 51)
    alone = robot(damper=[0.3, 0.02, 0.01]).with_joints(ankle={"effects": {}})
    rigid = simulate(alone, START, [0.0] * 3, times, tolerance=1e-9)
    moved = []
    for place in (0.3, 0.6, 0.9):
        bent = alone.with_joints(ankle={"effects": {"link_flexibility": {"stiffness": 5.0, "place": place}}})
        moved.append(np.abs(simulate(bent, START, [0.0] * 3, times, tolerance=1e-9) - rigid).max())
    assert moved[0] > 2 * moved[1] > 10 * moved[2] > 0.0


def test_the_lock_of_a_joint_carries_its_springs_torque() -> None:
    """The link starts straight, as the longer chain does, and bends when the other joints move."""
    made = bending(0.0)
    times, conditions = np.linspace(0, 1, 51), Conditions(locked=(1,))
    whole = LegLanes.whole(made)
    links = [Link(*(float(getattr(whole, n)[i, 0]) for n in ("length", "mass", "com", "inertia"))) for i in range(4)]
    hip, knee, ankle = made.joints
    near = Joint("knee", links[1], knee.zero, knee.sign, None, knee.spring, knee.damper)
    bend = Joint("bend", links[2], spring=Spring(8.0, 0.0), damper=Damper(float(whole.damper_rate[2, 0])))
    longer = Leg("by hand", (hip, near, bend, ankle))
    got = simulate(made, START, [0.0] * 3, times, conditions, tolerance=1e-9)
    expected = simulate(longer, [0.5, -1.8, 0.0, 1.2], [0.0] * 4, times, conditions, tolerance=1e-9)
    np.testing.assert_allclose(got, expected[:, [0, 1, 3]], atol=1e-7)
    assert np.ptp(expected[:, 2]) > 0.01


def test_the_lock_of_the_first_joint_carries_its_springs_torque_before_the_mount_does() -> None:
    made = replace(robot(), effects={"base_compliance": {"rocking_stiffness": 40.0, "arm": 0.05, "inertia": 0.02}})
    legs, held = LegLanes.held(made, np.array(START)[:, None], locked=(0,))
    assert legs.n == 4
    np.testing.assert_array_equal(held[:, 0], [0.0, *START])


@pytest.mark.parametrize("at", [0.03, 0.09, 0.15])
def test_a_tip_mass_is_placed_from_the_joint_of_a_link_that_bends(at: float) -> None:
    """On the part that it is fastened to, before and beyond the bend."""
    link, cut = Link(0.2, 0.3, 0.08, 1.5e-3), 0.08
    plain = Joint("hip", link, spring=Spring(1.5, 0.4), damper=Damper(0.01))
    made = Leg("one", (replace(plain, effects={"link_flexibility": {"stiffness": 8.0, "place": 0.4}}),))
    whole, tip = LegLanes.whole(made), Tip(0.1, 2e-4, at)
    parts = [Link(*(float(getattr(whole, n)[i, 0]) for n in ("length", "mass", "com", "inertia"))) for i in range(2)]
    if at < cut:  # the near part with the mass, by hand
        near = parts[0]
        mass = near.mass + tip.mass
        com = (near.mass * near.com + tip.mass * at) / mass
        about = near.inertia + near.mass * near.com**2 + tip.inertia + tip.mass * at**2
        parts[0], carried = Link(near.length, mass, com, about - mass * com**2), Tip()
    else:
        carried = Tip(tip.mass, tip.inertia, at - cut)
    bend = Joint("bend", parts[1], spring=Spring(8.0, 0.0), damper=Damper(float(whole.damper_rate[1, 0])))
    longer = Leg("by hand", (replace(plain, link=parts[0]), bend))
    times, bent = np.linspace(0, 1, 51), 0.6 * 1.5 * (0.9 - 0.4) / 8.0
    got, expected = (
        simulate(
            leg, start, [0.0] * len(start), times, Conditions((), each.mass, 0.0, each.inertia, each.at), tolerance=1e-9
        )
        for leg, start, each in ((made, [0.9], tip), (longer, [0.9, bent], carried))
    )
    np.testing.assert_allclose(got[:, 0], expected[:, 0], atol=1e-7)
