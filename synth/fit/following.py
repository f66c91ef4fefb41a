"""How the estimates follow a small change of the model, and what of its motion they cannot follow.

The change of each trial's prediction with the unknowns held is given; those of the estimates follow from the
sensitivities of the trajectories (``estimation.consider``), without refits.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array, Mask
from synth.estimation.consider import Considered, Coupling, consider
from synth.fit.diverged_fit import divergence_refused
from synth.fit.least_squares import Solution, Stage, Weights, resimulated, sample_weights
from synth.fit.recordings import Recording
from synth.fit.trajectories import Sensitivity, TrajectoryModel
from synth.threads import shared_out


@dataclass(frozen=True)
class FollowedChanges:
    """``considered`` : of the common unknowns (p, c). A trial each: ``own`` (l, c) change of its own unknowns, and
    ``left`` (k, n, c) rad of the prediction of its samples asked for, all unknowns following.
    """

    considered: Considered
    own: tuple[Array, ...]
    left: tuple[Array, ...]


@dataclass(frozen=True)
class _ChangedTrial:
    """Its ``coupling``; of the samples asked for ``moved`` (k, n, c), and ``slopes`` (k, n, p + l) by its unknowns."""

    coupling: Coupling
    moved: Array
    slopes: Array


def follow_changes(
    model: TrajectoryModel,
    recordings: Sequence[Recording],
    stage: Stage,
    change: Callable[[int], Array],
    asked: Callable[[Recording], Mask],
    beside: Array | None = None,
) -> FollowedChanges:
    """The estimates of ``stage`` after each of c changes of the model.

    Parameters
    ----------
    change : trial -> (m, n, c) rad, of its prediction, the unknowns held.
    asked : recording -> (m,) the samples whose remaining change is wanted.
    beside : (p, c) change of the gradient by measurements other than trials.
    """
    stage = resimulated(model, recordings, stage, 0.0)
    solution, weights, n_common = stage.solution, stage.weights, len(stage.solution.values)
    information = solution.information
    lanes = _lanes(model, recordings, solution)

    def one(t: int) -> _ChangedTrial:
        recording, moved = recordings[t], change(t)
        both, root = _slopes(lanes[t], recording, weights, t)
        product = _flat(both, root).T @ _flat(moved, root)
        some = asked(recording)
        return _ChangedTrial(Coupling(product[:n_common], product[n_common:]), moved[some], both[some])

    trials = shared_out(one, len(recordings))
    couplings = [trial.coupling for trial in trials]
    with divergence_refused():
        considered = consider(information, couplings, beside)
    own = tuple(considered.own(information, couplings))
    left = (
        trial.moved + trial.slopes @ np.concatenate([considered.sensitivity, mine])
        for trial, mine in zip(trials, own, strict=True)
    )
    return FollowedChanges(considered, own, tuple(left))


def _flat(slopes: Array, root: Array) -> Array:
    """(k n, c), weighted."""
    return np.asarray((slopes * root[:, :, None]).reshape(root.size, -1))


def weighted_sensitivities(
    model: TrajectoryModel, recordings: Sequence[Recording], stage: Stage
) -> list[tuple[Array, Array]]:
    """Of each trial, the weighted derivatives (m, n, p + l) of its angles, and the weights (m, n) 1/rad."""
    lanes = _lanes(model, recordings, stage.solution)

    def one(t: int) -> tuple[Array, Array]:
        both, root = _slopes(lanes[t], recordings[t], stage.weights, t)
        return both * root[:, :, None], root

    return shared_out(one, len(recordings))


def _lanes(model: TrajectoryModel, recordings: Sequence[Recording], solution: Solution) -> Sequence[Sensitivity]:
    return solution.lanes or shared_out(
        lambda t: model.sensitivity(recordings[t], solution.values, solution.locals[t]), len(recordings)
    )


def _slopes(found: Sensitivity, recording: Recording, weights: Weights, trial: int) -> tuple[Array, Array]:
    """The derivatives (m, n, p + l) of a trial's angles by common and own unknowns, and the weights (m, n) 1/rad."""
    both = (found.differences() / found.plan.width)[:, :, found.plan.order]
    return both, sample_weights(recording, found.prediction, weights.noise[trial], weights.rounding)
