"""The error of each leading hypothesis on trials that were left out of its fit.

The trials are split into folds; each hypothesis is fitted without one fold after the other, and its error on the
left-out trials is computed with fitted initial states (K-fold cross-validation: Stone, J. R. Stat. Soc. B 36
(1974) 111). All folds of all hypotheses step in common lanes. A fit starts from the fit to all trials and keeps
its derivatives by tolerances and states, so that a few steps suffice; the closed form of one step is wrong if a
cause changes the motion strongly (a link that bends: 1.41 for 0.9 deg on the robot's ankle). Where a left-out trial
errs more than it did in the fit to all, its initial state is fitted again with derivatives of its own: near the top of
a pendulum the kept ones do not lead there, and a piece erred by 66000 floors that has 9 from its best state.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from synth.arrays import Array
from synth.diagnosis.evaluated_hypothesis import FIRST_DAMPING, EvaluatedHypothesis
from synth.diagnosis.hypotheses import Assessment, Hypotheses, TrialErrors
from synth.diagnosis.lanes import PredictorCache
from synth.diagnosis.left_out_fold import FitWithoutFold, bounded_residual, evaluated_without_fold, normal_without_fold
from synth.diagnosis.odds import Calibration, in_order_of_odds
from synth.diagnosis.prediction_error import BLOCKS_A_TRIAL
from synth.diagnosis.score import from_state
from synth.diagnosis.workbench import DAMPING_RULE, HypothesisFits, Workbench
from synth.estimation.correlation import independent_errors
from synth.estimation.intervals import NORMAL90, student95
from synth.estimation.levenberg_marquardt import Iterate, minimise
from synth.estimation.linearisation import LinearisedNormal

MOST_SINGLES, SETS_A_SIZE = 8, 3  # leading hypotheses evaluated, of one cause and of several
MOST_FOLDS = 5  # of the trials: with more folds a fit hardly differs from the fit to all, at the same cost each
FOLD_ITERATIONS = 3  # iterations without a fold
LAST_STEP_FALL = 0.5  # decrease of the cost below which a step is the last
DAMPING_FACTORS = (1.0, 30.0)  # on the damping, tried in parallel: the fit starts near its optimum
ERROR_GROWTH = 1.1  # times the error of a trial in the fit that knows it: beyond, its initial state is fitted again


def folds(bench: Workbench) -> list[tuple[int, ...]]:
    """Indices of the trials that are left out together.

    Trials of one kind (locked joints, tip, tilt, leg) are distributed over the folds, so that no fold takes all of
    a kind with several. Pieces of one recording stay together, unless it is the only one.
    """
    groups: dict[int, list[int]] = {}
    for index, trial in enumerate(bench.trials):
        groups.setdefault(id(trial.whole), []).append(index)
    together = list(groups.values()) if len(groups) > 1 else [[index] for index in range(len(bench.trials))]
    kinds: dict[object, list[list[int]]] = {}
    for group in together:
        kinds.setdefault(bench.trials[group[0]].kind, []).append(group)
    dealt = [group for kind in kinds.values() for group in kind]
    count = min(len(dealt), MOST_FOLDS)
    return [tuple(sorted(index for group in dealt[k::count] for index in group)) for k in range(count)]


def errors_on_unseen_trials(bench: Workbench, fits: Sequence[EvaluatedHypothesis]) -> list[TrialErrors]:
    """The error of each fit, refitted without each fold, on the trials of that fold.

    Raises
    ------
    ValueError : there is only one trial.
    """
    if len(bench.trials) < 2:
        raise ValueError("a single trial leaves none for validation")
    parts = folds(bench)
    framed = [fit if fit.frame is not None else replace(fit, frame=bench.frame(fit)) for fit in fits]
    begin = {"damping": FIRST_DAMPING, "done": False}
    given = [{f.name: getattr(fit, f.name) for f in fields(fit)} | begin for fit in framed]  # not what it has cached
    start = [FitWithoutFold(**each, out=out) for each in given for out in parts]
    problem = _FoldFits(bench, None, LAST_STEP_FALL)
    begun = [Iterate[EvaluatedHypothesis](evaluated_without_fold(bench, fit), fit.damping) for fit in start]
    ends = [iterate.point for iterate in minimise(problem, begun, DAMPING_RULE, FOLD_ITERATIONS)]
    made = []
    for place in range(len(fits)):
        own = ends[place * len(parts) : (place + 1) * len(parts)]
        left = {index: fit for fit in own for index in _as_fit_without_fold(fit).out}
        errors = errors_by_trial(bench, _residuals_from_best_states(bench, fits[place], left))
        by_fold = np.array([fit.unknowns for fit in own])
        refitted = np.array([left[i].unknowns for i in range(len(bench.trials))])
        made.append(replace(errors, by_fold=by_fold, refitted=refitted))
    return made


def _residuals_from_best_states(
    bench: Workbench, fit: EvaluatedHypothesis, left: Mapping[int, EvaluatedHypothesis]
) -> list[Array]:
    """(M,) whitened residual of every trial by the fit ``left`` of it that does not know it.

    The state is fitted again where the error grew by more than ``ERROR_GROWTH`` over that of ``fit``, which knows the
    trial; not for hypotheses that add links to those of the designed leg: with two more numbers a link in each trial
    they follow what they do not explain.
    """
    kept: dict[int, PredictorCache] = {}

    def residual(index: int) -> Array:
        own, trial = left[index], bench.trials[index]
        more_links = any(c.links > c.replaced_links for c in own.hypothesis)
        known, found = fit.residuals[index], own.residuals[index]
        if not float(found @ found) > ERROR_GROWTH**2 * float(known @ known) or more_links:
            return found
        again = from_state(bench, own, trial, kept.setdefault(id(own), {}), own.states[index])
        return again if float(again @ again) < float(found @ found) or not np.isfinite(found).all() else found

    return bench.in_parallel(residual, len(bench.trials))


def errors_by_trial(bench: Workbench, residuals: Sequence[Array]) -> TrialErrors:
    """Errors trial by trial from whitened residuals, one array per trial."""
    each = bench.in_parallel(lambda i: block_errors(bench, i, residuals[i]), len(bench.trials))
    return TrialErrors(*(np.array(column) for column in zip(*each, strict=True)))


def with_unseen_errors(
    bench: Workbench, found: Hypotheses[EvaluatedHypothesis], calibration: Calibration
) -> Hypotheses[EvaluatedHypothesis]:
    """The hypotheses with their errors by trial, of the leading ones also those of unseen trials.

    Leading are single causes of the lowest cost, and of each size the sets that the odds prefer. Unchanged if there is
    only one trial.
    """
    if len(bench.trials) < 2:
        return found

    def seen(item: Assessment[EvaluatedHypothesis]) -> Assessment[EvaluatedHypothesis]:
        return replace(item, seen=errors_by_trial(bench, item.fit.residuals))

    none, singles, several = seen(found.none), [*map(seen, found.singles)], [*map(seen, found.several)]
    preferred = in_order_of_odds([none, *singles, *several], calibration)
    sizes = {len(item.keys) for item in several}
    leading = [item for size in sizes for item in [s for s in preferred if len(s.keys) == size][:SETS_A_SIZE]]
    items = [none, *singles[:MOST_SINGLES], *leading]
    left = {
        id(item): each
        for item, each in zip(items, errors_on_unseen_trials(bench, [item.fit for item in items]), strict=True)
    }

    def judged(item: Assessment[EvaluatedHypothesis]) -> Assessment[EvaluatedHypothesis]:
        return replace(item, unseen=left.get(id(item)))

    return Hypotheses(judged(none), tuple(map(judged, singles)), tuple(map(judged, several)))


def jackknife(each: Array) -> Array:
    """(p,) standard deviation of unknowns (n_fold, p), each without one fold (Efron 1982, chapter 3).

    Widened by Student's distribution at 90 %, because few folds determine their own spread poorly.
    """
    count = len(each)
    widened = student95(count - 1) / NORMAL90
    return np.asarray(widened * np.sqrt((count - 1) / count * np.sum((each - each.mean(axis=0)) ** 2, axis=0)))


@dataclass(frozen=True)
class _FoldFits(HypothesisFits):
    """Fits that each leave a fold out."""

    def evaluate(self, points: Sequence[EvaluatedHypothesis]) -> list[EvaluatedHypothesis]:
        """The point as if the fold were absent."""
        return [evaluated_without_fold(self.bench, _as_fit_without_fold(fit)) for fit in self.bench.evaluate(points)]

    def normal(self, point: EvaluatedHypothesis) -> LinearisedNormal:
        """Normal equations of the trials that count; the others' states are refitted."""
        return normal_without_fold(self.bench, _as_fit_without_fold(point), point.columns)

    def damping_factors(self, point: EvaluatedHypothesis) -> tuple[float, ...]:
        """The fit is near its optimum."""
        return DAMPING_FACTORS


def _as_fit_without_fold(fit: EvaluatedHypothesis) -> FitWithoutFold:
    assert isinstance(fit, FitWithoutFold)
    return fit


def block_errors(bench: Workbench, index: int, residual: Array) -> tuple[Array, Array, float]:
    """Mean squares by blocks of time, their samples, and the number of independent errors of a trial."""
    trial = bench.trials[index]
    where = trial.counts
    scale = np.broadcast_to(bench.tempering(trial), where.shape)
    floors = np.zeros(where.shape)
    noise = np.broadcast_to(bench.noise, where.shape)[where]
    floors[where] = bounded_residual(residual[: where.sum()] * scale[where], noise)
    counts = np.array([part.sum() for part in np.array_split(where, BLOCKS_A_TRIAL)], dtype=float)
    squares = np.array([part.sum() for part in np.array_split(floors**2, BLOCKS_A_TRIAL)]) / np.maximum(counts, 1.0)
    channels = [floors[where[:, j], j] for j in trial.free if where[:, j].any()]
    return squares, counts, sum(independent_errors(channel, trial.share * bench.effective) for channel in channels)
