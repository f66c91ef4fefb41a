"""Fits with their own derivatives, and fits again from elsewhere where the cost has several minima.

The cost of a motion that turns over, or rubs, has many minima, and the start decides which one is found. A few fits
show whether that is so: the best causes, fitted again from the designed leg, end where they were, or not. Only if not,
every cause is fitted again from the tolerances and initial states of the others.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from synth.arrays import Array
from synth.diagnosis.effect_shape import ShapedEffect
from synth.diagnosis.evaluated_hypothesis import FIRST_DAMPING, EvaluatedHypothesis
from synth.diagnosis.score import fresh
from synth.diagnosis.screening import ladder_starts, scale_strengths
from synth.diagnosis.search import best_of_each
from synth.diagnosis.workbench import DAMPING_RULE, SOLVED, HypothesisFits, Workbench

# Most renewals of the derivatives, which stop when the cost falls by less, and most steps with each.
RENEWALS, CONVERGED_FALL, STEPS_A_RENEWAL = 8, 1.0, 3
CAUSES_PROBED = 2  # best causes that are fitted again from the designed leg
SHARE_APART = 0.05  # of the best cause's gain: ends that differ by more are different minima, not unfinished steps
LEAST_COST_APART = 3.0  # in log-likelihood, a factor of 20
DONOR_FITS = 4  # best causes whose tolerances and initial states the others start from
STRENGTH_FACTORS = (0.7, 1.4)  # factors on the strengths of causes from which it is fitted again
STARTS_A_CAUSE = 2  # starts of each cause that continue after the first steps
# Factors on the best rungs' strengths: a minimum may be narrow.
FACTORS_BETWEEN_RUNGS = 0.6, 0.7, 0.8, 0.9, 1.1, 1.25, 1.4, 1.7
CAUSES_TRIED = 16  # causes that continue from the best fits' tolerances; half of them after the first steps
EXCHANGE_ROUNDS = 2  # the second from the tolerances that the first found
# Steps of the derivatives, and how often they are renewed with each: dry friction makes cliffs in the cost, at which a
# derivative over a thousandth shows nothing of the way down. Last, the number of fits that continue.
WIDE_STEPS = ((0.1, 3, 12), (0.03, 3, 10), (0.01, 2, 8))
TrialStates = tuple[Array, ...]  # initial state of each trial


def refine(
    bench: Workbench,
    fits: Sequence[EvaluatedHypothesis],
    frames: int = RENEWALS,
    least_gain: float = CONVERGED_FALL,
    steps: int = STEPS_A_RENEWAL,
    *,
    undamped: bool = False,
) -> list[EvaluatedHypothesis]:
    """Fits with derivatives of their own point, renewed until they gain no more.

    ``frames`` : most renewals, with at most so many ``steps`` each. ``least_gain`` : fall of the cost, log-likelihood,
    up to which a renewal is a fit's last. ``undamped`` : to the optimum; steps begin undamped, continue down to this
    fall, and are taken only where the first of them predicts a larger one.
    """
    current, going = [bench.awake(fit) for fit in fits], list(range(len(fits)))
    damping, finished = (DAMPING_RULE.least, least_gain) if undamped else (FIRST_DAMPING, SOLVED)
    for _ in range(frames):
        for i in going:
            current[i] = replace(fresh(current[i]), frame=bench.frame(current[i]), damping=damping)
        if undamped:
            going = [i for i in going if predicted_fall(bench, current[i]) > least_gain]
        ends = dict(zip(going, bench.solve([current[i] for i in going], None, steps, finished), strict=True))
        going = [i for i, end in ends.items() if current[i].cost - end.cost > least_gain]
        current = [ends.get(i, fit) for i, fit in enumerate(current)]
        if not going:
            break
    return current


def predicted_fall(bench: Workbench, fit: EvaluatedHypothesis) -> float:
    """Fall of the cost that a step predicts, with that of the initial states; ``fit`` with derivatives of its point."""
    problem = HypothesisFits(bench, None, SOLVED)
    normal = problem.normal(fit)
    (step,) = normal.steps(
        fit.unknowns, np.array([fit.damping]), normal.scale, problem.bounds(fit), problem.limits(fit)
    )
    of_states = sum(float(residual @ residual) for residual in fit.residuals) - sum(normal.squares)
    return normal.predicted_fall(step) + 0.5 * normal.weight * of_states


def descend(
    bench: Workbench, fits: Sequence[EvaluatedHypothesis], rank: Callable[[EvaluatedHypothesis], float]
) -> list[EvaluatedHypothesis]:
    """The best fits by ``rank``, improved with derivatives over ever narrower steps; then as ``refine`` does."""
    current = list(fits)
    for step, frames, most in WIDE_STEPS:
        wide = replace(bench, step=step)
        current = sorted(refine(wide, wide.evaluate([fresh(fit) for fit in current]), frames), key=rank)[:most]
    return refine(bench, bench.evaluate([fresh(fit) for fit in current]))


def refit_from_design(
    bench: Workbench, refined: Sequence[EvaluatedHypothesis], designed: EvaluatedHypothesis
) -> list[EvaluatedHypothesis]:
    """The best causes fitted again from the unchanged leg ``designed``.

    ``refined`` : one fit of each cause, with its own derivatives, in order of cost.
    """
    probes = [
        _with_tolerances_of(fit, designed, states)
        for fit in refined[:CAUSES_PROBED]
        for states in _start_states(fit, designed)
    ]
    return refine(bench, bench.evaluate(probes))


def has_other_minima(
    refined: Sequence[EvaluatedHypothesis], ends: Sequence[EvaluatedHypothesis], nominal: EvaluatedHypothesis
) -> bool:
    """Whether fits of the same causes ended far apart, compared with what the best one gains over the nominal leg."""
    if not refined:
        return False
    best = {fit.keys: fit.cost for fit in refined}
    far = max(SHARE_APART * (nominal.cost - refined[0].cost), LEAST_COST_APART)
    return any(abs(end.cost - best[end.keys]) > far for end in ends)


def fit_from_best(
    bench: Workbench, candidates: Sequence[ShapedEffect], fits: Sequence[EvaluatedHypothesis]
) -> list[EvaluatedHypothesis]:
    """Every cause in place of those of the best fits, with their tolerances and initial states; with own derivatives.

    What acts like a cause that was found is near its optimum there, at a strength that has to be found: first on a
    coarse ladder, then between its rungs.
    """
    size = bench.n_tolerance
    begun = []
    for donor in fits[:DONOR_FITS]:
        plain = donor.start_at(hypothesis=(), unknowns=donor.unknowns[:size])
        starts = [
            bench.held(plain.beside([candidate], [point])) for candidate in candidates for point in candidate.starts()
        ]
        begun += bench.evaluate([rung for start in starts for rung in ladder_starts(start, size)])
    near = _best_starts(begun, STARTS_A_CAUSE)
    begun += bench.evaluate([scale_strengths(fit, size, factor) for fit in near for factor in FACTORS_BETWEEN_RUNGS])
    first = refine(bench, _best_starts(begun, 1)[:CAUSES_TRIED], frames=1)
    return refine(bench, _best_starts(first, 1)[: CAUSES_TRIED // 2])


def exchange_fits(
    bench: Workbench, refined: Sequence[EvaluatedHypothesis], designed: EvaluatedHypothesis
) -> list[EvaluatedHypothesis]:
    """The best fit of each cause, started again from the tolerances and initial states of the others' fits."""
    current = list(refined)
    for _ in range(EXCHANGE_ROUNDS):
        best = {fit.keys: fit.cost for fit in current}
        begun = refine(bench, bench.evaluate(_exchanged_starts(current, designed)), frames=1)
        current = best_of_each([*current, *refine(bench, _best_starts(begun, STARTS_A_CAUSE))])
        if all(best[fit.keys] - fit.cost <= LEAST_COST_APART for fit in current):
            break
    return current


