"""Gauss-Newton in the own unknowns of one trial, all others fixed; scores trials that were not fitted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from synth.arrays import Array

S = TypeVar("S")


@dataclass(frozen=True)
class LocalProblem(Generic[S]):
    """One trial at one point: ``prediction``, cost, normal ``matrix`` (l, l) and ``gradient`` (l,)."""

    prediction: S
    cost: float
    matrix: Array
    gradient: Array


def gauss_newton(
    assess: Callable[[Array], LocalProblem[S]], start: Array, *, rounds: int, least_gain: float
) -> tuple[S, Array]:
    """The prediction at the best point found, and that point (l,).

    Steps that do not lower the cost are halved; the search stops at a step that lowers it by less than ``least_gain``,
    or if the normal equations are not finite because a simulation diverged.
    """
    at, where, step = start, start, np.zeros(len(start))
    best: LocalProblem[S] | None = None
    for _ in range(rounds):
        found = assess(at)
        if best is None or found.cost < best.cost:
            gain = np.inf if best is None else best.cost - found.cost
            best, where = found, at
            if gain < least_gain or not (np.all(np.isfinite(found.matrix)) and np.all(np.isfinite(found.gradient))):
                break
            step = np.asarray(-np.linalg.solve(found.matrix, found.gradient))
        else:
            step = 0.5 * step
        at = where + step
    assert best is not None
    return best.prediction, where
