"""A hypothesis about the causes of a gap at one point: its unknowns, residuals and cost."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np

from synth.arrays import Array
from synth.diagnosis.effect_shape import ShapedEffect, shape_places, unknown_slices
from synth.diagnosis.lanes import Hypothesis
from synth.estimation.linearisation import Linearisation

FIRST_DAMPING = 1e-3  # of a fit's first step, in units of the curvature


@dataclass(frozen=True)
class EvaluatedHypothesis:
    """A hypothesis at one point.

    ``unknowns`` (p + n_effect,); ``states`` (2 n,) per trial, or with those of compliant links, see ``Block``;
    ``residuals`` (M,) per trial, whitened, followed by the states' prior; ``columns`` (M, n_effect) per trial, whitened
    derivatives by the effect's unknowns; ``cost`` a log-likelihood.

    What was computed holds at this point only: elsewhere, or with other causes, it starts by ``start_at``.
    """

    hypothesis: Hypothesis
    unknowns: Array
    states: tuple[Array, ...]
    residuals: tuple[Array, ...] = ()
    columns: tuple[Array, ...] = ()
    cost: float = np.inf
    damping: float = FIRST_DAMPING
    done: bool = False
    frame: Linearisation | None = field(default=None, repr=False)

    def start_at(
        self,
        *,
        hypothesis: Hypothesis | None = None,
        unknowns: Array | None = None,
        states: Sequence[Array] | None = None,
        frame: Linearisation | None = None,
    ) -> Self:
        """A start elsewhere, not evaluated: what is not given stays, and nothing that was computed here.

        ``frame`` : derivatives to begin with, of a point nearby.
        """
        return replace(
            self,
            hypothesis=self.hypothesis if hypothesis is None else hypothesis,
            unknowns=self.unknowns if unknowns is None else unknowns,
            states=self.states if states is None else tuple(states),
            residuals=(),
            columns=(),
            cost=np.inf,
            damping=FIRST_DAMPING,
            done=False,
            frame=frame,
        )

    def at(self, unknowns: Array) -> Self:
        """The hypothesis with other unknowns, for predictions."""
        return self.start_at(unknowns=unknowns)

    def without(self, k: int) -> Self:
        """A start without the cause ``k``; the others' unknowns stay."""
        rest = (*self.hypothesis[:k], *self.hypothesis[k + 1 :])
        return self.start_at(hypothesis=rest, unknowns=np.delete(self.unknowns, self.slices[k]))

    def with_cause(self, k: int, other: ShapedEffect, point: Array) -> Self:
        """A start with another cause, at its unknowns ``point`` (size,), in the place of the cause ``k``."""
        place = self.slices[k]
        unknowns = np.concatenate([self.unknowns[: place.start], point, self.unknowns[place.stop :]])
        hypothesis = (*self.hypothesis[:k], other, *self.hypothesis[k + 1 :])
        return self.start_at(hypothesis=hypothesis, unknowns=unknowns)

    def beside(
        self, causes: Sequence[ShapedEffect], points: Sequence[Array], frame: Linearisation | None = None
    ) -> Self:
        """A start with further causes, last, at these unknowns (size,) of each; ``frame`` as in ``start_at``."""
        unknowns = np.concatenate([self.unknowns, *points])
        return self.start_at(hypothesis=(*self.hypothesis, *causes), unknowns=unknowns, frame=frame)

    def strengthened(self, factor: float) -> Array:
        """(n,) unknowns with every cause's strengths multiplied by a positive factor."""
        unknowns = self.unknowns.copy()
        for cause, place in zip(self.hypothesis, self.slices, strict=True):
            unknowns[place] = cause.strengthened(unknowns[place], factor)
        return unknowns

    @property
    def n_tolerance(self) -> int:
        """Number of tolerance unknowns, the first of all."""
        return len(self.unknowns) - sum(cause.size for cause in self.hypothesis)

    @property
    def slices(self) -> list[slice]:
        """Places of each cause's unknowns."""
        return unknown_slices(self.hypothesis, self.n_tolerance)

    @property
    def keys(self) -> tuple[tuple[str, str], ...]:
        """Effect and place of each candidate."""
        return tuple(candidate.key for candidate in self.hypothesis)

    @cached_property
    def shapes(self) -> Array:
        """(n, 2), see ``hypotheses.FittedHypothesis``; without derivatives, or where they diverge, fully determined."""
        first = self.n_tolerance
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
        return shaped(values, changes, squares)


def shaped(values: Array, changes: Array, squares: float) -> Array:
    """(n, 2) as ``FittedHypothesis.shapes``: values (n,), squared changes (n,) of all residuals, residuals' squares."""
    return np.column_stack([values, np.where(np.isfinite(changes), changes, np.inf) / squares])
