"""Levenberg-Marquardt for one or many problems in parallel, with one or several dampings per step.

A problem defines its cost, its normal equations and how a step moves a point; rules define how the
damping changes. Points of many problems are evaluated in one call, so that a simulator can batch them.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Generic, Protocol, TypeVar

import numpy as np

from synth.arrays import Array
from synth.estimation.normal_equations import DampingScale, NormalEquations, ParameterStep, StepLimits

CONVERGED = "converged"
AT_THE_LIMIT = "the iteration limit was reached"
DIVERGED = "the simulation diverges at the start"


class Point(Protocol):
    """A point of a problem, evaluated or not."""

    @property
    def cost(self) -> float:
        """Negative log-likelihood; inf if the simulation diverges or the point is not evaluated."""

    @property
    def unknowns(self) -> Array:
        """(p,) common unknowns."""


P = TypeVar("P", bound=Point)


class LeastSquares(ABC, Generic[P]):
    """A cost to minimise."""

    @abstractmethod
    def evaluate(self, points: Sequence[P]) -> Sequence[P]:
        """The points with their costs and the data of the normal equations."""

    @abstractmethod
    def normal(self, point: P) -> NormalEquations:
        """Normal equations at an evaluated point."""

    @abstractmethod
    def bounds(self, point: P) -> tuple[Array, Array]:
        """Lower and upper bounds of the common unknowns (p,); equal bounds fix an unknown."""

    @abstractmethod
    def moved(self, point: P, step: ParameterStep) -> P:
        """The point after a step, not evaluated."""

    @abstractmethod
    def least_gain(self, cost: float) -> float:
        """Decrease of ``cost`` below which a step is the last."""

    def limits(self, point: P) -> StepLimits:
        """Step limits; none by default."""
        return StepLimits()

    def damping_factors(self, point: P) -> Sequence[float]:
        """Factors on the damping that are tried in parallel; the best step is taken."""
        return (1.0,)


@dataclass(frozen=True)
class DampingRule(ABC):
    """Rule for the damping from step to step.

    ``least`` : lower bound of the damping. ``most`` : above it no step lowers the cost. ``memory`` : least share
    of the last step's scale that the next one keeps. ``settled`` : share of the least gain; a step with
    damping below ``hardly_damped`` that predicts less has converged. 0: every step is tried.
    """

    least: float
    most: float
    memory: float = 0.0
    settled: float = 0.0
    hardly_damped: float = 0.0

    @abstractmethod
    def after_success(self, iterate: Iterate[P], gain: float, predicted: float) -> tuple[float, float]:
        """Next damping and growth after a step with damping ``iterate.damping`` that lowered the cost by ``gain``."""

    @abstractmethod
    def after_failure(self, iterate: Iterate[P]) -> tuple[float, float]:
        """Next damping and growth after a failed step, or several."""


@dataclass(frozen=True)
class Nielsen(DampingRule):
    """Damping from the ratio of actual and predicted gain (Nielsen 1999, IMM-REP-1999-05)."""

    def after_success(self, iterate: Iterate[P], gain: float, predicted: float) -> tuple[float, float]:
        """Down to a third if the prediction held, up to twice if it did not; equation 2.21 there.

        ``predicted`` is that of ``NormalEquations.predicted_fall``, for a damped step less than Nielsen's, so that the
        damping falls sooner: with his, legs that nearly diverge take several times as many steps.
        """
        ratio = gain / max(predicted, 1e-300)
        factor = max(1 / 3, 1 - (2 * min(ratio, 1.5) - 1) ** 3)  # the least factor is reached below 1.5
        return max(iterate.damping * factor, self.least), 2.0

    def after_failure(self, iterate: Iterate[P]) -> tuple[float, float]:
        """Higher by 2, 4, 8 ... with each consecutive failure."""
        return iterate.damping * iterate.growth, 2.0 * iterate.growth


@dataclass(frozen=True)
class Marquardt(DampingRule):
    """Damping divided by ``down`` after a success and multiplied by ``up`` after a failure (Marquardt 1963).

    ``least_after_failure`` : the damping after a failure is at least this.
    """

    down: float = 10.0
    up: float = 10.0
    least_after_failure: float = 0.0

    def after_success(self, iterate: Iterate[P], gain: float, predicted: float) -> tuple[float, float]:
        """Lower."""
        return max(iterate.damping / self.down, self.least), iterate.growth

    def after_failure(self, iterate: Iterate[P]) -> tuple[float, float]:
        """Higher."""
        return max(self.up * iterate.damping, self.least_after_failure), iterate.growth


@dataclass(frozen=True)
class Iterate(Generic[P]):
    """State of an iteration: an evaluated point, the next damping, and the reason for its end, if any.

    ``growth`` : factor on the damping at the next failure. ``count`` : steps so far. ``scale`` : of the last step.
    """

    point: P
    damping: float = 1e-3
    reason: str = ""
    count: int = 0
    growth: float = 2.0
    scale: DampingScale | None = None


@dataclass(frozen=True)
class _Proposal(Generic[P]):
    """Trial steps from an iterate."""

    points: list[P]
    steps: list[ParameterStep]
    dampings: list[float]
    normal: NormalEquations | None


def minimise(problem: LeastSquares[P], start: Sequence[Iterate[P]], rule: DampingRule, rounds: int) -> list[Iterate[P]]:
    """Improve evaluated points in parallel by at most ``rounds`` steps each.

    Returns
    -------
    list : one iterate each, in order; ``reason`` says why it ended, or that the limit was reached.
    """
    current = [
        it if it.reason or np.isfinite(it.point.cost) else replace(it, count=it.count + 1, reason=DIVERGED)
        for it in start
    ]
    for _ in range(rounds):
        proposals: list[tuple[int, _Proposal[P]]] = []
        for index, iterate in enumerate(current):
            if not iterate.reason:
                current[index], proposal = _propose_steps(problem, replace(iterate, count=iterate.count + 1), rule)
                proposals.append((index, proposal))
        if not proposals:
            break
        tried = problem.evaluate([point for _, proposal in proposals for point in proposal.points])
        first = 0
        for index, proposal in proposals:
            points = tried[first : first + len(proposal.points)]
            first += len(points)
            if points:
                current[index] = _take_best_step(problem, current[index], proposal, points, rule)
    return [it if it.reason else replace(it, reason=AT_THE_LIMIT) for it in current]


def _propose_steps(problem: LeastSquares[P], iterate: Iterate[P], rule: DampingRule) -> tuple[Iterate[P], _Proposal[P]]:
    """The next trial steps; none, and the iterate ends, if they predict next to no gain."""
    point = iterate.point
    normal = problem.normal(point)
    iterate = replace(iterate, scale=normal.scale.remembering(iterate.scale, rule.memory))
    assert iterate.scale is not None
    dampings = iterate.damping * np.array(problem.damping_factors(point))
    steps = normal.steps(point.unknowns, dampings, iterate.scale, problem.bounds(point), problem.limits(point))
    if rule.settled > 0.0 and iterate.damping <= rule.hardly_damped:
        least = rule.settled * problem.least_gain(point.cost)
        if all(normal.predicted_fall(step) <= least for step in steps):
            return replace(iterate, reason=CONVERGED), _Proposal([], [], [], None)
    return iterate, _Proposal([problem.moved(point, step) for step in steps], steps, dampings.tolist(), normal)


def _take_best_step(
    problem: LeastSquares[P], iterate: Iterate[P], proposal: _Proposal[P], tried: Sequence[P], rule: DampingRule
) -> Iterate[P]:
    """The iterate after its best step, or unchanged with more damping."""
    best = min(range(len(tried)), key=lambda k: tried[k].cost)
    point, here = tried[best], iterate.point.cost
    if np.isfinite(point.cost) and point.cost <= here:
        gain = here - point.cost
        assert proposal.normal is not None
        predicted = proposal.normal.predicted_fall(proposal.steps[best])
        taken = replace(iterate, point=point, damping=proposal.dampings[best])
        damping, growth = rule.after_success(taken, gain, predicted)
        reason = CONVERGED if gain <= problem.least_gain(point.cost) else ""
        return replace(taken, damping=damping, growth=growth, reason=reason)
    damping, growth = rule.after_failure(iterate)
    return replace(iterate, damping=damping, growth=growth, reason=CONVERGED if damping > rule.most else "")
