"""Dry friction or quadratic damping at the joints, where springs and linear dampers do not explain a motion.

A joint that rubs is the most usual leg with another law. Fitted without it, the first samples and the later ones ask
for different rates, as if a hand acted at first, and a spring on the ridge of an overdamped joint comes out at a
multiple of its rate. The law's coefficients are estimated by Gauss-Newton steps in which all other unknowns follow
(variable projection: Golub & Pereyra, Inverse Problems 19 (2003) R1), never below zero (Lawson & Hanson, Solving Least
Squares Problems, 1974, ch. 23).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.estimation.intervals import NORMAL90, spectrum
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_problem import model_of
from synth.fit.least_squares import FitStart, Solution, Stage, solve
from synth.fit.model_error import ModelError
from synth.fit.recordings import Recording
from synth.fit.uncertainty import clipped_rms, correlation_times
from synth.swing.leg_model import Leg
from synth.swing.mechanics import coefficients, momentum_and_force
from synth.units import quantity

# Of the mean squared error above the samples' scatter, what a law must leave at most to be named. Of 24 random legs
# that rub, friction leaves under 0.06 in 16; of 24 with quadratic damping, that leaves under 0.07 in 21; on 48 driven
# by a hand for 0.15 or 0.25 s friction leaves 0.7 and more.
LEAVES = 0.2
HOPELESS = 0.85  # the same, as predicted by the first linear step: no further one is taken
FIRST = 0.03  # of the torque of springs and gravity, the first step of a law's torque at the joint's RMS speed
LEAST_STEP = 0.003  # as ``FIRST``, of a coefficient that is nearly zero
NEXT = 0.3  # of the coefficient, later ones
STEPS = 6
NEAR_ENOUGH = 0.05  # of the log-likelihood, of the other unknowns' fits
SUSPECT = 1.15  # times the samples' scatter, a joint's residuals from which a law is looked for
# Twice the gain of the log-likelihood by a law, correlated samples counted once: more than chance gives four joints.
LEAST_GAIN = 30.0
SETTLED = 0.05  # of the error above the scatter, gain of a step that is the last
HALVINGS = 4
SURE = 2.0  # standard deviations from zero, of a coefficient that is kept
SAMPLES = 400  # of a trial that are used
TRIALS = 6


@dataclass(frozen=True)
class SpeedLaw:
    """A torque that opposes motion: the ``effect``, its ``key`` and ``unit``, what it is called; ``power`` of speed."""

    effect: str
    key: str
    unit: str
    words: str
    power: int


# Those that a leg of springs and linear dampers lacks most often; ``synth gap`` has the rest.
LAWS = (
    SpeedLaw("coulomb_friction", "torque", "N*m", "dry friction", 0),
    SpeedLaw("quadratic_damping", "coefficient", "N*m*s^2/rad^2", "damping that grows with the square of speed", 2),
)


@dataclass(frozen=True)
class AnotherLaw:
    """``size`` (n,) of the law's coefficient at each joint, SI, 0 where it does not act, ``deviation`` (n,) of it.

    ``leg`` : the given one with it as its effect. ``moved`` (p, c) change of the common unknowns per standard
    deviation of each independent error of the coefficients. ``left`` : share of the error that stays.
    """

    law: SpeedLaw
    leg: Leg
    size: Array
    deviation: Array
    moved: Array
    left: float

    @property
    def error(self) -> ModelError:
        """Of the coefficients, with the finding and how to write it."""
        law = self.law
        told = ", ".join(
            f"{joint.name} {size:.3g} +- {NORMAL90 * deviation:.2g} {law.unit}"
            for joint, size, deviation in zip(self.leg.joints, self.size, self.deviation, strict=True)
            if size > 0.0
        )
        return ModelError(
            self.moved,
            f"{law.words} explains {100 * min(1 - self.left, 1.0):.0f} % of what springs and linear dampers leave: "
            f"{told}. It is part of the fitted leg and its uncertainty is in the intervals. To state it beforehand, "
            f"write effects: [{{{law.effect}: {{{law.key}: ...}}}}] at the joint in the leg file; to fit without it, "
            "laws: linear",
        )

    def as_json(self) -> dict[str, Any]:
        """The entry ``law`` of ``fit.json``."""
        sizes = {
            joint.name: quantity(size, self.law.unit, (max(0.0, size - NORMAL90 * width), size + NORMAL90 * width))
            for joint, size, width in zip(self.leg.joints, self.size.tolist(), self.deviation.tolist(), strict=True)
            if size > 0.0
        }
        return {"effect": self.law.effect, self.law.key: sizes, "explains": min(1.0 - self.left, 1.0)}


def suspected(recordings: Sequence[Recording], stage: Stage, scatter: Array) -> bool:
    """Whether some joint's residuals are larger than the samples' ``scatter`` (n,) rad."""
    return bool(np.any(clipped_rms(recordings, stage.solution.predictions) > SUSPECT * scatter))


def another_law(
    leg: Leg, recordings: Sequence[Recording], stage: Stage, options: LegFitOptions, scatter: Array
) -> AnotherLaw | None:
    """The law that explains what the fit ``stage`` leaves above the samples' ``scatter`` (n,) rad; None if none does.

    None too for a leg whose file states an effect, and for trials with legs of their own.
    """
    if any(joint.effects for joint in leg.joints) or any(recording.leg is not None for recording in recordings):
        return None
    every = max(1, -(-len(recordings) // TRIALS))
    some = [recording.thinned(SAMPLES) for recording in recordings[::every]]
    found = [_Search(law, leg, some, options, stage, scatter, every).found() for law in LAWS]
    return min((each for each in found if each is not None), key=lambda each: each.left, default=None)


class _Search:
    """Gauss-Newton steps of a law's coefficients on some of the trials."""

    def __init__(
        self,
        law: SpeedLaw,
        leg: Leg,
        some: Sequence[Recording],
        options: LegFitOptions,
        stage: Stage,
        scatter: Array,
        every: int,
    ) -> None:
        self.law, self.leg, self.some, self.options, self.scatter = law, leg, some, options, scatter
        self.weights = replace(stage.weights, noise=stage.weights.noise[::every], centre=None)
        solution = stage.solution
        self.begin = FitStart(solution.values, solution.locals[::every])
        rate = np.exp(solution.values[: len(leg.joints)])
        torque, speed = np.max([_torque_and_speed(leg, recording, rate) for recording in some], axis=0)
        self.scale = torque / np.where(speed > 0.0, speed, np.inf) ** law.power
        self.noise = np.where(np.isfinite(self.weights.noise[0]), self.weights.noise[0], np.inf)

    def found(self) -> AnotherLaw | None:
        """The search; None unless its result explains the motion."""
        begun = self._point(np.zeros(len(self.scale)), self.begin)
        if begun is None:
            return None
        here, step, slopes = begun, FIRST * self.scale, None
        floor = self._floor()
        for turn in range(STEPS):
            found = self._slopes(here, step)
            if found is None:
                break
            slopes = found
            side = slopes.residual @ here.size - here.residual
            if turn == 0 and not _promising(slopes.residual, side, floor):
                return None
            wanted = _not_below_zero(slopes.residual, side)
            moved = self._towards(wanted, here)
            if moved is None:
                break
            gain = (here.square - moved.square) / max(here.square - floor, 1e-300)
            here = moved
            step = np.maximum(NEXT * here.size, LEAST_STEP * self.scale)
            if gain < SETTLED:
                break
        if slopes is None:
            return None
        share = (self._error(here) / self._error(begun)) if self._error(begun) > 0.0 else 1.0
        if share > LEAVES or self._gain(begun, here) < LEAST_GAIN:
            return None
        return self._result(here, slopes, share)

    def _point(self, size: Array, start: FitStart) -> _Point | None:
        """All other unknowns with these coefficients; None if the motion diverges."""
        options = self.options
        leg = with_law(self.leg, self.law, size)
        model = model_of(leg, options.curves, prior=options.prior, static=options.static)
        found = solve(model, self.some, start, self.weights, tolerance=NEAR_ENOUGH)
        if not np.isfinite(found.cost):
            return None
        off = [
            np.where(r.counts & np.isfinite(p), (p - r.rotation) / self.noise, 0.0)
            for r, p in zip(self.some, found.predictions, strict=True)
        ]
        return _Point(size, found, np.concatenate([each.ravel() for each in off]))

    def _slopes(self, here: _Point, step: Array) -> _Slopes | None:
        """With each coefficient; None if a motion diverges."""
        residual, values = (np.zeros((len(each), len(step))) for each in (here.residual, here.solution.values))
        for j in np.flatnonzero(step > 0.0):
            moved = self._point(here.size + step[j] * (np.arange(len(step)) == j), here.start)
            if moved is None:
                return None
            residual[:, j] = (moved.residual - here.residual) / step[j]
            values[:, j] = (moved.solution.values - here.solution.values) / step[j]
        return _Slopes(residual, values)

    def _towards(self, wanted: Array, here: _Point) -> _Point | None:
        """The first of ever shorter steps that is better; None if none is."""
        for halving in range(HALVINGS):
            found = self._point(here.size + (wanted - here.size) * 0.5**halving, here.start)
            if found is not None and found.square < here.square:
                return found
        return None

    def _floor(self) -> float:
        """The square that the samples' scatter alone leaves."""
        counted = np.sum([r.counts.sum(axis=0) for r in self.some], axis=0)
        known = np.isfinite(self.scatter) & np.isfinite(self.noise)
        return float(np.sum(counted[known] * (self.scatter[known] / self.noise[known]) ** 2))

    def _error(self, point: _Point) -> float:
        """Mean square above the scatter, rad^2, glitches truncated."""
        return float(np.nansum(clipped_rms(self.some, point.solution.predictions) ** 2 - self.scatter**2))

    def _independent(self, here: _Point) -> float:
        """How many of the samples' residuals count: correlated ones tell less."""
        counted = np.sum([r.counts.sum(axis=0) for r in self.some], axis=0)
        return max(float(np.sum(counted / correlation_times(self.some, here.solution.predictions))), 1.0)

    def _gain(self, begun: _Point, here: _Point) -> float:
        """Twice that of the log-likelihood, with the noise estimated from the residuals."""
        return self._independent(here) * float(np.log(begun.square / here.square))

    def _result(self, here: _Point, slopes: _Slopes, share: float) -> AnotherLaw | None:
        """With the coefficients that are surely above zero; None if there is none."""
        used = np.flatnonzero((slopes.residual != 0.0).any(axis=0) & (here.size > 0.0))
        normal = slopes.residual[:, used].T @ slopes.residual[:, used]
        covariance = np.linalg.pinv(normal) * here.square / self._independent(here)
        deviation = np.zeros(len(here.size))
        deviation[used] = np.sqrt(np.diag(covariance))
        kept = here.size > SURE * deviation
        if not kept.any():
            return None
        size, deviation = np.where(kept, here.size, 0.0), np.where(kept, deviation, 0.0)
        variance, direction = spectrum(covariance[np.ix_(kept[used], kept[used])])
        root = direction * np.sqrt(np.maximum(variance, 0.0))
        leg = with_law(self.leg, self.law, size)
        return AnotherLaw(self.law, leg, size, deviation, slopes.values[:, kept] @ root, share)


