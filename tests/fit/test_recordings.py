"""Preparation of trials for the fit, and what is refused."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from fit.simulated_legs import LINKS, RELEASES, bare, fitted, recorded, release, releases, robot
from synth.errors import Problem, UserError
from synth.files.trial_list import Trial
from synth.fit.estimate import fit_leg
from synth.fit.fit_options import LegFitOptions
from synth.fit.recordings import recordings

LEG = robot()
TRIAL = releases(LEG, 0, count=1)[0]


def refused(trials: Sequence[Trial], sought: Sequence[str] | None = None) -> list[Problem]:
    with pytest.raises(UserError) as caught:
        recordings(bare(LEG), trials, sought)
    return caught.value.problems


def test_all_short_trials_are_refused_with_their_files() -> None:
    short = replace(TRIAL, name="short.csv", time=TRIAL.time[:11], angles=TRIAL.angles[:11])
    sparse = replace(TRIAL, name="sparse.csv", time=TRIAL.time[::50], angles=TRIAL.angles[::50])
    found = refused([short, TRIAL, sparse])
    assert [problem.file for problem in found] == ["short.csv", "sparse.csv"]
    assert "11 samples over 20 ms" in str(found[0])
    assert "11 samples over 1000 ms" in str(found[1])
    assert "at least 12 samples" in str(found[0])


def test_a_locked_joint_that_swings_is_refused() -> None:
    """Frozen at its median it gave the hip a spring of 6.4 for 8.0, with an interval of 2 %."""
    (problem,) = refused([replace(TRIAL, name="swings.csv", locked=("knee",))])
    assert (problem.file, problem.key) == ("swings.csv", "locked")
    assert problem.text.startswith("knee is listed as locked, but its angle changes by")


def test_a_joint_with_too_few_samples_is_refused() -> None:
    angles = TRIAL.angles.copy()
    angles[10:, 1] = np.nan
    (problem,) = refused([replace(TRIAL, name="torn.csv", angles=angles)])
    assert (problem.file, problem.text) == ("torn.csv", "fewer than 12 usable samples of knee")


def test_a_joint_that_is_locked_in_every_trial_is_refused() -> None:
    generator = np.random.default_rng(0)
    trials = [release(LEG, RELEASES[i], generator, locked=("knee",), name=str(i)) for i in range(2)]
    (problem,) = refused(trials)
    assert problem.key == "knee"
    assert "locked in every trial" in problem.text
    assert refused(trials, ["knee"]) == [problem]
    assert len(recordings(bare(LEG), trials, ["hip", "ankle"])) == 2
    assert len(recordings(bare(LEG), [*trials, TRIAL])) == 3  # free in one is enough


def test_a_joint_that_never_moves_is_refused() -> None:
    angles = TRIAL.angles.copy()
    angles[:, 2] = 1.7 + np.random.default_rng(1).normal(0, 1e-4, len(angles))
    (problem,) = refused([replace(TRIAL, angles=angles)])
    assert problem.key == "ankle"
    assert "never moves" in problem.text
    assert "`locked`" in problem.text


def test_a_fit_without_trials_is_refused() -> None:
    with pytest.raises(UserError, match="no trial remains to fit"):
        fit_leg(bare(LEG), [])


def test_a_wrong_link_gives_a_missing_effect_warning() -> None:
    """Angles of one leg, the foot of another, a hundred times heavier and mounted the other way round."""
    joints = list(bare(LEG).joints)
    joints[2] = replace(joints[2], link=replace(LINKS[2], com=-0.15, mass=9.0), sign=1)
    wrong = replace(bare(LEG), joints=tuple(joints))
    recorded = recordings(wrong, releases(LEG, 0, count=3))
    result = fit_leg(wrong, recorded)
    assert any("the model lacks an effect" in text for text in result.warnings)
    follower = fit_leg(wrong, recorded, LegFitOptions(wanted=True))
    blaming = ("lacks an effect", "muscle", "check it first")
    assert not [text for text in follower.warnings if any(words in text for words in blaming)]
    misses = [text for text in follower.warnings if "comes no nearer to the scaled motion than" in text]
    assert misses
    assert all("its links, gravity and any linear dampers" in text for text in misses)


def test_rotations_samples_and_conditions_are_copied() -> None:
    generator = np.random.default_rng(4)
    trial = release(LEG, RELEASES[1], generator, locked=("hip",), tip_mass=0.1, tilt=0.2, name="a.csv")
    angles = trial.angles.copy()
    angles[50, 1] = np.nan
    torque = np.zeros_like(angles)
    torque[:, 2] = 0.3
    given = replace(trial, time=trial.time + 7.0, angles=angles, torques=torque)
    (made,) = recordings(bare(LEG), [given], ["knee", "ankle"])
    assert made.time[0] == 0.0
    np.testing.assert_allclose(made.rotation[:, 2], -(angles[:, 2] - np.pi))  # sign -1, zero 180 deg
    assert not made.counts[:, 0].any()  # held
    assert np.ptp(made.rotation[:, 0]) == 0.0
    assert np.flatnonzero(~made.counts[:, 1]).tolist() == [50]
    assert made.n_lost == 1
    assert (made.conditions.locked, made.conditions.tip_mass, made.conditions.tilt) == ((0,), 0.1, 0.2)
    assert made.free == [1, 2]
    assert made.known_torque is not None
    np.testing.assert_array_equal(made.known_torque[1][:, 2], -0.3)
    assert np.isnan(given.angles[50, 1])  # the trial itself is left as it was
    np.testing.assert_array_equal(given.angles, angles)


def test_stretching_and_thinning_keep_the_motion() -> None:
    (made,) = recorded(LEG, [TRIAL])
    slow = made.stretched(2.5)
    np.testing.assert_allclose(slow.time, 2.5 * made.time)
    np.testing.assert_array_equal(slow.rotation, made.rotation)
    np.testing.assert_allclose(slow.smoothed.rate, made.smoothed.rate / 2.5)
    few = made.thinned(100)
    assert len(few.time) <= 102
    kept = np.searchsorted(made.time, few.time)
    np.testing.assert_array_equal(few.rotation, made.rotation[kept])


def test_a_strong_damper_is_at_no_bound_of_the_search() -> None:
    # b/I of the ankle is 760 1/s here; the search ended at 500
    leg = robot(damper=[1.2903, 0.1054, 0.38])
    result = fitted(leg, releases(leg, 1))
    assert result.joints["ankle"].damper_rate.value == pytest.approx(0.38, rel=0.05)
    assert not result.warnings
