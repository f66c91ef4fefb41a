"""Leading hypotheses with the same small causes beside each, so that a small cause does not decide between them.

A rig has small causes beside its main one, and what a hypothesis leaves alone mixes both: a wrong main cause that
happens to imitate the small ones may leave less than the right one, which beside them leaves far less. So the leading
hypotheses are fitted again beside the small causes that the search found, each beside the same ones, and compared by
what they leave then.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from synth.arrays import Array
from synth.diagnosis.angle_search import rms_over_noise
from synth.diagnosis.effect_shape import ShapedEffect
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.hypotheses import Assessment, Hypotheses, Key
from synth.diagnosis.odds import Calibration, adds_little, far_share, in_order_of_odds
from synth.diagnosis.restarts import refine
from synth.diagnosis.search import best_of_each
from synth.diagnosis.unseen import errors_by_trial
from synth.diagnosis.verdict import hypotheses_that_pay, judge
from synth.diagnosis.workbench import Workbench

COMPANION_COUNT = 2  # small causes beside each leading hypothesis: as many as the search ever adds to a single cause
MOST_LEADERS, LEAST_WEIGHT = 6, 0.02  # hypotheses compared, and their least weight: a rival below it has odds below 50
# Single causes of the lowest cost that are compared in any case, though a trial may speak against them.
CHEAPEST_SINGLES = 2
START_FACTORS = (1.0, 0.3)  # on a small cause's strengths, starts beside another hypothesis
MOST_CAUSES = 3  # of a hypothesis, with its small causes
SmallCause = tuple[ShapedEffect, Array]  # a small cause and its unknowns


def with_companions(
    bench: Workbench, found: Hypotheses[EvaluatedHypothesis], calibration: Calibration
) -> Hypotheses[EvaluatedHypothesis]:
    """The hypotheses, with the leading ones also fitted beside the same small causes.

    ``found`` : with errors by trial. Unchanged near the noise, where nothing small is left, or if there is no small
    cause.
    """
    known = [found.none, *found.singles, *found.several]
    if far_share(known) == 0.0:
        return found
    small = _small_causes(found, hypotheses_that_pay(known, calibration), calibration)
    if not small:
        return found
    tried = {frozenset(item.keys) for item in known}
    fits = [
        fit
        for leader in _leading_hypotheses(found, calibration)
        for fit in _starts_beside_companions(bench, leader.fit, small, tried)
    ]
    made = [_assess_fit(bench, fit) for fit in best_of_each(refine(bench, fits))]
    several = tuple(sorted([*found.several, *made], key=lambda item: item.cost))
    return replace(found, several=several, small=tuple(cause.key for cause, _ in small))


def _small_causes(
    found: Hypotheses[EvaluatedHypothesis], paid: Sequence[Assessment[EvaluatedHypothesis]], calibration: Calibration
) -> list[SmallCause]:
    """The causes that the sets which the odds prefer have beside a hypothesis that pays, without paying.

    Without links of their own: their states would start from nothing beside another hypothesis. All of them can stand
    beside each other: of dry friction and one that falls with speed at a joint the better one.
    """
    pays, chosen, main = {frozenset(item.keys) for item in paid}, dict[Key, SmallCause](), frozenset[Key]()
    for item in in_order_of_odds([found.none, *found.singles, *found.several], calibration):
        keys = frozenset(item.keys)
        within = [each for each in paid if each.keys and set(each.keys) < keys]
        largest = min(within, key=lambda each: each.cost, default=None)
        if keys in pays or largest is None or not adds_little(item, largest, found.none):
            continue
        main = main or frozenset(largest.keys)
        for cause, place in zip(item.fit.hypothesis, item.fit.slices, strict=True) if main < keys else ():
            beside = [known for known, _ in chosen.values()]
            if cause.key not in main and not cause.links and cause.stands_beside(beside):
                chosen[cause.key] = cause, item.fit.unknowns[place]
        if len(chosen) >= COMPANION_COUNT:
            break
    return list(chosen.values())[:COMPANION_COUNT]


def _leading_hypotheses(
    found: Hypotheses[EvaluatedHypothesis], calibration: Calibration
) -> list[Assessment[EvaluatedHypothesis]]:
    """The hypotheses with the largest weights, and the single causes of the lowest cost."""
    judged = judge(found, calibration)
    weighed = [item for item, weight in judged.weighed if item.keys and weight > LEAST_WEIGHT][:MOST_LEADERS]
    cheapest = [item for item in found.singles[:CHEAPEST_SINGLES] if all(item is not other for other in weighed)]
    return [*weighed, *cheapest]


def _starts_beside_companions(
    bench: Workbench, fit: EvaluatedHypothesis, small: Sequence[SmallCause], tried: set[frozenset[Key]]
) -> list[EvaluatedHypothesis]:
    """Starts of a hypothesis with each of the small causes, and with all, that were not ``tried`` yet."""
    free = [each for each in small if each[0].stands_beside(fit.hypothesis)]
    made = []
    for count in range(1, min(len(free), MOST_CAUSES - len(fit.keys)) + 1):
        for some in combinations(free, count):
            keys = frozenset((*fit.keys, *(cause.key for cause, _ in some)))
            if keys not in tried:
                tried.add(keys)
                starts = [_start_of_set(bench, fit, some, factor) for factor in START_FACTORS]
                made.append(min(bench.evaluate(starts), key=lambda each: each.cost))
    return [start for start in made if np.isfinite(start.cost)]


def _start_of_set(
    bench: Workbench, fit: EvaluatedHypothesis, small: Sequence[SmallCause], factor: float
) -> EvaluatedHypothesis:
    points = [cause.strengthened(point, factor) for cause, point in small]
    return bench.awake(fit.beside([cause for cause, _ in small], points))


def _assess_fit(bench: Workbench, fit: EvaluatedHypothesis) -> Assessment[EvaluatedHypothesis]:
    return Assessment(fit, fit.cost, rms_over_noise(bench, fit), seen=errors_by_trial(bench, fit.residuals))
