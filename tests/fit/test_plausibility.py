"""Impossible input is refused or named, and possible input gives no warning."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fit.simulated_legs import NAMES, bare, releases, robot
from robustness.random_legs import random_case
from synth.api.fitting import read_fit
from synth.batch.one_fit import ready
from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo, ServoSignals
from synth.errors import UserError
from synth.files.drive_columns import signals as servo_signals
from synth.files.leg_file import read_leg, write_leg
from synth.files.trial_list import Trial
from synth.fit import plausibility
from synth.fit.estimate import fit_leg, least_residuals
from synth.fit.fit_options import LegFitOptions
from synth.fit.leg_plausibility import leg_doubts
from synth.fit.plausibility import (
    _in_convention,
    _residual_left,
    convention_doubts,
    doubts,
    recording_doubts,
)
from synth.fit.recordings import Recording, recordings
from synth.fit.uncertainty import sample_scatter
from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring
from synth.validation.thesis_data import read_lab_data

EXAMPLE = Path(__file__).resolve().parents[2] / "synth" / "examples" / "fit"
LAB = Path(__file__).resolve().parents[3] / "shared" / "aarl"


def changed(leg: Leg, joint: int, **values: object) -> Leg:
    """The leg with another convention at one joint."""
    joints = list(leg.joints)
    joints[joint] = replace(joints[joint], **values)  # type: ignore[arg-type]
    return replace(leg, joints=tuple(joints))


def with_link(leg: Leg, joint: int, **values: float) -> Leg:
    """The leg with other numbers of one link."""
    return changed(leg, joint, link=replace(leg.joints[joint].link, **values))


def test_a_correct_leg_gives_no_plausibility_warning() -> None:
    leg, trials = bare(robot()), releases(robot(), 3)
    made = recordings(leg, trials)
    assert doubts(leg, made, fit_leg(leg, made)) == ()
    for seed in range(1, 13):
        case = random_case(seed)
        assert recording_doubts(case.bare, recordings(case.bare, case.trials)) == []


def test_impossible_link_inertia_and_com_are_named() -> None:
    leg = robot()
    link = leg.joints[1].link
    (heavy,) = leg_doubts(with_link(leg, 1, inertia=2.0 * link.mass * link.length**2))
    assert heavy.startswith("knee: the link's inertia is 2 times its mass by its length squared")
    (outside,) = leg_doubts(with_link(leg, 1, com=1.2 * link.length))
    assert "outside the link's" in outside
    (unlike,) = leg_doubts(with_link(leg, 2, mass=1e-4 * leg.joints[0].link.mass, inertia=1e-9))
    assert unlike.startswith("hip and ankle: link masses of")
    shank = leg.joints[2].link
    (long,) = leg_doubts(with_link(leg, 2, length=1e3 * shank.length, com=1e3 * shank.com))
    assert long.startswith("ankle and hip: link lengths of") or long.startswith("ankle and knee: link lengths of")
    assert long.endswith("mm, more than 300 to one; check their units (mm, m)")


def test_an_inertia_in_other_units_is_refused_with_its_line(tmp_path: Path) -> None:
    leg = robot()
    write_leg(with_link(leg, 0, inertia=1e4 * leg.joints[0].link.inertia), tmp_path / "a.leg.yaml")
    with pytest.raises(UserError, match="lengths of the link; check the units") as refused:
        read_leg(tmp_path / "a.leg.yaml")
    assert refused.value.problems[0].line
    assert "inertia" in str(refused.value.problems[0])


def test_milliseconds_labelled_as_seconds_are_named() -> None:
    leg, trials = bare(robot()), releases(robot(), 3)
    slow = recordings(leg, [replace(trial, time=1e3 * trial.time) for trial in trials])
    (text,) = recording_doubts(leg, slow)
    assert text.endswith("are the times milliseconds, labelled as seconds?")
    fast = recordings(leg, [replace(trial, time=1e-3 * trial.time) for trial in trials])
    assert recording_doubts(leg, fast)[0].endswith("is the clock right?")


def test_frozen_channels_are_named() -> None:
    leg, (trial, *_) = bare(robot()), releases(robot(), 3)
    angles = trial.angles.copy()
    first = len(angles) // 16
    angles[first : 3 * first, 1] = angles[first, 1]
    (text,) = recording_doubts(leg, recordings(leg, [replace(trial, angles=angles)], ()))
    assert "knee reads the same from 0.06" in text
    angles = trial.angles.copy()
    angles[:, 2] = angles[0, 2]
    (text,) = recording_doubts(leg, recordings(leg, [replace(trial, angles=angles)], ()))
    assert "ankle reads the same from 0.000" in text
    held = replace(trial, angles=angles, locked=("ankle",))
    assert recording_doubts(leg, recordings(leg, [held], ())) == []


@pytest.mark.parametrize("joint", [*(pytest.param(j, marks=pytest.mark.slow) for j in (0, 1)), 2])
def test_a_wrong_joint_sign_is_detected(joint: int) -> None:
    leg, trials = robot(), releases(robot(), 3)
    right = leg.joints[joint].sign
    wrong = bare(changed(leg, joint, sign=-right))
    made = recordings(wrong, trials)
    found = fit_leg(wrong, made)
    (text,) = convention_doubts(wrong, made, found)
    assert text.endswith(f"Sign or zero of the {NAMES[joint]}?")
    assert f"with sign: {right:+d} of the {NAMES[joint]} a fit of the same trials leaves" in text
    # Both figures are the same measure of fits of the same samples.
    before, after = (float(each) for each in re.findall(r"leaves (\S+) deg", text))
    rms = [np.array(list(found.rms.values())), least_residuals(bare(leg), recordings(bare(leg), trials), "common")]
    assert [before, after] == pytest.approx([float(np.degrees(np.sqrt(np.mean(each**2)))) for each in rms], rel=0.06)


def test_a_change_that_suits_few_samples_only_is_not_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two trials of the lab's rat fitted with another zero, and all of them no better than with its own."""
    leg, trials = bare(robot()), releases(robot(), 3)
    made = recordings(leg, trials)
    found = fit_leg(leg, made)
    away = [
        replace(trial, fitted=trial.measured + 0.15 * (trial.measured - trial.measured[-1])) for trial in found.trials
    ]
    poor = replace(found, trials=tuple(away))
    # Of the leg as it is, and of each joint's other sign before six other zeros: the first trials suggest signs.
    few = iter((1.0, *(0.001 if k % 7 == 0 else 1.0 for k in range(21))))
    monkeypatch.setattr(plausibility, "_residual_left", lambda *_: next(few))
    monkeypatch.setattr(plausibility, "sample_scatter", lambda some: np.full(3, 1e-4))
    assert convention_doubts(leg, made, poor) == []


