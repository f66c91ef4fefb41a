"""A motor's constants from its response: current and speed are simulated from the recorded voltage and fitted.

The output-error method (Ljung, System Identification, 2nd edition 1999, sections 4.3 and 7.4): no noise is in the
simulation, so that of current and speed biases nothing, as it does where they are regressors (Söderström, Automatica
43 (2007) 939). Each run's current and speed at its first sample are unknown; of a motor that stood until it was
switched on before that sample, only the time of the switch-on is. Constants that cannot be negative are fitted by their
logarithms. The noise is estimated from the residuals; their autocorrelation reduces the information.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.estimation.correlation import correlation_factors_by_step
from synth.estimation.intervals import NotFiniteError, covariance_of
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
# Damping from a null direction's rounding to no step at all; hardly damped, a step's predicted gain is what it gains.
RULE = Nielsen(least=1e-12, most=1e12, settled=1.0, hardly_damped=1e-2)
SHORTEST = 40.0  # samples over L/R, above which no response shows L: it is within exp(-40) of none
# The share of a sample since the switch-on is fitted by its logit: 0.5 to begin with, at most 2 a step, and at most 12,
# which is 6 millionths of a sample from its ends: less than a noise shows, and the slope does not vanish
MOST_LOGIT, LOGIT_STEP = 12.0, 2.0


@dataclass(frozen=True, eq=False)
class ResponseRun:
    """``time`` (n,) s, ``voltage`` (n,) V without its noise, ``measured`` (n, 2) current A and rotor speed rad/s.

    ``after_rest`` : s before the first sample, within which the motor was switched on at rest; None: not known to be.
    """

    time: Array
    voltage: Array
    measured: Array
    after_rest: float | None = None

    @property
    def first_unknowns(self) -> Array:
        """(2,) current and speed at the first sample, as measured; (1,) 0 for half the time within ``after_rest``."""
        return self.measured[0] if self.after_rest is None else np.zeros(1)

    def first_states(self, lanes: Array, unknowns: Array) -> Array:
        """(2, m) current and speed at the first sample, of constants (6, m) and ``first_unknowns`` (k, m)."""
        if self.after_rest is None:
            return unknowns
        states = np.empty((2, lanes.shape[1]))
        for lane, logit in enumerate(unknowns[0].tolist()):
            since = np.array([0.0, self.after_rest / (1.0 + np.exp(-logit))])
            constants = lanes[:, lane : lane + 1]
            states[:, lane] = motor_responses(since, np.full(2, self.voltage[0]), constants, np.zeros((2, 1)))[1, :, 0]
        return states

    def responses(self, lanes: Array, unknowns: Array) -> Array:
        """(n, 2, m) simulated current and speed of constants (6, m) and ``first_unknowns`` (k, m)."""
        return motor_responses(self.time, self.voltage, lanes, self.first_states(lanes, unknowns))

    def moved(self, unknowns: Array, step: Array) -> Array:
        """``first_unknowns`` after a step."""
        if self.after_rest is None:
            return np.asarray(unknowns + step)
        return np.clip(unknowns + np.clip(step, -LOGIT_STEP, LOGIT_STEP), -MOST_LOGIT, MOST_LOGIT)

    @property
    def scale(self) -> Array:
        """Size of the ``first_unknowns``, for derivatives."""
        if self.after_rest is not None:
            return np.ones(1)
        return np.asarray(np.maximum(np.sqrt(np.mean(self.measured**2, axis=0)), 1e-300))


@dataclass(frozen=True, eq=False)
class ResponsePoint:
    """``unknowns`` (6,) of ``ResponseFit``, and each run's ``first_unknowns``, ``starts``."""

    unknowns: Array
    starts: tuple[Array, ...]
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
            found.append(run.measured - run.responses(lane, start[:, None])[:, :, 0])
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
        count, parts = len(CONSTANTS), []
        for run, start, deviation in zip(self.runs, point.starts, self.deviation, strict=True):
            own_count, size = len(start), STEP * run.scale
            lanes = self.constants(point.unknowns[:, None] + STEP * np.eye(count, count + own_count + 1))
            begun = start[:, None] + np.diag(size) @ np.eye(own_count, count + own_count + 1, count)
            out = run.responses(lanes, begun)
            steps = np.concatenate([np.full(count, STEP), size])
            slopes = ((out[:, :, :-1] - out[:, :, -1:]) / steps / deviation[:, None]).reshape(-1, count + own_count)
            left = ((out[:, :, -1] - run.measured) / deviation).ravel()
            common, own = slopes[:, :count], slopes[:, count:]
            parts.append(TrialNormal(common.T @ common, common.T @ own, own.T @ own, common.T @ left, own.T @ left))
        return ReducedNormal.of(parts, np.zeros((count, count)), np.zeros(count))

    def bounds(self, point: ResponsePoint) -> tuple[Array, Array]:
        """Lowest and highest unknowns, (p,) each."""
        return self.low, self.high

    def moved(self, point: ResponsePoint, step: ParameterStep) -> ResponsePoint:
        """The point after a step."""
        moved = zip(self.runs, point.starts, step.own, strict=True)
        return ResponsePoint(point.unknowns + step.common, tuple(run.moved(start, own) for run, start, own in moved))

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
    starts = tuple(run.first_unknowns for run in runs)
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


def standard_deviations(fit: ResponseFit, point: ResponsePoint, *, inductance_held: bool = False) -> Array:
    """(6,) standard deviations of the unknowns; of a held inductance 0.

    Raises
    ------
    UserError : the simulation diverges near the point.
    """
    free = [index for index in range(len(CONSTANTS)) if index != INDUCTANCE or not inductance_held]
    found = np.zeros(len(CONSTANTS))
    try:
        found[free] = np.sqrt(np.diag(covariance_of(fit.normal(point).matrix[np.ix_(free, free)])))
    except NotFiniteError as error:
        text = "the simulated current and speed diverge near the constants that fit best, so their uncertainty is"
        raise UserError(Problem(f"{text} unknown. Check the runs' units and signs, and the gear ratio")) from error
    return found


def moved_by_current(fit: ResponseFit, point: ResponsePoint, shift: float) -> Array:
    """(6,) change of the unknowns if all currents were larger by ``shift`` A, the inductance held; to first order."""
    free = [index for index in range(len(CONSTANTS)) if index != INDUCTANCE]
    runs = tuple(replace(run, measured=run.measured + np.array([shift, 0.0])) for run in fit.runs)
    here, there = fit.normal(point), replace(fit, runs=runs).normal(point)
    found = np.zeros(len(CONSTANTS))
    found[free] = covariance_of(here.matrix[np.ix_(free, free)]) @ (here.gradient - there.gradient)[free]
    return found


def _noise(fit: ResponseFit, point: ResponsePoint) -> Array:
    """(n_run, 2) of current and speed, all runs alike: RMS of all residuals, with half the unknowns taken by each."""
    left = np.concatenate(fit.residuals(point))
    taken = (len(point.unknowns) + sum(map(len, point.starts))) / 2
    return np.tile(np.sqrt(np.sum(left**2, axis=0) / max(1.0, len(left) - taken)), (len(fit.runs), 1))
