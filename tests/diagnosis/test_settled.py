"""Fits that are reported end at their optimum, whichever way they came."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.simulated_releases import TWO, off, recorded
from synth.diagnosis.angle_search import as_designed, rms_over_noise
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.hypotheses import Assessment, Hypotheses
from synth.diagnosis.odds import CALIBRATED
from synth.diagnosis.plants.swinging_chain.chain_candidates import candidates, natural_sizes_of
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import scene_of
from synth.diagnosis.restarts import refine
from synth.diagnosis.settled import LARGEST_FALL_LEFT, settle_fits, settle_leading
from synth.diagnosis.unseen import errors_on_unseen_trials, with_unseen_errors
from synth.diagnosis.workbench import Workbench
from synth.files.gap_project import Tolerance

NOISE = np.radians(0.05)
START = 1.5  # whitened unknowns on either side


def two_fits() -> tuple[Workbench, EvaluatedHypothesis, list[EvaluatedHypothesis]]:
    """A shifted spring of the hip, which tolerances imitate, fitted from either side as the search fits."""
    scene, _ = scene_of(TWO, recorded(off(TWO, 2), noise=NOISE), Tolerance(), 0)
    bench, designed = scene.bench, as_designed(scene.bench)
    every = candidates(TWO, scene.given, natural_sizes_of(TWO, scene.given))
    shift = next(each for each in every if each.key == ("spring_preload", "hip"))
    starts = [
        EvaluatedHypothesis((shift,), np.append(np.zeros(bench.n_tolerance), side), designed.states)
        for side in (-START, START)
    ]
    return bench, designed, refine(bench, bench.evaluate(starts))


def test_fits_from_either_side_end_at_one_point() -> None:
    bench, _, fits = two_fits()
    ends = settle_fits(bench, fits)
    deviation = float(np.sqrt(np.diag(bench.normal(ends[0]).covariance(1.0)))[-1])
    apart, left = (abs(float(a.unknowns[-1] - b.unknowns[-1])) for a, b in (fits, ends))
    assert apart > 0.3 * deviation  # a valley: the search stops on its way
    assert left < 0.1 * deviation
    assert ends[0].cost == pytest.approx(ends[1].cost, abs=LARGEST_FALL_LEFT)
    assert all(end.cost <= fit.cost for end, fit in zip(ends, fits, strict=True))


def test_a_fit_at_its_optimum_stays() -> None:
    bench, _, fits = two_fits()
    once = settle_fits(bench, fits)
    for first, again in zip(once, settle_fits(bench, once), strict=True):
        assert again.cost == pytest.approx(first.cost, abs=LARGEST_FALL_LEFT)
        np.testing.assert_allclose(again.unknowns, first.unknowns, atol=0.05)


def test_the_hypotheses_in_the_answer_are_settled_once() -> None:
    """The nominal leg and the leading cause; their costs and ratios are those of the new fits."""
    bench, designed, (first, _) = two_fits()

    def assessed(fit: EvaluatedHypothesis) -> Assessment[EvaluatedHypothesis]:
        return Assessment(fit, fit.cost, rms_over_noise(bench, fit))

    found = Hypotheses(assessed(designed), (assessed(replace(first, cost=first.cost)),), ())
    made, done = settle_leading(bench, found, CALIBRATED)
    assert made.none.cost < designed.cost - LARGEST_FALL_LEFT
    for item in (made.none, *made.singles):
        assert item.cost == item.fit.cost
        assert item.ratio == pytest.approx(rms_over_noise(bench, item.fit))
        assert any(item.fit is fit for fit in done)
    again, still = settle_leading(bench, made, CALIBRATED, done)
    assert again.none is made.none
    assert len(still) == len(done)


def test_what_leads_is_tested_on_unseen_trials() -> None:
    """A cause that no unseen trial had tested was "unknown" at 0.5 for that alone."""
    bench, designed, (first, _) = two_fits()
    none, single = (Assessment(fit, fit.cost, rms_over_noise(bench, fit)) for fit in (designed, first))
    untested, _ = settle_leading(bench, Hypotheses(none, (single,), ()), CALIBRATED)
    assert untested.singles[0].unseen is None  # nor is the nominal leg: it would have nothing to compare with
    tested = with_unseen_errors(bench, untested, CALIBRATED)
    cut = replace(tested, singles=(replace(tested.singles[0], unseen=None),))
    made, _ = settle_leading(bench, cut, CALIBRATED)
    assert made.singles[0].unseen is not None
    (expected,) = errors_on_unseen_trials(bench, [made.singles[0].fit])
    np.testing.assert_allclose(made.singles[0].unseen.by_trial, expected.by_trial, rtol=0.05)
