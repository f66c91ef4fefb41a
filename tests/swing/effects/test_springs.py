"""Springs that are not linear: exact periods, loop area, relaxation; and the same sums in scipy."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.special import ellipk

from swing.effects.one_joint import INERTIA, OMEGA, RATE, Array, leg, swing
from synth.swing.effects import effect_named
from synth.swing.effects.spring_hysteresis import loaded
from synth.swing.effects.torque_along_motion import AlongMotion, torque_along


@pytest.mark.parametrize("stiffening", [6.0, -3.0])
def test_hardening_spring_has_duffings_period(stiffening: float) -> None:
    # q'' + a q + b q^3 = 0: T = 4 K(m) / sqrt(a + b A^2), m = b A^2 / (2 (a + b A^2)); Kovacic & Brennan, *The Duffing
    # Equation* (2011), section 3.2
    a, b, amplitude = RATE / INERTIA, stiffening / INERTIA, 0.7
    stiff = a + b * amplitude**2
    period = 4 * ellipk(b * amplitude**2 / (2 * stiff)) / math.sqrt(stiff)
    times = np.arange(13) * period / 4
    angle = swing(leg({"hardening_spring": {"stiffening": stiffening}}), amplitude, 0.0, times, 1e-11)[:, 0]
    np.testing.assert_allclose(angle / amplitude, np.resize([1.0, 0.0, -1.0, 0.0], 13), atol=1e-7)


def test_hardening_from_zero_with_exponent_one_is_another_rate() -> None:
    # what the effect says of itself in ``becomes``; here in the angle, to the 1e-9 rad of the formula's onset
    (simpler,) = effect_named("hardening_spring").becomes
    assert simpler.name == "spring_rate"
    times, extra, reach = np.linspace(0.0, 1.0, 41), -3.0, 0.3
    hard = leg({"hardening_spring": {"stiffening": extra * reach, "reach": reach, **simpler.where}})
    joint = hard.joints[0]
    assert joint.spring is not None
    plain = replace(hard, joints=(replace(joint, spring=replace(joint.spring, rate=RATE + extra), effects={}),))
    one, other = (swing(made, 0.7, 0.0, times, 1e-11)[:, 0] for made in (hard, plain))
    np.testing.assert_allclose(one, other, atol=1e-7)


def test_a_softening_spring_has_the_period_of_its_energy_integral() -> None:
    # torque k u / sqrt(1 + (s u)^2), energy k (sqrt(1 + (s u)^2) - 1) / s^2; T = 4 int du / speed, u = A sin x
    s, amplitude = 2.5, 0.8

    def energy(u: float) -> float:
        return RATE * (math.sqrt(1 + (s * u) ** 2) - 1) / s**2

    def slowness(x: float) -> float:
        left = energy(amplitude) - energy(amplitude * math.sin(x))
        return amplitude * math.cos(x) / math.sqrt(2 * left / INERTIA)

    period = 4 * quad(slowness, 0, math.pi / 2 - 1e-9, epsabs=1e-12)[0]
    times = np.arange(9) * period / 4
    effects = {"hardening_spring": {"stiffening": 0.0, "softening": s}}
    angle = swing(leg(effects), amplitude, 0.0, times, 1e-11)[:, 0]
    np.testing.assert_allclose(angle / amplitude, np.resize([1.0, 0.0, -1.0, 0.0], 9), atol=1e-6)


def test_a_bumper_has_the_period_of_a_bilinear_spring() -> None:
    # rate k up to the onset, k + c beyond: a quarter is asin-time inside and a phase outside
    onset, extra, amplitude = 0.3, 12.0, 0.5
    within = RATE / INERTIA
    beyond = (RATE + extra) / INERTIA
    centre = extra * onset / (RATE + extra)  # the outer line's rest
    speed = math.sqrt(beyond * ((amplitude - centre) ** 2 - (onset - centre) ** 2))
    top = math.hypot(onset, speed / math.sqrt(within))
    outer = math.acos((onset - centre) / (amplitude - centre)) / math.sqrt(beyond)
    quarter = outer + math.asin(onset / top) / math.sqrt(within)
    times = np.arange(9) * quarter
    effects = {"hardening_spring": {"stiffening": extra, "exponent": 1.0, "onset": onset}}
    angle = swing(leg(effects), amplitude, 0.0, times, 1e-10)[:, 0]
    np.testing.assert_allclose(angle / amplitude, np.resize([1.0, 0.0, -1.0, 0.0], 9), atol=1e-6)


def test_a_diagnosis_takes_no_stop_for_a_bumper() -> None:
    # from an onset a spring becomes at most four rates stiffer; a power of the whole deflection, and softening, stay
    made, reach = leg({"hardening_spring": {"stiffening": 1.0}}), 0.1
    given = np.array([[9.0 * RATE * reach, 1.0, reach, 0.2, 0.0], [9.0 * RATE, 3.0, 1.0, 0.0, 0.0],
                      [-9.0 * RATE, 1.0, 1.0, 0.2, 0.0], [2.0 * RATE * reach, 1.0, reach, 0.2, 0.0]]).T  # fmt: skip
    kept = effect_named("hardening_spring").function("bounded")(made, 0, 1.0, given)
    assert kept[0, 0] == pytest.approx(4.0 * RATE * reach)
    np.testing.assert_array_equal(kept[1:], given[1:])
    np.testing.assert_array_equal(kept[:, 1:], given[:, 1:])


@pytest.mark.parametrize("sign", [1, -1])
def test_a_one_sided_springs_halves_have_their_own_periods(sign: int) -> None:
    # half periods pi sqrt(I/k1) and pi sqrt(I/k2); "above" is meant in measured angle, about a free angle
    zero, free = 0.4, 1.1
    made = leg({"one_sided_spring": {"loss_above": 0.75}}, sign=sign, zero=zero, free_angle=free)
    above, below = math.pi / (OMEGA * math.sqrt(0.25)), math.pi / OMEGA
    times = np.cumsum([0.0, above / 2, below / 2, below / 2, above / 2])
    measured = 0.2 * np.array([1.0, 0.0, -0.5, 0.0, 1.0])  # half the amplitude where it is four times as stiff
    got = swing(made, sign * (free + 0.2 - zero), 0.0, times, 1e-10)[:, 0]
    np.testing.assert_allclose(zero + sign * got - free, measured, atol=1e-6)


def test_the_changeover_is_rounded_over_its_width_about_its_shift() -> None:
    effect = effect_named("one_sided_spring")
    u = np.linspace(-0.5, 0.5, 1001)
    time, none = np.arange(1001.0), np.zeros(1001)
    torque = torque_along(effect, AlongMotion(time, u, none, u, RATE, 0.0, none, 0.0), [1.0, 0.0, 0.1, 0.02])
    sharp = RATE * np.maximum(u - 0.1, 0.0)
    far = np.abs(u - 0.1) > 0.2
    np.testing.assert_allclose((torque - sharp)[far], -0.5 * RATE * 0.02, rtol=0.01, atol=0.5 * RATE * 0.02 * 0.06)
    slope = np.gradient(torque, u)
    assert slope[600] == pytest.approx(RATE / 2, rel=1e-3)
    np.testing.assert_allclose(slope, 0.5 * RATE * (1 + (u - 0.1) / np.hypot(u - 0.1, 0.02)), atol=2e-3 * RATE)


def test_a_slipping_springs_loop_has_its_area() -> None:
    # knee 1: from the turn at A it unloads along z = u to zero, then z = slip (1 - exp(-x / slip)) over the rest of
    # 2A - slip; the area is twice the work of one way
    stiffness, slip, amplitude = 3.0, 0.05, 0.6
    effect = effect_named("spring_hysteresis")
    time = np.linspace(0, 3 * 2 * math.pi, 30001)
    q, w = amplitude * np.sin(time), amplitude * np.cos(time)
    motion = AlongMotion(time, q, w, q, RATE, 0.0, 0.0 * w, 0.0)
    torque = torque_along(effect, motion, [stiffness, slip, 1e9, 1.0, 0.0, 0.0])
    last = slice(20000, 30001)
    area = -np.trapezoid(torque[last], q[last])
    rest = 2 * amplitude - slip
    one_way = -(slip**2) / 2 + slip * (rest - slip * (1 - math.exp(-rest / slip)))
    assert area == pytest.approx(2 * stiffness * one_way, rel=1e-3)


def test_a_relaxing_spring_relaxes_in_its_time() -> None:
    effect = effect_named("spring_hysteresis")
    stiffness, relaxation = 3.0, 0.4
    time = np.linspace(0, 2, 2001)
    q = np.minimum(time / 0.01, 1.0) * 0.2
    motion = AlongMotion(time, q, np.gradient(q, time), q, RATE, 0.0, 0.0, 0.0)
    torque = torque_along(effect, motion, [stiffness, 1e9, relaxation, 1.5, 0.0, 0.0])
    held = time > 0.05
    # the ramp's own relaxation makes it as if it had begun in its middle
    np.testing.assert_allclose(torque[held], -0.6 * np.exp(-(time[held] - 0.005) / relaxation), rtol=2e-3)


@pytest.mark.parametrize(
    "case",
    [
        {"slip": 0.08, "knee": 1.5},
        {"slip": 0.3, "knee": 3.0},
        {"slip": 0.2, "knee": 2.0, "unloading": 0.6},
        {"slip": 0.2, "knee": 2.0, "unloading": -0.3, "settled": 0.2},
        {"relaxation": 0.2},
    ],
)
def test_hysteresis_agrees_with_scipy(case: dict[str, float]) -> None:
    """Wen's law in his own parameters, loaded slowly from where it settled to the release at 0.5 rad."""
    stiffness, slip, tau, knee = (
        2.0,
        case.get("slip", math.inf),
        case.get("relaxation", math.inf),
        case.get("knee", 1.5),
    )
    gamma = (1.0 - case.get("unloading", 0.0)) / 2
    beta = 1.0 - gamma

    def memory(w: float, z: float) -> float:
        bent = abs(z / slip)
        return w - beta * abs(w) * bent**knee * np.sign(z) - gamma * w * bent**knee

    def derivative(_: float, state: Array) -> list[float]:
        q, w, z = state
        return [w, (-RATE * q - stiffness * z) / INERTIA, memory(w, z) - z / tau]

    times, way = np.linspace(0, 1, 101), 0.5 - case.get("settled", 0.0)
    before = solve_ivp(lambda _, z: [memory(1.0, z[0])], (0, way), [0.0], "DOP853", rtol=1e-10).y[0, -1]
    begin = [0.5, 0.0, before if slip < math.inf else 0.0]
    expected = solve_ivp(derivative, (0, 1), begin, "DOP853", times, rtol=1e-10, atol=1e-11, max_step=1e-3).y[0]
    # 5e-6 rad at tolerance 1e-9, of the steps that load the spring before the release, and 5e-5 at 1e-6: the memory has
    # a kink where loading turns to unloading
    got = [
        swing(leg({"spring_hysteresis": {"stiffness": stiffness} | case}), 0.5, 0.0, times, tol)[:, 0]
        for tol in (1e-9, 1e-6)
    ]
    assert np.abs(got[0] - expected).max() < 5e-6
    assert np.abs(got[1] - expected).max() < 5e-5


@pytest.mark.parametrize(("knee", "closed"), [(1.0, lambda x: 1 - np.exp(-x)), (2.0, np.tanh)])
def test_a_hand_loads_a_slipping_spring_as_in_the_closed_form(knee: float, closed: Callable[[Array], Array]) -> None:
    travel = np.linspace(-12.0, 12.0, 97)
    expected = np.sign(travel) * closed(np.abs(travel))
    np.testing.assert_allclose(loaded(travel, np.full_like(travel, knee)), expected, atol=1e-3)
