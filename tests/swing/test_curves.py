"""Torque-speed curves: the clamped sum against interpolation, thinning, and what the compiled chain makes of them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from synth.model_checks.other_engine import _torque
from synth.swing.chain import compiled_chain
from synth.swing.damper_curves import clamps, compiled_rows, thin, thinning_error, torque_at, with_rate
from synth.swing.lane_layout import CURVE_POINTS
from synth.swing.leg_model import Damper, DamperCurve, Joint, Leg, Link


@st.composite
def curves(draw: st.DrawFn, most: int = CURVE_POINTS) -> DamperCurve:
    steps = draw(st.lists(st.floats(0.01, 3.0), min_size=1, max_size=most))
    rises = draw(st.lists(st.floats(0.0, 2.0), min_size=len(steps), max_size=len(steps)))
    return DamperCurve(tuple(np.cumsum(steps).tolist()), tuple(np.cumsum(rises).tolist()))


@given(curves(), st.lists(st.floats(-100, 100), min_size=1, max_size=20))
def test_curve_is_odd_and_linear_between_its_points_and_along_the_last_segment_beyond(
    curve: DamperCurve, speeds: list[float]
) -> None:
    speed, torque = np.array([0.0, *curve.speed]), np.array([0.0, *curve.torque])
    at = np.array(speeds)
    slope = (torque[-1] - torque[-2]) / (speed[-1] - speed[-2])
    beyond = torque[-1] + slope * (np.abs(at) - speed[-1])
    expected = np.sign(at) * np.where(np.abs(at) > speed[-1], beyond, np.interp(np.abs(at), speed, torque))
    np.testing.assert_allclose(torque_at(curve, at), expected, atol=1e-9 * (1 + np.abs(expected).max()))
    np.testing.assert_array_equal(torque_at(curve, -at), -torque_at(curve, at))


@given(curves())
def test_points_are_met_and_short_curves_are_not_thinned(curve: DamperCurve) -> None:
    np.testing.assert_allclose(
        torque_at(curve, np.array(curve.speed)), curve.torque, atol=1e-12 + 1e-9 * curve.torque[-1]
    )
    assert thin(curve) == curve


@given(curves(most=30))
def test_thinning_keeps_some_of_the_points_and_the_last(curve: DamperCurve) -> None:
    thinned = thin(curve)
    assert len(thinned.speed) == min(len(curve.speed), CURVE_POINTS)
    assert (thinned.speed[-1], thinned.torque[-1]) == (curve.speed[-1], curve.torque[-1])
    pairs = set(zip(curve.speed, curve.torque, strict=True))
    assert pairs.issuperset(zip(thinned.speed, thinned.torque, strict=True))


def test_thinning_drops_points_on_a_chord_first_and_gives_its_error() -> None:
    # a bend at 1 rad/s with 40 points on its two straight lines loses nothing
    speed = np.linspace(0.05, 2.0, 40)
    bent = DamperCurve(tuple(speed), tuple(np.where(speed < 1, 0.3 * speed, 0.3 + 0.1 * (speed - 1))))
    assert thinning_error(bent) < 1e-12
    # chords over 12 spans of speed^0.45 cost at most a few per cent
    power = DamperCurve(tuple(speed), tuple(speed**0.45))
    thinned = thin(power)
    by_hand = np.abs(np.interp(speed, [0, *thinned.speed], [0, *thinned.torque]) - speed**0.45).max() / 2**0.45
    assert thinning_error(power) == pytest.approx(by_hand, abs=1e-12)
    assert 1e-4 < by_hand < 0.02


FALLING = DamperCurve((0.2, 0.5, 1.6, 2.1), (0.05, 0.08, 0.135, 0.12))


@pytest.mark.parametrize("speed", [0.1, 1.9, 2.1, 6.7, 100.0])
def test_a_curve_that_falls_at_its_end_keeps_its_last_torque_and_never_drives(speed: float) -> None:
    expected = np.interp(speed, [0.0, *FALLING.speed], [0.0, *FALLING.torque])
    assert torque_at(FALLING, np.array(speed)) == pytest.approx(expected)
    assert torque_at(FALLING, np.array(-speed)) == pytest.approx(-expected)
    assert _torque(FALLING, speed) == pytest.approx(expected)  # of the independent engine
    beside = torque_at(with_rate(FALLING, 0.01), np.array(speed))
    assert beside == pytest.approx(expected + 0.01 * speed)  # held, with a linear damper that goes on


def test_padding_adds_nothing() -> None:
    curve = DamperCurve((1.0, 2.0), (0.1, 0.15))
    speed, slope = compiled_rows(curve)
    assert len(speed) == len(slope) == CURVE_POINTS
    at = np.linspace(-5, 5, 31)[:, None]
    np.testing.assert_allclose(
        np.sum(slope * np.clip(at, -speed, speed), axis=1), torque_at(curve, at[:, 0]), atol=1e-15
    )
    assert np.count_nonzero(slope) == len(clamps(curve)[0])


@pytest.mark.parametrize("speed", [-40.0, -1.5, -0.3, 0.0, 0.3, 1.0, 7.0])
def test_the_compiled_chain_takes_the_curve_as_it_is(speed: float) -> None:
    # one link without gravity: acceleration = -torque / inertia
    curve = DamperCurve((0.5, 1.0, 4.0), (0.2, 0.25, 0.3))
    link = Link(0.2, 0.5, 0.1, 2e-3)
    leg = Leg("one", (Joint("hip", link, damper=Damper(curve=curve)),), gravity=0.0)
    chain = compiled_chain(1)
    workspace = np.repeat(chain.parameters(leg)[:, None], 16, axis=1)
    workspace[chain.layout.row("rate")] = speed
    chain.extra_torques(workspace.reshape(-1), 1, chain.acting.active(workspace)[1])
    chain.right_hand_side(workspace.reshape(-1))
    expected = -torque_at(curve, np.array(speed)) / (2e-3 + 0.5 * 0.1**2)
    np.testing.assert_allclose(workspace[chain.layout.row("acceleration")], expected, rtol=1e-13, atol=1e-13)
