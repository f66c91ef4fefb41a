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
