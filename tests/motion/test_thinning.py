"""Recordings with far more samples than needed: thinned, reported, and fitted as precisely as from all samples."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import pytest

from synth.arrays import Array
from synth.files.trial_list import Trial
from synth.fit.estimate import fit_leg
from synth.fit.recordings import recordings
from synth.motion import thinning
from synth.motion.smoothing import lost_samples
from synth.motion.thinning import UNTHINNED_SAMPLES, thin_recording
from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

NOISE = np.radians(0.1)
LEG = Leg(
    "two",
    (
        Joint("hip", Link(0.25, 0.6, 0.11, 4e-3), 0.4, 1, None, Spring(6.0, 0.5), Damper(0.08)),
        Joint("knee", Link(0.22, 0.35, 0.09, 2e-3), 2.0, -1, None, Spring(1.5, 1.8), Damper(0.015)),
    ),
)


def trial(count: int, seconds: float = 1.2, count_width: float = 0.0, seed: int = 1) -> Trial:
    """A release of the leg, its readings with noise or in counts."""
    times = np.linspace(0.0, seconds, count)
    rotation = simulate(LEG, LEG.rest + np.array([0.5, 0.7]), [0.0, 0.0], times, tolerance=1e-9)
    noise = NOISE if count_width == 0.0 else 0.02 * count_width
    rotation = rotation + np.random.default_rng(seed).normal(0.0, noise, rotation.shape)
    if count_width:
        rotation = count_width * np.round(rotation / count_width)
    return Trial("a.csv", times, LEG.to_measured(rotation))


def bare(leg: Leg) -> Leg:
    """The leg without springs and dampers."""
    return replace(leg, joints=tuple(replace(joint, spring=None, damper=None) for joint in leg.joints))


def test_the_fit_of_a_thinned_recording_is_that_of_all_samples(monkeypatch: pytest.MonkeyPatch) -> None:
    given = trial(20_001)
    few = fit_leg(bare(LEG), recordings(bare(LEG), [given]))
    monkeypatch.setattr(thinning, "UNTHINNED_SAMPLES", 10**9)
    every = fit_leg(bare(LEG), recordings(bare(LEG), [given]))
    assert any(text.startswith("a.csv: 20001 samples over 1.2 s are more") for text in few.warnings)
    assert not any("more than the motion needs" in text for text in every.warnings)
    for name in LEG.joint_names:
        for key in ("spring_rate", "damper_rate", "free_angle"):
            one, other = getattr(few.joints[name], key), getattr(every.joints[name], key)
            half, full = one.high - one.low, other.high - other.low
            assert abs(one.value - other.value) < 0.15 * full
            assert half == pytest.approx(full, rel=0.15)


def test_a_million_samples_are_read_in_seconds() -> None:
    given = trial(1_000_001)
    began = time.process_time()
    (made,) = recordings(bare(LEG), [given])
    assert time.process_time() - began < 10.0  # 40 s and 1.6 GB where every sample is smoothed
    assert thinning.LEAST_SAMPLES <= len(made.time) <= 2 * UNTHINNED_SAMPLES
    assert float(np.mean(made.smoothed.noise)) < 0.2 * NOISE  # the mean of some hundred samples


def means_of(given: Trial) -> tuple[thinning.ThinnedRecording, Array]:
    """A trial thinned, and the true rotation at its times."""
    rotation = LEG.to_rotation(given.angles)
    found = thin_recording(given.time, rotation, lost_samples(given.time, rotation))
    return found, simulate(LEG, LEG.rest + np.array([0.5, 0.7]), [0.0, 0.0], found.time - 0.0, tolerance=1e-9)


def test_a_short_recording_stays_as_it_is_and_a_long_rest_does_not_hide_the_swing() -> None:
    short, _ = means_of(trial(UNTHINNED_SAMPLES))
    assert (short.group, short.sentence) == (1, "")
    long, _ = means_of(trial(100_001, 100.0))
    swing, _ = means_of(trial(10_001, 10.0))
    assert long.group == swing.group  # 1 ms apart both
    assert long.group * 1e-3 < 0.02


def test_lost_samples_stay_lost_and_gaps_are_not_averaged() -> None:
    given = trial(30_001)
    angles = given.angles.copy()
    angles[12_000:12_500] = np.nan
    kept = np.r_[0:20_000, 24_000:30_001]
    found, _ = means_of(replace(given, time=given.time[kept], angles=angles[kept]))
    at = (found.time > given.time[12_000]) & (found.time < given.time[12_499])
    assert found.lost[at].all()
    across = np.abs(np.diff(found.time)) > 1.2 * np.median(np.diff(found.time))
    assert found.lost[:-1][across].any() or found.lost[1:][across].any()
    assert found.lost.mean() < 0.05


def test_coarse_counts_are_not_averaged_and_none_is_skipped() -> None:
    width = np.radians(0.35)
    found, _ = means_of(trial(60_001, 1.2, width))
    assert found.group > 1
    counts = found.angle / width
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-6)
    assert np.percentile(np.abs(np.diff(counts, axis=0)), 98.0) <= 1.0 + 1e-6
