"""A trial that stands out from the others is named by the fit and by the gap."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from diagnosis.simulated_releases import TWO, off, recorded
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose
from synth.files.gap_project import Tolerance
from synth.files.trial_list import Trial
from synth.fit.estimate import fit_leg
from synth.fit.odd_trials import odd_trials
from synth.fit.recordings import recordings


def with_a_misread_knee() -> list[Trial]:
    """One trial's knee is read in half degrees: half as far as it went."""
    trials = recorded(off(TWO, 3, 0.5), held_out=0)
    middle = trials[2].angles.mean(axis=0)
    angles = trials[2].angles.copy()
    angles[:, 1] = middle[1] + 0.3 * (angles[:, 1] - middle[1]) + 0.8
    return [*trials[:2], replace(trials[2], angles=angles), *trials[3:]]


def named(warnings: Sequence[str]) -> list[str]:
    return [text.partition(":")[0] for text in warnings if "check it first" in text]


def test_an_outlying_trial_is_named_by_the_fit() -> None:
    trials, wrong = recorded(off(TWO, 3, 0.5), held_out=0), with_a_misread_knee()
    assert named(fit_leg(TWO, recordings(TWO, trials)).warnings) == []
    assert named(fit_leg(TWO, recordings(TWO, wrong)).warnings) == [wrong[2].name]


@pytest.mark.slow
def test_an_outlying_trial_is_named_by_the_gap() -> None:
    wrong = with_a_misread_knee()
    assert named(diagnose(TWO, wrong, Tolerance()).warnings) == [wrong[2].name]


def test_no_outlier_is_named_among_two_trials_or_from_a_locked_joint() -> None:
    assert odd_trials(["a", "b"], ["hip"], np.array([[0.001], [1.0]])) == []
    rms = np.array([[0.01, np.nan], [0.011, 0.3], [0.012, np.nan]])
    assert odd_trials(["a", "b", "c"], ["hip", "knee"], rms) == []


def test_free_angles_of_locked_joints_and_of_no_spring_are_not_compared() -> None:
    rms, own = np.full((4, 1), 0.01), np.array([[0.1], [0.1], [0.1], [0.9]])
    assert named(odd_trials(["a", "b", "c", "d"], ["hip"], rms, own)) == ["d"]
    own[3] = np.nan
    assert odd_trials(["a", "b", "c", "d"], ["hip"], rms, own) == []
    assert odd_trials(["a", "b", "c", "d"], ["hip"], rms, np.full_like(rms, np.nan)) == []
