"""Hypotheses that are a simpler effect under another name are no rivals of it.

A spring whose rate changes with deflection, from an onset of 0 with an exponent of 1, is another spring rate: the same
motion in every trial. A fit that ends there is that simpler effect with idle unknowns, and as a rival of it makes a tie
that no recording can end. Near that border too, as long as it explains no more: a bounded unknown whose true value is
its bound ends above it as often as on it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from synth.arrays import Array
from synth.diagnosis.effect_shape import ShapedEffect
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.hypotheses import Assessment, Hypotheses, Key
from synth.diagnosis.odds import Calibration, price_of_unknown
from synth.diagnosis.workbench import Workbench
from synth.estimation.parameters import SimplerEffect

# Deviations of a parameter's prior from the value at which it is a simpler effect: an exponent of 1.1 for 1.
# A choice; what is farther away and explains no more is a rival, since a trial could tell it apart.
NEAR_SIMPLER = 0.1


def without_simpler_effects_in_disguise(
    bench: Workbench, found: Hypotheses[EvaluatedHypothesis], calibration: Calibration
) -> Hypotheses[EvaluatedHypothesis]:
    """The hypotheses without those that are simpler ones among them, and explain no more by what their unknowns cost.

    As ``SimplerEffect`` says of their causes. The simpler ones stay.
    """
    every = [found.none, *found.singles, *found.several]
    price = price_of_unknown(min(item.ratio for item in every), bench.total, calibration)
    known = {frozenset(item.keys): item for item in every}

    def is_rival(item: Assessment[EvaluatedHypothesis]) -> bool:
        simpler = (known.get(keys) for keys in _simpler_sets(item.fit))
        return not any(each is not None and _leaves_as_much(each, item, price) for each in simpler)

    singles, several = (tuple(filter(is_rival, items)) for items in (found.singles, found.several))
    return replace(found, singles=singles, several=several)


def _leaves_as_much(
    simpler: Assessment[EvaluatedHypothesis], item: Assessment[EvaluatedHypothesis], price: float
) -> bool:
    """Whether the additional unknowns of ``item`` take off less than they cost.

    Without the priors of the causes: the same change is a large rate, and a small torque at a small deflection.
    """
    gained = _misfit(simpler.fit) - _misfit(item.fit)
    return gained <= price * (item.n_unknown - simpler.n_unknown)


def _misfit(fit: EvaluatedHypothesis) -> float:
    """Cost without the priors of its causes."""
    own = fit.unknowns[fit.n_tolerance :]
    return fit.cost - 0.5 * float(own @ own)


def _simpler_sets(fit: EvaluatedHypothesis) -> Iterator[frozenset[Key]]:
    """The causes of each simpler hypothesis that this one is."""
    for k, (cause, place) in enumerate(zip(fit.hypothesis, fit.slices, strict=True)):
        others = [*fit.keys[:k], *fit.keys[k + 1 :]]
        for key in simpler_keys(cause, fit.unknowns[place]):
            yield frozenset([*others, key])


def simpler_keys(cause: ShapedEffect, unknowns: Array) -> Sequence[Key]:
    """The simpler effects, at its place, that a cause is at these whitened unknowns (size,)."""
    return [(simpler.name, cause.key[1]) for simpler in cause.effect.becomes if _is_near(cause, unknowns, simpler)]


def _is_near(cause: ShapedEffect, unknowns: Array, simpler: SimplerEffect) -> bool:
    ends = cause.values(np.column_stack([unknowns - NEAR_SIMPLER, unknowns + NEAR_SIMPLER]))
    places = [cause.effect.index(name) for name in simpler.where]
    wanted = np.array([*simpler.where.values()])
    low, high = ends[places].min(axis=1), ends[places].max(axis=1)
    return bool(np.all((low <= wanted) & (wanted <= high)))
