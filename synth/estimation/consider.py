"""Consider covariance: the uncertainty that estimates inherit from numbers that are held fixed but not known exactly.

An estimate that minimises a cost at fixed numbers c moves with them by S = -H^-1 d(gradient)/dc, H the information with
each trial's own unknowns eliminated. With whitened c (standard normal) the covariance grows by S S^T. The Gauss-Newton
terms are kept on both sides, as in H itself. Source: Tapley, Schutz & Born, *Statistical Orbit Determination* (2004),
section 6.2, consider covariance analysis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.estimation.intervals import spectrum
from synth.estimation.normal_equations import Information


@dataclass(frozen=True)
class Coupling:
    """One trial's second derivatives of the cost by considered numbers: ``common`` (p, c) and ``own`` (l, c)."""

    common: Array
    own: Array


@dataclass(frozen=True)
class Considered:
    """``sensitivity`` (p, c): how far each estimate moves for one standard deviation of each considered number."""

    sensitivity: Array

    @property
    def covariance(self) -> Array:
        """(p, p) that the considered numbers add."""
        return np.asarray(self.sensitivity @ self.sensitivity.T)

    def shares(self, covariance: Array) -> Array:
        """(p, c) of each estimate's variance, that each number brings; ``covariance`` (p, p) without them."""
        total = np.diag(covariance) + np.sum(self.sensitivity**2, axis=1)
        return np.asarray(self.sensitivity**2 / np.maximum(total, 1e-300)[:, None])


def consider(information: Information, couplings: Sequence[Coupling], beside: Array | None = None) -> Considered:
    """Sensitivity of the common unknowns to considered numbers.

    Parameters
    ----------
    information : at the estimate, priors included.
    couplings : a trial each, in the order of ``information.own``.
    beside : (p, c) what measurements beside the trials add to the common unknowns' derivative.
    """
    summed = np.zeros((len(information.common), couplings[0].common.shape[1])) if beside is None else beside.copy()
    for coupling, cross, own in zip(couplings, information.cross, information.own, strict=True):
        summed += coupling.common - cross @ np.linalg.solve(own, coupling.own)
    schur = information.schur()
    root = np.sqrt(np.maximum(np.diag(schur), 1e-12))
    value, vector = spectrum(schur, root)
    scaled = vector.T @ (summed / root[:, None])
    return Considered(np.asarray(-(vector / np.maximum(value, 1e-12)) @ scaled / root[:, None]))
