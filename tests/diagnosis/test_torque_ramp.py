"""The slow torque that is suggested as a next trial: where it takes the leg."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq

from diagnosis.simulated_releases import ONE, TWO, recorded
from synth.diagnosis.angle_trials import angle_trial
from synth.diagnosis.plants.swinging_chain import chain_menu
from synth.diagnosis.plants.swinging_chain.chain_menu import RAMP_SHARE, holding_torque, menu
from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo, TorqueDrive
from synth.fit.recordings import recordings
from synth.swing.chain import Conditions
from synth.swing.leg_model import Damper, Joint, Leg, Link
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


@pytest.mark.parametrize(
    ("drive", "what"),
    [
        (None, "a torque on knee that rises slowly to 0.36 N m in 3 s"),
        (TorqueDrive(GearedMotor(np.inf, 0.01, 40.0, 0.9, 0.0)), "a current of knee that rises slowly to 1 A in 3 s"),
        (
            Servo(0.0, motor=GearedMotor(2.0, 0.01, 40.0, 0.9, 0.0), open_duty=1.0),
            "a voltage on knee that rises slowly to 2 V in 3 s",
        ),
    ],
)
def test_a_ramp_is_told_as_what_the_drive_takes(drive: Servo | TorqueDrive | None, what: str) -> None:
    joint = Joint("knee", Link(0.2, 0.3, 0.1, 1e-3), drive=drive, sign=-1)
    assert chain_menu._ramp_text(joint, 0.36) == what + " and is recorded"
    ramp = chain_menu._imagined_release(Leg("one", (joint,)), np.ones(1), np.zeros(1), Conditions(), (0, 0.36))
    if isinstance(drive, Servo):
        assert ramp.recording.known_torque is None
        assert ramp.recording.signals is not None
        end = ramp.recording.signals.supply[-1, 0]
        torque = float(drive.torque(np.zeros(1), np.zeros(1), end)[0])  # on q
    else:
        assert ramp.recording.known_torque is not None
        torque = float(ramp.recording.known_torque[1][-1, 0])
    assert torque == pytest.approx(-0.36)
