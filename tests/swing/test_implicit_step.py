"""The implicit step of bent damper curves: closed forms, scipy, the explicit step, derivatives, where it is used."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fit.simulated_legs import robot
from synth.arrays import Array
from synth.parts.damper_law import power_law_curve
from synth.swing.chain import Chain, Conditions, compiled_chain, simulate
from synth.swing.damper_curves import clamps, torque_at
from synth.swing.leg_model import Damper, DamperCurve, Joint, Leg, Link, Spring
from synth.swing.mechanics import coefficients, mass_matrix, momentum_and_force
from synth.swing.stage_rows import AT_SHARES, INTEGRAL, NODES, SHARE_WEIGHTS, WEIGHTS

LINK = Link(0.2, 0.74, 0.091, 3.5e-3)
ABOUT_HINGE = LINK.inertia + LINK.mass * LINK.com**2
TIMES = np.linspace(0.0, 1.0, 201)
# rad at the usual tolerance of 1e-6; a curve with one sharp bend is nearly dry friction, and steps end at that bend
LARGEST = {"power law": 3e-6, "measured": 3e-6, "friction with a linear rate": 1e-6}
FREE = Conditions()
MEASURED = DamperCurve((0.05, 0.2, 0.5, 1.5, 4.0), (0.05, 0.11, 0.17, 0.29, 0.42))


def power_law(scale: float = 1.0, exponent: float = 0.45) -> DamperCurve:
    return power_law_curve(scale, 5.0, exponent)


def damped_robot(curves: list[DamperCurve]) -> Leg:
    """The three-link robot with a curve at each joint."""
    leg = robot()
    return leg.with_joints(
        **{joint.name: {"damper": Damper(curve=curve)} for joint, curve in zip(leg.joints, curves, strict=True)}
    )


CURVES = {
    "power law": [power_law(6.0), power_law(0.6), power_law(0.3)],
    "measured": [DamperCurve(MEASURED.speed, tuple(k * t for t in MEASURED.torque)) for k in (6.0, 0.6, 0.3)],
    "friction with a linear rate": [DamperCurve((0.05, 5.0), (k * 0.5, k * 1.0)) for k in (4.0, 0.4, 0.1)],
}


def explicit(chain: Chain) -> Chain:
    """The same chain without the implicit step."""
    return replace(chain, sources={name: text for name, text in chain.sources.items() if name != "curves"})


def counted(chain: Chain) -> tuple[Chain, list[int]]:
    """The chain, and a list that receives the steps of each group of lanes by the implicit step."""
    counting, steps = replace(chain), []
    seen, *called = chain._curves

    def integrate(*arguments: Any) -> Any:
        found = seen(*arguments)
        steps.append(found[0])
        return found

    counting.__dict__["_curves"] = (integrate, *called)
    return counting, steps


def lanes_of(leg: Leg, rotation: list[float], conditions: Conditions = FREE) -> tuple[Chain, Array]:
    chain = compiled_chain(len(leg.joints))
    lane = chain.parameters(leg, conditions)
    lane[chain.layout.rows("rotation")] = rotation
    return chain, lane[:, None]


def test_stages_integrate_polynomials_exactly() -> None:
    for k in range(3):  # collocation at three nodes
        np.testing.assert_allclose(INTEGRAL @ NODES**k, NODES ** (k + 1) / (k + 1), rtol=1e-13)
    for k in range(5):  # order 5 at the end of the step
        assert WEIGHTS @ NODES**k == pytest.approx(1.0 / (k + 1), rel=1e-13)


def test_an_averaged_torque_is_the_stages_own_where_the_curve_is_straight() -> None:
    # discontinuous Galerkin with Radau quadrature is Radau IIA: mean over the step of l_i l_m is b_i for i = m, else 0
    found = np.einsum("k,ki,km->im", SHARE_WEIGHTS, AT_SHARES, AT_SHARES)
    np.testing.assert_allclose(found, np.diag(WEIGHTS), atol=1e-14)


def passes(curve: DamperCurve, rate: float, inertia: float) -> tuple[Array, Array, Array]:
    """Speeds of the curve's points below ``rate``, with times and angles at which a free joint slows down to them.

    On a segment with torque a + b w the speed obeys I dw/dt = -(a + b w), so t = I/b ln((a + b w0)/(a + b w)) and the
    angle is I (w0 - w)/b - a t / b.
    """
    clamp_speed, clamp_slope = clamps(curve)
    speeds = [rate, *[s for s in clamp_speed[::-1] if s < rate]]
    times, angles = [0.0], [0.0]
    for fast, slow in pairwise(speeds):
        middle = 0.5 * (fast + slow)
        b = float(clamp_slope[clamp_speed > middle].sum())
        a = float(torque_at(curve, np.array(middle))) - b * middle
        spent = inertia / b * np.log((a + b * fast) / (a + b * slow))
        times.append(times[-1] + spent)
        angles.append(angles[-1] + inertia * (fast - slow) / b - a * spent / b)
    return np.array(speeds), np.array(times), np.array(angles)


@pytest.mark.parametrize("curve", [power_law(0.05), power_law(0.05, 0.3), MEASURED], ids=["0.45", "0.3", "measured"])
def test_a_free_joint_slows_down_as_the_closed_form_says(curve: DamperCurve) -> None:
    leg = Leg("one", (Joint("hip", LINK, damper=Damper(curve=curve)),), gravity=0.0)
    speeds, times, angles = passes(curve, 4.9, ABOUT_HINGE)
    motion = simulate(leg, [0.0], [4.9], times, rates=True)
    np.testing.assert_allclose(motion[:, 0], angles, rtol=3e-6, atol=3e-6)
    np.testing.assert_allclose(motion[:, 1], speeds, atol=3e-4)


def test_a_power_law_stops_a_free_joint_in_finite_time() -> None:
    # I dw/dt = -T w^p gives w^(1-p) = w0^(1-p) - (1-p) T t / I; a curve of twelve points is within 2 % of the law
    exponent, torque = 0.45, 0.05
    curve = power_law_curve(torque, 1.0, exponent, lowest_speed=1e-3)
    leg = Leg("one", (Joint("hip", LINK, damper=Damper(curve=curve)),), gravity=0.0)
    stop = ABOUT_HINGE / torque / (1.0 - exponent)  # from 1 rad/s
    times = np.linspace(0.0, 0.9 * stop, 10)
    speed = simulate(leg, [0.0], [1.0], times, rates=True)[:, 1]
    np.testing.assert_allclose(speed ** (1.0 - exponent), 1.0 - times / stop, atol=0.02)
    assert abs(simulate(leg, [0.0], [1.0], np.array([0.0, 1.2 * stop]), rates=True)[-1, 1]) < 1e-3


def by_scipy(leg: Leg, rotation: list[float], times: Array) -> Array:
    """Rotations by scipy's Radau on the equations of ``mechanics``, which the compiled chain does not use."""
    known, n = coefficients(leg), len(leg.joints)

    def derivative(_: float, state: Array) -> Array:
        q, w = state[:n], state[n:]
        mass = mass_matrix(known, q, leg.tilt)
        _, force = momentum_and_force(known, q[None], w[None], leg.tilt)
        # ``momentum_and_force``: d(momentum)/dt = force + torque, and momentum = mass matrix times rates
        change = 1e-7
        before, after = (mass_matrix(known, q + sign * change * w, leg.tilt) @ w for sign in (-1.0, 1.0))
        torque = -leg.spring_rate * (q - leg.rest)
        for j, joint in enumerate(leg.joints):
            curve = joint.damper.curve if joint.damper else None
            assert curve is not None
            torque[j] -= torque_at(curve, w[j])
        rates = np.linalg.solve(mass, force[0] + torque - (after - before) / (2.0 * change))
        return np.concatenate([w, rates])

    start = np.concatenate([rotation, np.zeros(n)])
    solved = solve_ivp(derivative, (0.0, times[-1]), start, "Radau", times, rtol=1e-8, atol=1e-9)
    return np.asarray(solved.y[:n].T)


