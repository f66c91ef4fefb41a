"""A motor's constants from its response: current and speed are simulated from the recorded voltage and fitted.

The output-error method (Ljung, System Identification, 2nd edition 1999, sections 4.3 and 7.4): no noise is in the
simulation, so that of current and speed biases nothing, as it does where they are regressors (Söderström, Automatica
43 (2007) 939). Each run's current and speed at its first sample are unknown. Constants that cannot be negative are
fitted by their logarithms. The noise is estimated from the residuals; their autocorrelation reduces the information.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from synth.arrays import Array
from synth.estimation.correlation import correlation_factors_by_step
from synth.estimation.intervals import NORMAL90
from synth.estimation.levenberg_marquardt import Iterate, LeastSquares, Nielsen, minimise
from synth.estimation.normal_equations import ParameterStep, ReducedNormal, StepLimits, TrialNormal
from synth.hopper.motor_response import CONSTANTS, motor_responses

RATES = np.array([name not in ("friction", "viscous") for name in CONSTANTS])  # positive, fitted by logarithms
INDUCTANCE = CONSTANTS.index("inductance")
STEP = 1e-6  # of an unknown in its scale, for derivatives; the response is exact to 1e-12
ROUNDS = 40  # steps of a fit; from the windows' estimate it takes five to ten
REWEIGHTED = 8  # repetitions with the noise of the fit before; noise-free recordings take four
SAME_NOISE = 0.01  # relative change of the noise that ends them
LEAST_NOISE = 1e-9  # of a column's root mean square: noise of recordings without any
LEAST_GAIN = 1e-4  # of the cost: a step of 0.014 standard deviations
SAME_COST = 1e-2  # difference of cost, 0.14 standard deviations, below which two fits are alike
# Damping from a null direction's rounding to no step at all; hardly damped, a step's predicted gain is what it gains.
RULE = Nielsen(least=1e-12, most=1e12, settled=1.0, hardly_damped=1e-2)
SHORTEST = 40.0  # samples over L/R, above which no response shows L: it is within exp(-40) of none


@dataclass(frozen=True, eq=False)
class ResponseRun:
    """``time`` (n,) s, ``voltage`` (n,) V without its noise, ``measured`` (n, 2) current A and rotor speed rad/s."""

    time: Array
    voltage: Array
    measured: Array


@dataclass(frozen=True, eq=False)
class ResponsePoint:
    """``unknowns`` (6,) of ``ResponseFit``, and each run's initial current and speed, ``starts`` (n_run, 2)."""

    unknowns: Array
    starts: Array
    cost: float = np.inf


@dataclass(frozen=True, eq=False)
class ResponseFit(LeastSquares[ResponsePoint]):
    """Half the sum of squares of the residuals over ``deviation`` (n_run, 2) A, rad/s.

    ``unit`` (6,): the unknowns of friction and its viscous part are in these. ``low``, ``high`` (6,): bounds.
    """

    runs: tuple[ResponseRun, ...]
    unit: Array
    low: Array
    high: Array
    deviation: Array

    def constants(self, unknowns: Array) -> Array:
        """(6, m) SI, in the order of ``CONSTANTS``, of unknowns (6, m)."""
        return np.where(RATES[:, None], np.exp(np.where(RATES[:, None], unknowns, 0.0)), unknowns * self.unit[:, None])

    def residuals(self, point: ResponsePoint) -> list[Array]:
        """(n, 2) measured less simulated, of each run."""
        lane = self.constants(point.unknowns[:, None])
        found = []
        for run, start in zip(self.runs, point.starts, strict=True):
            found.append(run.measured - motor_responses(run.time, run.voltage, lane, start[:, None])[:, :, 0])
        return found

    def evaluate(self, points: Sequence[ResponsePoint]) -> Sequence[ResponsePoint]:
        """The points with their costs."""
        costs = [
            0.5 * sum(float(np.sum((r / d) ** 2)) for r, d in zip(self.residuals(p), self.deviation, strict=True))
            for p in points
        ]
        return [replace(p, cost=cost if np.isfinite(cost) else np.inf) for p, cost in zip(points, costs, strict=True)]

    def normal(self, point: ResponsePoint) -> ReducedNormal:
        """Normal equations with the initial states eliminated."""
        count = len(CONSTANTS)
        shifted = point.unknowns[:, None] + STEP * np.eye(count, count + 3)
        lanes, parts = self.constants(shifted), []
        for run, start, deviation in zip(self.runs, point.starts, self.deviation, strict=True):
            size = STEP * np.maximum(np.sqrt(np.mean(run.measured**2, axis=0)), 1e-300)
            begun = start[:, None] + np.concatenate([np.zeros((2, count)), np.diag(size), np.zeros((2, 1))], axis=1)
            out = motor_responses(run.time, run.voltage, lanes, begun)
            steps = np.concatenate([np.full(count, STEP), size])
            slopes = ((out[:, :, :-1] - out[:, :, -1:]) / steps / deviation[:, None]).reshape(-1, count + 2)
            left = ((out[:, :, -1] - run.measured) / deviation).ravel()
            common, own = slopes[:, :count], slopes[:, count:]
            parts.append(TrialNormal(common.T @ common, common.T @ own, own.T @ own, common.T @ left, own.T @ left))
        return ReducedNormal.of(parts, np.zeros((count, count)), np.zeros(count))

    def bounds(self, point: ResponsePoint) -> tuple[Array, Array]:
        """Lowest and highest unknowns, (p,) each."""
        return self.low, self.high

    def moved(self, point: ResponsePoint, step: ParameterStep) -> ResponsePoint:
        """The point after a step."""
        return ResponsePoint(point.unknowns + step.common, point.starts + np.array(step.own))

    def least_gain(self, cost: float) -> float:
        """Least gain of a step in standard deviations, not in shares of the cost."""
        return LEAST_GAIN

    def limits(self, point: ResponsePoint) -> StepLimits:
        """A factor e at most."""
        return StepLimits(common=1.0, follow=True)

    def best(self, starts: Sequence[ResponsePoint]) -> ResponsePoint:
        """The lowest of the minima reached from these points."""
        begun = [Iterate(point) for point in self.evaluate(starts)]
        return min((it.point for it in minimise(self, begun, RULE, ROUNDS)), key=lambda point: point.cost)

    def with_inductance(self, unknown: float) -> ResponseFit:
        """The same with the inductance held."""
        low, high = self.low.copy(), self.high.copy()
        low[INDUCTANCE] = high[INDUCTANCE] = unknown
        return replace(self, low=low, high=high)


