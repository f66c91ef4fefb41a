"""How far one trial moves the rates: where the model misses an effect, their intervals do not tell it.

An interval is that of a model that holds: its residuals are noise, correlated as they are. What the model lacks acts in
each trial by its own amount, and another choice of trials gives other rates. Leaving out each trial in turn shows it
(the jackknife, Efron & Tibshirani, *An Introduction to the Bootstrap*, 1993, chapter 11).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from synth.arrays import Array
from synth.estimation.estimate_words import interval_words
from synth.estimation.intervals import Estimate
from synth.fit.least_squares import FitStart, Solution, Stage, solve
from synth.fit.recordings import Recording
from synth.fit.trajectories import TrajectoryModel
from synth.fit.uncertainty import residuals
from synth.remarks import at_joint

MOST_LEFT_OUT = 12  # trials, those that fit worst: each takes a fit of all others, some 40 ms for six
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
    solution = least or stage.solution
    squares = [float(np.nansum(residuals(r, p) ** 2)) for r, p in zip(recordings, solution.predictions, strict=True)]
    worst = np.argsort(squares)[::-1][:MOST_LEFT_OUT]
    found = [values for t in worst if (values := _without(model, recordings, stage, solution, int(t))) is not None]
    if not found:
        return []
    reach = np.array([solution.values, *found])
    sentences: list[str] = []
    for place, name in enumerate(model.unknowns.names):
        kind, _, joint = name.partition(" ")
        estimate = told.get(name)
        if kind not in RATES or estimate is None or estimate.low is None or estimate.high is None:
            continue
        low, high = np.exp([reach[:, place].min(), reach[:, place].max()]).tolist()
        if low < estimate.low or high > estimate.high:
            words = interval_words(estimate.value, low, high, estimate.shown_in)
            text = f"leaving out one trial moves the {RATES[kind]} within {words}, beyond its interval"
            sentences.append(at_joint(joint, f"{text}: intervals hold only if the model does"))
    return sentences


def _without(
    model: TrajectoryModel, recordings: Sequence[Recording], stage: Stage, solution: Solution, left_out: int
) -> Array | None:
    """(p,) common unknowns of the fit without one trial, from those with it; None if it diverges."""
    kept = [t for t in range(len(recordings)) if t != left_out]
    centre = stage.weights.centre
    weights = replace(stage.weights, noise=stage.weights.noise[kept], centre=None if centre is None else centre[kept])
    lanes = [solution.lanes[t] for t in kept] if solution.lanes else []
    start = FitStart(solution.values, [solution.locals[t] for t in kept], lanes=lanes)
    found = solve(model, [recordings[t] for t in kept], start, weights)
    return found.values if np.isfinite(found.cost) else None
