"""A further cause beside a fit: screened by secants, tried on a subset of the trials, the best fitted to all."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synth.diagnosis.effect_shape import ShapedEffect
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.screening import costs_after_step, costs_by_secant, overshoots, scale_strengths
from synth.diagnosis.sifting import Sifting
from synth.diagnosis.workbench import Workbench
from synth.estimation.linearisation import Linearisation

LEAST_COST_REDUCTION = 3.0  # least predicted cost reduction of a further cause
SECANT_FACTORS = (1.0, 12.0)  # factors on a start's strengths at which the secant of a cause is evaluated
CAUSES_BY_SECANT, STARTS_OF_EACH = 16, 4  # most promising causes by secants; starts of each
FACTORS_ON_SECANT = (0.4, 1.0)  # factors on the strength that the secant predicts
# Most promising further causes, fitted to a subset of the trials: the secant ranks strong causes roughly only, and a
# fit to few trials is cheap. Decided by ``make blind-rigs``.
SETS_TRIED = 20
SETS_FITTED = 8  # of those, number fitted to all trials
ITERATIONS_OF_SETS = (2, 3)  # iterations of the fit on the subset, and on all trials


def fit_further_cause(
    bench: Workbench,
    sifting: Sifting,
    anchors: Sequence[EvaluatedHypothesis],
    candidates: Sequence[ShapedEffect],
    tried: int = SETS_TRIED,
    kept: int = SETS_FITTED,
) -> list[EvaluatedHypothesis]:
    """Hypotheses with an anchor and one further cause, best first.

    The most promising are ``tried`` on a subset of the trials, and those ``kept`` fitted to all.
    """
    promising: dict[frozenset[tuple[str, str]], tuple[float, EvaluatedHypothesis, EvaluatedHypothesis]] = {}
    for anchor in anchors:
        here = sifting.beside(anchor)
        for left, start in _starts_with_further_cause(sifting.bench, here, candidates):
            keys = frozenset(start.keys)
            if here.cost - left > LEAST_COST_REDUCTION and (keys not in promising or left < promising[keys][0]):
                promising[keys] = left, start, anchor
    best = sorted(promising.values(), key=lambda item: item[0])[:tried]
    origin = {frozenset(start.keys): anchor for _, start, anchor in best}
    fits = sifting.bench.solve([start for _, start, _ in best], None, ITERATIONS_OF_SETS[0])
    fits = sorted((fit for fit in fits if np.isfinite(fit.cost)), key=lambda fit: fit.cost)[:kept]
    from_anchors = [(fit, origin[frozenset(fit.keys)]) for fit in fits]
    spread = [start_for_all_trials(fit, sifting.few, anchor, anchor.frame) for fit, anchor in from_anchors]
    found = bench.solve(spread, None, ITERATIONS_OF_SETS[1])
    return sorted((fit for fit in found if np.isfinite(fit.cost)), key=lambda fit: fit.cost)


def _starts_with_further_cause(
    bench: Workbench, here: EvaluatedHypothesis, candidates: Sequence[ShapedEffect]
) -> list[tuple[float, EvaluatedHypothesis]]:
    """The best start of each further cause beside a fit: its predicted cost, and the start.

    First by secants, one or two lanes per start; then the most promising at the strengths that the secants predict.
    """
    first = len(here.unknowns)
    starts = []
    for candidate in candidates:
        if candidate.stands_beside(here.hypothesis):
            for point in candidate.starts():
                start = here.beside([candidate], [point], here.frame)
                secants = [secant for secant in SECANT_FACTORS if not overshoots(start, first, secant)]
                starts += [scale_strengths(start, first, secant) for secant in secants]
    predicted = zip(costs_by_secant(bench, starts, here), starts, strict=True)
    order = sorted(((left, best, start) for (left, best), start in predicted), key=lambda item: item[0])
    chosen: dict[tuple[str, str], list[EvaluatedHypothesis]] = {}
    for left, best, start in order:
        key = start.keys[-1]
        if here.cost - left > LEAST_COST_REDUCTION and len(chosen.get(key, ())) < STARTS_OF_EACH:
            chosen.setdefault(key, []).extend(
                scale_strengths(start, first, best * factor) for factor in FACTORS_ON_SECANT
            )
    tried = [start for key in list(chosen)[:CAUSES_BY_SECANT] for start in chosen[key]]
    found: dict[tuple[str, str], tuple[float, EvaluatedHypothesis]] = {}
    for left, start in zip(costs_after_step(bench, tried, here), tried, strict=True):
        if start.keys[-1] not in found or left < found[start.keys[-1]][0]:
            found[start.keys[-1]] = left, start
    return list(found.values())


def start_for_all_trials(
    fit: EvaluatedHypothesis, few: Sequence[int], whole: EvaluatedHypothesis, frame: Linearisation | None = None
) -> EvaluatedHypothesis:
    """A start at a fit to a subset of the trials, with the other trials' states of a fit to the ``whole``."""
    states = list(whole.states)
    for place, i in enumerate(few):
        states[i] = fit.states[place]
    return fit.start_at(states=states, frame=frame)
