"""Every cause alone, in every shape and from every start, on few trials: the best fits of each cause.

Thousands of starts share one linearisation, first to predict what each gains, then to fit the promising ones.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synth.diagnosis.effect_shape import ShapedEffect
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.screening import costs_after_step, ladder_starts
from synth.diagnosis.workbench import Workbench

SCREEN_ROUNDS = (2, 2, 2)  # iterations of all starts, of each candidate's best shapes, of the promising ones
TRIED_STARTS = 3  # of each candidate
LEAST_PROMISE, LEAST_TRIED = 0.5, 40  # least predicted cost reduction of a start, and number tried in any case
KEPT_SHAPES = 3  # fits of each cause that continue, and one more if all have the same shape
KEPT_STARTS = 2  # of those, number that continues to all trials, and one more if both have the same shape
PROMISING_SHARE, LEAST_CONTINUED = 0.1, 16  # share of the best gain after the first steps, and number, that continue


def screen_causes(
    bench: Workbench, candidates: Sequence[ShapedEffect], designed: EvaluatedHypothesis, still: float
) -> list[EvaluatedHypothesis]:
    """Every candidate from every start; the best shapes of each cause, in order of cost.

    ``still`` : cost of the nominal leg's best fit. The search starts from the designed leg, not from that fit: if a
    cause is missing, the best fit lies many tolerances away, far from the true leg and cause.
    """
    starts = [
        EvaluatedHypothesis((candidate,), np.concatenate([designed.unknowns, start]), designed.states)
        for candidate in candidates
        for start in candidate.starts()
    ]
    fits = bench.solve(_promising_starts(bench, starts, designed), designed.frame, SCREEN_ROUNDS[0])
    fits = _split_by_gain(fits, still, 0.3 * PROMISING_SHARE, 2 * LEAST_CONTINUED)[0]
    kept: dict[tuple[str, str], list[EvaluatedHypothesis]] = {}
    for fit in fits:
        kept.setdefault(fit.keys[0], []).append(fit)
    ordered = [sorted(group, key=lambda fit: fit.cost) for group in kept.values()]
    chosen = [fit for group in ordered for fit in _first_and_another_shape(group, KEPT_SHAPES)]
    chosen = bench.solve(chosen, designed.frame, SCREEN_ROUNDS[1])
    going, rest = _split_by_gain(chosen, still, PROMISING_SHARE, LEAST_CONTINUED)
    fits = [*bench.solve(going, designed.frame, SCREEN_ROUNDS[2]), *rest]
    best: dict[tuple[str, str], list[EvaluatedHypothesis]] = {}
    for fit in sorted(fits, key=lambda fit: fit.cost):
        if np.isfinite(fit.cost):
            best.setdefault(fit.keys[0], []).append(fit)
    left = [fit for group in best.values() for fit in _first_and_another_shape(group, KEPT_STARTS)]
    return sorted(left, key=lambda fit: fit.cost)


def same_shape(fit: EvaluatedHypothesis, other: EvaluatedHypothesis) -> bool:
    return fit.hypothesis[0].shape is other.hypothesis[0].shape


def _first_and_another_shape(fits: Sequence[EvaluatedHypothesis], most: int) -> list[EvaluatedHypothesis]:
    """The first so many fits of a single cause, and if all of them have one shape the first of another one."""
    kept = list(fits[:most])
    if all(same_shape(fit, kept[0]) for fit in kept):
        kept += [fit for fit in fits[most:] if not same_shape(fit, kept[0])][:1]
    return kept


def _split_by_gain(
    fits: Sequence[EvaluatedHypothesis], still: float, share: float, least: int
) -> tuple[list[EvaluatedHypothesis], list[EvaluatedHypothesis]]:
    """Fits that have gained at least a share of the best gain, ``least`` in any case; and the others."""
    order = sorted(fits, key=lambda fit: fit.cost)
    wanted = share * (still - order[0].cost) if order else 0.0
    cut = max(least, sum(still - fit.cost > wanted for fit in order))
    return order[:cut], order[cut:]


def _promising_starts(
    bench: Workbench, starts: Sequence[EvaluatedHypothesis], designed: EvaluatedHypothesis
) -> list[EvaluatedHypothesis]:
    """The starts of each candidate, at several strengths, with the lowest predicted cost.

    A strong cause changes a swing too much for a search from a small strength: the phase is lost.
    """
    p = bench.n_tolerance
    ladders = [ladder_starts(start, p) for start in starts]
    left = costs_after_step(bench, [fit for ladder in ladders for fit in ladder], designed)
    best: dict[int, list[tuple[float, EvaluatedHypothesis]]] = {}
    place = 0
    for start, ladder in zip(starts, ladders, strict=True):
        rung = int(np.argmin(left[place : place + len(ladder)]))
        best.setdefault(id(start.hypothesis[0]), []).append((left[place + rung], ladder[rung]))
        place += len(ladder)
    (alone,) = costs_after_step(bench, [EvaluatedHypothesis((), designed.unknowns, designed.states)], designed)
    chosen = [sorted(found, key=lambda item: item[0])[:TRIED_STARTS] for found in best.values()]
    tried = sorted((item for found in chosen for item in found), key=lambda item: item[0])
    worth = max(LEAST_TRIED, sum(cost < alone - LEAST_PROMISE for cost, _ in tried))
    return bench.evaluate([fit for _, fit in tried[:worth]])
