"""A trial that stands out from the others is named by the fit and by the gap."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from diagnosis.simulated_releases import TWO, off, recorded
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose
from synth.files.gap_project import Tolerance
from synth.fit.estimate import fit_leg
from synth.fit.odd_trials import odd_trials
from synth.fit.recordings import recordings


def test_an_outlying_trial_is_named_by_the_fit_and_the_gap() -> None:
    """One trial's knee is read in half degrees: half as far as it went."""
    trials = recorded(off(TWO, 3, 0.5), held_out=0)
    assert not [text for text in fit_leg(TWO, recordings(TWO, trials)).warnings if "check it first" in text]
    middle = trials[2].angles.mean(axis=0)
    angles = trials[2].angles.copy()
    angles[:, 1] = middle[1] + 0.3 * (angles[:, 1] - middle[1]) + 0.8
    wrong = [*trials[:2], replace(trials[2], angles=angles), *trials[3:]]
    for warnings in (fit_leg(TWO, recordings(TWO, wrong)).warnings, diagnose(TWO, wrong, Tolerance()).warnings):
        named = [text.partition(":")[0] for text in warnings if "check it first" in text]
        assert named == [trials[2].name]


def test_no_outlier_is_named_among_two_trials_or_from_a_locked_joint() -> None:
    assert odd_trials(["a", "b"], ["hip"], np.array([[0.001], [1.0]])) == []
    rms = np.array([[0.01, np.nan], [0.011, 0.3], [0.012, np.nan]])
    assert odd_trials(["a", "b", "c"], ["hip", "knee"], rms) == []
