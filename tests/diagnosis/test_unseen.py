"""Trials left out: their errors against refits, and the odds and verdicts that follow from them."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis.simulated_releases import NOISE, TWO, off, recorded, with_effects
from synth.diagnosis.angle_search import as_designed, fit_nominal
from synth.diagnosis.angle_trials import angle_trial
from synth.diagnosis.cause_intervals import causes_of
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.hypotheses import Assessment, Hypotheses, TrialErrors
from synth.diagnosis.left_out_fold import DIVERGED_ANGLE, DIVERGED_ERROR, bounded_residual, finite_residual
from synth.diagnosis.odds import CALIBRATED, far_share, posterior_weights, share_removed
from synth.diagnosis.plants.swinging_chain.chain_candidates import Candidate, candidates, natural_sizes_of
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import scene_of
from synth.diagnosis.prediction_error import PredictionErrors
from synth.diagnosis.remainder import Remainder
from synth.diagnosis.score import score
from synth.diagnosis.unseen import block_errors, errors_on_unseen_trials, folds, jackknife
from synth.diagnosis.verdict import hypotheses_that_pay, judge, with_coarse_counts, without_causes
from synth.estimation.intervals import NORMAL90
from synth.files.gap_project import Tolerance
from synth.fit.recordings import recordings

TRIALS = [angle_trial(recording, held_out=False) for recording in recordings(TWO, recorded(TWO), ())]
FOUND = candidates(TWO, TRIALS, natural_sizes_of(TWO, TRIALS))


def cause(effect: str, joint: str) -> Candidate:
    return next(candidate for candidate in FOUND if candidate.key == (effect, joint))


FRICTION, OFFSET = cause("coulomb_friction", "hip"), cause("encoder_offset", "knee")
DRAG, SCALE = cause("quadratic_damping", "knee"), cause("encoder_scale", "knee")


def held_out_error(*ratios: float, independent: float = 8.0) -> TrialErrors:
    """One RMS over the noise a trial."""
    squares = np.array(ratios)[:, None] ** 2
    return TrialErrors(squares, np.full(squares.shape, 100.0), np.full(len(ratios), independent))


def assessed(
    unseen: TrialErrors | None, *causes: Candidate, cost: float = 100.0, ratio: float | None = None
) -> Assessment:
    fit = EvaluatedHypothesis(tuple(causes), np.zeros(sum(c.size for c in causes)), ())
    return Assessment(fit, cost, ratio if ratio is not None else unseen.ratio if unseen else 1.0, unseen)


def with_fitted(item: Assessment, ratio: float) -> Assessment:
    """With errors of the fitted trials, the same RMS over the noise in each."""
    assert item.unseen is not None
    return replace(item, ratio=ratio, seen=held_out_error(*[ratio] * len(item.unseen.by_trial)))


@pytest.mark.parametrize("away", [3e5, np.inf])
def test_a_motion_that_runs_away_errs_alike_in_both_directions(away: float) -> None:
    """It counts as ``DIVERGED_ERROR``, so that the odds do not depend on the side on which a motion leaves."""
    trial = TRIALS[0]
    bench = scene_of(TWO, recorded(TWO), Tolerance(), 0)[0].bench
    bench = replace(bench, trials=(trial,))
    up, down = (block_errors(bench, 0, np.full(int(trial.counts.sum()), side * away)) for side in (1.0, -1.0))
    assert up[0] == pytest.approx(DIVERGED_ERROR**2)
    np.testing.assert_array_equal(down[0], up[0])
    np.testing.assert_array_equal(
        finite_residual(np.array([np.inf, -np.inf, np.nan, -3e5])),
        [DIVERGED_ERROR, -DIVERGED_ERROR, DIVERGED_ERROR, -3e5],
    )


def test_the_jackknife_of_means_is_the_standard_error() -> None:
    """Of five values' mean, but for Student's widening of so few: 2.132 for 1.645."""
    values = np.array([1.0, 2.0, 4.0, 7.0, 11.0])
    each = np.array([[np.delete(values, k).mean()] for k in range(5)])
    assert jackknife(each)[0] == pytest.approx(values.std(ddof=1) / np.sqrt(5) * 2.132 / 1.6449, rel=1e-3)


@pytest.mark.parametrize("second", [[0.1, 0.2], [0.13, 0.21]])
def test_folds_that_end_at_one_point_count_each(second: list[float]) -> None:
    """As two that end at a bound: alike ones counted once, and three alike were a bug's message."""

    def against_design(_: object, values: dict[str, float], tolerances: np.ndarray) -> dict[str, float]:
        return {name: value + 0.01 * float(tolerances[0]) for name, value in values.items()}

    by_fold = np.array([[0.1, 0.2], second, [0.1, 0.2]])
    errors = replace(held_out_error(1.0, 1.0, 1.0), by_fold=by_fold, refitted=by_fold)
    fit = EvaluatedHypothesis((OFFSET,), np.array([0.1, 0.2]), ())
    plant: Any = SimpleNamespace(n_tolerance=1, covariance=lambda _: 1e-12 * np.eye(2), against_design=against_design)
    (found,) = causes_of(plant, Assessment(fit, 0.0, 1.0, errors))
    (told,) = [each for each in found.parameters.values() if each.low is not None]
    assert told.low is not None
    assert told.high is not None
    one = next(iter(OFFSET.named(np.ones(1)).values())) - next(iter(OFFSET.named(np.zeros(1)).values()))
    wanted = max(1e-6, jackknife(by_fold @ np.array([[0.01 / one], [1.0]]))[0], jackknife(by_fold)[1])
    assert (told.high - told.low) / (2.0 * NORMAL90 * one) == pytest.approx(wanted, rel=0.01)


