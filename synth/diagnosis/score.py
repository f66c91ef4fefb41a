"""Predictions of trials, fitted or left out, by a fixed hypothesis; only each trial's initial state is estimated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial
from synth.diagnosis.evaluated_hypothesis import FIRST_DAMPING, EvaluatedHypothesis
from synth.diagnosis.lanes import PredictorCache, state_size
from synth.diagnosis.workbench import Workbench, state_rows
from synth.estimation.gauss_newton import LocalProblem, gauss_newton

ITERATIONS = 8  # Gauss-Newton iterations for the initial state, the only unknowns
# RMS over the noise floor above which a trial may be a swing off; shares of the trial on which its state is then found
# one after the other, so that each part is followed before the next one counts.
FAR_OFF_RATIO, GROWING_SHARES = 9.0, (0.25, 0.5, 0.75)
LEAST_GAIN = 0.05  # of the cost, in units of log-likelihood: less changes no printed figure


def first_state(trial: AngleTrial) -> Array:
    """(2 n,) rotations and rates at the start, from the smoothed samples."""
    smoothed = trial.recording.smoothed
    return np.concatenate([smoothed.angle[0], smoothed.rate[0]])


def score(bench: Workbench, fit: EvaluatedHypothesis, trials: Sequence[AngleTrial]) -> list[tuple[Array, Array]]:
    """Prediction (m, n) rad in the sense of q of each trial by a fixed hypothesis, and its initial state."""
    cache: PredictorCache = {}
    return bench.in_parallel(lambda i: _follow_trial(bench, fit, trials[i], cache), len(trials))


def from_state(
    bench: Workbench, fit: EvaluatedHypothesis, trial: AngleTrial, cache: PredictorCache, start_state: Array
) -> Array:
    """(M,) whitened residual of a trial by a fixed hypothesis, from the best-fitting initial state near
    ``start_state``.
    """
    _, prediction, state = _with_state(bench, fit, trial, cache, start_state)
    return bench.residual(trial, prediction, state)


def _follow_trial(
    bench: Workbench, fit: EvaluatedHypothesis, trial: AngleTrial, cache: PredictorCache
) -> tuple[Array, Array]:
    """With the best-fitting initial state; if that is far off, also with one found on growing parts of the trial."""
    begun = first_state(trial)
    size = state_size(bench.predictor, len(bench.noise), fit.hypothesis)
    start_state = np.concatenate([begun, np.zeros(size - len(begun))])
    cost, prediction, state = _with_state(bench, fit, trial, cache, start_state)
    white = bench.whitener(trial).count
    if cost > 0.5 * FAR_OFF_RATIO**2 * float(bench.independent(trial).sum()):
        grown = start_state
        for share in GROWING_SHARES:
            grown = _with_state(bench, fit, trial, cache, grown, round(share * white))[2]
        better, also, other = _with_state(bench, fit, trial, cache, grown)
        if better < cost:
            return also, other
    return prediction, state


def _with_state(
    bench: Workbench,
    fit: EvaluatedHypothesis,
    trial: AngleTrial,
    cache: PredictorCache,
    start_state: Array,
    first: int | None = None,
) -> tuple[float, Array, Array]:
    """Cost, prediction and the best-fitting initial state near ``start_state``, by the ``first`` samples or by all."""
    rows = state_rows(trial, start_state)
    below = bench.state_prior(trial, start_state)
    later = slice(first, bench.whitener(trial).count) if first is not None else slice(0, 0)

    def state_at(free: Array) -> Array:
        state = start_state.copy()
        state[rows] = free
        return state

    def assess(free: Array) -> LocalProblem[Array]:
        state = state_at(free)
        prediction, slopes = bench.slopes(trial, fit, state, (), cache)
        residual = bench.residual(trial, prediction, state)
        matrix = np.concatenate([slopes, below])
        residual[later], matrix[later] = 0.0, 0.0
        with np.errstate(invalid="ignore", over="ignore"):  # a diverging motion is not finite, which ends the search
            normal, gradient = matrix.T @ matrix, matrix.T @ residual
        normal += 1e-12 * np.diag(np.diag(normal))  # a locked neighbour leaves a state almost no derivative
        return LocalProblem(prediction, 0.5 * float(residual @ residual), normal, gradient)

    found = gauss_newton(assess, start_state[rows], rounds=ITERATIONS, least_gain=LEAST_GAIN)
    prediction, state = found[0], state_at(found[1])
    residual = bench.residual(trial, prediction, state)
    return 0.5 * float(residual @ residual), prediction, state


def fresh(fit: EvaluatedHypothesis) -> EvaluatedHypothesis:
    """The fit, ready to continue from its current point."""
    return replace(fit, damping=FIRST_DAMPING, done=False)
