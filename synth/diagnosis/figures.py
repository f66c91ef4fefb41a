"""How far: scored trials predicted as designed, before and after, and what each prediction misses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from synth.arrays import Array
from synth.diagnosis.encoder_counts import Coarse, rounded
from synth.diagnosis.encoder_transitions import at_edges
from synth.diagnosis.gap_trials import GapTrial
from synth.diagnosis.prediction_error import BLOCKS, Misses, label
from synth.diagnosis.result import TrialGap
from synth.diagnosis.score import score
from synth.diagnosis.search import Assessed, Search
from synth.diagnosis.solve import Fit, Workbench
from synth.diagnosis.where import Missing, phases
from synth.swing.leg_model import Leg

SHOWN_ALONE = 4  # single causes whose predictions are kept, the likeliest first, for the page to show beside the trial


@dataclass(frozen=True)
class Gap(Misses):
    """Predictions (m, n) rad of each scored trial, and what they miss; ``alone``: with each of the likeliest causes."""

    trials: tuple[GapTrial, ...]
    as_designed: tuple[Array, ...]
    before: tuple[Array, ...]
    after: tuple[Array, ...]
    alone: Mapping[str, tuple[Array, ...]] = field(default_factory=dict)


def predictions(bench: Workbench, found: Assessed, trials: Sequence[GapTrial], held_out: bool) -> tuple[Array, ...]:
    """(m, n) rad a trial: of trials that took no part, or else of each trial by a fit without it."""
    if held_out or len(trials) == 1:
        return score(bench, found.fit, trials).predictions
    normal = bench.normal(found.fit)
    low, high = bench.bounds(found.fit.hypothesis)
    made = []
    for index, trial in enumerate(trials):
        moved = np.clip(found.fit.unknowns + normal.without(index), low, high)
        made.append(score(bench, replace(found.fit, unknowns=moved), [trial]).predictions[0])
    return tuple(made)


def measure(
    bench: Workbench,
    trials: Sequence[GapTrial],
    found: Search,
    accepted: Assessed,
    others: Sequence[Assessed],
    coarse: Sequence[Coarse],
    usual: Array,
    held_out: bool,
    seed: int,
) -> Gap:
    """Predict the scored trials as designed, before, after, and with each of the ``others``.

    ``usual`` (n,) rad: each channel's noise without coarse counts. Squares of the others stand under their keys joined
    by " + ".
    """
    leg = bench.predictor.leg
    designed = Fit((), np.zeros(bench.n_tolerance), ())
    begun = [at_edges(trial, coarse, usual) for trial in trials]  # what the initial states are estimated from
    as_designed = score(bench, designed, begun).predictions
    before = predictions(bench, found.none, begun, held_out)

    def told(predicted: Sequence[Array]) -> tuple[Array, ...]:
        return tuple(rounded(leg, trial, p, coarse) for trial, p in zip(trials, predicted, strict=True))

    after = told(before if accepted is found.none else predictions(bench, accepted, begun, held_out))
    squares = {
        "as_designed": _squares(trials, as_designed),
        "before": _squares(trials, before),
        "after": _squares(trials, after),
    }
    alone: dict[str, tuple[Array, ...]] = {}
    for other in others:
        predicted = after if other is accepted else told(predictions(bench, other, begun, held_out))
        squares[label(other.keys)] = _squares(trials, predicted)
        if len(alone) < SHOWN_ALONE:
            alone[label(other.keys)] = predicted
    counts = _squares(trials, [np.ones_like(t.measured) + t.measured for t in trials])
    noise = _squares(trials, [t.measured + usual for t in trials])
    return Gap(squares, counts, noise, seed, tuple(trials), as_designed, before, after, alone)


def _squares(trials: Sequence[GapTrial], predicted: Sequence[Array]) -> Array:
    """(n_trial, BLOCKS) summed squared misses."""
    found = np.zeros((len(trials), BLOCKS))
    for i, (trial, prediction) in enumerate(zip(trials, predicted, strict=True)):
        away = np.where(np.isfinite(prediction), prediction - trial.measured, np.pi)
        square = np.where(trial.counts, away**2, 0.0).sum(axis=1)
        found[i] = [part.sum() for part in np.array_split(square, BLOCKS)]
    return found


def trial_gaps(
    nominal: Leg, gap: Gap, missing: Sequence[Missing], held_out: bool, noise: Array
) -> tuple[TrialGap, ...]:
    """Scored trials in measured angles, for the report and the files."""
    made = []
    for index, trial in enumerate(gap.trials):
        smoothed, found = trial.recording.smoothed, missing[index]
        nearest = np.clip(np.searchsorted(smoothed.time, trial.time), 0, len(smoothed.time) - 1)
        torque = np.full((len(trial.time), len(nominal.joints)), np.nan)
        inside = (trial.time >= found.time[0]) & (trial.time <= found.time[-1]) if len(found.time) else None
        for j in range(len(nominal.joints)):
            if inside is not None:
                torque[inside, j] = nominal.sign[j] * np.interp(trial.time[inside], found.time, found.torque[:, j])
        measured = np.where(trial.counts, nominal.to_measured(trial.measured), np.nan)
        made.append(
            TrialGap(
                name=trial.recording.name,
                time=trial.time,
                measured=measured,
                as_designed=nominal.to_measured(gap.as_designed[index]),
                before=nominal.to_measured(gap.before[index]),
                after=nominal.to_measured(gap.after[index]),
                missing_torque=torque,
                speed=nominal.sign * smoothed.rate[nearest],
                deflection=nominal.sign * (smoothed.angle[nearest] - nominal.rest),
                phase=phases(trial, noise),
                held_out=held_out,
                scored=True,
                alone={name: nominal.to_measured(each[index]) for name, each in gap.alone.items()},
            )
        )
    return tuple(made)
