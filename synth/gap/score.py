"""How far a hypothesis misses trials that took no part: only each trial's own initial state is estimated there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.gap.data import GapTrial
from synth.gap.predict import Block
from synth.gap.solve import RATE_STEP, STEP, Fit, Workbench, by_trial
from synth.model.leg import Array

ROUNDS = 8


@dataclass(frozen=True)
class Scored:
    """Predictions (m, n) rad a trial, in the sense of q, with the initial state that fits best; and those states."""

    predictions: tuple[Array, ...]
    states: tuple[Array, ...]


def first_state(trial: GapTrial) -> Array:
    """(2 n,) rotations and rates at the start, from the smoothed samples."""
    smoothed = trial.recording.smoothed
    return np.concatenate([smoothed.angle[0], smoothed.rate[0]])


def score(bench: Workbench, fit: Fit, trials: Sequence[GapTrial]) -> Scored:
    """Predict trials with a hypothesis held fixed."""
    found = by_trial(lambda i: _one(bench, fit, trials[i]), len(trials))
    return Scored(tuple(p for p, _ in found), tuple(s for _, s in found))


def _one(bench: Workbench, fit: Fit, trial: GapTrial) -> tuple[Array, Array]:
    """Gauss-Newton in the trial's initial state, halving steps that do not help."""
    state, n = first_state(trial), len(first_state(trial)) // 2
    free = trial.free
    rows = [*free, *[n + j for j in free]]
    deviation = trial.recording.initial_rate[1]
    best: tuple[float, Array, Array] | None = None
    step = np.zeros(len(rows))
    for _ in range(ROUNDS):
        states = np.repeat(state[:, None], len(rows) + 1, axis=1)
        widths = np.array([STEP * (1.0 if row < n else RATE_STEP) for row in rows])
        for column, row in enumerate(rows, start=1):
            states[row, column] += widths[column - 1]
        unknowns = np.repeat(fit.unknowns[:, None], len(rows) + 1, axis=1)
        out = bench.predictor.predict(trial, [Block(fit.hypothesis, unknowns, states)])[0]
        residual = bench.residual(trial, out[:, :, 0], state)
        cost = 0.5 * float(residual @ residual)
        if best is None or cost < best[0]:
            gain = np.inf if best is None else best[0] - cost
            best = cost, out[:, :, 0], state.copy()
            if gain < 0.05:
                break
            slopes = ((out[:, :, 1:] - out[:, :, :1]) / widths / bench.sigma(trial)[:, None])[trial.counts]
            below = np.zeros((len(rows), len(rows)))
            for k, j in enumerate(free):
                below[len(free) + k, len(free) + k] = 1.0 / deviation[j]
            matrix = np.concatenate([slopes, below])
            if not np.all(np.isfinite(matrix)) or not np.all(np.isfinite(residual)):
                break
            normal = matrix.T @ matrix
            step = -np.linalg.solve(normal + 1e-12 * np.diag(np.diag(normal)), matrix.T @ residual)
        else:
            step = 0.5 * step
        state = best[2].copy()
        state[rows] += step
    assert best is not None
    return best[1], best[2]


def fresh(fit: Fit) -> Fit:
    """The fit to go on from where it is, as if never stopped."""
    return replace(fit, damping=1e-3, done=False)
