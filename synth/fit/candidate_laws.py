"""Candidate torque-speed laws of a damper, with their parameters as unknowns of a fit."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.estimation.intervals import NORMAL90
from synth.swing.chain import Chain
from synth.swing.damper_curves import compiled_rows, torque_at
from synth.swing.lane_layout import CURVE_POINTS
from synth.swing.leg_model import DamperCurve
from synth.units import quantity

TABLE_POINTS = 6  # of a tabulated law: one per factor of about two in speed


@dataclass(frozen=True)
class CandidateLaw:
    """A candidate: name, formula, and names and units of its parameters."""

    name: str
    formula: str
    parameters: tuple[tuple[str, str], ...]


LINEAR_LAW = CandidateLaw("linear", "T = b w", (("rate", "N*m*s/rad"),))
POWER = CandidateLaw("power", "T = T1 (w / w1)^p, w1 = 1 rad/s", (("torque_at_1_rad_per_s", "N*m"), ("exponent", "1")))
FRICTION = CandidateLaw("coulomb_viscous", "T = Tc + b w", (("friction", "N*m"), ("rate", "N*m*s/rad")))
# A number a point of the table.
_SLOPES = tuple((f"slope_{i + 1}", "N*m*s/rad") for i in range(TABLE_POINTS))
TABLE = CandidateLaw("table", "monotone, linear between points", _SLOPES)
LAWS = (LINEAR_LAW, POWER, FRICTION, TABLE)


@dataclass(frozen=True)
class SpeedRange:
    """Speeds (rad/s) covered by the drops: 2nd and 98th percentile of the moving samples, and the fastest."""

    low: float
    high: float
    fastest: float

    @property
    def creep(self) -> float:
        """Speed below which there are no data and a law is a straight line to the origin."""
        return 0.3 * self.low


@dataclass(frozen=True)
class LawUnknowns:
    """One law's parameters as unknowns: logarithms, except the power law's exponent."""

    chain: Chain
    law: CandidateLaw
    joint: int
    speeds: SpeedRange
    scale: float  # N m s/rad, a rate to start from
    like: DamperCurve | None = None  # a law already found, as starting point of a table

    @property
    def names(self) -> tuple[str, ...]:
        """The law's parameter names."""
        return tuple(name for name, _ in self.law.parameters)

    @cached_property
    def start(self) -> Array:
        """(n_unknown,) a first guess from the scale."""
        middle = np.sqrt(self.speeds.low * self.speeds.high)
        if self.law is LINEAR_LAW:
            return np.array([np.log(self.scale)])
        if self.law is POWER:
            return np.array([np.log(self.scale * middle) - 0.6 * np.log(middle), 0.6])
        if self.law is FRICTION:
            return np.log([0.3 * self.scale * middle, 0.7 * self.scale])
        if self.like is None:
            return np.full(TABLE_POINTS, np.log(self.scale))
        torque = torque_at(self.like, self._table_speeds)
        return np.asarray(np.log(np.diff(torque, prepend=0.0) / np.diff(self._table_speeds, prepend=0.0)))

    @property
    def _table_speeds(self) -> Array:
        return np.geomspace(self.speeds.low, 1.2 * self.speeds.fastest, TABLE_POINTS)

    @cached_property
    def _bounds(self) -> tuple[Array, Array]:
        wide = np.log(self.scale) + np.array([-12.0, 12.0])
        lower, upper = np.full(len(self.names), wide[0]), np.full(len(self.names), wide[1])
        if self.law is POWER:
            lower[1], upper[1] = 0.05, 2.5
        return lower, upper

    @property
    def lower(self) -> Array:
        """(n_unknown,) lower bounds."""
        return self._bounds[0]

    @property
    def upper(self) -> Array:
        """(n_unknown,) upper bounds."""
        return self._bounds[1]

    @property
    def prior(self) -> tuple[Array, Array]:
        """None, except for the table's slopes: each within a factor of three of the power law's."""
        precision = (NORMAL90 / np.log(3.0)) ** 2 if self.law is TABLE else 0.0
        return self.start, np.full(len(self.names), precision)

    @property
    def weak_precision(self) -> Array:
        """The prior's: nobody states a law's parameters."""
        return self.prior[1]

    @property
    def rest_index(self) -> tuple[int | None, ...]:
        """No rest angle is estimated: there is no spring."""
        return (None,) * self.chain.layout.n

    def measured(self, values: Array, spread: Array | None) -> None:
        """None: a damper is measured by drops only."""

    def curve(self, values: Array) -> DamperCurve:
        """The law as a curve over the drops' speeds, linear below and beyond them."""
        low, high = self.speeds.creep, 1.2 * self.speeds.fastest
        if self.law is LINEAR_LAW:
            return DamperCurve((high,), (float(np.exp(values[0]) * high),))
        if self.law is POWER:
            speed = np.geomspace(low, high, CURVE_POINTS)
            return DamperCurve(tuple(speed.tolist()), tuple((np.exp(values[0]) * speed ** values[1]).tolist()))
        if self.law is FRICTION:
            friction, rate = np.exp(values)
            return DamperCurve((low, high), (float(friction + rate * low), float(friction + rate * high)))
        speed = self._table_speeds
        torque = np.cumsum(np.exp(values) * np.diff(speed, prepend=0.0))
        return DamperCurve(tuple(speed.tolist()), tuple(torque.tolist()))

    def write(self, lanes: Array, values: Array) -> None:
        """Write each lane's curve."""
        layout = self.chain.layout
        rows = slice(self.joint * CURVE_POINTS, (self.joint + 1) * CURVE_POINTS)
        speeds, slopes = lanes[layout.rows("curve_speed")], lanes[layout.rows("curve_slope")]
        distinct, column_of = np.unique(values, axis=1, return_inverse=True)
        made = [compiled_rows(self.curve(column)) for column in distinct.T]
        speeds[rows] = np.stack([speed for speed, _ in made], axis=1)[:, column_of.ravel()]
        slopes[rows] = np.stack([slope for _, slope in made], axis=1)[:, column_of.ravel()]

    def natural(self, values: Array) -> dict[str, dict[str, Any]]:
        """The law's parameters with units."""
        shown = np.exp(values)
        if self.law is POWER:
            shown[1] = values[1]
        return {n: quantity(float(v), unit) for (n, unit), v in zip(self.law.parameters, shown, strict=True)}
