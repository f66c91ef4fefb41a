"""The size of a recording in words, also where what was given as its arrays is none."""

from __future__ import annotations

import numpy as np


def sizes_of(time: object, angles: object) -> list[str]:
    """Samples, joints and duration of ``time`` (n,) s and ``angles`` (n, n_joint) as far as they are such; no error."""
    try:
        clock, shape = np.asarray(time, dtype=float), np.shape(np.asarray(angles, dtype=float))
    except (TypeError, ValueError):
        return ["time and angles are not arrays of numbers"]
    if clock.ndim != 1 or len(shape) != 2 or len(clock) != shape[0]:
        return [f"time {clock.shape} and angles {shape} do not match"]
    said = [f"{shape[0]} samples of {shape[1]} joint{'s' if shape[1] != 1 else ''}"]
    return [*said, f"{clock[-1] - clock[0]:.4g} s"] if len(clock) else said
