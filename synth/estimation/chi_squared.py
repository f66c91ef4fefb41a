"""The chi-squared distribution with whole degrees of freedom, in closed form.

M. Abramowitz, I. A. Stegun, Handbook of Mathematical Functions, 26.4.4 and 26.4.5. Written here because importing
``scipy.special`` takes 0.3 s of a processor.
"""

from __future__ import annotations

import math

HALVINGS = 200  # bisections of an interval that holds the quantile: beyond the last digit


def chi_squared_above(freedom: int, value: float) -> float:
    """The probability that a chi-squared variable of ``freedom`` degrees exceeds ``value``."""
    if value <= 0.0:
        return 1.0
    half, odd = 0.5 * value, freedom % 2
    # By logarithms, because exp(-half) alone is zero where the sum over many degrees is not.
    terms = (
        math.exp(power * math.log(half) - half - math.lgamma(power + 1.0))
        for power in (index + 0.5 * odd for index in range(freedom // 2))
    )
    return math.fsum(terms) + (math.erfc(math.sqrt(half)) if odd else 0.0)


def chi_squared_exceeded(freedom: int, probability: float) -> float:
    """The value that is exceeded with this ``probability``, between 0 and 1.

    Raises
    ------
    ValueError : fewer than one degree, or a probability that no value has.
    """
    if freedom < 1 or not 0.0 < probability < 1.0:
        raise ValueError(f"chi-squared of {freedom} degrees at {probability}: at least 1 degree, and between 0 and 1")
    low, high = 0.0, float(freedom)
    while chi_squared_above(freedom, high) > probability:
        low, high = high, 2.0 * high
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        low, high = (middle, high) if chi_squared_above(freedom, middle) > probability else (low, middle)
    return high
