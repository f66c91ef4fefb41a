"""Readings that jump by whole turns, in a trial's file: continued where it is certain, refused where it is not."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from synth.errors import UserError
from synth.files.trial_in_code import checked_trials
from synth.files.trial_list import read_trials, turned_back
from synth.files.turns import TURN, turns_back, turns_together, unwrapped
from synth.files.yaml_lines import Document
from synth.fit.recordings import recordings, sentences_on_reading
from synth.swing.leg_model import Joint, Leg, Link

TIME = np.arange(0.0, 2.0, 0.005)
SWING = np.radians(178.0 + 40.0 * np.exp(-2.0 * TIME) * np.cos(14.0 * TIME))
LEG = Leg("one", (Joint("knee", Link(0.3, 0.4, 0.12, 3e-3), 0.0, 1),))

HERE = Document(Path("here"), "here", {}, {}, b"")


def wrapped(angle: np.ndarray, end: float = np.pi) -> np.ndarray:
    """From -180 to 180 deg, or to another end."""
    return (angle - end) % TURN - TURN + end


@pytest.mark.parametrize("end", [np.pi, TURN, np.radians(175.0)])
@pytest.mark.parametrize("noise", [0.05, 0.5])
def test_a_swing_over_the_end_of_the_scale_is_continued(end: float, noise: float) -> None:
    angle = SWING + np.radians(noise) * np.random.default_rng(1).normal(size=len(TIME))
    found = unwrapped(wrapped(angle, end))
    if end == TURN:
        assert (found.jumps, found.doubtful) == (0, None)
        return
    assert found.jumps > 5
    assert found.doubtful is None
    np.testing.assert_allclose(np.diff(found.angle), np.diff(angle), atol=1e-9)


def test_a_joint_that_turns_on_is_left_and_a_wrapped_one_continued() -> None:
    for speed in (5.0, 60.0, 250.0):  # rad/s: up to a fifth of a turn from sample to sample
        turning = speed * TIME + 0.1 * np.sin(9.0 * TIME)
        assert unwrapped(turning).jumps == 0
        found = unwrapped(wrapped(turning))
        assert found.doubtful is None
        np.testing.assert_allclose(np.diff(found.angle), np.diff(turning), atol=1e-9)
    fast = 900.0 * TIME  # 0.7 turns from sample to sample, as an unwrapped wheel has
    assert (unwrapped(fast).jumps, unwrapped(fast).doubtful) == (0, None)


def test_gaps_are_continued_and_outliers_are_left_to_the_fit() -> None:
    angle = wrapped(SWING)
    angle[[100, 101, 102, 200]] = np.nan
    found = unwrapped(angle)
    good = np.isfinite(angle)
    np.testing.assert_allclose(np.diff(found.angle[good]), np.diff(SWING[good]), atol=1e-9)
    spiked = SWING.copy()
    spiked[50] -= np.radians(300.0)  # a lost marker reads 0
    found = unwrapped(spiked)
    assert (found.jumps, found.doubtful) == (0, None)
    np.testing.assert_array_equal(found.angle, spiked)


def test_a_slip_by_almost_a_turn_is_doubtful() -> None:
    slipped = np.where(TIME < 1.0, SWING, SWING - np.radians(300.0))
    assert unwrapped(slipped).doubtful == int(np.argmax(TIME >= 1.0))


def test_recordings_are_brought_to_one_turn() -> None:
    assert turns_together([3.1, -3.1, 3.2], [False, False, False], 0.0) == [0.0, 0.0, 0.0]
    assert turns_together([3.1, -3.1, 3.2], [True, True, False], 0.0) == pytest.approx([0.0, TURN, 0.0])
    assert turns_together([3.2, -3.1], [True, True], 0.0) == pytest.approx([-TURN, 0.0])


def written(folder: Path, name: str, angle: np.ndarray) -> None:
    rows = "\n".join(f"{t:.6f},{np.degrees(a):.5f}" for t, a in zip(TIME, angle, strict=True))
    (folder / name).write_text(f"time [s],knee [deg]\n{rows}\n", encoding="utf-8")


def test_trials_are_read_without_jumps_on_one_turn_with_a_note(tmp_path: Path) -> None:
    starts = (0.7, -0.7, 0.4)
    for k, start in enumerate(starts):
        written(tmp_path, f"{k}.csv", wrapped(np.radians(178.0) + start * np.exp(-2.0 * TIME) * np.cos(14.0 * TIME)))
    trials = read_trials(["*.csv"], tmp_path, LEG)
    made = recordings(LEG, trials)
    ends = [recording.smoothed.angle[-1, 0] for recording in made]
    assert np.ptp(ends) < 0.05
    assert all(np.abs(np.diff(trial.angles[:, 0])).max() < 0.2 for trial in trials)
    said = sentences_on_reading(made)
    assert len(said) == 3
    assert "jumps by a whole turn were removed (knee " in said[0]


def test_a_recording_on_another_turn_is_turned_back_with_a_note(tmp_path: Path) -> None:
    """As ``synth import`` does; it ruined a fit, and no warning named the turn."""
    for k, off in enumerate((0.0, -TURN, 0.0)):
        written(tmp_path, f"{k}.csv", SWING + off + 0.1 * k)
    trials = read_trials(["*.csv"], tmp_path, LEG)
    assert [trial.turned for trial in trials] == [(), (1,), ()]
    np.testing.assert_allclose(trials[1].angles[:, 0], SWING + 0.1, atol=1e-6)
    (said,) = sentences_on_reading(recordings(LEG, trials))
    assert "1.csv: turned back by whole turns to where the other trials are (knee +360 deg)" in said
    # Trials made in code, and those read again, are treated alike.
    moved = dataclasses.replace(trials[1], angles=trials[1].angles - TURN, turned=())
    again = checked_trials([trials[0], moved, trials[2]], LEG, HERE)
    assert [trial.turned for trial in again] == [(), (1,), ()]
    assert checked_trials(again, LEG, HERE)[1] is again[1]


def test_only_a_joint_that_does_not_turn_on_is_turned_back() -> None:
    at = [(middle - 0.3, middle, middle + 0.3) for middle in (1.0, 1.2, 1.1 - 2 * TURN)]
    joint = LEG.joints[0]
    assert turns_back(at, joint) == [0, 0, 2]
    assert turns_back([*at, (1.0, 3.0, 5.0)], joint) == [0, 0, 0, 0]  # one covers more than half a turn
    assert turns_back([at[0], (3.7, 4.2, 4.7), (4.0, 4.3, 4.6)], joint) == [0, 0, 0]  # less than a turn apart
    assert turns_back([at[0], at[2]], joint) == [0, 2]  # of two, that nearer to the leg file's angle stays
    assert turns_back([at[0], at[2], at[2], at[0]], joint) == [0, 2, 2, 0]
    wide = dataclasses.replace(joint, range=(-14.0, 2.0))
    assert turns_back(at, wide) == [0, 0, 0]  # all within the stated range
    there = dataclasses.replace(joint, range=(-12.5, -10.5))
    assert turns_back([at[0], at[2], at[2]], there) == [-2, 0, 0]


def test_a_joint_that_a_known_torque_turns_is_left(tmp_path: Path) -> None:
    """A spring wound by a torque is on another turn indeed."""
    for k in range(3):
        written(tmp_path, f"{k}.csv", SWING + 0.1 * k)
    trials = read_trials(["*.csv"], tmp_path, LEG)
    torque = np.ones_like(trials[1].angles)
    wound = dataclasses.replace(trials[1], angles=trials[1].angles + TURN, torques=torque, turned=())
    assert turned_back([trials[0], wound, trials[2]], LEG)[1] is wound


def test_a_doubtful_step_is_refused_with_its_line(tmp_path: Path) -> None:
    written(tmp_path, "a.csv", np.where(TIME < 1.0, SWING, SWING - np.radians(300.0)))
    with pytest.raises(UserError, match=r"a\.csv") as caught:
        read_trials(["a.csv"], tmp_path, LEG)
    assert "may be a whole turn or not" in str(caught.value)
    assert "202" in str(caught.value)
