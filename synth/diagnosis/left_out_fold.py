"""Fits that each leave a fold of trials out: all trials are predicted, but only the others count."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from synth.arrays import Array
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.workbench import Workbench
from synth.estimation.linearisation import LinearisedNormal
from synth.estimation.unknown_size import UnknownSize

DIVERGED_ERROR = 1e4  # times the noise, error of a diverged motion
# Rad, the largest error that counts where it is more than that: of readings whose noise a filter took away, as of a
# simulation's, every error of a real leg is more than 1e4 times the noise, and all causes would be alike.
DIVERGED_ANGLE = 0.5


@dataclass(frozen=True)
class FitWithoutFold(EvaluatedHypothesis):
    """A fit to all trials except ``out``, whose states are refitted."""

    out: tuple[int, ...] = ()


F = TypeVar("F", bound=FitWithoutFold)


def squares_without_fold(bench: Workbench, residuals: Sequence[Array], out: Sequence[int]) -> tuple[float, float]:
    """Whitened sum of squares and effective samples of all trials except ``out``."""
    inside = [i for i in range(len(bench.trials)) if i not in out]
    squares = float(sum(float(residuals[i] @ residuals[i]) for i in inside))
    return squares, float(sum(bench.independent(bench.trials[i]).sum() for i in inside))


def finite_residual(residual: Array) -> Array:
    """The residual (m,), ``DIVERGED_ERROR`` where it is not finite, in its direction where it has one."""
    return np.nan_to_num(residual, nan=DIVERGED_ERROR, posinf=DIVERGED_ERROR, neginf=-DIVERGED_ERROR)


def bounded_residual(residual: Array, noise: Array) -> Array:
    """The residual (m,), in units of its noise (m,) rad, bounded in either direction, and so where it is not finite."""
    most = np.maximum(DIVERGED_ERROR, DIVERGED_ANGLE / noise)
    return np.clip(np.nan_to_num(residual, nan=np.inf), -most, most)


def evaluated_without_fold(bench: Workbench, fit: F) -> F:
    """The fit with the cost of the trials that count."""
    squares, total = squares_without_fold(bench, fit.residuals, fit.out)
    cost = UnknownSize(total).cost(squares, fit.unknowns)
    return replace(fit, cost=cost if np.isfinite(cost) else np.inf)


def normal_without_fold(bench: Workbench, fit: FitWithoutFold, columns: Sequence[Array]) -> LinearisedNormal:
    """Normal equations of the trials that count; the others' states are refitted.

    ``columns`` (M, k) per trial: whitened derivatives by the unknowns after the tolerances.
    """
    squares, total = squares_without_fold(bench, fit.residuals, fit.out)
    residuals = [finite_residual(residual) for residual in fit.residuals]
    sound = [np.nan_to_num(c, nan=0.0, posinf=0.0, neginf=0.0) for c in columns]
    assert fit.frame is not None
    normal = fit.frame.normal(residuals, sound, UnknownSize(total).weight(squares), fit.unknowns)
    return normal.without_fold(fit.out, fit.unknowns)
