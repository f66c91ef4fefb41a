"""Recordings compared with the designed leg: exchanged or inverted columns show as a much better fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial, angle_trial
from synth.diagnosis.check.finding import Finding
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.score import score
from synth.diagnosis.workbench import Workbench
from synth.errors import UserError
from synth.fit.recordings import recordings
from synth.swing.leg_model import Leg
from synth.units import significant

if TYPE_CHECKING:
    from synth.files.trial_list import Trial

SAMPLES_A_TRIAL = 120  # samples per trial: enough to see errors of degrees
MOST_TRIALS = 6  # trials compared, those with the largest motion
# Least factor by which a change of columns must reduce the error; as in ``recordings_together``.
LEAST_IMPROVEMENT = 3.0
NEAR_DESIGN = np.radians(15.0)  # rad RMS: a recording farther from the design has other problems than its columns
LEAST_ERROR = np.radians(2.0)  # rad RMS from the design below which columns are accepted


@dataclass(frozen=True)
class _ColumnChange:
    """A change of a trial's columns, and its meaning."""

    joints: tuple[int, ...]
    text: str
    remedy: str

    def of(self, leg: Leg, trial: Trial) -> Trial:
        angles = trial.angles.copy()
        if len(self.joints) == 2:
            angles[:, list(self.joints)] = angles[:, list(self.joints[::-1])]
        else:
            j = self.joints[0]
            angles[:, j] = 2.0 * leg.joints[j].zero - angles[:, j]
        return replace(trial, angles=angles, velocities=None)


def column_findings(leg: Leg, trials: Sequence[Trial], bench: Workbench) -> list[Finding]:
    """Columns that look exchanged or inverted.

    The designed leg predicts each recording from the best-fitting initial state: unchanged, with two columns
    exchanged, or with one inverted about its joint's zero.
    """
    chosen = sorted(trials, key=lambda t: -float(np.nanmax(np.nanstd(t.angles, axis=0))))[:MOST_TRIALS]
    own = _errors_of_design(leg, chosen, bench)
    best: dict[int, tuple[float, _ColumnChange]] = {}
    for change in _column_changes(leg):
        missed = _errors_of_design(leg, [change.of(leg, trial) for trial in chosen], bench)
        for k, value in enumerate(missed):
            likelier = own[k] > LEAST_ERROR and value < min(own[k] / LEAST_IMPROVEMENT, NEAR_DESIGN)
            if likelier and value < best.get(k, (np.inf, change))[0]:
                best[k] = float(value), change
    found = []
    for change in dict.fromkeys(change for _, change in best.values()):
        places = [k for k, (_, other) in best.items() if other is change]
        worst = places[0]
        names = ", ".join(chosen[k].name for k in places[:3]) + (
            f" and {len(places) - 3} more" if len(places) > 3 else ""
        )
        text = (
            f"{change.text}: the designed leg's error is {significant(np.degrees(own[worst]), 2)} deg RMS as recorded"
        )
        text += f" and {significant(np.degrees(best[worst][0]), 2)} deg with this change"
        found.append(Finding("fault", text, change.remedy, names))
    return found


def _column_changes(leg: Leg) -> list[_ColumnChange]:
    names = leg.joint_names
    made = [
        _ColumnChange(
            (i, j), f"the columns of {names[i]} and {names[j]} look exchanged", "exchange the two names in its header"
        )
        for i, j in combinations(range(len(names)), 2)
    ]
    return made + [
        _ColumnChange(
            (j,),
            f"{names[j]} looks inverted",
            "turn the joint's `sign` in the leg file, or its column",
        )
        for j in range(len(names))
    ]


def _errors_of_design(leg: Leg, trials: Sequence[Trial], bench: Workbench) -> Array:
    """(n_trial,) rad RMS error of the designed leg for each trial; infinite if the simulation fails."""
    found = np.full(len(trials), np.inf)
    made: dict[int, AngleTrial] = {}
    for k, trial in enumerate(trials):
        try:
            (recording,) = recordings(leg, [trial], ())
        except UserError:
            continue
        made[k] = angle_trial(recording, held_out=False).thinner(SAMPLES_A_TRIAL)
    fit = EvaluatedHypothesis((), np.zeros(bench.n_tolerance), ())
    for k, (prediction, _) in zip(made, score(bench, fit, list(made.values())), strict=True):
        trial_made = made[k]
        away = (prediction - trial_made.measured)[trial_made.counts]
        if len(away) and np.all(np.isfinite(away)):
            found[k] = float(np.sqrt(np.mean(away**2)))
    return found
