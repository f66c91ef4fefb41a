"""Frames lost without a word, in motion that ``scipy`` integrates: found, put back and told; and none elsewhere."""

from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from robustness.dirty import AS_SYNTH_FIT, Pendulums, dirty_case
from robustness.random_legs import Case
from synth import fit
from synth.files.leg_file import read_leg
from synth.files.trial_list import Trial, read_trials
from synth.fit.fit_problem import model_of
from synth.fit.frame_paths import FrameStep, StepGains, _cheapest, steps_of, timed
from synth.fit.free_angle import WIDE
from synth.fit.least_squares import FitStart
from synth.fit.lost_frames import LostFrames, lost_frames
from synth.fit.recordings import Recording, recordings
from synth.fit.refinement import refine
from synth.fit.starts import first_locals, weak_form_start
from synth.remarks import Remark
from synth.swing.mechanics import rest_pose
from synth.validation.thesis_data import read_lab_data

Array = NDArray[np.float64]
SHARED = Path(__file__).resolve().parents[3] / "shared"
RATE, NOISE = 100.0, 0.2  # Hz, deg
LOST = (((12, 1), (30, 2)), (), ((17, 3),))  # of each trial: the frame before which so many are missing


@pytest.fixture(scope="module")
def case() -> Case:
    """A leg of two swinging joints: of seed 41005, with its own motion and links that are off."""
    found = dirty_case("clean", 41005)
    assert found is not None
    return found


def released(case: Case, lost: tuple[tuple[tuple[int, int], ...], ...]) -> list[Trial]:
    """Three releases of 0.8 s, in whose samples frames are missing; the time is even."""
    generator, trials = np.random.default_rng(4), []
    for number, steps in enumerate(lost):
        away = np.radians(np.array([(18.0, -25.0), (-20.0, 12.0), (24.0, 20.0)])[number])
        motion, _ = Pendulums(case.leg).released(rest_pose(case.leg) + away, np.zeros(2), 1.0)
        frames = np.arange(80)
        for row, count in steps:
            frames[row:] += count
        rotation = motion(frames / RATE) + np.radians(NOISE) * generator.normal(size=(80, 2))
        trials.append(Trial(f"film {number}", np.arange(80) / RATE, case.leg.to_measured(rotation)))
    return trials


def found_in(case: Case, trials: list[Trial]) -> LostFrames | None:
    return lost_frames(case.off, recordings(case.off, trials), AS_SYNTH_FIT)


def test_each_lost_frame_is_found_where_it_was_and_put_back(case: Case) -> None:
    found = found_in(case, released(case, LOST))
    assert found is not None
    assert tuple(tuple((step.row, step.lost) for step in each) for each in found.steps) == LOST
    for recording, steps in zip(found.recordings, LOST, strict=True):
        frames = np.round(recording.time * RATE).astype(int) - np.arange(80)
        assert frames.tolist() == [sum(count for row, count in steps if row <= k) for k in range(80)]
    assert np.all(np.diff(found.recordings[0].smoothed.time) > 0.0)


def test_the_fit_puts_them_back_says_so_and_its_intervals_hold(case: Case) -> None:
    told = fit(case.off, released(case, LOST))
    first = told.warnings[0]
    assert isinstance(first, Remark)
    assert first.severity == "decide"
    assert first.startswith("6 frames were lost that the time does not show (film 0: 1 before 0.12 s, 2 before 0.3 s; ")
    assert "film 2: 3 before 0.17 s)" in first
    assert "`frame`" in first.remedy
    assert told.result.cut == 0.0
    for joint in case.leg.joints:
        assert joint.spring is not None
        estimate = told.joints[joint.name].spring_rate
        assert abs(np.log(estimate.value / joint.spring.rate)) < 0.06
    whole = fit(case.off, released(case, ((), (), ())))
    assert not any("lost that the time" in text for text in whole.warnings)


