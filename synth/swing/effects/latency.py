"""One channel late against the others."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from synth.swing.effects.definition import Effect, Parameter, Prior, Shape

if TYPE_CHECKING:
    from synth.arrays import Array


LATEST = 2.0  # times 1 / w of the motion, a third of its period; a larger delay would belong to another recording
BLOCK = 24  # samples of a filter's recurrence that are computed at once


def read(time: Array, rotation: Array, rate: Array, sign: int, zero: float, delay: Array, lag: Array) -> Array:
    """Rotation ``delay`` (n_lane,) s earlier, by cubic Hermite interpolation, then filtered with time constant ``lag``.

    Before the first sample the motion is extrapolated with its initial rate and acceleration, at most back to the
    release, before which the joint was at rest.
    """
    past = time[:, None] - np.broadcast_to(delay, (rotation.shape[1],))
    index = np.minimum(np.maximum(np.searchsorted(time, past, side="right") - 1, 0), len(time) - 2)
    lanes, starts = np.arange(rotation.shape[1]), time[index]
    step = time[index + 1] - starts
    u = (past - starts) / step
    q0, w0 = rotation[index, lanes], rate[index, lanes] * step
    rise, w1 = rotation[index + 1, lanes] - q0, rate[index + 1, lanes] * step
    # The cubic with these end values and slopes, by Horner's rule.
    result: Array = q0 + u * (w0 + u * (3.0 * rise - 2.0 * w0 - w1 + u * (w0 + w1 - 2.0 * rise)))
    for lane in np.flatnonzero(past[0] < time[0]):
        before = past[:, lane] < time[0]
        result[before, lane] = _earlier(past[before, lane] - time[0], time, rotation[:, lane], rate[:, lane])
    return _lagged(time, result, lag) if np.any(np.asarray(lag) > 0.0) else result


def _lagged(time: Array, reading: Array, lag: Array) -> Array:
    """Reading (n_time, n_lane) after a first-order filter with time constant ``lag`` (n_lane,) s, initially at rest.

    Exact for a reading that is linear between its samples.
    """
    constant = np.maximum(np.broadcast_to(lag, (reading.shape[1],)), 1e-9)
    step = np.diff(time)[:, None]
    fade = np.exp(-step / constant)
    drive = (fade - 1.0) * constant * np.diff(reading, axis=0) / step
    behind = np.zeros_like(reading)  # output minus input: behind[k + 1] = fade[k] behind[k] + drive[k]
    level = np.cumsum(np.maximum(-step / constant, -50.0), axis=0)
    for first in range(0, len(drive), BLOCK):
        part = slice(first, first + BLOCK)
        grown = level[part] - (level[first - 1] if first else 0.0)
        # Within a block: behind[k + 1] = sum_j exp(grown[k] - grown[j]) drive[j] + exp(grown[k]) behind[first]
        share = np.exp(np.minimum(grown[:, None] - grown[None], 0.0)) * np.tri(len(grown))[:, :, None]
        behind[first + 1 : first + 1 + len(grown)] = (share * drive[part][None]).sum(axis=1) + np.exp(grown) * behind[
            first
        ]
    return reading + behind


def _earlier(lead: Array, time: Array, rotation: Array, rate: Array) -> Array:
    """Rotation at ``lead`` (m,) s < 0 before the first sample, from its initial rate and acceleration.

    A joint that accelerates was released when its rate was zero and was at rest before. A joint that decelerates was
    moving; but the slower it is, the more likely it was released and the estimated rate has the wrong sign. Its motion
    is therefore reduced for small rates. Otherwise the reading would be discontinuous where the rate changes sign, and
    a fit could not pass this point.
    """
    bend = (rate[1] - rate[0]) / (time[1] - time[0])
    if bend == 0.0:
        return np.asarray(rotation[0] + lead * rate[0])
    since = rate[0] / bend  # s since the rate was zero; negative: until it will be
    if since >= 0.0:
        lead = np.maximum(lead, -since)
        return np.asarray(rotation[0] + lead * rate[0] + 0.5 * lead**2 * bend)
    share = since**2 / (since**2 + lead**2)
    return np.asarray(rotation[0] + share * (lead * rate[0] + 0.5 * lead**2 * bend))


EFFECT = Effect(
    name="latency",
    meaning="one channel late against the others",
    phrase="is read late",
    formula="reading(t) = angle(t - delay), then behind a first-order filter: lag dr/dt = angle - r",
    source="definition",
    way="reading",
    parameters=(
        Parameter("delay", "s", 0.0, Prior(0.0, 0.2, lower=0.0, upper=LATEST), meaning="later by"),
        Parameter("lag", "s", 0.0, Prior(0.0, 0.2, lower=0.0, upper=LATEST), meaning="time constant of a filter"),
    ),
    strengths=("delay", "lag"),
    shapes=(
        Shape(("delay",), {}, ({}, {"delay": 0.2}, {"delay": 0.8})),
        Shape(("lag",), {}, ({}, {"lag": 0.4})),
    ),
)
