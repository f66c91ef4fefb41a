"""Rates that differ from trial to trial: what the trials' own scatter adds to the intervals.

An animal's muscles are no springs: from one release to the next, and from one animal to the next, rate and damping
differ. The fit has one of each, its mean; its covariance by the readings' noise does not know that another choice of
trials has another mean. Each trial's gradient at the common optimum shows it: of one leg it scatters as the trial's
information tells, and Cochran's Q (Biometrics 10 (1954) 101) over all trials tests that. The noise in it is that about
fits to each trial by itself: in the residuals of the common fit the difference itself is noise, which lasts, and
the larger it is the better it hides. Where the gradients scatter more, the
share of Q beyond its expectation (Higgins & Thompson, Statistics in Medicine 21 (2002) 1539) of the jackknife's
covariance over trials (Efron & Tibshirani, *An Introduction to the Bootstrap*, 1993, chapter 11), to first order, is
added, with Student's t of one degree less than trials.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array
from synth.estimation.chi_squared import chi_squared_above
from synth.estimation.f_distribution import square_above
from synth.estimation.intervals import NORMAL90, covariance_of, student95
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_problem import unknowns_of
from synth.fit.lasting_noise import noise_of_each
from synth.fit.least_squares import FitStart, Stage, reduced_by_trial, solve
from synth.fit.recordings import Recording
from synth.fit.refinement import FINE_TOLERANCE
from synth.fit.trajectories import TrajectoryModel
from synth.fit.treatments import FittedTreatments
from synth.remarks import noted
from synth.threads import shared_out

# Of Q: only a clear scatter counts, as links that are off and a misread correlation of the noise make some.
SIGNIFICANCE = 1e-4
# Of the same if nothing in the noise lasts: above it no more is asked. A choice, far above ``SIGNIFICANCE``.
AGREE = 0.01
# Of the information in a direction, that one trial is taken to have at most: where the others have none, the step
# without it has no end.
MOST_LEVERAGE = 0.75
LEAST_TOLD = 1e-30  # of a probability: smaller ones are of a size that no noise model holds to
LEAST_SHARE = 1e-6  # of the largest eigenvalue of a trial's information, below which it tells nothing in that direction


@dataclass(frozen=True)
class RateSpread:
    """``covariance`` (p, p) to add to the common unknowns' own, and the ``probability`` of such trials of one leg."""

    covariance: Array
    probability: float

    @property
    def _chance(self) -> str:
        """The probability in words: one that underflows is not none."""
        return f"p = {self.probability:.1g}" if self.probability > LEAST_TOLD else f"p < {LEAST_TOLD:.0g}"

    @property
    def sentences(self) -> list[str]:
        """The finding; none where the trials agree."""
        if not self.covariance.any():
            return []
        return [
            noted(
                f"the trials differ by more than their noise from one leg of these rates ({self._chance}): the "
                "rates differ from trial to trial, or the model lacks something. The rates given are those of all "
                "trials together, and the intervals include how much another choice of trials would move them"
            )
        ]


def spread_over_trials(
    model: TrajectoryModel,
    recordings: Sequence[Recording],
    fitted: FittedTreatments,
    name: str,
    options: LegFitOptions,
) -> RateSpread:
    """How the trials scatter about the fit of the treatment of this name.

    Nothing of a motion that is computed or followed, and of one trial; nor with weights that are no likelihood.
    """
    stage = fitted.treatments[name].stage
    computed = fitted.searched or options.wanted or options.computed or options.near is not None
    if computed or options.weight != "noise" or len(recordings) < 2:
        return RateSpread(np.zeros((len(unknowns_of(model).names),) * 2), 1.0)
    least = fitted.least if name == fitted.mode else None
    return rate_spread(model, recordings, Stage(least or stage.solution, stage.weights))


