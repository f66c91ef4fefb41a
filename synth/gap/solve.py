"""Many hypotheses fitted side by side: each within the tolerances, each trial's initial state estimated with it.

Levenberg-Marquardt in whitened unknowns, where the prior is the unit normal. A hypothesis changes a leg's motion by
little, so the derivatives by tolerances and initial states are taken once, at a ``Frame``, and only those by the
effect's own unknowns anew at each step: a step costs two to four lanes a trial instead of thirty. Initial states are
eliminated trial by trial (variable projection: Golub & Pereyra, SIAM J. Numer. Anal. 10 (1973) 413).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import TypeVar

import numpy as np

from synth.gap.data import GapTrial
from synth.gap.predict import Block, Hypothesis, Predictor
from synth.model.layout import LANES
from synth.model.leg import Array
from synth.threads import thread_count

STEP = 1e-3  # of a whitened unknown, rad; 30x that of rad/s
RATE_STEP = 30.0
LIMIT = 2.5  # tolerances (standard deviations): a number farther off is no tolerance any more but a cause
DAMPINGS = (1.0, 30.0, 900.0)  # factors on the damping that are tried side by side
T = TypeVar("T")


@lru_cache(maxsize=1)
def _workers() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(max_workers=thread_count(), thread_name_prefix="synth-gap")


def by_trial(function: Callable[[int], T], count: int) -> list[T]:
    """``function(index)`` of each trial on all cores: the compiled code runs without the interpreter's lock."""
    return list(_workers().map(function, range(count)))


@dataclass(frozen=True)
class Part:
    """One trial's share of a frame, whitened: ``tolerance`` (M, p) derivatives, ``q`` (M, l), ``r`` (l, l) of states.

    The states' columns have the weak prior of their initial rates below them, so M is the samples' number plus l.
    """

    tolerance: Array
    q: Array
    r: Array


@dataclass(frozen=True)
class Frame:
    """Derivatives by tolerances and initial states of all trials at one point."""

    parts: tuple[Part, ...]


@dataclass(frozen=True)
class Fit:
    """A hypothesis at one point.

    ``unknowns`` (p + n_effect,); ``states`` a trial (2 n,), or with those of links that give, see ``Block``;
    ``residuals`` a trial (M,) whitened, the states' prior below; ``columns`` a trial (M, n_effect), whitened
    derivatives by the effect's unknowns; ``cost`` a log-likelihood.
    """

    hypothesis: Hypothesis
    unknowns: Array
    states: tuple[Array, ...]
    residuals: tuple[Array, ...] = ()
    columns: tuple[Array, ...] = ()
    cost: float = np.inf
    damping: float = 1e-3
    rounds: int = 0
    done: bool = False
    frame: Frame | None = field(default=None, repr=False)

    @property
    def keys(self) -> tuple[tuple[str, str], ...]:
        """Effect and place of each candidate."""
        return tuple(candidate.key for candidate in self.hypothesis)


