"""The uncertainty of a fit whose joints' readings err together, or are weighed otherwise than by their noise.

Tracked points do err together: one point moves the angles of both joints beside it, and a knee's angle is a difference
of two directions. The covariance of the estimates is then C M C, C the inverse of the information and M the sum of
S' V S over the samples, S their weighted sensitivities and V the covariance of the joints' weighted residuals: their
correlation, where each joint is weighed by its own noise (the sandwich of Huber, *Proc. 5th Berkeley Symposium* 1
(1967) 221). With ``weight: amplitude`` or ``equal`` the variances differ from 1 too.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synth.arrays import Array
from synth.estimation.intervals import covariance_of
from synth.fit.following import weighted_sensitivities
from synth.fit.least_squares import Stage
from synth.fit.recordings import Recording
from synth.fit.refinement import error_ratios
from synth.fit.trajectories import TrajectoryModel
from synth.fit.uncertainty import covariance


def spread_of(model: TrajectoryModel, recordings: Sequence[Recording], stage: Stage, weight: str = "noise") -> Array:
    """Covariance (p, p) of the common unknowns by the readings' errors, of which a joint's go with another's.

    ``weight`` of the fit, see ``FitOptions``.

    Raises
    ------
    UserError : the simulation diverges at the solution.
    """
    spread = covariance(model, stage.solution)
    n = recordings[0].rotation.shape[1]
    if n < 2 and weight == "noise":
        return spread
    solution, count = stage.solution, len(stage.solution.values)
    found = weighted_sensitivities(model, recordings, stage)
    left = [
        root * np.where(recording.counts, prediction - recording.rotation, 0.0)
        for (_, root), recording, prediction in zip(found, recordings, solution.predictions, strict=True)
    ]
    ratios = np.ones((len(recordings), n)) if weight == "noise" else error_ratios(model, recordings, stage)
    together, middle, information = _correlations(left), np.zeros_like(spread), solution.information
    for (slopes, _), cross, own, ratio in zip(found, information.cross, information.own, ratios, strict=True):
        apart = together * np.sqrt(np.outer(ratio, ratio)) - np.eye(n)
        common = slopes[:, :, :count] - slopes[:, :, count:] @ np.linalg.solve(own, cross.T)
        middle += np.einsum("mjp,jk,mkq->pq", common, apart, common, optimize=True)
    inverse = covariance_of(information.schur())
    return np.asarray(spread + inverse @ middle @ inverse)


def _correlations(left: Sequence[Array]) -> Array:
    """(n, n) of weighted residuals (m, n) of each trial about zero; of joints that are never seen together 0."""
    stacked = np.concatenate(left)
    seen = (stacked != 0.0).astype(float)
    size = np.sqrt(np.maximum((stacked**2).T @ seen * ((stacked**2).T @ seen).T, 1e-300))
    found = stacked.T @ stacked / size
    np.fill_diagonal(found, 1.0)
    return np.asarray(found)
