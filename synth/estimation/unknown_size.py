"""Residuals of unknown size: a multivariate t, of which the noise is the least.

``N log(1 + squares / N)`` for whitened residuals with ``N`` independent ones, a multivariate t with ``N`` degrees of
freedom (Lange, Little & Taylor, J. Am. Stat. Assoc. 84 (1989) 881): least squares at the noise; far above it twice the
``N/2 log(squares)`` of residuals of unknown size. Beside it stands half the square of unknowns with standard normal
priors.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from synth.arrays import Array

S = TypeVar("S", float, Array)


@dataclass(frozen=True)
class UnknownSize:
    """Of residuals whose size is not known, so many of them ``independent``."""

    independent: float

    def cost(self, squares: float, unknowns: Array) -> float:
        """Cost of a whitened sum of squares and of whitened unknowns (p,)."""
        return self.independent * float(np.log1p(squares / self.independent)) + 0.5 * float(unknowns @ unknowns)

    def costs(self, squares: Array, unknowns: Array) -> Array:
        """(n,) as ``cost``, of squares (n,) and unknowns (n, p)."""
        prior = np.einsum("fp,fp->f", unknowns, unknowns)
        return np.asarray(self.independent * np.log1p(squares / self.independent) + 0.5 * prior)

    def weight(self, squares: S) -> S:
        """Weight of half the sum of squares in the normal equations: twice the cost's derivative by the squares."""
        return 2.0 / (1.0 + squares / self.independent)
