"""Sets of causes with one cause in another of its shapes.

A cause is screened in all its simple shapes alone, and kept in the best. Beside a second cause another shape may be the
right one: a spring that is stiffer on one side, beside a rotor's inertia, resembles alone one that is softer on the
other side. Richer shapes of mounts and bending links are not tried here: with initial states of their own in each trial
they imitate other causes, such as a wrong centre of mass.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synth.diagnosis.effect_shape import ShapedEffect
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.screening import ladder_starts
from synth.diagnosis.workbench import Workbench


def starts_in_other_shapes(
    bench: Workbench, fit: EvaluatedHypothesis, candidates: Sequence[ShapedEffect]
) -> list[list[EvaluatedHypothesis]]:
    """Starts of the set with one of its causes in each of its other simple shapes of another strength, shape by shape.

    What both shapes free keeps its value, the strength is that of each rung of the ladder. The cause comes last. Not in
    shapes of more links: with a state in each trial they imitate others. A mount that slides has no more than one that
    rocks, which imitates it about a far point: alone it may fit better, and beside a shifted encoder far worse.
    """
    made = []
    for k, cause in enumerate(fit.hypothesis):
        for other in candidates:
            simple = not other.shape.richer and other.links <= cause.links
            new = {*other.effect.strengths} & {*other.shape.free} - {*cause.shape.free}
            if other.key == cause.key and simple and new:
                first = len(fit.unknowns) - cause.size
                made.append(
                    [rung for start in _starts_in_shape(bench, fit, k, other) for rung in ladder_starts(start, first)]
                )
    return made


def _starts_in_shape(
    bench: Workbench, fit: EvaluatedHypothesis, k: int, other: ShapedEffect
) -> list[EvaluatedHypothesis]:
    """Starts with the cause ``k`` in another shape, last; what both shapes free keeps its value."""
    own = dict(zip(fit.hypothesis[k].shape.free, fit.unknowns[fit.slices[k]], strict=True))
    points = [
        [own.get(name, value) for name, value in zip(other.shape.free, start, strict=True)] for start in other.starts()
    ]
    return [bench.held(fit.without(k).beside([other], [np.array(point)])) for point in points]