def _best_starts(fits: Sequence[EvaluatedHypothesis], most: int) -> list[EvaluatedHypothesis]:
    """Starts: at most so many of each cause, in order of cost."""
    count: dict[tuple[tuple[str, str], ...], int] = {}
    kept = []
    for fit in sorted(fits, key=lambda fit: fit.cost):
        count[fit.keys] = count.get(fit.keys, 0) + 1
        if np.isfinite(fit.cost) and count[fit.keys] <= most:
            kept.append(fit)
    return kept


def _exchanged_starts(fits: Sequence[EvaluatedHypothesis], designed: EvaluatedHypothesis) -> list[EvaluatedHypothesis]:
    """Each cause from the others' tolerances, with their initial states or its own, and at other strengths."""
    made = []
    for fit in fits:
        for donor in (*fits[:DONOR_FITS], designed):
            if donor is not fit:
                made += [_with_tolerances_of(fit, donor, states) for states in _start_states(fit, donor)]
        made += [fit.start_at(unknowns=fit.strengthened(factor)) for factor in STRENGTH_FACTORS]
    return made


def _start_states(fit: EvaluatedHypothesis, donor: EvaluatedHypothesis) -> list[TrialStates]:
    """Initial states to start from: the donor's, where it has as many, and the fit's own."""
    alike = all(len(a) == len(b) for a, b in zip(fit.states, donor.states, strict=True))
    return [donor.states, fit.states] if alike else [fit.states]


def _with_tolerances_of(
    fit: EvaluatedHypothesis, donor: EvaluatedHypothesis, states: TrialStates
) -> EvaluatedHypothesis:
    """A cause with the tolerances of another one's fit."""
    size = donor.n_tolerance
    return fit.start_at(unknowns=np.concatenate([donor.unknowns[:size], fit.unknowns[size:]]), states=states)
