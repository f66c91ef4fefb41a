"""How causes are fitted to trials of angles, as ``synth.diagnosis.search`` asks for them.

Thousands of starts share one linearisation and a few thinned trials; those that promise most go on to all trials. A
cause that shows only once another is in the model (dry friction of a tenth of the torque beside a shifted encoder) does
badly alone. So every candidate is tried again beside the best single causes, and the tolerances, the initial states and
the other cause's unknowns are free to follow.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from synth.arrays import Array
from synth.diagnosis.effect_shape import ShapedEffect
from synth.diagnosis.hypotheses import Assessed, Hypotheses
from synth.diagnosis.odds import CALIBRATED
from synth.diagnosis.score import fresh, score
from synth.diagnosis.screening import leverage, prospects, rungs, strengthened
from synth.diagnosis.search import CauseSearch, SearchPlan, best_of_each
from synth.diagnosis.workbench import EvaluatedHypothesis, Workbench
from synth.swing.chain import Conditions

BASE_ROUNDS = 5  # steps of the nominal leg, from which all candidates start
SCREEN_ROUNDS = (2, 2, 2)  # steps of all starts, of each candidate's best shapes, of those that promise something
SIFTED, SIFTED_SAMPLES = 4, 300  # trials that the first sifting uses, and samples of each
SIFTING_TOLERANCE = 1e-5  # of the integrator, while candidates are only ranked
FRAMES, CONVERGED = 8, 1.0  # times that derivatives are taken anew, until the cost falls by less
TRIED_STARTS = 3  # of each candidate
LEAST_PROMISE, LEAST_TRIED = 0.5, 40  # cost that a start must promise to take away, and number tried in any case
KEPT_SHAPES = 3  # shapes of each candidate that go on
KEPT_STARTS = 2  # of each cause, that go from the first sifting to all trials
CLOSER = 16  # of those, that are fitted there before the best are refined
PROMISING, LEAST_KEPT = 0.1, 16  # share of the best's gain after the first steps, and number, that go on
REFINED = 6  # single causes that get derivatives of their own
REFINED_FURTHER = 2  # sets of several causes that get derivatives of their own
# A second and a third cause
WORTH = 3.0  # cost that a further cause must promise to take away
SECANTS = (1.0, 12.0)  # times a start's strengths, at which the change that a cause makes is looked at
LOOKED_AT, STRENGTHS_TRIED = 16, 4  # causes that promise most by secants; of each, starts
AROUND = (0.4, 1.0)  # times the strength that the secant asks for
FURTHER_TRIED = 10  # further causes that are fitted to some of the trials, of those that promise most
FURTHER_KEPT = 5  # of those, that are fitted to all
FURTHER_ROUNDS = (2, 3)  # steps of the fit on some trials, and on all
PLAN = SearchPlan(
    anchors=4,
    anchor_pairs=1,
    worth=WORTH,
    satisfied=1.05,
    well=1.2,
    least_left=0.003,
    pays=0.4,
    per_parameter=CALIBRATED.per_parameter,
)


def as_designed(bench: Workbench) -> EvaluatedHypothesis:
    """The nominal leg to the letter, each trial's initial state estimated; with its derivatives."""
    fit = EvaluatedHypothesis((), np.zeros(bench.n_tolerance), ())
    states = tuple(state for _, state in score(bench, fit, bench.trials))
    fit = bench.evaluate([replace(fit, states=states)])[0]
    return replace(fit, frame=bench.frame(fit))


def fit_nominal(bench: Workbench, designed: EvaluatedHypothesis) -> EvaluatedHypothesis:
    """The nominal leg at its best within the tolerances."""
    fit = designed
    for _ in range(BASE_ROUNDS):
        before = fit.cost
        fit = bench.solve([fresh(fit)], None, 2)[0]
        fit = replace(fit, frame=bench.frame(fit))
        if before - fit.cost < 0.1:
            break
    return fit


def search(
    bench: Workbench, candidates: Sequence[ShapedEffect], progress: Callable[[str], None] | None = None
) -> Hypotheses[EvaluatedHypothesis]:
    """Find how well each cause, and each promising set of several, explains the trials."""
    explorer = AngleExplorer(bench, candidates)
    return CauseSearch(explorer, progress or (lambda text: None)).run(len({c.key for c in candidates}))


