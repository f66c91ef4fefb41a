"""Which static points contradict the recordings: those are left out of the fit, and named.

A fit estimates the recordings' noise from its own residuals. A point with a small error that no leg of these recordings
meets (a torque with the wrong sign) moves the leg away from them, their residuals become noise, and the point is met:
one number then decides against hundreds of samples, and the recordings are blamed. So the points are compared with the
fit to the recordings alone, whose noise they cannot change: by how much the least sum of squares grows with a point is
the square of its deviations (Chow, Econometrica 28 (1960) 591), along a ridge too, where a linear prediction tells
nothing. What the links' errors do to that fit and to the leg's weight is allowed for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array
from synth.estimation.intervals import NORMAL90
from synth.files.static_points_file import StaticPoint
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_problem import unknowns_of
from synth.fit.least_squares import FitStart, Stage, solve
from synth.fit.link_errors import link_errors, link_widths, residuals_by_links
from synth.fit.recordings import Recording
from synth.fit.ridge import ALLOWANCE, MISFIT, overall_rms
from synth.fit.static_points import Balance, balances, groups, independent_residuals, linearised, spread_at
from synth.fit.trajectories import TrajectoryModel
from synth.fit.uncertainty import clipped_rms, covariance
from synth.remarks import decisive
from synth.units import significant

# Standard deviations from which a point is left out: by chance once in 16 000, as rarely as the test of the first
# samples believes in a hand; where free angles shift by a spread that four trials tell, once in 80. Nearer ones are
# used, and named from ``MISPLACED_POINT`` on.
CONTRADICTING = 4.0
TOLERANCE = 0.01  # of a log-likelihood; one deviation is 0.5
CHANCE = 4.0  # of a square of deviations, up to which two points are equally likely to be the wrong one
SIGN = (
    "Turn the sign of torque: it is what acts on the leg from outside, not what the spring does, and is positive in "
    "the sense in which the measured angle grows."
)
CHECKS = (
    "Check its angle, torque and joint, and the link masses; a spring that is not linear differs too. If the point may "
    "be that far off, state its torque_error and angle_error, and it is used with that weight."
)


@dataclass(frozen=True)
class LeftOutPoint:
    """A balance that the recordings contradict by so many ``deviations``, theirs, the point's and the links' together.

    ``torque`` N m of the spring in this pose by the recordings alone, ``width`` half its 90 % interval; ``turned``
    whether the point agrees with its known torque in the other sense; ``beside`` whether it agrees without the others.
    """

    balance: Balance
    torque: float
    width: float
    deviations: float
    turned: bool
    beside: bool = False

    def sentence(self, joint: str) -> str:
        """What was done, by how much they differ, and the likely mistake."""
        name, point = f"static point {self.balance.name}, {joint}", f"{self.balance.torque:.3g} N*m"
        if self.beside:
            return decisive(
                f"{name}: the static points contradict each other, by {self.deviations:.0f} standard deviations "
                "beside the recordings, and it is one of those that may be wrong: it is left out",
                CHECKS,
            )
        text = (
            f"{name}: it contradicts the recordings and is left out. The spring torque is {point} there by the point "
            f"and {self.torque:.3g} +- {significant(self.width, 2)} N*m by the recordings alone, "
            f"{self.deviations:.0f} standard deviations apart"
        )
        if self.turned:
            return decisive(f"{text}. With the torque's sign turned it agrees", SIGN)
        return decisive(text, CHECKS)


@dataclass(frozen=True)
class CheckedPoints:
    """The points to use, and the balances that are left out."""

    static: tuple[StaticPoint, ...]
    left_out: tuple[LeftOutPoint, ...] = ()


def check_points(
    model: TrajectoryModel, recordings: Sequence[Recording], stage: Stage, options: LegFitOptions, scatter: Array
) -> CheckedPoints:
    """Compare the points with ``stage``, the fit to the recordings alone by ``model``, which has no points.

    ``scatter`` (n,) rad, the readings' noise.
    """
    every, unknowns = balances(model.leg, options.static), unknowns_of(model)
    far = _far(every, *unknowns.springs(stage.solution.values), stage.weights.points)
    if not far or not np.isfinite(stage.solution.cost):
        return CheckedPoints(options.static)  # at the fit without it, a point grows by no more than its own square
    comparison = _Comparison(model, recordings, stage, scatter, every, _errors(model, recordings, stage, options))
    left_out = {k: found for k in far if (found := comparison.left_out(k)) is not None}
    left_out |= comparison.of_each_other([k for k in range(len(every)) if k not in left_out], far)
    static = without_balances(options.static, [every[k] for k in left_out])
    return CheckedPoints(static, tuple(left_out[k] for k in sorted(left_out)))


def _far(every: Sequence[Balance], rates: Array, rests: Array, spread: Array | None) -> list[int]:
    """Numbers of the balances that are far from the fit to the recordings alone, log ``rates`` and ``rests`` (n,).

    Those of a session share a shift: each may be near, and their differences far.
    """
    found: set[int] = set()
    for numbers in groups(every):
        group = [every[k] for k in numbers]
        joint = group[0].joint
        at = float(rates[joint]), float(rests[joint]), spread_at(spread, joint)
        found |= {k for k in numbers if abs(every[k].residual(*at)) > CONTRADICTING}
        if group[0].session is not None and at[2] > 0.0:
            together = independent_residuals(group, *at)
            if together @ together > CONTRADICTING**2 + len(group) - 1:
                found |= set(numbers)
    return sorted(found)


def without_balances(static: Sequence[StaticPoint], some: Sequence[Balance]) -> tuple[StaticPoint, ...]:
    """The points without these balances; a point of which none is left is left out."""
    gone = {(balance.name, balance.joint) for balance in some}
    kept = [
        replace(point, balanced=tuple(j for j in point.balanced if (point.name, j) not in gone)) for point in static
    ]
    return tuple(point for point in kept if point.balanced)


@dataclass(frozen=True)
class _PointErrors:
    """Of each balance's residual at the fit to the recordings alone, in the point's own deviations.

    ``slope`` (m, p) by the unknowns, ``by_fit`` (m,) variance by the recordings' noise, ``by_links`` (m,) by the links.
    """

    slope: Array
    by_fit: Array
    by_links: Array

    @property
    def factor(self) -> Array:
        """(m,) on deviations that neglect the links' errors."""
        return np.asarray(np.sqrt((1.0 + self.by_fit) / (1.0 + self.by_fit + self.by_links)))