def test_a_wrong_sign_behind_an_absurd_damper_is_detected() -> None:
    """The built-in example with the other sign of the ankle: 1 deg RMS by a damper far too strong, and no other law."""
    project = read_fit(EXAMPLE / "fit.yaml")
    wrong = changed(project.leg, 2, sign=-project.leg.joints[2].sign)
    given = ready(replace(project, leg=wrong))
    found = fit_leg(wrong, given.fitted, LegFitOptions(project.free_angle, release=project.release, laws="auto"))
    assert np.degrees(found.rms["ankle"]) < 1.5
    assert found.law == {}
    (text,) = convention_doubts(wrong, given.fitted, found)
    assert "with sign: -1 of the ankle" in text
    # A smaller residual is looked into where the result has a rate at a bound, whatever its sentences say.
    scatter = np.nan_to_num(sample_scatter(given.fitted))
    nearer = 3.0 * scatter / np.array(list(found.averaged_rms.values()))
    trials = [replace(each, fitted=each.measured + nearer * (each.fitted - each.measured)) for each in found.trials]
    near = replace(found, trials=tuple(trials), warnings=())
    assert convention_doubts(wrong, given.fitted, near) == []
    (text,) = convention_doubts(wrong, given.fitted, replace(near, at_bound=("damper_rate ankle",)))
    assert "with sign: -1 of the ankle" in text