def test_left_out_errors_equal_a_refit_without_the_fold() -> None:
    built = with_effects(off(TWO, 3), {"knee": {"coulomb_friction": {"torque": 0.05}}})
    scene, _ = scene_of(TWO, recorded(built, held_out=0), Tolerance(), 0)
    bench = scene.bench
    nominal = fit_nominal(bench, as_designed(bench))
    (found,) = errors_on_unseen_trials(bench, [nominal])
    assert [len(fold) for fold in folds(bench)] == [1, 1, 1, 1]
    for out, trial in enumerate(bench.trials):
        rest = replace(bench, trials=tuple(t for i, t in enumerate(bench.trials) if i != out))
        again = fit_nominal(rest, as_designed(rest))
        ((prediction, _),) = score(bench, again, [trial])
        direct = np.sqrt(np.mean(((prediction - trial.measured) / scene.usual)[trial.counts] ** 2))
        assert np.sqrt(found.by_trial[out]) == pytest.approx(direct, rel=0.05)
        np.testing.assert_allclose(found.refitted[out], again.unknowns, atol=0.1)  # tolerances
    assert sorted(found.by_fold.tolist()) == sorted(found.refitted.tolist())  # each fold is one trial


def test_at_the_noise_floor_odds_come_from_the_fits() -> None:
    plain = [
        assessed(None, ratio=5.0, cost=300.0),
        assessed(None, FRICTION, cost=100.0),
        assessed(None, DRAG, cost=105),
    ]
    known = [
        replace(item, unseen=held_out_error(*[ratio] * 4)) for item, ratio in zip(plain, (5.0, 1.0, 1.5), strict=True)
    ]
    assert far_share(known) == 0.0
    assert posterior_weights(known, CALIBRATED) == pytest.approx(posterior_weights(plain, CALIBRATED))


def test_far_above_the_noise_odds_come_from_the_errors_by_trial() -> None:
    """Where every trial differs alike the bootstrap adds nothing: the odds are (r1/r2)^(2 sum m / 2), m at most 20."""
    none = assessed(held_out_error(200, 200, 200), cost=900.0)
    worse = assessed(held_out_error(110, 110, 110), FRICTION, cost=100.0)  # the better of the two in sample, by far
    better = assessed(held_out_error(100, 100, 100), DRAG, cost=400.0)
    weights = posterior_weights([none, worse, better], CALIBRATED)
    assert weights[2] / weights[1] == pytest.approx((110 / 100) ** 20, rel=1e-3)
    judged = judge(Hypotheses(none, (worse, better), ()), CALIBRATED)
    assert judged.accepted.keys == (("quadratic_damping", "knee"),)


def test_the_initial_states_of_an_added_link_cost_what_unknowns_of_one_trial_do() -> None:
    """Two a link and trial, at 20/3 independent errors each. Where errors are alike, the odds are the penalties'."""
    flexible = cause("link_flexibility", "knee")
    assert (flexible.size, flexible.links, DRAG.links) == (1, 1, 0)
    none = assessed(held_out_error(200, 200, 200))
    alike = [assessed(held_out_error(100, 100, 100), each) for each in (flexible, DRAG)]
    weights = posterior_weights([none, *alike], CALIBRATED)
    a_state = CALIBRATED.per_state_far * np.log(1.0 + 20.0 / 3.0)
    more = CALIBRATED.per_unknown_far * (DRAG.size - 1) - a_state * 2 * 3
    assert weights[1] / weights[2] == pytest.approx(np.exp(more), rel=1e-3)


