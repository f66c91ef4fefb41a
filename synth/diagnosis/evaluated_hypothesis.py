"""A hypothesis about the causes of a gap at one point: its unknowns, residuals and cost."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from synth.arrays import Array
from synth.diagnosis.effect_shape import shape_places
from synth.diagnosis.lanes import Hypothesis
from synth.estimation.linearisation import Linearisation


@dataclass(frozen=True)
class EvaluatedHypothesis:
    """A hypothesis at one point.

    ``unknowns`` (p + n_effect,); ``states`` (2 n,) per trial, or with those of compliant links, see ``Block``;
    ``residuals`` (M,) per trial, whitened, followed by the states' prior; ``columns`` (M, n_effect) per trial, whitened
    derivatives by the effect's unknowns; ``cost`` a log-likelihood.
    """

    hypothesis: Hypothesis
    unknowns: Array
    states: tuple[Array, ...]
    residuals: tuple[Array, ...] = ()
    columns: tuple[Array, ...] = ()
    cost: float = np.inf
    damping: float = 1e-3
    done: bool = False
    frame: Linearisation | None = field(default=None, repr=False)

    def at(self, unknowns: Array) -> EvaluatedHypothesis:
        """The hypothesis with other unknowns, for predictions."""
        return replace(self, unknowns=unknowns)

    @property
    def keys(self) -> tuple[tuple[str, str], ...]:
        """Effect and place of each candidate."""
        return tuple(candidate.key for candidate in self.hypothesis)

    @cached_property
    def shapes(self) -> Array:
        """(n, 2), see ``hypotheses.FittedHypothesis``; without derivatives, or where they diverge, fully determined."""
        first = len(self.unknowns) - sum(cause.size for cause in self.hypothesis)
        places = shape_places(self.hypothesis)
        values = self.unknowns[[first + place for place in places]]
        if not self.columns:
            return np.column_stack([values, np.full(len(places), np.inf)])
        parts = self.frame.trials if self.frame is not None else [None] * len(self.columns)
        changes = np.zeros(len(places))
        for part, columns in zip(parts, self.columns, strict=True):
            rows = columns.T[places]
            changes += np.sum((rows if part is None else part.project(rows)) ** 2, axis=1)
        squares = sum(float(residual @ residual) for residual in self.residuals)
        curvature = np.where(np.isfinite(changes), changes, np.inf) / squares
        return np.column_stack([values, curvature])