@pytest.mark.skipif(not LAB.is_dir(), reason="the lab's recordings (../shared/aarl) are not here")
def test_the_rats_releases_give_no_plausibility_warning() -> None:
    data = read_lab_data(LAB)
    made = data.releases()
    for release in ("free", "recorded"):
        assert doubts(data.rat, made, fit_leg(data.rat, made, LegFitOptions(release=release))) == ()


@pytest.mark.parametrize("joint", [pytest.param(1, marks=pytest.mark.slow), 2])
def test_a_wrong_joint_zero_is_detected(joint: int) -> None:
    leg, trials = robot(), releases(robot(), 3)
    right = leg.joints[joint].zero
    wrong = bare(changed(leg, joint, zero=right - np.pi))
    made = recordings(wrong, trials)
    (text,) = convention_doubts(wrong, made, fit_leg(wrong, made))
    assert f"with zero: {np.degrees(right):.0f} deg of the {NAMES[joint]}" in text


@pytest.mark.parametrize("drive", [Servo(3.0, 0.02), Servo(0.0, open_duty=1.0, motor=GearedMotor(5.0, 0.3))])
@pytest.mark.parametrize(("sign", "zero"), [(-1, 1.0), (1, 1.0 + np.pi), (-1, 1.0 + 0.5 * np.pi)])
def test_what_drives_a_joint_is_turned_with_its_angle(drive: Servo, sign: int, zero: float) -> None:
    """Readings of one log by a leg of another convention, turned to the true one, are those of the true leg."""
    true = Joint("knee", Link(0.2, 0.7, 0.09, 3.5e-3), zero=1.0, spring=Spring(1.5, 1.3), drive=drive)
    built = Leg("arm", (true,))
    time = np.arange(0.0, 1.0, 0.01)
    read, wave = 1.0 + 0.5 * np.sin(7.0 * time), 0.6 * np.cos(5.0 * time)
    columns = {"knee command": wave} if not drive.open_duty else {"knee voltage": wave}

    def recorded(leg: Leg) -> Recording:
        signals = servo_signals(leg, columns, time)
        return recordings(leg, [Trial("a.csv", time, read[:, None], signals=signals)], ())[0]

    other = changed(built, 0, sign=sign, zero=zero)
    turned, expected = _in_convention(recorded(other), 0, other.joints[0], true), recorded(built)
    np.testing.assert_allclose(turned.rotation, expected.rotation, atol=1e-12)
    assert turned.signals is not None
    assert expected.signals is not None
    for name in ("command", "supply"):
        np.testing.assert_allclose(getattr(turned.signals, name), getattr(expected.signals, name), atol=1e-12)


def test_a_wrong_sign_beside_a_servo_leaves_nothing_when_it_is_turned_back() -> None:
    true = Leg("arm", (Joint("knee", Link(0.2, 0.7, 0.09, 3.5e-3), zero=1.0, spring=Spring(1.5, 1.3),
                             damper=Damper(0.02), drive=Servo(3.0, 0.02)),), tilt=0.5)  # fmt: skip
    wrong, time = changed(true, 0, sign=-1), np.arange(0.0, 2.0, 0.01)
    command, ones = 0.6 * np.sin(4.0 * time[:, None]), np.ones((len(time), 1))
    motion = simulate(true, [0.4], [0.0], time, signals=ServoSignals(time, command, ones, ones))
    signals = ServoSignals(time, true.to_measured(command), ones, ones)
    (recording,) = recordings(wrong, [Trial("a.csv", time, true.to_measured(motion), signals=signals)])
    turned = _in_convention(recording, 0, wrong.joints[0], true.joints[0])
    assert _residual_left(true, [turned]) < np.radians(0.05)