@pytest.mark.parametrize("kind", ["clean", "hand", "wobble", "cross_talk", "spread"])
@pytest.mark.parametrize("seed", [42007, 42011, 42024])
def test_a_hand_soft_tissue_or_another_leg_lose_no_frame(kind: str, seed: int) -> None:
    """Their fits take steps too, of which the first version put 60 back: the angles do not jump there."""
    other = dirty_case(kind, seed)
    assert other is not None
    assert found_in(other, list(other.trials)) is None


def test_a_clock_with_gaps_and_a_driven_motion_are_believed(case: Case) -> None:
    trials = released(case, LOST)
    gap = np.where(np.arange(80) >= 40, 0.02, 0.0)
    assert found_in(case, [replace(trial, time=trial.time + gap) for trial in trials]) is None
    driven = [replace(trial, torques=np.zeros((80, 2))) for trial in trials]
    assert found_in(case, driven) is None


def test_lost_readings_beside_lost_frames(case: Case) -> None:
    trials = released(case, LOST)
    for trial in trials:
        trial.angles[np.random.default_rng(7).random(trial.angles.shape) < 0.05] = np.nan
    found = found_in(case, trials)
    assert found is not None
    assert [[step.lost for step in each] for each in found.steps] == [[1, 2], [], [3]]


def test_the_cheapest_path_is_that_of_all_paths() -> None:
    each = np.random.default_rng(3).gamma(1.0, 2.0, size=(8, 4))
    paths = [p for p in itertools.product(range(4), repeat=8) if p[:3] == (0, 0, 0) and all(np.diff(p) >= 0)]
    costs = [sum(each[range(8), p]) + 1.5 * sum(np.diff(p) > 0) for p in paths]
    assert tuple(_cheapest(each, 1.5)) == paths[int(np.argmin(costs))]


def test_a_single_steps_gain_is_that_of_the_fit_with_it(case: Case) -> None:
    """To first order, with all unknowns following; and a step at a wrong place is moved to the right one."""
    made = recordings(case.off, released(case, ((), ((12, 1),), ())))
    model, spread = model_of(case.off, recordings=made), np.full(2, WIDE)
    start = FitStart(weak_form_start(model, made, AS_SYNTH_FIT).values, first_locals(made))

    scatter, path = np.full(2, np.radians(NOISE)), (np.arange(80) >= 12).astype(np.intp)

    def fitted(some: list[Recording]) -> tuple[float, StepGains]:
        solution = refine(model, some, start, "noise", spread).solution
        off = [p - r.rotation for p, r in zip(solution.predictions, some, strict=True)]
        square = sum(float(np.sum((each / scatter) ** 2)) for each in off)
        return 0.5 * square, StepGains(model, some, solution, scatter)

    before, gains = fitted(made)
    after, there = fitted([made[0], timed(made[1], path), made[2]])
    found = gains.best(1)
    assert found is not None
    assert steps_of(path) == [replace(found, gain=0.0)] == [FrameStep(12, 1)]
    assert found.gain == pytest.approx(before - after, rel=0.15)
    assert there.instead(1, found) is None
    wrong = (np.arange(80) >= 22).astype(np.intp)
    _, moved = fitted([made[0], timed(made[1], wrong), made[2]])
    better = moved.instead(1, FrameStep(22, 1))
    assert better is not None
    assert (better.row, better.lost) == (12, 1)


@pytest.mark.skipif(not SHARED.is_dir(), reason="the real recordings (../shared) are not here")
def test_real_recordings_lose_none() -> None:
    data = read_lab_data(SHARED / "aarl")
    assert lost_frames(data.rat, data.releases(), AS_SYNTH_FIT) is None
    leg = read_leg(SHARED / "double_pendulum" / "double_pendulum.leg.yaml")
    names = [path.name for path in sorted((SHARED / "double_pendulum" / "trials").glob("val_*.csv"))]
    trials = read_trials([f"trials/{name}" for name in names[:4]], SHARED / "double_pendulum", leg)
    assert lost_frames(leg, recordings(leg, trials), AS_SYNTH_FIT) is None