def test_states_of_many_short_pieces_cost_no_more_than_their_errors_tell() -> None:
    """Ninety-nine pieces share twenty independent errors: they cannot charge an added link with hundreds."""
    flexible, count = cause("link_flexibility", "knee"), 99
    none = assessed(held_out_error(*[200] * count))
    half = [assessed(held_out_error(*[left] * count), each) for left, each in ((50, flexible), (100, DRAG))]
    weights = posterior_weights([none, *half], CALIBRATED)
    charged = CALIBRATED.per_state_far * 2 * count * np.log(1.0 + 20.0 / count)
    more = CALIBRATED.per_unknown_far * (DRAG.size - 1) - charged + 10.0 * np.log((1 + 100**2) / (1 + 50**2))
    assert weights[1] / weights[2] == pytest.approx(np.exp(more), rel=1e-3)
    assert charged < 20.0


@pytest.mark.parametrize(("left", "first"), [(50.06, "simple"), (53.0, "rich")])
def test_the_simpler_of_two_that_the_draws_do_not_separate_comes_first(left: float, first: str) -> None:
    """The rich one is ahead by less, and by more, than the standard error of 400 draws."""
    priced = np.exp(CALIBRATED.per_unknown_far * (DRAG.size - OFFSET.size) / 20.0)
    none = assessed(held_out_error(200, 200, 200))
    rich, simple = assessed(held_out_error(*[50.0 / priced] * 3), DRAG), assessed(held_out_error(*[left] * 3), OFFSET)
    weights = posterior_weights([none, rich, simple], CALIBRATED)
    assert weights[1] > weights[2]
    assert bool(weights[1] - weights[2] < 0.025) is (first == "simple")
    judged = judge(Hypotheses(none, (rich, simple), ()), CALIBRATED)
    assert judged.accepted is {"rich": rich, "simple": simple}[first]


@pytest.mark.parametrize(("floors", "factor"), [(1.0, 0.0), (100.0, 1.0)])
def test_an_unusual_shape_costs_odds_far_from_the_noise(floors: float, factor: float) -> None:
    """By its prior, as the cost of a fit already has it near the noise; a strength may have any size."""
    none = assessed(held_out_error(*[2.0 * floors] * 3), cost=900.0)
    usual = assessed(held_out_error(*[floors] * 3), DRAG, cost=100.0)
    assert (DRAG.shape.free, DRAG.effect.strengths) == (("coefficient", "exponent"), ("coefficient",))

    def with_shape(coefficient: float, exponent: float) -> Assessment:
        unknowns = np.array([coefficient, exponent])
        return replace(usual, fit=replace(usual.fit, unknowns=unknowns))

    weights = posterior_weights([none, usual, with_shape(30.0, 0.0), with_shape(0.0, 3.0)], CALIBRATED)
    assert weights[2] == pytest.approx(weights[1])
    assert weights[3] / weights[1] == pytest.approx(np.exp(-factor * 0.5 * 3.0**2), rel=1e-3)


def test_an_explanation_that_predicts_no_trial_left_out_of_its_fit_is_not_accepted() -> None:
    """However well it follows the trials that it was fitted to."""
    none = with_fitted(assessed(held_out_error(200, 200, 200), cost=900.0), 200.0)
    for left, verdict in ((60.0, "effect"), (199.0, "unknown")):
        found = with_fitted(assessed(held_out_error(left, left, left), FRICTION), 50.0)
        assert judge(Hypotheses(none, (found,), ()), CALIBRATED).verdict == verdict


def test_fitted_trials_and_the_same_left_out_count_alike() -> None:
    """The mean of both log-likelihoods; the penalty of an unknown cancels."""
    none = with_fitted(assessed(held_out_error(200, 200, 200), cost=900.0), 200.0)
    first = with_fitted(assessed(held_out_error(90, 90, 90), FRICTION), 50.0)
    second = with_fitted(assessed(held_out_error(60, 60, 60), DRAG), 55.0)
    assert FRICTION.size == DRAG.size
    weights = posterior_weights([none, first, second], CALIBRATED)
    assert weights[1] / weights[2] == pytest.approx((55 / 50 * 60 / 90) ** 10, rel=1e-2)