@dataclass
class AngleExplorer:
    """Fits to trials of angles."""

    bench: Workbench
    candidates: Sequence[ShapedEffect]
    plan: SearchPlan = PLAN

    @cached_property
    def _designed(self) -> EvaluatedHypothesis:
        return as_designed(self.bench)

    @cached_property
    def _nominal(self) -> EvaluatedHypothesis:
        return fit_nominal(self.bench, self._designed)

    @cached_property
    def _sifting(self) -> Sifting:
        return Sifting.of(self.bench)

    def none(self) -> EvaluatedHypothesis:
        """The nominal leg at its best within the tolerances."""
        return self._nominal

    def singles(self) -> list[EvaluatedHypothesis]:
        """Each cause alone: sifted on some of the trials, then fitted to all; the best get their own linearisation."""
        bench, designed, some, few = self.bench, self._designed, self._sifting.bench, self._sifting.few
        there = EvaluatedHypothesis((), self._nominal.unknowns, tuple(self._nominal.states[i] for i in few))
        screened = _screen(some, self.candidates, as_designed(some), some.evaluate([there])[0].cost)
        spread = bench.evaluate([_spread(fit, few, designed) for fit in screened])
        closer = bench.solve([fresh(fit) for fit in spread[:CLOSER]], designed.frame, 2)
        # Once more from the nominal leg at its best, by secants: a fixed start overshoots what a fine sensor sees.
        again = further(bench, self._sifting, [self._nominal], self.candidates)
        found = best_of_each([*closer, *spread[CLOSER:], *again])
        return [*_refine(bench, found[:REFINED]), *found[REFINED:]]

    def beside(
        self, anchors: Sequence[Assessed[EvaluatedHypothesis]], singles: Sequence[Assessed[EvaluatedHypothesis]]
    ) -> list[EvaluatedHypothesis]:
        """One cause more beside each of the anchors; the best get their own linearisation."""
        fits = [anchor.fit for anchor in anchors if anchor.fit.frame is not None]
        found = further(self.bench, self._sifting, fits, self.candidates)
        return [*_refine(self.bench, found[:REFINED_FURTHER]), *found[REFINED_FURTHER:]]

    def ratio(self, fit: EvaluatedHypothesis) -> float:
        """RMS of a fit over the noise floor."""
        return ratio(self.bench, fit)


def few_trials(bench: Workbench) -> list[int]:
    """Trials that the first sifting uses: one of each kind, then those that move most."""
    order = sorted(range(len(bench.trials)), key=lambda i: -float(np.ptp(bench.trials[i].measured, axis=0).max()))
    kinds: dict[Conditions, int] = {}
    for i in order:
        kinds.setdefault(bench.trials[i].recording.conditions, i)
    first = sorted(kinds.values(), key=order.index)
    return sorted([*first, *[i for i in order if i not in first]][:SIFTED])


def _spread(fit: EvaluatedHypothesis, few: Sequence[int], designed: EvaluatedHypothesis) -> EvaluatedHypothesis:
    """A fit to some of the trials with the other trials' states from the leg as designed."""
    states = list(designed.states)
    for place, i in enumerate(few):
        states[i] = fit.states[place]
    return replace(fit, states=tuple(states), residuals=(), columns=(), cost=np.inf, frame=None)


def _screen(
    bench: Workbench, candidates: Sequence[ShapedEffect], designed: EvaluatedHypothesis, still: float
) -> list[EvaluatedHypothesis]:
    """Every candidate from every start; of each cause its best shapes, in order of cost.

    ``still`` : cost of the nominal leg at its best there. From the leg as designed, not from its best fit: where a
    cause is missing the best fit lies many tolerances off, and from there the way to cause and true leg is long.
    """
    starts = [
        EvaluatedHypothesis((candidate,), np.concatenate([designed.unknowns, start]), designed.states)
        for candidate in candidates
        for start in candidate.starts()
    ]
    fits = bench.solve(_promising(bench, starts, designed), designed.frame, SCREEN_ROUNDS[0])
    fits = _gaining(fits, still, 0.3 * PROMISING, 2 * LEAST_KEPT)[0]
    kept: dict[tuple[str, str], list[EvaluatedHypothesis]] = {}
    for fit in fits:
        kept.setdefault(fit.keys[0], []).append(fit)
    chosen = [fit for group in kept.values() for fit in sorted(group, key=lambda f: f.cost)[:KEPT_SHAPES]]
    chosen = bench.solve(chosen, designed.frame, SCREEN_ROUNDS[1])
    going, rest = _gaining(chosen, still, PROMISING, LEAST_KEPT)
    fits = [*bench.solve(going, designed.frame, SCREEN_ROUNDS[2]), *rest]
    fits.sort(key=lambda fit: fit.cost)
    seen: dict[tuple[str, str], int] = {}
    best = []
    for fit in fits:
        seen[fit.keys[0]] = seen.get(fit.keys[0], 0) + 1
        if np.isfinite(fit.cost) and seen[fit.keys[0]] <= KEPT_STARTS:
            best.append(fit)
    return best


