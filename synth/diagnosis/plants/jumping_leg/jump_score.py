"""Prediction error on trials that were not fitted; only each trial's own unknowns are estimated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.diagnosis.plants.jumping_leg.jump_bench import UNKNOWN_STEP, JumpBench, JumpFit
from synth.diagnosis.plants.jumping_leg.jump_data import Jump
from synth.diagnosis.plants.jumping_leg.jump_predict import N_TRIAL_UNKNOWN
from synth.estimation.gauss_newton import LocalProblem, gauss_newton
from synth.threads import in_parallel

ITERATIONS = 6  # iterations for the trial's own unknowns
LEAST_GAIN = 0.02  # of the cost, in units of log-likelihood: less changes no printed figure


@dataclass(frozen=True)
class ScoredJump:
    """A predicted trial: channel -> (m,) SI, with the best-fitting own unknowns (2,)."""

    channels: dict[str, Array]
    own: Array


def score(bench: JumpBench, fit: JumpFit, trials: Sequence[Jump]) -> tuple[ScoredJump, ...]:
    """Predict trials with a fixed hypothesis."""
    return tuple(in_parallel(lambda i: _score_jump(bench, fit, trials[i]), len(trials)))


def _score_jump(bench: JumpBench, fit: JumpFit, jump: Jump) -> ScoredJump:
    """The score of one trial with its own two unknowns estimated."""
    predictor = bench.predictor
    x = np.repeat(fit.unknowns[:, None], 1 + N_TRIAL_UNKNOWN, axis=1)

    def assess(own: Array) -> LocalProblem[dict[str, Array]]:
        mine = np.repeat(own[:, None], 1 + N_TRIAL_UNKNOWN, axis=1)
        mine[[0, 1], [1, 2]] += UNKNOWN_STEP
        predicted = predictor.predict(jump, fit.hypothesis, x, mine)
        residual = predictor.residual(jump, predicted)
        cost = 0.5 * float(residual[:, 0] @ residual[:, 0]) + 0.5 * float(own @ own)
        slopes = (residual[:, 1:] - residual[:, :1]) / UNKNOWN_STEP
        channels = {name: values[:, 0].copy() for name, values in predicted.items()}
        return LocalProblem(
            channels, cost, slopes.T @ slopes + np.eye(N_TRIAL_UNKNOWN), slopes.T @ residual[:, 0] + own
        )

    return ScoredJump(*gauss_newton(assess, np.zeros(N_TRIAL_UNKNOWN), rounds=ITERATIONS, least_gain=LEAST_GAIN))
