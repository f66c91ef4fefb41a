"""Levenberg-Marquardt over all trials: common unknowns, and each trial's own eliminated by Schur complement.

Cost, in units of log-likelihood: Huber's function of the residuals over their noise, shifts of the rest angles over
their spread, weak priors of the common unknowns and of the initial states, and static points. The
normal equations are arrow-shaped (see ``estimation.normal_equations``); damping after Nielsen 1999.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from synth.arrays import Array
from synth.estimation.levenberg_marquardt import CONVERGED, Iterate, LeastSquares, Nielsen, minimise
from synth.estimation.normal_equations import ArrowNormal, Information, ParameterStep, StepLimits, TrialNormal
from synth.fit.recordings import Recording
from synth.fit.rounding import Rounding
from synth.fit.trajectories import Local, Sensitivity, TrajectoryModel
from synth.threads import shared_out

HUBER = 3.0  # noise standard deviations beyond which a residual counts linearly
LEAST_CURVATURE = 1e-6  # least curvature of a count's likelihood, which almost vanishes in the middle of a wide count
LARGEST_STEP = 1.0  # of a log rate, or rad of a rest angle: the linearisation is invalid beyond a factor of e
DAMPING = 1e-3  # initial, relative to the diagonal (Nielsen 1999: 1e-3 for a good start)
# A scale at most halves in a step; a step that predicts less than the tolerance is not simulated (see
# ``_with_last_step``).
RULE = Nielsen(least=1e-12, most=1e10, memory=0.5, settled=1.0, hardly_damped=DAMPING)
SIMULATED_RULE = replace(RULE, settled=0.1)  # where lanes are too large to store, the last step is simulated
# Log-likelihood: most that the last step may gain to be taken by the sensitivities alone. It moves no estimate by more
# than 0.3 of its deviation, over which they hardly change.
LINEAR_GAIN = 0.05
# Of a log rate or rad, last step that was not simulated from which predictions and information are simulated anew for a
# result: along a ridge the deviations change by far more than the rates. A choice, compared
# in ``tests/fit/test_refreshed.py``.
STALE_STEP = 5e-3
STORED_BYTES = 2**26  # bytes of lanes that are stored, so that other weights at the same point need no simulation


@dataclass(frozen=True)
class Weights:
    """Divisors of the residuals (n_trial, n_joint) rad, and spread (n_joint,) rad of the rest shifts.

    A spread of zero fixes the shifts at zero, or at ``centre`` (n_trial, n_joint) rad if given.
    ``rounding`` : for each joint, the treatment of counts that are coarser than its noise; else None. The square of
    ``noise`` over the noise before rounding divides the counts' log-likelihood, because they are correlated.
    ``points`` (n_joint,) rad, spread of the rest angles at static points; None: they have the common ones.
    """

    noise: Array
    spread: Array
    centre: Array | None = None
    rounding: tuple[Rounding | None, ...] = ()
    points: Array | None = None


@dataclass(frozen=True)
class Solution:
    """The end of the iteration: unknowns, each trial's own, predictions (m, n) per trial, cost, steps, reason.

    ``damping`` at the end, and ``lanes`` per trial (empty if too large to store), for another
    ``solve`` starting here. ``unsimulated``: most that a common unknown (log rate or rad) moved in last steps that were
    taken by the sensitivities alone: predictions and cost are linear in them, and the information is that of the point
    before, see ``resimulated``.
    Where such a step gains more than ``LINEAR_GAIN``, predictions are those after it and all else is of the point
    before.
    """

    values: Array
    locals: tuple[Local, ...]
    predictions: tuple[Array, ...]
    cost: float
    iterations: int
    reason: str
    information: Information
    damping: float = DAMPING
    lanes: tuple[Sensitivity, ...] = field(default=(), repr=False, compare=False)
    unsimulated: float = 0.0


@dataclass(frozen=True)
class Stage:
    """A solution with the weights that it was found under."""

    solution: Solution
    weights: Weights


@dataclass(frozen=True)
class _State:
    """A point of the iteration, without predictions and normal equations until evaluated."""

    unknowns: Array
    locals: tuple[Local, ...]
    cost: float = np.inf
    predictions: tuple[Array, ...] = ()
    information: Information | None = None
    gradient: Array | None = None
    own_gradient: tuple[Array, ...] = ()
    lanes: tuple[Sensitivity, ...] = ()
    unsimulated: float = 0.0


@dataclass(frozen=True)
class _TrajectoryFit(LeastSquares[_State]):
    """Whole trajectories as a least-squares problem; ``fixed`` : only per-trial unknowns are estimated."""

    model: TrajectoryModel
    recordings: Sequence[Recording]
    weights: Weights
    tolerance: float
    fixed: bool

    @cached_property
    def own_priors(self) -> list[Array]:
        """Each trial's precision (l,) of its own unknowns' priors."""
        spread, model = self.weights.spread, self.model
        return [start_precision(recording, spread, model.shifted(recording)) for recording in self.recordings]

    def evaluate(self, points: Sequence[_State]) -> list[_State]:
        """Costs, gradients and information."""
        return [_assess(self, point.unknowns, point.locals) for point in points]

    def normal(self, point: _State) -> ArrowNormal:
        """Normal equations of an evaluated point."""
        assert point.information is not None
        assert point.gradient is not None
        return ArrowNormal.of(point.information, point.gradient, point.own_gradient)

    def bounds(self, point: _State) -> tuple[Array, Array]:
        """The bounds of the unknowns, or the point itself if they are fixed."""
        unknowns = self.model.unknowns
        return (point.unknowns, point.unknowns) if self.fixed else (unknowns.lower, unknowns.upper)

    def limits(self, point: _State) -> StepLimits:
        """No common unknown moves by more than ``LARGEST_STEP``."""
        return StepLimits(LARGEST_STEP)

    def moved(self, point: _State, step: ParameterStep) -> _State:
        """After a step."""
        moved = zip(self.recordings, point.locals, step.own, strict=True)
        return _State(point.unknowns + step.common, tuple(self.model.step_local(r, at, own) for r, at, own in moved))

    def least_gain(self, cost: float) -> float:
        """The tolerance, independent of the cost."""
        return self.tolerance


@dataclass(frozen=True)
class FitStart:
    """The start of a fit: common unknowns (p,), per-trial unknowns, and the damping of its first step.

    ``lanes`` : the sensitivities at this point from an earlier solution, so that they need not be simulated, and
    ``unsimulated`` as of that.
    """

    values: Array
    locals: Sequence[Local]
    damping: float = DAMPING
    lanes: Sequence[Sensitivity] = ()
    unsimulated: float = 0.0

    @classmethod
    def at(cls, solution: Solution) -> FitStart:
        """A start to continue from a solution with other weights."""
        return cls(solution.values, solution.locals, solution.damping, solution.lanes, solution.unsimulated)


def solve(
    model: TrajectoryModel,
    recordings: Sequence[Recording],
    start: FitStart,
    weights: Weights,
    *,
    max_iterations: int = 40,
    tolerance: float = 1e-4,
    fixed: bool = False,
) -> Solution:
    """Minimise the cost from the given start.

    Parameters
    ----------
    tolerance : decrease of the cost (a log-likelihood) below which the iteration has converged.
    fixed : fix the common unknowns and estimate only per-trial ones (to score a given leg).

    Returns
    -------
    Solution ; its ``cost`` is inf if the start diverges.
    """
    problem = _TrajectoryFit(model, recordings, weights, tolerance, fixed)
    point = _assess(problem, start.values, tuple(start.locals), start.lanes)
    begun = Iterate(replace(point, unsimulated=start.unsimulated if start.lanes else 0.0), start.damping)
    (end,) = minimise(problem, [begun], RULE if begun.point.lanes else SIMULATED_RULE, max_iterations)
    found = _with_last_step(problem, end) if end.reason == CONVERGED else end.point
    assert found.information is not None
    return Solution(
        found.unknowns, found.locals, found.predictions, found.cost, end.count, end.reason, found.information,
        end.damping, found.lanes, found.unsimulated,
    )  # fmt: skip


def resimulated(
    model: TrajectoryModel, recordings: Sequence[Recording], stage: Stage, most: float = STALE_STEP
) -> Stage:
    """The same estimates, with predictions, cost and information simulated at them.

    The least eigenvalue of the information, which sets the deviations along a ridge, is a small difference of large
    numbers: a last step that was not simulated hardly moves these, and may change it many times over.
    ``most`` : that step, of a log rate or rad, up to which the stage is left as it is.
    """
    solution = stage.solution
    if solution.unsimulated <= most or not np.isfinite(solution.cost):
        return stage
    problem = _TrajectoryFit(model, recordings, stage.weights, 0.0, fixed=False)
    found = _assess(problem, solution.values, solution.locals)
    assert found.information is not None
    solution = replace(
        solution, predictions=found.predictions, cost=found.cost, information=found.information, lanes=found.lanes,
        unsimulated=0.0,
    )  # fmt: skip
    return replace(stage, solution=solution)


def reduced_by_trial(
    model: TrajectoryModel, recordings: Sequence[Recording], stage: Stage
) -> list[tuple[Array, Array]]:
    """Each trial's part of the common unknowns' normal matrix (p, p) and gradient (p,), its own unknowns eliminated."""
    found = stage.solution
    problem = _TrajectoryFit(model, recordings, stage.weights, 0.0, fixed=False)
    reduced = []
    for t, local in enumerate(found.locals):
        lanes = found.lanes[t] if found.lanes else model.sensitivity(recordings[t], found.values, local)
        part = _normal(recordings[t], lanes, stage.weights.noise[t], len(found.values), stage.weights.rounding)
        _own_priors(part, problem, t, local)
        reduced.append(TrialNormal(part.common, part.cross, part.own, part.gradient, part.own_gradient).reduced())
    return reduced


def _with_last_step(problem: _TrajectoryFit, end: Iterate[_State]) -> _State:
    """The end of the iteration after the last step, which gains less than the tolerance, taken by the sensitivities.

    Simulating it would only confirm it: the error of the linearisation is of second order in a step that is a small
    part of the estimates' deviations. The information is that of the point before. After a step that gains more than
    ``LINEAR_GAIN`` only the predictions are given, from which the noise can be estimated.
    """
    at = end.point
    if end.damping > RULE.hardly_damped or not at.lanes:
        return at
    normal = problem.normal(at)
    (step,) = normal.steps(at.unknowns, np.array([RULE.least]), normal.scale, problem.bounds(at), problem.limits(at))
    gain = normal.predicted_fall(step)
    if not 0.0 <= gain <= problem.tolerance:
        return at
    steps = (np.concatenate([step.common, own]) for own in step.own)
    lanes = tuple(found.after(own) for found, own in zip(at.lanes, steps, strict=True))
    predictions = tuple(found.prediction for found in lanes)
    far = at.unsimulated + float(np.abs(step.common).max(initial=0.0))
    if gain > LINEAR_GAIN:
        return replace(at, predictions=predictions, unsimulated=far)
    moved = problem.moved(at, step)
    return replace(
        at, unknowns=moved.unknowns, locals=moved.locals, cost=at.cost - gain, predictions=predictions, lanes=lanes,
        unsimulated=far,
    )  # fmt: skip


def _assess(
    problem: _TrajectoryFit, values: Array, locals_: tuple[Local, ...], lanes: Sequence[Sensitivity] = ()
) -> _State:
    """Cost, gradient and information at one point; ``lanes`` there, if available."""
    model, recordings, weights = problem.model, problem.recordings, problem.weights
    mean, precision_common = model.unknowns.prior
    common, gradient = np.diag(precision_common), precision_common * (values - mean)
    cost = 0.5 * float(gradient @ (values - mean))
    beside = model.unknowns.measured(values, weights.points)
    if beside is not None:
        cost, gradient, common = cost + beside[0], gradient + beside[1], common + beside[2]
    kept = STORED_BYTES // max(1, len(recordings))

    def one(t: int) -> tuple[_Part, Array, Sensitivity | None]:
        found = lanes[t] if lanes else model.sensitivity(recordings[t], values, locals_[t])
        part = _normal(recordings[t], found, weights.noise[t], len(values), weights.rounding)
        _own_priors(part, problem, t, locals_[t])
        small = found.out.nbytes <= kept
        return part, found.prediction if small else found.prediction.copy(), found if small else None

    parts = shared_out(one, len(recordings))
    for part, _, _ in parts:
        common += part.common
        gradient += part.gradient
        cost += part.cost
    return _State(
        values,
        locals_,
        cost if np.isfinite(cost) else np.inf,
        tuple(prediction for _, prediction, _ in parts),
        Information(common, tuple(part.cross for part, _, _ in parts), tuple(part.own for part, _, _ in parts)),
        gradient,
        tuple(part.own_gradient for part, _, _ in parts),
        tuple(found for _, _, found in parts if found is not None) if all(found for _, _, found in parts) else (),
    )


def _own_priors(part: _Part, problem: _TrajectoryFit, t: int, local: Local) -> None:
    """Add the priors of a trial's own unknowns: initial state, and shifts."""
    recording, centre = problem.recordings[t], problem.weights.centre
    free, start, shifted = recording.free, recording.start, problem.model.shifted(recording)
    shift = local.shift if centre is None else local.shift - centre[t]
    off = np.concatenate([(local.rotation - start.angle)[free], (local.rate - start.rate)[free], shift[shifted]])
    precision = problem.own_priors[t]
    pull = precision * off
    part.own.flat[:: len(off) + 1] += precision
    part.own_gradient += pull
    part.cost += 0.5 * float(pull @ off)