def _gaining(
    fits: Sequence[EvaluatedHypothesis], still: float, share: float, least: int
) -> tuple[list[EvaluatedHypothesis], list[EvaluatedHypothesis]]:
    """Fits that have gained at least a share of what the best has, ``least`` in any case; and the rest."""
    order = sorted(fits, key=lambda fit: fit.cost)
    wanted = share * (still - order[0].cost) if order else 0.0
    cut = max(least, sum(still - fit.cost > wanted for fit in order))
    return order[:cut], order[cut:]


def _promising(
    bench: Workbench, starts: Sequence[EvaluatedHypothesis], designed: EvaluatedHypothesis
) -> list[EvaluatedHypothesis]:
    """Of each candidate's starts, and for each the strength of a ladder, those that promise to leave least.

    A strong cause changes a swing too much for a search that begins with hardly any of it: the phase is lost.
    """
    p = bench.n_tolerance
    ladders = [rungs(start, p) for start in starts]
    left = prospects(bench, [fit for ladder in ladders for fit in ladder], designed)
    best: dict[int, list[tuple[float, EvaluatedHypothesis]]] = {}
    place = 0
    for start, ladder in zip(starts, ladders, strict=True):
        rung = int(np.argmin(left[place : place + len(ladder)]))
        best.setdefault(id(start.hypothesis[0]), []).append((left[place + rung], ladder[rung]))
        place += len(ladder)
    (alone,) = prospects(bench, [EvaluatedHypothesis((), designed.unknowns, designed.states)], designed)
    chosen = [sorted(found, key=lambda item: item[0])[:TRIED_STARTS] for found in best.values()]
    tried = sorted((item for found in chosen for item in found), key=lambda item: item[0])
    worth = max(LEAST_TRIED, sum(cost < alone - LEAST_PROMISE for cost, _ in tried))
    return bench.evaluate([fit for _, fit in tried[:worth]])


def _refine(bench: Workbench, fits: Sequence[EvaluatedHypothesis]) -> list[EvaluatedHypothesis]:
    """Fits with derivatives of their own, gone on with from where they are until they gain no more."""
    current, going = [bench.awake(fit) for fit in fits], list(range(len(fits)))
    for _ in range(FRAMES):
        framed = [replace(fresh(current[i]), frame=bench.frame(current[i])) for i in going]
        better = bench.solve(framed, None, 3)
        still = []
        for i, fit in zip(going, better, strict=True):
            if current[i].cost - fit.cost > CONVERGED:
                still.append(i)
            current[i] = fit
        going = still
        if not going:
            break
    return current


def ratio(bench: Workbench, fit: EvaluatedHypothesis) -> float:
    """RMS of a fit over the noise floor, all samples alike."""
    total, count = 0.0, 0
    for trial, residual in zip(bench.trials, fit.residuals, strict=True):
        scale: Array = np.broadcast_to(bench.tempering(trial), trial.counts.shape)[trial.counts]
        total += float(np.sum((residual[: len(scale)] * scale) ** 2))
        count += len(scale)
    return float(np.sqrt(total / max(count, 1)))


