"""Search of causes on trials of angles, called by ``synth.diagnosis.search``.

Thousands of starts share one linearisation and a few thinned trials; the most promising continue with all trials. A
cause that only shows together with another one (dry friction of a tenth of the torque beside a shifted encoder) fits
badly alone. Every candidate is therefore tried again beside the best single causes, with the tolerances, the initial
states and the unknowns of the other cause free.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from synth.arrays import Array
from synth.diagnosis.effect_shape import ShapedEffect
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.further_cause import LEAST_COST_REDUCTION, fit_further_cause, start_for_all_trials
from synth.diagnosis.hypotheses import Assessment, Hypotheses, Key
from synth.diagnosis.odds import Calibration, price_of_unknown
from synth.diagnosis.other_shapes import starts_in_other_shapes
from synth.diagnosis.restarts import (
    LEAST_COST_APART,
    descend,
    exchange_fits,
    fit_from_best,
    has_other_minima,
    refine,
    refit_from_design,
)
from synth.diagnosis.score import first_state, fresh, score
from synth.diagnosis.screened_causes import same_shape, screen_causes
from synth.diagnosis.search import CauseSearch, SearchPlan, best_of_each
from synth.diagnosis.search_limits import tolerances_at_limits
from synth.diagnosis.sets_of_causes import (
    from_recorded_states,
    pairs_of,
    with_pair_replaced,
    with_simpler_cause,
    without_one_cause,
)
from synth.diagnosis.sifting import Sifting
from synth.diagnosis.simpler_shapes import cost_with_unknowns, prefer_simpler_shapes
from synth.diagnosis.workbench import Workbench

# Renewals of the derivatives of the nominal leg, from which all candidates start, and steps with each. A cost, a
# log-likelihood, that falls by 0.1 moves no unknown by a half of its deviation.
BASE_FRAMES, BASE_STEPS, BASE_GAIN = 5, 2, 0.1
SAME_START_SHARE = 0.05  # of the largest motion: where initial rotations are nearer, one screening suffices
FITTED_BEFORE_REFINING = 16  # of those, number fitted before the best are refined
REFINED_SINGLES = 6  # single causes that get their own derivatives
REFINED_OTHER_STRENGTHS = 3  # fits of these causes at another strength that get their own derivatives too
RICHER_CAUSES, REFINED_RICHER = 3, 4  # causes screened in richer shapes; fits of these that get their own derivatives
REFINED_SETS = 4  # sets of several causes that get their own derivatives: what acts alike must be compared alike
# A second and a third cause
STARTS_OF_OTHER_SHAPE = 2  # of each other shape of a cause in these sets that are continued
SETS_REDUCED = 3  # best sets of three causes of which one is left out again
SETS_EXCHANGED = 3  # best sets of three causes in which a pair that acts alike takes the place of theirs
# The same where recordings are compared in pieces: their cost has cliffs, and a rank after few steps tells less.
SETS_TRIED_IN_PIECES, SETS_FITTED_IN_PIECES = 30, 10
RENEWALS_OF_SETS = 24  # most renewals of the derivatives: a pair of strong causes moves far, a little at a time
EXPLAINED_RATIO = 1.2  # RMS over the noise floor that leaves nothing to explain
# The same for a shape that counts only where it explains the trials. On a double pendulum of which every cause leaves
# tens of floors, friction that creeps fitted better alone, and worse beside what the other half of the trials shows.
NEARLY_EXPLAINED_RATIO = 2.0
SEARCH_PLAN = SearchPlan(
    anchors=4,
    anchor_pairs=1,
    worth=LEAST_COST_REDUCTION,
    satisfied=1.05,
    well=EXPLAINED_RATIO,
    least_left=0.003,
    pays=0.4,
    anchors_found=2,
    alike_pairs=2,
)  # without the price of an unknown, which is the calibration's


def as_designed(bench: Workbench) -> EvaluatedHypothesis:
    """The nominal leg unchanged, with each trial's initial state estimated; with derivatives."""
    fit = EvaluatedHypothesis((), np.zeros(bench.n_tolerance), ())
    fit = bench.evaluate([fit.start_at(states=[state for _, state in score(bench, fit, bench.trials)])])[0]
    return replace(fit, frame=bench.frame(fit))