def test_a_cause_that_was_not_left_out_loses_there_what_the_others_do() -> None:
    """Its odds against another then are those of the fitted trials."""
    none = with_fitted(assessed(held_out_error(260, 260, 260), cost=900.0), 200.0)
    known = with_fitted(assessed(held_out_error(65, 65, 65), FRICTION), 50.0)
    unknown = replace(with_fitted(assessed(held_out_error(55, 55, 55), DRAG), 55.0), unseen=None)
    weights = posterior_weights([none, known, unknown], CALIBRATED)
    assert weights[1] / weights[2] == pytest.approx((55 / 50) ** 20, rel=1e-2)


def test_a_cause_must_remove_most_of_the_gap_or_an_unknown_one_is_more_probable() -> None:
    """Even odds at the stated share, before the least doubt: of four trials 1/10."""
    none = with_fitted(assessed(held_out_error(*[1000] * 4)), 1000.0)
    verdicts = []
    for left in (1000 * (1.0 - CALIBRATED.most), 200.0, 700.0):
        found = with_fitted(assessed(held_out_error(*[left] * 4), FRICTION), left)
        verdicts.append(judge(Hypotheses(none, (found,), ()), CALIBRATED, motion=5000.0))
    expected = 1.0 - (1.0 - 0.5 * CALIBRATED.most_unknown) * (1.0 - 1.0 / 10.0)
    assert verdicts[0].unknown == pytest.approx(expected, abs=0.01)
    assert [judged.verdict for judged in verdicts[1:]] == ["effect", "unknown"]


@pytest.mark.parametrize(("motion", "verdict"), [(10_000.0, "unknown"), (200_000.0, "none"), (np.inf, "none")])
def test_a_gap_that_nothing_explains_is_unknown_if_it_exceeds_a_models_accuracy(motion: float, verdict: str) -> None:
    """Five per cent of the motion, a quarter of a per cent, and where no motion is known."""
    none = with_fitted(assessed(held_out_error(*[500] * 4)), 500.0)
    little = with_fitted(assessed(held_out_error(*[490] * 4), FRICTION), 490.0)
    assert judge(Hypotheses(none, (little,), ()), CALIBRATED, motion=motion).verdict == verdict


def test_beside_an_unknown_cause_nothing_missing_is_as_probable_as_the_gap_allows() -> None:
    """A gap of five times a model's accuracy; where nothing is known to help, all the rest is the unknown cause's."""
    none = with_fitted(assessed(held_out_error(*[500] * 4)), 500.0)
    little = with_fitted(assessed(held_out_error(*[490] * 4), FRICTION), 490.0)
    judged = judge(Hypotheses(none, (little,), ()), CALIBRATED, motion=500.0 / (5.0 * CALIBRATED.accuracy))
    assert judged.none == pytest.approx(1.0 / (1.0 + 5.0**CALIBRATED.accuracy_steep), rel=0.01)
    assert sum(p for _, p in judged.singles) + judged.none + judged.unknown == pytest.approx(1.0)


@pytest.mark.parametrize(("share", "verdict"), [(0.1, "unknown"), (2.0, "none")])
def test_a_stated_accuracy_decides_which_gap_may_be_a_models_own_error(share: float, verdict: str) -> None:
    """A gap of 500 floors, of which the project allows a tenth, or twice as much."""
    scene, _ = scene_of(TWO, recorded(TWO), Tolerance(), 0)
    noise = float(np.sqrt(np.mean(scene.usual**2)))
    stated = replace(scene, accuracy=share * 500.0 * noise)
    none = with_fitted(assessed(held_out_error(*[500] * 4)), 500.0)
    little = with_fitted(assessed(held_out_error(*[490] * 4), FRICTION), 490.0)
    motion = stated.motion_trusted(CALIBRATED.accuracy)
    assert judge(Hypotheses(none, (little,), ()), CALIBRATED, motion=motion).verdict == verdict
    assert scene.motion_trusted(CALIBRATED.accuracy) == scene.motion


def test_pairs_that_differ_in_their_small_cause_give_the_common_cause() -> None:
    none = with_fitted(assessed(held_out_error(*[1000] * 4)), 1000.0)
    alone = with_fitted(assessed(held_out_error(*[250] * 4), FRICTION), 250.0)
    pairs = tuple(with_fitted(assessed(held_out_error(*[100] * 4), FRICTION, item), 100.0) for item in (OFFSET, SCALE))
    judged = judge(Hypotheses(none, (alone,), pairs), CALIBRATED, motion=5000.0)
    assert (judged.verdict, judged.accepted.keys, judged.tied) == ("effect", alone.keys, ())
    weak = with_fitted(assessed(held_out_error(*[600] * 4), FRICTION), 600.0)
    assert judge(Hypotheses(none, (weak,), pairs), CALIBRATED, motion=5000.0).verdict == "tie"


