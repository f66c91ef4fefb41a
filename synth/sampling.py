"""The sample step of channels that share a table of times: that between a channel's own samples.

Joints may be read a moment apart, as by two publishers on one topic, or at different rates. A row then has a sample of
some channels and empty cells of the others, which miss nothing, and the step from row to row is that of no channel.
"""

from __future__ import annotations

from collections.abc import Callable
from math import floor

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array, Mask

# Of a channel's step: so near to its own sample an empty cell is another channel's moment. Half, and jitter.
BESIDE = 0.6
ROUNDING = 1e-3  # of a step, by which a whole number of them may seem to be less
# Such rows, alone and of the channel's samples: fewer are lost samples of a shaky clock.
LEAST_ROWS, LEAST_SHARE = 12, 0.1


def channel_step(time: Array, known: Mask) -> float:
    """Usual time between the samples of one channel, lost ones included, s; nan for fewer than two.

    ``time`` (m,) s of the rows, rising; ``known`` (m,) True where the channel has a sample.
    """
    if known.all():
        return _median_step(time)
    # Over lost samples a shaky clock's steps would seem longer.
    return _median_step(time[known if known.sum() < LEAST_ROWS else own_moments(time, known[:, None])[:, 0]])


def usual_step(time: Array, known: Mask) -> float:
    """Usual time between the samples of the channel that is sampled fastest, s.

    ``time`` (m,) s of the rows, rising; ``known`` (m, n) True where a channel has a sample. Without any two samples of
    one channel the step from row to row.
    """
    steps = {channel_step(time, own) for own in _distinct(known)}
    return min((step for step in steps if step > 0.0), default=float(np.median(np.diff(time))))


def own_moments(time: Array, known: Mask) -> Mask:
    """(m, n) True at the rows of each channel: its samples, and the empty cells in which one is missing.

    False where only others are sampled. ``time`` (m,) s of the rows, rising; ``known`` (m, n) True where a channel has
    a sample.
    """
    own = np.ones_like(known)
    for j in np.flatnonzero(~known.all(axis=0)):
        at = time[known[:, j]]
        if len(at) < LEAST_ROWS:
            continue
        step = _median_step(at)
        beside = ~known[:, j] & (np.abs(time - at[_nearest(at, time)]) <= BESIDE * step)
        if beside.sum() >= max(LEAST_ROWS, LEAST_SHARE * len(at)):
            expected = _expected(at, step, float(time[0]), float(time[-1]))
            rows = _nearest(time, expected)
            own[:, j] = known[:, j]
            own[rows[np.abs(time[rows] - expected) <= BESIDE * step], j] = True
    return own


def densest_clock(time: Array, own: Mask) -> Array:
    """(k,) s, the moments of the channel that has the most of them; ``own`` (m, n) as of ``own_moments``."""
    return time if own.all() or not own.size else time[own[:, int(np.argmax(own.sum(axis=0)))]]


def every_nth(own: Mask, samples: int, whole: Callable[[float], int] = floor) -> Mask:
    """(m, n) True at about ``samples`` moments of each channel, evenly spaced; ``own`` (m, n) as of ``own_moments``.

    ``whole`` : makes a whole number of their ratio. Of channels that are sampled a moment apart every n-th row might
    be of one channel only.
    """
    kept = np.zeros_like(own)
    for j, moments in enumerate(own.T):
        rows = np.flatnonzero(moments)
        kept[rows[:: max(1, whole(len(rows) / samples))], j] = True
    return kept


def _median_step(time: Array) -> float:
    """s; nan for fewer than two of the rising ``time`` (n,) s."""
    return float(np.median(np.diff(time))) if len(time) > 1 else float("nan")


def _nearest(at: Array, time: Array) -> NDArray[np.intp]:
    """Indices (k,) of those of the rising ``at`` (n,), at least two, that are nearest to each ``time`` (k,)."""
    after = np.searchsorted(at, time).clip(1, len(at) - 1)
    return np.where(time - at[after - 1] <= at[after] - time, after - 1, after)


def _expected(at: Array, step: float, first: float, last: float) -> Array:
    """Times (k,) s from ``first`` to ``last`` of samples that are missing in holes of a channel's own ``at`` (n,)."""
    left = np.rint(np.diff(at) / step).astype(int) - 1
    inside = [np.linspace(at[k], at[k + 1], left[k] + 2)[1:-1] for k in np.flatnonzero(left > 0)]
    before, after = (np.arange(1, int(span / step + ROUNDING) + 1) for span in (at[0] - first, last - at[-1]))
    return np.concatenate([at[0] - step * before, *inside, at[-1] + step * after])


def _distinct(known: Mask) -> list[Mask]:
    """The columns of ``known`` (m, n) that differ from all before."""
    found: list[Mask] = []
    for column in known.T:
        if not any(np.array_equal(column, other) for other in found):
            found.append(column)
    return found