@dataclass(frozen=True)
class Workbench:
    """Trials that a diagnosis fits, and how their residuals are weighted.

    ``sigma`` (n,) rad: what a residual is divided by. It is larger than the noise: samples are many and what a form
    does not get right about its cause is no white noise; ``effective`` is the number of samples a trial and joint that
    count as independent.
    """

    predictor: Predictor
    trials: tuple[GapTrial, ...]
    noise: Array
    effective: float

    @property
    def n_tolerance(self) -> int:
        """Number of tolerance unknowns."""
        return self.predictor.tolerances.size

    @cached_property
    def total(self) -> float:
        """Effective samples of all trials and joints."""
        return float(sum(np.minimum(t.counts.sum(axis=0), self.effective).sum() for t in self.trials))

    def cost(self, squares: float, unknowns: Array) -> float:
        """Cost of a whitened sum of squares and unknowns, in units of log-likelihood.

        ``N log(1 + squares / N) + |x|^2 / 2``: near the noise floor least squares, far above it the log-likelihood of
        residuals whose size is not known. So a hypothesis that misses is not driven out of its tolerances by residuals
        that no tolerance can mend.
        """
        return self.total * float(np.log1p(squares / self.total)) + 0.5 * float(unknowns @ unknowns)

    def tempering(self, trial: GapTrial) -> Array:
        """(n,) by what a channel's errors are taken larger, since its samples are not independent."""
        return np.sqrt(np.maximum(trial.counted / self.effective, 1.0))

    def sigma(self, trial: GapTrial) -> Array:
        """(n,) or, where samples differ, (m, n) rad."""
        alike = self.noise * self.tempering(trial)
        return np.asarray(alike if trial.relative is None else alike * trial.relative)

    def residual(self, trial: GapTrial, prediction: Array, state: Array) -> Array:
        """(M,) whitened residual of one trial; inf where the motion diverged."""
        sigma = self.sigma(trial)
        away = ((prediction - trial.measured) / sigma)[trial.counts]
        rate, deviation = trial.recording.initial_rate
        n = len(rate)
        free = trial.free
        prior = np.zeros(2 * len(free) + len(state) - 2 * n)
        prior[len(free) : 2 * len(free)] = (state[n : 2 * n][free] - rate[free]) / deviation[free]
        prior[2 * len(free) :] = state[2 * n :]
        return np.concatenate([np.where(np.isfinite(away), away, np.inf), prior])

    def frame(self, fit: Fit) -> Frame:
        """Derivatives at a fit's point."""
        return Frame(tuple(by_trial(lambda i: self._part(self.trials[i], fit, fit.states[i]), len(self.trials))))

    def _part(self, trial: GapTrial, fit: Fit, state: Array) -> Part:
        alive = np.flatnonzero(self.predictor.tolerances.width.reshape(-1) > 0.0)
        _, slopes = self.slopes(trial, fit, state, alive.tolist())
        below = self.state_prior(trial, state)
        count, extra = len(slopes), len(below)
        tolerance = np.zeros((count + extra, self.n_tolerance))
        tolerance[:count, alive] = slopes[:, : len(alive)]
        q, r = np.linalg.qr(np.concatenate([slopes[:, len(alive) :], below]))
        return Part(tolerance, q, r)

    def slopes(self, trial: GapTrial, fit: Fit, state: Array, unknowns: Sequence[int]) -> tuple[Array, Array]:
        """Prediction (m, n) rad of a trial, and its whitened derivatives (samples that count, n_unknown + n_state).

        By these ``unknowns``, then by the ``state_rows``.
        """
        n = trial.measured.shape[1]
        moves = [(True, k, STEP) for k in unknowns]
        moves += [(False, k, STEP * (RATE_STEP if n <= k < 2 * n else 1.0)) for k in state_rows(trial, state)]
        blocks = []
        for first in range(0, len(moves), LANES - 1):
            chunk = moves[first : first + LANES - 1]
            values = np.repeat(fit.unknowns[:, None], len(chunk) + 1, axis=1)
            states = np.repeat(state[:, None], len(chunk) + 1, axis=1)
            for column, (common, index, step) in enumerate(chunk, start=1):
                (values if common else states)[index, column] += step
            blocks.append(Block(fit.hypothesis, values, states))
        found = self.predictor.predict(trial, blocks)
        widths = np.array([step for _, _, step in moves])
        change = np.concatenate([out[:, :, 1:] - out[:, :, :1] for out in found], axis=2) / widths
        return found[0][:, :, 0], (change / self.sigma(trial)[..., None])[trial.counts]

    @staticmethod
    def state_prior(trial: GapTrial, state: Array) -> Array:
        """(n_state, n_state) rows of the prior of initial rates and of links that give, below the derivatives."""
        free, deviation = trial.free, trial.recording.initial_rate[1]
        links = np.ones(len(state) - 2 * len(deviation))
        return np.diag(np.concatenate([np.zeros(len(free)), 1.0 / deviation[free], links]))

    def awake(self, fit: Fit) -> Fit:
        """The fit with the initial states of the links that its candidates add, as far as it has none."""
        size = 2 * (len(self.noise) + sum(candidate.links for candidate in fit.hypothesis))
        if all(len(state) == size for state in fit.states):
            return fit
        states = tuple(np.concatenate([state, np.zeros(size - len(state))]) for state in fit.states)
        return replace(fit, states=states, residuals=(), columns=(), cost=np.inf, frame=None)

    def evaluate(self, fits: Sequence[Fit]) -> list[Fit]:
        """Residuals and the effects' columns of many fits at their points, packed into common lanes."""

        def one(i: int) -> list[tuple[Array, Array]]:
            trial, blocks = self.trials[i], []
            for fit in fits:
                size = len(fit.unknowns) - self.n_tolerance
                unknowns = np.repeat(fit.unknowns[:, None], size + 1, axis=1)
                for k in range(size):
                    unknowns[self.n_tolerance + k, k + 1] += STEP
                blocks.append(Block(fit.hypothesis, unknowns, np.repeat(fit.states[i][:, None], size + 1, axis=1)))
            found = []
            for fit, out in zip(fits, self.predictor.predict(trial, blocks), strict=True):
                residual = self.residual(trial, out[:, :, 0], fit.states[i])
                slopes = (out[:, :, 1:] - out[:, :, :1]) / STEP / self.sigma(trial)[..., None]
                below = np.zeros((len(residual) - int(trial.counts.sum()), slopes.shape[2]))
                found.append((residual, np.concatenate([slopes[trial.counts], below])))
            return found

        parts = by_trial(one, len(self.trials))
        made = []
        for f, fit in enumerate(fits):
            residuals = tuple(part[f][0] for part in parts)
            columns = tuple(part[f][1] for part in parts)
            cost = self.cost(sum(float(r @ r) for r in residuals), fit.unknowns)
            if not (np.isfinite(cost) and all(np.all(np.isfinite(c)) for c in columns)):
                cost = np.inf
            made.append(replace(fit, residuals=residuals, columns=columns, cost=cost))
        return made

    def solve(self, fits: Sequence[Fit], frame: Frame | None, rounds: int, tolerance: float = 0.5) -> list[Fit]:
        """Improve all fits by at most ``rounds`` steps; ``frame`` for those that have none of their own.

        A fit is done when a step lowers its cost by less than ``tolerance``.
        """
        current = list(fits)
        fresh = [i for i, fit in enumerate(current) if not fit.residuals]
        for i, fit in zip(fresh, self.evaluate([current[i] for i in fresh]), strict=True):
            current[i] = fit
        for _ in range(rounds):
            open_ = [i for i, fit in enumerate(current) if not fit.done and np.isfinite(fit.cost)]
            if not open_:
                break
            steps = [fit for i in open_ for fit in self._steps(current[i], current[i].frame or frame)]
            tried = self.evaluate(steps)
            place = 0
            for i in open_:
                here, count = current[i], len(_dampings(current[i]))
                found = min(tried[place : place + count], key=lambda fit: fit.cost)
                place += count
                if found.cost < here.cost:
                    small = here.cost - found.cost < tolerance
                    damping = max(found.damping / DAMPINGS[1], 1e-6)
                    current[i] = replace(found, damping=damping, rounds=here.rounds + 1, done=small)
                else:
                    damping = max(here.damping, 1e-4) * DAMPINGS[-1] * 10.0
                    current[i] = replace(here, damping=damping, rounds=here.rounds + 1, done=damping > 1e5)
        return current

    def _steps(self, fit: Fit, frame: Frame | None) -> list[Fit]:
        """The fit moved by a step with less and with more damping; lanes are cheaper than a step tried in vain."""
        assert frame is not None
        normal = Normal.of(self, fit, frame)
        return [self._stepped(fit, frame, normal, fit.damping * factor) for factor in _dampings(fit)]

    def _stepped(self, fit: Fit, frame: Frame, normal: Normal, damping: float) -> Fit:
        """The fit moved by one damped step; residuals not yet computed."""
        matrix = normal.matrix + damping * np.diag(np.diag(normal.matrix))
        low, high = self.bounds(fit.hypothesis)
        held = np.zeros(len(fit.unknowns), dtype=bool)
        step = np.zeros(len(fit.unknowns))
        for _ in range(6):
            moving = ~held
            step[:] = 0.0
            step[moving] = -np.linalg.solve(matrix[np.ix_(moving, moving)], normal.gradient[moving])
            outward = ((fit.unknowns <= low) & (step < 0)) | ((fit.unknowns >= high) & (step > 0))
            if not np.any(outward & ~held):
                break
            held |= outward
        most = np.max(np.abs(step[self.n_tolerance :]), initial=0.0)
        if most > 3.0:
            step *= 3.0 / most
        unknowns = np.clip(fit.unknowns + step, low, high)
        step = unknowns - fit.unknowns
        states = []
        for i, (part, trial) in enumerate(zip(frame.parts, self.trials, strict=True)):
            ahead = fit.residuals[i] + part.tolerance @ step[: self.n_tolerance]
            ahead = ahead + fit.columns[i] @ step[self.n_tolerance :]
            square = part.r.T @ part.r
            damped = square + damping * np.diag(np.diag(square))
            change: Array = -np.asarray(np.linalg.solve(damped, part.r.T @ (part.q.T @ ahead)))
            states.append(self._state(trial, fit.states[i], change))
        return replace(
            fit, unknowns=unknowns, states=tuple(states), residuals=(), columns=(), cost=np.inf, damping=damping
        )

    @staticmethod
    def _state(trial: GapTrial, state: Array, change: Array) -> Array:
        moved = state.copy()
        moved[state_rows(trial, state)] += change
        return moved

    def bounds(self, hypothesis: Hypothesis) -> tuple[Array, Array]:
        """Least and greatest unknowns; tolerances stay within ``LIMIT``."""
        lows, highs = [np.full(self.n_tolerance, -LIMIT)], [np.full(self.n_tolerance, LIMIT)]
        for candidate in hypothesis:
            low, high = candidate.bounds()
            lows.append(low)
            highs.append(high)
        return np.concatenate(lows), np.concatenate(highs)


