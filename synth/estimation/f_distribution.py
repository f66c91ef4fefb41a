"""Probabilities of Fisher's F: a chi-squared test whose noise was estimated from few residuals.

By the incomplete beta function, W. H. Press et al., Numerical Recipes, 3rd ed. (2007), 6.4 and 6.14.10. Written here
because importing ``scipy.special`` takes 0.3 s of a processor.
"""

from __future__ import annotations

import math

from synth.estimation.chi_squared import chi_squared_above

MANY = 1e5  # degrees of the noise, from which it counts as known: by up to nine of a sum, 1e-4 changes by 0.2 %
TERMS, CLOSE, TINY = 10_000, 1e-14, 1e-300  # of the continued fraction: most terms, its relative error, no zero divisor


def square_above(freedom: int, square: float, of_noise: float = math.inf) -> float:
    """The probability that so large a sum of squares is noise's.

    Parameters
    ----------
    freedom : degrees of the sum.
    square : in units of the noise's estimated variance.
    of_noise : degrees of that estimate, independent of the sum; infinite: the variance is known.

    Raises
    ------
    ValueError : no degree of the noise.
    """
    if not of_noise > 0.0:
        raise ValueError(f"a noise of {of_noise} degrees of freedom: more than 0 are needed")
    if square <= 0.0:
        return 1.0
    if of_noise >= MANY:
        return chi_squared_above(freedom, square)
    return _incomplete_beta(0.5 * of_noise, 0.5 * freedom, of_noise / (of_noise + square))


def _incomplete_beta(a: float, b: float, x: float) -> float:
    """I_x(a, b) for 0 < x < 1, by the continued fraction that converges fast."""
    front = math.exp(math.lgamma(a + b) - math.lgamma(a) - math.lgamma(b) + a * math.log(x) + b * math.log1p(-x))
    if x < (a + 1.0) / (a + b + 2.0):
        return front * _fraction(a, b, x) / a
    return 1.0 - front * _fraction(b, a, 1.0 - x) / b


def _fraction(a: float, b: float, x: float) -> float:
    """The continued fraction of the incomplete beta function, by Lentz's method."""
    upper, lower = 1.0, 1.0 / _not_zero(1.0 - (a + b) * x / (a + 1.0))
    value = lower
    for m in range(1, TERMS):
        for term in (
            m * (b - m) * x / ((a + 2 * m - 1.0) * (a + 2 * m)),
            -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1.0)),
        ):
            lower = 1.0 / _not_zero(1.0 + term * lower)
            upper = _not_zero(1.0 + term / upper)
            value *= lower * upper
        if abs(lower * upper - 1.0) < CLOSE:
            return value
    raise ArithmeticError(f"incomplete beta function of {a}, {b} at {x}: no convergence")


def _not_zero(value: float) -> float:
    return value if abs(value) > TINY else TINY
