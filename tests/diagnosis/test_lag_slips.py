"""A drive's columns on another clock than the angles: late or early by more than any delay that is a cause."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from diagnosis.simulated_releases import TWO
from diagnosis.simulated_servos import ARM, driven
from diagnosis.test_inverted_inputs import HANGING, SPRUNG, found
from real_rigs.recorded import DRIVEN, RIGS
from synth.arrays import Array
from synth.diagnosis.check.finding import Finding
from synth.files.gap_project import read_gap_project
from synth.files.trial_list import Trial
from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, Leg

TIME = np.arange(0.0, 5.0, 0.01)


def swept(time: Array, k: int) -> Array:
    """N m, a sine of rising frequency: no two parts of it are alike."""
    return np.asarray(0.35 * np.sin(2.0 * np.pi * (0.3 + 0.1 * k + 0.25 * time) * time + k))


def late_by(finding: Finding) -> float:
    """S, as it is told: less than 0 of an early column."""
    told = re.search(r"looks? ([0-9.]+) s (late|early) against the angles: ", finding.text)
    assert told is not None, finding.text
    return float(told[1]) * (1.0 if told[2] == "late" else -1.0)


def pushed(leg: Leg, lags: tuple[float, ...]) -> list[Trial]:
    """The torque's columns ``lags`` s late; a logger goes on before and after."""
    trials = []
    for k, lag in enumerate(lags):
        applied, told = (swept(TIME - by, k)[:, None] for by in (0.0, lag))
        motion = simulate(leg, [0.1], [0.0], TIME, known_torque=(TIME, leg.sign * applied))
        noise = np.radians(0.03) * np.random.default_rng(k).standard_normal(motion.shape)
        trials.append(Trial(f"{k}.csv", TIME, leg.to_measured(motion) + noise, torques=told))
    return trials


@pytest.mark.parametrize(("lag", "words", "shift"), [(0.5, "late", "-"), (-0.6, "early", "+")])
def test_a_torque_on_another_clock_is_named(lag: float, words: str, shift: str) -> None:
    """The check was silent, and the diagnosis named causes: no delay is so long, and none is negative."""
    assert found(SPRUNG, pushed(SPRUNG, (0.0, 0.0))) == []
    (finding,) = found(SPRUNG, pushed(SPRUNG, (lag, lag)))
    size = f"{abs(lag):g} s"
    assert finding.text.startswith(f"the column knee torque looks {size} {words} against the angles: ")
    assert finding.remedy == f"shift it by {shift}{size}, or set the two clocks alike"
    assert "0.csv" in finding.recording
    assert "1.csv" in finding.recording


def test_one_recording_alone_may_be_on_another_clock() -> None:
    (finding,) = found(SPRUNG, pushed(SPRUNG, (0.0, 0.7, 0.0)))
    assert finding.recording == "1.csv"
    assert finding.text.startswith("the column knee torque looks 0.7 s late ")
    assert finding.remedy.endswith("; of these recordings only: others fit as they are")


@pytest.mark.parametrize(("lags", "told"), [((0.0, 0.0, 0.7), False), ((0.0, 0.7, 0.7), True)])
def test_one_lag_among_recordings_of_another_fault_may_be_chance(lags: tuple[float, ...], told: bool) -> None:
    """Those without a lag follow another torque than the column says, which no change of columns explains."""
    trials = pushed(SPRUNG, lags)
    for k, lag in enumerate(lags):
        if not lag:
            wandering = 0.03 * np.cumsum(np.random.default_rng(k + 5).standard_normal(len(TIME)))
            trials[k] = replace(trials[k], torques=wandering[:, None])
    lagging = [finding for finding in found(SPRUNG, trials) if "against the angles" in finding.text]
    assert bool(lagging) == told
    if told:
        assert "1.csv" in lagging[0].recording
        assert "2.csv" in lagging[0].recording


