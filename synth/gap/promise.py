"""What a cause promises before it is fitted: one lane a start, all else by derivatives that are there already."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synth.gap.predict import Block
from synth.gap.solve import Fit, Workbench, by_trial
from synth.model.leg import Array

DIVERGED = 1e6  # whitened residual of a motion that diverged
WEIGHINGS = 3  # less left weighs more: times that the weight is taken anew


@dataclass(frozen=True)
class Ground:
    """What fits have in common: a fit with its frame; its unknowns' derivatives, the states' taken out.

    ``slopes`` a trial (M, p); ``matrix`` (p, p) their products summed.
    """

    bench: Workbench
    at: Fit
    slopes: tuple[Array, ...]
    matrix: Array

    @classmethod
    def of(cls, bench: Workbench, at: Fit) -> Ground:
        """At a fit that has been evaluated and has a frame of its own."""
        assert at.frame is not None
        slopes = []
        for i, part in enumerate(at.frame.parts):
            wide = np.concatenate([part.tolerance, at.columns[i]], axis=1) if at.hypothesis else part.tolerance
            slopes.append(wide - part.q @ (part.q.T @ wide))
        p = len(at.unknowns)
        return cls(bench, at, tuple(slopes), sum((s.T @ s for s in slopes), np.zeros((p, p))))

    def project(self, trial: int, residual: Array) -> Array:
        """A trial's residual less what its initial state can explain."""
        assert self.at.frame is not None
        q = self.at.frame.parts[trial].q
        return np.asarray(residual - q @ (q.T @ residual))

    def residuals(self, trial: int, fits: Sequence[Fit]) -> list[Array]:
        """(M,) projected residuals of fits whose states are those of the ground."""
        data = self.bench.trials[trial]
        blocks = [Block(fit.hypothesis, fit.unknowns[:, None], fit.states[trial][:, None]) for fit in fits]
        found = []
        for fit, out in zip(fits, self.bench.predictor.predict(data, blocks), strict=True):
            residual = self.bench.residual(data, out[:, :, 0], fit.states[trial])
            whole = residual if np.all(np.isfinite(residual)) else np.full(len(residual), DIVERGED)
            found.append(self.project(trial, whole))
        return found


def prospects(bench: Workbench, fits: Sequence[Fit], at: Fit) -> list[float]:
    """Cost that each fit would have after one undamped step of all but its last candidate, by the frame of ``at``.

    ``at`` holds what the fits have in common: tolerances, states and its own candidates, whose unknowns come first in
    the fits' too.
    """
    ground = Ground.of(bench, at)

    def one(i: int) -> list[tuple[Array, float]]:
        return [(ground.slopes[i].T @ left, float(left @ left)) for left in ground.residuals(i, fits)]

    parts = by_trial(one, len(bench.trials))
    p = len(at.unknowns)
    costs = []
    for f, fit in enumerate(fits):
        gradient = sum((part[f][0] for part in parts), np.zeros(p))
        squares = sum(part[f][1] for part in parts)
        left, step = _stepped(bench, ground.matrix, gradient, squares, fit.unknowns[:p])
        costs.append(bench.cost(left, np.concatenate([fit.unknowns[:p] + step, fit.unknowns[p:]])))
    return costs


def leverage(bench: Workbench, fits: Sequence[Fit], at: Fit) -> list[tuple[float, float]]:
    """Cost that each fit's last cause promises at the best multiple of its strength, and that multiple.

    By the secant: the change that the cause makes at the strength given, taken to grow in proportion to it.
    """
    ground = Ground.of(bench, at)
    p = len(at.unknowns)

    def one(i: int) -> list[tuple[Array, float, Array, float, float]]:
        here = ground.project(i, at.residuals[i])
        found = []
        for there in ground.residuals(i, fits):
            change = there - here
            slopes = ground.slopes[i]
            products = slopes.T @ change, float(change @ change), slopes.T @ here
            found.append((*products, float(change @ here), float(here @ here)))
        return found

    parts = by_trial(one, len(bench.trials))
    found = []
    for f in range(len(fits)):
        matrix, gradient = np.zeros((p + 1, p + 1)), np.zeros(p + 1)
        matrix[:p, :p] = ground.matrix
        squares = 0.0
        for part in parts:
            across, own, down, along, rest = part[f]
            matrix[:p, p] += across
            matrix[p, p] += own
            gradient[:p] += down
            gradient[p] += along
            squares += rest
        matrix[p, :p] = matrix[:p, p]
        left, step = _stepped(bench, matrix, gradient, squares, np.concatenate([at.unknowns, [0.0]]))
        found.append((bench.cost(left, at.unknowns + step[:p]), float(step[p])))
    return found


def _stepped(bench: Workbench, matrix: Array, gradient: Array, squares: float, at: Array) -> tuple[float, Array]:
    """Squares left after one undamped step, and the step; unknowns beyond the prior's (the secant's) have none."""
    prior = np.eye(len(at))
    left = squares
    step: Array = np.zeros(len(at))
    for _ in range(WEIGHINGS):
        weight = 2.0 / (1.0 + left / bench.total)
        step = -np.asarray(np.linalg.solve(weight * matrix + prior, weight * gradient + at))
        left = max(squares + 2.0 * float(gradient @ step) + float(step @ matrix @ step), 0.0)
    return left, step
