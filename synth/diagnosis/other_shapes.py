"""Sets of causes with one cause in another of its shapes.

A cause is screened in all its simple shapes alone, and kept in the best. Beside a second cause another shape may be the
right one. A spring that is stiffer on one side, beside a rotor's inertia, left 39.7 floors as one that is softer on
the other side, and 9.3 in its own shape. Richer shapes have many unknowns and are tried for a leading single cause
only: a mount that slides, beside a centre of mass that is off, had the cost 1004 where the mount that also rocks has
833, and a spring that is softer on one side took the mount's place with 907.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from synth.arrays import Array
from synth.diagnosis.effect_shape import ShapedEffect
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.hypotheses import Hypotheses
from synth.diagnosis.restarts import refine
from synth.diagnosis.score import fresh
from synth.diagnosis.screening import rungs
from synth.diagnosis.workbench import Workbench

FRAMES = 24  # most renewals of the derivatives
RICHER = 2  # best sets that are tried in a richer shape: each takes some seconds


def in_other_shapes(
    bench: Workbench, fit: EvaluatedHypothesis, candidates: Sequence[ShapedEffect]
) -> list[list[EvaluatedHypothesis]]:
    """Starts of the set with one of its causes in each of its other simple shapes, shape by shape.

    What both shapes free keeps its value; where a strength is new, at each rung of the ladder of strengths. The cause
    comes last. Not of compliances: with a state in each trial they imitate others (``_in_another_shape`` of
    ``angle_search``).
    """
    made = []
    for k, cause in enumerate(fit.hypothesis):
        for other in candidates:
            simple = not (other.shape.richer or cause.is_compliance)
            if other.key == cause.key and other.shape is not cause.shape and simple:
                starts = _in_shape(bench, fit, k, other)
                known = {*other.effect.strengths} & {*other.shape.free} <= {*cause.shape.free}
                first = len(fit.unknowns) - cause.size
                made.append(starts if known else [rung for start in starts for rung in rungs(start, first)])
    return made


def with_richer_shapes(
    bench: Workbench,
    found: Hypotheses[EvaluatedHypothesis],
    candidates: Sequence[ShapedEffect],
    rank: Callable[[EvaluatedHypothesis], float],
) -> list[EvaluatedHypothesis]:
    """Fits of the best few sets whose causes have richer shapes, in these, where they are better by ``rank``.

    After the search: a third cause is sought beside the best set, and a rich shape that imitates two causes would be
    in it. On a real double pendulum a mount and a shifted reading took the place of a centre of mass that is 11 % off.
    """
    made = [(item.fit, starts) for item in found.several if (starts := _richer(bench, item.fit, candidates))][:RICHER]
    ends = iter(refine(bench, bench.evaluate([start for _, starts in made for start in starts]), FRAMES))
    best = [(fit, min((next(ends) for _ in starts), key=rank)) for fit, starts in made]
    return [end for fit, end in best if rank(end) < rank(fit)]


def _richer(
    bench: Workbench, fit: EvaluatedHypothesis, candidates: Sequence[ShapedEffect]
) -> list[EvaluatedHypothesis]:
    """Starts of the set with one of its causes in each of its richer shapes."""
    return [
        start
        for k, cause in enumerate(fit.hypothesis)
        for other in candidates
        if other.key == cause.key and other.shape.richer and not cause.shape.richer
        for start in _in_shape(bench, fit, k, other)
    ]


def _in_shape(bench: Workbench, fit: EvaluatedHypothesis, k: int, other: ShapedEffect) -> list[EvaluatedHypothesis]:
    """Starts with the cause ``k`` in another shape, last; what both shapes free keeps its value."""
    place = bench.n_tolerance + sum(cause.size for cause in fit.hypothesis[:k])
    cause = fit.hypothesis[k]
    own = dict(zip(cause.shape.free, fit.unknowns[place : place + cause.size], strict=True))
    kept = np.delete(fit.unknowns, slice(place, place + cause.size))
    rest = (*fit.hypothesis[:k], *fit.hypothesis[k + 1 :])
    points = [
        [own.get(name, value) for name, value in zip(other.shape.free, start, strict=True)] for start in other.starts()
    ]
    return [_at(bench, fit, (*rest, other), np.concatenate([kept, point])) for point in points]


def _at(
    bench: Workbench, fit: EvaluatedHypothesis, hypothesis: tuple[ShapedEffect, ...], unknowns: Array
) -> EvaluatedHypothesis:
    """A start there; links that are added start as if held."""
    states = tuple(state[: 2 * len(bench.noise)] for state in fit.states)
    moved = replace(fit, hypothesis=hypothesis, unknowns=unknowns, states=states, residuals=(), columns=())
    return bench.awake(fresh(replace(moved, cost=np.inf, frame=None)))