def test_of_a_steady_sinusoid_no_lag_is_told() -> None:
    """A period more or less fits as well, and so does another damper or spring."""
    leg = HANGING.with_joints(knee={"damper": Damper(rate=0.05)})
    time, shown = np.arange(0.0, 12.0, 0.01), slice(700, None)
    trials = []
    for k in range(2):
        applied, told = (0.3 * np.sin(2.0 * np.pi * (0.9 + 0.2 * k) * (time - by))[:, None] for by in (0.0, 0.4))
        motion = leg.to_measured(simulate(leg, [0.1], [0.0], time, known_torque=(time, leg.sign * applied)))
        noise = np.radians(0.03) * np.random.default_rng(k).standard_normal(motion.shape)
        angles = (motion + noise)[shown]
        trials.append(Trial(f"{k}.csv", time[shown] - time[shown][0], angles, torques=told[shown]))
    assert not [finding for finding in found(leg, trials) if "against the angles" in finding.text]


def test_a_missing_damper_is_no_lag() -> None:
    assert found(SPRUNG, pushed(SPRUNG.with_joints(knee={"damper": Damper(rate=0.2)}), (0.0, 0.0))) == []


@pytest.mark.parametrize("late", [(0, 1), (1,)])
def test_of_two_joints_both_columns_may_be_late_or_one(late: tuple[int, ...]) -> None:
    columns = [[0.9, 0.25][j] * np.stack([swept(TIME - by, j) for by in (0.0, 0.5)], axis=1) for j in range(2)]
    applied = np.stack([columns[0][:, 0], columns[1][:, 0]], axis=1)
    motion = simulate(TWO, [0.1, 0.2], [0.0, 0.0], TIME, known_torque=(TIME, TWO.sign * applied))
    told = np.stack([columns[j][:, int(j in late)] for j in range(2)], axis=1)
    noise = np.radians(0.03) * np.random.default_rng(0).standard_normal(motion.shape)
    trial = Trial("0.csv", TIME, TWO.to_measured(motion) + noise, torques=told)
    assert found(TWO, [replace(trial, torques=applied)]) == []
    (finding,) = found(TWO, [trial])
    names = "the columns hip torque and knee torque look" if len(late) == 2 else "the column knee torque looks"
    assert finding.text.startswith(f"{names} 0.5 s late against the angles: ")


def shifted(trial: Trial, lag: float) -> Trial:
    """The held command's column ``lag`` s late: what was commanded before the log is not in it."""
    signals = trial.signals
    assert signals is not None
    last = np.clip(np.searchsorted(signals.time, signals.time - lag + 1e-9, side="right") - 1, 0, None)
    return replace(trial, signals=replace(signals, command=signals.command[last]))


@pytest.mark.parametrize("lag", [0.4, -0.5])
def test_a_command_of_another_start_is_named(lag: float) -> None:
    trials = driven(ARM, 3)
    assert found(ARM, trials) == []
    (finding,) = found(ARM, [shifted(trial, lag) for trial in trials])
    assert finding.text.startswith("the column knee command looks ")
    assert late_by(finding) == pytest.approx(lag, abs=0.02)


@pytest.mark.skipif(not DRIVEN.is_dir(), reason=f"not here: {DRIVEN}")
@pytest.mark.parametrize("lag", [0.0, 0.5, -0.6])
def test_the_lag_of_a_real_pendulum_is_told_and_none_of_unshifted_columns(lag: float, tmp_path: Path) -> None:
    """Its friction is not stated, and its torque, of a motor's current, scatters."""
    project = read_gap_project(RIGS["driven pendulum"](tmp_path).project(tmp_path, 0))
    told = []
    for trial in project.trials:
        assert trial.torques is not None
        late = np.interp(trial.time - lag, trial.time, trial.torques[:, 0])[:, None]
        told.append(replace(trial, torques=late))
    lags = [finding for finding in found(project.leg, told) if "against the angles" in finding.text]
    if not lag:
        assert lags == []
        return
    (finding,) = lags
    assert late_by(finding) == pytest.approx(lag, abs=0.03)
