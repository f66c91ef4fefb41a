"""A hand that still drives the leg after the release: detected, cut and reported. A free release is kept whole."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fit.simulated_legs import Rig, bare, recorded, releases, robot
from robustness.random_legs import random_case
from synth.fit.estimate import fit_leg
from synth.fit.fit_options import LegFitOptions
from synth.fit.free_motion_start import Seen, later, look, same_leg
from synth.fit.recordings import recordings
from synth.fit.ridge import SOFTEST
from synth.validation.thesis_data import read_lab_data

LAB = Path(__file__).resolve().parents[3] / "shared" / "aarl"
FREE = LegFitOptions(release="free")


def test_the_probability_of_a_difference_is_uniform_where_there_is_none() -> None:
    """An efficient estimate, and one from part of the samples: their difference has the difference of covariances."""
    generator, found = np.random.default_rng(1), []
    root, extra = generator.normal(size=(4, 4)), generator.normal(size=(4, 4))
    whole = root @ root.T
    part = whole + extra @ extra.T
    for _ in range(400):
        values = np.linalg.cholesky(whole) @ generator.normal(size=4)
        more = values + np.linalg.cholesky(part - whole) @ generator.normal(size=4)
        found.append(same_leg(values, whole, more, part))
    for quantile in (0.1, 0.5, 0.9):
        assert np.mean(np.array(found) < quantile) == pytest.approx(quantile, abs=0.07)
    assert same_leg(values, whole, values + 20.0, part) < 1e-6
    assert same_leg(values, whole, values + 20.0, whole) == 1.0  # a part that knows as much says nothing


@pytest.mark.parametrize("seed", [5001, 5004])
def test_a_hand_driven_start_is_cut_and_the_rates_are_recovered(seed: int) -> None:
    drawn = random_case(seed).recorder
    case = random_case(seed, replace(drawn, driven=0.15, trials=3))
    made = recordings(case.bare, case.trials)
    result = fit_leg(case.bare, made, FREE)
    assert 0.1 < result.cut < 0.35
    assert result.warnings[0].startswith("release: ")
    driven = fit_leg(case.bare, made)
    truth = np.log(case.leg.spring_rate)
    off = [np.log([j.spring_rate.value for j in fit.joints.values()]) - truth for fit in (result, driven)]
    assert np.abs(off[0]).max() < 0.5 * np.abs(off[1]).max()


def test_a_hand_that_no_recording_shows_is_cut_where_its_fading_end_no_longer_counts() -> None:
    """Leg 1416 of the study, driven for 0.15 s: samples from 0.1 s on agree with later ones but are still biased."""
    case = random_case(1416)
    made = recordings(case.bare, case.trials)
    assert look(case.bare, made).known == []
    result = fit_leg(case.bare, made, FREE)
    assert result.cut == pytest.approx(0.15)
    assert "do not fit one leg" in result.warnings[0]
    name, joint = next(iter(result.joints.items()))
    truth = case.leg.joints[case.leg.joint_names.index(name)]
    assert truth.spring is not None
    assert truth.damper is not None
    assert joint.damper_rate is not None
    assert joint.spring_rate.low <= truth.spring.rate <= joint.spring_rate.high
    assert joint.damper_rate.low <= truth.damper.rate <= joint.damper_rate.high


def test_a_free_leg_is_fitted_from_its_first_sample() -> None:
    leg = robot()
    made = recorded(leg, releases(leg, 3))
    result = fit_leg(bare(leg), made, FREE)
    assert result.cut == 0.0
    assert result.joints == fit_leg(bare(leg), made).joints


def test_later_samples_form_a_new_recording() -> None:
    leg = robot()
    (one, *_) = recorded(leg, releases(leg, 3, Rig()))
    cut = later([one], 0.2)
    assert cut is not None
    assert cut[0].time[0] == 0.0
    assert cut[0].time[-1] == pytest.approx(one.time[-1] - 0.2, abs=2 * (one.time[1] - one.time[0]))
    assert np.array_equal(cut[0].rotation[-1], one.rotation[-1])
    assert later([one], one.time[-1] - 0.05) is None
    assert not Seen((None, None, 0.1)).plain
    assert Seen((0.1, None)).plain


@pytest.mark.skipif(not LAB.is_dir(), reason="the lab's recordings (../shared/aarl) are not here")
def test_the_rats_releases_have_a_driven_start_and_the_rest_is_fitted() -> None:
    """Muscles act for the first 0.1 s and more; plain RMS and starts of what is fitted agree with the recordings."""
    data = read_lab_data(LAB)
    made = data.releases()
    assert look(data.rat, made).plain
    result = fit_leg(data.rat, made, replace(FREE, free_angle="per_trial"))
    assert 0.05 < result.cut < 0.2
    assert np.degrees(list(result.rms.values())) == pytest.approx([0.15, 0.21, 0.41], abs=0.1)
    off = np.degrees([trial.start.angle - trial.start.recorded.angle for trial in result.trials])
    assert np.abs(off).max() < 1.5
    rates = np.degrees([trial.start.rate - trial.start.recorded.rate for trial in result.trials])
    assert np.mean(np.abs(rates) < 60.0) > 0.85
    # a joint moved along its ridge is described by the values that the result has
    moved = {text.split(":")[0]: text for text in result.not_separable if SOFTEST in text}
    assert "hip" in moved
    for name, text in moved.items():
        found = result.joints[name]
        assert found.damper_rate is not None
        stated = f"{found.spring_rate.value:.3g} N*m/rad and {found.damper_rate.value:.3g} N*m*s/rad"
        assert f"{SOFTEST}: {stated}" in text