def rate_spread(model: TrajectoryModel, recordings: Sequence[Recording], stage: Stage) -> RateSpread:
    """What trials of one fit add to the rates' covariance; that of free angles is in their own spread.

    ``stage`` : at its optimum; of two trials or more.
    """
    unknowns = unknowns_of(model)
    count = len(unknowns.names)
    none = np.zeros((count, count))
    parts = reduced_by_trial(model, recordings, stage)
    if _agree_to_white_noise(parts, recordings, stage):
        return RateSpread(none, 1.0)
    noise = noise_within_trials(model, recordings, stage)
    tested = reduced_by_trial(model, recordings, Stage(stage.solution, replace(stage.weights, noise=noise)))
    rates = [unknowns.rate_at(j) for j in unknowns.rates] + [unknowns.damper_at(j) for j in unknowns.dampers]
    square, freedom = _cochran(tested)
    if freedom < 1:
        return RateSpread(none, 1.0)
    probability = chi_squared_above(freedom, square)
    if probability >= SIGNIFICANCE:
        return RateSpread(none, probability)
    trials, root = len(parts), np.linalg.cholesky(covariance_of(stage.solution.information.schur()))
    widen = (1.0 - 1.0 / trials) * (student95(trials - 1) / NORMAL90) ** 2 * (1.0 - freedom / square)
    moved = np.array([root @ _without(root.T @ matrix @ root, root.T @ gradient) for matrix, gradient in parts]).T
    held = np.setdiff1d(np.arange(count), rates)
    moved[held] = 0.0
    return RateSpread(widen * moved @ moved.T, probability)


def _cochran(parts: Sequence[tuple[Array, Array]]) -> tuple[float, int]:
    """Q of the trials' information (p, p) and gradients (p,) about their common optimum, and its degrees of freedom.

    The gradients' sum is zero at the optimum of their own weights; at that of others its own share is no difference.
    """
    square, freedom = 0.0, 0
    for matrix, gradient in parts:
        part, told = _square(matrix, gradient)
        square, freedom = square + part, freedom + told
    shared, told = _square(np.sum([m for m, _ in parts], axis=0), np.sum([g for _, g in parts], axis=0))
    return square - shared, freedom - told


def _agree_to_white_noise(parts: Sequence[tuple[Array, Array]], recordings: Sequence[Recording], stage: Stage) -> bool:
    """Whether an F test, to first order, finds no difference between trials even if nothing in the noise lasts.

    Then a noise that lasts finds none either, and need not be estimated, which takes five times as long as the fit.
    """
    square, freedom = _cochran(parts)
    predictions, noise = stage.solution.predictions, stage.weights.noise
    left = [
        ((prediction - recording.rotation) / own)[recording.counts]
        for prediction, recording, own in zip(predictions, recordings, noise, strict=True)
    ]
    starts = sum(2 * len(recording.free) for recording in recordings)
    beyond = sum(len(each) for each in left) - starts - len(parts[0][1]) - freedom
    rest = sum(float(each @ each) for each in left) - square
    if freedom < 1:
        return True  # nothing in which trials could differ
    if beyond < 1 or rest <= 0.0:
        return False  # too few samples for this test
    return square_above(freedom, square * beyond / rest, beyond) > AGREE


def _square(matrix: Array, gradient: Array) -> tuple[float, int]:
    """The gradient's (p,) square by the inverse information (p, p), and in how many directions there is some."""
    value, vector = np.linalg.eigh(matrix)
    tells = value > LEAST_SHARE * max(float(value[-1]), 1e-300)
    return float(np.sum((vector[:, tells].T @ gradient) ** 2 / value[tells])), int(tells.sum())


def noise_within_trials(model: TrajectoryModel, recordings: Sequence[Recording], stage: Stage) -> Array:
    """(n_trial, n) rad, noise of the readings about fits to each trial by itself, at most that of ``stage``.

    What the trials differ by is in the residuals of their common fit, and lasts: as noise it would hide itself.
    """
    found, weights = stage.solution, stage.weights

    def alone(t: int) -> Stage:
        centre = None if weights.centre is None else weights.centre[t : t + 1]
        own = replace(weights, noise=weights.noise[t : t + 1], centre=centre)
        start = FitStart(found.values, [found.locals[t]])
        solution = solve(model, [recordings[t]], start, own, tolerance=FINE_TOLERANCE)
        return Stage(solution, own)

    fits = shared_out(alone, len(recordings))
    if not all(np.isfinite(each.solution.cost) for each in fits):
        return weights.noise
    return np.fmin(weights.noise, noise_of_each(model, recordings, fits))


def _without(share: Array, gradient: Array) -> Array:
    """(p,) step without a trial that has this share (p, p) of the information, in units of the estimates' errors."""
    value, vector = np.linalg.eigh(share)
    return np.asarray(vector @ (vector.T @ gradient / (1.0 - np.clip(value, 0.0, MOST_LEVERAGE))))