def start_precision(recording: Recording, spread: Array, shifted: Sequence[int]) -> Array:
    """(l,) precision of the priors of a trial's own unknowns, in the order of ``Evaluation.local``."""
    free, start = recording.free, recording.start
    deviations = [start.angle_deviation[free], start.rate_deviation[free], np.maximum(spread[shifted], 1e-9)]
    return np.asarray(np.concatenate(deviations) ** -2.0)


@dataclass
class _Part:
    cost: float
    common: Array
    gradient: Array
    cross: Array
    own: Array
    own_gradient: Array


def _normal(
    recording: Recording,
    found: Sensitivity,
    noise: Array,
    n_common: int,
    rounding: Sequence[Rounding | None] = (),
) -> _Part:
    """One trial's contribution to the normal equations, Huber-weighted."""
    cost, root, residual = _weigh_residuals(recording, found.prediction, noise, rounding)
    jacobian = found.differences().reshape(residual.size, -1)
    jacobian *= root.reshape(-1, 1)
    plan, p = found.plan, n_common
    normal = ((jacobian.T @ jacobian) / plan.area)[plan.square]
    gradient = (residual.ravel() @ jacobian / plan.width)[plan.order]
    return _Part(cost, normal[:p, :p], gradient[:p], normal[:p, p:], normal[p:, p:], gradient[p:])


