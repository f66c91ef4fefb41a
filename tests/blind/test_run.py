"""The runner keeps answers closed, and suggested trials are made as specified."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from blind.baseline_fits import free_fit, largest_change, least_residual
from blind.baseline_torque import bic
from blind.cases import Case, make_case
from blind.legs import rest_pose
from blind.next_trial import RAMP, Suggestion, add_trial, recorded
from blind.run import ROOT, diagnose_all, snapshot
from blind.views import read_views
from blind.writing import write_case
from synth.diagnosis.diagnosis_result import Experiment
from synth.files.gap_project import read_gap_project
from synth.planting.model import PlantedTrial


@pytest.fixture(scope="module")
def preload() -> Case:
    return make_case(9, 0, "single", "spring_preload", 12.0, 1)


@pytest.fixture(scope="module")
def folder(preload: Case, tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("cases") / "abc"
    write_case(preload, made, "abc")
    return made


def watched(closed: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(ROOT / "synth" / "commands" / "watched.py"), str(closed), "--", *arguments]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    return subprocess.run(command, capture_output=True, text=True, env=environment, timeout=120, check=False)


def test_a_diagnosis_cannot_open_what_is_closed(folder: Path, tmp_path: Path) -> None:
    refused = watched(folder.parent, "gap", str(folder / "gap.yaml"), "--out", str(tmp_path / "out"), "--dry-run")
    assert refused.returncode != 0
    assert "closed to a diagnosis" in refused.stderr
    allowed = watched(tmp_path, "gap", str(folder / "gap.yaml"), "--out", str(folder.parent / "out"), "--dry-run")
    assert allowed.returncode == 0, allowed.stderr


def test_cases_are_diagnosed_once_with_their_answers_closed(folder: Path, tmp_path: Path) -> None:
    answers = tmp_path / "answers" / "answers.json"
    answers.parent.mkdir()
    answers.write_text("{}")
    program = snapshot(tmp_path)
    assert diagnose_all(folder.parent, tmp_path / "out", answers, 1, program) == 0
    view = read_views(tmp_path / "out", ["abc", "absent"])
    assert view["absent"].verdict == "failed"
    assert ("spring_preload", "hip") in view["abc"].keys
    assert 0.0 < view["abc"].seconds < 600.0
    written = (tmp_path / "out" / "abc" / "gap.json").stat().st_mtime_ns
    assert diagnose_all(folder.parent, tmp_path / "out", answers, 1, program) == 0
    assert (tmp_path / "out" / "abc" / "gap.json").stat().st_mtime_ns == written
    assert answers.stat().st_mode & 0o777 == 0o600


def test_a_slow_torque_moves_the_leg_as_springs_and_gravity_let_it(preload: Case) -> None:
    true, names = preload.setup.true, preload.setup.true.names
    size = 0.3 * float(true.of("spring")[0])
    what = f"a torque on {names[0]} that rises slowly to {size:.3g} N m in 30 s and is recorded"
    assert RAMP.search(what) is not None
    built = preload.truth.leg
    resting = built.reading(rest_pose(built, PlantedTrial(np.zeros(1), 1.0), preload.truth.tilt))
    asked = Experiment("", {"file": "trials/next.csv"}, {names[0]: float(resting[0])}, 1.0, ((what, 1.0),)).as_json()
    times, readings = recorded(preload, Suggestion.of(asked, names))
    assert times[-1] == pytest.approx(30.0)
    torque = float(f"{size:.3g}") * true.sign[0]
    shifted = built.changed("free_angle", 0, float(built.of("free_angle")[0] + torque / built.of("spring")[0]))
    end = shifted.reading(rest_pose(shifted, PlantedTrial(np.zeros(1), 1.0), preload.truth.tilt))
    away = abs(float(end[0] - resting[0]))
    lag = float(torque / 30.0 * built.of("damper")[0] / built.of("spring")[0] ** 2)  # rad, a damper's, at most
    assert float(np.median(readings[-20:, 0])) == pytest.approx(float(end[0]), abs=0.01 * away + abs(2 * lag))


def test_a_release_is_set_by_what_the_encoder_shows(preload: Case) -> None:
    shifted = replace(preload, sensor=replace(preload.sensor, offset=np.array([0.2]), scale=np.array([0.1])))
    keys = {"tip_mass": "12 g", "tilt": "30 deg"}
    _, readings = recorded(shifted, Suggestion(keys, np.array([0.4]), None))
    noise = 5 * math.hypot(preload.setup.noise, 2 * math.pi / preload.setup.counts)
    assert readings[0, 0] == pytest.approx(0.4, abs=noise)


def test_the_suggested_trial_is_a_legal_trial_to_learn_from(preload: Case, folder: Path, tmp_path: Path) -> None:
    names = preload.setup.true.names
    add_trial(preload, folder, tmp_path / "more", Suggestion({"tilt": "30 deg"}, np.array([0.4]), (0, 0.01, 3.0)))
    before = read_gap_project(folder / "gap.yaml").trials
    project = read_gap_project(tmp_path / "more" / "gap.yaml")
    assert len(project.trials) == len(before) + 1
    (added,) = [trial for trial in project.trials if trial.name.endswith("next.csv")]
    assert added.tilt == pytest.approx(math.radians(30))
    assert not added.held_out
    assert added.torques is not None
    assert added.torques[-1, names.index("hip")] == pytest.approx(0.01)


def test_baselines_see_a_large_and_simple_cause(folder: Path) -> None:
    project = read_gap_project(folder / "gap.yaml")
    torque = bic(project)
    assert torque.verdict == "effect"
    assert math.isclose(torque.none + sum(p for _, p in torque.ranked), 1.0)
    assert torque.none < 1e-3
    # Its odds are unreliable (it is certain of a moved centre of mass); the true cause is among its first.
    assert ("spring_preload", "hip") in [key for key, _ in torque.ranked[:3]]
    freed = free_fit(project)
    assert ("spring_preload", "hip") in largest_change(freed, project).keys[:4]  # its fit is out of phase
    least = least_residual(freed, project)
    assert len(set(least.keys)) == len(least.keys) > 10
    assert 0.0 < least.after < 10.0
