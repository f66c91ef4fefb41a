"""Overlapping windows over a recording, for weak forms: on each the equation is integrated against a bump.

Shinbrot's moment functions (1957); Messenger & Bortz, J. Comp. Phys. 443 (2021) 110525.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array

OVERLAP = 4  # windows over every instant; more are almost linear combinations of these
LEAST_SAMPLES = 8  # in a window, for the trapezoid rule on a bump


@dataclass(frozen=True, eq=False)
class Window:
    """Which samples it holds: ``inside`` (n_time,), of these ``time`` (m,) s and ``place`` (m,) from -1 to 1."""

    inside: NDArray[np.bool_]
    time: Array
    place: Array


def windows(time: Array, width: float) -> Iterator[Window]:
    """Those of this width (s) over a recording's time (n_time,) s that hold enough samples."""
    for centre in np.arange(time[0] + width / 2, time[-1] - width / 2, width / OVERLAP):
        inside = np.abs(time - centre) < width / 2
        if inside.sum() >= LEAST_SAMPLES:
            yield Window(inside, time[inside], 2.0 * (time[inside] - centre) / width)
