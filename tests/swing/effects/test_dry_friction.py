"""Dry friction against what is known exactly: linear decay, rest anywhere in a band, no creep, breakaway, load.

Errors measured: see ``synth.swing.effects.inlined``.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fit.simulated_legs import robot
from swing.effects.one_joint import INERTIA, LINK, OMEGA, RATE, Array, leg, swing
from synth.swing.chain import Conditions, compiled_chain, simulate
from synth.swing.effects.inlined import ASYMPTOTE, BRISTLE_DAMPING, LEAST_PRESLIDING, bend_that_holds
from synth.swing.lane_layout import LOAD_PASSES
from synth.swing.leg_lanes import LegLanes
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

HALF = math.pi / OMEGA


def sliding_swing(start: float, torque: float, times: Array) -> Array:
    """Half swings about +-T/k, which lose 2 T/k each until the spring cannot overcome the friction.

    Den Hartog, *Mechanical Vibrations*, section 8.7.
    """
    band, left, begin = torque / RATE, start, 0.0
    angle = np.empty_like(times)
    while abs(left) > band:
        centre = math.copysign(band, left)
        now = times >= begin
        angle[now] = centre + (left - centre) * np.cos(OMEGA * (times[now] - begin))
        left, begin = 2 * centre - left, begin + HALF
    angle[times >= begin] = left
    return angle


@pytest.mark.parametrize("torque", [0.04, 0.2, 0.5, 1.3])
def test_a_swing_loses_four_times_torque_over_rate_a_cycle_and_rests_off_the_middle(torque: float) -> None:
    # 1e-6 rad: nothing is smoothed while it slides, and it takes hold where it stops
    times = np.linspace(0, 4, 2001)
    got = swing(leg({"coulomb_friction": {"torque": torque}}), 0.5, 0.0, times, 1e-8)[:, 0]
    expected = sliding_swing(0.5, torque, times)
    np.testing.assert_allclose(got, expected, atol=1e-6)
    if torque > 0.04:
        assert np.ptp(got[-500:]) < 1e-8
        assert abs(got[-1]) <= torque / RATE


@pytest.mark.parametrize("presliding", [1e-3, 5e-3])
def test_an_intended_presliding_follows_dahl(presliding: float) -> None:
    # The bristle integrated on its own in small steps, up to its bound; and Dahl's law, which never quite reaches it.
    torque, times = 0.2, np.linspace(0, 0.8, 401)

    def bristle(asymptote: float, bound: float) -> Array:
        def derivative(_: float, state: Array) -> list[float]:
            q, w, z = state
            slides = abs(z) >= bound and w * z > 0.0
            change = 0.0 if slides else (asymptote * w - abs(w) * z) / presliding
            damping = BRISTLE_DAMPING * LEAST_PRESLIDING / presliding if bound < np.inf else 0.0
            exerted = min(max(z + (damping * change if abs(z) < bound else 0.0), -bound), bound)
            return [w, (-RATE * q - torque * exerted) / INERTIA, change]

        solved = solve_ivp(derivative, (0, 0.8), [0.5, 0, 0], "LSODA", times, rtol=1e-8, atol=1e-10, max_step=5e-4)
        return np.asarray(solved.y[0])

    got = swing(leg({"coulomb_friction": {"torque": torque, "presliding": presliding}}), 0.5, 0.0, times)[:, 0]
    dahl = bristle(1.0, np.inf)
    assert np.abs(dahl - sliding_swing(0.5, torque, times)).max() > 3e-3
    np.testing.assert_allclose(got, bristle(ASYMPTOTE, 1.0), atol=1e-5)
    np.testing.assert_allclose(got, dahl, atol=1e-3)


def test_the_motion_is_continuous_as_presliding_goes_to_zero() -> None:
    times = np.linspace(0, 0.8, 81)
    swings = [
        swing(leg({"coulomb_friction": {"torque": 0.2, "presliding": give}}), 0.5, 0.0, times)[:, 0]
        for give in np.linspace(0, 4e-4, 17)
    ]
    moved = np.abs(np.diff(swings, axis=0)).max(axis=1)
    assert np.abs(swings[-1] - swings[0]).max() > 3e-3
    assert moved.max() < 1.5e-3


@pytest.mark.parametrize("push", [-0.9, 0.3, 0.97])
def test_friction_holds_a_smaller_torque_for_a_minute_without_creep(push: float) -> None:
    # held at rest against a spring that pushes with a share of the torque: Dahl's or a smoothed law would creep
    torque = 0.2
    made = leg({"coulomb_friction": {"torque": torque}}, damper=0.01)
    start = push * torque / RATE
    moved = swing(made, start, 0.0, np.linspace(0, 60, 601))[:, 0]
    assert np.abs(moved - start).max() < 1e-9


def test_a_push_below_the_friction_torque_bends_the_bristle_which_springs_back_in_part() -> None:
    # A known torque rises to 80 % and falls again. Dahl's law: presliding ln(1 / (1 - 0.8)) there, and back by
    # presliding ln(1 + 0.8): what remains is the hysteresis that he measured in bearings.
    torque, presliding = 0.2, 1e-3
    made = leg({"coulomb_friction": {"torque": torque, "presliding": presliding}}, rate=None, damper=3.0)  # no ringing
    moments = np.array([0.0, 1.0, 2.0, 3.0, 4.0])
    known = (moments, np.array([[0.0], [0.16], [0.16], [0.0], [0.0]]))
    angle = simulate(made, [0.0], [0.0], np.array([0.0, 2.0, 3.5]), known_torque=known, tolerance=1e-9)[:, 0]
    # With its asymptote half a per cent above the friction torque, at which ours slides.
    most = 0.8 / ASYMPTOTE
    assert angle[1] == pytest.approx(-presliding * math.log(1.0 - most), rel=1e-3)
    assert angle[2] == pytest.approx(-presliding * (math.log(1.0 - most) + math.log(1.0 + most)), rel=2e-3)
    assert angle[1] == pytest.approx(-presliding * math.log(1.0 - 0.8), rel=0.02)  # Dahl's own


@pytest.mark.parametrize("presliding", [0.0, LEAST_PRESLIDING, 2e-3])
def test_a_joint_that_creeps_moves_at_the_speed_that_its_pull_allows(presliding: float) -> None:
    # Half the friction torque: bent by as much as holds it, the bristle slips at that share of the creep speed.
    torque, creep = 0.2, 0.05
    made = leg({"coulomb_friction": {"torque": torque, "presliding": presliding, "creep": creep}}, rate=None)
    pull = (np.array([0.0, 2.0]), np.array([[0.1], [0.1]]))
    moved = simulate(made, [0.0], [0.0], np.array([0.0, 1.0, 2.0]), known_torque=pull, tolerance=1e-9, rates=True)
    bend = 0.5 if presliding > LEAST_PRESLIDING else bend_that_holds(0.5)
    np.testing.assert_allclose(moved[1:, 1], creep * bend, rtol=1e-3)


def test_a_joint_that_creeps_swings_as_with_a_smoothed_sign_and_comes_to_its_springs_rest() -> None:
    torque, creep, times = 0.2, 0.06, np.linspace(0, 6, 601)

    def derivative(_: float, state: Array) -> list[float]:
        q, w = state
        x = min(max(w / creep, -1.0), 1.0)
        return [w, (-RATE * q - 0.02 * w - torque * x * (1.5 - 0.5 * x * x)) / INERTIA]

    solved = solve_ivp(derivative, (0, 6), [0.5, 0.0], "LSODA", times, rtol=1e-9, atol=1e-11, max_step=1e-3)
    effect = {"torque": torque, "presliding": LEAST_PRESLIDING, "creep": creep}
    got, held = (
        swing(leg({"coulomb_friction": given}, damper=0.02), 0.5, 0.0, times)[:, 0]
        for given in (effect, {"torque": torque})
    )
    np.testing.assert_allclose(got, solved.y[0], atol=1e-6)
    assert abs(got[-1]) < 1e-3
    assert np.abs(held - solved.y[0]).max() > 0.01


def test_a_slow_pull_breaks_away_at_the_friction_torque() -> None:
    torque = 0.2
    made = leg({"coulomb_friction": {"torque": torque}}, rate=None)
    times = np.linspace(0, 2, 2001)
    ramp = (np.array([0.0, 2.0]), np.array([[0.0], [0.4]]))
    angle = simulate(made, [0.0], [0.0], times, known_torque=ramp, tolerance=1e-9)[:, 0]
    assert times[np.argmax(angle > LEAST_PRESLIDING)] == pytest.approx(1.0, abs=0.01)
    gone = times - 1.0  # from then on I q'' = 0.2 (t - 1)
    late = gone > 0.3
    np.testing.assert_allclose(angle[late], (0.2 / INERTIA * gone**3 / 6)[late], rtol=0.02)


def test_friction_acts_at_once_on_a_joint_that_starts_in_motion() -> None:
    torque, rate = 0.3, 2.0
    made = leg({"coulomb_friction": {"torque": torque}}, rate=None)
    times = np.linspace(0, 0.2, 21)
    angle = swing(made, 0.0, rate, times)
    stop = rate * INERTIA / torque
    running = np.minimum(times, stop)
    np.testing.assert_allclose(angle[:, 0], rate * running - torque / INERTIA * running**2 / 2, atol=1e-8)
    np.testing.assert_allclose(angle[times > stop + 1e-3, 1], 0.0, atol=1e-9)


def test_lanes_that_reverse_at_different_times_agree_with_single_runs() -> None:
    # sixteen strengths in one group, that share their steps and have their turns one after the other
    chain = compiled_chain(3)
    base, times = robot(damper=[0.3, 0.02, 0.01]), np.linspace(0, 1, 51)
    legs = LegLanes.of(base, 16)
    effect = next(effect for effect in chain.effects if effect.name == "coulomb_friction")
    strengths = np.linspace(0.002, 0.1, 16)
    legs.put(effect, 1, np.array([strengths, np.zeros(16), np.zeros(16)]))
    lanes = chain.lanes(legs)
    lanes[chain.layout.rows("rotation")] = np.array([[0.3], [-1.0], [0.7]])
    together = chain.run(lanes, times, 1e-8)
    alone = np.concatenate([chain.run(lanes[:, i : i + 1], times, 1e-8) for i in range(16)], axis=2)
    assert np.ptp(together[-1, 1]) > 0.01
    np.testing.assert_allclose(together, alone, atol=2e-6)


@pytest.mark.parametrize("tolerance", [1e-5, 1e-7])
def test_perturbed_copies_give_the_derivative(tolerance: float) -> None:
    # forward differences of 1e-6 in lanes that share their steps, against central ones of 1e-4 at a tight tolerance;
    # this is what a fit lives on, and what smoothing by many small steps, or events taken lane by lane, spoils
    chain = compiled_chain(3)
    base = robot(damper=[0.3, 0.02, 0.01]).with_joints(knee={"effects": {"coulomb_friction": {"torque": 0.02}}})
    layout, times = chain.layout, np.linspace(0, 1.5, 151)

    def lanes(change: Array) -> Array:
        made = np.repeat(chain.parameters(base)[:, None], change.shape[1], axis=1)
        made[layout.rows("rotation")] = np.array([[0.3], [-1.0], [0.7]])
        made[layout.rows("spring_rate")] *= np.exp(change[:3])
        made[layout.parameter_rows("coulomb_friction", 0)] *= np.exp(change[3])
        return made

    steps = np.concatenate([np.zeros((4, 1)), 1e-6 * np.eye(4)], axis=1)
    wide = chain.run(lanes(1e-4 * np.concatenate([np.eye(4), -np.eye(4)], axis=1)), times, 1e-10)
    expected = (wide[:, :, :4] - wide[:, :, 4:]) / 2e-4
    largest = np.abs(expected).max(axis=(0, 1))
    assert largest.min() > 0.01
    errors = []
    for near in (0.8 * tolerance, 0.9 * tolerance, tolerance, 1.1 * tolerance, 1.2 * tolerance):
        run = chain.run(lanes(steps), times, near)
        got = (run[:, :, 1:] - run[:, :, :1]) / 1e-6
        errors.append(float((np.sqrt(np.mean((got - expected) ** 2, axis=(0, 1))) / largest).max()))
    # The usual one: rounding alone decides whether a step happens to end near a turn, which costs a factor of up to six
    # (0.005 to 0.031 between 0.8e-5 and 1.2e-5; the median is 0.018 there, before and after the armature came in).
    assert np.median(errors) < (0.01 if tolerance < 1e-6 else 0.025)


def test_stribeck_holds_to_the_breakaway_torque_and_slides_with_less() -> None:
    # between T (1 - fall) and T: held at first, but once it slides, even slowly, it runs away
    friction = {"torque": 0.3, "fall": 0.6, "speed": 0.05}
    made = leg({"stribeck_friction": friction}, rate=None)
    held = (np.array([0.0, 1.0]), np.full((2, 1), 0.29))
    angle = simulate(made, [0.0], [0.0], np.linspace(0, 1, 11), known_torque=held)[:, 0]
    assert np.abs(angle).max() < LEAST_PRESLIDING
    moving = simulate(made, [0.0], [0.5], np.linspace(0, 1, 11), known_torque=held, rates=True)
    # far above the speed over which it falls: acceleration (0.29 - 0.12) / I
    assert moving[-1, 1] - moving[-2, 1] == pytest.approx(0.1 * (0.29 - 0.12) / INERTIA, rel=1e-3)


def test_stribeck_friction_agrees_with_scipy() -> None:
    friction = {"torque": 0.1, "fall": 0.7, "speed": 0.8}

    def derivative(_: float, state: Array, sense: float) -> list[float]:
        level = 0.1 * (0.3 + 0.7 * math.exp(-((state[1] / 0.8) ** 2)))
        return [state[1], (-RATE * state[0] - sense * level) / INERTIA]

    def stops(_: float, state: Array, sense: float) -> float:
        return float(state[1])

    stops.terminal = True  # type: ignore[attr-defined]
    times, state, begin = np.linspace(0, 1, 201), [0.5, 0.0], 0.0
    expected = np.empty_like(times)
    while begin < 1.0:
        sense = -math.copysign(1.0, state[0])
        piece = solve_ivp(
            derivative, (begin, 2.0), [state[0], sense * 1e-12], "DOP853", args=(sense,), events=stops,
            dense_output=True, rtol=1e-11, atol=1e-12,
        )  # fmt: skip
        now = times >= begin
        expected[now] = piece.sol(times[now])[0]
        begin, state = piece.t[-1], [piece.y[0, -1], 0.0]
        assert abs(state[0]) * RATE > 0.1  # it does not stick in this second
    # 1e-3 rad: the curve's exponential is (1 + s/16)^-16, up to 2 % of it too large
    got = swing(leg({"stribeck_friction": friction}), 0.5, 0.0, times)[:, 0]
    assert np.abs(got - expected).max() < 2e-3


def newton_forces(made: Leg, rotation: Array, step: float) -> Array:
    """(m - 2, n) N: force through each hinge, from second differences of the centres of mass of what hangs from it."""
    absolute = made.tilt + np.cumsum(rotation, axis=1)
    hinge = np.zeros((len(rotation), 2))
    momentum_rate = []
    for j, joint in enumerate(made.joints):
        along = np.stack([np.sin(absolute[:, j]), -np.cos(absolute[:, j])], axis=1)
        across = np.stack([np.cos(absolute[:, j]), np.sin(absolute[:, j])], axis=1)
        centre = hinge + joint.link.com * along + joint.link.com_across * across
        acceleration = (centre[2:] - 2 * centre[1:-1] + centre[:-2]) / step**2
        momentum_rate.append(joint.link.mass * (acceleration + np.array([0.0, made.gravity])))
        hinge = hinge + joint.link.length * along
    return np.linalg.norm(np.cumsum(momentum_rate[::-1], axis=0)[::-1], axis=2).T


@pytest.mark.parametrize("beside", [0.0, 0.03])
def test_the_bearing_force_satisfies_newtons_second_law(beside: float) -> None:
    joints = [replace(joint, link=replace(joint.link, com_across=beside)) for joint in robot().joints]
    made = replace(robot(), joints=tuple(joints), tilt=0.3)
    chain, step = compiled_chain(3), 1e-4
    states = simulate(made, [0.5, -1.8, 1.2], [0.0, 3.0, -4.0], np.arange(2001) * step, tolerance=1e-12, rates=True)
    expected = newton_forces(made, states[:, :3], step)
    at = np.arange(1, 2000, 125)[:16]
    workspace = np.repeat(chain.parameters(made)[:, None], 16, axis=1)
    workspace[chain.layout.rows("rotation")] = states[at, :3].T
    workspace[chain.layout.rows("rate")] = states[at, 3:].T
    chain.right_hand_side(workspace.reshape(-1))
    chain.bearing_forces(workspace.reshape(-1))
    got = workspace[chain.layout.rows("bearing_force")].T
    assert np.ptp(expected[at - 1], axis=0).min() > 0.1
    np.testing.assert_allclose(got, expected[at - 1], rtol=3e-5)  # differences over 1e-4 s


@pytest.mark.parametrize("tip_mass", [0.0, 0.4])
def test_friction_grows_with_the_weight_that_the_bearing_carries(tip_mass: float) -> None:
    # at rest straight down the bearing carries the weight: a slow pull breaks it away at radius times that
    radius = 0.02
    made = Leg("one", (Joint("joint", LINK, effects={"load_friction": {"radius": radius}}, damper=Damper(0.5)),))
    weight = (LINK.mass + tip_mass) * 9.81
    times = np.linspace(0, 25, 5001)
    ramp = (np.array([0.0, 25.0]), np.array([[0.0], [0.25]]))
    angle = simulate(made, [0.0], [0.0], times, Conditions(tip_mass=tip_mass), known_torque=ramp, tolerance=1e-9)[:, 0]
    broke = 0.01 * times[np.argmax(angle > LEAST_PRESLIDING)]
    assert broke == pytest.approx(radius * weight, abs=2e-3)


def test_friction_proportional_to_spring_torque_reduces_each_half_swing_by_a_share() -> None:
    # friction mu k |u|: each half swing goes out with k (1 + mu) and back with k (1 - mu); work balance over a half
    # swing from a to -b: k a^2 (1 - mu) = k b^2 (1 + mu)
    share = 0.1
    made = leg({"load_friction": {"share": share}})
    out, back = (math.pi / (2 * OMEGA * math.sqrt(1 + sign * share)) for sign in (1, -1))
    times = np.array([0.0, out + back, 2 * (out + back)])
    factor = math.sqrt((1 - share) / (1 + share))
    got = swing(made, 0.5, 0.0, times)[:, 0]
    np.testing.assert_allclose(got, [0.5, -0.5 * factor, 0.5 * factor**2], atol=1e-6)


@pytest.mark.parametrize(("passes", "off"), [(LOAD_PASSES, 1e-6), (30, 5e-3)])
def test_load_friction_in_a_leg_is_coulomb_friction_of_the_present_load(passes: int, off: float) -> None:
    """Of the force in the bearing that rubs: in so many passes, and within 5e-3 rad of what they converge to.

    Against solve_ivp with the force from the exact one-link formula: m (g cos q + c w^2) along, m (...) across. The
    forces of the same state without friction leave 25e-3 rad.
    """
    radius = 0.05
    made = Leg("one", (Joint("joint", LINK, spring=Spring(RATE, 0.4), effects={"load_friction": {"radius": radius}}),))
    mass, com = LINK.mass, LINK.com

    def acceleration(q: float, friction: float) -> float:
        return (-RATE * (q - 0.4) - mass * 9.81 * com * math.sin(q) + friction) / INERTIA

    def derivative(_: float, state: Array) -> list[float]:
        q, w = state
        along, friction = mass * (com * w * w + 9.81 * math.cos(q)), 0.0
        for _ in range(passes):
            across = mass * (com * acceleration(q, friction) + 9.81 * math.sin(q))
            friction = radius * math.hypot(across, along)
        return [w, acceleration(q, friction)]

    def stops(_: float, state: Array) -> float:
        return float(state[1])

    stops.terminal, stops.direction = True, 1.0  # type: ignore[attr-defined]
    times = np.linspace(0, 0.14, 29)
    half = solve_ivp(
        derivative, (0, 1), [1.2, -1e-12], "DOP853", events=stops, dense_output=True, rtol=1e-11, atol=1e-12
    )
    assert half.t[-1] > 0.14
    got = simulate(made, [1.2], [0.0], times, tolerance=1e-9)[:, 0]
    np.testing.assert_allclose(got, half.sol(times)[0], atol=off)


def test_a_soft_bearing_follows_dahl_s_own_law_to_a_part_in_a_thousand() -> None:
    """Of its swing, 0.5 rad, at 0.01 rad of presliding: with a bristle damped by 1 ms it was ten of them."""
    torque, presliding, times = 0.2, 1e-2, np.linspace(0, 0.8, 401)

    def dahl(_: float, state: Array) -> list[float]:
        q, w, z = state
        return [w, (-RATE * q - torque * z) / INERTIA, (w - abs(w) * z) / presliding]

    solved = solve_ivp(dahl, (0, 0.8), [0.5, 0, 0], "RK45", times, rtol=1e-8, atol=1e-10, max_step=1e-3)
    got = swing(leg({"coulomb_friction": {"torque": torque, "presliding": presliding}}), 0.5, 0.0, times)[:, 0]
    np.testing.assert_allclose(got, solved.y[0], atol=5e-4)


def test_a_turn_and_turn_back_within_one_step_is_found_beside_a_known_torque_too() -> None:
    """Of no torque, so that the leg moves as it does without one; one short reversal was stepped over."""
    joints = [
        Joint(
            f"j{i}",
            Link(0.2 - 0.03 * i, 0.7 / (1 + i), 0.09, 3.5e-3 / (1 + 2 * i)),
            spring=Spring(4.0 / (1 + i), 0.0),
            damper=Damper(0.01 / (1 + i)),
            effects={"coulomb_friction": {"torque": 0.3 / (1 + i), "presliding": 0.0}},
        )
        for i in range(3)
    ]
    made, times = Leg("three", tuple(joints), 9.81), np.linspace(0.0, 2.0, 2001)
    generator = np.random.default_rng(1)
    starts = [(generator.uniform(-1, 1, 3), generator.uniform(-5, 5, 3)) for _ in range(4)]
    exact = simulate(made, *starts[3], times, tolerance=1e-10)
    none = times[::1000], np.zeros((3, 3))
    assert np.abs(simulate(made, *starts[3], times, known_torque=none) - exact).max() < 1e-5
