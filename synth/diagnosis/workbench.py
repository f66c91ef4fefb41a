"""Many hypotheses fitted in parallel, within the tolerances and with each trial's initial state.

Levenberg-Marquardt (``synth.estimation``) in whitened unknowns with standard normal priors. A hypothesis
changes a leg's motion little, so the derivatives by tolerances and initial states are computed once, in a
``Linearisation``, and only those by the effect's own unknowns at each step: a step costs two to four lanes per trial
instead of thirty.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TypeVar

import numpy as np

from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial, Whitener
from synth.diagnosis.effect_shape import shape_places
from synth.diagnosis.lanes import Block, Hypothesis, Kept, LanePredictor
from synth.estimation.levenberg_marquardt import CONVERGED, Factors, Iterate, LeastSquares, minimise
from synth.estimation.linearisation import Linearisation, LinearisedNormal, TrialLinearisation
from synth.estimation.normal_equations import ParameterStep, StepLimits
from synth.threads import in_parallel, thread_count

STEP = 1e-3  # of a whitened unknown, rad
RATE_STEP = 30.0  # s^-1, ratio of the steps of a rate and an angle, suited to limbs of a few hertz
LIMIT = 2.5  # tolerances (standard deviations): a larger deviation counts as a cause, not a tolerance
DAMPINGS = (1.0, 30.0, 900.0)  # factors on the damping, tried in parallel: lanes are cheaper than a failed step
TASKS = 8  # least number of calls a core beyond the first: cores then wait little for the last one
LONGEST = 3.0  # largest step of an effect's whitened unknown
# After a failed step the damping rises above all values tried, by 900 and 10 more; a fit whose damping exceeds 1e5 has
# found no better point in two such rounds.
RULE = Factors(least=1e-6, most=1e5, down=30.0, up=9000.0, least_after_failure=0.9)
T = TypeVar("T")


@dataclass(frozen=True)
class EvaluatedHypothesis:
    """A hypothesis at one point.

    ``unknowns`` (p + n_effect,); ``states`` (2 n,) per trial, or with those of compliant links, see ``Block``;
    ``residuals`` (M,) per trial, whitened, followed by the states' prior; ``columns`` (M, n_effect) per trial, whitened
    derivatives by the effect's unknowns; ``cost`` a log-likelihood.
    """

    hypothesis: Hypothesis
    unknowns: Array
    states: tuple[Array, ...]
    residuals: tuple[Array, ...] = ()
    columns: tuple[Array, ...] = ()
    cost: float = np.inf
    damping: float = 1e-3
    done: bool = False
    frame: Linearisation | None = field(default=None, repr=False)

    def at(self, unknowns: Array) -> EvaluatedHypothesis:
        """The hypothesis with other unknowns, for predictions."""
        return replace(self, unknowns=unknowns)

    @property
    def keys(self) -> tuple[tuple[str, str], ...]:
        """Effect and place of each candidate."""
        return tuple(candidate.key for candidate in self.hypothesis)

    @cached_property
    def shapes(self) -> Array:
        """(n, 2), see ``hypotheses.FittedHypothesis``; without derivatives fully determined."""
        first = len(self.unknowns) - sum(cause.size for cause in self.hypothesis)
        places = shape_places(self.hypothesis)
        values = self.unknowns[[first + place for place in places]]
        if not self.columns:
            return np.column_stack([values, np.full(len(places), np.inf)])
        parts = self.frame.trials if self.frame is not None else [None] * len(self.columns)
        changes = np.zeros(len(places))
        for part, columns in zip(parts, self.columns, strict=True):
            rows = columns.T[places]
            changes += np.sum((rows if part is None else part.project(rows)) ** 2, axis=1)
        squares = sum(float(residual @ residual) for residual in self.residuals)
        return np.column_stack([values, changes / squares])


@dataclass(frozen=True)
class Workbench:
    """The trials of a diagnosis and the weights of their residuals.

    ``sigma`` (n,) rad: divisor of the residuals. It exceeds the noise, because samples are many and
    form errors of a cause are not white noise; ``effective`` is the number of samples per trial and joint that
    count as independent; ``step`` : of a whitened unknown and in rad, of the derivatives; rates use ``RATE_STEP`` times
    as much in rad/s.
    """

    predictor: LanePredictor
    trials: tuple[AngleTrial, ...]
    noise: Array
    effective: float
    step: float = STEP

    @property
    def n_tolerance(self) -> int:
        """Number of tolerance unknowns."""
        return self.predictor.n_tolerance

    @cached_property
    def total(self) -> float:
        """Effective samples of all trials and joints."""
        return float(sum(self.independent(trial).sum() for trial in self.trials))

    @cached_property
    def in_pieces(self) -> bool:
        """Whether recordings are compared in pieces."""
        return any(trial.part_of for trial in self.trials)

    @cached_property
    def cores(self) -> int:
        """Cores that work on the trials: one for a single link that is not compared in pieces.

        Its motions take so little time that threads mostly wait for the interpreter's lock: with two of them
        ``synth gap`` on six trials of a pendulum took 3.8 s of a processor, with one 3.1 s, in turn.
        """
        return 1 if len(self.noise) == 1 and not self.in_pieces else thread_count()

    def in_parallel(self, work: Callable[[int], T], count: int) -> list[T]:
        """``work(index)`` for each index below ``count``, in order, on so many cores."""
        return in_parallel(work, count, self.cores)

    def cost(self, squares: float, unknowns: Array) -> float:
        """Cost of a whitened sum of squares and unknowns, in units of log-likelihood.

        ``N log(1 + squares / N) + |x|^2 / 2``: near the noise floor least squares, far above it the log-likelihood of
        residuals of unknown size. Residuals that no tolerance can reduce then do not push a hypothesis out of its
        tolerances.
        """
        return self.total * float(np.log1p(squares / self.total)) + 0.5 * float(unknowns @ unknowns)

    def tempering(self, trial: AngleTrial) -> Array:
        """(n,) factor on a channel's errors, because its samples are not independent."""
        return np.sqrt(np.maximum(trial.counted / (trial.share * self.effective), 1.0))

    def independent(self, trial: AngleTrial) -> Array:
        """(n,) samples of a trial that count as independent; pieces of a recording together count as much as it."""
        return np.minimum(trial.counted, trial.share * self.effective)

    def sigma(self, trial: AngleTrial) -> Array:
        """(n,) or, if samples differ, (m, n) rad."""
        alike = self.noise * self.tempering(trial)
        return np.asarray(alike if trial.relative is None else alike * trial.relative)

    def residual(self, trial: AngleTrial, prediction: Array, state: Array) -> Array:
        """(M,) whitened residual of one trial; inf if the motion diverged."""
        found = self._residual(trial, self.whitener(trial).lanes(prediction[:, :, None])[0], state)
        return np.where(np.isfinite(found), found, np.inf)

    def whitener(self, trial: AngleTrial) -> Whitener:
        """Of a trial's predictions."""
        if id(trial) not in self._whiteners:
            self._whiteners[id(trial)] = trial, Whitener.of(trial, self.sigma(trial))
        return self._whiteners[id(trial)][1]

    @cached_property
    def _whiteners(self) -> dict[int, tuple[AngleTrial, Whitener]]:
        """The results of ``whitener``; a trial that is kept here keeps its identity."""
        return {}

    @staticmethod
    def _residual(trial: AngleTrial, first: Array, state: Array) -> Array:
        """(M,) of a prediction's ``first`` lane, whitened (count,); not finite if it diverged."""
        rate, deviation = trial.rate_prior
        free, n = trial.free, trial.measured.shape[1]
        # Rotations have no prior.
        return np.concatenate([first, np.zeros(len(free)), (state[n : 2 * n][free] - rate) / deviation, state[2 * n :]])

    def residuals(self, fits: Sequence[EvaluatedHypothesis]) -> list[list[Array]]:
        """(M,) whitened residuals of every fit, one list per trial; not finite if a motion diverged."""

        def used(i: int, fit: EvaluatedHypothesis, lanes: Array) -> Array:
            return self._residual(self.trials[i], lanes[0], fit.states[i])

        return self._predicted(fits, None, used)

    def _predicted(
        self,
        fits: Sequence[EvaluatedHypothesis],
        first: int | None,
        use: Callable[[int, EvaluatedHypothesis, Array], T],
    ) -> list[list[T]]:
        """``use`` of every fit's whitened lanes (n_lane, count) in every trial, one list per trial.

        A fit's lanes: itself, and for each unknown from ``first`` a copy with that unknown stepped; None for no copy.
        A trial's groups of lanes are predicted in few calls, but in enough to occupy all cores to the end.
        """
        wide = [_stepped(fit.unknowns, first, self.step) for fit in fits]
        widths = [unknowns.shape[1] for unknowns in wide]
        hypotheses = [fit.hypothesis for fit in fits]
        packed = self.predictor.groups(hypotheses, widths)
        runs = self.predictor.runs(hypotheses, packed, -(-TASKS * (self.cores - 1) // len(self.trials)))
        kept: list[Kept] = [{} for _ in runs]

        def one(job: int) -> list[tuple[int, T]]:
            i, run = divmod(job, len(runs))
            groups = [
                [Block(fits[f].hypothesis, wide[f], fits[f].states[i][:, None]) for f in packed[g]] for g in runs[run]
            ]
            white = self.whitener(self.trials[i]).lanes(self.predictor.together(self.trials[i], groups, kept[run]))
            order = [f for g in runs[run] for f in packed[g]]
            ends = np.cumsum([widths[f] for f in order]).tolist()
            return [(f, use(i, fits[f], white[end - widths[f] : end])) for f, end in zip(order, ends, strict=True)]

        done = self.in_parallel(one, len(runs) * len(self.trials))
        result = []
        for i in range(len(self.trials)):
            each = dict(item for made in done[i * len(runs) : (i + 1) * len(runs)] for item in made)
            result.append([each[f] for f in range(len(fits))])
        return result

    def frame(self, fit: EvaluatedHypothesis) -> Linearisation:
        """Derivatives at a fit's point."""
        kept: Kept = {}
        parts = self.in_parallel(lambda i: self._part(self.trials[i], fit, fit.states[i], kept), len(self.trials))
        return Linearisation(tuple(parts))

    def _part(self, trial: AngleTrial, fit: EvaluatedHypothesis, state: Array, kept: Kept) -> TrialLinearisation:
        alive = list(self.predictor.open_tolerances)
        _, slopes = self.slopes(trial, fit, state, alive, kept)
        below = self.state_prior(trial, state)
        count, extra = len(slopes), len(below)
        tolerance = np.zeros((count + extra, self.n_tolerance))
        tolerance[:count, alive] = slopes[:, : len(alive)]
        q, r = np.linalg.qr(np.concatenate([slopes[:, len(alive) :], below]))
        return TrialLinearisation(tolerance, q, r)

    def slopes(
        self,
        trial: AngleTrial,
        fit: EvaluatedHypothesis,
        state: Array,
        unknowns: Sequence[int],
        kept: Kept | None = None,
    ) -> tuple[Array, Array]:
        """Prediction (m, n) rad of a trial, and its whitened derivatives (samples that count, n_unknown + n_state).

        By these ``unknowns``, then by the ``state_rows``. ``kept`` : one for all calls with the same fit and unknowns.
        """
        n = trial.measured.shape[1]
        moves = [(True, k, self.step) for k in unknowns]
        of_rate = self.step * RATE_STEP / trial.time_unit
        moves += [(False, k, of_rate if n <= k < 2 * n else self.step) for k in state_rows(trial, state)]
        blocks = []
        most = self.predictor.n_lane - 1
        for first in range(0, len(moves), most):
            chunk = moves[first : first + most]
            values = np.repeat(fit.unknowns[:, None], len(chunk) + 1, axis=1)
            states = np.repeat(state[:, None], len(chunk) + 1, axis=1)
            for column, (common, index, step) in enumerate(chunk, start=1):
                (values if common else states)[index, column] += step
            blocks.append(Block(fit.hypothesis, values, states))
        found = self.predictor.predict(trial, blocks, kept)
        white = self.whitener(trial)
        change, first = np.empty((len(moves), white.count)), 0
        for out in found:
            lanes = white.lanes(out)
            change[first : first + len(lanes) - 1] = lanes[1:] - lanes[0]
            first += len(lanes) - 1
        change /= np.array([step for _, _, step in moves])[:, None]
        return found[0][:, :, 0], change.T

    @staticmethod
    def state_prior(trial: AngleTrial, state: Array) -> Array:
        """(n_state, n_state) rows of the prior of initial rates and of compliant links, below the derivatives."""
        free, deviation = trial.free, trial.recording.initial_rate[1]
        links = np.ones(len(state) - 2 * len(deviation))
        return np.diag(np.concatenate([np.zeros(len(free)), 1.0 / deviation[free], links]))

    def awake(self, fit: EvaluatedHypothesis) -> EvaluatedHypothesis:
        """The fit with zero initial states for the links that its candidates add."""
        size = 2 * (len(self.noise) + sum(candidate.links for candidate in fit.hypothesis))
        if all(len(state) == size for state in fit.states):
            return fit
        states = tuple(np.concatenate([state, np.zeros(size - len(state))]) for state in fit.states)
        return replace(fit, states=states, residuals=(), columns=(), cost=np.inf, frame=None)

    def evaluate(self, fits: Sequence[EvaluatedHypothesis]) -> list[EvaluatedHypothesis]:
        """Residuals and the effects' columns of many fits, packed into common lanes."""
        p = self.n_tolerance

        def used(i: int, fit: EvaluatedHypothesis, lanes: Array) -> tuple[Array, Array]:
            residual = self._residual(self.trials[i], lanes[0], fit.states[i])
            slopes = np.zeros((len(lanes) - 1, len(residual)))
            change = slopes[:, : lanes.shape[1]]
            np.subtract(lanes[1:], lanes[0], out=change)
            change /= self.step
            return residual, slopes.T

        parts = self._predicted(fits, p, used)
        made = []
        for f, fit in enumerate(fits):
            residuals = tuple(part[f][0] for part in parts)
            columns = tuple(part[f][1] for part in parts)
            cost = self.cost(sum(float(r @ r) for r in residuals), fit.unknowns)
            if not (np.isfinite(cost) and all(np.all(np.isfinite(c)) for c in columns)):
                cost = np.inf
            made.append(replace(fit, residuals=residuals, columns=columns, cost=cost))
        return made

    def solve(
        self, fits: Sequence[EvaluatedHypothesis], frame: Linearisation | None, rounds: int, tolerance: float = 0.5
    ) -> list[EvaluatedHypothesis]:
        """Improve all fits by at most ``rounds`` steps; ``frame`` for those without their own linearisation.

        A fit is finished when a step lowers its cost by less than ``tolerance``.
        """
        current = list(fits)
        fresh = [i for i, fit in enumerate(current) if not fit.residuals]
        for i, fit in zip(fresh, self.evaluate([current[i] for i in fresh]), strict=True):
            current[i] = fit
        start = [Iterate(fit, fit.damping, CONVERGED if fit.done else "") for fit in current]
        ends = minimise(HypothesisFits(self, frame, tolerance), start, RULE, rounds)
        return [replace(end.point, damping=end.damping, done=end.reason == CONVERGED) for end in ends]

    def normal(self, fit: EvaluatedHypothesis, frame: Linearisation | None = None) -> LinearisedNormal:
        """Normal equations at an evaluated fit; derivatives are computed if it has none and none are given."""
        weight = 2.0 / (1.0 + sum(float(r @ r) for r in fit.residuals) / self.total)
        return (frame or fit.frame or self.frame(fit)).normal(fit.residuals, fit.columns, weight, fit.unknowns)

    def moved_states(self, fit: EvaluatedHypothesis, change: Sequence[Array]) -> tuple[Array, ...]:
        """Each trial's initial state after a ``change`` of its free components."""
        made = []
        for trial, state, own in zip(self.trials, fit.states, change, strict=True):
            moved = state.copy()
            moved[state_rows(trial, state)] += own
            made.append(moved)
        return tuple(made)

    def bounds(self, hypothesis: Hypothesis) -> tuple[Array, Array]:
        """Bounds of the unknowns; tolerances stay within ``LIMIT``."""
        lows, highs = [np.full(self.n_tolerance, -LIMIT)], [np.full(self.n_tolerance, LIMIT)]
        for candidate in hypothesis:
            low, high = candidate.bounds()
            lows.append(low)
            highs.append(high)
        return np.concatenate(lows), np.concatenate(highs)


def _stepped(unknowns: Array, first: int | None, step: float) -> Array:
    """(p, n_lane) the unknowns, and with each of them from ``first`` on moved by a ``step``; None for none of them."""
    count = 0 if first is None else len(unknowns) - first
    wide = np.repeat(unknowns[:, None], count + 1, axis=1)
    moved = np.arange(len(unknowns) - count, len(unknowns))
    wide[moved, np.arange(1, count + 1)] += step
    return wide


def state_rows(trial: AngleTrial, state: Array) -> list[int]:
    """Free rows of a trial's initial state: rotations and rates of joints not locked, and compliant links."""
    n = trial.measured.shape[1]
    return [*trial.free, *[n + j for j in trial.free], *range(2 * n, len(state))]


@dataclass(frozen=True)
class HypothesisFits(LeastSquares[EvaluatedHypothesis]):
    """Hypotheses as least-squares problems; ``frame`` for those without their own linearisation."""

    bench: Workbench
    frame: Linearisation | None
    tolerance: float

    def evaluate(self, points: Sequence[EvaluatedHypothesis]) -> list[EvaluatedHypothesis]:
        """All in common lanes."""
        return self.bench.evaluate(points)

    def normal(self, point: EvaluatedHypothesis) -> LinearisedNormal:
        """By the linearisation, and the effect's own columns."""
        frame = point.frame or self.frame
        assert frame is not None
        return self.bench.normal(point, frame)

    def bounds(self, point: EvaluatedHypothesis) -> tuple[Array, Array]:
        """Of tolerances and causes."""
        return self.bench.bounds(point.hypothesis)

    def limits(self, point: EvaluatedHypothesis) -> StepLimits:
        """An effect's unknown moves by ``LONGEST`` at most; tolerances have their bounds."""
        p = self.bench.n_tolerance
        return StepLimits(np.r_[np.full(p, np.inf), np.full(len(point.unknowns) - p, LONGEST)], follow=True)

    def factors(self, point: EvaluatedHypothesis) -> tuple[float, ...]:
        """Fewer if the cause enters almost linearly, like a shifted reading or a mass."""
        mild = all(candidate.nearly_linear for candidate in point.hypothesis)
        return DAMPINGS[:2] if mild else DAMPINGS

    def moved(self, point: EvaluatedHypothesis, step: ParameterStep) -> EvaluatedHypothesis:
        """After a step, not evaluated."""
        states = self.bench.moved_states(point, step.own)
        unknowns = point.unknowns + step.common
        return replace(point, unknowns=unknowns, states=states, residuals=(), columns=(), cost=np.inf)

    def least_gain(self, cost: float) -> float:
        """The tolerance, independent of the cost."""
        return self.tolerance
