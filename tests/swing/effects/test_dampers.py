"""Damping that is not linear: terminal speed, and free runs with a closed form."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from swing.effects.one_joint import INERTIA, OMEGA, RATE, leg, swing
from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, DamperCurve


@pytest.mark.parametrize(("loss", "speed", "knee"), [(0.6, 0.4, 2.0), (0.9, 1.5, 0.7)])
def test_a_thinning_damper_has_the_terminal_speed_of_its_curve(loss: float, speed: float, knee: float) -> None:
    rate, torque = 0.3, 0.5
    made = leg({"shear_thinning_damping": {"loss": loss, "speed": speed, "knee": knee}}, rate=None, damper=rate)
    known = (np.array([0.0, 100.0]), np.full((2, 1), torque))
    final = simulate(made, [0.0], [0.0], np.array([0.0, 99.0, 100.0]), known_torque=known, tolerance=1e-9, rates=True)

    def left(w: float) -> float:
        return rate * w * (1 + (w / speed) ** knee) ** (-loss / knee) - torque

    expected = brentq(left, 1e-6, 1e4)
    assert expected > 1.3 * torque / rate  # it does thin
    assert final[-1, 1] == pytest.approx(expected, rel=1e-6)


def test_a_thinning_damper_keeps_its_rate_at_low_speed() -> None:
    effects = {"shear_thinning_damping": {"loss": 0.8, "speed": 5.0}}
    times = np.linspace(0, 1, 51)
    slow, linear = (swing(leg(e, damper=0.05), 1e-3, 0.0, times)[:, 0] for e in (effects, {}))
    np.testing.assert_allclose(slow, linear, atol=1e-9)


def test_a_curve_shear_thins_like_a_linear_rate() -> None:
    effects = {"shear_thinning_damping": {"loss": 0.5, "speed": 0.5}}
    straight = Damper(curve=DamperCurve((1.0, 2.0, 8.0), (0.05, 0.1, 0.4)))
    times = np.linspace(0, 1, 51)
    with_rate = leg(effects, damper=0.05)
    with_curve = with_rate.with_joints(joint={"damper": straight})
    np.testing.assert_allclose(swing(with_curve, 0.5, 0.0, times), swing(with_rate, 0.5, 0.0, times), atol=1e-7)


def test_quadratic_drag_slows_a_free_joint_as_one_over_time() -> None:
    # I w' = -c w |w|: w = w0 / (1 + c w0 t / I), q = I / c ln(1 + c w0 t / I)
    c, w0, times = 0.02, 5.0, np.linspace(0, 5, 51)
    states = swing(leg({"quadratic_damping": {"coefficient": c}}, rate=None), 0.0, w0, times)
    growth = 1 + c * w0 * times / INERTIA
    np.testing.assert_allclose(states[:, 1], w0 / growth, atol=1e-7)
    np.testing.assert_allclose(states[:, 0], INERTIA / c * np.log(growth), atol=1e-7)


def test_cubic_drag_slows_it_as_one_over_the_root_of_time() -> None:
    c, w0, times = 0.005, 5.0, np.linspace(0, 5, 51)
    effects = {"quadratic_damping": {"coefficient": c, "exponent": 3.0}}
    states = swing(leg(effects, rate=None), 0.0, -w0, times)
    np.testing.assert_allclose(states[:, 1], -w0 / np.sqrt(1 + 2 * c * w0**2 * times / INERTIA), atol=1e-7)


def test_the_envelope_of_a_swing_falls_as_one_over_time() -> None:
    # averaging: A = A0 / (1 + 4 c w A0 t / (3 pi I)); Nayfeh & Mook, *Nonlinear Oscillations*, section 3.3.2
    c, start = 0.002, 0.6
    cycles = np.arange(0, 41, 10)
    got = swing(leg({"quadratic_damping": {"coefficient": c}}), start, 0.0, cycles * 2 * np.pi / OMEGA)[:, 0]
    expected = start / (1 + 4 * c * OMEGA * start * cycles * 2 * np.pi / OMEGA / (3 * np.pi * INERTIA))
    assert pytest.approx(INERTIA * OMEGA**2) == RATE
    assert expected[-1] < 0.25 * start
    np.testing.assert_allclose(got, expected, rtol=0.01)
