"""The causes of a hypothesis with their parameters, against the design's numbers, and 90 % intervals.

An effect that says "another torque constant" counts from the stated one, and so does its interval. In a fit the same
number moves within its own tolerance too, and the two share the deviation as their priors have it: of a constant 30 %
lower a third may be tolerance. What is told is therefore both together, with their covariance.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.diagnosis.diagnosis_result import Cause
from synth.diagnosis.effect_shape import ShapedEffect
from synth.diagnosis.hypotheses import Assessment
from synth.diagnosis.plant import F, Plant, S, T
from synth.diagnosis.search_limits import open_intervals, parameters_at_limits
from synth.diagnosis.unseen import jackknife
from synth.estimation.intervals import NORMAL90, Estimate
from synth.units import shown_unit

DERIVATIVE_STEP = 1e-4  # of a whitened unknown; the numbers of a leg are smooth in it


def causes_of(plant: Plant[F, T, S], item: Assessment[F]) -> tuple[Cause, ...]:
    """The causes of a hypothesis with their parameters and intervals.

    The interval is the larger of two: from the derivatives and the size of the residuals, and from the spread of the
    estimates when one fold of trials after the other is left out.
    """
    fit = item.fit
    if not fit.hypothesis:
        return ()
    covariance = plant.covariance(fit)
    deviation = np.sqrt(np.diag(covariance))
    by_fold = item.unseen.by_fold if item.unseen is not None else np.zeros((0, 0))
    left_out = by_fold.shape[1] == len(deviation)
    if left_out:
        deviation = np.maximum(deviation, jackknife(by_fold))
    made, first = [], plant.n_tolerance
    for candidate in fit.hypothesis:
        part = slice(first, first + candidate.size)
        numbers = _StatedNumbers(plant.against_design, candidate, fit.unknowns[: plant.n_tolerance], part)
        own = deviation[part].copy()
        for k, along in numbers.with_tolerance(fit.unknowns[part], len(covariance)).items():
            own[k] = np.sqrt(along @ covariance @ along)
            if left_out:
                own[k] = max(own[k], float(jackknife(by_fold @ along[:, None])[0]))
        made.append(_cause_with_intervals(candidate, numbers.named, fit.unknowns[part], own))
        first += candidate.size
    return tuple(made)


@dataclass(frozen=True)
class _StatedNumbers:
    """A cause's parameters against the design's numbers, at ``tolerances`` (n_tolerance,), whitened.

    ``against_design`` : the plant's. ``part`` : places of its unknowns in the hypothesis.
    """

    against_design: Callable[[ShapedEffect, Mapping[str, float], Array], dict[str, float]]
    candidate: ShapedEffect
    tolerances: Array
    part: slice

    def named(self, x: Array, tolerances: Array | None = None) -> dict[str, float]:
        """Parameters by name, in SI, from whitened unknowns (size,)."""
        at = self.tolerances if tolerances is None else tolerances
        return self.against_design(self.candidate, self.candidate.named(x), at)

    def with_tolerance(self, x: Array, count: int) -> dict[int, Array]:
        """Each unknown whose parameter has a tolerance of its own -> direction (count,) of both together.

        The unknown itself counts 1, a tolerance as much as it moves the parameter in comparison.
        """
        here, found = self.named(x), {}
        slopes = np.zeros((len(self.tolerances), len(self.candidate.shape.free)))
        for place in range(len(self.tolerances)):
            moved = self.tolerances.copy()
            moved[place] += DERIVATIVE_STEP
            there = self.named(x, moved)
            slopes[place] = [there[name] - here[name] for name in self.candidate.shape.free]
        for k, name in enumerate(self.candidate.shape.free):
            moved = x.copy()
            moved[k] += DERIVATIVE_STEP
            own = self.named(moved)[name] - here[name]
            if own != 0.0 and np.any(slopes[:, k]):
                along = np.zeros(count)
                along[: len(self.tolerances)], along[self.part.start + k] = slopes[:, k] / own, 1.0
                found[k] = along
        return found


def _cause_with_intervals(
    candidate: ShapedEffect, named: Callable[[Array], Mapping[str, float]], x: Array, deviation: Array
) -> Cause:
    """With 90 % intervals: each parameter's range over the interval of its unknowns, open at a limit of the search.

    ``named`` : parameters to tell from unknowns like ``x`` (size,).
    """
    values = named(x)
    reach = {name: [value] for name, value in values.items()}
    low, high = candidate.bounds()
    for k in range(candidate.size):
        for side in (-NORMAL90, NORMAL90):
            moved = x.copy()
            moved[k] = np.clip(moved[k] + side * deviation[k], low[k], high[k])
            for name, value in named(moved).items():
                reach[name].append(value)
    unit = {parameter.name: parameter.unit for parameter in candidate.effect.parameters}
    found = {}
    for name, value in values.items():
        written = shown_unit(unit[name])
        free = name in candidate.shape.free
        found[name] = Estimate(value, written, min(reach[name]), max(reach[name])) if free else Estimate(value, written)
    effect, place = candidate.key
    told = open_intervals(found, parameters_at_limits(candidate, x))
    return Cause(effect, place, told, absent=candidate.is_absent)
