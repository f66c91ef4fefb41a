"""A law's coefficients by Gauss-Newton steps in which all other unknowns follow.

Variable projection (Golub & Pereyra, Inverse Problems 19 (2003) R1), those of speed never below zero (Lawson &
Hanson, Solving Least Squares Problems, 1974, ch. 23). The first step is taken by refits, later ones by sensitivities
(``following``). Where a joint sticks the square has breaks, so that a polish by single steps ends the search.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array, Mask
from synth.errors import UserError
from synth.estimation.intervals import spectrum
from synth.fit.diverged_fit import divergence_refused
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_problem import model_of, unknowns_of
from synth.fit.following import follow_changes
from synth.fit.joint_laws import AnotherLaw, JointLaw, with_law
from synth.fit.least_squares import FitStart, Solution, Stage, solve
from synth.fit.link_errors import link_errors, link_widths
from synth.fit.model_error import ModelError
from synth.fit.recordings import Recording
from synth.fit.refinement import refine
from synth.fit.trajectories import Index, Local, TrajectoryModel
from synth.fit.uncertainty import clipped_rms, correlation_times
from synth.swing.leg_model import Leg
from synth.swing.mechanics import coefficients, momentum_and_force

# Of the squared error above the samples' scatter, what the first linear step leaves at which no further one is taken.
HOPELESS_RESIDUE = 0.85
FIRST_STEP = 0.03  # of the torque of springs and gravity, the first step of a law's torque at the joint's RMS speed
LEAST_STEP = 0.001  # as ``FIRST_STEP``, of a coefficient that is nearly zero
LATER_STEP = 0.03  # of the coefficient, later ones
# Of the torque of springs and gravity, standard deviation of a law's torque before the trials: while a joint turns one
# way, friction looks like another free angle, and the trials alone allow any size of it.
EXPECTED_TORQUE = 0.5
STEPS = 6
FIT_TOLERANCE = 0.01  # of the log-likelihood, of the other unknowns' fits
# Twice the gain of the log-likelihood by a law, correlated samples counted once: more than chance gives four joints.
LEAST_GAIN = 30.0
# The same of a law that is found beside a hand: a coefficient is so far from zero by chance with p = 1e-4, at which the
# test of the first samples believes in a hand.
GAIN_BESIDE_HAND = 15.0
SETTLED_GAIN = 0.05  # of the error above the scatter, gain of a step that is the last
NEAR_FLOOR = 0.1  # of the scatter's own error: nearer to it, gains count against this
HALVINGS = 4
PARTS, MOVES = (0.01, 0.003, 0.001), 3  # of a coefficient, steps of the last polish, and how many of each in turn
EXPLAINED_SQUARE = 1.05  # of the scatter's square, below which no better end is sought
SURE_DEVIATIONS = 2.0  # standard deviations from zero, of one coefficient at least


class LawSearch:
    """Gauss-Newton steps of a law's coefficients on some of the trials."""

    def __init__(
        self,
        law: JointLaw,
        leg: Leg,
        some: Sequence[Recording],
        options: LegFitOptions,
        stage: Stage,
        scatter: Array,
    ) -> None:
        self.law, self.leg, self.some, self.options, self.scatter = law, leg, some, options, scatter
        self.weights, solution = stage.weights, stage.solution
        self.begin = FitStart(solution.values, solution.locals)
        fitted = unknowns_of(self._model(np.zeros(len(leg.joints)))).fitted_leg(solution.values)
        torque, speed, deflection = np.max([_torque_and_motion(fitted, recording) for recording in some], axis=0)
        motion = deflection if law.of_deflection else speed
        self.scale = torque / np.where(motion > 0.0, motion, np.inf) ** law.power
        self.noise = np.where(np.isfinite(self.weights.noise), self.weights.noise, np.inf)
        counted = sum(int(recording.counts.sum()) for recording in some)
        # In units of the residuals, as another sample of the scatter.
        self.expected = np.sqrt(self._floor() / counted) / (EXPECTED_TORQUE * np.maximum(self.scale, 1e-300))

    def point(self, size: Array) -> LawPoint | None:
        """With these coefficients, from the stage; None if the motion diverges."""
        return self._point(size, self.begin)

    def descend(self, begun: LawPoint, *, first: bool = False) -> LawPoint | None:
        """The end of the steps from ``begun``; None if the ``first``, from no law at all, promises nothing."""
        here, step = begun, FIRST_STEP * self.scale if first else self._next_step(begun)
        floor = self._floor()
        for turn in range(STEPS):
            slopes = self._slopes(here, step) if turn else self._secants(here, step)
            if slopes is None:
                break
            side = slopes.residual @ here.size - here.residual
            if first and not turn and not _promises_gain(slopes.residual, side, floor):
                return None
            pull = np.diag(self.expected)
            columns, sides = np.vstack([slopes.residual, pull]), np.concatenate([side, np.zeros(len(pull))])
            wanted = np.linalg.lstsq(columns, sides)[0] if self.law.of_deflection else _not_below_zero(columns, sides)
            moved = self._towards(wanted, here, slopes) if (wanted != here.size).any() else None
            if moved is None:
                break
            gain = (here.square - moved.square) / max(here.square - floor, NEAR_FLOOR * floor)
            here = moved
            step = self._next_step(here)
            if gain < SETTLED_GAIN:
                break
        return here

    def polish(self, here: LawPoint) -> LawPoint:
        """The best of steps of one coefficient at a time, ever shorter: where a joint sticks the slopes break off."""
        for part in PARTS:
            for j in np.flatnonzero(here.size):
                for step in (part * here.size[j], -part * here.size[j]):
                    moved = self._step_coefficient(here, int(j), float(step))
                    for _ in range(MOVES):
                        if moved is None:
                            break
                        here = moved
                        moved = self._step_coefficient(here, int(j), float(step))
        return here

    def explained(self, here: LawPoint) -> bool:
        """Whether little more than the samples' scatter is left."""
        return bool(here.square < EXPLAINED_SQUARE * self._floor())

    def _step_coefficient(self, here: LawPoint, j: int, step: float) -> LawPoint | None:
        """One coefficient moved, if that is better."""
        size = here.size + step * (np.arange(len(here.size)) == j)
        found = self._point(size, FitStart(here.solution.values, here.solution.locals, here.solution.damping))
        better = found is not None and self._objective(found) < self._objective(here) - FIT_TOLERANCE
        return found if better else None

    def law_at(self, here: LawPoint, linear: LawPoint) -> AnotherLaw | None:
        """The law at ``here``; None if it hardly explains any of what ``linear``, without it, leaves."""
        share, gain = self.share(here, linear), self._gain(linear, here)
        if not here.size.any() or gain < GAIN_BESIDE_HAND:
            return None
        found = self._result(here, share)
        return found if found is None else replace(found, named=share <= self.law.residue and gain >= LEAST_GAIN)

    def share(self, here: LawPoint, linear: LawPoint) -> float:
        """Share that ``here`` leaves of the error above the scatter that ``linear`` leaves."""
        before = self._error(linear)
        return self._error(here) / before if before > 0.0 else 1.0

    def at(self, stage: Stage) -> LawSearch:
        """The same search from another stage, with its noise."""
        return LawSearch(self.law, self.leg, self.some, self.options, stage, self.scatter)

    def refit_at(self, here: LawPoint) -> Stage:
        """The other unknowns, with the noise that they leave."""
        start, weights = FitStart.at(here.solution), self.weights
        model = self._model(here.size)
        return refine(model, self.some, start, self.options.weight, weights.spread, points=weights.points)

    def _next_step(self, here: LawPoint) -> Array:
        return np.asarray(np.maximum(LATER_STEP * np.abs(here.size), LEAST_STEP * self.scale))

    def _model(self, size: Array) -> TrajectoryModel:
        """The model of the leg with these coefficients."""
        options = self.options
        leg = with_law(self.leg, self.law, size)
        return model_of(leg, options.curves, recordings=self.some, prior=options.prior, static=options.static)

    def _point(self, size: Array, start: FitStart) -> LawPoint | None:
        """All other unknowns with these coefficients; None if the motion diverges."""
        found = solve(self._model(size), self.some, start, self.weights, tolerance=FIT_TOLERANCE)
        if not np.isfinite(found.cost):
            return None
        return LawPoint(size, found, self._residual(found))

    def _residual(self, solution: Solution) -> Array:
        """(m,) over the noise."""
        off = [
            np.where(np.isfinite(prediction), prediction - recording.rotation, 0.0)
            for recording, prediction in zip(self.some, solution.predictions, strict=True)
        ]
        return self._over_noise(off)

    def _over_noise(self, changes: Sequence[Array]) -> Array:
        """(m,) or (m, c), trials' (k, n) or (k, n, c) rad over their noise, 0 where no sample counts, in one."""
        trailing = (1,) * (changes[0].ndim - 2)
        scaled = [
            each * (recording.counts / noise).reshape(*recording.counts.shape, *trailing)
            for recording, noise, each in zip(self.some, self.noise, changes, strict=True)
        ]
        return np.concatenate([each.reshape(-1, *each.shape[2:]) for each in scaled])

    def _secants(self, here: LawPoint, step: Array) -> _Slopes | None:
        """As ``_slopes``, by refits: where friction sets in, and along a ridge, linear steps are far too short."""
        wide = [np.zeros((len(each), len(step))) for each in (here.residual, here.solution.values)]
        start = FitStart(here.solution.values, here.solution.locals, here.solution.damping)
        for j in np.flatnonzero(step > 0.0):
            moved = self._point(here.size + step[j] * (np.arange(len(step)) == j), start)
            if moved is None:
                return None
            wide[0][:, j] = (moved.residual - here.residual) / step[j]
            wide[1][:, j] = (moved.solution.values - here.solution.values) / step[j]
        own = tuple(np.zeros((len(information), len(step))) for information in here.solution.information.own)
        return _Slopes(wide[0], wide[1], own)

    def _slopes(self, here: LawPoint, step: Array) -> _Slopes | None:
        """With each coefficient while all other unknowns follow; None if a motion diverges."""
        model, open_, solution = self._model(here.size), np.flatnonzero(step > 0.0), here.solution
        models = [model, *(self._model(size) for size in here.size + step * np.eye(len(step))[open_])]

        def change(t: int) -> Array:
            return _prediction_change(models, self.some[t], solution.values, solution.locals[t]) / step[open_]

        try:
            found = follow_changes(model, self.some, Stage(solution, self.weights), change, _all_samples)
        except UserError:  # a neighbouring motion diverges
            return None
        residual = self._over_noise(found.left)
        if not np.isfinite(residual).all():
            return None
        wide = (residual, found.considered.sensitivity, *found.own)
        columns, values, *own = (_in_columns(each, open_, len(step)) for each in wide)
        return _Slopes(columns, values, tuple(own))

    def _towards(self, wanted: Array, here: LawPoint, slopes: _Slopes) -> LawPoint | None:
        """The first of ever shorter steps that is better; None if none is."""
        for halving in range(HALVINGS):
            step = (wanted - here.size) * 0.5**halving
            found = self._point(here.size + step, self._start(here, slopes, step))
            if found is not None and self._objective(found) < self._objective(here):
                return found
        return None

    def _start(self, here: LawPoint, slopes: _Slopes, step: Array) -> FitStart:
        """After a step of the coefficients, as all other unknowns follow."""
        model = self._model(here.size)
        locals_ = [
            model.step_local(recording, local, own @ step)
            for recording, local, own in zip(self.some, here.solution.locals, slopes.own, strict=True)
        ]
        values = np.clip(here.solution.values + slopes.values @ step, model.unknowns.lower, model.unknowns.upper)
        return FitStart(values, locals_, here.solution.damping)

    def _objective(self, point: LawPoint) -> float:
        """The square of the residuals, and of the coefficients over what is expected of them."""
        return point.square + float(np.sum((self.expected * point.size) ** 2))

    def _floor(self) -> float:
        """The square that the samples' scatter alone leaves."""
        squares = self._counted() * (self.scatter / self.noise) ** 2
        return float(squares[np.isfinite(squares)].sum())

    def _error(self, point: LawPoint) -> float:
        """Mean square above the scatter, rad^2, glitches truncated."""
        return float(np.nansum(clipped_rms(self.some, point.solution.predictions) ** 2 - self.scatter**2))

    def _independent(self, here: LawPoint) -> float:
        """How many of the samples' residuals count: correlated ones tell less."""
        factors = correlation_times(self.some, here.solution.predictions)
        return max(float(np.sum(self._counted() / factors)), 1.0)

    def _counted(self) -> Array:
        """(n_trial, n) samples that count."""
        return np.array([recording.counts.sum(axis=0) for recording in self.some], dtype=float)

    def _gain(self, linear: LawPoint, here: LawPoint) -> float:
        """Twice that of the log-likelihood, with the noise estimated from the residuals."""
        before = self._residual(linear.solution)
        return self._independent(here) * float(np.log(before @ before / here.square))

    def _result(self, here: LawPoint, share: float) -> AnotherLaw | None:
        """With the errors of all coefficients; None if none of them is surely other than zero."""
        slopes = self._slopes(here, self._next_step(here))
        if slopes is None:
            return None
        used = np.flatnonzero((slopes.residual != 0.0).any(axis=0))
        columns, moved = slopes.residual[:, used], slopes.values[:, used]
        normal = columns.T @ columns + np.diag(self.expected[used] ** 2)
        covariance = np.asarray(np.linalg.pinv(normal) * here.square / self._independent(here))
        if not np.any(np.abs(here.size[used]) > SURE_DEVIATIONS * np.sqrt(np.diag(covariance))):
            return None
        with divergence_refused():
            variance, direction = spectrum(covariance)
        by_links = self._by_links(here, columns, normal)
        deviation = np.zeros(len(here.size))
        deviation[used] = np.sqrt(np.diag(covariance) + np.sum(by_links**2, axis=1))
        leg = with_law(self.leg, self.law, here.size)
        error = ModelError(moved @ (direction * np.sqrt(np.maximum(variance, 0.0))), "", moved @ by_links)
        rms = clipped_rms(self.some, here.solution.predictions)
        return AnotherLaw(self.law, leg, here.size, deviation, error, share, here.solution.values, rms)

    def _by_links(self, here: LawPoint, columns: Array, normal: Array) -> Array:
        """(n, c) change of coefficients per deviation of each of the links' parameters, all other unknowns following.

        ``columns`` (m, n) of their residuals, ``normal`` (n, n) their products.
        """
        model, stage = self._model(here.size), Stage(here.solution, self.weights)
        widths = link_widths(self.leg, self.options.tolerance, self.some)
        found = link_errors(model, self.some, stage, widths, self.options.static, until=np.inf)
        if found is None:
            return np.zeros((columns.shape[1], 0))
        return np.asarray(-np.linalg.pinv(normal) @ (columns.T @ self._over_noise(found.first)))


