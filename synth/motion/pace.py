"""The time scale of a recording, used for smoothing, windows and natural sizes instead of fixed seconds."""

from __future__ import annotations

import numpy as np

from synth.arrays import Array
from synth.motion.noise import white_noise

HALF_DEVIATION = 0.5  # of the RMS deviation: a sinusoid of frequency w changes by this in 0.505 / w
ORDER = 6  # order of differences that isolate noise
LEAST_DEVIATION = 5.0  # times its noise, least deviation of a joint for its pace
OF_SPAN = 50  # fraction of a recording without motion that is used as its pace


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