def as_recorded(bench: Workbench) -> EvaluatedHypothesis:
    """The nominal leg unchanged, from the initial states that the first samples show; with derivatives.

    All candidates start here. They also start from the fitted initial states (``as_designed``) if the initial rotations
    of the two differ by more than ``SAME_START_SHARE`` of the motion. Both are needed: if a strong cause is missing,
    the initial states that fit the nominal leg best are far from the readings (0.37 for 0.60 rad with strong dry
    friction), and no search from there finds the cause.
    """
    states = tuple(first_state(trial) for trial in bench.trials)
    fit = bench.evaluate([bench.awake(EvaluatedHypothesis((), np.zeros(bench.n_tolerance), states))])[0]
    return replace(fit, frame=bench.frame(fit))


def fit_nominal(bench: Workbench, designed: EvaluatedHypothesis) -> EvaluatedHypothesis:
    """The nominal leg's best fit within the tolerances."""
    (fit,) = refine(bench, [designed], BASE_FRAMES, BASE_GAIN, BASE_STEPS)
    return replace(fit, frame=bench.frame(fit))


def search(
    bench: Workbench,
    candidates: Sequence[ShapedEffect],
    calibration: Calibration,
    progress: Callable[[str], None] | None = None,
) -> Hypotheses[EvaluatedHypothesis]:
    """Find how well each cause, and each promising combination, explains the trials."""
    explorer = AngleExplorer(bench, candidates, calibration)
    return CauseSearch(explorer, progress or (lambda text: None)).run(len({c.key for c in candidates}))


