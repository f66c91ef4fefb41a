"""Information in coarse counts: little while a reading is constant, almost all at a transition.

At a transition the joint is at the edge between two counts, known to within the motion of one
sample, however wide the count. This is event time-stamping of encoders (Merry, van de Molengraft & Steinbuch,
Mechatronics 20 (2010) 20). Between transitions a reading only says that the joint is within the count.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial
from synth.diagnosis.encoder_counts import UNIFORM_DEVIATION, CoarseChannel

LEAST_AT_REST, MOST_AT_REST = 4, 12  # least samples of a constant reading for one to be used, and most that are used


def with_edges(trial: AngleTrial, coarse: Sequence[CoarseChannel], usual: Array) -> AngleTrial:
    """The trial with each coarse channel's samples at transitions replaced by their edges, others not counted.

    ``usual`` (n,) rad: each channel's noise without coarse counts, the unit of ``relative`` of the new trial.
    A sample beside an edge lies half a step's motion before or after it, with that motion as uncertainty; one
    between two edges lies at their mean. Readings that skip counts keep their value within half a count; so
    does a constant reading, whose few samples count together as one.
    """
    # A leg without a finer channel does not show its noise without counts.
    concerned = [c for c in coarse if c.joint in trial.free and usual[c.joint] < UNIFORM_DEVIATION * c.step]
    if not concerned:
        return trial
    measured, counts = trial.measured.copy(), trial.counts.copy()
    relative = np.ones(measured.shape)
    for item in concerned:
        j = item.joint
        used = np.flatnonzero(trial.counts[:, j])
        value, error = _edges_of_channel(trial.time[used], trial.measured[used, j], item.step)
        kept = np.isfinite(error)
        counts[:, j] = False
        counts[used[kept], j] = True
        measured[used[kept], j] = value[kept]
        relative[used[kept], j] = np.hypot(1.0, error[kept] / usual[j])
    return replace(trial, measured=measured, counts=counts, relative=relative)


def _edges_of_channel(time: Array, reading: Array, step: float) -> tuple[Array, Array]:
    """Angle (m,) rad at each sample and its deviation (m,) from the counts; inf for a sample without information."""
    jump = np.diff(reading) / step
    count = np.round(jump)
    turn = np.minimum(_motion_between_samples(time, reading, count, step), step)
    edge = 0.5 * (reading[:-1] + reading[1:])
    single = np.abs(count) == 1.0
    half = 0.5 * np.sign(count) * turn
    total, number, squared = np.zeros(len(reading)), np.zeros(len(reading)), np.zeros(len(reading))
    for place, value in ((slice(None, -1), edge - half), (slice(1, None), edge + half)):
        total[place] += np.where(single, value, 0.0)
        number[place] += single
        # Both samples of an edge have the same error: together they count as one.
        squared[place] += np.where(single, 2.0 * (UNIFORM_DEVIATION * turn) ** 2, 0.0)
    skipped = np.zeros(len(reading), dtype=bool)
    skipped[:-1] |= np.abs(count) > 1.0
    skipped[1:] |= np.abs(count) > 1.0
    known = np.maximum(number, 1.0)
    angle = np.where(number > 0.0, total / known, reading)
    error = np.where(number > 0.0, np.sqrt(squared) / known, np.inf)
    error[skipped & (number == 0.0)] = UNIFORM_DEVIATION * step
    for first, last in _constant_runs(count):
        number_taken = min((last - first) // LEAST_AT_REST, MOST_AT_REST)
        if number_taken:
            taken = np.linspace(first, last, 2 * number_taken + 1)[1::2].round().astype(int)
            error[taken] = UNIFORM_DEVIATION * step * np.sqrt(number_taken)
    return angle, error


def _motion_between_samples(time: Array, reading: Array, count: Array, step: float) -> Array:
    """(m - 1,) rad, motion of the joint between samples, from the neighbouring edges."""
    edges = np.flatnonzero(count != 0.0)
    if len(edges) < 2:
        return np.full(len(count), step)
    when = 0.5 * (time[edges] + time[edges + 1])
    far = np.abs(np.diff(reading[edges] + reading[edges + 1])) / 2.0  # from edge to edge; zero if the motion reverses
    speed = np.maximum(far, 0.25 * step) / np.diff(when)
    before, after = np.concatenate([speed[:1], speed]), np.concatenate([speed, speed[-1:]])
    found = np.zeros(len(count))
    found[edges] = np.maximum(before, after) * np.diff(time)[edges]
    return found


def _constant_runs(count: Array) -> list[tuple[int, int]]:
    """First and last index of each run of equal readings."""
    ends = np.flatnonzero(count != 0.0)
    starts = np.concatenate([[0], ends + 1])
    return [(int(a), int(b)) for a, b in zip(starts, np.concatenate([ends, [len(count)]]), strict=True)]
