"""Readings of a sensor that drops out: one value several times in a row, beside the motion.

A bus that times out gives 0, a tracker that loses a marker the corner of its picture. The channel leaps there, stands
still, and leaps back. A joint cannot: one that moves off goes farther in each of its next steps, so a leap beside which
no step is nearly as large is none of a joint.
"""

from __future__ import annotations

import numpy as np

from synth.arrays import Array, Mask

SHORTEST = 4  # equal readings: fewer are runs of outliers, or two counts between which a slow joint stays
BESIDE = 6  # steps on either side that are looked at: a swing of four samples a period has its next half there
SMALL = 0.3  # of the leaps there and back, the largest step beside them


def stuck_readings(value: Array, least: float) -> Mask:
    """(n,) True where a channel (n,) without missing samples leaps away, stays at one value exactly, and leaps back.

    Parameters
    ----------
    least : smallest leap, in the unit of ``value``.

    Where the channel stands still before or after, it is left as it is: a servo that is logged slowly leaps from
    command to command.
    """
    found = np.zeros(len(value), dtype=bool)
    step = np.diff(value)
    edges = np.flatnonzero(step != 0.0)
    for start, end in zip((edges[:-1] + 1).tolist(), edges[1:].tolist(), strict=True):  # not those at both ends
        size = min(abs(step[start - 1]), abs(step[end]))
        if end - start + 1 < SHORTEST or step[start - 1] * step[end] > 0.0 or size <= least:
            continue
        before, after = np.abs(step[max(0, start - 1 - BESIDE) : start - 1]), np.abs(step[end + 1 : end + 1 + BESIDE])
        if before.any() and after.any() and max(before.max(), after.max()) < SMALL * size:
            found[start : end + 1] = True
    return found
