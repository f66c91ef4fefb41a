"""The array types of all packages, and what numpy lacks for them; shapes and units are given in each docstring."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


def finite_median(values: Array) -> float:
    """The median of the finite values (n,), in their unit; nan if there are none."""
    known = values[np.isfinite(values)]
    if not len(known):
        return float("nan")
    middle = len(known) // 2
    if len(known) % 2:
        return float(np.partition(known, middle)[middle])
    return float(np.partition(known, (middle - 1, middle))[middle - 1 : middle + 1].mean())


def zero_crossings(value: Array) -> NDArray[np.intp]:
    """(m, 2) for each crossing of ``value`` (n,) the last sample of the old sign and the first of the new one.

    Samples that are zero, of either sign, have none: between both samples of a crossing all are zero, and a motion that
    touches zero and turns back does not cross it.
    """
    signed = np.flatnonzero((value > 0.0) | (value < 0.0))
    changes = np.flatnonzero(np.diff(value[signed] > 0.0))
    return np.stack([signed[changes], signed[changes + 1]], axis=1)
