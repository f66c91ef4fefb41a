"""Recordings that hold the same samples: saved under two names they are one measurement, not two."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.fit.recordings import Recording
from synth.motion.counts import LEAST_GAP, on_counts, width_of
from synth.remarks import noted

HALF_STEP = 0.51  # of a step, that rounding takes at most; the rest is how the rounded value is written
NOISE_SHARE = 0.1  # of a channel's noise; two readings with noise of their own are 1.4 of it apart, RMS
LEAST_SHARED_SAMPLES = 12  # samples that two recordings must share
MOST_OFFSET = 40  # largest offset, in samples, at which a copy may begin


def without_copies(
    fitted: Sequence[Recording], held_out: Sequence[Recording], project: str, key: str = "trials"
) -> tuple[list[Recording], list[Recording], tuple[str, ...]]:
    """The recordings without copies of others among them, and a warning on each that is left out.

    Raises
    ------
    UserError : a held-out recording is a copy of a fitted one, which could only confirm itself.
    """
    every, problems, warnings, left_out = [*fitted, *held_out], [], [], set()
    for later, earlier in copies(every, [k >= len(fitted) for k in range(len(every))]):
        copy, first = every[later].name, every[earlier].name
        if later >= len(fitted) > earlier:
            text = (
                f"{copy} is held out, but holds the same samples as {first}, which is fitted: it would be the check of "
            )
            problems.append(Problem(f"{text}itself. Remove one of the two, or hold out both", project, key=key))
        left_out.add(later)
        warnings.append(
            f"{copy} holds the same samples as {first} and is left out: a copy is no further measurement, and would "
            "make the intervals too narrow"
        )
    if problems:
        raise UserError(problems)
    kept = [
        [k for k in range(len(every)) if k not in left_out and (k < len(fitted)) == first] for first in (True, False)
    ]
    return [every[k] for k in kept[0]], [every[k] for k in kept[1]], tuple(warnings)


def copies(recordings: Sequence[Recording], held_out: Sequence[bool]) -> list[tuple[int, int]]:
    """Pairs (copy, original) of recordings that hold the same samples and count as one measurement.

    Includes recordings cut short, starting a few samples later, or saved with fewer digits: the shared samples agree to
    1e-3 of their range, and as nearly as rounding leaves them. A repeat with noise of its own is no copy, however well
    the motion repeats. The copy is the later one, or the held-out one: a fitted recording cannot be used for scoring.
    """
    found = []
    order = sorted(range(len(recordings)), key=lambda k: (held_out[k], k))
    near = _possible_copies([recordings[k] for k in order]) if order else []
    read: dict[int, _Readings] = {}
    for place, later in enumerate(order):
        for earlier in (order[p] for p in near[place] if p < place):
            for k in (later, earlier):
                if k not in read:
                    read[k] = _Readings.of(recordings[k])
            if _same_samples(recordings[later], recordings[earlier], _rounding_difference(read[later], read[earlier])):
                found.append((later, earlier))
                break
    return found


def told_copies(recordings: Sequence[Recording], held_out: Sequence[bool]) -> tuple[set[int], list[str]]:
    """Indices of the recordings that are ``copies`` of others, and a remark on each."""
    found = copies(recordings, held_out)
    names = [recording.name for recording in recordings]
    return {a for a, _ in found}, [noted(f"{names[a]} is a copy of {names[b]} and is left out") for a, b in found]


def _possible_copies(recordings: Sequence[Recording]) -> list[list[int]]:
    """For each recording the indices of possible copies, where the first sample of one is near the start of the other.

    Compares all pairs by one array operation per recording; calling ``_same_samples`` for each would take minutes for a
    thousand.
    """
    count, n = len(recordings), recordings[0].rotation.shape[1]
    heads = np.full((count, MOST_OFFSET, n), np.inf)
    for index, recording in enumerate(recordings):
        head = recording.rotation[:MOST_OFFSET]
        heads[index, : len(head)] = head
    reach = np.array([max(float(np.ptp(recording.rotation, axis=0).max()), 1e-9) for recording in recordings])
    alike = np.zeros((count, count), dtype=bool)
    for index in range(count):
        apart = np.abs(heads - heads[index, 0]).max(axis=2)
        alike[index] = (apart <= 1e-3 * np.maximum(reach, reach[index])[:, None]).any(axis=1)
    return [np.flatnonzero(alike[index] | alike[:, index]).tolist() for index in range(count)]


@dataclass(frozen=True)
class _Readings:
    """``noise`` (n,) rad, and ``step`` (n,) rad between readings that were rounded, 0 if they were not."""

    noise: Array
    step: Array

    @classmethod
    def of(cls, recording: Recording) -> _Readings:
        """As one recording shows them."""
        step = np.zeros(len(recording.levels))
        for j, levels in enumerate(recording.levels):
            width = width_of(np.diff(levels), LEAST_GAP)
            step[j] = width if width > 0.0 and on_counts(levels, width) else 0.0
        return cls(np.nan_to_num(recording.smoothed.noise), step)


def _rounding_difference(one: _Readings, other: _Readings) -> Array:
    """(n,) rad, by how much readings differ at most that were rounded on the way: not two readings of the same motion.

    Half the coarser step that either's readings show, or ``NOISE_SHARE`` of the lesser noise, which no two readings
    with noise of their own keep to all along.
    """
    steps = HALF_STEP * np.maximum(one.step, other.step)
    return np.asarray(np.maximum(steps, NOISE_SHARE * np.minimum(one.noise, other.noise)) + LEAST_GAP)


def _same_samples(a: Recording, b: Recording, rounding: Array) -> bool:
    """Whether one recording's samples are the other's, starting up to ``MOST_OFFSET`` samples later.

    ``rounding`` (n,) rad: what rounding may take.
    """
    if a.rotation.shape[1] != b.rotation.shape[1] or a.conditions != b.conditions or a.leg is not b.leg:
        return False
    reach = max(float(np.ptp(b.rotation, axis=0).max()), 1e-9)
    for first, second in ((a, b), (b, a)):
        for offset in range(MOST_OFFSET):
            count = min(len(first.time), len(second.time) - offset)
            if count < LEAST_SHARED_SAMPLES:
                break
            begun = np.abs(
                first.rotation[:LEAST_SHARED_SAMPLES] - second.rotation[offset : offset + LEAST_SHARED_SAMPLES]
            )
            if np.any(begun.max(axis=0) > rounding):  # nearly all repeats end here
                continue
            shifted = second.time[offset : offset + count] - second.time[offset]
            apart = np.abs(first.rotation[:count] - second.rotation[offset : offset + count])
            # A thousandth of the motion, and a tenth of a millisecond; then identical but for rounding.
            near = apart.max() <= 1e-3 * reach and np.allclose(first.time[:count], shifted, atol=1e-4)
            if near and np.all(apart.max(axis=0) <= rounding):
                return True
    return False
