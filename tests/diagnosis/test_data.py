"""What the recordings show before any model: copies, noise, encoder counts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, filtfilt

from diagnosis.simulated_releases import NOISE, TIME, TWO, off, recorded, with_effects
from synth.diagnosis.angle_trials import angle_trial
from synth.diagnosis.encoder_counts import coarse_counts, round_to_counts, usual_noise
from synth.files.trial_list import Trial
from synth.fit import sensor_noise
from synth.fit.copies import copies
from synth.fit.recordings import Recording, recordings
from synth.fit.sensor_noise import FILTERED_RATIO, estimate_sensor

LEG = off(TWO, 2)
TRIALS = recorded(LEG, held_out=0)


def read(trials: list[Trial]) -> list[Recording]:
    return recordings(TWO, trials, ())


def copied(trials: list[Trial]) -> list[tuple[int, int]]:
    """Pairs (copy, original)."""
    return copies(read(trials), [trial.held_out for trial in trials])


def test_different_releases_are_no_copies() -> None:
    assert copied(TRIALS) == []


def test_a_repeated_release_is_no_copy() -> None:
    assert copied([*TRIALS, *recorded(LEG, held_out=0, seed=9)]) == []


@pytest.mark.parametrize("count", [0.0, np.radians(0.088)])  # of an encoder of 12 bits
def test_a_repeat_with_noise_of_its_own_is_no_copy(count: float) -> None:
    """A servo repeats a command to a hundredth of its sensor's noise, which is a ten thousandth of the motion."""
    rng = np.random.default_rng(4)
    clean = np.radians(50.0) * np.sin(2.0 * np.pi * 0.8 * TIME)[:, None] * np.ones(2)
    noisy = [clean + np.radians(0.012) * rng.standard_normal(clean.shape) for _ in range(3)]
    angles = [np.round(each / count) * count if count else each for each in noisy]
    runs = [
        replace(TRIALS[0], name=f"{k}.csv", time=TIME, angles=each, velocities=None) for k, each in enumerate(angles)
    ]
    assert copied(runs) == []
    assert copied([*runs, replace(runs[1], name="copy.csv")]) == [(3, 1)]


@pytest.mark.parametrize("change", ["same", "cut short", "fewer digits"])
def test_a_copy_is_detected_after_editing(change: str) -> None:
    copy = replace(TRIALS[1], name="copy.csv")
    if change == "cut short":
        copy = replace(copy, time=copy.time[:120], angles=copy.angles[:120])
    if change == "fewer digits":
        copy = replace(copy, angles=np.radians(np.round(np.degrees(copy.angles), 2)))
    assert copied([*TRIALS, copy]) == [(len(TRIALS), 1)]


def test_a_held_out_copy_of_a_training_trial_is_the_copy() -> None:
    held = replace(TRIALS[2], name="unseen.csv", held_out=True)
    assert copied([held, *TRIALS]) == [(0, 3)]


@pytest.mark.parametrize("noise", [0.02, 0.1, 0.5])
def test_noise_is_estimated_from_the_readings_alone(noise: float) -> None:
    found = estimate_sensor(read(recorded(LEG, noise=np.radians(noise), held_out=0)))
    np.testing.assert_allclose(np.degrees(found.noise), noise, rtol=0.1)
    assert coarse_counts(found) == ()


@pytest.mark.parametrize("noise", [0.01, 0.1])
@pytest.mark.parametrize("spread", [0.05, 0.25])
def test_noise_of_samples_at_uneven_times(noise: float, spread: float) -> None:
    """As a computer's loop logs them, stamped right; at a quarter plain differences show 0.05 to 0.17 deg of motion."""
    steps = np.random.default_rng(8).normal(1.0, spread, 400).clip(0.3, 1.7)
    found = estimate_sensor(read(recorded(LEG, noise=np.radians(noise), held_out=0, time=0.005 * np.cumsum(steps))))
    np.testing.assert_allclose(np.degrees(found.noise), noise, rtol=0.1)
    assert np.all(found.scatter < FILTERED_RATIO)


@pytest.mark.parametrize("cutoff", [40.0, 80.0, 120.0])
def test_noise_of_filtered_readings_is_what_the_filter_let_through(cutoff: float) -> None:
    """A zero-phase Butterworth filter, as labs use it, at 500 Hz; the motion's frequencies are 1 to 4 Hz."""
    time = np.arange(0.0, 3.0, 0.002)
    noise, generator = np.radians(0.05), np.random.default_rng(5)
    low = butter(2, cutoff, fs=500.0)
    clean = recorded(LEG, noise=0.0, held_out=0, time=time)
    shaken = [replace(t, angles=t.angles + noise * generator.standard_normal(t.angles.shape)) for t in clean]
    smooth = [replace(t, angles=filtfilt(*low, t.angles, axis=0)) for t in shaken]
    written = [replace(t, angles=np.radians(np.round(np.degrees(t.angles), 5))) for t in smooth]
    apart = [filtfilt(*low, a.angles - b.angles, axis=0) for a, b in zip(shaken, clean, strict=True)]
    found = estimate_sensor(read(written))
    np.testing.assert_allclose(found.noise, np.std(np.concatenate(apart)), rtol=0.25)
    assert (found.scatter > FILTERED_RATIO).all()


