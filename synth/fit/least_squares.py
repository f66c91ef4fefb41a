"""Levenberg-Marquardt over all trials at once: common unknowns and each trial's own, by Schur complement.

Cost, in units of log-likelihood: Huber's function of the residuals over their noise, the shifts of the rest angles over
their spread, the weak priors of the common unknowns and of the initial rates, and static points beside the trials. The
normal equations are arrow-shaped, so a trial's own unknowns are eliminated trial by trial and the cost of a step is
linear in the number of trials (Triggs et al. 2000, "Bundle adjustment", section 6). Damping after Nielsen 1999
(IMM-REP-1999-05).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array
from synth.fit.recordings import Recording
from synth.fit.rounding import Rounding
from synth.fit.trajectories import Local, Sensitivity, TrajectoryModel
from synth.fit.unknowns import Unknowns
from synth.threads import shared_out

HUBER = 3.0  # noise standard deviations beyond which a residual counts linearly
FLAT = 1e-6  # least curvature of a count's likelihood: in the middle of a wide count there is next to none
LARGEST_STEP = 1.0  # of a log rate, rad
DAMPING = 1e-3  # at first, of the diagonal
SETTLED = 0.1  # of the tolerance: a step that promises less is not tried
KEPT = 2**26  # bytes of lanes that are kept, so that other weights at the same point need no simulation


@dataclass(frozen=True)
class Weights:
    """Noise (n_trial, n_joint) rad that residuals are divided by, and spread (n_joint,) rad of the rest shifts.

    A spread of zero holds the shifts at zero, or at ``centre`` (n_trial, n_joint) rad where that is given.
    ``rounding`` : a joint each, how its counts are reckoned with where they are coarser than its noise; else none.
    """

    noise: Array
    spread: Array
    centre: Array | None = None
    rounding: tuple[Rounding | None, ...] = ()


@dataclass(frozen=True)
class Information:
    """Arrow-shaped normal matrix: ``common`` (p, p), and a trial's ``cross`` (p, l) and ``own`` (l, l)."""

    common: Array
    cross: tuple[Array, ...]
    own: tuple[Array, ...]

    def schur(self) -> Array:
        """(p, p) information on the common unknowns once every trial's own are estimated too."""
        reduced = self.common.copy()
        for cross, own in zip(self.cross, self.own, strict=True):
            reduced -= cross @ np.linalg.solve(own, cross.T)
        return 0.5 * (reduced + reduced.T)