@dataclass(frozen=True)
class Sifting:
    """Some of the trials at fewer samples, to see what promises: ``few`` their places among all."""

    bench: Workbench
    few: Sequence[int]

    @classmethod
    def of(cls, bench: Workbench) -> Sifting:
        """Of some of the bench's trials, with a coarser integration."""
        few = few_trials(bench)
        trials = tuple(bench.trials[i].thinner(SIFTED_SAMPLES) for i in few)
        return cls(replace(bench, predictor=bench.predictor.coarser(SIFTING_TOLERANCE), trials=trials), few)

    def beside(self, fit: EvaluatedHypothesis) -> EvaluatedHypothesis:
        """A fit to all trials as one to these, with its derivatives."""
        here = EvaluatedHypothesis(fit.hypothesis, fit.unknowns, tuple(fit.states[i] for i in self.few))
        here = self.bench.evaluate([here])[0]
        return replace(here, frame=self.bench.frame(here))


def further(
    bench: Workbench, sifting: Sifting, anchors: Sequence[EvaluatedHypothesis], candidates: Sequence[ShapedEffect]
) -> list[EvaluatedHypothesis]:
    """Hypotheses of an anchor and one cause more, those that promise most, fitted to all trials; best first."""
    promising: dict[frozenset[tuple[str, str]], tuple[float, EvaluatedHypothesis, EvaluatedHypothesis]] = {}
    for anchor in anchors:
        here = sifting.beside(anchor)
        for left, start in _beside(sifting.bench, here, candidates):
            keys = frozenset(start.keys)
            if here.cost - left > WORTH and (keys not in promising or left < promising[keys][0]):
                promising[keys] = left, start, anchor
    best = sorted(promising.values(), key=lambda item: item[0])[:FURTHER_TRIED]
    origin = {frozenset(start.keys): anchor for _, start, anchor in best}
    fits = sifting.bench.solve([start for _, start, _ in best], None, FURTHER_ROUNDS[0])
    fits = sorted((fit for fit in fits if np.isfinite(fit.cost)), key=lambda fit: fit.cost)[:FURTHER_KEPT]
    spread = [_spread_from(fit, origin[frozenset(fit.keys)], sifting.few) for fit in fits]
    found = bench.solve(spread, None, FURTHER_ROUNDS[1])
    return sorted((fit for fit in found if np.isfinite(fit.cost)), key=lambda fit: fit.cost)


def _beside(
    bench: Workbench, here: EvaluatedHypothesis, candidates: Sequence[ShapedEffect]
) -> list[tuple[float, EvaluatedHypothesis]]:
    """Each further cause's best start beside a fit: cost that it promises, and the start.

    First by secants, a lane or two a start; then those that promise most, at the strengths that the secants ask for.
    """
    first = len(here.unknowns)
    starts = []
    for candidate in candidates:
        if candidate.stands_beside(here.hypothesis):
            plain = replace(here, hypothesis=(*here.hypothesis, candidate), residuals=(), columns=(), cost=np.inf)
            for point in candidate.starts():
                start = fresh(replace(plain, unknowns=np.concatenate([here.unknowns, point])))
                starts += [strengthened(start, first, secant) for secant in SECANTS]
    told = zip(leverage(bench, starts, here), starts, strict=True)
    order = sorted(((left, best, start) for (left, best), start in told), key=lambda item: item[0])
    chosen: dict[tuple[str, str], list[EvaluatedHypothesis]] = {}
    for left, best, start in order:
        key = start.keys[-1]
        if here.cost - left > WORTH and len(chosen.get(key, ())) < STRENGTHS_TRIED:
            chosen.setdefault(key, []).extend(strengthened(start, first, best * factor) for factor in AROUND)
    tried = [start for key in list(chosen)[:LOOKED_AT] for start in chosen[key]]
    found: dict[tuple[str, str], tuple[float, EvaluatedHypothesis]] = {}
    for left, start in zip(prospects(bench, tried, here), tried, strict=True):
        if start.keys[-1] not in found or left < found[start.keys[-1]][0]:
            found[start.keys[-1]] = left, start
    return list(found.values())


def _spread_from(fit: EvaluatedHypothesis, anchor: EvaluatedHypothesis, few: Sequence[int]) -> EvaluatedHypothesis:
    """A fit to some of the trials with the other trials' states and the derivatives from its anchor."""
    states = list(anchor.states)
    for place, i in enumerate(few):
        states[i] = fit.states[place]
    return fresh(replace(fit, states=tuple(states), residuals=(), columns=(), cost=np.inf, frame=anchor.frame))
