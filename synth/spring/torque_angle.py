"""A torsion spring measured on a bench: rate, free angle, hysteresis and preload from torque over angle.

The spring is wound up and let back, once or several times. Winding, friction between the coils and on the arbor adds to
the torque; unwinding, it takes from it. So the two branches are lines on either side of the spring's own:

    T = k u + w (f + g k |u|),  u = a - a0,  w = +1 while the angle grows, -1 while it falls

with the rate k, the free angle a0, a friction f that does not change and a share g of the load. One least squares
gives them; u in the last term is that of a first one without it. Left out are samples near the free angle, where coils
and arms still come to rest on each other (``loose_test.load_points`` begins there as well), and those behind each
turning point, where the friction has not turned round yet.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from synth.arrays import Array
from synth.errors import UserError
from synth.units import quantity

SLACK = 0.2  # of the largest torque, up to which samples are left out
TURNED = 0.15  # of the angles' range, behind a turning point, over which samples are left out
ALL_TURNED = 2.2  # slips after which all friction has turned, in which half of it has turned in one; a tenth to spare
MOST_TURNED = 0.5  # of the angles' range, that may be left out so
REVERSAL = 0.05  # of the angles' range: a smaller way back is noise
LEAST = 4  # samples of each kind, for a line with an error
REPEATED = 3  # cycles from which their own scatter gives the interval
SURE = 0.95  # quantile of both ends of a 90 % interval
MOST_ALIKE = 0.99  # correlation of neighbours, beyond which one sample in 200 counts: a bound against rounding
CURVED = 0.05  # share of the rate, lost or gained from end to end, above which a line does not describe the spring
DISTINCT = 3.0  # standard errors beyond which a number is taken for real


@dataclass(frozen=True)
class BenchValue:
    """A number and the half width of its 90 % interval."""

    value: float
    within: float

    def as_json(self, unit: str) -> dict[str, Any]:
        """With its unit."""
        return quantity(self.value, unit, (self.value - self.within, self.value + self.within))


@dataclass(frozen=True)
class MeasuredCycles:
    """What a bench says of a spring; angles in rad, torques in N m.

    ``friction`` is half the distance of the branches in the middle of the samples, ``winding`` and ``unwinding`` the
    rates on them; None: it was only wound up. ``loss``: energy that a cycle takes, of that which winding it puts in.
    ``slip``: angle after a turning point in which half of the friction has turned; None: too few samples there tell.
    ``bend``: change of the rate from the least to the greatest angle, as a share; None: none that can be told.
    ``reversed_branches``: less torque winding than unwinding, which no spring does. ``used``, ``samples``: numbers of
    samples. ``used_torque``: the greatest torque among them. ``repeated``: the intervals are of the scatter from cycle
    to cycle.
    """

    rate: BenchValue
    free_angle: BenchValue
    friction: BenchValue | None
    winding: float | None
    unwinding: float | None
    loss: float | None
    slip: float | None
    bend: float | None
    reversed_branches: bool
    rms: float
    cycles: int
    used: int
    samples: int
    used_torque: float
    repeated: bool

    def preload(self, free_angle: float) -> float:
        """Torque (N m) at the free angle that the drawing states, rad: 0 if the spring is there unloaded."""
        return self.rate.value * (free_angle - self.free_angle.value)

    def as_json(self) -> dict[str, Any]:
        """Every number with its unit."""
        friction = None
        if self.friction is not None:
            friction = {
                "torque": self.friction.as_json("N*m"),
                "rate_winding": quantity(self.winding or 0.0, "N*m/rad"),
                "rate_unwinding": quantity(self.unwinding or 0.0, "N*m/rad"),
                "loss": quantity(self.loss or 0.0, "1"),
                "slip": None if self.slip is None else quantity(self.slip, "deg"),
            }
        return {
            "rate": self.rate.as_json("N*m/rad"),
            "free_angle": self.free_angle.as_json("deg"),
            "hysteresis": friction,
            "rate_change": None if self.bend is None else quantity(self.bend, "1"),
            "rms": quantity(self.rms, "N*m"),
            "cycles": self.cycles,
            "samples": {"used": self.used, "all": self.samples},
            "interval_from": "cycles" if self.repeated else "residuals",
        }


def measured_cycles(angle: Array, torque: Array) -> MeasuredCycles:
    """The spring of a bench test: ``angle`` (n,) rad and ``torque`` (n,) N m in the order in which they were read.

    The torque may be that of the bench or the spring's own, of the other sign.

    Raises
    ------
    UserError : too few samples, no travel, no torque, or a torque that does not change with the angle.
    """
    width = float(np.ptp(angle)) if len(angle) else 0.0
    if len(angle) < LEAST or width <= 0.0:
        raise UserError(f"{len(angle)} samples over {math.degrees(width):.3g} deg tell no rate; at least {LEAST} do")
    slope = float(np.polyfit(angle - angle.mean(), torque, 1)[0])
    if not np.any(torque) or slope == 0.0:
        raise UserError("the torque does not change with the angle, so there is no spring in it")
    torque = math.copysign(1.0, slope) * torque
    stroke = _strokes(angle, REVERSAL * width)
    test = _Test(angle, torque, stroke, _ways(angle, stroke))
    found = _between(test, TURNED * width)
    longer = 0.0 if found.slip is None else ALL_TURNED * found.slip
    return _between(test, min(longer, MOST_TURNED * width)) if longer > TURNED * width else found


def _between(test: _Test, near: float) -> MeasuredCycles:
    """The spring of the samples beyond the slack and ``near`` rad behind the turning points."""
    size = np.abs(test.torque)
    kept = (size >= SLACK * size.max()) & ~_just_turned(test.angle, test.stroke, near)
    if np.count_nonzero(kept) < LEAST or np.ptp(test.angle[kept]) < SLACK * np.ptp(test.angle):
        raise UserError(
            f"of {len(size)} samples {np.count_nonzero(kept)} lie beyond a fifth of the greatest torque and away from "
            f"the turning points; at least {LEAST} are needed: read more angles between the ends"
        )
    return _fitted(test, kept)


def _strokes(angle: Array, least: float) -> NDArray[np.int_]:
    """Number of the stroke of each sample: one ends where the angle goes back by more than ``least`` rad."""
    number = np.zeros(len(angle), dtype=int)
    extreme, way, stroke = 0, 0.0, 0
    for k in range(1, len(angle)):
        moved = angle[k] - angle[extreme]
        if way == 0.0:
            if abs(moved) > least:
                way, extreme = math.copysign(1.0, moved), k
        elif moved * way >= 0.0:
            extreme = k
        elif abs(moved) > least:
            stroke += 1
            number[extreme + 1 : k] = stroke
            way, extreme = -way, k
        number[k] = stroke
    return number


def _just_turned(angle: Array, stroke: NDArray[np.int_], near: float) -> NDArray[np.bool_]:
    """Samples within ``near`` rad behind the turning point, or the first sample, with which their stroke begins."""
    turned = np.zeros(len(angle), dtype=bool)
    for number in range(int(stroke.max()) + 1):
        own = np.flatnonzero(stroke == number)
        turned[own] = np.abs(angle[own] - angle[max(own[0] - 1, 0)]) < near
    return turned


def _ways(angle: Array, stroke: NDArray[np.int_]) -> Array:
    """+1 in strokes in which the angle grows, -1 where it falls."""
    ways = np.empty(len(angle))
    for number in range(int(stroke.max()) + 1):
        own = np.flatnonzero(stroke == number)
        ways[own] = 1.0 if angle[own[-1]] >= angle[max(own[0] - 1, 0)] else -1.0
    return ways


def _both(way: Array) -> bool:
    return bool(min(np.count_nonzero(way > 0.0), np.count_nonzero(way < 0.0)) >= LEAST)


def _line(angle: Array, torque: Array, way: Array) -> tuple[Array, Array, Array, Array]:
    """Numbers of the columns angle, one and, with samples of both ways, friction and share of the load.

    With their covariance, the residuals, and the columns.
    """
    columns = np.stack([angle, np.ones_like(angle)], axis=1)
    if _both(way):
        columns = np.column_stack([columns, way])
        first, _, _ = _least_squares(columns, torque)
        columns = np.column_stack([columns, way * np.abs(first[0] * angle + first[1])])
    return (*_least_squares(columns, torque), columns)


@dataclass(frozen=True, eq=False)
class _Test:
    """Angle rad, torque N m, number of the stroke, and way of each sample."""

    angle: Array
    torque: Array
    stroke: NDArray[np.int_]
    way: Array


def _fitted(test: _Test, kept: NDArray[np.bool_]) -> MeasuredCycles:
    a, m, way = test.angle[kept], test.torque[kept], test.way[kept]
    best, covariance, residuals, columns = _line(a, m, way)
    rate, free = float(best[0]), float(-best[1] / best[0])
    if rate <= 0.0:
        raise UserError("the torque falls where the spring is wound up: check the columns' signs")
    factor = float(student.ppf(SURE, max(len(a) - columns.shape[1], 1)))
    to_free = np.array([-free / rate, -1.0 / rate, *[0.0] * (len(best) - 2)])  # of a0 by the columns' numbers
    errors = [math.sqrt(covariance[0, 0]), math.sqrt(to_free @ covariance @ to_free)]
    each = _by_cycle(test, kept)
    repeated = len(each) >= REPEATED
    if repeated:
        spread = np.std(each, axis=0, ddof=1) / math.sqrt(len(each))
        errors, factor = [float(x) for x in spread], float(student.ppf(SURE, len(each) - 1))
    found = MeasuredCycles(
        rate=BenchValue(rate, factor * errors[0]),
        free_angle=BenchValue(free, factor * errors[1]),
        friction=None,
        winding=None,
        unwinding=None,
        loss=None,
        slip=None,
        bend=_bend(columns, m, a),
        reversed_branches=False,
        rms=float(np.sqrt(np.mean(residuals**2))),
        cycles=max(1, math.ceil((int(test.stroke.max()) + 1) / 2)),
        used=len(a),
        samples=len(test.angle),
        used_torque=float(np.abs(m).max()),
        repeated=repeated,
    )
    return _with_friction(found, best, covariance, test, a) if _both(way) else found


def _least_squares(columns: Array, torque: Array) -> tuple[Array, Array, Array]:
    """Numbers of the columns, their covariance, and the residuals.

    Neighbouring samples of a recording share their errors: with a correlation r of neighbours n samples count as
    n (1 - r) / (1 + r) (Bartlett, J. Roy. Stat. Soc. 98 (1935) 536).
    """
    scale = np.abs(columns).max(axis=0)
    scale[scale == 0.0] = 1.0
    best, *_ = np.linalg.lstsq(columns / scale, torque, rcond=None)
    residuals = torque - columns / scale @ best
    free = max(len(torque) - columns.shape[1], 1)
    variance = float(residuals @ residuals) / free
    whole = float(residuals @ residuals)
    alike = float(residuals[1:] @ residuals[:-1]) / whole if whole > 0.0 else 0.0
    alike = min(max(alike, 0.0), MOST_ALIKE)
    inverse = np.linalg.pinv((columns / scale).T @ (columns / scale))
    covariance = variance * (1.0 + alike) / (1.0 - alike) * inverse / np.outer(scale, scale)
    return best / scale, covariance, residuals


def _by_cycle(test: _Test, kept: NDArray[np.bool_]) -> list[tuple[float, float]]:
    """Rate and free angle of each whole cycle by itself: two strokes, one after the other."""
    found = []
    for first in range(0, int(test.stroke.max()), 2):
        own = kept & ((test.stroke == first) | (test.stroke == first + 1))
        if np.count_nonzero(own) < 2 * LEAST or not _both(test.way[own]):
            continue
        best, *_ = _line(test.angle[own], test.torque[own], test.way[own])
        if best[0] > 0.0:
            found.append((float(best[0]), float(-best[1] / best[0])))
    return found


def _bend(columns: Array, torque: Array, angle: Array) -> float | None:
    """Change of the rate from the least to the greatest angle as a share of it, if it is real and counts."""
    middle = angle - 0.5 * (angle.min() + angle.max())
    if len(angle) < columns.shape[1] + 2:
        return None
    best, covariance, _ = _least_squares(np.column_stack([columns, middle**2]), torque)
    change, error = best[-1], math.sqrt(covariance[-1, -1])
    share = float(2.0 * change * np.ptp(angle) / best[0])
    return share if abs(change) > DISTINCT * error and abs(share) > CURVED else None


def _with_friction(found: MeasuredCycles, best: Array, covariance: Array, test: _Test, used: Array) -> MeasuredCycles:
    load = np.abs(found.rate.value * (used - found.free_angle.value))
    middle, width = 0.5 * (load.min() + load.max()), float(np.ptp(used))
    weights = np.array([0.0, 0.0, 1.0, middle])
    friction = float(weights @ best)
    error = math.sqrt(float(weights @ covariance @ weights))
    factor = float(student.ppf(SURE, max(found.used - len(best), 1)))
    grown = float(best[3]) * found.rate.value
    return replace(
        found,
        friction=BenchValue(friction, factor * error),
        winding=found.rate.value + grown,
        unwinding=found.rate.value - grown,
        loss=2.0 * friction * width / (width * (middle + friction)),
        slip=None if friction <= DISTINCT * error else _slip(found, test),
        reversed_branches=friction < -DISTINCT * error,
    )


def _slip(found: MeasuredCycles, test: _Test) -> float | None:
    """Angle behind the turning points at which the torque crosses the spring's own line, in the mean; rad."""
    crossings = []
    for number in range(1, int(test.stroke.max()) + 1):
        own = np.flatnonzero(test.stroke == number)
        turn = own[0] - 1
        if abs(test.torque[turn]) < SLACK * found.used_torque:
            continue  # at the slack end
        travel = np.abs(test.angle[own] - test.angle[turn])
        line = found.rate.value * (test.angle[own] - found.free_angle.value)
        beyond = (test.torque[own] - line) * test.way[own]  # from minus to plus the friction
        (crossed,) = np.nonzero(beyond > 0.0)
        if len(crossed) and crossed[0] >= 2:  # at least two samples on the way tell where
            k = crossed[0]
            share = beyond[k - 1] / (beyond[k - 1] - beyond[k])
            crossings.append(float(travel[k - 1] + share * (travel[k] - travel[k - 1])))
    return float(np.mean(crossings)) if crossings else None
