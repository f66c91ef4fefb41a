"""Leading hypotheses are compared beside the same small causes; what is large beside them is not handed to one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.simulated_releases import TWO, recorded, with_effects
from synth.diagnosis.angle_search import as_designed, fit_nominal, rms_over_noise
from synth.diagnosis.angle_trials import angle_trial
from synth.diagnosis.companions import with_companions
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.hypotheses import Assessment, Hypotheses, TrialErrors
from synth.diagnosis.odds import (
    CALIBRATED,
    LEAST_FURTHER_SHARE,
    adds_little,
    posterior_weights,
    posterior_weights_beside,
)
from synth.diagnosis.plants.swinging_chain.chain_candidates import Candidate, candidates, natural_sizes_of
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import EFFECTIVE_SAMPLES
from synth.diagnosis.plants.swinging_chain.chain_predictor import Predictor
from synth.diagnosis.restarts import refine
from synth.diagnosis.unknown_cause import probability_of_unknown
from synth.diagnosis.unseen import errors_by_trial
from synth.diagnosis.workbench import Workbench
from synth.files.gap_project import Tolerance
from synth.fit.recordings import recordings
from synth.swing.leg_model import Spring
from synth.swing.tolerances import Tolerances

TRIALS = [angle_trial(recording, held_out=False) for recording in recordings(TWO, recorded(TWO), ())]
FOUND = candidates(TWO, TRIALS, natural_sizes_of(TWO, TRIALS))
NOISE = np.radians(0.002)


def cause(effect: str, joint: str) -> Candidate:
    return next(candidate for candidate in FOUND if candidate.key == (effect, joint))


SOFT, SCALE = cause("spring_rate", "hip"), cause("encoder_scale", "hip")
SHIFT, TILT = cause("encoder_offset", "knee"), cause("base_tilt", "base")


def left(floors: list[float], *causes: Candidate) -> Assessment[EvaluatedHypothesis]:
    """A hypothesis that leaves so many noise floors in each trial, of the fit and unseen."""
    squares = np.array(floors)[:, None] ** 2
    errors = TrialErrors(squares, np.full((len(floors), 1), 100.0), np.full(len(floors), 50.0))
    rms = float(np.sqrt(np.mean(squares)))
    fit = EvaluatedHypothesis(tuple(causes), np.zeros(sum(c.size for c in causes)), ())
    return Assessment(fit, 1000.0 * np.log(rms), rms, errors, errors)


NONE = left([800.0, 700.0, 600.0, 500.0])
# Alone the scale leaves less in three trials of four: only the first shows the small cause.
ALONE = left([120.0, 50.0, 50.0, 50.0], SOFT), left([130.0, 25.0, 25.0, 25.0], SCALE)
WITH_SMALL = left([20.0, 12.0, 12.0, 12.0], SOFT, SHIFT), left([125.0, 25.0, 25.0, 25.0], SCALE, SHIFT)


def test_a_small_cause_does_not_decide_between_large_ones() -> None:
    hypotheses, fitted = [NONE, *ALONE], [NONE, *ALONE, *WITH_SMALL]
    alone = posterior_weights(hypotheses, CALIBRATED)
    beside = posterior_weights_beside(hypotheses, fitted, {SHIFT.key}, CALIBRATED)
    assert alone[2] > 5.0 * alone[1]
    assert beside[1] > 5.0 * beside[2]


def test_small_causes_do_not_show_that_there_is_a_large_one() -> None:
    hypotheses = [NONE, left([780.0, 650.0, 560.0, 470.0], SOFT)]
    fitted = [*hypotheses, left([700.0, 600.0, 500.0, 400.0], SOFT, SHIFT)]
    assert (
        posterior_weights_beside(hypotheses, fitted, {SHIFT.key}, CALIBRATED)[0]
        == posterior_weights(hypotheses, CALIBRATED)[0]
    )


def test_what_a_further_large_cause_removes_is_not_the_merit_of_the_first() -> None:
    """If the two pay together, they are a hypothesis of their own; and no cause is small that takes a fifth."""
    pair = left([20.0, 15.0, 15.0, 15.0], SOFT, SHIFT)
    hypotheses = [NONE, *ALONE, pair]
    fitted = [*hypotheses, left([10.0, 10.0, 10.0, 10.0], SOFT, SHIFT, TILT)]
    kept = posterior_weights_beside(hypotheses, fitted, {SHIFT.key, TILT.key}, CALIBRATED)
    assert kept[1] < 0.01 * kept[3]
    large = left([20.0, 15.0, 15.0, 15.0], SCALE, TILT)
    assert not adds_little(large, left([200.0, 190.0, 190.0, 190.0], SCALE), NONE)
    just = NONE.ratio * (0.3 - 0.99 * LEAST_FURTHER_SHARE)
    assert adds_little(left([just] * 4, SCALE, TILT), left([0.3 * NONE.ratio] * 4, SCALE), NONE)


def test_three_causes_of_one_spring_are_a_curve_and_unknown() -> None:
    """They describe whatever torque depends on the angle there; of two joints they are three causes."""
    spring = [cause(name, "hip") for name in ("spring_preload", "one_sided_spring", "hardening_spring")]
    none, alone = left([800.0] * 4), left([500.0] * 4, spring[0])
    curve = left([40.0] * 4, *spring)
    elsewhere = left([40.0] * 4, spring[0], spring[1], cause("hardening_spring", "knee"))
    unknown = [probability_of_unknown([none, alone, best], best, 1.0, None, CALIBRATED) for best in (curve, elsewhere)]
    assert unknown[0] > 0.7
    assert unknown[1] < 0.3


@pytest.mark.parametrize("against", [0, 1, 3])
def test_windows_that_contradict_an_explanation_leave_doubt(against: int) -> None:
    """Jeffreys' (against + 1/2) / (windows + 1); windows near the typical remainder tell nothing."""
    quiet, without, with_it = [1.0] * 3, [100.0] * 12, [30.0] * (12 - against) + [200.0] * against
    none, best = left([*quiet, *without]), left([*quiet[:2], 1.5, *with_it], SOFT)
    surely = replace(CALIBRATED, most_unknown=0.0)  # leaves the doubt alone
    assert probability_of_unknown([none, best], best, 1.0, None, surely) == pytest.approx((against + 0.5) / 13.0)


