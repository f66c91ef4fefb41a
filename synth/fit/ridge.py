"""The solution along a ridge that the trials leave open: the softest joint that fits equally well.

If a joint is overdamped, trials determine b/k and little else, and a model with missing effects prefers one end of
the ridge for a hundredth of a degree. The other end is more useful: the softest spring and damper with the same
motion can be wound or bought. The damper rate is therefore reduced, with everything else refitted, while the
overall RMS stays within ``ALLOWANCE`` of the best (the idea of the one-standard-error rule, Hastie, Tibshirani &
Friedman, *The Elements of Statistical Learning*, 2nd ed., section 7.10, with a fixed share because model error is not
sampling error). If the model explains the trials down to their noise, nothing is moved.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array
from synth.fit.fit_problem import unknowns_of
from synth.fit.least_squares import FitStart, Solution, Weights, solve
from synth.fit.recordings import Recording
from synth.fit.search_box import NEAR_LOGARITHM
from synth.fit.trajectories import TrajectoryModel
from synth.fit.uncertainty import covariance, is_ridge, root_mean_square
from synth.fit.unknowns import SpringsAndDampers
from synth.remarks import at_joint
from synth.swing.mechanics import outboard_inertia

MISFIT = 3.0  # RMS over sample scatter from which the model is questioned
ALLOWANCE = 0.05  # of the best overall RMS, for all joints together
BISECTIONS = 5  # of the logarithm of a rate: to a 32nd of the range
POINTS_COST = 0.5  # allowed increase of the static points' cost: one standard deviation of one of them
SAME_QUOTIENT = np.log(1.2)  # allowed change of b/k: beyond it is another minimum, not this ridge
HELD_PRECISION = 1e8  # precision of a fixed log rate: a standard deviation of 1e-4, far below any interval
SOFTEST_DECAY = 0.5  # 1/s of b/I in the recordings' unit of time, as of the prior: no ridge reaches lower
SETTLED_COST = 0.05  # decrease of the cost, a log-likelihood, below which a refit along a ridge has converged
SOFTEST = "of equally good springs and dampers the softest is given"
RIDGE = "moved along a ridge"  # kind of the remark on it


@dataclass(frozen=True)
class SoftenedSolution:
    """A solution further along its ridges, and a sentence for each joint that was moved."""

    solution: Solution
    sentences: tuple[str, ...]


def soften(
    model: TrajectoryModel, recordings: Sequence[Recording], solution: Solution, weights: Weights
) -> SoftenedSolution:
    """Move every joint whose spring and damper rate are not separable to the softest values that fit equally well."""
    unknowns = unknowns_of(model)
    loose = [(j, unknowns.rate_at(j), unknowns.damper_at(j)) for j in loose_joints(model, solution)]
    best, points = overall_rms(recordings, solution), static_cost(unknowns, solution.values, weights.points)
    softest = np.log(outboard_inertia(model.leg) * SOFTEST_DECAY / unknowns.box.unit)
    moved: list[tuple[int, Array, str]] = []
    pinned = unknowns.beliefs
    for count, (j, k, place) in enumerate(loose):
        limit = best * (1 + ALLOWANCE * (count + 1) / len(loose))
        high, low = float(solution.values[place]), softest[j]
        before = np.exp(solution.values[[k, place]])
        ended = bool(np.any(unknowns.upper[[k, place]] - solution.values[[k, place]] < NEAR_LOGARITHM))
        ratio = float(solution.values[place] - solution.values[k])
        search = RidgeSearch(with_beliefs(model, pinned), recordings, weights, max_iterations=12)
        for _ in range(BISECTIONS):
            middle = 0.5 * (high + low)
            found = search.refit(j, solution, middle)
            along = abs(float(found.values[place] - found.values[k]) - ratio) <= SAME_QUOTIENT
            points_fit = static_cost(unknowns, found.values, weights.points) <= points + POINTS_COST
            if along and points_fit and overall_rms(recordings, found) <= limit:
                high, solution = middle, found
            else:
                low = middle
        pinned = (*pinned, (place, high, HELD_PRECISION))
        after = np.exp(solution.values[[k, place]])
        if after[1] < 0.9 * before[1]:  # a smaller move is not worth a sentence
            moved.append((j, before, ", at the bound of the search" if ended else ""))
    # A joint's values still change while the next ones are moved: the sentences state what the result has.
    sentences = tuple(
        at_joint(
            model.leg.joint_names[j],
            f"{SOFTEST}: {np.exp(solution.values[unknowns.rate_at(j)]):.3g} N*m/rad and "
            f"{np.exp(solution.values[unknowns.damper_at(j)]):.3g} N*m*s/rad, the least residual would be at "
            f"{before[0]:.3g} and {before[1]:.3g}{where} (overall RMS {_degrees(recordings, solution)} instead of "
            f"{np.degrees(best):.3g} deg).",
            kind=RIDGE,
        )
        for j, before, where in moved
    )
    return SoftenedSolution(_without_pins(model, recordings, solution, weights), sentences)


@dataclass(frozen=True)
class RidgeSearch:
    """Refits with the damper rate of one joint fixed. ``clipped`` : the start is clipped to the search bounds."""

    model: TrajectoryModel
    recordings: Sequence[Recording]
    weights: Weights
    max_iterations: int
    clipped: bool = False

    def refit(self, joint: int, near: Solution, log_rate: float) -> Solution:
        """The fit with this log damper rate, started from a solution moved along the ridge: b/k stays the same."""
        unknowns = unknowns_of(self.model)
        k, place = unknowns.rate_at(joint), unknowns.damper_at(joint)
        values = near.values.copy()
        values[k] += log_rate - values[place]
        values[place] = log_rate
        if self.clipped:
            values = np.clip(values, unknowns.lower, unknowns.upper)
        model = with_beliefs(self.model, (*unknowns.beliefs, (place, log_rate, HELD_PRECISION)))
        start = FitStart(values, near.locals)
        return solve(
            model, self.recordings, start, self.weights, max_iterations=self.max_iterations, tolerance=SETTLED_COST
        )


def with_beliefs(model: TrajectoryModel, beliefs: tuple[tuple[int, float, float], ...]) -> TrajectoryModel:
    """The model with other priors."""
    unknowns = replace(unknowns_of(model), beliefs=beliefs)
    return TrajectoryModel(model.chain, model.leg, unknowns, max_steps=model.max_steps)


def loose_joints(model: TrajectoryModel, solution: Solution) -> list[int]:
    """Joints whose spring and damper rate are not separable, the least determined first."""
    unknowns = unknowns_of(model)
    cov = covariance(model, solution, with_prior=False)
    both = [(j, unknowns.rate_at(j), unknowns.damper_at(j)) for j in unknowns.rates if j in unknowns.dampers]
    found = [(float(cov[k, k]), j) for j, k, place in both if is_ridge(cov, k, place)]
    return [j for _, j in sorted(found, reverse=True)]


def static_cost(unknowns: SpringsAndDampers, values: Array, spread: Array | None) -> float:
    """The cost of the static points, which limits a move along a ridge; ``spread`` (n,) rad of their free angles."""
    measured = unknowns.measured(values, spread)
    return 0.0 if measured is None else measured[0]


def overall_rms(recordings: Sequence[Recording], solution: Solution) -> float:
    """Quadratic mean of the joints' RMS errors, rad; infinite for a diverged solution."""
    if not np.isfinite(solution.cost):
        return float("inf")
    rms = root_mean_square(recordings, solution.predictions)
    return float(np.sqrt(np.nanmean(rms**2)))


def _degrees(recordings: Sequence[Recording], solution: Solution) -> str:
    return f"{np.degrees(overall_rms(recordings, solution)):.3g}"


def _without_pins(
    model: TrajectoryModel, recordings: Sequence[Recording], solution: Solution, weights: Weights
) -> Solution:
    """The same point with the information of the problem without fixed rates, for correct intervals."""
    here = solve(model, recordings, FitStart(solution.values, solution.locals), weights, max_iterations=0)
    return replace(here, iterations=solution.iterations, reason=solution.reason, damping=solution.damping)
