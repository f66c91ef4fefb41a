"""The response error of a set of parts with tolerances: expectation, 90 % interval, probability, and its causes.

Every sample of the tolerances is one lane of the simulation: rates, free angles and torques are drawn within their
limits, and the arms' offsets are those of the nominal parts. All dampers of a sample have the same temperature. The
draws are a Latin hypercube by the project's seed (McKay, Beckman & Conover, Technometrics 21, 1979). They are the same
for every set, so that the comparison of sets is not affected by sampling noise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from hashlib import blake2b
from math import radians, sqrt
from types import MappingProxyType
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.design.assumed_laws import LawsOff, columns_off
from synth.design.choose_dampers import DamperOption
from synth.design.choose_springs import SpringOption
from synth.design.part_lanes import ROWS, PartLanes, column
from synth.files.project_options import ToleranceOptions
from synth.parts.damper_law import CONCAVE_EXPONENT
from synth.parts.part_tolerance import (
    PROJECT,
    DamperTolerance,
    SpringTolerance,
    bought_damper,
    bought_spring,
    measured_damper,
)
from synth.swing.lane_layout import CURVE_POINTS
from synth.units import quantity

CAUSES = ("spring rate", "free angle", "damper torque", "law of the damper")  # of each joint
TEMPERATURE = "temperature"
OF_WIRE = "by the wire's and the coil's tolerances"
EXPONENTS = 9  # levels of an assumed law's exponent
OUTER_NODE = sqrt(3.0 / 5.0)  # Gauss and Legendre's three points on [-1, 1]: weights 5/18, 8/18, 5/18 of a uniform draw

MEASURED_ANGLE = radians(1.0)  # uncertainty of a free angle measured with a protractor

SetParts = Sequence[tuple[SpringOption, DamperOption]]


@dataclass(frozen=True)
class SpringInHand:
    """A joint's measured spring, its seat set for it: rate (N m/rad), rotation at which it is unloaded (rad).

    ``angle_known``: that rotation was measured in the joint, within ``MEASURED_ANGLE``; else it has the part's
    tolerance. A measured rate keeps the part's tolerance: the error of its measurement is unknown.
    """

    rate: float
    rest: float
    angle_known: bool


IN_HAND: Mapping[int, SpringInHand] = MappingProxyType({})  # of no joint


@dataclass(frozen=True)
class Share:
    """A cause's share of the spread; ``alone``: the RMS error (rad) with this cause only, all else nominal."""

    joint: str | None
    cause: str
    share: float
    alone: float

    def as_json(self) -> dict[str, Any]:
        return {
            "joint": self.joint or "all",
            "cause": self.cause,
            "share": quantity(self.share, "1"),
            "alone": quantity(self.alone, "deg"),
        }


@dataclass(frozen=True)
class Forecast:
    """The distribution of the response error (rad, RMS over joints and releases) of a set of parts.

    ``chance``: probability that the error is at most ``within``. ``shares`` of the spread, largest first, if computed.
    ``laws_off``: the nominal error where the assumed laws of dampers, which the draws take as true, are not; None if
    all are known, or if it was not computed.
    """

    nominal: float
    expected: float
    interval90: tuple[float, float]
    chance: float
    within: float
    n_sample: int
    shares: tuple[Share, ...] = ()
    laws_off: LawsOff | None = None

    def as_json(self) -> dict[str, Any]:
        """Every number with its unit."""
        low, high = np.degrees(self.interval90)
        written: dict[str, Any] = {
            "nominal": quantity(self.nominal, "deg"),
            "expected": {**quantity(self.expected, "deg"), "interval90": [float(low), float(high)]},
            "within": quantity(self.within, "deg"),
            "chance": quantity(self.chance, "1"),
            "samples": self.n_sample,
        }
        if self.shares:
            written["causes"] = [share.as_json() for share in self.shares]
        if self.laws_off is not None:
            written["assumed_laws"] = self.laws_off.as_json()
        return written


def spring_tolerance(option: SpringOption, asked: ToleranceOptions) -> SpringTolerance:
    """Tolerance of all parallel springs together; the mean of independent springs has a smaller spread."""
    if option.row is not None:
        known, count = bought_spring(option.row), option.count
    else:
        assert option.design is not None
        plus, count = option.design.tolerance, option.design.count
        known = SpringTolerance(plus.rate, plus.free_angle, OF_WIRE, OF_WIRE)
    if asked.rate is not None:
        known = replace(known, rate=asked.rate, rate_source=PROJECT)
    if asked.free_angle is not None:
        known = replace(known, free_angle=asked.free_angle, free_angle_source=PROJECT)
    return replace(known, rate=known.rate / sqrt(count), free_angle=known.free_angle / sqrt(count))