def sample_weights(
    recording: Recording, prediction: Array, noise: Array, rounding: Sequence[Rounding | None] = ()
) -> Array:
    """(m, n) 1/rad: factors on a trial's residuals and sensitivities, 0 for samples that do not count."""
    return _weigh_residuals(recording, prediction, noise, rounding)[1]


def _weigh_residuals(
    recording: Recording, prediction: Array, noise: Array, rounding: Sequence[Rounding | None]
) -> tuple[float, Array, Array]:
    """A trial's cost, the factors (m, n) 1/rad on its residuals, and the weighted residuals, by Huber's function."""
    root = recording.counts / noise
    rounded = [j for j, item in enumerate(rounding) if item is not None]
    root[:, rounded] = 0.0
    residual = (prediction - recording.rotation) * root
    cost = 0.5 * float(np.vdot(residual, residual))
    flat, scales = residual.ravel(), root.ravel()
    far = np.flatnonzero(np.abs(flat) > HUBER)
    if len(far):
        size = np.abs(flat[far])
        cost += float(np.sum(HUBER * (size - 0.5 * HUBER) - 0.5 * size**2))
        weight = np.sqrt(HUBER / size)
        scales[far] *= weight
        flat[far] *= weight
    for j in rounded:
        item = rounding[j]
        assert item is not None
        cost += _weigh_counts(recording, prediction, j, item, float(item.noise / noise[j]) ** 2, root, residual)
    return cost, root, residual


def _weigh_counts(
    recording: Recording, prediction: Array, j: int, rounding: Rounding, share: float, root: Array, residual: Array
) -> float:
    """Write joint j's columns of ``root`` and ``residual`` (m, n) by the likelihood of its counts; their cost.

    ``share`` : of the counts that are independent.
    """
    counts = recording.counts[:, j]
    off = prediction[counts, j] - recording.rotation[counts, j]
    cost, slope, curvature = (share * term for term in rounding.terms(off, HUBER))
    scale = np.sqrt(np.maximum(curvature, LEAST_CURVATURE))
    root[counts, j] = scale / rounding.noise
    residual[counts, j] = slope / scale
    return float(cost.sum())
