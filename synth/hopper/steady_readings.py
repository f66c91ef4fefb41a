"""Means and lines through a few readings whose relative error is unknown, and what their errors add up to.

Three points leave one or two degrees of freedom for their scatter: the interval is that of Student's t, 6.3 standard
deviations at one degree where a normal one is 1.6. A constant that depends on several scatters has the degrees of
freedom of Welch and Satterthwaite (Biometrics Bulletin 2 (1946) 110).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.estimation.intervals import NORMAL90, student95
from synth.hopper.identify_motor import IdentifiedConstant

ALONE = 0.02  # of a reading: the error assumed of one that no other is compared with
ROUNDED = 0.003  # of a reading: 1.00 and its like is within 0.005, uniform; readings that agree better may be rounded
PASSES = 4  # over a line's weights, which are of the line itself; the first is unweighted
LEAST_SIZE = 0.1  # of the mean reading: a line that comes near zero takes no weight there without limit


@dataclass(frozen=True)
class Scatter:
    """A variance from the readings' scatter with ``degrees`` of freedom, infinite: assumed.

    ``least`` : the variance of rounding alone.
    """

    variance: float
    degrees: float
    least: float = 0.0

    def times(self, factor: float) -> Scatter:
        """Of what changes by ``factor`` with a unit."""
        return Scatter(self.variance * factor**2, self.degrees, self.least * factor**2)


@dataclass(frozen=True)
class Reading:
    """A value and the independent scatters that it depends on."""

    value: float
    scatters: tuple[Scatter, ...]

    def times(self, factor: float) -> tuple[Scatter, ...]:
        """The scatters of what changes by ``factor`` with a unit of it."""
        return tuple(scatter.times(factor) for scatter in self.scatters)

    def constant(self, *, positive: bool = False) -> IdentifiedConstant:
        """With its 90 % interval; that of a ``positive`` one is symmetric in its logarithm."""
        deviation, half = _deviation_and_half(self.scatters)
        if positive:
            low, high = (self.value * float(np.exp(way * half / self.value)) for way in (-1.0, 1.0))
            return IdentifiedConstant(self.value, deviation, (low, high))
        return IdentifiedConstant(self.value, deviation, (self.value - half, self.value + half))


def mean(values: Array, readings: int = 1) -> Reading:
    """Of values with equal relative errors; each is made of so many ``readings``."""
    level, count = float(np.mean(values)), len(values)
    if count == 1:
        return Reading(level, (Scatter(readings * (ALONE * level) ** 2, np.inf),))
    least = readings * (ROUNDED * level) ** 2 / count
    return Reading(level, (Scatter(float(np.var(values, ddof=1)) / count, count - 1, least),))


@dataclass(frozen=True, eq=False)
class FittedLine:
    """``intercept`` and ``slope`` of y over x; ``inverse`` (2, 2) of the normal matrix, ``variance`` of the errors."""

    intercept: float
    slope: float
    inverse: Array
    variance: float
    degrees: int

    def scatter(self, of_intercept: float, of_slope: float) -> Scatter:
        """Of a value with these derivatives with respect to intercept and slope."""
        derivative = np.array([of_intercept, of_slope])
        power = float(derivative @ self.inverse @ derivative)
        return Scatter(self.variance * power, self.degrees, ROUNDED**2 * power)


def line(x: Array, y: Array, *, proportional: bool) -> FittedLine:
    """Through at least three points; the errors of y are ``proportional`` to the line, or all alike."""
    columns = np.column_stack([np.ones_like(x), x])
    least = LEAST_SIZE * float(np.mean(np.abs(y)))
    size = np.full_like(y, float(np.mean(np.abs(y))))
    for _ in range(PASSES if proportional else 1):
        weighted = columns / size[:, None]
        found, *_ = np.linalg.lstsq(weighted, y / size, rcond=None)
        left, inverse = y / size - weighted @ found, np.asarray(np.linalg.inv(weighted.T @ weighted), dtype=float)
        size = np.maximum(np.abs(columns @ found), least)
    degrees = len(y) - 2
    return FittedLine(float(found[0]), float(found[1]), inverse, float(left @ left) / degrees, degrees)


def _deviation_and_half(scatters: Sequence[Scatter]) -> tuple[float, float]:
    """Standard deviation, and half of the 90 % interval: never below that of rounded readings."""
    variance = sum(scatter.variance for scatter in scatters)
    assumed = sum(scatter.variance if np.isinf(scatter.degrees) else scatter.least for scatter in scatters)
    each = sum(scatter.variance**2 / scatter.degrees for scatter in scatters)
    wide = NORMAL90 if each == 0.0 else student95(max(1, round(variance**2 / each)))
    deviation, least = float(np.sqrt(variance)), float(np.sqrt(assumed))
    return max(deviation, least), max(wide * deviation, NORMAL90 * least)
