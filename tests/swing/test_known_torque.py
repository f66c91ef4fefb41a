"""Known torques denser than the motion's samples: no pulse is stepped over, no impulse is lost, noise costs no more."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from synth.drives.servo import Servo, ServoSignals
from synth.swing import driven_steps
from synth.swing.chain import Conditions, compiled_chain, simulate
from synth.swing.known_torque import average_torques
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

LINK = Link(0.2, 0.5, 0.1, 2e-3)
INERTIA = LINK.inertia + LINK.mass * LINK.com**2
LEG = Leg("one", (Joint("hinge", LINK, 0.0, spring=Spring(3.0, 0.1), damper=Damper(0.02)),), 0.0)
TIMES = np.linspace(0.0, 1.0, 21)


def reference(moments: np.ndarray, torque: np.ndarray) -> np.ndarray:
    """The same motion piece by piece between the torque's knots, by scipy."""
    state, kept, at = np.array([0.4, 0.0]), {0.0: 0.4}, np.unique(np.r_[moments, TIMES])

    def derivative(time: float, x: np.ndarray) -> list[float]:
        return [x[1], (np.interp(time, moments, torque) - 3.0 * (x[0] - 0.1) - 0.02 * x[1]) / INERTIA]

    for start, stop in pairwise(at.tolist()):
        state = solve_ivp(derivative, (start, stop), state, "DOP853", rtol=1e-10, atol=1e-12).y[:, -1]
        kept[float(stop)] = float(state[0])
    return np.array([kept[float(t)] for t in TIMES])


@pytest.mark.parametrize("begins", np.linspace(0.4, 0.45, 6).tolist())
def test_a_short_pulse_between_quiet_times_is_not_stepped_over(begins: float) -> None:
    moments = np.round(np.linspace(0.0, 1.0, 10_001), 7)
    torque = np.where((moments > begins) & (moments < begins + 1e-3), 5.0, 0.0)
    edges = np.flatnonzero(np.diff(torque) != 0.0)
    knots = np.unique(np.concatenate([[0], edges, edges + 1, [10_000]]))
    got = simulate(LEG, [0.4], [0.0], TIMES, known_torque=(moments, torque[:, None]), tolerance=1e-9)[:, 0]
    np.testing.assert_allclose(got, reference(moments[knots], torque[knots]), atol=1e-7)


def test_a_noisy_torque_is_followed_within_the_steps_that_a_fit_has() -> None:
    """Every knot is a bend: a step that does not end there is refused time and again."""
    generator = np.random.default_rng(3)
    moments = np.linspace(0.0, 1.0, 2001)
    torque = 0.5 * np.sin(9.0 * moments) + 0.05 * generator.standard_normal(len(moments))
    chain = compiled_chain(1)
    lanes = np.repeat(chain.parameters(LEG)[:, None], 16, axis=1)
    lanes[chain.layout.rows("rotation")] = 0.4
    got = chain.run(lanes, TIMES, 1e-7, known_torque=(moments, torque[:, None]), max_steps=500)
    np.testing.assert_allclose(got[:, 0, 0], reference(moments, torque), atol=2e-6)


def test_the_average_keeps_a_line_and_every_impulse() -> None:
    grid = 0.01 * np.arange(51)
    moments = np.unique(np.random.default_rng(5).uniform(-0.02, 0.52, 400))
    line = average_torques((moments, np.stack([3.0 - 2.0 * moments, 0.0 * moments], axis=1)), grid)
    np.testing.assert_allclose(line[:, 0], 3.0 - 2.0 * grid, atol=1e-9)
    torque = np.where((moments > 0.2) & (moments < 0.204), 7.0, 0.0)
    found = average_torques((moments, torque[:, None]), grid)[:, 0]
    assert 0.01 * found.sum() == pytest.approx(np.trapezoid(torque, moments), rel=1e-9)
    fine = np.linspace(0.19, 0.22, 300_001)
    between = np.interp(fine, moments, torque)
    assert float(grid @ found / found.sum()) == pytest.approx(float(fine @ between / between.sum()), abs=1e-7)


def test_a_step_that_is_tried_again_sees_the_knots_before_its_stages() -> None:
    """The stages leave the cursor at the end of the longer step; a diagnosis of friction ran without end there."""
    times = np.arange(10) * 0.1
    torques = np.zeros((10, 1))
    torques[3] = 1.0  # no straight line leads past it
    known = times, torques, np.array([1e-3])
    expected = driven_steps.within_torque(known, 0, 0.05, 0.5, 100)
    assert expected == pytest.approx((0.15, 1, 0.05))  # past the flat knot at 0.1, to that at 0.2
    for ahead in (3, 6, 9):
        assert driven_steps.within_torque(known, ahead, 0.05, 0.5, 100) == pytest.approx(expected)


@pytest.mark.parametrize("ends", [0.1, 0.35])
def test_a_known_torque_keeps_its_ends_beyond_its_samples(ends: float) -> None:
    """As with the same samples and one more of the last value; it went on along its last slope."""
    moments, torque = np.array([0.02, ends]), np.array([0.05, 0.2])
    held = np.array([0.0, *moments, 1.5]), np.array([0.05, *torque, 0.2])
    got = simulate(LEG, [0.4], [0.0], TIMES, known_torque=(moments, torque[:, None]), tolerance=1e-9)[:, 0]
    np.testing.assert_allclose(got, reference(*held), atol=1e-7)


def test_a_servo_s_signals_keep_their_ends_too() -> None:
    arm, moments = replace(LEG, joints=(replace(LEG.joints[0], drive=Servo(2.0, 0.1)),)), np.array([0.0, 0.1])
    wave, one = np.array([[0.0], [0.3]]), np.ones((2, 1))
    short = ServoSignals(moments, wave, one, one)
    long = ServoSignals(np.array([0.0, 0.1, 1.5]), *(np.vstack([rows, rows[-1:]]) for rows in (wave, one, one)))
    first, second = (simulate(arm, [0.4], [0.0], TIMES, signals=each, tolerance=1e-9) for each in (short, long))
    np.testing.assert_allclose(first, second, atol=1e-7)


def test_a_single_sample_is_refused() -> None:
    """It acted on nothing, without a word."""
    with pytest.raises(ValueError, match="1 sample of a known torque or signal: give at least two"):
        simulate(LEG, [0.4], [0.0], TIMES, known_torque=(np.zeros(1), np.full((1, 1), 5.0)))


def test_a_locked_joint_s_rate_is_zero() -> None:
    two = replace(LEG, joints=(LEG.joints[0], replace(LEG.joints[0], name="other")))
    states = ([0.0, 3.0], [0.0, 0.0])
    one, other = (simulate(two, [0.4, 0.2], rate, TIMES, Conditions((1,))) for rate in states)
    np.testing.assert_array_equal(one, other)
    assert np.ptp(one[:, 1]) == 0.0
