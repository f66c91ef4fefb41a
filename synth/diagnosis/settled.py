"""Fits that are reported, continued to their optimum.

The fits of a search stop where they gain little more, since there are hundreds of them. Along a flat valley that may be
far from the optimum, at a place that depends on rounding and on the senses of the axes. A log-likelihood that falls by
less than ``LARGEST_FALL_LEFT`` moves no number by more than a seventh of its standard deviation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from synth.diagnosis.angle_search import rms_over_noise
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.hypotheses import Assessment, Hypotheses
from synth.diagnosis.restarts import refine
from synth.diagnosis.simpler_effects import without_simpler_effects_in_disguise
from synth.diagnosis.unseen import errors_by_trial, errors_on_unseen_trials
from synth.diagnosis.verdict import Calibration, judge
from synth.diagnosis.workbench import Workbench

LARGEST_FALL_LEFT = 0.01  # log-likelihood, largest fall that may be left: (1/7)^2 / 2
# Hypotheses continued, and their least weight. What is left of a valley may raise a weight a few times: what has less
# than a quarter of the least weight that is reported (2 %) does not come into the answer.
MOST_SETTLED, LEAST_SETTLED_WEIGHT = 6, 0.005


def settle_leading(
    bench: Workbench,
    found: Hypotheses[EvaluatedHypothesis],
    calibration: Calibration,
    done: Sequence[EvaluatedHypothesis] = (),
) -> tuple[Hypotheses[EvaluatedHypothesis], list[EvaluatedHypothesis]]:
    """The hypotheses, the leading ones and the nominal leg's at their optimum; and the fits that are.

    Without those that are a simpler one there, which differs in its words only.

    ``done`` : fits that are already. Leading are those that the odds prefer, and what the verdict names. Where errors
    on unseen trials are known, they are of all that lead.
    """
    found = _with_leading_tested(bench, found, calibration)
    chosen = {id(item): item for item in (found.none, *_leading(found, calibration))}
    still = {key: item for key, item in chosen.items() if all(item.fit is not fit for fit in done)}
    fits = settle_fits(bench, [item.fit for item in still.values()])
    ends = {
        key: replace(item, fit=fit, cost=fit.cost, ratio=rms_over_noise(bench, fit))
        for (key, item), fit in zip(still.items(), fits, strict=True)
    }
    ends |= {
        key: replace(item, seen=errors_by_trial(bench, item.fit.residuals)) for key, item in ends.items() if item.seen
    }
    left = {key: item.fit for key, item in ends.items() if item.unseen}
    for key, errors in zip(left, errors_on_unseen_trials(bench, list(left.values())) if left else [], strict=True):
        ends[key] = replace(ends[key], unseen=errors)
    each = [[ends.get(id(item), item) for item in items] for items in ([found.none], found.singles, found.several)]
    (none,), singles, several = (tuple(sorted(items, key=lambda item: item.cost)) for items in each)
    settled = replace(found, none=none, singles=singles, several=several)
    return without_simpler_effects_in_disguise(bench, settled, calibration), [*done, *fits]


def _with_leading_tested(
    bench: Workbench, found: Hypotheses[EvaluatedHypothesis], calibration: Calibration
) -> Hypotheses[EvaluatedHypothesis]:
    """The hypotheses, those that lead with their errors on unseen trials, if the nominal leg's are known.

    What is left out beforehand are the sets that the fits prefer. The odds may then prefer a rival of one of them, of
    which nothing was left out: an explanation that no unseen trial has tested is not accepted as it is, nor refused
    for that: untested, an unknown cause has at least 0.5 against it.
    """
    while found.none.unseen is not None:
        untested = [item for item in _leading(found, calibration) if item.unseen is None]
        if not untested:
            break
        errors = errors_on_unseen_trials(bench, [item.fit for item in untested])
        tested = {
            id(item): replace(item, unseen=each, seen=item.seen or errors_by_trial(bench, item.fit.residuals))
            for item, each in zip(untested, errors, strict=True)
        }
        singles, several = (tuple(tested.get(id(h), h) for h in items) for items in (found.singles, found.several))
        found = replace(found, singles=singles, several=several)
    return found


def _leading(found: Hypotheses[EvaluatedHypothesis], calibration: Calibration) -> list[Assessment[EvaluatedHypothesis]]:
    """The hypotheses that the odds prefer, and what the verdict names; each once."""
    judged = judge(found, calibration)
    weighed = [item for item, weight in judged.weighed[:MOST_SETTLED] if weight >= LEAST_SETTLED_WEIGHT]
    return [*{id(item): item for item in (judged.accepted, *judged.tied, *weighed)}.values()]


def settle_fits(bench: Workbench, fits: Sequence[EvaluatedHypothesis]) -> list[EvaluatedHypothesis]:
    """Each fit with derivatives of its own point, where a step predicts no fall of the cost above
    ``LARGEST_FALL_LEFT``.
    """
    return refine(bench, fits, least_gain=LARGEST_FALL_LEFT, undamped=True)