@dataclass(frozen=True)
class LawPoint:
    """Coefficients ``size`` (n,), the ``solution`` with them, and its residuals (m,) over the fit's noise."""

    size: Array
    solution: Solution
    residual: Array

    @property
    def square(self) -> float:
        """Sum of the squared residuals."""
        return float(self.residual @ self.residual)


@dataclass(frozen=True)
class _Slopes:
    """Change of residuals (m, n), common unknowns (p, n), and each trial's own (l, n), per unit of each coefficient."""

    residual: Array
    values: Array
    own: tuple[Array, ...]


def _prediction_change(models: Sequence[TrajectoryModel], recording: Recording, values: Array, local: Local) -> Array:
    """(k, n, c) rad, of the prediction by each model against the first one's, all unknowns alike."""
    count = len(models)
    lanes = np.stack([each.chain.parameters(each.leg, recording.conditions) for each in models], axis=1)
    state = np.repeat(np.concatenate([local.rotation, local.rate])[:, None], count, axis=1)
    out = models[0].run_lanes(recording, lanes, np.repeat(values[:, None], count, axis=1), state, local.shift[:, None])
    return np.asarray(out[:, :, 1:] - out[:, :, :1])


def _all_samples(recording: Recording) -> Mask:
    """(m,) all of them."""
    return np.ones(len(recording.time), dtype=bool)