def free_angles_measured(asked: ToleranceOptions) -> ToleranceOptions:
    """The tolerances that remain when the springs' free angles are measured."""
    known = MEASURED_ANGLE if asked.free_angle is None else min(MEASURED_ANGLE, asked.free_angle)
    return replace(asked, free_angle=known)


def damper_tolerance(option: DamperOption, asked: ToleranceOptions) -> DamperTolerance:
    """Tolerance of all dampers of an arrangement together.

    Of a part that was measured at another joint, another specimen acts here: its curve is off as parts are. Below the
    lowest point of a measured table the exponent is as uncertain as that of an assumed law.
    """
    elsewhere = option.measured is not None and option.measured.at
    if option.row is None or (option.law == "curve" and not elsewhere):
        known = measured_damper(asked.measured)
    else:
        known = bought_damper(option.row, option.law)
        if asked.torque is not None:
            known = replace(known, torque=asked.torque, torque_source=PROJECT)
    exponents = known.exponents if option.below is None else option.below.exponents
    return replace(known, torque=known.torque / sqrt(option.arrangement.pieces), exponents=exponents)


@lru_cache(maxsize=8)
def latin_hypercube(n: int, n_sample: int, seed: int) -> Array:
    """(n, n_sample) in [-1, 1]: of each row one draw in each of ``n_sample`` equal strata, in random order.

    McKay, Beckman and Conover, Technometrics 21 (1979) 239. The same numbers as ``scipy.stats.qmc.LatinHypercube``
    gives, whose import takes 0.7 s.
    """
    random = np.random.default_rng(seed).spawn(1)[0]
    within = random.uniform(size=(n_sample, n))
    strata = np.tile(np.arange(1, n_sample + 1), (n, 1))
    for row in strata:
        random.shuffle(row)
    drawn = 2.0 * ((strata - within.T) / n_sample) - 1.0
    drawn.setflags(write=False)
    return np.asarray(drawn)


