"""Recordings that begin after the release, while a flexible mount or link already moves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from diagnosis.simulated_releases import TIME, TWO, best, off, recorded, with_effects
from synth.diagnosis.angle_trials import angle_trial
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.lanes import Block
from synth.diagnosis.plants.swinging_chain.chain_candidates import candidates, natural_sizes_of
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose
from synth.diagnosis.plants.swinging_chain.chain_predictor import Predictor
from synth.diagnosis.score import first_state
from synth.diagnosis.workbench import Workbench, state_rows
from synth.files.gap_project import Tolerance
from synth.files.trial_list import Trial
from synth.fit.recordings import recordings
from synth.swing.tolerances import Tolerances

MOUNT = {"rocking_stiffness": 40.0, "arm": 0.1, "inertia": 0.004, "damping_ratio": 0.03}
LATE = 3  # samples


def late(trials: Sequence[Trial]) -> list[Trial]:
    """The recordings without their first samples."""
    return [replace(t, time=t.time[LATE:] - t.time[LATE], angles=t.angles[LATE:]) for t in trials]


def test_an_initially_moving_mount_is_found_and_tracked() -> None:
    built = with_effects(off(TWO, 3), {"base": {"base_compliance": MOUNT}})
    time = np.concatenate([TIME, TIME[-1] + TIME[1 : LATE + 1]])
    result = diagnose(TWO, late(recorded(built, seed=5, time=time)), Tolerance())
    assert result.before.value > 20.0 * result.noise_floor.value
    assert best(result) == ("base_compliance", "base")
    assert result.after.value < 1.5 * result.noise_floor.value  # 5 if the mount is taken to start as it was held


def test_the_state_of_a_flexible_link_is_predicted_and_fitted() -> None:
    """Its rows move the prediction, are asked for one by one, and cost what a standard normal does."""
    trials = recorded(TWO, held_out=0)[:1]
    (recording,) = recordings(TWO, trials, ())
    trial = angle_trial(recording, held_out=False)
    bench = Workbench(Predictor(TWO, Tolerances.of(TWO, Tolerance())), (trial,), np.full(2, 1e-3), 50.0)
    found = candidates(TWO, [trial], natural_sizes_of(TWO, [trial]))
    mount = next(c for c in found if c.key == ("base_compliance", "base") and "arm" in c.shape.free)
    assert mount.links == 1
    unknowns = np.concatenate([np.zeros(bench.n_tolerance), mount.starts()[0]])
    fit = EvaluatedHypothesis((mount,), unknowns, (first_state(trial),))
    (awake,) = (bench.awake(fit),)
    assert len(awake.states[0]) == 2 * 2 + 2
    assert state_rows(trial, awake.states[0]) == [0, 1, 2, 3, 4, 5]
    still, same = bench.evaluate([fit, awake])
    assert same.cost == still.cost
    moved = awake.states[0].copy()
    moved[4] = 0.5
    there = bench.evaluate([replace(awake, states=(moved,))])[0]
    assert np.abs(there.residuals[0][:-6] - still.residuals[0][:-4]).max() > 0.01
    assert there.residuals[0][-2:].tolist() == [0.5, 0.0]
    _, slopes = bench.slopes(trial, awake, awake.states[0], ())
    step = bench.predictor.predict([trial], [Block((mount,), unknowns[:, None], moved[None, :, None])])[0][:, :, 0]
    change = ((step - trial.measured) / bench.sigma(trial))[trial.counts] - still.residuals[0][: len(slopes)]
    np.testing.assert_allclose(slopes[:, 4] * 0.5, change, atol=0.1 * np.abs(change).max())
