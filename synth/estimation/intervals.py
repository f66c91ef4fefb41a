"""Values with 90 % intervals, and covariances from information matrices."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan, cos, pi, sin, sqrt
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.estimation.estimate_words import interval_words
from synth.units import factor, quantity, si_unit

NORMAL90 = 1.6448536269514722  # half-width of a 90 % normal interval in standard deviations: the normal's 95 % point
STUDENT95 = (6.314, 2.920, 2.353, 2.132)  # 95 % points of Student's t of 1 to 4 degrees (any table of it)
FULL_TURN = 2.0 * pi * (1.0 - 1e-9)  # rad, less the rounding of results' ten digits
NULL = 1e-12  # share of the diagonal below which a direction carries no information


class NotFiniteError(ArithmeticError):
    """A matrix of information or covariance holds infinite or undefined numbers, as where a simulation diverges."""


@dataclass(frozen=True)
class Estimate:
    """A value with its 90 % interval; ``repr`` shows it as the tables and files do, an angle in degrees.

    ``value``, ``low``, ``high`` : in SI and radians, whose unit is ``unit``. No ends: it has no interval; an end may be
    infinite. ``shown_in`` : the unit of tables and files, to which ``words`` and ``as_json`` convert.
    """

    value: float
    shown_in: str
    low: float | None = None
    high: float | None = None

    @property
    def unit(self) -> str:
        """The unit of ``value``, ``low`` and ``high``: ``rad`` of an angle, which is shown in ``deg``."""
        return si_unit(self.shown_in)

    def __repr__(self) -> str:
        """Value and interval in the unit shown, ``Estimate(105.003 deg, 90 %: 104.994 to 105.013)``."""
        scale = factor(self.shown_in, self.unit)
        ends = "" if self.low is None or self.high is None else f"{self.low / scale:.6g} to {self.high / scale:.6g}"
        unit = "" if self.shown_in == "1" else f" {self.shown_in}"
        return f"Estimate({self.value / scale:.6g}{unit}{', 90 %: ' if ends else ''}{ends})"

    @property
    def is_any_angle(self) -> bool:
        """Whether it is an angle whose interval spans a full turn: the free angle of a spring that may not be there."""
        if self.shown_in != "deg" or self.low is None or self.high is None:
            return False
        return self.high - self.low >= FULL_TURN

    def as_json(self) -> dict[str, Any]:
        """``{"value", "unit", "interval90"}``; with ``"unknown": true`` if it is any angle."""
        interval = None if self.low is None or self.high is None else (self.low, self.high)
        return quantity(self.value, self.shown_in, interval) | ({"unknown": True} if self.is_any_angle else {})

    @property
    def words(self) -> str:
        """The 90 % interval in a sentence, ``0.064 to 0.76 N*m/rad``: the numbers of the table; empty without one."""
        if self.low is None or self.high is None:
            return ""
        scale = factor(self.shown_in, self.unit)  # an end may be infinite, which no quantity of a file is
        value, low, high = self.value / scale, self.low / scale, self.high / scale
        return interval_words(value, low, high, self.shown_in)


def student95(degrees: int) -> float:
    """95 % point of Student's t; beyond a table by its expansion in ``1 / degrees`` (Abramowitz & Stegun, 26.7.5).

    The expansion is worst at five degrees: 0.43 % too low, of which the probability is 0.9494.

    Raises
    ------
    ValueError : fewer than one degree.
    """
    if degrees < 1:
        raise ValueError(f"Student's t of {degrees} degrees: at least 1")
    if degrees <= len(STUDENT95):
        return STUDENT95[degrees - 1]
    z, share = NORMAL90, 1.0 / degrees
    return z + (z**3 + z) / 4.0 * share + (5.0 * z**5 + 16.0 * z**3 + 3.0 * z) / 96.0 * share**2


def student(value: float, degrees: int) -> float:
    """Probability that Student's t of these ``degrees`` of freedom is below a value (Abramowitz & Stegun, 26.7.3-4)."""
    angle = atan(value / sqrt(degrees))
    sine, cosine = sin(angle), cos(angle)
    odd = degrees % 2
    # Of odd degrees the series is cos + 2/3 cos^3 + 2 4/(3 5) cos^5 ..., of even 1 + 1/2 cos^2 + 1 3/(2 4) cos^4 ...
    term, total = cosine if odd else 1.0, 0.0
    for k in range(degrees // 2):
        total += term
        term *= cosine**2 * (2 * k + 1 + odd) / (2 * k + 2 + odd)
    within = 2.0 / pi * (angle + sine * total) if odd else sine * total
    return 0.5 * (1.0 + within)


def spectrum(matrix: Array, scale: Array | float = 1.0) -> tuple[Array, Array]:
    """Eigenvalues (p,) and eigenvectors (p, p) of a symmetric matrix scaled by ``scale`` (p,) on both sides.

    Raises
    ------
    NotFiniteError : the matrix is not finite; ``eigh`` would fail or return arbitrary values.
    """
    if not np.isfinite(matrix).all():
        raise NotFiniteError("a matrix of information or covariance is not finite")
    value, vector = np.linalg.eigh(matrix / np.outer(scale, scale))
    return np.asarray(value), np.asarray(vector)


def covariance_of(information: Array) -> Array:
    """(p, p) inverse of an information matrix; null directions get a very large variance instead of an error.

    Raises
    ------
    NotFiniteError : it is not finite.
    """
    root = np.sqrt(np.maximum(np.diag(information), NULL))
    value, vector = spectrum(information, root)
    return np.asarray((vector / np.maximum(value, NULL)) @ vector.T / np.outer(root, root))