class Forecaster:
    """Draws the tolerances of sets of parts in one leg; ``in_hand``: measured springs, by the number of their joint."""

    def __init__(
        self,
        lanes: PartLanes,
        asked: ToleranceOptions,
        within: float,
        seed: int = 0,
        in_hand: Mapping[int, SpringInHand] = IN_HAND,
    ) -> None:
        self.lanes, self.asked, self.within, self.seed, self.in_hand = lanes, asked, within, seed, in_hand
        self._known: dict[bytes, Array] = {}  # errors by the content of the lanes
        self._levels: dict[tuple[object, ...], tuple[Array, Array]] = {}  # see ``_curves``

    def forecast(self, parts: SetParts, n_sample: int, *, shares: bool = False) -> Forecast:
        """The error of one set over ``n_sample`` draws; with ``shares`` also these, and that of assumed laws off."""
        errors = self._errors(parts, self._draws(len(parts), n_sample))
        nominal = float(self._errors(parts, np.zeros((4 * len(parts) + 1, 1)))[0])
        low, high = np.quantile(errors, [0.05, 0.95])  # 90 % interval
        return Forecast(
            nominal,
            float(np.mean(errors)),
            (float(low), float(high)),
            float(np.mean(errors <= self.within)),
            self.within,
            n_sample,
            self._shares(parts, nominal) if shares else (),
            self._laws_off(parts) if shares else None,
        )

    def expected(self, parts: SetParts, n_sample: int) -> float:
        """The expected error (rad) of ``forecast`` only; sets are compared by it."""
        return float(np.mean(self._errors(parts, self._draws(len(parts), n_sample))))

    def _errors(self, parts: SetParts, draws: Array) -> Array:
        """(n_sample,) rad; lanes that were simulated before are not run again."""
        columns = self._columns(parts, draws)
        key = blake2b(b"".join(each.tobytes() for each in columns)).digest()
        if key not in self._known:
            self._known[key] = self.lanes.errors_of(columns)
        return self._known[key]

    def _draws(self, n: int, n_sample: int) -> Array:
        """(4 n + 1, n_sample) in [-1, 1]: four causes per joint, then temperature."""
        return latin_hypercube(4 * n + 1, n_sample, self.seed)

    def _columns(self, parts: SetParts, draws: Array) -> list[Array]:
        """Columns (ROWS, n_lane) by joint for draws (4 n + 1, n_lane)."""
        kelvin = draws[-1] * self.asked.temperature
        return [
            self._joint(j, spring, damper, draws[4 * j : 4 * j + 4], kelvin) for j, (spring, damper) in enumerate(parts)
        ]

    def _joint(self, j: int, spring: SpringOption, damper: DamperOption, draw: Array, kelvin: Array) -> Array:
        known = self.in_hand.get(j)
        asked = free_angles_measured(self.asked) if known is not None and known.angle_known else self.asked
        of_spring, of_damper = spring_tolerance(spring, asked), damper_tolerance(damper, self.asked)
        rate, rest = (spring.rate, self.lanes.rest(j, spring.rate)) if known is None else (known.rate, known.rest)
        made = np.repeat(column(rate, rest, damper.damper)[:, None], len(kelvin), 1)
        made[0] *= 1.0 + of_spring.rate * draw[0]
        made[1] += of_spring.free_angle * draw[1]
        if of_damper.exponents is not None:
            made[3:] = self._laws(damper, of_damper.exponents, draw[3])
        strength = (1.0 + of_damper.torque * draw[2]) * np.exp(of_damper.per_kelvin * kelvin)
        made[2] *= strength
        made[3 + CURVE_POINTS :] *= strength
        return made

    def _laws(self, damper: DamperOption, exponents: tuple[float, float], draw: Array) -> Array:
        """(2 CURVE_POINTS, n_lane) curve rows with the assumed law's exponent drawn between its limits."""
        (low, high), (levels, curves) = exponents, self._curves(damper, exponents)
        # A draw of 0 is the nominal law, although its exponent is not in the middle of the limits.
        exponent = CONCAVE_EXPONENT if damper.below is None else damper.below.exponent
        middle = exponent + draw * np.where(draw < 0.0, exponent - low, high - exponent)
        nearest = np.argmin(np.abs(levels[:, None] - middle[None, :]), axis=0)
        found = curves[:, nearest]
        nominal = column(1.0, 0.0, damper.damper)[3:]
        return np.asarray(np.where(draw == 0.0, nominal[:, None], found))

    def _curves(self, damper: DamperOption, exponents: tuple[float, float]) -> tuple[Array, Array]:
        """(EXPONENTS,) exponents between the limits, and the rows (2 CURVE_POINTS, EXPONENTS) of their curves."""
        key = (damper.row, damper.law, damper.measured, damper.arrangement, exponents)
        if key not in self._levels:
            levels = np.linspace(*exponents, EXPONENTS)
            curves = [column(1.0, 0.0, damper.with_exponent(float(n)))[3:] for n in levels]
            assert len(curves[0]) == ROWS - 3
            self._levels[key] = levels, np.stack(curves, axis=1)
        return self._levels[key]

    def _laws_off(self, parts: SetParts) -> LawsOff | None:
        """The nominal error with the assumed laws off to either side; a few lanes."""
        dampers = [
            (damper.damper, damper.known_from) if damper_tolerance(damper, self.asked).exponents is not None else None
            for _, damper in parts
        ]
        names = tuple(name for name, damper in zip(self.lanes.leg.joint_names, dampers, strict=True) if damper)
        if not names:
            return None
        nominal = self._columns(parts, np.zeros((4 * len(parts) + 1, 1)))
        errors = self.lanes.errors_of(columns_off(nominal, dampers))
        return LawsOff(names, float(errors.min()), float(errors.max()))

    def _shares(self, parts: SetParts, nominal: float) -> tuple[Share, ...]:
        """Each cause alone at its two outer Gauss points; shares of the growth of the mean squared error."""
        n_cause = 4 * len(parts) + 1
        draws = np.concatenate([np.eye(n_cause), -np.eye(n_cause)], axis=1) * OUTER_NODE
        square = self.lanes.errors_of(self._columns(parts, draws)).reshape(2, n_cause) ** 2
        alone = (5.0 * square.sum(axis=0) + 8.0 * nominal**2) / 18.0
        grown = np.maximum(alone - nominal**2, 0.0)
        names = [(name, cause) for name in self.lanes.leg.joint_names for cause in CAUSES]
        total = float(grown.sum()) or 1.0
        found = [
            Share(joint, cause, float(g) / total, float(np.sqrt(a)))
            for (joint, cause), g, a in zip([*names, (None, TEMPERATURE)], grown, alone, strict=True)
        ]
        return tuple(sorted(found, key=lambda share: -share.share))