@pytest.mark.parametrize("name", CURVES)
def test_three_links_agree_with_scipy(name: str) -> None:
    leg, times = damped_robot(CURVES[name]), np.linspace(0.0, 0.2, 21)
    expected = by_scipy(leg, [0.5, -0.9, 0.6], times)
    assert np.abs(simulate(leg, [0.5, -0.9, 0.6], np.zeros(3), times) - expected).max() < LARGEST[name]


@pytest.mark.parametrize(
    "conditions",
    [Conditions(), Conditions(locked=(1,)), Conditions(locked=(0, 2), tilt=0.2), Conditions(tip_mass=0.3)],
    ids=["free", "knee locked", "hip and ankle locked", "tip mass"],
)
@pytest.mark.parametrize("name", CURVES)
def test_it_agrees_with_the_explicit_step(name: str, conditions: Conditions) -> None:
    chain, lanes = lanes_of(damped_robot(CURVES[name]), [0.5, -0.9, 0.6], conditions)
    counting, steps = counted(chain)
    found = counting.run(lanes, TIMES, rates=True)
    expected = explicit(chain).run(lanes, TIMES, 1e-9, rates=True, max_steps=10**6)
    assert len(steps) == 1
    assert np.abs(found - expected)[:, :3].max() < LARGEST[name]
    assert np.abs(found - expected)[:, 3:].max() < 2e-3
    locked = list(conditions.locked)
    np.testing.assert_array_equal(found[:, locked], np.repeat(found[:1, locked], len(TIMES), axis=0))


@pytest.mark.parametrize("n", [1, 2, 4])
def test_chains_of_other_lengths(n: int) -> None:
    joint = Joint("joint", LINK, spring=Spring(2.0, 0.3), damper=Damper(curve=power_law(0.4)))
    chain, lanes = lanes_of(Leg("chain", (joint,) * n), [0.4] * n)
    counting, steps = counted(chain)
    expected = explicit(chain).run(lanes, TIMES, 1e-9, max_steps=10**6)
    assert np.abs(counting.run(lanes, TIMES) - expected).max() < 3e-6
    assert len(steps) == 1