def test_noise_of_filtered_readings_that_a_smooth_motion_follows(monkeypatch: pytest.MonkeyPatch) -> None:
    """A fine sensor at 1 kHz: only rounding is left from one reading to the next, and a fast motion hides the rest."""
    monkeypatch.setattr(sensor_noise, "_scatter_ratio", lambda *given: 1.0)
    time = np.arange(0.0, 1.5, 0.001)
    noise, generator = np.radians(0.004), np.random.default_rng(5)
    low = butter(2, 50.0, fs=1000.0)
    clean = recorded(LEG, noise=0.0, held_out=0, time=time)
    shaken = [replace(t, angles=t.angles + noise * generator.standard_normal(t.angles.shape)) for t in clean]
    smooth = [replace(t, angles=filtfilt(*low, t.angles, axis=0)) for t in shaken]
    written = [replace(t, angles=np.radians(np.round(np.degrees(t.angles), 5))) for t in smooth]
    apart = [filtfilt(*low, a.angles - b.angles, axis=0) for a, b in zip(shaken, clean, strict=True)]
    np.testing.assert_allclose(estimate_sensor(read(written)).noise, np.std(np.concatenate(apart)), rtol=0.35)


def test_a_channel_with_more_noise_is_not_pooled_with_the_others() -> None:
    generator = np.random.default_rng(3)
    louder = [
        replace(t, angles=t.angles + generator.normal(0.0, [0.0, 4 * NOISE], t.angles.shape)) for t in TRIALS
    ]  # fmt: skip
    noise = estimate_sensor(read(louder)).noise
    assert noise[0] == pytest.approx(NOISE, rel=0.1)
    assert noise[1] == pytest.approx(np.sqrt(17.0) * NOISE, rel=0.1)


def test_coarse_counts_are_detected_at_their_joint() -> None:
    step = np.radians(1.0)
    trials = recorded(with_effects(LEG, {"knee": {"encoder_quantisation": {"step": step}}}), held_out=0)
    found = estimate_sensor(read(trials))
    (coarse,) = coarse_counts(found)
    assert coarse.joint == 1
    assert coarse.step == pytest.approx(step, rel=1e-6)
    assert usual_noise(found, (coarse,))[1] == pytest.approx(NOISE, rel=0.1)  # as it would be without the counts
    stated = usual_noise(found.stated(TWO.joint_names, {TWO.joint_names[1]: 0.01}), (coarse,))
    assert stated[1] == 0.01  # what is stated of the channel, as it is
    assert stated[0] == usual_noise(found, (coarse,))[0]
    trial = angle_trial(read(trials)[0], held_out=False)
    told = round_to_counts(trial, trial.measured + 0.3 * step, (coarse,))
    np.testing.assert_allclose(told[:, 1], trial.measured[:, 1], atol=1e-9)
    np.testing.assert_allclose(told[:, 0], trial.measured[:, 0] + 0.3 * step)


def test_counts_shared_by_all_channels_are_no_cause() -> None:
    step = np.radians(360 / 4096)
    counted = [replace(t, angles=step * np.round(t.angles / step)) for t in recorded(LEG, noise=0.0, held_out=0)]
    found = estimate_sensor(read(counted))
    np.testing.assert_allclose(found.step, step, rtol=1e-6)
    assert coarse_counts(found) == ()


def test_counts_are_seen_though_a_file_rounds_each_reading() -> None:
    """A real drive's log: 16 bits over 30 turns in seven digits, and at rest for most of the time."""
    time, step = np.arange(4001) * 1e-3, 2.0 * 95.5 / 2**16
    moves = np.sin(np.pi * np.minimum(time, 1.2) / 2.4)
    (trial,) = recorded(LEG, np.array([[0.4, -0.5]]), noise=0.0, held_out=0)
    counted = step * np.round(np.array([1.0, 20.0]) * moves[:, None] / step)
    written = np.array([[float(f"{value:.7g}") for value in row] for row in counted])
    found = estimate_sensor(read([replace(trial, time=time, angles=written)]))
    np.testing.assert_allclose(found.step, step, rtol=1e-5)
    np.testing.assert_allclose(found.noise, step / np.sqrt(12.0), rtol=0.3)


def test_samples_are_thinned_evenly() -> None:
    time = np.arange(3001) * 1e-3
    (trial,) = recorded(LEG, np.array([[0.4, -0.5]]), time=time, held_out=0)
    thin = angle_trial(read([trial])[0], held_out=True)
    assert 350 < len(thin.time) < 1000
    assert np.ptp(np.diff(thin.time)) < 1e-9
    assert thin.held_out
    assert len(angle_trial(read(TRIALS)[0], held_out=False).time) == len(TIME)


@pytest.mark.parametrize(("factor", "told"), [(0.1, True), (0.5, False), (2.0, False), (7.0, True)])
def test_a_stated_noise_that_the_readings_contradict_is_doubted(factor: float, told: bool) -> None:
    """A slip of a digit made a leg four times better than perfect, or white noise an unexplained remainder."""
    made = recordings(TWO, recorded(TWO), ())
    shown = estimate_sensor(made)
    doubts = shown.stated(TWO.joint_names, {"knee": factor * float(shown.noise[1])}).doubts
    assert [text.startswith("knee: a noise of ") for text in doubts] == [True] * told
