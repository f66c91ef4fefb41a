"""Predictions of the scored trials by fits that do not know them."""

from __future__ import annotations

import numpy as np

from synth.diagnosis.hypotheses import Assessment
from synth.diagnosis.plant import F, Plant, S, T


def predict_unseen(plant: Plant[F, T, S], item: Assessment[F]) -> tuple[S, ...]:
    """Predictions of held-out trials, or else of each trial by a fit without it.

    By the refit without the trial's fold where there is one, else by one linear step, which is wrong where the
    motion is strongly nonlinear (a pendulum that turns over).
    """
    fit = item.fit
    if plant.held_out or len(plant.scored) == 1:
        return plant.predict(fit, plant.scored)
    if item.unseen is not None and len(item.unseen.refitted) == len(plant.scored):
        each = zip(item.unseen.refitted, plant.scored, strict=True)
        return tuple(predicted for x, trial in each for predicted in plant.predict(fit.at(x), [trial]))
    normal, (low, high) = plant.normal(fit), plant.bounds(fit)
    made: list[S] = []
    for index, trial in enumerate(plant.scored):
        moved = np.clip(fit.unknowns + normal.without(index), low, high)
        made += plant.predict(fit.at(moved), [trial])
    return tuple(made)