@dataclass
class AngleExplorer:
    """Fits to trials of angles; by ``calibration`` what an unknown must explain."""

    bench: Workbench
    every: Sequence[ShapedEffect]
    calibration: Calibration
    plan: SearchPlan = field(init=False)
    _fitted_sets: set[frozenset[Key]] = field(default_factory=set)  # sets of causes fitted from the unchanged leg

    def __post_init__(self) -> None:
        self.plan = replace(SEARCH_PLAN, per_parameter=self.calibration.per_parameter)

    @cached_property
    def candidates(self) -> list[ShapedEffect]:
        """Those that are screened: all but the richer shapes."""
        return [candidate for candidate in self.every if not candidate.shape.richer]

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
        """The nominal leg's best fit within the tolerances."""
        return self._nominal

    def singles(self) -> list[EvaluatedHypothesis]:
        """Each cause alone: screened on a few trials, then fitted to all; the best get their own linearisation."""
        bench, few = self.bench, self._sifting.few
        there = EvaluatedHypothesis((), self._nominal.unknowns, tuple(self._nominal.states[i] for i in few))
        still = self._sifting.bench.evaluate([there])[0].cost
        found = [fit for start in self._screening_starts for fit in self._screened_fits(self.candidates, start, still)]
        # Again from the nominal leg's best fit, by secants: a fixed start overshoots at a fine sensor's resolution.
        again = fit_further_cause(bench, self._sifting, [self._nominal], self.candidates)
        best = best_of_each([*found, *again])
        # Of compliances all: the shared derivatives lack their links. A mount that leaves 9 floors of 54 was the 15th.
        chosen = [fit for place, fit in enumerate(best) if place < REFINED_SINGLES or _is_soft(fit)]
        rest = [fit for fit in best if all(fit is not other for other in chosen)]
        others = [*_fits_at_other_strengths(bench, chosen, found), *_fits_in_other_shapes(chosen, found)]
        refined = best_of_each(refine(bench, [*chosen, *others]))
        ends = refit_from_design(bench, refined, self._designed)
        several = has_other_minima(refined, ends, self._nominal)
        refined = best_of_each([*refined, *ends])
        if several:
            refined = best_of_each([*refined, *fit_from_best(bench, self.candidates, refined)])
            refined = exchange_fits(bench, refined[:REFINED_SINGLES], self._designed) + refined[REFINED_SINGLES:]
        return best_of_each([*self._in_preferred_shapes(self._in_richer_shapes(refined, still)), *rest])

    def _in_richer_shapes(self, refined: Sequence[EvaluatedHypothesis], still: float) -> list[EvaluatedHypothesis]:
        """The fits, the leading ones richer where the odds prefer that; ``still`` as in ``screen_causes``."""
        leading = {fit.keys[0] for fit in refined[:RICHER_CAUSES]}
        richer = [each for each in self.every if each.shape.richer and each.key in leading]
        if not richer or min(self.ratio(fit) for fit in refined) <= EXPLAINED_RATIO:
            return list(refined)
        found = [fit for start in self._screening_starts for fit in self._screened_fits(richer, start, still)]
        ends = refine(self.bench, sorted(found, key=lambda fit: fit.cost)[:REFINED_RICHER])
        ends = [
            fit for fit in ends if not fit.hypothesis[0].shape.explains or self.ratio(fit) <= NEARLY_EXPLAINED_RATIO
        ]
        rank = self._rank(refined)
        return best_of_each([min([fit, *(end for end in ends if end.keys == fit.keys)], key=rank) for fit in refined])

    def _sets_in_other_shapes(self, refined: Sequence[EvaluatedHypothesis]) -> list[EvaluatedHypothesis]:
        """The fits of several causes, each with a cause in another simple shape where the odds prefer that."""
        bench, rank = self.bench, self._rank(refined)
        if min((self.ratio(fit) for fit in refined), default=1.0) <= EXPLAINED_RATIO:
            return list(refined)
        shapes = [shape for fit in refined for shape in starts_in_other_shapes(bench, fit, self.every)]
        evaluated = iter(bench.evaluate([start for shape in shapes for start in shape]))
        begun = [
            sorted((next(evaluated) for _ in shape), key=lambda start: start.cost)[:STARTS_OF_OTHER_SHAPE]
            for shape in shapes
        ]
        ends = [*refined, *refine(bench, [start for starts in begun for start in starts], RENEWALS_OF_SETS)]
        return [min((end for end in ends if {*end.keys} == {*fit.keys}), key=rank) for fit in refined]

    @cached_property
    def _screening_starts(self) -> list[EvaluatedHypothesis]:
        """The nominal leg unchanged, from the recorded initial states, and from fitted ones where these differ."""
        recorded = as_recorded(self.bench)
        apart = [
            np.abs(one - other)[: len(self.bench.noise)].max() / max(float(np.ptp(trial.measured, axis=0).max()), 1e-9)
            for trial, one, other in zip(self.bench.trials, recorded.states, self._designed.states, strict=True)
        ]
        return [recorded, self._designed] if max(apart) > SAME_START_SHARE else [recorded]

    def _screened_fits(
        self, candidates: Sequence[ShapedEffect], start: EvaluatedHypothesis, still: float
    ) -> list[EvaluatedHypothesis]:
        """The best fits of each of the causes, screened from one start; ``still`` as in ``screen_causes``."""
        some, few = self._sifting.bench, self._sifting.few
        there = EvaluatedHypothesis((), start.unknowns, tuple(start.states[i] for i in few))
        (there,) = some.evaluate([there])
        screened = screen_causes(some, candidates, replace(there, frame=some.frame(there)), still)
        spread = self.bench.evaluate([start_for_all_trials(fit, few, start) for fit in screened])
        closer = self.bench.solve([fresh(fit) for fit in spread[:FITTED_BEFORE_REFINING]], start.frame, 2)
        return [*closer, *spread[FITTED_BEFORE_REFINING:]]

    def beside(
        self, anchors: Sequence[Assessment[EvaluatedHypothesis]], singles: Sequence[Assessment[EvaluatedHypothesis]]
    ) -> list[EvaluatedHypothesis]:
        """One further cause beside each of the anchors; the best get their own linearisation.

        Of the best sets of three, also those with one of the first two causes left out.
        """
        framed = [anchor.fit for anchor in anchors if anchor.fit.frame is not None]
        fits = [*framed, *refine(self.bench, [anchor.fit for anchor in anchors if anchor.fit.frame is None])]
        alone = all(len(fit.hypothesis) == 1 for fit in fits)  # a third cause is small: to start from the pair suffices
        if alone and self.bench.in_pieces:
            return self._sets_in_pieces(fits, [single.fit for single in singles])
        found = fit_further_cause(self.bench, self._sifting, fits, self.candidates)
        refined = self._sets_in_other_shapes(refine(self.bench, found[:REFINED_SETS], RENEWALS_OF_SETS))
        cheapest = sorted(refined, key=lambda fit: fit.cost)[:SETS_REDUCED]
        fewer = [] if alone else without_one_cause(self.bench, cheapest, fits)
        return [*refined, *found[REFINED_SETS:], *self._fits_without_one_cause(fewer, [*fits, *refined])]

    def alone(
        self, sets: Sequence[Assessment[EvaluatedHypothesis]], singles: Sequence[Assessment[EvaluatedHypothesis]]
    ) -> list[EvaluatedHypothesis]:
        """The causes of the best sets, each again from its values there; those that end in a better minimum."""
        known, fits = {single.keys: single.fit for single in singles}, [each.fit for each in sets[:SETS_REDUCED]]
        rank = self._rank([*fits, *known.values()])
        return [
            end
            for end in self._fits_without_one_cause(without_one_cause(self.bench, fits, ()), fits)
            if end.keys not in known or rank(known[end.keys]) - rank(end) > LEAST_COST_APART
        ]

    def in_place(
        self,
        pair: Assessment[EvaluatedHypothesis],
        alike: Sequence[Assessment[EvaluatedHypothesis]],
        sets: Sequence[Assessment[EvaluatedHypothesis]],
    ) -> list[EvaluatedHypothesis]:
        """The best sets of the pair and a third cause, with each of the pairs ``alike`` in place of the pair."""
        found, others = [each.fit for each in sets[:SETS_EXCHANGED]], [each.fit for each in alike]
        starts = with_pair_replaced(self.bench, found, pair.fit, others)
        return refine(self.bench, self.bench.evaluate(starts), RENEWALS_OF_SETS)

    def _fits_without_one_cause(
        self, fewer: Sequence[EvaluatedHypothesis], found: Sequence[EvaluatedHypothesis]
    ) -> list[EvaluatedHypothesis]:
        """Fits of sets that lack a cause; in pieces from the unchanged leg too, see ``_sets_in_pieces``."""
        if not self.bench.in_pieces:
            return refine(self.bench, self.bench.evaluate(fewer), RENEWALS_OF_SETS)
        starts = [*self.bench.evaluate(fewer), *[from_recorded_states(self.bench, fit) for fit in fewer]]
        return best_of_each(descend(self.bench, starts, self._rank(found)))

    def _sets_in_pieces(
        self, anchors: Sequence[EvaluatedHypothesis], singles: Sequence[EvaluatedHypothesis]
    ) -> list[EvaluatedHypothesis]:
        """The same where recordings are compared in pieces.

        An anchor's tolerances and initial states are those that imitate the cause it lacks. Sets of causes are
        therefore fitted from the unchanged leg and the recorded initial states too, each once, and all pairs of the
        best ``singles`` with them. Sets with a simpler cause in place of one are among them: the anchor is the cause
        that imitates two, and often has more unknowns than needed.
        """
        bench = self.bench
        found = fit_further_cause(
            bench, self._sifting, anchors, self.candidates, SETS_TRIED_IN_PIECES, SETS_FITTED_IN_PIECES
        )
        simpler = with_simpler_cause(bench, found, singles)
        sets = {frozenset(fit.keys): fit for fit in [*pairs_of(bench, singles[:REFINED_SINGLES]), *simpler, *found]}
        new = [fit for keys, fit in sets.items() if keys not in self._fitted_sets]
        self._fitted_sets.update(sets)
        ends = descend(bench, [from_recorded_states(bench, fit) for fit in new], self._rank([*anchors, *found]))
        best = best_of_each([*found, *ends])
        return [*refine(bench, best[:REFINED_SETS]), *best[REFINED_SETS:]]

    def _rank(self, found: Sequence[EvaluatedHypothesis]) -> Callable[[EvaluatedHypothesis], float]:
        """Cost with the unknowns charged, at the price of ``found``."""
        price = self._price(found)
        return lambda fit: cost_with_unknowns(fit, price)

    def _price(self, found: Sequence[EvaluatedHypothesis]) -> float:
        """What an unknown must take off the cost, by how far the best of the ``found`` fits is from the noise."""
        floors = min((self.ratio(fit) for fit in found), default=1.0)
        return price_of_unknown(floors, self.bench.total, self.calibration)

    def _in_preferred_shapes(self, refined: Sequence[EvaluatedHypothesis]) -> list[EvaluatedHypothesis]:
        """Fits with their own derivatives, each in the shape that the odds prefer."""
        return prefer_simpler_shapes(self.bench, refined, self.candidates, self._price(refined))

    def ratio(self, fit: EvaluatedHypothesis) -> float:
        """RMS of a fit over the noise floor."""
        return rms_over_noise(self.bench, fit)

    def at_limits(self, fit: EvaluatedHypothesis) -> bool:
        """Whether a tolerance of a fit ends at the limit of its search."""
        return tolerances_at_limits(fit.unknowns[: self.bench.n_tolerance])


