"""Sets of causes with one cause in a richer shape: a mount that slides and rocks in place of one that slides.

Richer shapes have many unknowns and are tried for a leading single cause only. Beside a second cause the simple shape
may be the reason why the set is not the best: a mount that slides, beside a centre of mass that is off, left 1004 where
the mount that also rocks leaves 833, and a spring that is softer on one side took the mount's place with 907.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from synth.arrays import Array
from synth.diagnosis.effect_shape import ShapedEffect
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.score import fresh
from synth.diagnosis.workbench import Workbench


def in_richer_shapes(
    bench: Workbench, fit: EvaluatedHypothesis, candidates: Sequence[ShapedEffect]
) -> list[EvaluatedHypothesis]:
    """Starts of the set with one of its causes in each of its richer shapes; what both shapes free keeps its value."""
    made, place = [], bench.n_tolerance
    for k, cause in enumerate(fit.hypothesis):
        for other in candidates:
            if other.key == cause.key and other.shape.richer and not cause.shape.richer:
                own = dict(zip(cause.shape.free, fit.unknowns[place : place + cause.size], strict=True))
                for start in other.starts():
                    point = [own.get(name, value) for name, value in zip(other.shape.free, start, strict=True)]
                    unknowns = np.concatenate([fit.unknowns[:place], point, fit.unknowns[place + cause.size :]])
                    made.append(_at(bench, fit, (*fit.hypothesis[:k], other, *fit.hypothesis[k + 1 :]), unknowns))
        place += cause.size
    return made


def _at(
    bench: Workbench, fit: EvaluatedHypothesis, hypothesis: tuple[ShapedEffect, ...], unknowns: Array
) -> EvaluatedHypothesis:
    """A start there; links that are added start as if held."""
    states = tuple(state[: 2 * len(bench.noise)] for state in fit.states)
    moved = replace(fit, hypothesis=hypothesis, unknowns=unknowns, states=states, residuals=(), columns=())
    return bench.awake(fresh(replace(moved, cost=np.inf, frame=None)))