def _in_columns(found: Array, open_: Index, count: int) -> Array:
    """(m, count), zero for those that are not open."""
    all_ = np.zeros((len(found), count))
    all_[:, open_] = found
    return all_


def _promises_gain(columns: Array, side: Array, floor: float) -> bool:
    """Whether a linear step, of any sign, explains enough of the square of ``side`` (m,) above ``floor``."""
    left = side - columns @ np.linalg.lstsq(columns, side)[0]
    return float(left @ left) - floor <= HOPELESS_RESIDUE * (float(side @ side) - floor)


def _not_below_zero(columns: Array, side: Array) -> Array:
    """(n,) least squares of ``columns`` (m, n) against ``side`` (m,), none of them negative."""
    from scipy.optimize import nnls  # only here: few fits come so far, and its import takes 0.2 s

    return np.asarray(nnls(columns, side)[0])


def _torque_and_motion(leg: Leg, recording: Recording) -> tuple[Array, Array, Array]:
    """(n,) N m, how much torques of springs and gravity vary; rad/s RMS speed; rad RMS deflection of the springs.

    All are 0 for a locked joint.
    """
    rate, free = leg.spring_rate, np.isin(np.arange(len(leg.joints)), recording.free)
    smoothed, conditions = recording.smoothed, recording.conditions
    terms = coefficients(leg, conditions.tip)
    force = momentum_and_force(terms, smoothed.angle, np.zeros_like(smoothed.rate), leg.tilt + conditions.tilt)[1]
    torque = np.hypot(rate * np.std(smoothed.angle, axis=0), np.std(force, axis=0))
    speed = np.sqrt(np.mean(smoothed.rate**2, axis=0))
    deflection = np.sqrt(np.mean((smoothed.angle - leg.rest) ** 2, axis=0))
    return np.where(free, torque, 0.0), np.where(free, speed, 0.0), np.where(free, deflection, 0.0)
