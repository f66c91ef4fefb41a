"""How far a hypothesis misses trials that took no part: only each trial's own initial state is estimated there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array
from synth.diagnosis.gap_trials import GapTrial
from synth.diagnosis.solve import Fit, Workbench, state_rows
from synth.threads import in_parallel

ROUNDS = 8  # Gauss-Newton steps for the initial state, which is all that is estimated


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
    found = in_parallel(lambda i: _one(bench, fit, trials[i]), len(trials))
    return Scored(tuple(p for p, _ in found), tuple(s for _, s in found))


def _one(bench: Workbench, fit: Fit, trial: GapTrial) -> tuple[Array, Array]:
    """Gauss-Newton in the trial's initial state, halving steps that do not help."""
    links = sum(candidate.links for candidate in fit.hypothesis)
    state = np.concatenate([first_state(trial), np.zeros(2 * links)])
    rows = state_rows(trial, state)
    below = bench.state_prior(trial, state)
    best: tuple[float, Array, Array] | None = None
    step = np.zeros(len(rows))
    for _ in range(ROUNDS):
        prediction, slopes = bench.slopes(trial, fit, state, ())
        residual = bench.residual(trial, prediction, state)
        cost = 0.5 * float(residual @ residual)
        if best is None or cost < best[0]:
            gain = np.inf if best is None else best[0] - cost
            best = cost, prediction, state.copy()
            if gain < 0.05:
                break
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
