"""Channels with coarse counts, found from the readings alone without a model of the motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import erfc, sqrt

import numpy as np

from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial
from synth.fit.sensor_noise import AngleSensor

UNIFORM_DEVIATION = 1.0 / np.sqrt(12.0)  # standard deviation of a uniform distribution of width 1
# Counts to either side that noise may carry a reading: it is less than ``UNIFORM_DEVIATION`` of a count.
COUNTS_BESIDE = 3
COARSER_RATIO = 2.5  # times the other channels' counts, or noise, from which a count is a cause
LEAST_SHARE = 0.1  # of the error, as of any cause beside another; a choice
COARSE_ALONE = np.radians(0.36)  # rad, 1000 counts per turn: for a leg of one joint, without another channel


@dataclass(frozen=True)
class CoarseChannel:
    """A joint whose readings change in steps of ``step`` rad, coarser than those of the other joints."""

    joint: int
    step: float


def coarse_counts(sensor: AngleSensor) -> tuple[CoarseChannel, ...]:
    """Joints whose count is ``COARSER_RATIO`` times the others' median and causes more error than their noise."""
    found = []
    for j, step in enumerate(sensor.step):
        others = [k for k in range(len(sensor.step)) if k != j]
        if not others:
            if step > COARSE_ALONE:
                found.append(CoarseChannel(j, float(step)))
            continue
        usual = float(np.median(sensor.noise[others]))
        if UNIFORM_DEVIATION * step > COARSER_RATIO * usual and step > COARSER_RATIO * float(
            np.median(sensor.step[others])
        ):
            found.append(CoarseChannel(j, float(step)))
    return tuple(found)


def counts_matter(trials: Sequence[AngleTrial], predictions: Sequence[Array], coarse: Sequence[CoarseChannel]) -> bool:
    """Whether coarse counts make ``LEAST_SHARE`` of the error that an explanation leaves.

    ``predictions`` (m, n) rad of each trial, not rounded.
    """
    if not coarse:
        return False
    rounded = total = 0.0
    for trial, prediction in zip(trials, predictions, strict=True):
        away = np.where(trial.counts, prediction - trial.measured, 0.0)
        total += float(np.nansum(away**2))
        sizes = [(UNIFORM_DEVIATION * item.step) ** 2 * trial.counts[:, item.joint].sum() for item in coarse]
        rounded += float(np.sum(sizes))
    return rounded >= (1.0 - (1.0 - LEAST_SHARE) ** 2) * total


def usual_noise(sensor: AngleSensor, coarse: Sequence[CoarseChannel]) -> Array:
    """(n,) rad, each channel's noise without its coarse counts: as stated, else that of the other channels."""
    noise = sensor.noise.copy()
    rough = [item.joint for item in coarse if item.joint not in sensor.known]
    fine = [j for j in range(len(noise)) if j not in [item.joint for item in coarse]]
    if fine:
        noise[rough] = float(np.median(noise[fine]))
    return noise


def round_to_counts(trial: AngleTrial, prediction: Array, coarse: Sequence[CoarseChannel]) -> Array:
    """A prediction (m, n) rad in the sense of q, rounded like channels with coarse counts.

    The counts are aligned with the recording's.
    """
    reading = prediction.copy()
    for item in coarse:
        j = item.joint
        if j in trial.free:
            origin = _count_origin(trial, j)
            reading[:, j] = origin + np.round((prediction[:, j] - origin) / item.step) * item.step
    return reading


def noise_as_read(
    trials: Sequence[AngleTrial], predictions: Sequence[Array], coarse: Sequence[CoarseChannel], usual: Array
) -> list[Array]:
    """(m, n) rad of each trial, the ``noise_of_rounded`` predictions, (m, n) rad before rounding.

    The ``usual`` noise of a coarse channel is that of another sensor, the most that is believed of it: where it would
    turn more readings than are off, those tell it. Else it would hide what is not explained at another joint.
    """
    made = [noise_of_rounded(trial, each, coarse, usual) for trial, each in zip(trials, predictions, strict=True)]
    seen, expected = np.zeros(len(usual)), np.zeros(len(usual))
    for trial, prediction, noise in zip(trials, predictions, made, strict=True):
        away = round_to_counts(trial, prediction, coarse) - trial.measured
        seen += np.where(trial.counts & np.isfinite(away), away**2, 0.0).sum(axis=0)
        expected += np.where(trial.counts & np.isfinite(away), noise**2, 0.0).sum(axis=0)
    less = np.ones(len(usual))
    for j in {item.joint for item in coarse}:
        less[j] = sqrt(min(seen[j] / expected[j], 1.0)) if expected[j] > 0.0 else 1.0
    return [noise * less for noise in made]


def noise_of_rounded(trial: AngleTrial, prediction: Array, coarse: Sequence[CoarseChannel], usual: Array) -> Array:
    """(m, n) rad, RMS expected between readings and the ``prediction`` (m, n) rad by ``round_to_counts``, itself not
    rounded.

    A reading is the angle with its noise s, ``usual`` (n,) rad, rounded: it is k counts or more away where the noise
    carries the angle over the k-th edge, whose distance is d, with the probability Q(d/s). The mean square is the
    count's times the sum of (2 k - 1) Q(d_k/s) over the edges of both sides. Of angles spread evenly over counts much
    wider than the noise it is step s sqrt(2/pi): a noise of one hundredth of a count becomes nine hundredths.
    """
    noise = np.tile(usual, (len(prediction), 1))
    for item in coarse:
        j = item.joint
        if j in trial.free and 0.0 < usual[j] < UNIFORM_DEVIATION * item.step:
            away = (prediction[:, j] - _count_origin(trial, j)) / item.step
            within = away - np.round(away)
            square = np.zeros(len(away))
            for k in range(1, COUNTS_BESIDE + 1):
                for edge in (k - 0.5 - within, k - 0.5 + within):
                    square += (2 * k - 1) * _tail_probability(edge * item.step / usual[j])
            noise[:, j] = item.step * np.sqrt(square)
    return noise


def _tail_probability(deviations: Array) -> Array:
    """(m,) probability that a normal variable is so many ``deviations`` or more above its mean."""
    return np.array([0.5 * erfc(x / sqrt(2.0)) for x in deviations.tolist()])


def _count_origin(trial: AngleTrial, joint: int) -> float:
    """Rad, a reading of the joint, from which all are whole counts away."""
    return float(trial.measured[np.flatnonzero(trial.counts[:, joint])[0], joint])