def _errors(
    model: TrajectoryModel, recordings: Sequence[Recording], stage: Stage, options: LegFitOptions
) -> _PointErrors:
    unknowns, every = unknowns_of(model), balances(model.leg, options.static)
    rates, rests = unknowns.springs(stage.solution.values)
    spread = stage.weights.points
    slope = np.zeros((len(every), len(stage.solution.values)))
    for row, point in zip(slope, every, strict=True):
        at = float(rates[point.joint]), float(rests[point.joint]), spread_at(spread, point.joint)
        row[[unknowns.rate_at(point.joint), unknowns.rest_at(point.joint)]] = linearised([point], *at)[1][0]
    by_fit = np.einsum("mp,pq,mq->m", slope, covariance(model, stage.solution), slope)
    widths = link_widths(model.leg, options.tolerance, recordings)
    links = link_errors(model, recordings, stage, widths)
    by_links = np.zeros(len(every))
    if links is not None:
        held = residuals_by_links(model.leg, widths, options.static, rates, rests, spread)
        by_links = np.sum((held + slope @ links.considered.sensitivity) ** 2, axis=1)
    return _PointErrors(slope, by_fit, by_links)


@dataclass(frozen=True)
class _Comparison:
    """Fits with some of the balances ``every`` beside that to the recordings alone, ``stage``, at its noise."""

    model: TrajectoryModel
    recordings: Sequence[Recording]
    stage: Stage
    scatter: Array
    every: tuple[Balance, ...]
    errors: _PointErrors

    def left_out(self, k: int) -> LeftOutPoint | None:
        """The balance ``k`` by itself, if the recordings contradict it."""
        point = self.every[k]
        deviations = self._deviations([point], self.errors.factor[k])
        if deviations <= CONTRADICTING:
            return None
        other = replace(point, torque=point.torque - 2.0 * point.applied)
        turned = point.applied != 0.0 and self._deviations([other], self.errors.factor[k]) <= CONTRADICTING
        return self._named(k, deviations, turned=turned)

    def of_each_other(self, kept: list[int], far: Sequence[int]) -> dict[int, LeftOutPoint]:
        """Balances that each agree with the recordings, but not together; all that may be the wrong one."""
        found: dict[int, LeftOutPoint] = {}
        # One that is near the fit to the recordings alone may be so by chance: a ridge has its own place for each.
        while len(kept) > 1 and any(k in far for k in kept):
            factor = float(self.errors.factor[kept].min())
            deviations = self._deviations([self.every[k] for k in kept], factor)
            if deviations**2 <= CONTRADICTING**2 + len(kept) - 1:
                break
            without = [self._deviations([self.every[i] for i in kept if i != k], self.errors.factor[k]) for k in kept]
            worst = [k for k, left in zip(kept, without, strict=True) if left**2 <= min(without) ** 2 + CHANCE]
            found |= {k: self._named(k, deviations, turned=False, beside=True) for k in worst}
            kept = [k for k in kept if k not in worst]
        return found

    def _named(self, k: int, deviations: float, *, turned: bool, beside: bool = False) -> LeftOutPoint:
        point, slope = self.every[k], self.errors
        rates, rests = unknowns_of(self.model).springs(self.stage.solution.values)
        rate = float(np.exp(rates[point.joint]))
        rest = float(rests[point.joint])
        torque, spread = point.spring_torque(rate, rest), spread_at(self.stage.weights.points, point.joint)
        width = NORMAL90 * point.error(rate, rest, spread) * float(np.sqrt(slope.by_fit[k] + slope.by_links[k]))
        return LeftOutPoint(point, torque, width, deviations, turned, beside)

    def _deviations(self, some: Sequence[Balance], factor: float) -> float:
        """Root of twice the growth of the least cost with ``some`` points, by ``factor`` less for the links' errors.

        0 where the model lacks an effect, so that the least residual along a ridge means nothing, and as good a fit to
        the recordings meets the points.
        """
        unknowns, alone = unknowns_of(self.model), self.stage.solution
        beside = replace(unknowns, balances=tuple(some))
        model = TrajectoryModel(self.model.chain, self.model.leg, beside, max_steps=self.model.max_steps)
        weights = replace(self.stage.weights, centre=None)
        found = solve(model, self.recordings, FitStart(alone.values, alone.locals), weights, tolerance=TOLERANCE)
        if not np.isfinite(found.cost):
            return float("inf")
        if np.any(clipped_rms(self.recordings, alone.predictions) > MISFIT * self.scatter):
            met = not _far(some, *unknowns.springs(found.values), weights.points)
            limit = (1.0 + ALLOWANCE) * overall_rms(self.recordings, alone)
            if met and overall_rms(self.recordings, found) <= limit:
                return 0.0
        return factor * float(np.sqrt(2.0 * max(found.cost - alone.cost, 0.0)))
