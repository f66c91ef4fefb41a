"""How far one trial moves the rates: where the model misses an effect, their intervals do not tell it.

An interval is that of a model that holds: its residuals are noise, correlated as they are. What the model lacks acts in
each trial by its own amount, and another choice of trials gives other rates. Leaving out each trial in turn shows it
(the jackknife, Efron & Tibshirani, *An Introduction to the Bootstrap*, 1993, chapter 11).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from synth.arrays import Array
from synth.estimation.estimate_words import interval_words
from synth.estimation.intervals import Estimate
from synth.fit.least_squares import Solution, Stage, reduced_by_trial
from synth.fit.recordings import Recording
from synth.fit.trajectories import TrajectoryModel
from synth.remarks import at_joint

RATES = {"spring_rate": "spring rate", "damper_rate": "damper rate"}


def moved_by_one_trial(
    model: TrajectoryModel,
    recordings: Sequence[Recording],
    stage: Stage,
    least: Solution | None,
    told: Mapping[str, Estimate],
) -> list[str]:
    """Sentences on rates that leave their 90 % intervals if one trial is left out.

    ``stage`` : of the fit, and ``least`` its solution of least residual if it was moved; ``told`` : the estimates by
    the unknowns' names. None for a single trial.
    """
    if len(recordings) < 2:
        return []
    at = Stage(least or stage.solution, stage.weights)
    values, steps = at.solution.values, steps_without_each(model, recordings, at)
    known = {
        place: (name.partition(" ")[0], name.partition(" ")[2], told[name])
        for place, name in enumerate(model.unknowns.names)
        if name.partition(" ")[0] in RATES and name in told
    }
    sentences: list[str] = []
    for place, (kind, joint, estimate) in known.items():
        moved = steps[:, place]
        low, high = np.exp(values[place] + np.array([moved.min(initial=0.0), moved.max(initial=0.0)])).tolist()
        if estimate.low is None or estimate.high is None or estimate.low <= low <= high <= estimate.high:
            continue
        words = interval_words(estimate.value, low, high, estimate.shown_in)
        text = f"leaving out one trial moves the {RATES[kind]}, to first order, within {words}, beyond its interval"
        sentences.append(at_joint(joint, f"{text}: intervals hold only if the model does"))
    return sentences


def steps_without_each(model: TrajectoryModel, recordings: Sequence[Recording], stage: Stage) -> Array:
    """(n_trial, p) first-order changes of the common unknowns if each trial is left out.

    One step of the normal equations without the trial (Miller, Biometrika 61 (1974) 1); its gradient is what the others
    leave at the optimum. Of two trials of one knee and one of a knee 50 % stiffer it gives 4 % less than the fit of the
    two, of one 10 % stiffer the same within 2 %.
    """
    whole, bounds = stage.solution.information.schur(), model.unknowns
    steps = []
    for matrix, gradient in reduced_by_trial(model, recordings, stage):
        step = np.linalg.lstsq(whole - matrix, gradient, rcond=None)[0]
        values = stage.solution.values
        steps.append(np.clip(values + step, bounds.lower, bounds.upper) - values)
    return np.array(steps)