def _is_soft(fit: EvaluatedHypothesis) -> bool:
    return any(candidate.is_compliance for candidate in fit.hypothesis)


def _fits_at_other_strengths(
    bench: Workbench, chosen: Sequence[EvaluatedHypothesis], found: Sequence[EvaluatedHypothesis]
) -> list[EvaluatedHypothesis]:
    """Screened fits of the chosen causes at another strength, the best few by cost.

    Where a strong cause changes the motion much (dry friction of a pendulum that turns over), no step with the
    derivatives of the designed leg may succeed: a fit that stays at its start may be near the best by chance, while one
    from elsewhere goes on to a lower cost.
    """
    best = {fit.keys: fit for fit in chosen}
    apart = [fit for fit in found if fit.keys in best and _strengths_differ(bench, fit, best[fit.keys])]
    return best_of_each(apart)[:REFINED_OTHER_STRENGTHS]


def _fits_in_other_shapes(
    chosen: Sequence[EvaluatedHypothesis], found: Sequence[EvaluatedHypothesis]
) -> list[EvaluatedHypothesis]:
    """Screened fits of the best few of the chosen causes in another shape.

    Shapes are screened with the derivatives of the designed leg, which follow a strong cause a part of the way only, so
    that a long delay may rank behind a filter that explains less. Not of compliances, of which twice as many fits are
    refined: with a state in each trial they imitate others, a mount in another shape a wrong centre of mass.
    """
    first = {fit.keys: fit for fit in chosen[:REFINED_OTHER_STRENGTHS] if not _is_soft(fit)}
    apart = [fit for fit in found if fit.keys in first and not same_shape(fit, first[fit.keys])]
    return best_of_each(apart)


def _strengths_differ(bench: Workbench, fit: EvaluatedHypothesis, other: EvaluatedHypothesis) -> bool:
    """Whether the strengths of a single cause differ by more than a factor of two, or in sign."""
    if not same_shape(fit, other):
        return False
    cause, first = fit.hypothesis[0], bench.n_tolerance
    strong = [k for k, name in enumerate(cause.shape.free) if name in cause.effect.strengths]
    one, two = ((each.unknowns[first:] - cause.absent)[strong] for each in (fit, other))
    return bool(np.any(np.abs(one - two) > 0.5 * np.maximum(np.abs(one), np.abs(two))))


def rms_over_noise(bench: Workbench, fit: EvaluatedHypothesis) -> float:
    """RMS of a fit over the noise floor, all samples weighted equally."""
    total, count = 0.0, 0
    for trial, residual in zip(bench.trials, fit.residuals, strict=True):
        scale: Array = np.broadcast_to(bench.tempering(trial), trial.counts.shape)[trial.counts]
        total += float(np.sum((residual[: len(scale)] * scale) ** 2))
        count += len(scale)
    return float(np.sqrt(total / max(count, 1)))
