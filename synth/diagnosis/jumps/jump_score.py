"""How far a hypothesis misses trials that took no part: only each trial's own unknowns are estimated there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array
from synth.diagnosis.jumps.jump_data import Jump
from synth.diagnosis.jumps.jump_predict import N_OWN
from synth.diagnosis.jumps.jump_solve import STEP, JumpBench, JumpFit
from synth.threads import in_parallel

ROUNDS = 6  # steps for the trial's own unknowns


@dataclass(frozen=True)
class Scored:
    """A trial predicted: channel -> (m,) SI, with the trial's own unknowns (2,) that fit best."""

    channels: dict[str, Array]
    own: Array


def score(bench: JumpBench, fit: JumpFit, trials: Sequence[Jump]) -> tuple[Scored, ...]:
    """Predict trials with a hypothesis held fixed."""
    return tuple(in_parallel(lambda i: _one(bench, fit, trials[i]), len(trials)))


def score_in_turn(bench: JumpBench, fit: JumpFit) -> tuple[Scored, ...]:
    """Each trial to learn from, predicted by the others: the fit moved by what it owes to the trial."""
    if len(bench.trials) == 1:
        return score(bench, fit, bench.trials)
    normal = bench.normal(fit)
    low, high = bench.bounds(fit.hypothesis)
    made: list[Scored] = []
    for index, trial in enumerate(bench.trials):
        moved = np.clip(fit.unknowns + normal.without(index), low, high)
        made += score(bench, replace(fit, unknowns=moved), [trial])
    return tuple(made)


def _one(bench: JumpBench, fit: JumpFit, jump: Jump) -> Scored:
    """Gauss-Newton in the trial's own two unknowns, halving steps that do not help."""
    predictor = bench.predictor
    x = np.repeat(fit.unknowns[:, None], 1 + N_OWN, axis=1)
    own: Array = np.zeros(N_OWN)
    step: Array = np.zeros(N_OWN)
    best: tuple[float, dict[str, Array], Array] | None = None
    for _ in range(ROUNDS):
        mine = np.repeat(own[:, None], 1 + N_OWN, axis=1)
        mine[[0, 1], [1, 2]] += STEP
        predicted = predictor.predict(jump, fit.hypothesis, x, mine)
        residual = predictor.residual(jump, predicted)
        cost = 0.5 * float(residual[:, 0] @ residual[:, 0]) + 0.5 * float(own @ own)
        if best is None or cost < best[0]:
            gain = np.inf if best is None else best[0] - cost
            best = cost, {name: values[:, 0].copy() for name, values in predicted.items()}, own.copy()
            if gain < 0.02:
                break
            slopes = (residual[:, 1:] - residual[:, :1]) / STEP
            matrix = slopes.T @ slopes + np.eye(N_OWN)
            step = np.asarray(-np.linalg.solve(matrix, slopes.T @ residual[:, 0] + own), dtype=float)
        else:
            step = 0.5 * step
        own = best[2] + step
    assert best is not None
    return Scored(best[1], best[2])
