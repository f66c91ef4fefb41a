"""The time scale of a recording, used for smoothing, windows and natural sizes instead of fixed seconds."""

from __future__ import annotations

import numpy as np

from synth.arrays import Array
from synth.noise import white_noise
from synth.sampling import channel_step

SINUSOID_PACE = 0.505  # a sinusoid's pace times its angular frequency, by ``HALF_DEVIATION``
HALF_DEVIATION = 0.5  # of the RMS deviation: a sinusoid of frequency w changes by this in 0.505 / w
ORDER = 6  # order of differences that isolate noise
LEAST_DEVIATION = 5.0  # times its noise, least deviation of a joint for its pace
OF_SPAN = 50  # fraction of a recording without motion that is used as its pace
LEAST_SAMPLES = 12  # of a channel, for a pace of its own
MOST_POINTS = 100_000  # of the grid on which a channel's pace is sought: a long pause has no more


def pace(step: float, even: Array) -> float:
    """Time (s) in which the fastest joint changes by half of its RMS deviation, RMS over the recording.

    About 0.5 / w for angular frequency w, whatever the decay and the rest after it, since
    both are averages over the same samples. A steady rotation and the noise's share are subtracted.

    Parameters
    ----------
    step : s; even : (n, n_joint) rad on a grid of that step.
    """
    own = paces(step, even)
    return float(step * len(even) / OF_SPAN if np.isnan(own).all() else np.nanmin(own))


def paces(step: float, even: Array) -> Array:
    """(n_joint,) s, the time of ``pace`` of each joint; nan for one that does not move above its noise."""
    lags = [_lag(even[:, j]) for j in range(even.shape[1])]
    return np.array([np.nan if lag is None else step * lag for lag in lags])


def own_paces(time: Array, values: Array) -> Array:
    """(n_channel,) s, as ``paces`` of a recording as read, each channel at its own samples.

    Parameters
    ----------
    time : (m,) s, rising; values : (m, n_channel) in any unit, nan where a channel has no sample.
    """
    found = np.full(values.shape[1], np.nan)
    for j, value in enumerate(values.T):
        known = np.isfinite(value)
        if known.sum() < LEAST_SAMPLES:
            continue
        at = time[known]
        step = max(channel_step(time, known), float(at[-1] - at[0]) / MOST_POINTS)
        grid = np.arange(at[0], at[-1] + 0.5 * step, step)
        found[j] = paces(step, np.interp(grid, at, value[known])[:, None])[0]
    return found


def _lag(value: Array) -> float | None:
    """In samples, of one joint; None if it does not move above its noise, or slower than the recording is long."""
    count = len(value)
    line = np.arange(count) - 0.5 * (count - 1)
    value = value - value.mean()
    value = value - line * float(line @ value) / float(line @ line)
    noise = white_noise(value, ORDER) ** 2 if count > 2 * ORDER else 0.0
    deviation = float(value @ value) / count - noise
    if deviation <= LEAST_DEVIATION**2 * noise or deviation <= 0.0:
        return None
    before, lag = (0.0, 0.0), 1
    while lag < count // 2:
        change = value[lag:] - value[:-lag]
        size = np.sqrt(max(float(change @ change) / count - 2.0 * noise, 0.0) / deviation)
        if size >= HALF_DEVIATION:
            return float(before[0] + (lag - before[0]) * (HALF_DEVIATION - before[1]) / (size - before[1]))
        before, lag = (float(lag), float(size)), lag + max(1, lag // 4)
    return None