@dataclass(frozen=True)
class Solution:
    """Where the iteration ended: unknowns, each trial's own, predictions (m, n) a trial, cost, steps, and why.

    ``damping`` as it was at the end, and ``lanes`` a trial, empty where they are too large to keep: what another
    ``solve`` from here can begin with.
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


@dataclass(frozen=True)
class Stage:
    """A solution with the weights that it was found under."""

    solution: Solution
    weights: Weights


@dataclass(frozen=True)
class _State:
    values: Array
    locals: tuple[Local, ...]
    predictions: tuple[Array, ...]
    cost: float
    information: Information
    gradient: Array
    own_gradient: tuple[Array, ...]
    lanes: tuple[Sensitivity, ...]


def solve(
    model: TrajectoryModel,
    recordings: Sequence[Recording],
    values: Array,
    locals_: Sequence[Local],
    weights: Weights,
    *,
    max_iterations: int = 40,
    tolerance: float = 1e-4,
    fixed: bool = False,
    damping: float = DAMPING,
    lanes: Sequence[Sensitivity] = (),
) -> Solution:
    """Minimise the cost from the given start.

    Parameters
    ----------
    tolerance : fall of the cost (a log-likelihood) below which the iteration has converged.
    fixed : hold the common unknowns and estimate only what belongs to each trial (to score a given leg).
    damping : at first; ``lanes`` : at this very start, from an earlier solution, so that they are not run again.

    Returns
    -------
    Solution ; its ``cost`` is inf if even the start diverges.
    """
    state = _assess(model, recordings, values, tuple(locals_), weights, lanes)
    growth, reason, done = 2.0, "the iteration limit was reached", 0
    scale: tuple[Array, list[Array]] | None = None
    for done in range(1, max_iterations + 1):  # noqa: B007, reported at the end
        if not np.isfinite(state.cost):
            reason = "the motion diverges at the start"
            break
        diagonal = np.diag(state.information.common)
        owns = [np.diag(own) for own in state.information.own]
        if scale is None:
            scale = (diagonal.copy(), [own.copy() for own in owns])
        scale = (
            np.maximum(0.5 * scale[0], diagonal),
            [np.maximum(0.5 * a, b) for a, b in zip(scale[1], owns, strict=True)],
        )
        step, own_steps, predicted = _bounded_step(model.unknowns, state, damping, scale, fixed)
        if damping <= DAMPING and predicted <= SETTLED * tolerance:
            reason = "converged"
            break
        moved = np.clip(state.values + step, model.unknowns.lower, model.unknowns.upper)
        moved_locals = tuple(
            model.step_local(r, local, own) for r, local, own in zip(recordings, state.locals, own_steps, strict=True)
        )
        trial = _assess(model, recordings, moved, moved_locals, weights)
        if np.isfinite(trial.cost) and trial.cost <= state.cost:
            gain = state.cost - trial.cost
            ratio = gain / max(predicted, 1e-300)
            damping = max(damping * max(1 / 3, 1 - (2 * min(ratio, 1.5) - 1) ** 3), 1e-12)
            growth = 2.0
            small = gain <= tolerance
            state = trial
            if small:
                reason = "converged"
                break
        else:
            damping *= growth
            growth *= 2.0
            if damping > 1e10:
                reason = "converged"  # no step lowers the cost any more
                break
    return Solution(
        state.values, state.locals, state.predictions, state.cost, done, reason, state.information, damping, state.lanes
    )


def _assess(
    model: TrajectoryModel,
    recordings: Sequence[Recording],
    values: Array,
    locals_: tuple[Local, ...],
    weights: Weights,
    lanes: Sequence[Sensitivity] = (),
) -> _State:
    """Cost, gradient and information at one point; ``lanes`` there, if they are known already."""
    mean, precision_common = model.unknowns.prior
    common, gradient = np.diag(precision_common), precision_common * (values - mean)
    cost = 0.5 * float(gradient @ (values - mean))
    beside = model.unknowns.measured(values)
    if beside is not None:
        cost, gradient, common = cost + beside[0], gradient + beside[1], common + beside[2]
    kept = KEPT // max(1, len(recordings))

    def one(t: int) -> tuple[_Part, Array, Sensitivity | None]:
        found = lanes[t] if lanes else model.sensitivity(recordings[t], values, locals_[t])
        part = _normal(recordings[t], found, weights.noise[t], len(values), weights.rounding)
        _own_priors(part, recordings[t], locals_[t], weights, t, model.shifted(recordings[t]))
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
        tuple(prediction for _, prediction, _ in parts),
        cost if np.isfinite(cost) else np.inf,
        Information(common, tuple(part.cross for part, _, _ in parts), tuple(part.own for part, _, _ in parts)),
        gradient,
        tuple(part.own_gradient for part, _, _ in parts),
        tuple(found for _, _, found in parts if found is not None) if all(found for _, _, found in parts) else (),
    )


def _own_priors(
    part: _Part, recording: Recording, local: Local, weights: Weights, t: int, shifted: Sequence[int]
) -> None:
    """Add what is known of a trial's own unknowns: its initial rates, and its shifts' spread."""
    free = recording.free
    rate, deviation = recording.initial_rate
    first = 2 * len(free)
    precision = np.concatenate([deviation[free] ** -2, np.maximum(weights.spread[shifted], 1e-9) ** -2])
    off = local.shift[shifted] if weights.centre is None else (local.shift - weights.centre[t])[shifted]
    off = np.concatenate([local.rate[free] - rate[free], off])
    places = np.arange(len(free), first + len(shifted))
    part.own[places, places] += precision
    part.own_gradient[places] += precision * off
    part.cost += 0.5 * float(precision @ off**2)


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
    root = recording.counts / noise
    rounded = [j for j, item in enumerate(rounding) if item is not None]
    root[:, rounded] = 0.0
    residual = (found.prediction - recording.rotation) * root
    size = np.abs(residual)
    if np.max(size) <= HUBER:  # the usual case; not if it is no number
        cost = 0.5 * float(np.vdot(residual, residual))
    else:
        inside = size <= HUBER
        cost = float(np.sum(np.where(inside, 0.5 * residual**2, HUBER * (size - 0.5 * HUBER))))
        weight = np.sqrt(np.where(inside, 1.0, HUBER / np.maximum(size, HUBER)))
        root, residual = root * weight, residual * weight
    for j in rounded:
        cost += _rounded(recording, found.prediction, j, rounding[j], root, residual)
    jacobian = found.differences()
    jacobian *= root[:, :, None]
    jacobian = jacobian.reshape(residual.size, -1)
    plan, p = found.plan, n_common
    normal = ((jacobian.T @ jacobian) / plan.area)[plan.square]
    gradient = (jacobian.T @ residual.ravel() / plan.width)[plan.order]
    return _Part(cost, normal[:p, :p], gradient[:p], normal[:p, p:], normal[p:, p:], gradient[p:])


def _rounded(
    recording: Recording, prediction: Array, j: int, rounding: Rounding | None, root: Array, residual: Array
) -> float:
    """Write joint j's columns of ``root`` and ``residual`` (m, n) by the likelihood of its counts; their cost."""
    assert rounding is not None
    counts = recording.counts[:, j]
    off = prediction[counts, j] - recording.rotation[counts, j]
    cost, slope, curvature = rounding.terms(off, HUBER)
    scale = np.sqrt(np.maximum(curvature, FLAT))
    root[counts, j] = scale / rounding.noise
    residual[counts, j] = slope / scale
    return float(cost.sum())


