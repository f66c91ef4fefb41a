"""Hypotheses fitted to jumps, by ``synth.estimation``; each trial's own unknowns are eliminated.

Derivatives are differences between lanes that share every step of the integration. For a leaning trial, those by
unknowns that only a lean shows are computed with the planar form, all others with an upright jump: the planar form
takes a hundred times as long as a lane.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array
from synth.diagnosis.effect_shape import shape_places
from synth.diagnosis.plants.jumping_leg.jump_candidates import JumpCandidate
from synth.diagnosis.plants.jumping_leg.jump_data import Jump
from synth.diagnosis.plants.jumping_leg.jump_predict import N_TRIAL_UNKNOWN, JumpPredictor
from synth.diagnosis.search_limits import LARGEST_TOLERANCE
from synth.estimation.levenberg_marquardt import Iterate, LeastSquares, Marquardt, minimise
from synth.estimation.normal_equations import ParameterStep, ReducedNormal, StepLimits, TrialNormal
from synth.estimation.tailed_prior import tailed_cost, tailed_weight
from synth.threads import in_parallel

UNKNOWN_STEP = 0.05  # whitened, step of the differences
# Most iterations; the last step gains less than CONVERGED_BY, or than SHARE of the cost.
MOST_ITERATIONS, CONVERGED_GAIN, CONVERGED_SHARE = 25, 0.05, 1e-3
# Times the best hypothesis' cost; the share of the cost that a step must gain above that.
HOPELESS_RATIO, LEAST_SHARE_IF_HOPELESS = 4.0, 0.05
LARGEST_STEP = 2.5  # whitened, largest step of a tolerance or a trial's own unknown
SOFTNESS_STAGES = (8.0, 2.5)  # factors on the samples' uncertainty in successive fits, before they count fully
SOFT_ITERATIONS = 6  # iterations, see ``solve``
# As Marquardt's: a tenth after a success, tenfold after a failure; above 1e6 no step lowers the cost.
DAMPING_RULE = Marquardt(least=1e-7, most=1e6, down=10.0, up=10.0, least_after_failure=1e-2)


@dataclass(frozen=True, eq=False)
class JumpFit:
    """A hypothesis with its unknowns (tolerances, then each cause's) and each trial's own (n_trial, 2), whitened.

    ``residuals`` (M,) per trial, ``slopes`` (M, n_unknown + 2) per trial; ``cost`` half the sum of squares, with
    priors.

    What was computed holds at this point only: elsewhere, or with other causes, it starts by ``start_at``.
    """

    hypothesis: tuple[JumpCandidate, ...]
    unknowns: Array
    own: Array
    residuals: tuple[Array, ...] = ()
    slopes: tuple[Array, ...] = ()
    cost: float = np.inf

    def start_at(self, *, unknowns: Array | None = None, own: Array | None = None) -> JumpFit:
        """A start elsewhere, not evaluated: what is not given stays, and nothing that was computed here."""
        return JumpFit(
            self.hypothesis,
            self.unknowns if unknowns is None else unknowns,
            self.own if own is None else own,
        )

    def at(self, unknowns: Array) -> JumpFit:
        """The hypothesis with other unknowns, for predictions."""
        return self.start_at(unknowns=unknowns)

    @property
    def keys(self) -> tuple[tuple[str, str], ...]:
        """Effect and place of each cause."""
        return tuple(candidate.key for candidate in self.hypothesis)

    @property
    def shapes(self) -> Array:
        """(n, 2), see ``hypotheses.FittedHypothesis``; without derivatives fully determined."""
        first = len(self.unknowns) - sum(cause.size for cause in self.hypothesis)
        places = [first + place for place in shape_places(self.hypothesis)]
        changes = sum((np.sum(slopes[:, places] ** 2, axis=0) for slopes in self.slopes), np.zeros(len(places)))
        squares = sum(float(residual @ residual) for residual in self.residuals)
        determined = changes / squares if self.slopes else np.full(len(places), np.inf)
        return np.column_stack([self.unknowns[places], determined])


@dataclass(frozen=True, eq=False)
class JumpBench:
    """The training trials; the uncertainty of the samples is multiplied by ``softness``."""

    predictor: JumpPredictor
    trials: tuple[Jump, ...]
    softness: float = 1.0

    @property
    def n_tolerance(self) -> int:
        """Number of the leg's own unknowns."""
        return self.predictor.tolerances.size

    def bounds(self, hypothesis: Sequence[JumpCandidate]) -> tuple[Array, Array]:
        """Bounds of the unknowns."""
        wide = np.full(self.n_tolerance, LARGEST_TOLERANCE)
        ends = [candidate.bounds() for candidate in hypothesis]
        return np.concatenate([-wide, *(low for low, _ in ends)]), np.concatenate([wide, *(high for _, high in ends)])

    def evaluate(self, fit: JumpFit) -> JumpFit:
        """Residuals, derivatives and cost of the trials."""
        found = in_parallel(lambda i: self.slopes(self.trials[i], fit, fit.own[i]), len(self.trials))
        residuals = tuple(r / self.softness for r, _ in found)
        cost = 0.5 * sum(float(r @ r) for r in residuals)
        cost += self.prior_cost(fit.unknowns) + 0.5 * float(np.sum(fit.own**2))
        return replace(fit, residuals=residuals, slopes=tuple(s / self.softness for _, s in found), cost=cost)

    def prior_cost(self, unknowns: Array) -> float:
        """Of the unknowns (p,): tolerances are normal, a cause's strength may be far larger than usual."""
        tolerances = unknowns[: self.n_tolerance]
        return 0.5 * float(tolerances @ tolerances) + float(tailed_cost(unknowns[self.n_tolerance :]))

    def remainder(self, fit: JumpFit) -> float:
        """RMS of an evaluated fit's residuals over the samples' uncertainty; at least 1."""
        squares = sum(float(residual @ residual) for residual in fit.residuals)
        counted = sum(jump.weight * len(residual) for jump, residual in zip(self.trials, fit.residuals, strict=True))
        return max(float(np.sqrt(squares / counted)), 1.0)

    def slopes(self, jump: Jump, fit: JumpFit, own: Array) -> tuple[Array, Array]:
        """(M,) residual and (M, n_unknown + 2) derivatives."""
        everything = list(range(len(fit.unknowns) + N_TRIAL_UNKNOWN))
        if not jump.leaning:
            return self._differences(jump, fit, own, everything)
        slid = self._leaning_unknowns(fit)
        residual, by_slide = self._differences(jump, fit, own, slid)
        rest = [k for k in everything if k not in slid]
        upright = jump.upright()
        _, by_rest = self._differences(upright, fit, own, rest)
        found = np.zeros((len(residual), len(everything)))
        found[:, slid] = by_slide
        size = len(jump.time)
        for place, name in enumerate(jump.measured):
            if name in upright.measured:
                first = list(upright.measured).index(name) * size
                found[place * size : (place + 1) * size, rest] = by_rest[first : first + size]
        return residual, found

    def _leaning_unknowns(self, fit: JumpFit) -> list[int]:
        """Indices of the unknowns of causes that only a lean shows."""
        found: list[int] = []
        first = self.n_tolerance
        for candidate in fit.hypothesis:
            found += range(first, first + candidate.size) if candidate.effect.leaning else ()
            first += candidate.size
        return found

    def _differences(self, jump: Jump, fit: JumpFit, own: Array, moved: list[int]) -> tuple[Array, Array]:
        """Residual and derivatives by some unknowns, by differences away from the nearer bound."""
        count = len(fit.unknowns)
        x = np.repeat(fit.unknowns[:, None], 1 + len(moved), axis=1)
        mine = np.repeat(own[:, None], 1 + len(moved), axis=1)
        low, high = self.bounds(fit.hypothesis)
        steps = np.full(count + N_TRIAL_UNKNOWN, UNKNOWN_STEP)
        steps[:count] = np.where(high - fit.unknowns > fit.unknowns - low, UNKNOWN_STEP, -UNKNOWN_STEP)
        for lane, k in enumerate(moved, start=1):
            if k < count:
                x[k, lane] += steps[k]
            else:
                mine[k - count, lane] += steps[k]
        residual = self.predictor.residual(jump, self.predictor.predict(jump, fit.hypothesis, x, mine))
        return residual[:, 0], (residual[:, 1:] - residual[:, :1]) / steps[moved]

    def normal(self, fit: JumpFit, count: int | None = None) -> ReducedNormal:
        """Normal equations of an evaluated fit, by its first ``count`` unknowns (default: all) and each trial's own."""
        return self.normal_at(fit, fit.residuals, len(fit.unknowns) if count is None else count)

    def normal_at(self, fit: JumpFit, residuals: Sequence[Array], count: int) -> ReducedNormal:
        """Like ``normal``, with the derivatives of a fit and other residuals (M,) per trial."""
        trials = []
        for slopes, residual, own in zip(fit.slopes, residuals, fit.own, strict=True):
            a, b = slopes[:, :count], slopes[:, slopes.shape[1] - N_TRIAL_UNKNOWN :]
            trials.append(
                TrialNormal(a.T @ a, a.T @ b, b.T @ b + np.eye(N_TRIAL_UNKNOWN), a.T @ residual, b.T @ residual + own)
            )
        prior = np.concatenate([np.ones(self.n_tolerance), tailed_weight(fit.unknowns[self.n_tolerance :])])[:count]
        return ReducedNormal.of(trials, np.diag(prior), prior * fit.unknowns[:count])

    def prospects(self, hypothesis: tuple[JumpCandidate, ...], points: Array, base: JumpFit) -> Array:
        """(n_point,) cost with the causes at these points (size, n_point) after one undamped step of all other
        unknowns.

        The derivatives by the other unknowns are those of ``base``.
        """
        x = np.repeat(base.unknowns[:, None], points.shape[1], axis=1)
        x = np.concatenate([x[: self.n_tolerance], points])

        def missed(i: int) -> Array:
            own = np.repeat(base.own[i][:, None], points.shape[1], axis=1)
            return self.predictor.residual(self.trials[i], self.predictor.predict(self.trials[i], hypothesis, x, own))

        residuals = in_parallel(missed, len(self.trials))
        free = (np.full(self.n_tolerance, -np.inf), np.full(self.n_tolerance, np.inf))
        costs = np.empty(points.shape[1])
        for k in range(points.shape[1]):
            here = [r[:, k] for r in residuals]
            normal = self.normal_at(base, here, self.n_tolerance)
            (step,) = normal.steps(base.unknowns, np.zeros(1), normal.scale, free, StepLimits())
            moves = [np.concatenate([step.common, own]) for own in step.own]
            left = [r + s @ d for r, s, d in zip(here, base.slopes, moves, strict=True)]
            costs[k] = 0.5 * sum(float(r @ r) for r in left) + float(tailed_cost(points[:, k]))
            costs[k] += 0.5 * float(np.sum((base.unknowns + step.common) ** 2))
            costs[k] += 0.5 * float(np.sum((base.own + np.array(step.own)) ** 2))
        return costs

    def solve_softly(self, fit: JumpFit, best: float = np.inf) -> JumpFit:
        """Start with a low weight of the samples, so that causes rather than extreme tolerances explain large
        residuals.

        A push ends at a stop: an error of a few milliseconds shifts all later samples, and the minimum is narrow.
        ``best`` : as for ``solve``.
        """
        if any(candidate.effect.leaning for candidate in fit.hypothesis):
            return self.solve(fit, best=best)  # starts from the design's best fit
        quick = [i for i, trial in enumerate(self.trials) if not trial.leaning] or list(range(len(self.trials)))
        trials = tuple(self.trials[i] for i in quick)
        current = fit.start_at(own=fit.own[quick])
        for softness in SOFTNESS_STAGES:
            bench = replace(self, softness=softness, trials=trials)
            current = bench.solve(current, SOFT_ITERATIONS)
        own = fit.own.copy()
        own[quick] = current.own
        return self.solve(current.start_at(own=own), best=best)

    def solve(self, fit: JumpFit, rounds: int = MOST_ITERATIONS, best: float = np.inf) -> JumpFit:
        """Iterate from a fit's point, whatever was computed there, until the cost no longer decreases.

        ``best`` : cost of another hypothesis; a fit far above it need not converge fully.
        """
        (end,) = minimise(_Hypothesis(self, best), [Iterate(self.evaluate(fit))], DAMPING_RULE, rounds)
        return end.point


@dataclass(frozen=True)
class _Hypothesis(LeastSquares[JumpFit]):
    """A hypothesis as a least-squares problem; ``best`` : lowest cost so far."""

    bench: JumpBench
    best: float

    def evaluate(self, points: Sequence[JumpFit]) -> list[JumpFit]:
        """Residuals, derivatives and costs."""
        return [self.bench.evaluate(point) for point in points]

    def normal(self, point: JumpFit) -> ReducedNormal:
        """Normal equations of all unknowns at a point."""
        return self.bench.normal(point)

    def bounds(self, point: JumpFit) -> tuple[Array, Array]:
        """Lowest and highest tolerances and causes' unknowns, (p,) each, whitened."""
        return self.bench.bounds(point.hypothesis)

    def limits(self, point: JumpFit) -> StepLimits:
        """Tolerances and a trial's own unknowns move by ``LARGEST_STEP`` at most; causes have their bounds."""
        p = self.bench.n_tolerance
        return StepLimits(np.r_[np.full(p, LARGEST_STEP), np.full(len(point.unknowns) - p, np.inf)], LARGEST_STEP)

    def moved(self, point: JumpFit, step: ParameterStep) -> JumpFit:
        """After a step, not evaluated."""
        own = point.own + np.array(step.own)
        return point.start_at(unknowns=point.unknowns + step.common, own=own)

    def least_gain(self, cost: float) -> float:
        """A share of the cost, larger far above the best: such a fit need not converge fully."""
        return max(
            CONVERGED_GAIN, (LEAST_SHARE_IF_HOPELESS if cost > HOPELESS_RATIO * self.best else CONVERGED_SHARE) * cost
        )
