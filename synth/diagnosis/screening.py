"""Screening before any fit: trial sizes of a cause, and the cost predicted for each.

A strong cause changes a swing too much for a search from a small strength. A trial size costs one lane;
everything else uses existing derivatives.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.workbench import Workbench
from synth.threads import in_parallel

DIVERGED_RESIDUAL = 1e6  # whitened residual of a diverged motion
WEIGHT_RENEWALS = 8  # renewals of the weight, which grows as the remainder falls, and of the tolerances at their bounds
BOUND_STIFFNESS = 1e6  # times the largest second derivative: keeps a tolerance at its bound

STRENGTH_LADDER = (0.1, 1.0, -1.0, 4.0, -4.0, 12.0, 30.0, 70.0)  # factors on a start's strengths
# The same for compliances, the stiffer the more expensive; the softest is as soft as the joint's own spring.
STIFF_LADDER = (0.5, 2.0, 8.0, 40.0)


@dataclass(frozen=True)
class ScreeningFrame:
    """The shared data of fits: a linearised fit; derivatives by its unknowns with the states projected out.

    ``slopes`` (M, p) per trial; ``matrix`` (p, p) sum of their products.
    """

    bench: Workbench
    at: EvaluatedHypothesis
    slopes: tuple[Array, ...]
    matrix: Array

    @classmethod
    def of(cls, bench: Workbench, at: EvaluatedHypothesis) -> ScreeningFrame:
        """The screening at an evaluated fit with its own linearisation."""
        assert at.frame is not None
        slopes = [trial.projected for trial in at.frame.trials]
        if at.hypothesis:
            columns = [trial.project(c.T).T for trial, c in zip(at.frame.trials, at.columns, strict=True)]
            slopes = [np.concatenate(both, axis=1) for both in zip(slopes, columns, strict=True)]
        p = len(at.unknowns)
        return cls(bench, at, tuple(slopes), sum((s.T @ s for s in slopes), np.zeros((p, p))))

    def project(self, trial: int, residual: Array) -> Array:
        """A trial's residual (M,), or several (n_fit, M), without the part that its initial state can explain."""
        assert self.at.frame is not None
        return self.at.frame.trials[trial].project(residual)

    def left(self, trial: int, residuals: Sequence[Array]) -> Array:
        """(n_fit, M) projected residuals of fits with the states of this frame."""
        found = np.array(residuals)
        found[~np.isfinite(found.sum(axis=1))] = DIVERGED_RESIDUAL
        return self.project(trial, found)


def costs_after_step(bench: Workbench, fits: Sequence[EvaluatedHypothesis], at: EvaluatedHypothesis) -> list[float]:
    """Cost of each fit after one undamped step of all unknowns except its last candidate's, linearised at ``at``.

    ``at`` has the common part of the fits: tolerances, states and candidates, whose unknowns come first in
    each fit too.
    """
    ground = ScreeningFrame.of(bench, at)

    def trial_products(i: int) -> tuple[Array, Array]:
        left = ground.left(i, residuals[i])
        return left @ ground.slopes[i], _squares(left)

    if not fits:
        return []
    residuals = bench.residuals(fits)
    parts = in_parallel(trial_products, len(bench.trials))
    p = len(at.unknowns)
    begun = np.array([fit.unknowns[:p] for fit in fits])
    gradients, squares = sum(part[0] for part in parts), sum(part[1] for part in parts)
    left, steps = _step_within_bounds(bench, ground.matrix, np.asarray(gradients), np.asarray(squares), begun)
    return [
        bench.unknown_size.cost(float(rest), np.concatenate([here, fit.unknowns[p:]]))
        for fit, here, rest in zip(fits, begun + steps, left, strict=True)
    ]


def costs_by_secant(
    bench: Workbench, fits: Sequence[EvaluatedHypothesis], at: EvaluatedHypothesis
) -> list[tuple[float, float]]:
    """Predicted cost of each fit with its last cause at the best multiple of its strength, and that multiple.

    By the secant: the change at the given strength, extrapolated in proportion to the strength.
    """
    ground = ScreeningFrame.of(bench, at)
    p = len(at.unknowns)

    def trial_products(i: int) -> tuple[Array, Array, Array, Array, float]:
        here, slopes = ground.project(i, at.residuals[i]), ground.slopes[i]
        change = ground.left(i, residuals[i]) - here
        return change @ slopes, _squares(change), slopes.T @ here, change @ here, float(here @ here)

    if not fits:
        return []
    residuals = bench.residuals(fits)
    parts = in_parallel(trial_products, len(bench.trials))
    matrices, gradients = np.zeros((len(fits), p + 1, p + 1)), np.zeros((len(fits), p + 1))
    matrices[:, :p, :p] = ground.matrix
    squares = np.zeros(len(fits))
    for across, own, down, along, rest in parts:
        matrices[:, :p, p] += across
        matrices[:, p, p] += own
        gradients[:, :p] += down
        gradients[:, p] += along
        squares += rest
    matrices[:, p, :p] = matrices[:, :p, p]
    begun = np.tile(np.append(at.unknowns, 0.0), (len(fits), 1))
    left, steps = _step_within_bounds(bench, matrices, gradients, squares, begun)
    return [
        (bench.unknown_size.cost(float(rest), at.unknowns + step[:p]), float(step[p]))
        for rest, step in zip(left, steps, strict=True)
    ]


