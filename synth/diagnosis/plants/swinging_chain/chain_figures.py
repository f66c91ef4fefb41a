"""Prediction errors of scored trials, and the trials for report and files."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.plant import StagePredictions
from synth.diagnosis.plants.swinging_chain.chain_result import TrialGap
from synth.diagnosis.plants.swinging_chain.chain_where import MissingTorque, phases
from synth.diagnosis.prediction_error import BLOCKS_A_TRIAL
from synth.diagnosis.verdict import Judgement
from synth.drives.servo import Servo
from synth.swing.leg_model import Leg


def squares(trials: Sequence[AngleTrial], predicted: Sequence[Array]) -> Array:
    """(n_trial, BLOCKS) summed squared errors."""
    found = np.zeros((len(trials), BLOCKS_A_TRIAL))
    for i, (trial, prediction) in enumerate(zip(trials, predicted, strict=True)):
        away = np.where(np.isfinite(prediction), prediction - trial.measured, np.pi)
        square = np.where(trial.counts, away**2, 0.0).sum(axis=1)
        found[i] = [part.sum() for part in np.array_split(square, BLOCKS_A_TRIAL)]
    return found


def trial_gaps(
    nominal: Leg,
    trials: Sequence[AngleTrial],
    stages: StagePredictions[EvaluatedHypothesis, Array],
    missing: Sequence[MissingTorque],
    *,
    held_out: bool,
    noise: Array,
) -> tuple[TrialGap, ...]:
    """Scored trials in measured angles, for the report and the files."""
    made = []
    for index, trial in enumerate(trials):
        smoothed, found, rest = trial.recording.smoothed, missing[index], (trial.recording.leg or nominal).rest
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
                as_designed=nominal.to_measured(stages.as_designed[index]),
                before=nominal.to_measured(stages.before[index]),
                after=nominal.to_measured(stages.after[index]),
                missing_torque=torque,
                speed=nominal.sign * smoothed.rate[nearest],
                deflection=nominal.sign * (smoothed.angle[nearest] - rest),
                phase=phases(trial, noise),
                held_out=held_out,
                scored=True,
                alone={name: nominal.to_measured(each[index]) for name, each in stages.alone.items()},
                command=_command_angles(nominal, trial),
            )
        )
    return tuple(made)


def _command_angles(nominal: Leg, trial: AngleTrial) -> dict[str, Array]:
    """Name of each joint with a commanded servo -> (m,) rad, in its measured angle."""
    signals = trial.recording.signals
    if signals is None:
        return {}
    told = nominal.to_measured(signals.commands_held(trial.time))
    drives = [(j, joint.name, joint.drive) for j, joint in enumerate(nominal.joints)]
    return {name: told[:, j] for j, name, drive in drives if isinstance(drive, Servo) and not drive.open_duty}


def joint_odds(judged: Judgement[EvaluatedHypothesis], leg: Leg) -> dict[str, float]:
    """Joint -> probability that it has a cause."""
    found: dict[str, float] = {}
    for item, probability in judged.singles:
        joint = item.keys[0][1]
        if joint in leg.joint_names:
            found[joint] = found.get(joint, 0.0) + probability
    return found


def joint_errors(trials: Sequence[AngleTrial], predicted: Sequence[Array]) -> Array:
    """(n_trial, n) rad, RMS error of each joint; nan where no sample counts."""
    rms = []
    for trial, prediction in zip(trials, predicted, strict=True):
        squared = np.where(trial.counts, (prediction - trial.measured) ** 2, 0.0).sum(axis=0)
        rms.append(np.sqrt(np.where(trial.counted > 0, squared / np.maximum(trial.counted, 1.0), np.nan)))
    return np.array(rms)
