"""Recordings sampled too slowly: seen by how readings jump and by the designed leg, and not taken for noise."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from diagnosis.simulated_releases import ONE, TWO, recorded
from synth.diagnosis.check import run
from synth.diagnosis.check.clocks import clock_findings, describe_sampling
from synth.diagnosis.check.undersampling import (
    ENOUGH_SAMPLES,
    ReadingJumps,
    designed_swings,
    doubt_of_frequency,
    reading_jumps,
    roughness_of,
)
from synth.files.gap_project import GapProject, Tolerance
from synth.fit.recordings import recordings
from synth.swing.leg_model import Damper

FINE = np.radians(0.05)  # rad, noise
FAST = designed_swings(TWO, recordings(TWO, recorded(TWO), ())[0])


def times(a_period: float, seconds: float = 4.0) -> np.ndarray:
    """Samples so many a period of the designed leg's fastest swing."""
    assert FAST is not None
    return np.arange(0.0, seconds, 1.0 / (a_period * FAST[1]))


@pytest.mark.parametrize("a_period", [1.02, 1.3, 1.7, 2.0, 2.4, 3.0])
def test_a_recording_of_too_few_samples_is_a_fault_whatever_it_looks_like(a_period: float) -> None:
    """At 1.2 samples a period it had "6.0 at 1 Hz", was to be recorded at 20 Hz, and its noise was 4.6 deg."""
    trials = recorded(TWO, time=times(a_period), noise=FINE, held_out=0)
    made = recordings(TWO, trials, ())
    found = clock_findings(TWO, made, [describe_sampling(TWO, recording) for recording in made])
    told = [each for each in found if each.level == "fault"]
    assert told
    assert FAST is not None
    for each in told:
        assert f"{FAST[0]:.3g} to {FAST[1]:.3g} Hz: {a_period:.1f} samples per period" in each.text
        assert float(each.remedy.split()[2]) >= 0.95 * 2.0 * ENOUGH_SAMPLES * FAST[1]
    lost = [describe_sampling(TWO, recording) for recording in made]
    assert all(one.as_json()["fastest_motion"] is None for one in lost if not one.resolved)


def test_no_noise_is_read_from_undersampled_recordings() -> None:
    trials = tuple(recorded(TWO, time=times(1.7), noise=FINE, held_out=0))
    found = run.check(GapProject(Path("gap.yaml"), TWO.name, TWO, trials, Tolerance(), 0, (), ()))
    assert not found.usable
    assert not [each for each in found.findings if "noise," in each.text or "above its noise" in each.text]
    assert all(channel.as_json()["noise"] is None for channel in found.channels)
    stated = GapProject(Path("gap.yaml"), TWO.name, TWO, trials, Tolerance(), 0, (), (), noise={"knee": FINE})
    assert [channel.noise for channel in run.check(stated).channels] == [None, FINE]


@pytest.mark.parametrize("noise", [1e-6, 0.02])
def test_enough_samples_are_no_fault_however_noisy(noise: float) -> None:
    made = recordings(TWO, recorded(TWO, time=times(20.0), noise=noise, held_out=0), ())
    assert clock_findings(TWO, made, [describe_sampling(TWO, recording) for recording in made]) == []


def test_a_slower_leg_than_designed_is_believed() -> None:
    """Its knee was designed to swing twice as fast; its readings show that it does not."""
    stiff = TWO.with_joints(knee={"link": TWO.joints[1].link.__class__(0.22, 0.35, 0.09, 2e-4)})
    made = recordings(stiff, recorded(TWO, time=np.arange(0.0, 3.0, 0.01), noise=1e-5), ())
    assert all(one.resolved for one in (describe_sampling(stiff, recording) for recording in made))


def test_jumps_are_those_of_a_sinusoid() -> None:
    (recording,) = recordings(ONE, recorded(ONE, away=np.array([[0.6]]), held_out=0), ())
    for a_period in (3.3, 5.7, 9.1):
        time = np.arange(200) * 0.01
        wave = np.sin(2.0 * np.pi * np.arange(200) / a_period)[:, None]
        made = recording.__class__(
            "a", time, wave, np.ones((200, 1), dtype=bool), recording.conditions, recording.smoothed
        )
        assert reading_jumps(made).roughness == pytest.approx(roughness_of(a_period), rel=0.1)


def test_without_a_designed_swing_nothing_is_sure() -> None:
    heavy = ONE.with_joints(knee={"damper": Damper(5.0)})
    (recording,) = recordings(heavy, recorded(ONE, away=np.array([[0.6]]), held_out=0), ())
    assert designed_swings(heavy, recording) is None
    assert doubt_of_frequency(10.0, 1.0, None, ReadingJumps(0.5, False)) == "unclear"
    assert doubt_of_frequency(10.0, 1.0, None, ReadingJumps(0.1, False)) == ""
    assert doubt_of_frequency(10.0, 1.0, (3.0, 3.0), ReadingJumps(np.nan, False)) == "slow"