def test_a_difference_due_to_one_trial_is_not_certain() -> None:
    none = assessed(held_out_error(200, 200, 200, 200))
    steady = assessed(held_out_error(60, 60, 60, 60), FRICTION)
    leading = assessed(held_out_error(12, 63, 63, 63), DRAG)
    weights = posterior_weights([none, steady, leading], CALIBRATED)
    alike = posterior_weights([none, steady, assessed(held_out_error(*[leading.unseen.typical] * 4), DRAG)], CALIBRATED)  # type: ignore[union-attr]
    assert 0.02 < weights[1] / weights[2] < 0.5
    assert alike[1] / alike[2] < 0.1 * weights[1] / weights[2]


def test_the_verdict_is_none_when_causes_help_less_than_trials_differ() -> None:
    """However far above the noise: a remainder of 250 to 900 floors, of which the best cause takes 15 %."""
    none = assessed(held_out_error(300, 1000, 500, 700))
    little = assessed(held_out_error(255, 850, 425, 595), FRICTION)
    judged = judge(Hypotheses(none, (little,), ()), CALIBRATED)
    assert judged.verdict == "none"
    steady = judge(
        Hypotheses(assessed(held_out_error(*[600] * 4)), (assessed(held_out_error(*[150] * 4), FRICTION),), ()),
        CALIBRATED,
    )
    assert steady.verdict == "effect"


def test_the_verdict_is_unknown_when_only_a_free_torque_helps() -> None:
    none = assessed(held_out_error(*[500] * 4))
    some = assessed(held_out_error(*[430] * 4), FRICTION)
    found = Hypotheses(none, (some,), ())
    assert judge(found, CALIBRATED, free=held_out_error(*[100] * 4)).verdict == "unknown"
    assert judge(found, CALIBRATED, free=held_out_error(*[100] * 4)).accepted.keys == (("coulomb_friction", "hip"),)
    assert judge(Hypotheses(none, (), ()), CALIBRATED, free=held_out_error(*[480] * 4)).verdict == "none"
    assert judge(Hypotheses(none, (), ()), CALIBRATED, free=held_out_error(*[100] * 4)).verdict == "unknown"


def test_an_additional_cause_must_remove_a_tenth_on_left_out_trials() -> None:
    none, single = assessed(held_out_error(*[100] * 3)), assessed(held_out_error(*[50] * 3), FRICTION)
    tenth = replace(assessed(held_out_error(*[39] * 3), FRICTION, OFFSET), ratio=20.0)
    less = replace(tenth, unseen=held_out_error(*[41] * 3))
    assert hypotheses_that_pay([none, single, tenth], CALIBRATED) == [none, single, tenth]
    assert hypotheses_that_pay([none, single, less], CALIBRATED) == [none, single]
    assert hypotheses_that_pay([none, single, replace(tenth, unseen=None)], CALIBRATED) == [none, single]


@pytest.mark.parametrize("floors", [100.0, 1.0])
def test_a_pair_replaces_a_third_cause_that_imitates_both(floors: float) -> None:
    """Each of the pair takes much beside the other, and what the third leaves is less than a tenth of the gap.

    A torque a third too large and a shifted reading are nearly a scaled reading on one joint (a dirty rig).
    """
    none = assessed(held_out_error(*[20.0 * floors] * 3))
    imitates = assessed(held_out_error(*[2.4 * floors] * 3), SCALE)
    parts = [assessed(held_out_error(*[left * floors] * 3), each) for left, each in ((12.0, FRICTION), (8.0, OFFSET))]
    pair = assessed(held_out_error(*[1.0 * floors] * 3), FRICTION, OFFSET)
    little = replace(parts[1], unseen=held_out_error(*[1.9 * floors] * 3), ratio=1.9 * floors)
    assert pair in hypotheses_that_pay([none, imitates, *parts, pair], CALIBRATED)
    assert pair not in hypotheses_that_pay([none, imitates, parts[0], little, pair], CALIBRATED)


