"""Recordings cut where errors grow or add up, against closed forms of a pendulum."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from diagnosis.simulated_releases import TWO
from diagnosis.simulated_releases import recorded as releases
from diagnosis.turning_pendulum import LEG, recorded
from synth.diagnosis.angle_trials import AngleTrial, angle_trial
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import scene_of
from synth.diagnosis.plants.swinging_chain.chain_predictor import Predictor
from synth.diagnosis.plants.swinging_chain.pieces import (
    LEAST_SAMPLES,
    Deviations,
    cut_into_pieces,
    cut_sentence,
    join_pieces,
    whole_recordings,
)
from synth.diagnosis.score import score
from synth.diagnosis.unseen import folds
from synth.files.gap_project import Tolerance
from synth.files.leg_file import read_leg
from synth.fit.recordings import recordings
from synth.swing.leg_model import Damper, Leg
from synth.swing.tolerances import Tolerances

RUBS = {"coulomb_friction": {"torque": 0.25}}


@pytest.fixture
def pendulum(tmp_path: Path) -> Leg:
    (tmp_path / "pendulum.leg.yaml").write_text(LEG)
    return read_leg(tmp_path / "pendulum.leg.yaml")


def held_at(leg: Leg, folder: Path, angle: float) -> AngleTrial:
    """A trial of the pendulum at rest at an angle, deg from hanging, for 2 s."""
    project = recorded(folder, {}, 0, (0.0, 0.0), 2.0, 1)
    trial = angle_trial(recordings(leg, project.trials, ())[0], held_out=False)
    here = np.full_like(trial.measured, np.radians(angle))
    smoothed = trial.recording.smoothed
    still = replace(smoothed, angle=np.full_like(smoothed.angle, np.radians(angle)), rate=np.zeros_like(smoothed.rate))
    return replace(trial, measured=here, recording=replace(trial.recording, rotation=here, smoothed=still))


def test_a_pendulum_at_its_top_is_cut_where_a_deviation_has_grown_by_the_limit(pendulum: Leg, tmp_path: Path) -> None:
    """There it grows like cosh(t sqrt(m g c / (I + m c^2)))."""
    trial = held_at(pendulum, tmp_path, 180.0)
    rate = np.sqrt(0.68 * 9.81 * 0.45 / (9e-3 + 2e-3 + 0.68 * 0.45**2))
    begins = Deviations.of(pendulum, trial).cuts(len(trial.time), 8.0)
    expected = np.arccosh(8.0) / rate
    assert np.diff(trial.time[begins]) == pytest.approx(expected, abs=2.0 * float(trial.time[1]))
    assert len(begins) == int(2.0 / expected) + 1


def test_what_grows_beyond_the_limit_is_cut_into_pieces_in_which_less_grows(pendulum: Leg, tmp_path: Path) -> None:
    """A recording of the time in which a deviation grows six times stays whole: 6 < 8; of 2 s it does not."""
    trial = held_at(pendulum, tmp_path, 180.0)
    rate = np.sqrt(0.68 * 9.81 * 0.45 / (9e-3 + 2e-3 + 0.68 * 0.45**2))
    predictor = Predictor(pendulum, Tolerances.of(pendulum, Tolerance()))
    short = int(np.arccosh(6.0) / rate / trial.time[1])
    assert len(cut_into_pieces(pendulum, predictor, [trial.piece(0, short)])) == 1
    pieces = cut_into_pieces(pendulum, predictor, [trial])
    lengths = [piece.time[-1] + trial.time[1] for piece in pieces[:-1]]
    assert np.array(lengths) == pytest.approx(np.arccosh(4.0) / rate, abs=2.0 * float(trial.time[1]))


def test_a_hanging_pendulum_is_not_cut(pendulum: Leg, tmp_path: Path) -> None:
    along = Deviations.of(pendulum, held_at(pendulum, tmp_path, 0.0))
    assert along.cuts(10_000, 8.0) == [0]
    assert along.kept(100.0) == pytest.approx(1.0, abs=1e-6)


def test_a_damper_makes_a_leg_forget(pendulum: Leg, tmp_path: Path) -> None:
    """A deviation decays like exp(-t b / (2 I))."""
    damped = pendulum.with_joints(hinge={"damper": Damper(rate=0.1)})
    along = Deviations.of(damped, held_at(damped, tmp_path, 0.0))
    assert along.forgetting == pytest.approx(0.1 / (2.0 * (9e-3 + 2e-3 + 0.68 * 0.45**2)), rel=1e-6)


def test_releases_of_a_damped_leg_stay_whole() -> None:
    trials = [angle_trial(recording, held_out=False) for recording in recordings(TWO, releases(TWO), ())]
    assert cut_into_pieces(TWO, Predictor(TWO, Tolerances.of(TWO, Tolerance())), trials) == tuple(trials)
    assert cut_sentence(trials) == ""


def test_pieces_of_a_driven_pendulum_are_predicted_as_the_whole(tmp_path: Path) -> None:
    """The leg that made the recording follows each piece; joined they are the recording, and they count as much."""
    project = recorded(tmp_path, RUBS, 0, (1.2, 2.2), 5.0, 3)
    scene, warnings = scene_of(project.leg, project.trials, project.tolerance, 0)
    assert any("pieces" in warning for warning in warnings)
    bench, whole = scene.bench, whole_recordings(scene.given)
    assert len(scene.given) > len(whole) == 3
    assert min(len(trial.time) for trial in scene.given) >= LEAST_SAMPLES
    for each, measured in zip(whole, join_pieces(scene.given, [trial.measured for trial in scene.given]), strict=True):
        np.testing.assert_array_equal(measured, each.measured)
    assert bench.total == pytest.approx(3 * bench.effective)
    built = project.leg.with_joints(hinge={"effects": RUBS})
    made = replace(bench, predictor=Predictor(built, Tolerances.of(built, Tolerance())))
    fit = EvaluatedHypothesis((), np.zeros(made.n_tolerance), ())
    found = join_pieces(scene.given, [prediction for prediction, _ in score(made, fit, scene.given)])
    left = np.concatenate([prediction - each.measured for prediction, each in zip(found, whole, strict=True)])
    assert np.degrees(np.sqrt(np.mean(left**2))) == pytest.approx(0.05, rel=0.1)


def test_pieces_of_a_recording_are_left_out_together(tmp_path: Path) -> None:
    project = recorded(tmp_path, RUBS, 0, (1.2, 2.2), 5.0, 3)
    scene, _ = scene_of(project.leg, project.trials, project.tolerance, 0)
    names = [{id(scene.given[index].whole) for index in fold} for fold in folds(scene.bench)]
    assert [len(each) for each in names] == [1, 1, 1]
    assert len(set.union(*names)) == 3


def test_a_damper_that_is_not_there_does_not_make_pieces_longer(tmp_path: Path) -> None:
    """With it the leg would forget within a period, and its recordings stay longer than half a period."""
    project = recorded(tmp_path, RUBS, 0, (1.2, 2.2), 5.0, 3)
    damped = project.leg.with_joints(hinge={"damper": Damper(rate=0.5)})
    plain, stated = (scene_of(leg, project.trials, project.tolerance, 0)[0] for leg in (project.leg, damped))
    assert len(stated.given) >= len(plain.given)
