"""Many hypotheses fitted in parallel, within the tolerances and with each trial's initial state.

Levenberg-Marquardt (``synth.estimation``) in whitened unknowns with standard normal priors. A hypothesis
changes a leg's motion little, so the derivatives by tolerances and initial states are computed once, in a
``Linearisation``, and only those by the effect's own unknowns at each step: a step costs two to four lanes per trial,
not one for each tolerance and initial state.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial, Whitener, trials_together
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.lanes import Block, Hypothesis, LanePredictor, PredictorCache, state_size
from synth.diagnosis.search_limits import LARGEST_TOLERANCE
from synth.estimation.levenberg_marquardt import CONVERGED, Iterate, LeastSquares, Marquardt, minimise
from synth.estimation.linearisation import Linearisation, LinearisedNormal, TrialLinearisation
from synth.estimation.normal_equations import ParameterStep, StepLimits
from synth.estimation.unknown_size import UnknownSize
from synth.threads import in_parallel, thread_count

UNKNOWN_STEP = 1e-3  # of a whitened unknown, rad
RATE_STEP_RATIO = 30.0  # ratio of the steps of a rate, per time unit of the trial, and an angle
DAMPING_FACTORS = (1.0, 30.0, 900.0)  # factors on the damping, tried in parallel: lanes are cheaper than a failed step
CALLS_A_CORE = 8  # least number of calls a core beyond the first: cores then wait little for the last one
SOLVED = 0.5  # log-likelihood, fall of the cost below which a step is a fit's last: one standard deviation
LONGEST_STEP = 3.0  # largest step of an effect's whitened unknown
# After a failed step the damping rises above all values tried, by 900 and 10 more; a fit whose damping exceeds 1e5 has
# found no better point in two such rounds.
DAMPING_RULE = Marquardt(least=1e-6, most=1e5, down=30.0, up=9000.0, least_after_failure=0.9)
T = TypeVar("T")


@dataclass(frozen=True)
class Workbench:
    """The trials of a diagnosis and the weights of their residuals.

    ``noise`` (n,) rad of the readings; the residuals' divisor, ``sigma``, exceeds it, because samples are many and
    form errors of a cause are not white noise; ``effective`` is the number of samples per trial and joint that
    count as independent; ``step`` : of a whitened unknown and in rad, of the derivatives; rates use ``RATE_STEP_RATIO``
    times as much per time unit of the trial.
    """

    predictor: LanePredictor
    trials: tuple[AngleTrial, ...]
    noise: Array
    effective: float
    step: float = UNKNOWN_STEP

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

        Its motions take so little time that threads mostly wait for the interpreter's lock.
        """
        return 1 if len(self.noise) == 1 and not self.in_pieces else thread_count()

    def in_parallel(self, work: Callable[[int], T], count: int) -> list[T]:
        """``work(index)`` for each index below ``count``, in order, on so many cores."""
        return in_parallel(work, count, self.cores)

    @cached_property
    def unknown_size(self) -> UnknownSize:
        """Cost, by which the search orders hypotheses, and weight of the residuals of all trials.

        The odds are tuned with that; what is reported has ``ReducedNormal.covariance``. Residuals that no tolerance can
        reduce do not push a hypothesis out of its tolerances.
        """
        return UnknownSize(self.total)

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

    @cached_property
    def together(self) -> list[range]:
        """Indices of the trials that one call predicts."""
        return trials_together(self.trials)

    def whitener(self, *trials: AngleTrial) -> Whitener:
        """The whitener of the predictions of one trial, or of ``trials_together``."""
        key = id(trials[0]), len(trials)
        if key not in self._whiteners:
            self._whiteners[key] = trials, Whitener.of(trials, [self.sigma(trial) for trial in trials])
        return self._whiteners[key][1]

    @cached_property
    def _whiteners(self) -> dict[tuple[int, int], tuple[tuple[AngleTrial, ...], Whitener]]:
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
        wide = [_step_each_unknown(fit.unknowns, first, self.step) for fit in fits]
        widths = [unknowns.shape[1] for unknowns in wide]
        hypotheses = [fit.hypothesis for fit in fits]
        packed = self.predictor.groups(hypotheses, widths)
        runs = self.predictor.runs(hypotheses, packed, -(-CALLS_A_CORE * (self.cores - 1) // len(self.together)))
        kept: list[PredictorCache] = [{} for _ in runs]

        def one(job: int) -> list[tuple[int, int, T]]:
            place, run = divmod(job, len(runs))
            inside = self.together[place]
            trials = self.trials[inside.start : inside.stop]
            groups = [
                [Block(fits[f].hypothesis, wide[f], _initial_states(fits[f], inside)[:, :, None]) for f in packed[g]]
                for g in runs[run]
            ]
            white = self.whitener(*trials)
            lanes = white.lanes(self.predictor.together(trials, groups, kept[run]))
            found, last = [], 0
            for f in (f for g in runs[run] for f in packed[g]):
                first, last = last, last + widths[f]
                found += [
                    (f, i, use(i, fits[f], lanes[first:last, at])) for i, at in zip(inside, white.each, strict=True)
                ]
            return found

        result: list[list[Any]] = [[None] * len(fits) for _ in self.trials]
        for made in self.in_parallel(one, len(runs) * len(self.together)):
            for f, i, used in made:
                result[i][f] = used
        return result

    def frame(self, fit: EvaluatedHypothesis) -> Linearisation:
        """Derivatives at a fit's point."""
        kept: PredictorCache = {}
        parts = self.in_parallel(lambda k: self._parts(self.together[k], fit, kept), len(self.together))
        return Linearisation(tuple(part for found in parts for part in found))

    def _parts(self, inside: range, fit: EvaluatedHypothesis, kept: PredictorCache) -> list[TrialLinearisation]:
        """Linearisations of ``trials_together``."""
        alive, trials = list(self.predictor.open_tolerances), self.trials[inside.start : inside.stop]
        states, made = _initial_states(fit, inside), []
        _, all_slopes = self._slopes(trials, fit, states, alive, kept)
        for trial, state, rows in zip(trials, states, self.whitener(*trials).each, strict=True):
            slopes, below = all_slopes[rows], self.state_prior(trial, state)
            count, extra = len(slopes), len(below)
            tolerance = np.zeros((count + extra, self.n_tolerance))
            tolerance[:count, alive] = slopes[:, : len(alive)]
            q, r = np.linalg.qr(np.concatenate([slopes[:, len(alive) :], below]))
            made.append(TrialLinearisation(tolerance, q, r))
        return made

    def slopes(
        self,
        trial: AngleTrial,
        fit: EvaluatedHypothesis,
        state: Array,
        unknowns: Sequence[int],
        kept: PredictorCache | None = None,
    ) -> tuple[Array, Array]:
        """Prediction (m, n) rad of a trial, and its whitened derivatives (samples that count, n_unknown + n_state).

        By these ``unknowns``, then by the ``state_rows``. ``kept`` : one for all calls with the same fit and unknowns.
        """
        return self._slopes([trial], fit, state[None], unknowns, kept)

    def _slopes(
        self,
        trials: Sequence[AngleTrial],
        fit: EvaluatedHypothesis,
        states: Array,
        unknowns: Sequence[int],
        kept: PredictorCache | None,
    ) -> tuple[Array, Array]:
        """Like ``slopes``, of ``trials_together`` with initial ``states`` (n_trial, n_state), their samples in order.

        A derivative by a state is that by the trial's own.
        """
        n = trials[0].measured.shape[1]
        moves = [(True, k, self.step) for k in unknowns]
        of_rate = self.step * RATE_STEP_RATIO / trials[0].time_unit
        moves += [(False, k, of_rate if n <= k < 2 * n else self.step) for k in state_rows(trials[0], states[0])]
        blocks = []
        most = self.predictor.n_lane - 1
        for first in range(0, len(moves), most):
            chunk = moves[first : first + most]
            values = np.repeat(fit.unknowns[:, None], len(chunk) + 1, axis=1)
            moved = np.repeat(states[:, :, None], len(chunk) + 1, axis=2)
            for column, (common, index, step) in enumerate(chunk, start=1):
                if common:
                    values[index, column] += step
                else:
                    moved[:, index, column] += step
            blocks.append(Block(fit.hypothesis, values, moved))
        found = self.predictor.predict(trials, blocks, kept)
        white = self.whitener(*trials)
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
        """The fit with zero initial states for the links of the designed leg's structures and of its candidates."""
        size = state_size(self.predictor, len(self.noise), fit.hypothesis)
        if all(len(state) == size for state in fit.states):
            return fit
        states = tuple(np.concatenate([state, np.zeros(size - len(state))]) for state in fit.states)
        return fit.start_at(states=states)

    def held(self, fit: EvaluatedHypothesis) -> EvaluatedHypothesis:
        """A start of the fit with the designed leg's initial states, and zero ones for its candidates' links."""
        size = state_size(self.predictor, len(self.noise), ())
        return self.awake(fit.start_at(states=[state[:size] for state in fit.states]))

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
            cost = self.unknown_size.cost(sum(float(r @ r) for r in residuals), fit.unknowns)
            if not (np.isfinite(cost) and all(np.all(np.isfinite(c)) for c in columns)):
                cost = np.inf
            made.append(replace(fit, residuals=residuals, columns=columns, cost=cost))
        return made

    def solve(
        self, fits: Sequence[EvaluatedHypothesis], frame: Linearisation | None, rounds: int, tolerance: float = SOLVED
    ) -> list[EvaluatedHypothesis]:
        """Improve all fits by at most ``rounds`` steps; ``frame`` for those without their own linearisation.

        A fit is finished when a step lowers its cost by less than ``tolerance``.
        """
        current = list(fits)
        fresh = [i for i, fit in enumerate(current) if not fit.residuals]
        for i, fit in zip(fresh, self.evaluate([current[i] for i in fresh]), strict=True):
            current[i] = fit
        start = [Iterate(fit, fit.damping, CONVERGED if fit.done else "") for fit in current]
        ends = minimise(HypothesisFits(self, frame, tolerance), start, DAMPING_RULE, rounds)
        return [replace(end.point, damping=end.damping, done=end.reason == CONVERGED) for end in ends]

    def normal(self, fit: EvaluatedHypothesis, frame: Linearisation | None = None) -> LinearisedNormal:
        """Normal equations at an evaluated fit; derivatives are computed if it has none and none are given."""
        weight = self.unknown_size.weight(float(sum(float(r @ r) for r in fit.residuals)))
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
        """Bounds of the unknowns; tolerances stay within ``LARGEST_TOLERANCE``."""
        wide = np.full(self.n_tolerance, LARGEST_TOLERANCE)
        lows, highs = [-wide], [wide]
        for candidate in hypothesis:
            low, high = candidate.bounds()
            lows.append(low)
            highs.append(high)
        return np.concatenate(lows), np.concatenate(highs)


def _step_each_unknown(unknowns: Array, first: int | None, step: float) -> Array:
    """(p, n_lane) the unknowns, and with each of them from ``first`` on moved by a ``step``; None for none of them."""
    count = 0 if first is None else len(unknowns) - first
    wide = np.repeat(unknowns[:, None], count + 1, axis=1)
    moved = np.arange(len(unknowns) - count, len(unknowns))
    wide[moved, np.arange(1, count + 1)] += step
    return wide


def _initial_states(fit: EvaluatedHypothesis, inside: range) -> Array:
    """(n_trial, n_state) a fit's initial states in these trials."""
    return np.array(fit.states[inside.start : inside.stop])


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
        """Normal equations by the linearisation, and the effect's own columns."""
        frame = point.frame or self.frame
        assert frame is not None
        return self.bench.normal(point, frame)

    def bounds(self, point: EvaluatedHypothesis) -> tuple[Array, Array]:
        """Lowest and highest tolerances and causes' unknowns, (p,) each, whitened."""
        return self.bench.bounds(point.hypothesis)

    def limits(self, point: EvaluatedHypothesis) -> StepLimits:
        """An effect's unknown moves by ``LONGEST_STEP`` at most; tolerances have their bounds."""
        p = self.bench.n_tolerance
        return StepLimits(np.r_[np.full(p, np.inf), np.full(len(point.unknowns) - p, LONGEST_STEP)], follow=True)

    def damping_factors(self, point: EvaluatedHypothesis) -> tuple[float, ...]:
        """Fewer if the cause enters almost linearly, like a shifted reading or a mass."""
        mild = all(candidate.nearly_linear for candidate in point.hypothesis)
        return DAMPING_FACTORS[:2] if mild else DAMPING_FACTORS

    def moved(self, point: EvaluatedHypothesis, step: ParameterStep) -> EvaluatedHypothesis:
        """After a step, not evaluated."""
        states = self.bench.moved_states(point, step.own)
        return point.start_at(unknowns=point.unknowns + step.common, states=states, frame=point.frame)

    def least_gain(self, cost: float) -> float:
        """The tolerance, independent of the cost."""
        return self.tolerance