@dataclass(frozen=True)
class _Point:
    """Coefficients ``size`` (n,), the ``solution`` with them, and its residuals (m,) over the fit's noise."""

    size: Array
    solution: Solution
    residual: Array

    @property
    def square(self) -> float:
        """Of the residuals."""
        return float(self.residual @ self.residual)

    @property
    def start(self) -> FitStart:
        """Of a neighbouring fit; its sensitivities hold for another leg."""
        return FitStart(self.solution.values, self.solution.locals, self.solution.damping)


@dataclass(frozen=True)
class _Slopes:
    """Change of the residuals (m, n) and of the common unknowns (p, n) per unit of each coefficient."""

    residual: Array
    values: Array


def _promising(columns: Array, side: Array, floor: float) -> bool:
    """Whether a linear step, of any sign, explains enough of the square of ``side`` (m,) above ``floor``."""
    left = side - columns @ np.linalg.lstsq(columns, side)[0]
    return float(left @ left) - floor <= HOPELESS * (float(side @ side) - floor)


def _not_below_zero(columns: Array, side: Array) -> Array:
    """(n,) least squares of ``columns`` (m, n) against ``side`` (m,), none of them negative."""
    from scipy.optimize import nnls  # only here: few fits come so far, and its import takes 0.2 s

    return np.asarray(nnls(columns, side)[0])


def _torque_and_speed(leg: Leg, recording: Recording, rate: Array) -> tuple[Array, Array]:
    """(n,) N m, how much the torques of springs of ``rate`` (n,) and of gravity vary, and (n,) rad/s RMS speed.

    Both are 0 for a locked joint.
    """
    free = np.isin(np.arange(len(rate)), recording.free)
    smoothed, conditions = recording.smoothed, recording.conditions
    terms = coefficients(leg, conditions.tip)
    force = momentum_and_force(terms, smoothed.angle, np.zeros_like(smoothed.rate), leg.tilt + conditions.tilt)[1]
    torque = np.hypot(rate * np.std(smoothed.angle, axis=0), np.std(force, axis=0))
    speed = np.sqrt(np.mean(smoothed.rate**2, axis=0))
    return np.where(free, torque, 0.0), np.where(free, speed, 0.0)


def with_law(leg: Leg, law: SpeedLaw, size: Array) -> Leg:
    """The leg with coefficients (n,) of the law at its joints, none where they are zero."""
    return leg.with_joints(**{
        joint.name: {"effects": {law.effect: {law.key: float(each)}}}
        for joint, each in zip(leg.joints, size, strict=True)
        if each > 0.0
    })  # fmt: skip
