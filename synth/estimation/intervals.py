"""Values with their 90 % intervals, and covariances from information."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.errors import UserError
from synth.units import quantity

NORMAL90 = 1.6448536269514722  # half-width of a 90 % normal interval in standard deviations: the normal's 95 % point
NULL = 1e-12  # information, as a share of its diagonal, below which a direction counts as not measured at all
DIVERGED = (
    "the fit ended where the simulated motion diverges, so nothing is known of its uncertainty. Check the leg file's "
    "units and signs, and leave recordings out one by one: `synth fit` names those that do not fit"
)


@dataclass(frozen=True)
class Estimate:
    """A value with its 90 % interval, SI; ``unit`` is what it is written in."""

    value: float
    unit: str
    low: float | None = None
    high: float | None = None

    def as_json(self) -> dict[str, Any]:
        """``{"value", "unit", "interval90"}``."""
        interval = None if self.low is None or self.high is None else (self.low, self.high)
        return quantity(self.value, self.unit, interval)


def spectrum(matrix: Array, scale: Array | float = 1.0) -> tuple[Array, Array]:
    """Eigenvalues (p,) and eigenvectors (p, p) of a symmetric matrix of a fit, divided by ``scale`` (p,) on both sides.

    Raises
    ------
    UserError : it is not finite, so nothing is known of the fit there; ``eigh`` would fail or return anything.
    """
    if not np.isfinite(matrix).all():
        raise UserError(DIVERGED)
    value, vector = np.linalg.eigh(matrix / np.outer(scale, scale))
    return np.asarray(value), np.asarray(vector)


def covariance_of(information: Array) -> Array:
    """(p, p) inverse of an information matrix; null directions get a huge variance instead of an error.

    Raises
    ------
    UserError : it is not finite.
    """
    root = np.sqrt(np.maximum(np.diag(information), NULL))
    value, vector = spectrum(information, root)
    return np.asarray((vector / np.maximum(value, NULL)) @ vector.T / np.outer(root, root))
