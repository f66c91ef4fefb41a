"""Play and stops: free flight, rest in the gap, contact time, rebound; and what the smooth law of play errs."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from swing.effects.one_joint import INERTIA, OMEGA, RATE, leg, swing
from synth.swing.chain import compiled_chain, simulate

Array = NDArray[np.float64]


def test_zero_backlash_changes_nothing() -> None:
    times = np.linspace(0, 1, 51)
    plain, none = (swing(leg(e, damper=0.02), 0.5, 0.0, times) for e in ({}, {"backlash": {"gap": 0.0}}))
    np.testing.assert_array_equal(plain, none)


def test_the_joint_moves_freely_through_the_gap() -> None:
    made, speed = leg({"backlash": {"gap": 0.2}}, damper=0.02), 0.5
    times = np.linspace(0, 0.19, 20)  # starts in the middle, meets the flank after 0.2 s
    np.testing.assert_allclose(swing(made, 0.0, speed, times)[:, 0], speed * times, atol=1e-9)


def test_inside_the_gap_the_joint_rests_at_any_angle() -> None:
    made = leg({"backlash": {"gap": 0.2}}, damper=0.02)
    for start in (-0.09, 0.0, 0.05):
        assert swing(made, start, 0.0, [0.0, 5.0])[-1, 0] == pytest.approx(start, abs=1e-12)


@pytest.mark.parametrize("pull", [0.4, -0.9])
def test_a_slow_pull_crosses_half_the_gap_and_then_meets_the_spring(pull: float) -> None:
    made = leg({"backlash": {"gap": 0.2}}, damper=0.3)
    known = (np.array([0.0, 20.0]), np.full((2, 1), pull))
    settled = simulate(made, [0.0], [0.0], np.array([0.0, 20.0]), known_torque=known, tolerance=1e-9)[-1, 0]
    assert settled == pytest.approx(math.copysign(0.1, pull) + pull / RATE, abs=1e-5)


def linear(deflection: float) -> float:
    return RATE * deflection


def play(start: float, gap: float, damper: float, times: Array, spring: Callable[[float], float] = linear) -> Array:
    """Rigid flanks and a massless output side on spring and damper, from event to event.

    While it pushes, the joint has spring and damper; when the force turns to a pull they part: the joint is free and
    the output side goes back by itself, b z' = -k z, until the joint meets a flank again.
    """
    half, flank = 0.5 * gap, math.copysign(1.0, start)
    state, begin, touching = [start, 0.0, start - flank * half], 0.0, True
    angle = np.empty_like(times)

    def together(_: float, s: Array) -> list[float]:
        return [s[1], (-spring(s[2]) - damper * s[1]) / INERTIA, s[1]]

    def apart(_: float, s: Array) -> list[float]:
        return [s[1], 0.0, -spring(s[2]) / damper]

    while begin < times[-1]:
        if touching:
            event = lambda _, s, side=flank: side * (spring(s[2]) + damper * s[1])  # noqa: E731
            event.direction = -1.0
        else:
            event = lambda _, s: abs(s[0] - s[2]) - half  # noqa: E731
            event.direction = 1.0
        event.terminal = True
        piece = solve_ivp(
            together if touching else apart, (begin, begin + 5.0), state, "DOP853", dense_output=True, events=event,
            rtol=1e-11, atol=1e-12,
        )  # fmt: skip
        now = times >= begin
        angle[now] = piece.sol(times[now])[0]
        begin, state = piece.t[-1], list(piece.y[:, -1])
        touching = not touching
        if touching:
            flank = math.copysign(1.0, state[0] - state[2])
    return angle


@pytest.mark.parametrize(("gap", "damper"), [(0.05, 0.05), (0.2, 0.05), (0.1, 0.15), (0.02, 0.02), (0.05, 0.005)])
@pytest.mark.parametrize("tolerance", [1e-6, 1e-9])
def test_backlash_swings_like_rigid_flanks(gap: float, damper: float, tolerance: float) -> None:
    times = np.linspace(0, 0.8, 401)
    expected = play(0.5, gap, damper, times)
    got = swing(leg({"backlash": {"gap": gap}}, damper=damper), 0.5, 0.0, times, tolerance)[:, 0]
    plain = swing(leg({}, damper=damper), 0.5, 0.0, times)[:, 0]
    assert np.abs(plain - expected).max() > 0.02
    assert np.abs(got - expected).max() < 6e-5


LAWS = {
    "one_sided_spring": {"loss_above": 0.6, "loss_below": 0.2},
    "hardening_spring": {"stiffening": 2.0, "exponent": 2.0, "softening": 0.8},
    "shear_thinning_damping": {"loss": 0.8, "speed": 0.1},
}


@pytest.mark.parametrize("name", LAWS)
def test_in_the_gap_a_law_of_spring_or_damper_is_not_felt(name: str) -> None:
    """It took the joint's own angle and rate: what a spring or damper lacks there pushed the joint on."""
    made, speed = leg({"backlash": {"gap": 0.2}, name: LAWS[name]}, damper=0.02), 0.5
    times = np.linspace(0, 0.19, 20)  # from the middle; the flank comes after 0.2 s
    np.testing.assert_allclose(swing(made, 0.0, speed, times)[:, 0], speed * times, atol=1e-9)
    assert swing(made, 0.06, 0.0, [0.0, 5.0])[-1, 0] == pytest.approx(0.06, abs=1e-12)


def two_rates(deflection: float) -> float:
    return RATE * deflection * (0.4 if deflection > 0.0 else 0.8)


