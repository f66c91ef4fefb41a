"""Sets of causes made from single causes and from other sets, to be fitted from the unchanged leg."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synth.arrays import Array
from synth.diagnosis.effect_shape import ShapedEffect
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.score import first_state
from synth.diagnosis.workbench import Workbench


def pairs_of(bench: Workbench, singles: Sequence[EvaluatedHypothesis]) -> list[EvaluatedHypothesis]:
    """Each two of the causes that can act together."""
    made = []
    for place, first in enumerate(singles):
        for second in singles[:place]:
            if all(cause.stands_beside(first.hypothesis) for cause in second.hypothesis):
                unknowns = np.concatenate([first.unknowns, second.unknowns[bench.n_tolerance :]])
                both = (*first.hypothesis, *second.hypothesis)
                made.append(bench.held(first.start_at(hypothesis=both, unknowns=unknowns)))
    return made


def with_simpler_cause(
    bench: Workbench, found: Sequence[EvaluatedHypothesis], singles: Sequence[EvaluatedHypothesis]
) -> list[EvaluatedHypothesis]:
    """The sets with one cause replaced by one of fewer unknowns that excludes it, as one dry friction another; at zero.

    ``singles`` : the causes that replace others.
    """
    made = []
    for fit in found:
        for place, cause in enumerate(fit.hypothesis):
            rest = (*fit.hypothesis[:place], *fit.hypothesis[place + 1 :])
            for (other,) in (single.hypothesis for single in singles):
                excludes = other.key[1] == cause.key[1] and not other.stands_beside([cause])
                if other.key != cause.key and excludes and other.size < cause.size and other.stands_beside(rest):
                    hypothesis = (other, *rest)
                    made.append(
                        bench.held(fit.start_at(hypothesis=hypothesis, unknowns=_unchanged_unknowns(bench, hypothesis)))
                    )
    return made


def without_one_cause(
    bench: Workbench, found: Sequence[EvaluatedHypothesis], known: Sequence[EvaluatedHypothesis]
) -> list[EvaluatedHypothesis]:
    """The sets that lack one cause of a set, at its values, except those with the causes of a ``known`` fit.

    Backward after forward selection: a first cause that imitated two others is not needed beside them.
    """
    tried, made = {frozenset(fit.keys) for fit in known}, []
    for fit in found:
        for fewer in (fit.without(k) for k in range(len(fit.hypothesis))):
            keys = frozenset(fewer.keys)
            if keys not in tried:
                tried.add(keys)
                made.append(bench.held(fewer))
    return made


def with_pair_replaced(
    bench: Workbench,
    found: Sequence[EvaluatedHypothesis],
    pair: EvaluatedHypothesis,
    others: Sequence[EvaluatedHypothesis],
) -> list[EvaluatedHypothesis]:
    """The sets of a ``pair`` and one further cause with each other pair in place of it; that cause at its values.

    A further cause is searched beside one pair only: of two that act alike by the noise's choice.
    """
    made, tried = [], {frozenset(fit.keys) for fit in found}
    for fit in found:
        further = [k for k, key in enumerate(fit.keys) if key not in pair.keys]
        for other in others if len(fit.keys) == len(pair.keys) + 1 == len(further) + 2 else ():
            cause, point = fit.hypothesis[further[0]], fit.unknowns[fit.slices[further[0]]]
            keys = frozenset((*other.keys, cause.key))
            if keys not in tried and cause.stands_beside(other.hypothesis):
                tried.add(keys)
                made.append(bench.awake(other.beside([cause], [point])))
    return made


def from_recorded_states(bench: Workbench, fit: EvaluatedHypothesis) -> EvaluatedHypothesis:
    """A hypothesis at the unchanged leg, from the initial states that the first samples show."""
    states = [first_state(trial) for trial in bench.trials]
    return bench.held(fit.start_at(unknowns=_unchanged_unknowns(bench, fit.hypothesis), states=states))


def _unchanged_unknowns(bench: Workbench, hypothesis: Sequence[ShapedEffect]) -> Array:
    """The unknowns of the unchanged leg: (n_tolerance + sizes of the causes,)."""
    return np.concatenate([np.zeros(bench.n_tolerance), *(cause.absent for cause in hypothesis)])
