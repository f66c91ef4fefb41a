"""Trials that a fit does not follow: because small errors grow along their motion, or for what is wrong in them.

Over the top of a pendulum deviations grow like exp(t sqrt(g / l)). The cost of whole recordings then has many minima,
and in a wrong one the misfit says nothing about the recording.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from synth.arrays import Array
from synth.fit.filtered_readings import likely_filter
from synth.fit.fit_result import TrialFit
from synth.fit.least_squares import Solution
from synth.fit.odd_trials import odd_trials
from synth.fit.recordings import Recording
from synth.fit.trajectories import Sensitivity, TrajectoryModel
from synth.fit.trial_fits import away_from_their_starts
from synth.fit.uncertainty import residuals
from synth.swing.leg_model import Leg

# Of a joint's motion in a trial, RMS misfit beyond which the fit has lost it: the gap's limit for a nominal leg too.
LOST_SHARE = 0.25
# Times that a deviation of an initial angle grows: 1.0 in the releases of ../shared/aarl, 6 to 13 in the free swings of
# ../shared/double_pendulum, 100 and more where both links go over the top.
MOST_GROWTH = 4.0


def sentences_on_trials(
    model: TrajectoryModel,
    recordings: Sequence[Recording],
    leg: Leg,
    trials: Sequence[TrialFit],
    chosen: Solution,
    judged: Sequence[int],
    follower: str = "",
) -> list[str]:
    """Sentences on trials that are lost, differ from the others, or start elsewhere.

    ``leg`` : the fitted one. ``chosen`` : the solution that ``trials`` are of. ``judged`` : joints whose free angles,
    one in each trial, are compared; not in trials where they are locked. ``follower`` : of a wanted motion, the leg in
    words: its trials are right, however little the leg follows them.
    """
    lost = lost_sensitive(model, recordings, chosen)
    kept = [trial for t, trial in enumerate(trials) if t not in lost]
    rms = np.array([trial.rms for trial in kept])
    free = np.full_like(rms, np.nan)
    for t, trial in enumerate(kept):
        own = [j for j in judged if np.isfinite(trial.rms[j])]
        free[t, own] = trial.free_angle[own]
    odd = [] if follower else odd_trials([t.name for t in kept], leg.joint_names, rms, free)
    away = away_from_their_starts(leg, kept, recordings[0].unit, follower, likely_filter(recordings))
    return [*_lost_sentences(leg, trials, lost), *odd, *away]


def lost_trials(recordings: Sequence[Recording], predictions: Sequence[Array]) -> list[int]:
    """Indices of the recordings that ``predictions`` (m, n) rad do not follow."""
    found = []
    for t, (recording, prediction) in enumerate(zip(recordings, predictions, strict=True)):
        seen = recording.counts.any(axis=0)
        off = residuals(recording, prediction)[:, seen]
        motion = np.where(recording.counts, recording.rotation, np.nan)[:, seen]
        if not np.all(np.nanmean(off**2, axis=0) <= LOST_SHARE**2 * np.nanvar(motion, axis=0)):
            found.append(t)
    return found


def lost_sensitive(model: TrajectoryModel, recordings: Sequence[Recording], solution: Solution) -> dict[int, float]:
    """By index, of the trials that the fit does not follow: times that deviations grow, where they do."""
    grown: dict[int, float] = {}
    for t in lost_trials(recordings, solution.predictions):
        values, recording = solution.values, recordings[t]
        lanes = solution.lanes[t] if solution.lanes else model.sensitivity(recording, values, solution.locals[t])
        times = _growth(lanes, recording.free, len(values))
        if times > MOST_GROWTH:
            grown[t] = times
    return grown


def _growth(lanes: Sensitivity, free: Sequence[int], n_common: int) -> float:
    """Times that a deviation of an initial angle grows along the simulated motion; nan if that diverges."""
    plan, angles = lanes.plan, slice(n_common, n_common + len(free))
    grown = lanes.differences()[:, free][:, :, plan.order[angles]] / plan.width[plan.order[angles]]
    return float(np.abs(grown).max(initial=0.0))


def _lost_sentences(leg: Leg, trials: Sequence[TrialFit], lost: Mapping[int, float]) -> list[str]:
    """A sentence on each trial of ``lost``, see ``lost_sensitive``."""
    found = []
    for t, times in lost.items():
        rms = np.nan_to_num(np.degrees(trials[t].rms))
        joint = int(np.argmax(rms))
        found.append(
            f"{trials[t].name}: the fit does not follow this motion: {leg.joint_names[joint]} is {rms[joint]:.3g} deg "
            f"RMS there. A deviation at its start grows {float(f'{times:.2g}'):.0f} times along it, so small errors of "
            "the model are enough, and the recording need not be wrong. Fit a shorter part of it (synth import cuts "
            "it), or leave it out"
        )
    return found
