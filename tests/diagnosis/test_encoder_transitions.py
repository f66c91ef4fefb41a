"""Coarse counts: the information in a transition, and the accuracy that it allows."""

from __future__ import annotations

import numpy as np
import pytest

from diagnosis.simulated_releases import TIME, TWO, off, recorded, with_effects
from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial, angle_trial
from synth.diagnosis.encoder_counts import (
    CoarseChannel,
    counts_matter,
    noise_as_read,
    noise_of_rounded,
    round_to_counts,
)
from synth.diagnosis.encoder_transitions import with_edges
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose
from synth.files.gap_project import Tolerance
from synth.fit.recordings import recordings

STEP, USUAL = 0.04, 1e-4  # rad


def counted(angle: Array, time: Array) -> tuple[AngleTrial, AngleTrial]:
    """A trial whose knee reads ``angle`` (m,) in counts of ``STEP``, and the same at its edges."""
    (recording,) = recordings(TWO, recorded(TWO, np.array([[0.5, 0.6]]), time=time, held_out=0), ())
    trial = angle_trial(recording, held_out=False)
    trial.measured[:, 1] = STEP * np.round(angle / STEP)
    return trial, with_edges(trial, [CoarseChannel(1, STEP)], np.full(2, USUAL))


def spread(made: AngleTrial) -> Array:
    """(m,) rad, the deviation that counts leave of the knee's samples that are used."""
    assert made.relative is not None
    return USUAL * np.sqrt(np.maximum(made.relative[made.counts[:, 1], 1] ** 2 - 1.0, 0.0))


def test_a_transition_locates_a_slow_angle_better_than_one_count() -> None:
    time = np.arange(401) * 0.005
    angle = 0.3 * np.cos(2.0 * time)
    raw, made = counted(angle, time)
    kept = made.counts[:, 1]
    away = np.abs(made.measured[kept, 1] - angle[kept])
    sharp = spread(made) < 0.05 * STEP
    assert sharp.sum() > 10
    assert away[sharp].max() < 0.1 * STEP
    assert away.max() < 0.51 * STEP
    assert kept.sum() < 0.6 * raw.counts[:, 1].sum()
    np.testing.assert_array_equal(made.counts[:, 0], raw.counts[:, 0])
    np.testing.assert_array_equal(made.measured[:, 0], raw.measured[:, 0])


def test_stated_deviations_match_the_errors() -> None:
    """Root mean square of miss over deviation, over motions slow and fast; samples at rest are few and not sure."""
    ratios = []
    for speed in (0.5, 2.0, 8.0, 30.0):
        for phase in (0.0, 0.4, 1.1):
            time = np.arange(601) * 0.004
            angle = 0.4 * np.sin(speed * time + phase)
            _, made = counted(angle, time)
            kept, deviation = made.counts[:, 1], spread(made)
            moving = deviation < 0.9 * STEP / np.sqrt(12.0)
            miss = (made.measured[kept, 1] - angle[kept]) / np.hypot(deviation, 0.01 * STEP)
            ratios.append(np.mean(miss[moving] ** 2) if moving.any() else np.nan)
    assert 0.4 < np.sqrt(np.nanmean(ratios)) < 1.2


def test_a_constant_reading_informs_to_one_count_only() -> None:
    time = np.arange(301) * 0.005
    _, made = counted(np.full(301, 0.1), time)
    kept = made.counts[:, 1]
    assert 1 <= kept.sum() <= 12
    information = np.sum(1.0 / spread(made) ** 2)
    assert information == pytest.approx(12.0 / STEP**2, rel=0.1)  # of one sample within a count


def test_held_out_readings_are_predicted_to_the_count() -> None:
    """Rounded predictions of a leg known to a fraction of a count differ in few samples from the readings."""
    step = 0.05
    built = with_effects(off(TWO, 1), {"knee": {"encoder_quantisation": {"step": step}}})
    result = diagnose(TWO, recorded(built, seed=1, noise=np.radians(0.02), time=TIME), Tolerance())
    assert result.verdict == "effect"
    assert [(c.effect, c.joint) for c in result.explanation] == [("encoder_quantisation", "knee")]
    assert result.after.value < 0.45 * step / np.sqrt(12.0) / np.sqrt(2.0)  # of both joints; .5 before


@pytest.mark.parametrize("noise", [0.02, 0.05, 0.2])  # of a count
def test_the_noise_of_readings_that_are_rounded(noise: float) -> None:
    """By chance, and in the mean over a count; readings quieter than assumed tell their own noise."""
    generator = np.random.default_rng(4)
    time = np.arange(800) * 0.005
    angle = STEP * time  # four counts
    trial, _ = counted(angle + noise * STEP * generator.standard_normal(800), time)
    coarse, usual = [CoarseChannel(1, STEP)], np.array([USUAL, noise * STEP])
    prediction = np.column_stack([trial.measured[:, 0], angle])
    made = noise_of_rounded(trial, prediction, coarse, usual)
    np.testing.assert_array_equal(made[:, 0], USUAL)
    assert np.mean(made[:, 1] ** 2) == pytest.approx(noise * STEP**2 * np.sqrt(2.0 / np.pi), rel=0.02)
    square = [
        np.mean((STEP * np.round((angle + noise * STEP * generator.standard_normal(800)) / STEP)
                 - STEP * np.round(angle / STEP)) ** 2)
        for _ in range(200)
    ]  # fmt: skip
    assert np.mean(made[:, 1] ** 2) == pytest.approx(np.mean(square), rel=0.15)
    (loud,) = noise_as_read([trial], [prediction], coarse, np.array([USUAL, 0.28 * STEP]))
    told = round_to_counts(trial, prediction, coarse) - trial.measured
    assert np.mean(loud[:, 1] ** 2) == pytest.approx(np.mean(told[:, 1] ** 2))


@pytest.mark.parametrize(("error", "matters"), [(0.0, True), (0.5, True), (2.0, False), (150.0, False)])
def test_counts_are_a_cause_where_they_make_a_tenth_of_what_is_left(error: float, matters: bool) -> None:
    """The last digit of a filtered recording was 95 % the cause of an error 500 times as large."""
    time = np.arange(401) * 0.005
    angle = 0.3 * np.cos(2.0 * time)
    trial, _ = counted(angle, time)
    predicted = trial.measured.copy()
    predicted[:, 1] = angle + error * STEP / np.sqrt(6.0) * np.cos(9.0 * time)
    coarse = [CoarseChannel(1, STEP)]
    assert counts_matter([trial], [predicted], coarse) == matters
    assert not counts_matter([trial], [], [])
