"""Recordings that hold the same samples: saved under two names they are one measurement, not two."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synth.errors import Problem, UserError
from synth.fit.recordings import Recording

LATER = 40  # largest offset, in samples, at which a copy may begin


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
    1e-3 of their range. The copy is the later one, or the held-out one: a fitted recording cannot be used for scoring.
    """
    found = []
    order = sorted(range(len(recordings)), key=lambda k: (held_out[k], k))
    near = _alike([recordings[k] for k in order]) if order else []
    for place, later in enumerate(order):
        for earlier in (order[p] for p in near[place] if p < place):
            if _same(recordings[later], recordings[earlier]):
                found.append((later, earlier))
                break
    return found


def _alike(recordings: Sequence[Recording]) -> list[list[int]]:
    """For each recording the indices of possible copies, where the first sample of one is near the start of the other.

    Compares all pairs by one array operation per recording; calling ``_same`` for each would take minutes for a
    thousand.
    """
    count, n = len(recordings), recordings[0].rotation.shape[1]
    heads = np.full((count, LATER, n), np.inf)
    for index, recording in enumerate(recordings):
        head = recording.rotation[:LATER]
        heads[index, : len(head)] = head
    reach = np.array([max(float(np.ptp(recording.rotation, axis=0).max()), 1e-9) for recording in recordings])
    alike = np.zeros((count, count), dtype=bool)
    for index in range(count):
        apart = np.abs(heads - heads[index, 0]).max(axis=2)
        alike[index] = (apart <= 1e-3 * np.maximum(reach, reach[index])[:, None]).any(axis=1)
    return [np.flatnonzero(alike[index] | alike[:, index]).tolist() for index in range(count)]


def _same(a: Recording, b: Recording) -> bool:
    """Whether one recording's samples are the other's, starting up to ``LATER`` samples later."""
    if a.rotation.shape[1] != b.rotation.shape[1] or a.conditions != b.conditions or a.leg is not b.leg:
        return False
    reach = max(float(np.ptp(b.rotation, axis=0).max()), 1e-9)
    for first, second in ((a, b), (b, a)):
        for offset in range(LATER):
            count = min(len(first.time), len(second.time) - offset)
            if count < 12:
                break
            shifted = second.time[offset : offset + count] - second.time[offset]
            apart = np.abs(first.rotation[:count] - second.rotation[offset : offset + count])
            # Identical but for rounding: a thousandth of the motion, and a tenth of a millisecond.
            if apart.max() <= 1e-3 * reach and np.allclose(first.time[:count], shifted, atol=1e-4):
                return True
    return False