def _squares(rows: Array) -> Array:
    """Sum of squares of each row."""
    return np.asarray(np.einsum("fm,fm->f", rows, rows))


def _step_within_bounds(
    bench: Workbench, matrix: Array, gradient: Array, squares: Array, at: Array
) -> tuple[Array, Array]:
    """Sum of squares after one undamped step of each fit, and the steps; tolerances stop at their bounds.

    ``matrix`` (p, p) or (n_fit, p, p), ``gradient`` and ``at`` (n_fit, p), ``squares`` (n_fit,). Far above the noise
    the priors hold no tolerance back: unbounded, they would explain in this prediction what no fit lets them explain.
    The bounds by an active set (Nocedal & Wright, *Numerical Optimization* 2006, ch. 16.5), all tolerances at once;
    the best of the iterates.
    """
    low, high = bench.bounds(())
    count, prior = len(low), np.eye(at.shape[1])
    lowest, highest = low - at[:, :count], high - at[:, :count]
    step, best = np.zeros_like(at), np.zeros_like(at)
    left, least = squares, np.full(len(at), np.inf)
    stopped = np.zeros_like(at)  # 1 for a tolerance at its bound
    for _ in range(WEIGHT_RENEWALS):
        weight = bench.unknown_size.weight(left)[:, None]
        whole = weight[:, :, None] * matrix + prior
        hold = stopped * (BOUND_STIFFNESS * np.abs(whole).max(axis=(1, 2)))[:, None]
        right = (weight * gradient + at - hold * step)[:, :, None]
        step = -np.asarray(np.linalg.solve(whole + hold[:, :, None] * prior, right))[:, :, 0]
        step[:, :count] = np.clip(step[:, :count], lowest, highest)
        change = (matrix @ step[:, :, None])[:, :, 0]
        left = np.maximum(squares + np.einsum("fp,fp->f", 2.0 * gradient + change, step), 0.0)
        cost = bench.unknown_size.costs(left, at + step)
        best = np.where((cost < least)[:, None], step, best)
        least = np.minimum(cost, least)
        uphill = (weight * (gradient + change) + at + step)[:, :count]
        own = step[:, :count]
        stopped[:, :count] = ((own <= lowest) & (uphill > 0.0)) | ((own >= highest) & (uphill < 0.0))
    change = (matrix @ best[:, :, None])[:, :, 0]
    return np.maximum(squares + np.einsum("fp,fp->f", 2.0 * gradient + change, best), 0.0), best


def ladder_starts(fit: EvaluatedHypothesis, first: int) -> list[EvaluatedHypothesis]:
    """The start with the strengths of its last candidate multiplied by ``STRENGTH_LADDER``, as far as its bounds allow.

    ``first`` : index of that candidate's unknowns.
    """
    made, seen = [], set()
    for factor in STRENGTH_LADDER if not fit.hypothesis[-1].is_compliance else STIFF_LADDER:
        if overshoots(fit, first, factor):
            continue
        rung = scale_strengths(fit, first, factor)
        key = tuple(rung.unknowns[first:].round(9))
        if key not in seen:
            seen.add(key)
            made.append(rung)
    return made


def overshoots(fit: EvaluatedHypothesis, first: int, factor: float) -> bool:
    """Whether the factor takes a log-normal strength of the last candidate beyond its bounds.

    There it is absurd rather than strong: a stop 65 000 times as stiff as its joint, which the integrator cannot follow
    within the largest number of steps.
    """
    candidate = fit.hypothesis[-1]
    named = zip(candidate.shape.free, candidate.priors, strict=True)
    log = np.array([prior.log and name in candidate.effect.strengths for name, prior in named])
    low, high = candidate.bounds()
    moved = fit.unknowns[first:] * factor
    return bool(np.any(log & ((moved < low) | (moved > high))))


def scale_strengths(fit: EvaluatedHypothesis, first: int, factor: float) -> EvaluatedHypothesis:
    """The fit with its last candidate's whitened strengths multiplied, within its bounds.

    From the prior's centre, not from ``absent``: the rungs of a damper that thins are losses of 0.15, 0.47, 0.85, 1.2.
    """
    candidate = fit.hypothesis[-1]
    strengths = np.array([name in candidate.effect.strengths for name in candidate.shape.free])
    low, high = candidate.bounds()
    unknowns = fit.unknowns.copy()
    unknowns[first:] = np.clip(unknowns[first:] * np.where(strengths, factor, 1.0), low, high)
    return fit.start_at(unknowns=unknowns, frame=fit.frame)
