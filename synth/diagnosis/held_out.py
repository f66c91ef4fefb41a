"""What held-out trials say of a hypothesis that may move within its uncertainty.

A held-out trial often depends on a number that the trials learnt from do not determine: a tip mass shows the length of
its link, which may be off by more than its tolerance where the cause is right. Such an error does not contradict the
cause; one that remains after the numbers have moved as far as the trials learnt from let them does.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.lanes import PredictorCache
from synth.diagnosis.score import score
from synth.diagnosis.workbench import Workbench
from synth.estimation.gauss_newton import LocalProblem, gauss_newton
from synth.estimation.linearisation import TrialLinearisation

ITERATIONS = 8  # Gauss-Newton iterations
LEAST_GAIN = 0.5  # of the cost, in units of log-likelihood, as for the fits


def moved_within_uncertainty(
    bench: Workbench, fit: EvaluatedHypothesis, trials: Sequence[AngleTrial], covariance: Array
) -> EvaluatedHypothesis:
    """The hypothesis at the unknowns that follow the held-out ``trials`` best, within its uncertainty.

    ``covariance`` (p, p) : of the errors of its unknowns; it stands for the trials learnt from and the priors.
    """
    information = np.asarray(np.linalg.inv(covariance))
    total = float(sum(bench.independent(trial).sum() for trial in trials))
    low, high = bench.bounds(fit.hypothesis)
    moved = [*bench.predictor.open_tolerances, *range(bench.n_tolerance, len(fit.unknowns))]

    def assess(step: Array) -> LocalProblem[EvaluatedHypothesis]:
        here = fit.at(np.clip(fit.unknowns + step, low, high))
        changed = here.unknowns - fit.unknowns
        kept: PredictorCache = {}
        states = [state for _, state in score(bench, here, trials)]

        def normal(index: int) -> tuple[Array, Array, float]:
            trial, state = trials[index], states[index]
            prediction, slopes = bench.slopes(trial, here, state, moved, kept)
            residual = bench.residual(trial, prediction, state)
            common = np.zeros((len(residual), len(fit.unknowns)))
            common[: len(slopes), moved] = slopes[:, : len(moved)]
            q, r = np.linalg.qr(np.concatenate([slopes[:, len(moved) :], bench.state_prior(trial, state)]))
            linear = TrialLinearisation(common, q, r)
            return linear.products, linear.projected.T @ residual, float(residual @ residual)

        with np.errstate(invalid="ignore", over="ignore"):  # a diverging motion is not finite, which ends the search
            found = bench.in_parallel(normal, len(trials))
            squares = sum(square for _, _, square in found)
            against, weight = _cost_of_unknown_size(squares, total)
            matrix = information + weight * sum(part for part, _, _ in found)
            gradient = information @ changed + weight * sum(part for _, part, _ in found)
            cost = against + 0.5 * float(changed @ information @ changed)
        return LocalProblem(here, cost, matrix, gradient)

    return gauss_newton(assess, np.zeros(len(fit.unknowns)), rounds=ITERATIONS, least_gain=LEAST_GAIN)[0]


def _cost_of_unknown_size(squares: float, total: float) -> tuple[float, float]:
    """What is against ``total`` errors with this sum of squares, and the weight of half the squares in it.

    Their negative log-likelihood at the most likely variance, which is the noise's or more: both sides of a move then
    count as they are, as the search's cost does only near the noise (``UnknownSize``).
    """
    variance = max(squares / total, 1.0)
    return 0.5 * (total * float(np.log(variance)) + squares / variance), 1.0 / variance