def _bounded_step(
    unknowns: Unknowns, state: _State, damping: float, scale: tuple[Array, list[Array]], fixed: bool
) -> tuple[Array, list[Array], float]:
    """A step that leaves out the unknowns that sit on a bound and push outwards, and shortens the rest as a whole."""
    held = np.full(len(state.values), fixed)
    for _ in range(3):
        step, owns, predicted = _step(state, damping, scale, held)
        outward = ((state.values <= unknowns.lower) & (step < 0)) | ((state.values >= unknowns.upper) & (step > 0))
        if not np.any(outward & ~held):
            break
        held = held | outward
    longest = float(np.max(np.abs(step), initial=0.0))
    if longest > LARGEST_STEP:
        share = LARGEST_STEP / longest
        step, owns, predicted = step * share, [own * share for own in owns], predicted * share
    return step, owns, predicted


def _step(
    state: _State, damping: float, scale: tuple[Array, list[Array]], held: NDArray[np.bool_]
) -> tuple[Array, list[Array], float]:
    """Damped Gauss-Newton step (p,), each trial's own (l,), and the predicted fall of the cost."""
    information = state.information
    reduced = information.common + np.diag((damping + 1e-13) * scale[0] + 1e-300)
    side = -state.gradient
    solved = []
    for cross, own, own_scale, g in zip(information.cross, information.own, scale[1], state.own_gradient, strict=True):
        damped = own + np.diag((damping + 1e-13) * own_scale + 1e-300)
        both = np.linalg.solve(damped, np.column_stack([cross.T, g]))
        reduced = reduced - cross @ both[:, :-1]
        side = side + cross @ both[:, -1]
        solved.append(both)
    step, moving = np.zeros_like(side), ~held
    if np.any(moving):
        step[moving] = np.linalg.solve(reduced[np.ix_(moving, moving)], side[moving])
    owns = [-both[:, -1] - both[:, :-1] @ step for both in solved]
    predicted = -0.5 * float(state.gradient @ step)
    predicted -= sum(0.5 * float(g @ own) for g, own in zip(state.own_gradient, owns, strict=True))
    return step, owns, predicted