def test_it_takes_far_fewer_steps() -> None:
    chain, lanes = lanes_of(damped_robot(CURVES["power law"]), [0.5, -0.9, 0.6])
    counting, steps = counted(chain)
    counting.run(lanes, TIMES)
    assert steps[0] < 300  # the explicit step takes more than a thousand


def test_a_slower_clock_changes_nothing() -> None:
    chain, lanes = lanes_of(damped_robot(CURVES["power law"]), [0.5, -0.9, 0.6])
    counting, steps = counted(chain)
    assert np.abs(counting.run(lanes, TIMES, unit=2.5) - counting.run(lanes, TIMES)).max() < 6e-6
    assert len(steps) == 2


def test_lanes_give_derivatives() -> None:
    """A perturbed copy in the same group differs by the derivative of the exact motion, within 1 %."""
    leg, change = damped_robot(CURVES["power law"]), 1e-4
    chain, lane = lanes_of(leg, [0.5, -0.9, 0.6])
    lanes = np.repeat(lane, 4, axis=1)
    slopes = lanes[chain.layout.rows("curve_slope")]
    slopes[:, 1] *= 1.0 + change
    lanes[chain.layout.row("spring_rate", 1), 2] *= 1.0 + change
    lanes[chain.layout.row("rest"), 3] += change
    found, exact = chain.run(lanes, TIMES), explicit(chain).run(lanes, TIMES, 1e-11, max_steps=10**6)
    for k in (1, 2, 3):
        derivative, expected = ((motion[:, :, k] - motion[:, :, 0]) / change for motion in (found, exact))
        assert np.abs(derivative - expected).max() < 0.01 * np.abs(expected).max()


def different_legs() -> tuple[Chain, Array]:
    """Sixteen legs, the dampers of the last four times as strong as those of the first."""
    chain, lane = lanes_of(damped_robot(CURVES["power law"]), [0.5, -0.9, 0.6])
    lanes = np.repeat(lane, 16, axis=1)
    lanes[chain.layout.rows("curve_slope")] *= np.geomspace(0.5, 2.0, 16)
    return chain, lanes


def test_different_legs_step_on_their_own() -> None:
    chain, lanes = different_legs()
    counting, steps = counted(chain)
    together = counting.run(lanes, TIMES)
    alone = np.concatenate([counting.run(lanes[:, k : k + 1], TIMES) for k in range(16)], axis=2)
    assert np.abs(together - alone).max() < 2.0 * LARGEST["power law"]
    assert steps[0] < 0.4 * sum(steps[1:])  # many of them end in the same iteration


def test_a_lost_lane_leaves_the_others_alone() -> None:
    chain, lanes = different_legs()
    expected = chain.run(lanes, TIMES)
    lanes[chain.layout.row("spring_rate"), 5] = np.nan
    found = chain.run(lanes, TIMES)
    assert np.isnan(found[1:, :, 5]).all()
    others = [k for k in range(16) if k != 5]
    assert np.abs(found - expected)[:, :, others].max() < 2.0 * LARGEST["power law"]


def test_where_it_is_used() -> None:
    def used(leg: Leg) -> bool:
        chain, lanes = lanes_of(leg, [0.3] * len(leg.joints))
        return "curves" in chain.sources and chain.acting.bends(chain.acting.active(lanes), lanes)

    bent = damped_robot(CURVES["power law"])
    assert used(bent)
    straight = DamperCurve((1.0, 2.0), (0.1, 0.2))
    thickening = DamperCurve((1.0, 2.0), (0.1, 0.4))
    assert not used(damped_robot([straight] * 3))
    assert not used(damped_robot([thickening] * 3))
    assert not used(robot())
    assert not used(bent.with_joints(hip={"effects": {"coulomb_friction": {"torque": 0.05}}}))
    joint = Joint("joint", LINK, damper=Damper(curve=power_law(0.4)))
    assert not used(Leg("five", (joint,) * 5))


def test_a_driven_leg_keeps_the_explicit_step() -> None:
    chain, lanes = lanes_of(damped_robot(CURVES["power law"]), [0.5, -0.9, 0.6])
    counting, steps = counted(chain)
    counting.run(lanes, TIMES[:21], known_torque=(TIMES, np.full((len(TIMES), 3), 0.01)))
    assert steps == []


def test_a_lost_motion_is_nan_from_there_on() -> None:
    chain, lanes = lanes_of(damped_robot(CURVES["power law"]), [0.5, -0.9, 0.6])
    found = chain.run(lanes, TIMES, max_steps=30)
    lost = np.isnan(found).any(axis=(1, 2))
    assert lost.any()
    assert not lost[0]
    assert np.all(np.diff(lost.astype(int)) >= 0)
    lanes[chain.layout.row("spring_rate")] = np.nan
    assert np.isnan(chain.run(lanes, TIMES)[1:]).all()
