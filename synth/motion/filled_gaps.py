"""Stretches of a channel that a program filled in: no reading scatters as little.

Capture programs bridge frames without a marker by a straight line or a cubic. Among readings that scatter such a
stretch shows itself: its second or fourth differences vanish, while those of the samples around it have the size that
the noise gives them. Taken for measured, two lines of 30 to 120 ms in each channel made 90 % intervals hold 72 to 78 %.
"""

from __future__ import annotations

import numpy as np

from synth.arrays import Array, Mask
from synth.noise import robust_deviation

ORDERS = (2, 4)  # of differences, that a straight line and a cubic do not have
# Of their deviation, below which a difference is none. White noise is so by chance in one of sixty samples, in
# ``SHORTEST`` beside each other in one of ten million.
NONE = 0.02
SHORTEST = 4
# Of their deviation, a difference on either side of the stretch. A motion that grows quiet has small ones beside it;
# one that passes smoothly through zero with four below 0.02 reaches 0.1 in eight more.
KINK = 0.3
# Times the order, differences on either side of which one shows it: the first ones of a cubic spline share its slope
# and curvature with it.
BESIDE = 2
COARSEST = 0.1  # of the deviation of differences, the channel's count: a coarser one makes lines of slow motions
EVEN_STAMPS = 0.02  # of the step, range of the steps: stamps are written with few digits
LEAST_DIFFERENCES = 20  # from which their usual size is known


def filled_gaps(time: Array, value: Array) -> Mask:
    """(n,) True in the inside of stretches of a channel (n,), at ``time`` (n,) s, that lie on a line or a cubic.

    The samples at both ends of a stretch were measured, and stay. Nothing is said of unevenly sampled stretches, nor of
    those that repeat a reading, as a slow sensor does, see ``stuck_readings``.
    """
    found = np.zeros(len(value), dtype=bool)
    if len(value) <= LEAST_DIFFERENCES:
        return found
    step = np.diff(time)
    even = np.abs(step - np.median(step)) < EVEN_STAMPS * np.median(step)
    apart = np.diff(np.unique(value))
    count = float(apart.min(initial=np.inf, where=apart > 1e-12))
    for order in ORDERS:
        size = np.abs(np.diff(value, order))[_windows(even, order)]
        usual = robust_deviation(size) if len(size) >= LEAST_DIFFERENCES else 0.0
        if count > COARSEST * usual:
            continue
        size = np.where(_windows(even, order), np.abs(np.diff(value, order)), np.nan)
        edges = np.flatnonzero(np.diff(np.r_[False, size < NONE * usual, False].astype(int)))
        for start, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):  # of differences, end excluded
            beside = size[max(0, start - BESIDE * order) : start], size[end : end + BESIDE * order]
            kinked = all(np.nanmax(each, initial=0.0) > KINK * usual for each in beside)
            inside = slice(start + 1, end + order - 1)
            if end - start >= SHORTEST and kinked and np.diff(value[inside]).all():
                found[inside] = True
    return found


def _windows(even: Mask, order: int) -> Mask:
    """(n - order,) whether all steps, of which ``even`` (n - 1,) tells, of a difference of this order are even."""
    return np.asarray(np.lib.stride_tricks.sliding_window_view(even, order).all(axis=1))
