"""Parameters of a cause that end where their search does: the trials may well ask for more.

The interval of such a parameter ends at the search's limit and not at the data's: without a warning it would exclude
larger values that nobody has tried.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from synth.arrays import Array
from synth.diagnosis.diagnosis_result import Cause
from synth.diagnosis.effect_shape import ShapedEffect
from synth.diagnosis.sentences import parameters_text
from synth.estimation.intervals import Estimate

# Standard deviations, for every plant: a larger deviation of a tolerance counts as a cause, whatever it would explain.
LARGEST_TOLERANCE = 2.5
NEAR_BOUND = 1e-3  # deviations of the prior from a bound: a step that is cut at a bound ends on it
STEP_INSIDE = 0.01  # deviations of the prior, by which a step back shows the sense of a parameter


def parameters_at_limits(candidate: ShapedEffect, x: Array) -> dict[str, bool]:
    """Name of each free parameter that ends at a limit of its search -> whether that is its largest value.

    Not where the parameter itself ends: at 0 if it is a size, at the whole of a share. ``x`` (size,) : whitened.
    """
    low, high = candidate.bounds()
    values, found = candidate.named(x), dict[str, bool]()
    for k, (name, prior) in enumerate(zip(candidate.shape.free, candidate.priors, strict=True)):
        unit = candidate.effect.parameters[candidate.effect.index(name)].unit
        for bound, inward in ((low[k], STEP_INSIDE), (high[k], -STEP_INSIDE)):
            end = float(prior.value(bound))
            linear = not (prior.log or prior.inverse)
            if abs(x[k] - bound) > NEAR_BOUND or (linear and (end == 0.0 or (unit == "1" and abs(end) == 1.0))):
                continue
            inside = x.copy()
            inside[k] = bound + inward
            before = candidate.named(inside)[name]
            if before != values[name]:
                found[name] = values[name] > before
    return found


def tolerances_at_limits(tolerances: Array) -> bool:
    """Whether one of the whitened tolerances (n_tolerance,) ends at the limit of its search."""
    return bool(np.any(np.abs(tolerances) > LARGEST_TOLERANCE - NEAR_BOUND))


def open_intervals(estimates: Mapping[str, Estimate], limits: Mapping[str, bool]) -> dict[str, Estimate]:
    """The estimates, the intervals of those in ``limits`` without the end that only the search sets."""
    return {
        name: _open_interval(each, largest=limits[name]) if name in limits else each for name, each in estimates.items()
    }


def _open_interval(estimate: Estimate, *, largest: bool) -> Estimate:
    return replace(estimate, high=np.inf) if largest else replace(estimate, low=-np.inf)


def limit_sentences(short: str, candidate: ShapedEffect, x: Array, cause: Cause) -> list[str]:
    """A warning for each parameter told in the sentence that ends at a limit; ``short`` : the cause in a few words."""
    found = []
    for name, largest in parameters_at_limits(candidate, x).items():
        if name in candidate.effect.stated_by_default:
            end, beyond = ("largest", "larger") if largest else ("smallest", "smaller")
            told = parameters_text(cause, [name], candidate.effect)
            found.append(
                f"{short}: {told} is the {end} value that the search tries; the true one may be {beyond}, and its "
                "interval is open on that side"
            )
    return found
