"""Nelder and Mead's simplex within bounds, with all candidate points of a step computed together.

Coefficients of reflection, expansion, contraction and shrinking 1, 2, 1/2, 1/2, a start of 5 % along each axis, and the
tests for convergence are those of MATLAB's ``fminsearch`` (Lagarias et al., SIAM J. Optim. 9 (1998) 112); bounds by the
sine as in J. D'Errico's ``fminsearchbnd``. One candidate costs as much as sixteen, the lanes of the engine, so the
reflected, expanded, contracted and shrunken points are computed before it is known which is needed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array

MAX_ITERATIONS = 500  # steps, after which the best point so far is returned
TOLERANCE_X, TOLERANCE_F = 1e-4, 1e-4  # the defaults of MATLAB's fminsearch


@dataclass(frozen=True)
class SearchEnd:
    """The end of a search: ``point`` (d,), its ``cost``, number of steps and of computed points."""

    point: Array
    cost: float
    iterations: int
    evaluations: int


def simplex(
    cost: Callable[[Array], Array],
    start: Array,
    lower: Array,
    upper: Array,
    *,
    max_iterations: int = MAX_ITERATIONS,
) -> SearchEnd:
    """Minimise ``cost``, which takes columns (d, c) and gives (c,), from ``start`` (d,) within the bounds (d,)."""

    def inside(angle: Array) -> Array:
        return lower[:, None] + 0.5 * (upper - lower)[:, None] * (np.sin(angle) + 1.0)

    share = np.clip(2 * (np.clip(start, lower, upper) - lower) / (upper - lower) - 1.0, -1.0, 1.0)
    first = 2 * np.pi + np.arcsin(share)  # away from zero, where 5 % would vanish
    d = len(start)
    points = np.repeat(first[:, None], d + 1, axis=1)
    points[np.arange(d), np.arange(1, d + 1)] *= 1.05
    values = cost(inside(points))
    evaluations, done = d + 1, 0
    for done in range(1, max_iterations + 1):  # noqa: B007, reported at the end
        order = np.argsort(values, kind="stable")
        points, values = points[:, order], values[order]
        near = np.abs(points[:, 1:] - points[:, :1]).max() <= TOLERANCE_X
        if near and np.abs(values[1:] - values[0]).max() <= TOLERANCE_F:
            break
        centre, worst = points[:, :-1].mean(axis=1), points[:, -1]
        away = centre - worst
        tried = np.stack([centre + away, centre + 2 * away, centre + 0.5 * away, centre - 0.5 * away], axis=1)
        shrunken = points[:, :1] + 0.5 * (points[:, 1:] - points[:, :1])
        found = cost(inside(np.concatenate([tried, shrunken], axis=1)))
        evaluations += d + 4
        chosen = _replacement_point(found[:4], values)
        if chosen is None:
            points[:, 1:], values[1:] = shrunken, found[4:]
        else:
            points[:, -1], values[-1] = tried[:, chosen], found[chosen]
    best = int(np.argmin(values))
    return SearchEnd(inside(points[:, [best]])[:, 0], float(values[best]), done, evaluations)


def _replacement_point(found: Array, values: Array) -> int | None:
    """The replacement of the worst point: reflection, expansion, outer or inner contraction; None: shrink."""
    reflected, expanded, outer, inner = found
    if reflected < values[0]:
        return 1 if expanded < reflected else 0
    if reflected < values[-2]:
        return 0
    if reflected < values[-1]:
        return 2 if outer <= reflected else None
    return 3 if inner < values[-1] else None
