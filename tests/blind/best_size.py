"""The size at which a cause explains another one best."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import minimize_scalar


def best_size(left: Callable[[float], float], both_ways: bool, worth: float) -> tuple[float, float]:
    """Size with the least remainder, and that remainder; refined only if a first guess leaves less than ``worth``."""
    sizes = np.r_[-np.geomspace(1.0, 0.02, 6), np.geomspace(0.02, 1.0, 6)]
    if not both_ways:
        sizes = sizes[sizes > 0.0]
    tried = [left(float(size)) for size in sizes]
    k = int(np.argmin(tried))
    if tried[k] >= worth:
        return float(sizes[k]), tried[k]
    low, high = sizes[max(k - 1, 0)], sizes[min(k + 1, len(sizes) - 1)]
    best = minimize_scalar(left, bounds=(low, high), method="bounded", options={"maxiter": 12})
    return (float(best.x), float(best.fun)) if best.fun < tried[k] else (float(sizes[k]), tried[k])