def state_rows(trial: GapTrial, state: Array) -> list[int]:
    """Rows of a trial's initial state that are free: rotations and rates of joints not locked, and links that give."""
    n = trial.measured.shape[1]
    return [*trial.free, *[n + j for j in trial.free], *range(2 * n, len(state))]


def _dampings(fit: Fit) -> tuple[float, ...]:
    """Factors that are tried: fewer where the cause enters all but linearly, as a shifted reading or a mass does."""
    mild = all(candidate.effect.way in ("leg", "reading") for candidate in fit.hypothesis)
    return DAMPINGS[:2] if mild else DAMPINGS


@dataclass(frozen=True)
class Normal:
    """Normal equations in the unknowns once the states are eliminated.

    ``parts`` : each trial's matrix, gradient and sum of squares, without prior and ``weight``.
    """

    matrix: Array
    gradient: Array
    weight: float
    parts: tuple[tuple[Array, Array, float], ...]

    @classmethod
    def of(cls, bench: Workbench, fit: Fit, frame: Frame) -> Normal:
        """At a fit's point, with the derivatives of a frame."""
        made = []
        for part, residual, columns in zip(frame.parts, fit.residuals, fit.columns, strict=True):
            slopes = np.concatenate([part.tolerance, columns], axis=1)
            slopes = slopes - part.q @ (part.q.T @ slopes)
            left = residual - part.q @ (part.q.T @ residual)
            made.append((slopes.T @ slopes, slopes.T @ left, float(left @ left)))
        size = len(fit.unknowns)
        weight = 2.0 / (1.0 + sum(float(r @ r) for r in fit.residuals) / bench.total)
        matrix = np.eye(size) + weight * sum((m for m, _, _ in made), np.zeros((size, size)))
        gradient = fit.unknowns + weight * sum((g for _, g, _ in made), np.zeros(size))
        return cls(matrix, gradient, weight, tuple(made))

    def without(self, trial: int) -> Array:
        """Step (n_unknown,) to the fit of all trials but one: Gauss-Newton from the common fit, in closed form."""
        matrix, gradient, _ = self.parts[trial]
        left = self.gradient - self.weight * gradient
        return -np.asarray(np.linalg.solve(self.matrix - self.weight * matrix, left))
