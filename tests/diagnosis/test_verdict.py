"""From costs to a verdict: several causes against fewer, probabilities that sum to one, and unknown causes."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from diagnosis.simulated_releases import TWO, recorded
from synth.diagnosis import odds
from synth.diagnosis.angle_trials import angle_trial
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.hypotheses import Assessment, Hypotheses, TrialErrors
from synth.diagnosis.left_out_fold import DIVERGED_ERROR
from synth.diagnosis.odds import costs_against, in_order_of_odds, price_of_unknown
from synth.diagnosis.plants.swinging_chain.chain_candidates import Candidate, candidates, natural_sizes_of
from synth.diagnosis.unknown_cause import probability_of_unknown
from synth.diagnosis.verdict import (
    CALIBRATED,
    UNKNOWN_IF_CONTRADICTED,
    hypotheses_that_pay,
    judge,
    posterior_weights,
    with_doubt_of_held_out,
)
from synth.fit.recordings import recordings

TRIALS = [angle_trial(recording, held_out=False) for recording in recordings(TWO, recorded(TWO), ())]
FOUND = candidates(TWO, TRIALS, natural_sizes_of(TWO, TRIALS))


def cause(effect: str, joint: str) -> Candidate:
    return next(candidate for candidate in FOUND if candidate.key == (effect, joint))


FRICTION, OFFSET = cause("coulomb_friction", "hip"), cause("encoder_offset", "knee")
DRAG, SCALE = cause("quadratic_damping", "knee"), cause("encoder_scale", "knee")


def assessed(cost: float, ratio: float, *causes: Candidate) -> Assessment:
    return Assessment(EvaluatedHypothesis(tuple(causes), np.zeros(sum(c.size for c in causes)), ()), cost, ratio)


NONE = assessed(1000.0, 5.0)
SINGLES = (assessed(400.0, 2.5, FRICTION), assessed(500.0, 3.0, OFFSET), assessed(950.0, 4.8, DRAG))


def test_one_cause_that_leaves_only_noise_is_the_effect() -> None:
    judged = judge(Hypotheses(NONE, (assessed(100.0, 1.01, FRICTION), *SINGLES[1:]), ()), CALIBRATED)
    assert judged.verdict == "effect"
    assert judged.accepted.keys == (("coulomb_friction", "hip"),)
    assert judged.probability == pytest.approx(1.0 - CALIBRATED.doubt, abs=0.01)
    assert judged.unknown == pytest.approx(CALIBRATED.doubt)


def test_a_pair_of_certain_causes_is_accepted() -> None:
    judged = judge(Hypotheses(NONE, SINGLES, (assessed(100.0, 1.01, FRICTION, OFFSET),)), CALIBRATED)
    assert set(judged.accepted.keys) == {("coulomb_friction", "hip"), ("encoder_offset", "knee")}
    odds = {item.keys[0]: probability for item, probability in judged.singles}
    assert odds["coulomb_friction", "hip"] == pytest.approx(1.0 - CALIBRATED.doubt_of_several, abs=1e-3)
    assert odds["encoder_offset", "knee"] == pytest.approx(1.0 - CALIBRATED.doubt_of_several, abs=1e-3)
    assert odds["quadratic_damping", "knee"] < 1e-3


def test_a_second_cause_with_little_gain_is_not_accepted() -> None:
    """Even if it fits better: a slightly wrong form leaves a remainder that any other cause reduces."""
    little = assessed(300.0, 2.4, FRICTION, OFFSET)
    much = assessed(300.0, 1.8, FRICTION, OFFSET)
    assert hypotheses_that_pay([NONE, *SINGLES, little], CALIBRATED) == [NONE, *SINGLES]
    assert hypotheses_that_pay([NONE, *SINGLES, much], CALIBRATED) == [NONE, *SINGLES, much]
    assert len(judge(Hypotheses(NONE, SINGLES, (little,)), CALIBRATED).accepted.keys) == 1


def test_many_equal_causes_that_leave_much_are_unknown_and_few_are_tied() -> None:
    """Of twelve that explain equally, and a remainder that none explains, nothing is told."""
    alike = [assessed(400.0, 2.2, candidate) for candidate in FOUND[:12]]
    few = judge(Hypotheses(NONE, tuple(alike[:3]), ()), CALIBRATED)
    many = judge(Hypotheses(NONE, tuple(alike), ()), CALIBRATED)
    assert many.singles[0][1] < many.unknown < 0.5
    assert (few.verdict, len(few.tied)) == ("tie", 2)
    assert (many.verdict, many.tied) == ("unknown", ())
    near = [assessed(400.0, 1.0, candidate) for candidate in FOUND[:12]]
    assert judge(Hypotheses(NONE, tuple(near), ()), CALIBRATED).verdict == "tie"


def test_near_the_noise_initial_states_of_an_added_link_are_charged() -> None:
    """Of two causes with equal costs: ``per_state`` for the rotation and the rate in each of four trials."""
    base = next(c for c in FOUND if c.effect.name == "base_compliance" and c.size == 3)
    spring = next(c for c in FOUND if c.effect.name == "spring_hysteresis" and c.size == 3)
    at_noise = TrialErrors(np.full((4, 1), 1.1), np.full((4, 1), 200.0), np.full(4, 20.0))
    none, sways, slips = (
        replace(item, seen=at_noise, unseen=at_noise)
        for item in (NONE, assessed(400.0, 1.1, base), assessed(400.0, 1.1, spring))
    )
    _, of_base, of_spring = posterior_weights([none, sways, slips], CALIBRATED)
    assert np.log(of_spring / of_base) == pytest.approx(CALIBRATED.per_state * 4 * 2 / CALIBRATED.temperature)


def test_a_diverged_hypothesis_comes_last_far_from_the_noise() -> None:
    """Its cost is infinite, and its errors are as large as they can be."""
    counts, independent = np.full((4, 1), 200.0), np.full(4, 20.0)
    far, lost = (TrialErrors(np.full((4, 1), square), counts, independent) for square in (900.0, DIVERGED_ERROR**2))
    none, found = replace(NONE, ratio=40.0, seen=far), replace(assessed(400.0, 30.0, FRICTION), seen=far)
    gone = replace(assessed(np.inf, np.inf, OFFSET), seen=lost)
    assert in_order_of_odds([none, gone, found], CALIBRATED)[-1] is gone


def errors(floors: float) -> TrialErrors:
    """The same error in four trials, in noise floors."""
    return TrialErrors(np.full((4, 1), floors**2), np.full((4, 1), 200.0), np.full(4, 20.0))


def far(item: Assessment, seen: float, unseen: float) -> Assessment:
    return replace(item, ratio=seen, seen=errors(seen), unseen=errors(unseen))


@pytest.mark.parametrize(("floors", "share"), [(1.0, 0.0), (50.0, 1.0)])
def test_an_unknown_that_takes_its_price_off_the_cost_has_even_odds(floors: float, share: float) -> None:
    """Near the noise and far from it, where the odds count other errors than the cost does."""
    total = 600.0  # samples that the cost counts
    asked = price_of_unknown(floors, total, CALIBRATED) * (DRAG.size - OFFSET.size)
    assert asked > 0.0
    rich = np.sqrt((1.0 + floors**2) * np.exp(-asked / total) - 1.0)  # noise floors that it leaves
    both = [
        replace(assessed(total * np.log1p(left**2), left, each), seen=errors(left))
        for each, left in ((OFFSET, floors), (DRAG, rich))
    ]
    few, many = costs_against(both, share, CALIBRATED)
    assert many == pytest.approx(few, abs=1e-9)


def test_every_part_of_a_verdict_uses_the_calibration_that_is_given() -> None:
    """At a high price of an unknown the cause alone is less probable than none, and no reason to distrust the pair."""
    none, pair = far(NONE, 170.0, 170.0), far(assessed(300.0, 44.0, FRICTION, OFFSET), 44.0, 62.0)
    spring = cause("one_sided_spring", "hip")
    alone = far(Assessment(EvaluatedHypothesis((spring,), np.zeros(spring.size), ()), 400.0, 60.0), 60.0, 60.0)
    found = Hypotheses(none, (alone,), (pair,))
    cheap, dear = (replace(CALIBRATED, per_unknown_far=price) for price in (2.0, 7.5))
    assert judge(found, cheap).accepted.keys == alone.keys
    assert judge(found, dear).accepted.keys == pair.keys


def test_a_calibration_is_a_plants_choice() -> None:
    """The default is that of a plant; what takes a calibration has none."""
    package = Path(odds.__file__).parent
    used = {path.name for path in package.rglob("*.py") if "CALIBRATED" in re.findall(r"\w+", path.read_text())}
    assert used == {"odds.py", "verdict.py", "plant.py"}  # where it is made, exported and chosen


def test_a_cause_less_probable_than_none_is_no_reason_to_distrust_two() -> None:
    """One with numbers six standard deviations from usual explains trials left out as well as the pair."""
    none, pair = far(NONE, 170.0, 170.0), far(assessed(300.0, 44.0, FRICTION, OFFSET), 44.0, 62.0)
    spring = cause("one_sided_spring", "hip")
    odd, usual = (
        far(Assessment(EvaluatedHypothesis((spring,), np.full(spring.size, value), ()), 400.0, 60.0), 60.0, 60.0)
        for value in (6.0, 0.0)
    )
    assert hypotheses_that_pay([none, usual, pair], CALIBRATED) == [none, usual]
    assert hypotheses_that_pay([none, odd, pair], CALIBRATED) == [none, odd, pair]
    useless = far(assessed(300.0, 160.0, FRICTION, OFFSET), 160.0, 160.0)
    assert hypotheses_that_pay([none, odd, useless], CALIBRATED) == [none, odd]


def test_a_cause_that_holds_on_trials_left_out_beside_another_is_not_unknown() -> None:
    none, alone = far(NONE, 130.0, 130.0), far(SINGLES[0], 22.0, 125.0)
    beside = far(assessed(300.0, 16.0, FRICTION, OFFSET), 16.0, 50.0)
    by_itself = probability_of_unknown([none, alone], alone, 1.0, None, CALIBRATED)
    with_it = probability_of_unknown([none, alone, beside], alone, 1.0, None, CALIBRATED)
    assert with_it < 0.2 < 0.5 < by_itself


def test_several_causes_are_kept_when_fewer_are_not_evaluated() -> None:
    pair = assessed(200.0, 1.5, FRICTION, OFFSET)
    assert hypotheses_that_pay([NONE, pair], CALIBRATED) == [NONE, pair]


def test_a_third_cause_is_compared_with_the_best_pair() -> None:
    pair = assessed(200.0, 1.5, FRICTION, OFFSET)
    third = assessed(150.0, 1.45, FRICTION, OFFSET, DRAG)
    clear = assessed(100.0, 1.05, FRICTION, OFFSET, DRAG)
    assert len(judge(Hypotheses(NONE, SINGLES, (pair, third)), CALIBRATED).accepted.keys) == 2
    assert len(judge(Hypotheses(NONE, SINGLES, (pair, clear)), CALIBRATED).accepted.keys) == 3


def test_single_causes_none_and_unknown_sum_to_one() -> None:
    judged = judge(Hypotheses(NONE, SINGLES, ()), CALIBRATED)
    assert sum(p for _, p in judged.singles) + judged.none + judged.unknown == pytest.approx(1.0)
    assert judged.unknown > 0.5  # 2.5 of 5 is left: no known cause
    assert judged.verdict == "unknown"


def test_a_larger_remainder_raises_the_probability_of_unknown() -> None:
    odds = [
        judge(Hypotheses(NONE, (assessed(400.0, r, FRICTION), *SINGLES[1:]), ()), CALIBRATED).unknown
        for r in (1.2, 1.6, 2.2, 3.0)
    ]
    assert odds[0] == pytest.approx(CALIBRATED.doubt)
    assert odds == sorted(odds)
    assert odds[-1] > 0.7


def test_a_remainder_after_several_causes_raises_unknown_faster() -> None:
    """Two causes imitate many others; if they leave as much as one may, an unknown one is probable."""
    alone = judge(Hypotheses(NONE, (assessed(300.0, 1.9, FRICTION), *SINGLES[1:]), ()), CALIBRATED)
    both = judge(Hypotheses(NONE, SINGLES, (assessed(200.0, 1.9, FRICTION, OFFSET),)), CALIBRATED)
    assert alone.unknown < 0.5 < both.unknown
    assert (alone.verdict, both.verdict) == ("effect", "unknown")


def test_a_remainder_far_above_the_noise_raises_unknown_faster() -> None:
    """The same share of a gap left: of one of five noise floors, and of one of five hundred."""
    near = judge(Hypotheses(assessed(1000.0, 5.0), (assessed(400.0, 1.9, FRICTION),), ()), CALIBRATED)
    far = judge(Hypotheses(assessed(1000.0, 500.0), (assessed(400.0, 150.0, FRICTION),), ()), CALIBRATED)
    little = judge(Hypotheses(assessed(1000.0, 500.0), (assessed(400.0, 15.0, FRICTION),), ()), CALIBRATED)
    assert near.verdict == "effect"
    assert far.verdict == "unknown"
    assert 0.8 < far.unknown < 0.99
    assert little.verdict == "effect"  # a thousandth of the squared gap


def test_equally_good_explanations_are_tied() -> None:
    judged = judge(
        Hypotheses(NONE, (assessed(100.0, 1.0, OFFSET), assessed(101.0, 1.0, SCALE), SINGLES[0]), ()), CALIBRATED
    )
    assert judged.verdict == "tie"
    assert [item.keys[0] for item in judged.tied] == [("encoder_scale", "knee")]


def test_the_verdict_is_none_when_no_cause_pays_for_its_parameters() -> None:
    still = assessed(100.0, 1.0)
    found = Hypotheses(still, (assessed(98.0, 1.0, FRICTION), assessed(99.5, 1.0, OFFSET)), ())
    judged = judge(found, CALIBRATED)
    assert judged.verdict == "none"
    assert judged.none > 0.5
    assert judged.unknown == 0.0
    weights = posterior_weights(
        [still, *found.singles], replace(CALIBRATED, temperature=5.0, per_parameter=3.0, none=0.3, single=0.5, pair=0.2)
    )
    asked = [98.0 + 3.0 * FRICTION.size, 99.5 + 3.0 * OFFSET.size]  # cost with what its unknowns must earn
    odds = [0.25 * np.exp(-(cost - 100.0) / 5.0) for cost in asked]
    assert weights[0] == pytest.approx(0.3 / (0.3 + sum(odds)))


def test_weights_equal_the_closed_form_of_prior_and_cost() -> None:
    """Prior times exp(-(cost + price per unknown) / temperature), the prior of singles shared among them."""
    hypotheses = [NONE, assessed(996.0, 4.9, FRICTION), assessed(999.0, 4.9, OFFSET)]
    c = CALIBRATED
    expected = np.array(
        [
            c.none * np.exp(-1000.0 / c.temperature + 990.0 / c.temperature),
            c.single / 2 * np.exp(-(996.0 + FRICTION.size * c.per_parameter - 990.0) / c.temperature),
            c.single / 2 * np.exp(-(999.0 + OFFSET.size * c.per_parameter - 990.0) / c.temperature),
        ]
    )
    np.testing.assert_allclose(posterior_weights(hypotheses, c), expected / expected.sum())


def test_unknown_has_probability_one_half_at_its_stated_share() -> None:
    """The best single cause leaves exactly ``left`` of the squared gap: even odds before the least doubt is added."""
    c = CALIBRATED
    gap = 4.5
    none = assessed(1000.0, np.sqrt(1.0 + (gap**2 - c.clean**2) / c.left))
    judged = judge(Hypotheses(none, (assessed(10.0, gap, FRICTION),), ()), CALIBRATED)
    assert judged.unknown == pytest.approx(1.0 - 0.5 * (1.0 - c.doubt), abs=0.02)
    assert judged.verdict == "unknown"


@pytest.mark.parametrize("ratio", [1.01, 1.5, 2.5, 4.0, 30.0])
@pytest.mark.parametrize("second", [0.5, 3.0, 20.0])
def test_probabilities_lie_between_zero_and_one(ratio: float, second: float) -> None:
    """With ``none`` and ``unknown`` the single causes never sum to more than 1, whichever hypothesis is heaviest."""
    singles = (assessed(100.0, ratio, FRICTION), assessed(100.0 + second, ratio, OFFSET), SINGLES[2])
    judged = judge(Hypotheses(NONE, singles, (assessed(99.0, ratio, FRICTION, DRAG),)), CALIBRATED)
    odds = [p for _, p in judged.singles]
    assert all(0.0 <= p <= 1.0 for p in [*odds, judged.none, judged.unknown])
    if len(judged.accepted.keys) < 2:
        assert sum(odds) + judged.none + judged.unknown <= 1.0 + 1e-12
    assert sum(weight for _, weight in judged.weighed) == pytest.approx(1.0)


def test_only_close_weights_are_a_tie() -> None:
    near = (assessed(100.0, 1.0, FRICTION), assessed(100.0 + 0.5 * CALIBRATED.temperature, 1.0, DRAG))
    far = (near[0], assessed(100.0 + 9 * CALIBRATED.temperature, 1.0, DRAG))
    assert DRAG.size == FRICTION.size
    assert judge(Hypotheses(NONE, near, ()), CALIBRATED).verdict == "tie"
    assert judge(Hypotheses(NONE, far, ()), CALIBRATED).verdict == "effect"


def test_an_explanation_that_predicts_unseen_trials_worse_is_unknown() -> None:
    sure = judge(Hypotheses(NONE, (assessed(50.0, 1.0, FRICTION), *SINGLES[1:]), ()), CALIBRATED)
    for fails, verdict in ((0.0, "effect"), (0.2, "effect"), (0.7, "unknown"), (1.0, "unknown")):
        found = with_doubt_of_held_out(sure, fails)
        assert found.verdict == verdict
        assert found.unknown == pytest.approx(1.0 - (1.0 - sure.unknown) * (1.0 - UNKNOWN_IF_CONTRADICTED * fails))
        total = found.none + found.unknown + sum(probability for _, probability in found.singles)
        assert total == pytest.approx(1.0)
        assert found.accepted is sure.accepted  # the nearest explanation is shown
