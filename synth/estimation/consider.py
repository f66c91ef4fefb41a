"""Consider covariance: uncertainty of estimates due to fixed parameters that are not known exactly.

An estimate that minimises a cost at fixed parameters c changes with them by S = -H^-1 d(gradient)/dc, H the information
with each trial's own unknowns eliminated. With whitened c (standard normal) the covariance grows by S S^T. The
Gauss-Newton terms are kept on both sides, as in H itself. Source: Tapley, Schutz & Born, *Statistical Orbit
Determination* (2004), section 6.2, consider covariance analysis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.estimation.intervals import covariance_of
from synth.estimation.normal_equations import Information


@dataclass(frozen=True)
class Coupling:
    """Second derivatives of one trial's cost by considered parameters: ``common`` (p, c) and ``own`` (l, c)."""

    common: Array
    own: Array


@dataclass(frozen=True)
class Considered:
    """``sensitivity`` (p, c): change of each estimate per standard deviation of each considered parameter."""

    sensitivity: Array

    @property
    def covariance(self) -> Array:
        """(p, p) covariance added by the considered parameters."""
        return np.asarray(self.sensitivity @ self.sensitivity.T)

    def own(self, information: Information, couplings: Sequence[Coupling]) -> list[Array]:
        """(l, c) a trial, change of its own unknowns, per standard deviation too."""
        return [
            np.asarray(-np.linalg.solve(own, coupling.own + cross.T @ self.sensitivity))
            for coupling, cross, own in zip(couplings, information.cross, information.own, strict=True)
        ]


def consider(information: Information, couplings: Sequence[Coupling], beside: Array | None = None) -> Considered:
    """Sensitivity of the common unknowns to considered parameters.

    Parameters
    ----------
    information : at the estimate, priors included.
    couplings : one per trial, in the order of ``information.own``.
    beside : (p, c) contribution of measurements other than trials to the derivative of the common unknowns.

    Raises
    ------
    NotFiniteError : the information is not finite.
    """
    summed = np.zeros((len(information.common), couplings[0].common.shape[1])) if beside is None else beside.copy()
    for coupling, cross, own in zip(couplings, information.cross, information.own, strict=True):
        summed += coupling.common - cross @ np.linalg.solve(own, coupling.own)
    return Considered(np.asarray(-covariance_of(information.schur()) @ summed))
