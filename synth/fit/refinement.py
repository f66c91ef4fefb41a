"""Refinement of a start: whole trajectories and each joint's noise, estimated alternately."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from synth.arrays import Array
from synth.fit.least_squares import HUBER, FitStart, Solution, Stage, Weights, solve
from synth.fit.recordings import Recording, relative_amplitudes
from synth.fit.rounding import Rounding, encoder_counts, rounding_of
from synth.fit.starts import drawn_starts, first_locals, quick_costs
from synth.fit.trajectories import Local, TrajectoryModel
from synth.fit.uncertainty import all_residuals, clipped_rms, correlation_of, residuals
from synth.threads import shared_out

NOISE_ROUNDS = 5  # most rounds of noise and fit; ``SAME_NOISE`` ends them earlier
SAME_NOISE = 0.02  # change of its logarithm that ends the rounds
FIRST_NOISE = 0.1  # rad, if the start's motion diverges
ROUGH_TOLERANCE, ROUGH_ITERATIONS = 3.0, 25  # tolerance on the log-likelihood before the noise is known
FINE_TOLERANCE = 0.02  # log-likelihood: a decrease that moves no estimate by more than a fifth of its deviation
NEAR_DAMPING = 1e-6  # of an iteration that starts near its optimum, as from the weak form
KEPT_STARTS = 2  # starts that are refined after screening
SCREENED_TRIALS = 5  # about the number of trials that show whether a start is useful
SCREENING_ITERATIONS, SCREENING_TOLERANCE = 12, 1.0  # of each start, only to rank them
POOR_FIT = 4.0  # times the samples' own scatter: above it other starts are tried


def refine(
    model: TrajectoryModel,
    recordings: Sequence[Recording],
    start: FitStart,
    weight: str,
    spread: Array,
    *,
    centre: Array | None = None,
    points: Array | None = None,
    rounds: int = NOISE_ROUNDS,
) -> Stage:
    """Solve, estimate each joint's noise from the residuals, and repeat until the noise is constant.

    Parameters
    ----------
    weight : noise, amplitude or equal, see ``FitOptions``.
    spread : (n,) rad of the rest angles' shifts, about zero or ``centre`` (n_trial, n) rad.
    points : (n,) rad, spread of the rest angles at static points; None: they have the common ones.
    """
    relative, counts = _relative_noise(recordings, weight), encoder_counts(recordings)
    lanes = start.lanes or shared_out(
        lambda t: model.sensitivity(recordings[t], start.values, start.locals[t]), len(recordings)
    )
    predictions = [found.prediction for found in lanes]
    noise = np.nan_to_num(clipped_rms(recordings, predictions), nan=FIRST_NOISE, posinf=FIRST_NOISE) + 1e-6
    weights = Weights(relative * noise, spread, centre, points=points)
    solution = solve(
        model, recordings, replace(start, damping=NEAR_DAMPING, lanes=lanes), weights,
        max_iterations=ROUGH_ITERATIONS, tolerance=ROUGH_TOLERANCE,
    )  # fmt: skip
    del lanes  # a copy for every trial, of which the solution keeps the small parts
    for _ in range(rounds):
        if not np.isfinite(solution.cost):
            break
        found, rounding = _noise(recordings, solution.predictions, weight, counts)
        change = np.abs(np.log(found / noise)).max()
        noise = found
        weights = Weights(relative * noise, spread, centre, rounding, points)
        solution = solve(
            model, recordings, replace(FitStart.at(solution), damping=min(solution.damping, NEAR_DAMPING)), weights,
            tolerance=FINE_TOLERANCE,
        )  # fmt: skip
        if change < SAME_NOISE:
            break
    return Stage(solution, weights)


def error_ratios(model: TrajectoryModel, recordings: Sequence[Recording], stage: Stage) -> Array:
    """(n_trial, n) variance of the readings' errors over the one that the cost of ``stage`` assumes.

    1 where it weighs by the noise; else the weights are not likelihoods. Errors that last from sample to sample count
    as in the noise. They are what a fit weighed by the noise leaves: a joint that counts little beside a noisier one
    keeps the errors of the estimates in its residuals, which last and would pass for noise.
    """
    weights = stage.weights
    centre, points = weights.centre, weights.points
    weighed = refine(
        model, recordings, FitStart.at(stage.solution), "noise", weights.spread, centre=centre, points=points
    )
    # Where that fit diverges the residuals of this one are larger: the interval is then too wide, not too narrow.
    best = weighed if np.isfinite(weighed.solution.cost) else stage
    found, _ = _noise(recordings, best.solution.predictions, "amplitude", encoder_counts(recordings))
    return np.asarray((found / weights.noise) ** 2)


def _noise(
    recordings: Sequence[Recording], predictions: Sequence[Array], weight: str, counts: Array
) -> tuple[Array, tuple[Rounding | None, ...]]:
    """(n_trial, n) rad noise of each joint from its residuals, and the treatment of coarser counts (n,) rad.

    Correlated residuals carry less information: their noise is enlarged, so that the cost remains a
    log-likelihood with the right weight against the spread of the shifts and the prior. Trials of one sample step have
    one noise: the denser the samples, the more they are correlated.
    """
    off = [residuals(r, p) for r, p in zip(recordings, predictions, strict=True)]
    rounding: list[Rounding | None] = [None] * len(counts)
    if weight == "noise":
        rounding = [rounding_of(np.concatenate([each[:, j] for each in off]), w) for j, w in enumerate(counts)]
    whitened = [all_residuals(r, p) for r, p in zip(recordings, predictions, strict=True)]
    for j, item in enumerate(rounding):
        if item is not None:
            for each in whitened:
                each[:, j] = item.surprise(each[:, j], HUBER)
    times = correlation_of(recordings, whitened)
    found = clipped_rms(recordings, predictions) * np.sqrt(times)
    found = np.where(np.isfinite(found), found, 1.0) + 1e-7
    if weight == "equal":
        found = np.sqrt(np.mean(found**2, axis=1, keepdims=True)) * np.ones(found.shape[1])
    for j, item in enumerate(rounding):
        if item is not None:
            found[:, j] = item.noise * np.sqrt(times[:, j])
    return found, tuple(rounding)


def _relative_noise(recordings: Sequence[Recording], weight: str) -> Array:
    """(n_trial, n) factor on each joint's noise: one, or each trial's amplitude over its mean."""
    if weight != "amplitude":
        return np.ones((len(recordings), recordings[0].rotation.shape[1]))
    return relative_amplitudes(recordings)


def refine_other_starts(
    model: TrajectoryModel,
    recordings: Sequence[Recording],
    best: Stage,
    scatter: Array,
    spread: Array,
    *,
    weight: str,
    seed: int,
) -> Stage:
    """The given stage if it comes near the samples' scatter; else the best of it and of a few natural starts.

    The weak form may lead to the wrong minimum; a start is screened on a few trials before it is refined.
    """
    rms = clipped_rms(recordings, best.solution.predictions)
    if np.all((rms < POOR_FIT * scatter) | ~np.isfinite(scatter)):
        return best
    drawn = drawn_starts(model, recordings, seed)
    every = max(1, len(recordings) // SCREENED_TRIALS)
    some, weights = recordings[::every], replace(best.weights, noise=best.weights.noise[::every])
    order = np.argsort(quick_costs(model, some, drawn), kind="stable")

    def screened(values: Array, locals_: Sequence[Local]) -> Solution:
        return solve(
            model, some, FitStart(values, locals_), weights,
            max_iterations=SCREENING_ITERATIONS, tolerance=SCREENING_TOLERANCE,
        )  # fmt: skip

    here = screened(best.solution.values, best.solution.locals[::every])
    for k in order[:KEPT_STARTS]:
        found = screened(drawn[k], first_locals(some))
        if found.cost < here.cost - 1.0:
            refined = refine(model, recordings, FitStart(found.values, first_locals(recordings)), weight, spread)
            if np.isfinite(refined.solution.cost) and misfit(recordings, refined) < misfit(recordings, best):
                best = refined
    return best


def misfit(recordings: Sequence[Recording], stage: Stage) -> float:
    """Sum over joints of the log RMS, the likelihood with each joint's noise estimated from its residual."""
    return float(np.nansum(np.log(clipped_rms(recordings, stage.solution.predictions) + 1e-12)))
