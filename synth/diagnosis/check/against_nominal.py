"""Recordings held against the leg as designed: columns exchanged or turned round show by how much nearer it comes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial, angle_trial
from synth.diagnosis.check.finding import Finding
from synth.diagnosis.score import score
from synth.diagnosis.workbench import EvaluatedHypothesis, Workbench
from synth.errors import UserError
from synth.fit.recordings import recordings
from synth.swing.leg_model import Leg

if TYPE_CHECKING:
    from synth.files.trial_list import Trial

SAMPLES = 120  # of a trial: enough for an error of degrees
MOST = 6  # trials that are looked at, those that move most
NEARER = (
    3.0  # times nearer to the design a recording must come by a change of its columns; as in ``recordings_together``
)
NEAR = np.radians(15.0)  # rad RMS: what stays farther off than that is another matter than its columns
WORTH = np.radians(2.0)  # rad RMS from the design, below which columns are what they say


@dataclass(frozen=True)
class _Change:
    """What is done to the columns of a trial, and what that would mean."""

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
    """Columns that look exchanged, or measured the other way round.

    Each recording is predicted by the leg as designed, from the initial state that fits best, as it is and with two
    columns exchanged or one turned about its joint's zero.
    """
    chosen = sorted(trials, key=lambda t: -float(np.nanmax(np.nanstd(t.angles, axis=0))))[:MOST]
    own = _misses(leg, chosen, bench)
    best: dict[int, tuple[float, _Change]] = {}
    for change in _changes(leg):
        missed = _misses(leg, [change.of(leg, trial) for trial in chosen], bench)
        for k, value in enumerate(missed):
            likelier = own[k] > WORTH and value < min(own[k] / NEARER, NEAR)
            if likelier and value < best.get(k, (np.inf, change))[0]:
                best[k] = float(value), change
    found = []
    for change in dict.fromkeys(change for _, change in best.values()):
        places = [k for k, (_, other) in best.items() if other is change]
        worst = places[0]
        names = ", ".join(chosen[k].name for k in places[:3]) + (
            f" and {len(places) - 3} more" if len(places) > 3 else ""
        )
        text = f"{change.text}: as recorded the leg as designed misses it by {np.degrees(own[worst]):.2g} deg RMS, so "
        text += f"changed by {np.degrees(best[worst][0]):.2g} deg"
        found.append(Finding("fault", text, change.remedy, names))
    return found


def _changes(leg: Leg) -> list[_Change]:
    names = leg.joint_names
    made = [
        _Change(
            (i, j), f"the columns of {names[i]} and {names[j]} look exchanged", "exchange the two names in its header"
        )
        for i, j in combinations(range(len(names)), 2)
    ]
    return made + [
        _Change(
            (j,),
            f"{names[j]} looks measured the other way round",
            "turn the joint's `sign` in the leg file, or its column",
        )
        for j in range(len(names))
    ]


def _misses(leg: Leg, trials: Sequence[Trial], bench: Workbench) -> Array:
    """(n_trial,) rad RMS by which the leg as designed misses each; infinite where it cannot be read or followed."""
    found = np.full(len(trials), np.inf)
    made: dict[int, AngleTrial] = {}
    for k, trial in enumerate(trials):
        try:
            (recording,) = recordings(leg, [trial], ())
        except UserError:
            continue
        made[k] = angle_trial(recording, held_out=False).thinner(SAMPLES)
    fit = EvaluatedHypothesis((), np.zeros(bench.n_tolerance), ())
    for k, (prediction, _) in zip(made, score(bench, fit, list(made.values())), strict=True):
        trial_made = made[k]
        away = (prediction - trial_made.measured)[trial_made.counts]
        if len(away) and np.all(np.isfinite(away)):
            found[k] = float(np.sqrt(np.mean(away**2)))
    return found
