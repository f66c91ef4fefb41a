"""The slow torque that is suggested as a next trial, and releases of driven legs: what they simulate and say."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq

from diagnosis.simulated_releases import AWAY, ONE, TIME, TWO, recorded
from synth.diagnosis.angle_trials import angle_trial
from synth.diagnosis.next_experiment import _gain_text, _TrialInformation
from synth.diagnosis.plants.swinging_chain import chain_menu
from synth.diagnosis.plants.swinging_chain.chain_menu import RAMP_SHARE, holding_torque, menu
from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo, TorqueDrive
from synth.files.trial_list import read_trials
from synth.fit.recordings import recordings
from synth.swing.chain import Conditions, simulate
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
        (TorqueDrive(), "a torque on knee that rises slowly to 0.36 N m in 3 s"),
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


@pytest.mark.parametrize("voltage", [True, False])
def test_the_planned_trials_of_driven_legs_are_those_that_the_entry_reads(voltage: bool, tmp_path: Path) -> None:
    """Nothing said that windings are open; without columns they were refused, at 0 V they brake."""
    motor = GearedMotor(2.0, 0.015, 30.0, 1.0, 1e-6)
    drive = Servo(0.0, motor=motor, open_duty=1.0) if voltage else TorqueDrive(motor)
    leg = TWO.with_joints(hip={"drive": drive}, knee={"drive": drive})
    known = [angle_trial(each, held_out=False) for each in recordings(TWO, recorded(TWO, held_out=0), ())]
    items = menu(leg, SimpleNamespace(noise=np.full(2, 1e-3)), known)  # type: ignore[arg-type]
    release, ramp = items[3], next(item for item in items if item.ramp is not None)
    assert release.state == "with the windings of hip and knee open"
    assert ramp.state == f"with the winding of {'knee' if ramp.ramp and ramp.ramp[0] == 'hip' else 'hip'} open"
    told = _TrialInformation(1.0, 1.0, 1.0)
    words = "A release from the other side, with the windings of hip and knee open, would give most information: 1 bit."
    assert _gain_text(release, told, [], None) == words
    rows = [f"{t},{a},{b}" for t, (a, b) in zip(TIME, np.degrees(leg.to_measured(AWAY[[0] * len(TIME)])), strict=True)]
    (tmp_path / "trials").mkdir()
    (tmp_path / "trials" / "next.csv").write_text("\n".join(["time [s],hip [deg],knee [deg]", *rows]) + "\n")
    (trial,) = read_trials([release.keys], tmp_path, leg)
    start = list(leg.to_rotation(np.array([[*release.release.values()]]))[0])
    assert trial.torques is None
    assert (trial.signals is not None) == voltage
    as_read = simulate(leg, start, [0.0, 0.0], TIME, signals=trial.signals)
    planned = simulate(leg, start, [0.0, 0.0], TIME, signals=release.trial.recording.signals)
    np.testing.assert_allclose(as_read, planned, atol=2e-6)  # steps of the integrator
    if voltage:  # only the ramp's winding is fed
        assert ramp.keys["drive_off"] == ["knee" if ramp.ramp and ramp.ramp[0] == "hip" else "hip"]
        fed = ramp.trial.recording.signals
        assert fed is not None
        assert np.flatnonzero(fed.enabled.any(axis=0)) == [leg.joint_names.index(ramp.ramp[0] if ramp.ramp else "")]
