"""Readings of a sensor that drops out: one value several times in a row, beside the motion or of its last reading.

A bus that times out gives 0, a tracker that loses a marker the corner of its picture. The channel leaps there, stands
still, and leaps back. A joint cannot: one that moves off goes farther in each of its next steps, so a leap beside which
no step is nearly as large is none of a joint.

A driver that repeats its last reading until the next one comes makes one leap, at the end, of all that the joint moved
in the meantime. An encoder with hysteresis does so at turning points: a real double pendulum's reads the same eight
times, then leaps by 0.02 deg, ten times its steps there. A joint that rests, at a stop or by friction, moves off by no
larger step than the next ones.
"""

from __future__ import annotations

import numpy as np

from synth.arrays import Array, Mask

SHORTEST = 4  # equal readings: fewer are runs of outliers, or two counts between which a slow joint stays
BESIDE = 6  # steps on either side that are looked at: a swing of four samples a period has its next half there
SMALL = 0.3  # of the leaps there and back, the largest step beside them
# Of repeated readings. Fewer equal ones are a single one beside the motion, which is an outlier.
SHORTEST_HOLD, BESIDE_HOLD = 3, 4
# Of the channel: 60 ms in recordings of 1 s are left out; what stays longer is frozen, and told as such by the checks.
LONGEST_HOLD = 0.08
LEAST_BESIDE = 2  # steps, of fewer before or after nothing is said
LEAP_OF_HOLD = 1.5  # times the largest step beside it: of three equal readings it is three steps of an even motion


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


def repeated_readings(value: Array, least: float) -> Mask:
    """(n,) True where a channel (n,) without missing samples repeats its last reading while the motion goes on.

    Parameters
    ----------
    least : smallest leap at the end, in the unit of ``value``.

    The first of the equal readings was measured, and stays. Where readings are equal beside them too, as by coarse
    counts or a slow sensor, all stay; so do longer runs, of a frozen channel.
    """
    found = np.zeros(len(value), dtype=bool)
    step = np.diff(value)
    edges = np.flatnonzero(step != 0.0)
    far = np.flatnonzero(np.diff(edges) >= SHORTEST_HOLD)
    for start, end in zip((edges[far] + 1).tolist(), edges[far + 1].tolist(), strict=True):
        before, after = step[max(0, start - BESIDE_HOLD) : start], step[end + 1 : end + 1 + BESIDE_HOLD]
        if min(len(before), len(after)) < LEAST_BESIDE or not (before.all() and after.all()):
            continue
        if end - start + 1 >= LONGEST_HOLD * len(value):
            continue
        if abs(step[end]) > max(least, LEAP_OF_HOLD * max(np.abs(before).max(), np.abs(after).max())):
            found[start + 1 : end + 1] = True
    return found
