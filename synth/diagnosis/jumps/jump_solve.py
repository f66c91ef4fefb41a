"""Unknowns that fit the trials best: Levenberg and Marquardt, each trial's own unknowns eliminated.

Derivatives are differences between lanes that share every step of the integration. A leaning trial's, but those by what
only a lean shows, are taken upright: the planar form takes a hundred times as long as a lane.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array
from synth.diagnosis.jumps.jump_candidates import JumpCandidate
from synth.diagnosis.jumps.jump_data import Jump
from synth.diagnosis.jumps.jump_predict import N_OWN, JumpPredictor
from synth.threads import in_parallel

STEP = 0.05  # whitened, of differences
ROUNDS, CONVERGED, SHARE = 25, 0.05, 1e-3  # a step that gains less, or less than that share of the cost, is the last
HOPELESS, LAZY = 4.0, 0.05  # times the best hypothesis' cost; the share that a step must gain there
WITHIN = 2.5  # deviations: what lies further off is not within tolerances, however much it would explain
FARTHEST = 2.5  # whitened, that a tolerance or a trial's own unknown may go in a step
SOFTENING = (8.0, 2.5)  # times what samples are uncertain by, in turn, before they count in full
SOFT_ROUNDS = 6


@dataclass(frozen=True, eq=False)
class JumpFit:
    """A hypothesis with its unknowns (tolerances, then each cause's) and each trial's own (n_trial, 2), whitened.

    ``residuals`` a trial (M,), ``slopes`` a trial (M, n_unknown + 2); ``cost`` half the sum of squares, priors in it.
    """

    hypothesis: tuple[JumpCandidate, ...]
    unknowns: Array
    own: Array
    residuals: tuple[Array, ...] = ()
    slopes: tuple[Array, ...] = ()
    cost: float = np.inf

    @property
    def keys(self) -> tuple[tuple[str, str], ...]:
        """Effect and place of each cause."""
        return tuple(candidate.key for candidate in self.hypothesis)


@dataclass(frozen=True, eq=False)
class JumpBench:
    """The trials to learn from; samples count as uncertain by ``softness`` times what they are."""

    predictor: JumpPredictor
    trials: tuple[Jump, ...]
    softness: float = 1.0

    @property
    def n_tolerance(self) -> int:
        """Unknowns of the leg itself."""
        return self.predictor.tolerances.size

    def bounds(self, hypothesis: Sequence[JumpCandidate]) -> tuple[Array, Array]:
        """Least and greatest unknowns."""
        wide = np.full(self.n_tolerance, WITHIN)
        ends = [candidate.bounds() for candidate in hypothesis]
        return np.concatenate([-wide, *(low for low, _ in ends)]), np.concatenate([wide, *(high for _, high in ends)])

    def evaluate(self, fit: JumpFit) -> JumpFit:
        """Residuals, derivatives and cost of the trials."""
        found = in_parallel(lambda i: self.slopes(self.trials[i], fit, fit.own[i]), len(self.trials))
        residuals = tuple(r / self.softness for r, _ in found)
        cost = 0.5 * sum(float(r @ r) for r in residuals)
        cost += 0.5 * float(fit.unknowns @ fit.unknowns) + 0.5 * float(np.sum(fit.own**2))
        return replace(fit, residuals=residuals, slopes=tuple(s / self.softness for _, s in found), cost=cost)

    def slopes(self, jump: Jump, fit: JumpFit, own: Array) -> tuple[Array, Array]:
        """(M,) residual and (M, n_unknown + 2) its derivatives."""
        everything = list(range(len(fit.unknowns) + N_OWN))
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
        """Places of the unknowns of causes that only a lean shows."""
        found: list[int] = []
        first = self.n_tolerance
        for candidate in fit.hypothesis:
            found += range(first, first + candidate.size) if candidate.effect.leaning else ()
            first += candidate.size
        return found

    def _differences(self, jump: Jump, fit: JumpFit, own: Array, moved: list[int]) -> tuple[Array, Array]:
        """Residual and its derivatives by some unknowns, by steps away from the nearer bound."""
        count = len(fit.unknowns)
        x = np.repeat(fit.unknowns[:, None], 1 + len(moved), axis=1)
        mine = np.repeat(own[:, None], 1 + len(moved), axis=1)
        low, high = self.bounds(fit.hypothesis)
        steps = np.full(count + N_OWN, STEP)
        steps[:count] = np.where(high - fit.unknowns > fit.unknowns - low, STEP, -STEP)
        for lane, k in enumerate(moved, start=1):
            if k < count:
                x[k, lane] += steps[k]
            else:
                mine[k - count, lane] += steps[k]
        residual = self.predictor.residual(jump, self.predictor.predict(jump, fit.hypothesis, x, mine))
        return residual[:, 0], (residual[:, 1:] - residual[:, :1]) / steps[moved]

    def left(self, hypothesis: tuple[JumpCandidate, ...], points: Array, base: JumpFit) -> Array:
        """(n_point,) cost that the causes at these points (size, n_point) promise, all else linear about ``base``."""
        x = np.repeat(base.unknowns[:, None], points.shape[1], axis=1)
        x = np.concatenate([x[: self.n_tolerance], points])

        def missed(i: int) -> Array:
            own = np.repeat(base.own[i][:, None], points.shape[1], axis=1)
            return self.predictor.residual(self.trials[i], self.predictor.predict(self.trials[i], hypothesis, x, own))

        residuals = in_parallel(missed, len(self.trials))
        normal = Normal.of(replace(base, residuals=()), self.n_tolerance)
        costs = np.empty(points.shape[1])
        for k in range(points.shape[1]):
            step = normal.step([r[:, k] for r in residuals], base, 0.0)
            squares = sum(
                float(np.sum((r[:, k] + s @ d) ** 2)) for r, s, d in zip(residuals, base.slopes, step, strict=True)
            )
            costs[k] = 0.5 * squares + 0.5 * float(np.sum((base.unknowns + step[0][: len(base.unknowns)]) ** 2))
            costs[k] += 0.5 * float(points[:, k] @ points[:, k])
        return costs

    def solve_softly(self, fit: JumpFit, best: float = np.inf) -> JumpFit:
        """First with samples that count little, so that causes and not far-off tolerances explain what is gross.

        A push ends at a stop: a few milliseconds off, every sample after is, and the way to the best fit is narrow.
        ``best`` : as for ``solve``.
        """
        if any(candidate.effect.leaning for candidate in fit.hypothesis):
            return self.solve(replace(fit, residuals=()), best=best)  # it begins where the design fits best
        quick = [i for i, trial in enumerate(self.trials) if not trial.leaning] or list(range(len(self.trials)))
        trials = tuple(self.trials[i] for i in quick)
        current = replace(fit, own=fit.own[quick])
        for softness in SOFTENING:
            bench = replace(self, softness=softness, trials=trials)
            current = bench.solve(replace(current, residuals=()), SOFT_ROUNDS)
        own = fit.own.copy()
        own[quick] = current.own
        return self.solve(replace(current, own=own, residuals=()), best=best)

    def solve(self, fit: JumpFit, rounds: int = ROUNDS, best: float = np.inf) -> JumpFit:
        """The fit gone on with until it gains no more.

        ``best`` : cost of another hypothesis; one far above it need not be brought to its last decimal.
        """
        current = fit if fit.residuals else self.evaluate(fit)
        low, high = self.bounds(fit.hypothesis)
        damping = 1e-3
        for _ in range(rounds):
            normal = Normal.of(current, len(current.unknowns))
            step = self._shortened(normal.step(current.residuals, current, damping, (low, high)))
            count = len(current.unknowns)
            tried = self.evaluate(
                replace(
                    current,
                    unknowns=np.clip(current.unknowns + step[0][:count], low, high),
                    own=current.own + np.array([s[count:] for s in step]),
                )
            )
            gain = current.cost - tried.cost
            if gain > 0.0:
                current, damping = tried, max(damping / 10.0, 1e-7)
                hopeless = current.cost > HOPELESS * best
                if gain < max(CONVERGED, (LAZY if hopeless else SHARE) * current.cost):
                    break
            else:
                damping = max(10.0 * damping, 1e-2)
                if damping > 1e6:
                    break
        return current

    def _shortened(self, step: list[Array]) -> list[Array]:
        """The steps, all alike shorter where one goes too far."""
        p, largest = self.n_tolerance, 0.0
        for one in step:
            largest = max(largest, float(np.abs(one[:p]).max()), float(np.abs(one[-N_OWN:]).max()))
        share = min(1.0, FARTHEST / max(largest, 1e-12))
        return [share * one for one in step]


@dataclass(frozen=True, eq=False)
class Normal:
    """Normal equations: ``matrix`` (n, n) with each trial's own unknowns eliminated, and the parts that they need."""

    matrix: Array
    parts: tuple[tuple[Array, Array, Array], ...]  # a trial: (n, n), (n, 2), (2, 2) of its squares

    @classmethod
    def of(cls, fit: JumpFit, count: int) -> Normal:
        """From a fit's derivatives, those of the first ``count`` unknowns and of each trial's own."""
        parts, matrix = [], np.eye(count)
        for slopes in fit.slopes:
            a, b = slopes[:, :count], slopes[:, slopes.shape[1] - N_OWN :]
            part = (a.T @ a, a.T @ b, b.T @ b + np.eye(N_OWN))
            matrix += part[0] - part[1] @ np.linalg.solve(part[2], part[1].T)
            parts.append(part)
        return cls(matrix, tuple(parts))

    def gradients(self, residuals: Sequence[Array], fit: JumpFit) -> list[tuple[Array, Array]]:
        """A trial: reduced gradient (n,) of its part, and that of its own unknowns (2,)."""
        count = len(self.matrix)
        found = []
        for residual, slopes, own, (_, b, c) in zip(residuals, fit.slopes, fit.own, self.parts, strict=True):
            mine = slopes[:, slopes.shape[1] - N_OWN :].T @ residual + own
            found.append((slopes[:, :count].T @ residual - b @ np.linalg.solve(c, mine), mine))
        return found

    def step(
        self, residuals: Sequence[Array], fit: JumpFit, damping: float, bounds: tuple[Array, Array] | None = None
    ) -> list[Array]:
        """A trial: the step (n + 2,) of all unknowns and its own; what would leave the bounds stays on them."""
        count = len(self.matrix)
        gradients = self.gradients(residuals, fit)
        total = sum((g for g, _ in gradients), fit.unknowns[:count].copy())
        matrix = self.matrix + damping * np.diag(np.diag(self.matrix))
        shared = -np.linalg.solve(matrix, total)
        if bounds is not None:
            there = fit.unknowns[:count]
            held = np.zeros(count, dtype=bool)
            for _ in range(3):
                reached = there + shared
                held |= (reached < bounds[0]) & (there <= bounds[0]) | (reached > bounds[1]) & (there >= bounds[1])
                free = ~held
                shared = np.zeros(count)
                shared[free] = -np.linalg.solve(matrix[np.ix_(free, free)], total[free])
        return [
            np.concatenate([shared, -np.linalg.solve(c + damping * np.diag(np.diag(c)), mine + b.T @ shared)])
            for (_, mine), (_, b, c) in zip(gradients, self.parts, strict=True)
        ]

    def without(self, index: int, fit: JumpFit) -> Array:
        """(n,) how the unknowns move when one trial takes no part, to first order."""
        a, b, c = self.parts[index]
        gradients = self.gradients(fit.residuals, fit)
        matrix = self.matrix - (a - b @ np.linalg.solve(c, b.T))
        total = sum((g for k, (g, _) in enumerate(gradients) if k != index), fit.unknowns.copy())
        return np.asarray(-np.linalg.solve(matrix, total))