def fit_response(runs: Sequence[ResponseRun], near: Array) -> tuple[ResponseFit, ResponsePoint]:
    """The fit with its noise estimated, and its best point.

    ``near`` (6,): constants to start from, SI; an inductance that no run can show, or below 0, starts elsewhere.
    """
    shortest = min(float(np.median(np.diff(run.time))) for run in runs)
    longest = max(float(run.time[-1] - run.time[0]) for run in runs)
    whole = [np.sqrt(np.mean(np.concatenate([run.measured[:, k] ** 2 for run in runs]))) for k in (0, 1)]
    torque = near[CONSTANTS.index("back_emf")] * whole[0]
    unit = np.array([1.0, 1.0, 1.0, torque, torque / max(whole[1], 1e-300), 1.0])
    first = near / unit
    first[RATES] = np.log(np.maximum(near[RATES], 1e-300))
    low, high = np.full(len(near), -np.inf), np.full(len(near), np.inf)
    low[INDUCTANCE], high[INDUCTANCE] = first[0] + np.log([shortest / SHORTEST, longest])
    floor = LEAST_NOISE * np.maximum(whole, 1e-300)
    fit = ResponseFit(tuple(runs), unit, low, high, np.tile(0.01 * np.array(whole), (len(runs), 1)))
    starts = np.array([run.measured[0] for run in runs])
    points = []
    for guess in (first[INDUCTANCE], *(first[0] + np.log(shortest * np.array([0.1, 1.0, 10.0])))):
        unknowns = first.copy()
        unknowns[INDUCTANCE] = np.clip(guess, low[INDUCTANCE], high[INDUCTANCE])
        points.append(ResponsePoint(unknowns, starts))
    best = fit.best(points)
    for _ in range(REWEIGHTED):
        before = fit.deviation
        fit = replace(fit, deviation=np.maximum(_noise(fit, best), floor))
        best = fit.best([best])
        if np.all(np.abs(fit.deviation / before - 1.0) < SAME_NOISE):
            break
    steps = [float(np.median(np.diff(run.time))) for run in runs]
    counted = np.sqrt(correlation_factors_by_step(fit.residuals(best), steps))
    fit = replace(fit, deviation=np.maximum(_noise(fit, best) * counted, floor))
    return fit, fit.best([best])


def inductance_of(fit: ResponseFit, best: ResponsePoint) -> tuple[float, float, float]:
    """The inductance and its 90 % interval, H, by profile likelihood; from 0 if none at all would do as well.

    The response is far from linear in the inductance where L/R is below the time between samples: there only an upper
    bound is known. Profile likelihood: Pawitan, In All Likelihood, 2001, section 3.4.
    """
    from scipy.optimize import brentq  # imported here: it takes 0.1 s, and only run-ups need it

    at, kept = float(best.unknowns[INDUCTANCE]), [best]

    @cache  # a repeated fit begins at its own end and gets a little lower: a bracket would lose its signs
    def beyond(unknown: float) -> float:
        """Standard deviations from the best fit to that with this inductance, less those of the interval's end."""
        near = min(kept, key=lambda point: abs(float(point.unknowns[INDUCTANCE]) - unknown))
        unknowns = near.unknowns.copy()
        unknowns[INDUCTANCE] = unknown
        kept.append(fit.with_inductance(unknown).best([ResponsePoint(unknowns, near.starts)]))
        return float(np.sqrt(2.0 * max(kept[-1].cost - best.cost, 0.0)) - NORMAL90)

    information = float(fit.normal(best).matrix[INDUCTANCE, INDUCTANCE])
    ends = []
    for bound, way in ((float(fit.low[INDUCTANCE]), -1.0), (float(fit.high[INDUCTANCE]), 1.0)):
        inside, step = at, 1.0 / np.sqrt(max(information, 1.0))
        while True:
            outside = way * min(way * bound, way * at + step)
            found = beyond(outside)
            if found > 0.0 or outside == bound:
                break
            inside, step = outside, 2.0 * step
        ends.append(float(brentq(beyond, inside, outside, xtol=0.01 * step)) if found > 0.0 else bound)
    none = float(fit.low[INDUCTANCE])
    low = 0.0 if ends[0] <= none else float(np.exp(ends[0]))
    without = min((point.cost for point in kept if point.unknowns[INDUCTANCE] <= none), default=np.inf)
    value = 0.0 if without <= best.cost + SAME_COST else float(np.exp(at))
    return value, low, float(np.exp(ends[1]))


def _noise(fit: ResponseFit, point: ResponsePoint) -> Array:
    """(n_run, 2) of current and speed, all runs alike: RMS of all residuals, with half the unknowns taken by each."""
    left = np.concatenate(fit.residuals(point))
    taken = len(point.unknowns) / 2 + len(point.starts)
    return np.tile(np.sqrt(np.sum(left**2, axis=0) / max(1.0, len(left) - taken)), (len(fit.runs), 1))
