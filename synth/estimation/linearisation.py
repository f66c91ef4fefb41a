"""Derivatives of all trials at one point by common and per-trial unknowns, shared by many hypotheses.

A cause changes a leg's motion little, so the derivatives by the shared unknowns are computed once and used for many
fits. Each trial's own unknowns are eliminated by an orthogonal projection (variable projection: Golub & Pereyra, SIAM
J. Numer. Anal. 10 (1973) 413), which is cheaper than a Schur complement if the projected derivatives are stored.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from synth.arrays import Array
from synth.estimation.normal_equations import OwnGroup, ReducedNormal


@dataclass(frozen=True)
class TrialLinearisation:
    """One trial's whitened derivatives: ``common`` (M, p), and QR factors ``q`` (M, l), ``r`` (l, l) of its own
    unknowns.

    Rows of the prior of the trial's own unknowns follow those of the samples.
    """

    common: Array
    q: Array
    r: Array

    @cached_property
    def along(self) -> Array:
        """(l, p) components of the common derivatives in the span of the trial's own."""
        return np.asarray(self.q.T @ self.common)

    @cached_property
    def projected(self) -> Array:
        """(M, p) the common derivatives without those components."""
        return np.asarray(self.common - self.q @ self.along)

    @cached_property
    def products(self) -> Array:
        """(p, p) inner products of the projected derivatives."""
        return np.asarray(self.projected.T @ self.projected)

    def project(self, rows: Array) -> Array:
        """Residuals (M,) or (n, M) projected off the span of the trial's own unknowns."""
        return np.asarray(rows - (rows @ self.q) @ self.q.T)


@dataclass(frozen=True)
class Linearisation:
    """Derivatives of all trials at one point."""

    trials: tuple[TrialLinearisation, ...]

    @cached_property
    def _trials_by_size(self) -> list[tuple[list[int], Array, Array]]:
        """Trials grouped by number of own unknowns: indices, ``r`` (t, l, l) and normal matrices (t, l, l)."""
        indices: dict[int, list[int]] = {}
        for i, trial in enumerate(self.trials):
            indices.setdefault(len(trial.r), []).append(i)
        factors = [(group, np.array([self.trials[i].r for i in group])) for group in indices.values()]
        return [(group, r, r.transpose(0, 2, 1) @ r) for group, r in factors]

    def normal(
        self, residuals: Sequence[Array], columns: Sequence[Array], weight: float, prior: Array
    ) -> LinearisedNormal:
        """Normal equations for residuals (M,) of each trial.

        Parameters
        ----------
        columns : (M, k) per trial, derivatives by further unknowns.
        weight : of the squared residuals in the cost, against priors of unit variance on all common unknowns.
        prior : (p + k,) the unknowns themselves, the gradient of those priors.
        """
        size = len(prior)
        parts, squares, components = [], [], []
        for trial, residual, more in zip(self.trials, residuals, columns, strict=True):
            wide = np.concatenate([more.T, residual[None]])
            along = wide @ trial.q
            left = wide - along @ trial.q.T
            across, own = left @ trial.projected, left @ left.T
            p = trial.common.shape[1]
            matrix = np.empty((size, size))
            matrix[:p, :p], matrix[p:, p:] = trial.products, own[:-1, :-1]
            matrix[p:, :p], matrix[:p, p:] = across[:-1], across[:-1].T
            parts.append((weight * matrix, weight * np.concatenate([across[-1], own[:-1, -1]])))
            squares.append(float(own[-1, -1]))
            components.append((along[-1], np.concatenate([trial.along, along[:-1].T], axis=1)))
        total = sum((matrix for matrix, _ in parts), np.eye(size))
        gradient = sum((part for _, part in parts), prior.copy())
        return LinearisedNormal(self._groups(components), total, gradient, tuple(parts), weight, tuple(squares))

    def _groups(self, components: Sequence[tuple[Array, Array]]) -> tuple[OwnGroup, ...]:
        """The trials' own unknowns, from components in their span: of residuals (l,), of derivatives (l, p + k)."""
        made = []
        for indices, r, square in self._trials_by_size:
            turned = r.transpose(0, 2, 1)
            here = np.array([components[i][0] for i in indices])
            along = np.array([components[i][1] for i in indices])
            made.append(OwnGroup(indices, square, (turned @ here[:, :, None])[:, :, 0], turned @ along))
        return tuple(made)


@dataclass(frozen=True)
class LinearisedNormal(ReducedNormal):
    """Reduced normal equations with each trial's projected sum of ``squares``."""

    squares: tuple[float, ...]

    @cached_property
    def _sums(self) -> tuple[Array, Array, float]:
        """Sums over all trials: matrix (p, p), gradient (p,) and sum of squares, without prior and weight."""
        matrix = sum((part for part, _ in self.parts), np.zeros_like(self.matrix))
        gradient = sum((part for _, part in self.parts), np.zeros_like(self.gradient))
        return matrix / self.weight, gradient / self.weight, float(sum(self.squares))

    def without_fold(self, out: Sequence[int], prior: Array) -> LinearisedNormal:
        """The same without the trials ``out``, whose own unknowns are refitted; ``prior`` as for ``normal``.

        They keep their places, with nothing in ``parts`` and ``squares``, so that all that is asked of the result holds
        for the others. Summed again, because the contribution of a diverged trial cannot be subtracted.
        """
        nothing = np.zeros_like(self.matrix), np.zeros_like(self.gradient)
        parts = tuple(nothing if index in out else part for index, part in enumerate(self.parts))
        squares = tuple(0.0 if index in out else own for index, own in enumerate(self.squares))
        matrix = sum((part for part, _ in parts), np.eye(len(prior)))
        gradient = sum((part for _, part in parts), prior.copy())
        return replace(self, matrix=matrix, gradient=gradient, parts=parts, squares=squares)

    def squares_without(self, trial: int, step: Array) -> float:
        """First-order projected sum of squares of all trials but one after a step (p,) of the common unknowns."""
        matrix, gradient, squares = self._sums
        own_matrix, own_gradient = (part / self.weight for part in self.parts[trial])
        bent = float(step @ (matrix - own_matrix) @ step)
        return squares - self.squares[trial] + 2.0 * float((gradient - own_gradient) @ step) + bent
