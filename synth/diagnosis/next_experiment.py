"""The next trial: the one of a plant's menu that best separates the remaining explanations."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite

from synth.diagnosis.diagnosis_result import Experiment
from synth.diagnosis.plant import F, Plant, S, T
from synth.estimation.information import expected_information, rivals_of
from synth.threads import in_parallel


def next_experiment(plant: Plant[F, T, S], rivals: Sequence[tuple[F, float]], why: str) -> Experiment | None:
    """The trial with the largest expected information on which rival is true; None with fewer than two.

    ``rivals`` : fits with their weights. ``why`` : a sentence. The uncertainty of a prediction combines noise, per-
    trial
    unknowns, and the uncertainty of the leg after the existing trials.
    """
    menu = plant.menu() if len(rivals) > 1 else ()
    if not menu:
        return None
    kept, weights = rivals_of(rivals)
    covariances = [plant.normal(fit).covariance for fit in kept]

    def information(index: int) -> float:
        trial = menu[index].trial
        made = [plant.forecast(fit, trial, known) for fit, known in zip(kept, covariances, strict=True)]
        found = [forecast for forecast in made if forecast is not None]
        if len(found) < len(kept):
            return 0.0
        told = expected_information(weights, lambda a, b, at: found[a].distance(found[b], found[at]))
        return told if isfinite(told) else 0.0  # derivatives of a motion that is about to diverge may overflow

    bits = in_parallel(information, len(menu))
    order = sorted(range(len(menu)), key=lambda i: -bits[i])
    best = menu[order[0]]
    return Experiment(
        f"{why} {best.what[0].upper()}{best.what[1:]} would give most information: {bits[order[0]]:.2g} bit.",
        dict(best.keys),
        dict(best.release),
        bits[order[0]],
        tuple((menu[i].what, bits[i]) for i in order),
        best.ramp,
        best.command,
    )
