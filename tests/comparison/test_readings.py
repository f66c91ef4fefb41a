"""Errors of encoders that a leg file states: beside recordings a leg is read with them, elsewhere a note says not."""

from __future__ import annotations

from dataclasses import replace
from math import radians
from pathlib import Path

import numpy as np
import pytest

from synth.cli import main
from synth.comparison.compare_sides import compare, warnings
from synth.comparison.recorded_sides import from_trials
from synth.comparison.side import MODEL, RECORDED, ComparedMotion, Side, joints_of
from synth.files.leg_file import write_leg
from synth.files.trial_list import Trial
from synth.swing.chain import Conditions, simulate
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring
from synth.swing.readings import as_stated

TIMES = np.arange(0.0, 1.5, 0.005)
ERRORS = {
    "late": {"latency": {"delay": 0.02}},
    "filtered": {"latency": {"lag": 0.02}},
    "shifted": {"encoder_offset": {"offset": 0.1}},
    "shifted, scaled": {"encoder_offset": {"offset": 0.1}, "encoder_scale": {"error": 0.1}},
}


def pendulum(errors: dict[str, dict[str, float]] | None = None) -> Leg:
    joint = Joint("knee", Link(0.2, 0.4, 0.1, 1.5e-3), spring=Spring(1.2, 0.3), damper=Damper(0.03))
    return Leg("one link", (replace(joint, effects=errors or {}),))


def seen(leg: Leg, rate: float) -> Side:
    """A recording of the leg, its start as read."""
    moved = simulate(leg, [0.9], [rate], TIMES, rates=True)
    reading = as_stated(leg, TIMES, moved[:, :1], moved[:, 1:])
    motion = ComparedMotion("a", TIMES, reading, reading[0], np.zeros(1), Conditions())
    return Side("seen", "seen", RECORDED, leg, motions=(motion,))


def model(leg: Leg, name: str = "leg", *, reads: bool = True) -> Side:
    return Side(name, name, MODEL, leg, joints_of(leg), reads=reads)


@pytest.mark.parametrize("rate", [0.0, 2.0])
@pytest.mark.parametrize("errors", ERRORS.values(), ids=ERRORS)
def test_beside_a_recording_a_leg_is_read_as_its_file_states(errors: dict[str, dict[str, float]], rate: float) -> None:
    found = compare([seen(pendulum(errors), rate), model(pendulum(errors))])
    assert found.differences[0].overall < radians(0.01)
    assert not [text for text in warnings(found) if "encoders" in text]
    exact = compare([seen(pendulum(errors), rate), model(pendulum(errors), reads=False)])
    assert exact.differences[0].overall > radians(0.3)  # as it was
    assert "without the errors of encoders that leg files state (leg: " in " ".join(warnings(exact))


def test_two_legs_are_compared_in_their_true_motion_and_a_note_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = compare([model(pendulum(), "plain"), model(pendulum(ERRORS["late"]), "late")])
    assert found.differences[0].overall == 0.0
    note = "true motions are compared, without the errors of encoders that leg files state (late: latency at knee)"
    assert [text for text in warnings(found) if note in text]
    write_leg(pendulum(), tmp_path / "plain.leg.yaml")
    write_leg(pendulum(ERRORS["late"]), tmp_path / "late.leg.yaml")
    assert (
        main(
            ["compare", str(tmp_path / "plain.leg.yaml"), str(tmp_path / "late.leg.yaml"), "--out", str(tmp_path / "c")]
        )
        == 0
    )
    written = capsys.readouterr()
    assert "without the errors of encoders" in written.out + written.err


@pytest.mark.parametrize("noise", [radians(0.05), radians(0.2)])
def test_the_recorded_leg_is_as_far_from_its_recording_as_the_noise(noise: float) -> None:
    """The first samples tell a release's rate to 30 deg/s: the leg itself was five times the noise away, or last."""
    leg = pendulum()
    other = leg.with_joints(knee={"spring": Spring(1.2 * 1.02, 0.3)})
    moved = simulate(leg, [0.9], [0.0], TIMES)
    for seed in range(4):
        shaken = moved + noise * np.random.default_rng(seed).standard_normal(moved.shape)
        motions = from_trials(leg, [Trial("a.csv", TIMES, leg.to_measured(shaken))])
        recorded = Side("seen", "seen", RECORDED, leg, motions=motions)
        found = compare([recorded, model(leg, "same"), model(other, "other")])
        same, other_one = (item.overall for item in found.differences if item.a == 0)
        assert same == pytest.approx(noise, rel=0.1)
        assert other_one > same
