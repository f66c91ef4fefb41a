"""The slow torque that is suggested as a next trial: where it takes the leg."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq

from diagnosis.simulated_releases import ONE, TWO, recorded
from synth.diagnosis.angle_trials import angle_trial
from synth.diagnosis.plants.swinging_chain.chain_menu import RAMP_SHARE, holding_torque, menu
from synth.fit.recordings import recordings
from synth.swing.leg_model import Damper, Leg
from synth.swing.mechanics import coefficients, rest_pose, static_torque


def ramps(leg: Leg, away: float) -> list[tuple[str, float, float]]:
    trials = recorded(leg, away=away * np.array([[1.0], [0.6]]), time=np.arange(601) * 0.01, held_out=0)
    known = [angle_trial(each, held_out=False) for each in recordings(leg, trials, ())]
    found = [item.ramp for item in menu(leg, SimpleNamespace(noise=np.full(1, 1e-3)), known)]  # type: ignore[arg-type]
    return [ramp for ramp in found if ramp is not None]


@pytest.mark.parametrize("away", [0.5, -0.5])
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("room", [None, 0.1])
def test_a_ramp_goes_towards_the_widest_release_and_keeps_the_range(away: float, sign: int, room: float | None) -> None:
    """It pushed in the positive sense always: 20 deg beyond all that was recorded, and 17 beyond the joint's range."""
    leg = ONE.with_joints(knee={"sign": sign, "damper": Damper(0.2)})
    rest = rest_pose(leg)[0]
    if room is not None:
        ends = sorted(leg.to_measured(np.array([rest + side * room]))[0] for side in (-1.0, 1.0))
        leg = leg.with_joints(knee={"range": tuple(ends)})
    ((_, torque, _),) = ramps(leg, away)
    gravity = coefficients(leg)

    def off(q: float) -> float:
        pose = np.array([q])
        moment = leg.spring_rate * (pose - leg.rest) + static_torque(gravity, pose, leg.tilt)
        return float(moment[0]) - sign * torque

    end = brentq(off, rest - 1.5, rest + 1.5) - rest
    start = leg.rest[0] + away - rest  # of the widest release
    expected = np.sign(start) * min(RAMP_SHARE * abs(start), np.inf if room is None else room)
    assert end == pytest.approx(expected, abs=0.02)


def test_other_joints_give_way() -> None:
    rest = rest_pose(TWO)
    torque = holding_torque(TWO, rest, 0, 0.3)
    held = rest_pose(TWO, start=rest + np.array([0.3, 0.0]), held=[0])
    load = static_torque(coefficients(TWO), held, TWO.tilt) + TWO.spring_rate * (held - TWO.rest)
    assert load == pytest.approx([torque, 0.0], abs=1e-9)
    assert holding_torque(TWO, rest, 0, 0.0) == 0.0
