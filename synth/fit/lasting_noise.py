"""How far noise that lasts moves the free angle of a single trial.

A trial's own unknowns (initial angle and rate, shift of the free angle) follow what is slow in its noise, so that the
residuals show less of it than there is: in a recording of ten times the noise's correlation time, a third. The noise is
therefore estimated by the likelihood of the residuals apart from all that these unknowns can take up (restricted
maximum likelihood: Patterson & Thompson, Biometrika 58 (1971) 545), as the sum of a part whose correlation falls
exponentially and a white one (Ornstein-Uhlenbeck with a nugget), on means over short pieces of the recordings. A
variance is its mean over the noises that this likelihood leaves open, because a short recording does not tell how long
its noise lasts.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.fit.following import weighted_sensitivities
from synth.fit.least_squares import Stage
from synth.fit.recordings import Recording
from synth.fit.trajectories import TrajectoryModel

PIECES = 60  # of a recording, whose means are compared: an exponential of a tenth of it is seen in six of them
MOST_TRIALS = 20  # from which the noise is estimated: its correlation is then known to some 10 %
TIMES = 8  # correlation times that are tried, from a piece to half of the recording: each 1.6 times the one before
WHITE_SHARES = (0.0, 0.1, 1.0, 10.0, 1e3)  # variance of a sample's white noise over the lasting part's; last: white
NEGLIGIBLE = 1e-3  # probability of a noise that moves no variance by as much as it is known
OWN = 3  # unknowns of a joint in a trial: initial angle, initial rate, shift
LEAST_LEFT = 5  # pieces beyond the unknowns of a fit to one trial: of fewer its residuals hardly show a noise
RANK = 1e-9  # of the largest: smaller directions of these are one


@dataclass(frozen=True)
class _Noise:
    """Its ``probability``; of the lasting part ``lasts`` s and ``variance`` rad^2; ``white`` over that variance."""

    probability: float
    lasts: float
    white: float
    variance: float


@dataclass(frozen=True)
class _Pieces:
    """One joint in one trial: ``time`` (k,) s, number of samples ``count`` (k,), and means over the pieces.

    ``left`` (k,) of the residuals, and ``columns`` (k, 3) of their derivatives by the joint's own unknowns; ``fitted``
    (k, c) of those by all unknowns that were fitted to this trial alone, none if it was fitted with others.
    """

    time: Array
    count: Array
    left: Array
    columns: Array
    fitted: Array

    def covariance(self, lasts: float, white: float) -> Array:
        """(k, k) of the means for a lasting part of variance one and correlation time ``lasts`` s."""
        apart = np.abs(self.time[:, None] - self.time[None])
        return np.asarray(np.exp(-apart / lasts) + np.diag(white / self.count))

    def likelihood_parts(self, lasts: float, white: float) -> tuple[float, float, int]:
        """Log-determinants, weighted square of what the columns leave, and its degrees of freedom."""
        root = np.linalg.cholesky(self.covariance(lasts, white))
        both = np.linalg.solve(root, np.column_stack([self.left, self.columns, self.fitted]))
        basis, sizes, _ = np.linalg.svd(both[:, 1:], full_matrices=False)
        basis = basis[:, sizes > RANK * sizes[0]]
        rest = both[:, 0] - basis @ (basis.T @ both[:, 0])
        determinants = 2.0 * float(np.log(np.diag(root)).sum() + np.log(sizes[sizes > RANK * sizes[0]]).sum())
        return determinants, float(rest @ rest), len(rest) - basis.shape[1]

    def shift_variance(self, lasts: float, white: float) -> float:
        """Variance of the shift by least squares of weights ``count``, for a lasting part of variance one."""
        weighted = self.columns * self.count[:, None]
        inverse = np.linalg.pinv(self.columns.T @ weighted, rcond=RANK, hermitian=True)
        return float((inverse @ (weighted.T @ self.covariance(lasts, white) @ weighted) @ inverse)[-1, -1])

    @property
    def white_shift_variance(self) -> float:
        """The same for white noise of variance one."""
        weighted = self.columns * self.count[:, None]
        return float(np.linalg.pinv(self.columns.T @ weighted, rcond=RANK, hermitian=True)[-1, -1])


def lasting_variances(model: TrajectoryModel, recordings: Sequence[Recording], stage: Stage, variances: Array) -> Array:
    """Variances (n_trial, n) rad^2 of the shifts of ``stage``, whose noise counts as correlated as residuals show it.

    ``variances`` (n_trial, n) rad^2 are those by the stage's own noise, nan where there is none; none becomes less.
    """
    found = variances.copy()
    slopes = weighted_sensitivities(model, recordings, stage)
    for j in range(variances.shape[1]):
        seen = [t for t in range(len(recordings)) if np.isfinite(variances[t, j])]
        pieces = {t: _pieces(model, recordings[t], stage, slopes[t], t, j) for t in seen}
        for t, variance in _as_white(pieces).items():
            found[t, j] = variances[t, j] * max(1.0, variance / float(stage.weights.noise[t, j]) ** 2)
    return found


def noise_of_each(model: TrajectoryModel, recordings: Sequence[Recording], alone: Sequence[Stage]) -> Array:
    """(n_trial, n) rad, of the noise in fits to each trial ``alone``; nan where its samples are too few to tell.

    As of a white noise by which a shift of the free angle is as uncertain. What all unknowns of such a fit take up is
    no part of the residuals.
    """
    found = np.full((len(recordings), recordings[0].rotation.shape[1]), np.nan)
    slopes = [
        weighted_sensitivities(model, [recording], stage)[0] for recording, stage in zip(recordings, alone, strict=True)
    ]
    for j in range(found.shape[1]):
        seen = [t for t, recording in enumerate(recordings) if recording.counts[:, j].any()]
        pieces = {t: _pieces(model, recordings[t], alone[t], slopes[t], 0, j, alone=True) for t in seen}
        for t, variance in _as_white(pieces).items():
            found[t, j] = np.sqrt(variance)
    return found


def _as_white(pieces: Mapping[int, _Pieces | None]) -> dict[int, float]:
    """By trial, rad^2, variance of a sample's white noise by which its shift is as uncertain; of too few samples none.

    ``pieces`` : of one joint, by trial.
    """
    usable = {t: each for t, each in pieces.items() if each is not None}
    if not usable:
        return {}
    every = max(1, len(usable) // MOST_TRIALS)
    noises = _noises(list(usable.values())[::every])
    return {
        t: sum(n.probability * n.variance * each.shift_variance(n.lasts, n.white) for n in noises)
        / each.white_shift_variance
        for t, each in usable.items()
    }


def taken_up(model: TrajectoryModel, recordings: Sequence[Recording], stage: Stage) -> Array:
    """(n_trial, n) factor >= 1 on the variance of the noise of ``stage``, by what lasts in it beyond its residuals."""
    seen = np.array([recording.counts.any(axis=0) for recording in recordings])
    return np.where(seen, lasting_variances(model, recordings, stage, np.where(seen, 1.0, np.nan)), 1.0)


def _noises(pieces: Sequence[_Pieces]) -> list[_Noise]:
    """What the noise may be, each with its probability where all that are tried are alike probable beforehand."""
    step = float(np.median([np.median(np.diff(each.time)) for each in pieces]))
    longest = 0.5 * max(float(np.ptp(each.time)) for each in pieces)
    tried, criteria = [], []
    for lasts in np.geomspace(step, longest, TIMES).tolist():
        for white in WHITE_SHARES:
            parts = [each.likelihood_parts(lasts, white) for each in pieces]
            determinants, square, freedom = (float(sum(column)) for column in zip(*parts, strict=True))
            tried.append((lasts, white, square / freedom))
            criteria.append(determinants + freedom * float(np.log(square / freedom)))
    weights = np.exp(-0.5 * (np.array(criteria) - min(criteria)))
    weights /= weights.sum()
    return [_Noise(float(w), *each) for w, each in zip(weights, tried, strict=True) if w > NEGLIGIBLE]


def _pieces(
    model: TrajectoryModel,
    recording: Recording,
    stage: Stage,
    found: tuple[Array, Array],
    trial: int,
    j: int,
    *,
    alone: bool = False,
) -> _Pieces | None:
    """The pieces of one joint in one trial; None of too few samples for its own unknowns, or ``alone`` for all."""
    slopes, root = found
    free, first = len(recording.free), len(stage.solution.values)
    place = recording.free.index(j)
    columns = [first + place, first + free + place, first + 2 * free + model.shifted(recording).index(j)]
    used = recording.counts[:, j] & (root[:, j] > 0.0)
    if int(used.sum()) < 4 * OWN:
        return None
    time, own = recording.time[used], slopes[used, j] / root[used, j, None]
    left = (stage.solution.predictions[trial] - recording.rotation)[used, j]
    number = np.minimum((PIECES * (time - time[0]) / (time[-1] - time[0])).astype(int), PIECES - 1)
    _, number, count = np.unique(number, return_inverse=True, return_counts=True)

    def means(value: Array) -> Array:
        return np.asarray(np.bincount(number, value) / count)

    stacked = np.stack([means(column) for column in own[:, columns].T], axis=1)
    stacked /= np.linalg.norm(stacked, axis=0).max()
    fitted = np.zeros((len(count), 0))
    if alone:
        every = np.stack([means(column) for column in own.T], axis=1)
        sizes = np.linalg.norm(every, axis=0)
        fitted = every[:, sizes > 0.0] / sizes[sizes > 0.0]
        if len(count) < fitted.shape[1] + LEAST_LEFT:
            return None
    return _Pieces(means(time), count.astype(float), means(left), stacked, fitted)
