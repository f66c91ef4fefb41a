"""Channels with coarse counts, found from the readings alone without a model of the motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial
from synth.diagnosis.sensor_noise import AngleSensor

COARSER = 2.5  # times the other channels' counts, or noise, from which a count is a cause
ALONE = np.radians(0.36)  # rad, 1000 counts per turn: for a leg of one joint, without another channel


@dataclass(frozen=True)
class Coarse:
    """A joint whose readings change in steps of ``step`` rad, coarser than those of the other joints."""

    joint: int
    step: float


def coarse_counts(sensor: AngleSensor) -> tuple[Coarse, ...]:
    """Joints whose count is ``COARSER`` times the others' median and causes more error than their noise."""
    found = []
    for j, step in enumerate(sensor.step):
        others = [k for k in range(len(sensor.step)) if k != j]
        if not others:
            if step > ALONE:
                found.append(Coarse(j, float(step)))
            continue
        usual = float(np.median(sensor.noise[others]))
        if step / np.sqrt(12.0) > COARSER * usual and step > COARSER * float(np.median(sensor.step[others])):
            found.append(Coarse(j, float(step)))
    return tuple(found)


def usual_noise(sensor: AngleSensor, coarse: Sequence[Coarse]) -> Array:
    """(n,) rad, each channel's noise without its coarse counts: as stated, else that of the other channels."""
    noise = sensor.noise.copy()
    rough = [item.joint for item in coarse if item.joint not in sensor.known]
    fine = [j for j in range(len(noise)) if j not in [item.joint for item in coarse]]
    if fine:
        noise[rough] = float(np.median(noise[fine]))
    return noise


def rounded(trial: AngleTrial, prediction: Array, coarse: Sequence[Coarse]) -> Array:
    """A prediction (m, n) rad in the sense of q, rounded like channels with coarse counts.

    The counts are aligned with the recording's.
    """
    reading = prediction.copy()
    for item in coarse:
        j = item.joint
        if j in trial.free:
            origin = trial.measured[np.flatnonzero(trial.counts[:, j])[0], j]
            reading[:, j] = origin + np.round((prediction[:, j] - origin) / item.step) * item.step
    return reading
