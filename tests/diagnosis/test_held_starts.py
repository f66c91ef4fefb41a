"""Recordings that begin while the leg is still held are a fault; slow, resting and driven starts are none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.simulated_releases import AWAY, ONE, TWO, heavier, off, recorded, with_effects
from diagnosis.test_gap_check import faults, project
from synth.arrays import Array
from synth.diagnosis.check import run
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import scene_of
from synth.diagnosis.plants.swinging_chain.held_starts import HELD_START, doubt_of_held_starts
from synth.files.tolerance import Tolerance
from synth.files.trial_list import Trial
from synth.remarks import Remark, kind_of, severity_of
from synth.swing.leg_model import Leg

TIME = np.arange(401) * 0.005
STEP = float(TIME[1])


def held(trial: Trial, samples: int, seed: int = 7) -> Trial:
    """The recording with so many samples before it at its first angles, with noise of 0.1 deg."""
    noise = np.radians(0.1) * np.random.default_rng(seed).standard_normal((samples, trial.angles.shape[1]))
    angles = np.vstack([trial.angles[0] + noise, trial.angles])
    return replace(trial, time=np.arange(len(angles)) * STEP, angles=angles)


def releases(leg: Leg, away: Array = AWAY) -> list[Trial]:
    return recorded(leg, away, seed=4, time=TIME, held_out=0)


def remarks(leg: Leg, trials: list[Trial]) -> list[str]:
    """The remarks on held starts, by the nominal ``leg``."""
    _, said = scene_of(leg, trials, Tolerance(), 0)
    return [text for text in said if kind_of(text) == HELD_START]


@pytest.mark.parametrize("samples", [8, 20, 80])
def test_a_hold_is_a_fault_that_says_until_when(samples: int) -> None:
    first, *others = releases(off(TWO, 3))
    found = run.check(project(TWO, [held(first, samples), *others]))
    (fault,) = faults(found)
    assert fault.recording == first.name
    until = float(fault.text.split("stands still until ")[1].split(" s")[0])
    assert samples * STEP <= until <= (samples + 3) * STEP
    assert "knee by" in fault.text
    assert ("hip by" in fault.text) == (samples > 8)
    assert "remove the rows" in fault.remedy


def test_gap_warns_first_and_trusts_no_cause() -> None:
    _, said = scene_of(TWO, [held(each, 10) for each in releases(TWO)], Tolerance(), 0)
    first = said[0]
    assert isinstance(first, Remark)
    assert (kind_of(first), severity_of(first)) == (HELD_START, "decide")
    assert all(each in first for each in ("0.csv", "1.csv until", "3.csv until"))
    assert doubt_of_held_starts(said) > 0.5
    assert doubt_of_held_starts(said[1:]) == 0.0


def test_a_free_start_is_no_hold() -> None:
    """As designed, a leg three times as heavy, one with much friction, one that is filtered, one with coarse counts."""
    filtered = {"latency": {"delay": 0.0, "lag": 0.02}}
    friction = {"coulomb_friction": {"torque": 0.15}}
    for built in (
        TWO,
        heavier(heavier(TWO, "hip", 2.0), "knee", 2.0),
        with_effects(TWO, {"hip": friction, "knee": friction}),
        with_effects(TWO, {"hip": filtered, "knee": filtered}),
        with_effects(TWO, {name: {"encoder_quantisation": {"step": np.radians(2.0)}} for name in TWO.joint_names}),
    ):
        assert remarks(TWO, releases(built)) == []


def test_a_joint_that_rests_or_is_locked_is_not_held() -> None:
    """At the nominal leg's equilibrium, or within its tolerances of it, nothing must move; a held joint neither."""
    (trial,) = releases(ONE, np.array([[0.6]]))
    still = np.vstack([np.full((40, 1), trial.angles[-1]), trial.angles])  # at its rest pose, then moved by hand
    pushed = replace(trial, time=np.arange(len(still)) * STEP, angles=still)
    assert remarks(ONE, [pushed]) == []
    (free,) = releases(TWO, AWAY[:1])
    one_still = free.angles.copy()
    one_still[:, 1] = free.angles[0, 1]
    assert remarks(TWO, [replace(free, angles=one_still, locked=("knee",))]) == []


def test_a_driven_leg_may_be_held_by_its_drive() -> None:
    trial = held(releases(ONE, np.array([[0.6]]))[0], 80)
    assert len(remarks(ONE, [trial])) == 1
    torques = np.zeros_like(trial.angles)
    torques[:80] = 0.9
    assert remarks(ONE, [replace(trial, torques=torques)]) == []


def test_equal_delays_of_a_single_joint_may_be_its_latency() -> None:
    """That is a cause in the library, so a doubt; holds that differ are none."""
    first, second = releases(ONE, np.array([[0.6], [-0.5]]))
    alike, apart = ([held(first, n), held(second, 20, seed=8)] for n in (20, 30))
    (finding,) = [each for each in run.check(project(ONE, alike)).findings if "stands still" in each.text]
    assert finding.level == "doubt"
    assert "latency" in finding.text
    assert faults(run.check(project(ONE, apart)))
