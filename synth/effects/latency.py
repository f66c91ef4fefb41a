"""One channel late against the others."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from synth.effects.effect import Effect, Parameter, Prior, Shape

if TYPE_CHECKING:
    from synth.model.leg import Array


def read(time: Array, rotation: Array, rate: Array, sign: int, zero: float, delay: Array, lag: Array) -> Array:
    """Rotation ``delay`` (n_lane,) s earlier, by cubic Hermite interpolation between the samples.

    Before the first sample the motion is carried back with the first samples' rate and acceleration, at most to
    the release, before which the joint stood still.
    """
    result = np.empty_like(rotation)
    for lane, late in enumerate(np.broadcast_to(delay, (rotation.shape[1],))):
        past = time - late
        index = np.clip(np.searchsorted(time, past, side="right") - 1, 0, len(time) - 2)
        step = time[index + 1] - time[index]
        u = (past - time[index]) / step
        q0, q1 = rotation[index, lane], rotation[index + 1, lane]
        w0, w1 = rate[index, lane] * step, rate[index + 1, lane] * step
        value = (
            (1 + 2 * u) * (1 - u) ** 2 * q0 + u * (1 - u) ** 2 * w0 + u * u * (3 - 2 * u) * q1 + u * u * (u - 1) * w1
        )
        before = past < time[0]
        if np.any(before):
            value[before] = _earlier(past[before] - time[0], time, rotation[:, lane], rate[:, lane])
        result[:, lane] = value
    return _lagged(time, result, lag) if np.any(np.asarray(lag) > 0.0) else result


def _lagged(time: Array, reading: Array, lag: Array) -> Array:
    """Reading (n_time, n_lane) behind a first-order filter of time constant ``lag`` (n_lane,) s, at rest before.

    Exact for a reading that is linear between its samples.
    """
    constant = np.maximum(np.broadcast_to(lag, (reading.shape[1],)), 1e-9)
    told = np.empty_like(reading)
    told[0] = reading[0]
    for k, step in enumerate(np.diff(time)):
        fade = np.exp(-step / constant)
        slope = (reading[k + 1] - reading[k]) / step
        told[k + 1] = reading[k + 1] - slope * constant + fade * (told[k] - reading[k] + slope * constant)
    return told


def _earlier(lead: Array, time: Array, rotation: Array, rate: Array) -> Array:
    """Rotation at ``lead`` (m,) s < 0 before the first sample: at rest up to the release, if there was one."""
    bend = (rate[1] - rate[0]) / (time[1] - time[0])
    if bend * rate[0] > 0.0 or rate[0] == 0.0:  # it had been speeding up: it stood still when its rate was zero
        lead = np.maximum(lead, -rate[0] / bend if bend != 0.0 else 0.0)
    return np.asarray(rotation[0] + lead * rate[0] + 0.5 * lead**2 * bend)


EFFECT = Effect(
    name="latency",
    meaning="one channel late against the others",
    formula="reading(t) = angle(t - delay), then behind a first-order filter: lag dr/dt = angle - r",
    source="definition",
    way="reading",
    parameters=(
        Parameter("delay", "s", 0.0, Prior(0.0, 0.2, lower=0.0), meaning="later by"),
        Parameter("lag", "s", 0.0, Prior(0.0, 0.2, lower=0.0), meaning="time constant of a filter"),
    ),
    strengths=("delay", "lag"),
    shapes=(
        Shape(("delay",), {}, ({}, {"delay": 0.2}, {"delay": 0.8})),
        Shape(("lag",), {}, ({}, {"lag": 0.4})),
    ),
)