def hardening(deflection: float) -> float:
    softened = RATE * deflection / math.sqrt(1.0 + (0.8 * deflection) ** 2)
    return softened + math.copysign(2.0 * deflection**2, deflection)


@pytest.mark.parametrize(("name", "law"), [("one_sided_spring", two_rates), ("hardening_spring", hardening)])
def test_a_law_of_the_spring_takes_the_deflection_behind_the_gap(name: str, law: Callable[[float], float]) -> None:
    times, gap = np.linspace(0, 0.8, 401), 0.1
    expected = play(0.5, gap, 0.05, times, law)
    got = swing(leg({"backlash": {"gap": gap}, name: LAWS[name]}, damper=0.05), 0.5, 0.0, times)[:, 0]
    assert np.abs(play(0.5, gap, 0.05, times) - expected).max() > 0.02
    assert np.abs(got - expected).max() < 6e-5


def test_perturbed_copies_with_backlash_give_the_derivative() -> None:
    # the moment of each contact, where the force jumps, moves with what is perturbed
    chain = compiled_chain(1)
    layout, times = chain.layout, np.linspace(0, 0.8, 81)
    base = chain.parameters(leg({"backlash": {"gap": 0.05}}, damper=0.03))
    base[layout.row("rotation")] = 0.5

    def lanes(change: Array) -> Array:
        made = np.repeat(base[:, None], change.shape[1], axis=1)
        made[layout.row("spring_rate")] *= np.exp(change[0])
        made[layout.row("damper_rate")] *= np.exp(change[1])
        made[layout.row("backlash")] *= np.exp(change[2])
        return made

    run = chain.run(lanes(np.concatenate([np.zeros((3, 1)), 1e-6 * np.eye(3)], axis=1)), times, 1e-6)[:, 0]
    got = (run[:, 1:] - run[:, :1]) / 1e-6
    wide = chain.run(lanes(1e-4 * np.concatenate([np.eye(3), -np.eye(3)], axis=1)), times, 1e-10)[:, 0]
    expected = (wide[:, :3] - wide[:, 3:]) / 2e-4
    largest = np.abs(expected).max(axis=0)
    assert largest.min() > 0.01
    assert (np.abs(got - expected).max(axis=0) / largest).max() < 0.02


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("exponent", [1.0, 1.5])
def test_the_contact_time_of_a_stop_follows_from_its_stiffness(sign: int, exponent: float) -> None:
    # a free joint at speed v: exponent 1 gives pi sqrt(I / K); else 2 x v^-1 int dy / sqrt(1 - y^(n+1)), x the deepest
    # (Goldsmith, *Impact* (1960), section 4.2, for n = 3/2)
    stiffness, speed, zero, end = 50.0, 2.0, 0.3, 0.7
    made = leg(
        {"joint_stop": {"upper": end, "stiffness": stiffness, "exponent": exponent, "depth": 1.0}},
        rate=None,
        sign=sign,
        zero=zero,
    )
    deepest = ((exponent + 1) * INERTIA * speed**2 / (2 * stiffness)) ** (1 / (exponent + 1))
    one = 1 / (exponent + 1)
    integral = math.sqrt(math.pi) * math.gamma(1 + one) / math.gamma(0.5 + one)
    contact = 2 * deepest / speed * integral
    if exponent == 1.0:
        assert contact == pytest.approx(math.pi * math.sqrt(INERTIA / stiffness))
    reached = 0.2 / speed
    times = np.array([0.0, reached, reached + contact / 2, reached + contact, reached + contact + 0.1])
    states = swing(made, sign * (end - 0.2 - zero), sign * speed, times, 1e-10)
    measured = zero + sign * states[:, 0]
    np.testing.assert_allclose(measured, end + np.array([-0.2, 0.0, deepest, 0.0, -0.1 * speed]), atol=1e-6)
    np.testing.assert_allclose(sign * states[:, 1], speed * np.array([1.0, 1.0, 0.0, -1.0, -1.0]), atol=2e-4)


@pytest.mark.parametrize("exponent", [1.0, 1.5])
def test_a_lossy_stop_rebounds_as_hunt_and_crossley_say(exponent: float) -> None:
    # v dv / (1 + d v) = -K x^n dx / I: whatever n, v - ln(1 + d v) / d is the same before and after
    damping, speed = 0.15, 3.0
    effects = {"joint_stop": {"lower": -0.5, "stiffness": 80.0, "damping": damping, "exponent": exponent, "depth": 1.0}}
    after = swing(leg(effects, rate=None), 0.0, -speed, [0.0, 0.5], 1e-9)[-1, 1]

    def work(v: float) -> float:
        return v - math.log(1 + damping * v) / damping

    expected = brentq(lambda v: work(-v) - work(speed), 1e-3, speed)
    assert expected < 0.85 * speed
    assert after == pytest.approx(expected, rel=1e-6)


def test_a_stop_holds_a_leaning_joint_and_lets_the_swing_pass_before_it() -> None:
    made = leg({"joint_stop": {"upper": 0.3, "stiffness": 200.0, "damping": 1.0}}, damper=0.1, free_angle=0.5)
    settled = swing(made, 0.0, 0.0, [0.0, 10.0])[-1, 0]
    assert settled == pytest.approx((200 * 0.3 + RATE * 0.5) / (200 + RATE), abs=1e-8)
    times = np.linspace(0, 1, 51)
    inside = leg({"joint_stop": {"upper": 0.3, "lower": -0.3, "stiffness": 200.0}})
    np.testing.assert_allclose(swing(inside, 0.29, 0.0, times)[:, 0], 0.29 * np.cos(OMEGA * times), atol=1e-8)
