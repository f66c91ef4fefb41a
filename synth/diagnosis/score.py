"""Predictions of trials, fitted or left out, by a fixed hypothesis; only each trial's initial state is estimated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial
from synth.diagnosis.evaluated_hypothesis import DAMPING, EvaluatedHypothesis
from synth.diagnosis.lanes import Kept
from synth.diagnosis.workbench import Workbench, state_rows
from synth.estimation.gauss_newton import LocalProblem, gauss_newton

ROUNDS = 8  # Gauss-Newton iterations for the initial state, the only unknowns
# RMS over the noise floor above which a trial may be a swing off; shares of the trial on which its state is then found
# one after the other, so that each part is followed before the next one counts.
FAR_OFF, GROWING = 9.0, (0.25, 0.5, 0.75)
LEAST_GAIN = 0.05  # of the cost, in units of log-likelihood: less changes no printed figure


def first_state(trial: AngleTrial) -> Array:
    """(2 n,) rotations and rates at the start, from the smoothed samples."""
    smoothed = trial.recording.smoothed
    return np.concatenate([smoothed.angle[0], smoothed.rate[0]])


def score(bench: Workbench, fit: EvaluatedHypothesis, trials: Sequence[AngleTrial]) -> list[tuple[Array, Array]]:
    """Prediction (m, n) rad in the sense of q of each trial by a fixed hypothesis, and its initial state."""
    kept: Kept = {}
    return bench.in_parallel(lambda i: _one(bench, fit, trials[i], kept), len(trials))


def from_state(bench: Workbench, fit: EvaluatedHypothesis, trial: AngleTrial, kept: Kept, begun: Array) -> Array:
    """(M,) whitened residual of a trial by a fixed hypothesis, from the best-fitting initial state near ``begun``."""
    _, prediction, state = _with_state(bench, fit, trial, kept, begun)
    return bench.residual(trial, prediction, state)


def _one(bench: Workbench, fit: EvaluatedHypothesis, trial: AngleTrial, kept: Kept) -> tuple[Array, Array]:
    """With the best-fitting initial state; if that is far off, also with one found on growing parts of the trial."""
    links = sum(candidate.links for candidate in fit.hypothesis)
    begun = np.concatenate([first_state(trial), np.zeros(2 * links)])
    cost, prediction, state = _with_state(bench, fit, trial, kept, begun)
    white = bench.whitener(trial).count
    if cost > 0.5 * FAR_OFF**2 * float(bench.independent(trial).sum()):
        grown = begun
        for share in GROWING:
            grown = _with_state(bench, fit, trial, kept, grown, round(share * white))[2]
        better, also, other = _with_state(bench, fit, trial, kept, grown)
        if better < cost:
            return also, other
    return prediction, state


def _with_state(
    bench: Workbench,
    fit: EvaluatedHypothesis,
    trial: AngleTrial,
    kept: Kept,
    begun: Array,
    first: int | None = None,
) -> tuple[float, Array, Array]:
    """Cost, prediction and the best-fitting initial state near ``begun``, by the ``first`` samples or by all."""
    rows = state_rows(trial, begun)
    below = bench.state_prior(trial, begun)
    later = slice(first, bench.whitener(trial).count) if first is not None else slice(0, 0)

    def state_at(free: Array) -> Array:
        state = begun.copy()
        state[rows] = free
        return state

    def assess(free: Array) -> LocalProblem[Array]:
        state = state_at(free)
        prediction, slopes = bench.slopes(trial, fit, state, (), kept)
        residual = bench.residual(trial, prediction, state)
        matrix = np.concatenate([slopes, below])
        residual[later], matrix[later] = 0.0, 0.0
        with np.errstate(invalid="ignore", over="ignore"):  # a diverging motion is not finite, which ends the search
            normal, gradient = matrix.T @ matrix, matrix.T @ residual
        normal += 1e-12 * np.diag(np.diag(normal))  # a locked neighbour leaves a state almost no derivative
        return LocalProblem(prediction, 0.5 * float(residual @ residual), normal, gradient)

    found = gauss_newton(assess, begun[rows], rounds=ROUNDS, least_gain=LEAST_GAIN)
    prediction, state = found[0], state_at(found[1])
    residual = bench.residual(trial, prediction, state)
    return 0.5 * float(residual @ residual), prediction, state


def fresh(fit: EvaluatedHypothesis) -> EvaluatedHypothesis:
    """The fit, ready to continue from its current point."""
    return replace(fit, damping=DAMPING, done=False)