def test_each_leading_hypothesis_is_fitted_beside_the_same_small_cause() -> None:
    """A softer spring, a small shift of the knee's reading, and drag that no hypothesis has."""
    knee = {"encoder_offset": {"offset": 0.03}, "quadratic_damping": {"coefficient": 0.004}}
    built = with_effects(TWO.with_joints(hip={"spring": Spring(4.5, 0.5)}), {"knee": knee})
    made = recordings(TWO, recorded(built, noise=NOISE), ())
    trials = tuple(angle_trial(recording, held_out=False) for recording in made)
    tolerances = Tolerances.of(TWO, Tolerance())
    bench = Workbench(Predictor(TWO, tolerances), trials, np.full(2, NOISE), EFFECTIVE_SAMPLES)
    none = fit_nominal(bench, as_designed(bench))

    def fitted(*causes: Candidate) -> Assessment[EvaluatedHypothesis]:
        start = np.concatenate([none.unknowns, *(c.starts()[0] for c in causes)])
        fit = refine(bench, bench.evaluate([EvaluatedHypothesis(causes, start, none.states)]))[0] if causes else none
        errors = errors_by_trial(bench, fit.residuals)
        return Assessment(fit, fit.cost, rms_over_noise(bench, fit), errors, errors)

    singles = sorted((fitted(each) for each in (SOFT, SCALE)), key=lambda item: item.cost)
    found = Hypotheses(fitted(), tuple(singles), (fitted(SOFT, SHIFT),))
    beside = with_companions(bench, found, CALIBRATED)
    assert beside.small == (SHIFT.key,)
    by_keys = {frozenset(item.keys): item for item in beside.several}
    assert frozenset((SCALE.key, SHIFT.key)) in by_keys
    assert by_keys[frozenset((SCALE.key, SHIFT.key))].cost < next(s for s in singles if s.keys[0] == SCALE.key).cost
    assert beside.several[0].keys == (SOFT.key, SHIFT.key)
