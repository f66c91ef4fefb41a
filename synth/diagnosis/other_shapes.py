"""Sets of causes with one cause in another of its shapes.

A cause is screened in all its simple shapes alone, and kept in the best. Beside a second cause another shape may be the
right one. A spring that is stiffer on one side, beside a rotor's inertia, left 39.7 floors as one that is softer on
the other side, and 9.3 in its own shape. Richer shapes have many unknowns and are tried for a leading single cause
only: a mount that slides, beside a centre of mass that is off, had the cost 1004 where the mount that also rocks has
833, and a spring that is softer on one side took the mount's place with 907.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from synth.arrays import Array
from synth.diagnosis.effect_shape import ShapedEffect
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.score import fresh
from synth.diagnosis.screening import rungs
from synth.diagnosis.workbench import Workbench


def in_other_shapes(
    bench: Workbench, fit: EvaluatedHypothesis, candidates: Sequence[ShapedEffect]
) -> list[list[EvaluatedHypothesis]]:
    """Starts of the set with one of its causes in each of its other shapes, shape by shape.

    None for a cause in a richer shape, which includes the others. What both shapes free keeps its value; where a
    strength is new, at each rung of the ladder of strengths. The cause comes last.
    """
    made, place = [], bench.n_tolerance
    for k, cause in enumerate(fit.hypothesis):
        end = place + cause.size
        own = dict(zip(cause.shape.free, fit.unknowns[place:end], strict=True))
        kept = np.delete(fit.unknowns, slice(place, end))
        rest = (*fit.hypothesis[:k], *fit.hypothesis[k + 1 :])
        for other in candidates:
            if other.key == cause.key and other.shape is not cause.shape and not cause.shape.richer:
                starts = []
                for start in other.starts():
                    point = [own.get(name, value) for name, value in zip(other.shape.free, start, strict=True)]
                    begun = _at(bench, fit, (*rest, other), np.concatenate([kept, point]))
                    known = all(name in own for name in other.effect.strengths if name in other.shape.free)
                    starts += [begun] if known or other.shape.richer else rungs(begun, len(kept))
                made.append(starts)
        place = end
    return made


def _at(
    bench: Workbench, fit: EvaluatedHypothesis, hypothesis: tuple[ShapedEffect, ...], unknowns: Array
) -> EvaluatedHypothesis:
    """A start there; links that are added start as if held."""
    states = tuple(state[: 2 * len(bench.noise)] for state in fit.states)
    moved = replace(fit, hypothesis=hypothesis, unknowns=unknowns, states=states, residuals=(), columns=())
    return bench.awake(fresh(replace(moved, cost=np.inf, frame=None)))
