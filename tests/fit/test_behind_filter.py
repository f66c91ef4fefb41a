"""Fits of filtered readings: the filter is named, what it smears is left out, and the intervals hold."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.signal import butter, filtfilt

from diagnosis.simulated_releases import AWAY, TWO, recorded
from synth.arrays import Array
from synth.files.project_options import FitOptions
from synth.files.trial_list import Trial
from synth.fit.behind_filter import bent_by_filter, filtered, seen_filter
from synth.fit.estimate import fit_leg
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_problem import model_of
from synth.fit.fit_result import FitResult
from synth.fit.least_squares import FitStart
from synth.fit.methods import fit_by
from synth.fit.noise_spectrum import filter_of_noise
from synth.fit.recordings import recordings
from synth.fit.refinement import refine
from synth.fit.starts import first_locals, weak_form_start
from synth.motion.low_pass import LowPass, SeenFilter
from synth.remarks import Remark

TIME, HELD = np.arange(0.0, 2.0, 0.005), 100  # s; samples in which the leg is held before its release
NOISE = np.radians(0.2)
FREE = LegFitOptions(release="free", laws="auto")


@cache
def trials(cutoff: float, seed: int = 5) -> tuple[Trial, ...]:
    """Releases from rest that went through a filter, Hz, together with the time before; 0 for none."""
    generator, made = np.random.default_rng(seed), []
    for trial in recorded(TWO, noise=0.0, held_out=0, time=TIME):
        whole = np.vstack([np.repeat(trial.angles[:1], HELD, axis=0), trial.angles])
        whole = whole + NOISE * generator.standard_normal(whole.shape)
        if cutoff:
            whole = filtfilt(*butter(2, cutoff / 100.0), whole, axis=0)
        made.append(replace(trial, angles=whole[HELD:]))
    return tuple(made)


@cache
def fit_of(cutoff: float, release: str = "free") -> FitResult:
    made = recordings(TWO, trials(cutoff))
    return fit_by(TWO, made, replace(FREE, release=release), FitOptions())  # type: ignore[arg-type]


def scores(result: FitResult) -> Array:
    """(n, 3) errors of spring rates, damper rates and free angles, in half widths of their 90 % intervals."""
    found = []
    for joint in TWO.joints:
        assert joint.spring is not None
        assert joint.damper is not None
        estimated = result.joints[joint.name]
        pairs = (estimated.spring_rate, joint.spring.rate), (estimated.damper_rate, joint.damper.rate)
        for estimate, truth in (*pairs, (estimated.free_angle, joint.spring.free_angle)):
            assert estimate is not None
            assert estimate.low is not None
            assert estimate.high is not None
            assert truth is not None
            found.append((estimate.value - truth) / (0.5 * (estimate.high - estimate.low)))
    return np.array(found)


@pytest.mark.parametrize("cutoff", [12.0, 20.0])
def test_intervals_hold_and_the_filter_is_told(cutoff: float) -> None:
    """Fitted from their first sample, they were off by up to six half widths, and a hand was blamed."""
    result = fit_of(cutoff)
    assert np.abs(scores(result)).max() < 2.0
    (note,) = (text for text in result.warnings if "low-pass filtered" in text)
    assert isinstance(note, Remark)
    assert "raw readings" in note.remedy
    assert "ms after each start are fitted" in note
    assert not any("a hand" in text or "external torque" in text for text in result.warnings)
    assert 1.0 / cutoff < result.cut < 3.0 / cutoff
    assert result.as_json()["fitted_from"]["value"] == pytest.approx(result.cut)


def test_all_samples_are_fitted_when_asked_and_the_filter_is_the_likely_reason() -> None:
    result = fit_of(12.0, "recorded")
    assert result.cut == 0.0
    (text,) = (each for each in result.warnings if each.startswith("release: "))
    assert "low-pass filtered" in text
    assert text.index("likely reason") < text.index("a hand")


def test_raw_readings_are_fitted_as_before() -> None:
    made = recordings(TWO, trials(0.0))
    assert seen_filter(TWO, made, FREE) is None
    one, other = fit_of(0.0), fit_leg(TWO, made, FREE)
    assert one.as_json() == other.as_json()


@pytest.mark.parametrize(
    "one",
    [
        LowPass("mean", points=9),
        *(LowPass("butterworth", order=2, cutoff=cutoff, passes=2) for cutoff in (0.2, 0.06, 0.012)),
    ],
)
def test_a_filter_is_found_in_noise_alone(one: LowPass) -> None:
    parts = [one.noise(1600, np.random.default_rng(k)) for k in range(6)]
    found = filter_of_noise(parts, 0.0)
    assert found is not None
    assert found.reach == pytest.approx(one.reach, rel=0.5)
    assert filter_of_noise([np.random.default_rng(k).standard_normal(400) for k in range(6)], 0.0) is None


def test_a_motion_behind_a_filter_is_as_scipys() -> None:
    time = np.arange(400.0)
    motion = np.stack([np.exp(-time / 200.0) * np.cos(time / 9.0), 0.01 * time], axis=1)
    one = LowPass("butterworth", order=2, cutoff=0.06, passes=2)
    inside = slice(round(one.reach), -round(one.reach))
    expected = filtfilt(*butter(2, 0.12), motion, axis=0)
    np.testing.assert_allclose(filtered(motion, one)[inside], expected[inside], atol=2e-3)


def test_what_a_filter_bends_of_a_small_swing_moves_no_estimate() -> None:
    """Each exponential of a linear swing is only scaled, which its initial state takes up; of a large one not all."""
    seen, moved = SeenFilter(("hip",), LowPass("butterworth", order=2, cutoff=0.06, passes=2), 0.005), []
    for share in (0.05, 1.0):
        small = recorded(TWO, share * AWAY, noise=1e-5, held_out=0, time=TIME)
        made = [replace(each, behind=seen) for each in recordings(TWO, small)]
        model = model_of(TWO, recordings=made)
        start = FitStart(weak_form_start(model, made, FREE).values, first_locals(made))
        moved.append(np.abs(bent_by_filter(model, made, refine(model, made, start, "noise", np.zeros(2)))).max())
    assert moved[0] < 0.2 * moved[1]
