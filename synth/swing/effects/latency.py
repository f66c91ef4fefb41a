"""One channel late against the others."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from synth.swing.effects.definition import Effect, Parameter, Prior, Shape

if TYPE_CHECKING:
    from synth.arrays import Array


LATEST = 2.0  # times 1 / w of the motion, a third of its period; a larger delay would belong to another recording


def read(time: Array, rotation: Array, rate: Array, sign: int, zero: float, delay: Array, lag: Array) -> Array:
    """Rotation ``delay`` (n_lane,) s earlier, by cubic Hermite interpolation, then filtered with time constant ``lag``.

    Before the first sample the motion is extrapolated with its initial rate and acceleration, at most back to the
    release, before which the joint was at rest.
    """
    from synth.swing.late_reading import filter_reading, later  # here, because the list of effects needs no compiler

    every = rotation.shape[1]
    result = np.empty(rotation.shape)
    later(time, rotation, rate, np.broadcast_to(np.asarray(delay, dtype=float), every).copy(), result)
    if np.any(np.asarray(lag) > 0.0):
        filter_reading(time, result, np.broadcast_to(np.asarray(lag, dtype=float), every).copy())
    return result


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
