"""Many trials: a stated sample is used for training, the others for scoring."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from diagnosis.simulated_releases import TWO, off, recorded
from synth.diagnosis.angle_trials import angle_trial, largest_of_kinds, spread_over_kinds
from synth.diagnosis.plants.swinging_chain import chain_diagnosis
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import scene_of
from synth.diagnosis.sifting import few_trials
from synth.files.tolerance import Tolerance
from synth.fit.recordings import recordings

TRIALS = [angle_trial(recording, held_out=False) for recording in recordings(TWO, recorded(TWO), ())]


def test_few_trials_are_all_used_for_training() -> None:
    taken, left = spread_over_kinds(TRIALS, len(TRIALS))
    assert (taken, left) == (TRIALS, [])


def test_the_training_sample_has_each_condition_and_is_even() -> None:
    plain = [replace(TRIALS[0]) for _ in range(20)]
    conditions = replace(TRIALS[0].recording.conditions, tip_mass=0.05)
    heavy = replace(TRIALS[0], recording=replace(TRIALS[0].recording, conditions=conditions))
    taken, left = spread_over_kinds([*plain, heavy], 5)
    places = [next(k for k, trial in enumerate([*plain, heavy]) if trial is one) for one in taken]
    assert places == [0, 1, 7, 13, 20]  # the first and the heavy one, then three of the nineteen others, six apart
    assert len(left) == 16


def test_the_first_screening_has_the_only_trial_of_another_leg() -> None:
    """It moves least: by motion alone it was left out, in ``gap --check`` beside twelve others too."""
    still = replace(TRIALS[0], measured=0.1 * TRIALS[0].measured)
    other = replace(still, recording=replace(still.recording, leg=off(TWO, 1)))
    bench: Any = SimpleNamespace(trials=[*6 * [TRIALS[0]], other])
    assert few_trials(bench) == [0, 1, 2, 6]
    assert few_trials(SimpleNamespace(trials=[*6 * [TRIALS[0]], still])) == [0, 1, 2, 3]  # type: ignore[arg-type]
    assert largest_of_kinds([*12 * [TRIALS[0]], other])[:2] == [0, 12]


def test_trials_outside_the_training_sample_are_scored_with_a_warning(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(chain_diagnosis, "MOST_TRAINING", 2)
    trials = recorded(TWO)
    scene, warnings = scene_of(TWO, trials, Tolerance(), 0)
    assert len(scene.given) == len(scene.bench.trials) == 2
    assert len(scene.held) == len(trials) - 2
    assert all(trial.held_out for trial in scene.held)
    assert any(f"2 of {sum(not trial.held_out for trial in trials)} trials" in text for text in warnings)