def test_a_cause_with_initial_states_of_its_own_is_not_simpler_than_two_without() -> None:
    """It has two in each of three trials, the pair three numbers; near the noise the evidence has them all."""
    flexible = cause("link_flexibility", "knee")
    for floors, pays in ((100.0, True), (1.5, False)):
        none = assessed(held_out_error(*[10.0 * floors] * 3))
        single = assessed(held_out_error(*[5.0 * floors] * 3), FRICTION)
        follows = assessed(held_out_error(*[floors] * 3), flexible)
        pair = assessed(held_out_error(*[floors] * 3), FRICTION, OFFSET)
        assert (pair in hypotheses_that_pay([none, single, follows, pair], CALIBRATED)) is pays
        assert pair in hypotheses_that_pay([none, single, pair], CALIBRATED)


def test_at_the_noise_an_additional_cause_pays_by_the_fitted_trials() -> None:
    """The fold that is the only trial of its kind is missed by an explanation whose unknowns only it determines."""
    none = replace(assessed(held_out_error(14, 1.4, 1.4)), ratio=9.0)
    single = replace(assessed(held_out_error(3, 1, 0.9), FRICTION), ratio=2.0)
    pair = replace(assessed(held_out_error(30, 0.9, 0.9), FRICTION, OFFSET), ratio=1.0)
    assert hypotheses_that_pay([none, single, pair], CALIBRATED) == [none, single, pair]
    assert hypotheses_that_pay([none, single, replace(pair, ratio=1.9)], CALIBRATED) == [none, single]


def test_one_outlying_trial_does_not_decide_the_share_removed() -> None:
    none, found = assessed(held_out_error(100, 100, 100, 100)), assessed(held_out_error(20, 20, 20, 300), FRICTION)
    assert share_removed(found, none) == pytest.approx(1.0 - (0.2**3 * 3.0) ** 0.25, abs=1e-3)


def test_a_gap_below_the_requested_accuracy_gives_none() -> None:
    none, single = assessed(held_out_error(*[100] * 3)), assessed(held_out_error(*[10] * 3), FRICTION)
    judged = without_causes(judge(Hypotheses(none, (single,), ()), CALIBRATED), none)
    assert (judged.verdict, judged.accepted, judged.none) == ("none", none, 1.0)
    counted = without_causes(with_coarse_counts(judge(Hypotheses(none, (single,), ()), CALIBRATED), coarse=True), none)
    assert (counted.counts, counted.none, counted.probability) == (0.0, 1.0, 0.0)


def test_the_remainder_is_the_error_above_the_noise() -> None:
    counts = np.full((2, 4), 50.0)
    squares = {"before": counts * 26.0 * NOISE**2, "after": counts * 5.0 * NOISE**2}
    errors = PredictionErrors(squares, counts, counts * NOISE**2, 0)
    found = Remainder.of(errors, "after", {"hip": 0.2, "knee": 0.8}, {"release": 0.4, "swing": 0.6})
    assert found.rms.value == pytest.approx(2.0 * NOISE)
    assert found.share == pytest.approx(0.4)
    assert found.times_noise == pytest.approx(2.0)
    assert found.place() == "at the knee while it swings"
    assert set(found.as_json()) == {"rms", "share", "times_noise", "where"}


def test_a_remainder_larger_than_the_gap_is_said() -> None:
    counts = np.full((2, 4), 50.0)
    squares = {"before": counts * 5.0 * NOISE**2, "after": counts * 10.0 * NOISE**2}
    errors = PredictionErrors(squares, counts, counts * NOISE**2, 0)
    assert Remainder.of(errors, "after", {}, {}).share == pytest.approx(1.5)
    none = replace(errors, squares={**squares, "before": counts * 1.04 * NOISE**2})  # no gap to speak of
    assert Remainder.of(none, "after", {}, {}).share == 1.0


def test_errors_of_less_than_half_a_radian_are_told_apart_whatever_the_noise() -> None:
    """A filter had left 8e-6 deg of noise: errors of 0.08 deg and of 20 deg counted alike, and every cause was tied."""
    noise = np.full(4, np.radians(8e-6))
    errors = np.radians([0.2, 20.0, 40.0, np.inf])
    found = bounded_residual(errors / noise, noise) * noise
    np.testing.assert_allclose(found, [np.radians(0.2), np.radians(20.0), DIVERGED_ANGLE, DIVERGED_ANGLE])
    coarse = np.full(2, np.radians(0.1))
    np.testing.assert_allclose(bounded_residual(np.array([1e5, np.nan]), coarse), DIVERGED_ERROR)
