"""The search for causes of any plant: none, each alone, then two or three if fewer leave a remainder.

The fit of a cause is plant-specific (``Explorer``): the residuals of a swing are almost linear in
the unknowns, so thousands of starts share a linearisation; those of a jump are not, so each fit has its own.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

from synth.diagnosis.hypotheses import Assessment, FittedHypothesis, Hypotheses, Key


class ExploredFit(FittedHypothesis, Protocol):
    """A hypothesis fitted to trials."""

    @property
    def cost(self) -> float:
        """Cost of the fitted trials, with the priors; infinite if the motion diverged."""

    @property
    def keys(self) -> tuple[Key, ...]:
        """Effect and place of each cause."""


F = TypeVar("F", bound=ExploredFit)

# RMS of a pair over that of the best one up to which it acts alike: as ``verdict.RIVAL_RATIO`` of sets that differ in
# one cause. An armature at the first joint acts as its link's inertia, and leaves 0.2 % more, with a number less.
ALIKE_RATIO = 1.05


@dataclass(frozen=True)
class SearchPlan:
    """Conditions for searching further causes.

    ``anchors`` : single causes used in pairs; ``anchor_pairs`` : pairs that are extended by a third cause;
    ``alike_pairs`` : pairs that act as the best of them does, tried in its place beside the third causes that it gets;
    ``anchors_found`` : causes of the best pairs and triples that are used in pairs too, though weak alone.
    ``worth`` : least cost reduction of the best single cause. ``satisfied``, ``well`` : RMS over the noise floor, and
    ``least_left`` : share of the squared gap, see ``leaves``. ``pays`` : share of the remainder that a second cause
    must remove before a third is tried. ``per_parameter`` : penalty per unknown when ranking a cause against
    a simpler one.
    """

    anchors: int
    anchor_pairs: int
    worth: float
    satisfied: float
    well: float
    least_left: float
    pays: float
    per_parameter: float = 0.0
    anchors_found: int = 0
    alike_pairs: int = 0

    def first(self, singles: Sequence[Assessment[F]]) -> list[Assessment[F]]:
        """Single causes used in pairs."""
        return sorted(singles, key=lambda single: single.cost + self.per_parameter * single.n_unknown)[: self.anchors]

    def leaves(self, found: Assessment[F], none: Assessment[F]) -> bool:
        """Whether a hypothesis leaves enough for a further cause: more than the difference between similar effects."""
        gap, left = none.ratio**2 - 1.0, found.ratio**2 - 1.0
        return found.ratio > self.well or (found.ratio > self.satisfied and left > self.least_left * gap > 0.0)

    def paid(self, found: Assessment[F], fewer: Assessment[F]) -> bool:
        """Whether one further cause removes so much that yet another may help."""
        return found.ratio**2 - 1.0 < (1.0 - self.pays) * (fewer.ratio**2 - 1.0)


class Explorer(Protocol[F]):
    """The fits of one plant, as used by the search."""

    plan: SearchPlan

    def none(self) -> F:
        """The nominal leg's best fit within the tolerances."""

    def singles(self) -> Sequence[F]:
        """The best fit of each cause alone; called after ``none``."""

    def beside(self, anchors: Sequence[Assessment[F]], singles: Sequence[Assessment[F]]) -> Sequence[F]:
        """Fits of one further cause with each of the anchors, and of sets of these; ``singles`` in order of cost."""

    def alone(self, sets: Sequence[Assessment[F]], singles: Sequence[Assessment[F]]) -> Sequence[F]:
        """Fits of single causes of the best of these ``sets``, in order of cost, that are better than in ``singles``.

        The fit of a strong cause may end in another minimum, and what is needed beside it is then only a way around.
        """

    def in_place(
        self, pair: Assessment[F], alike: Sequence[Assessment[F]], sets: Sequence[Assessment[F]]
    ) -> Sequence[F]:
        """Fits of the best of these ``sets``, in order of cost, with a pair that acts ``alike`` in place of theirs."""

    def ratio(self, fit: F) -> float:
        """RMS of a fit's residuals over the noise floor, all samples weighted equally."""

    def at_limits(self, fit: F) -> bool:
        """Whether a tolerance of a fit ends at the limit of its search."""


@dataclass(frozen=True)
class CauseSearch(Generic[F]):
    """One search: a plant's fits in the order of their dependence."""

    explorer: Explorer[F]
    say: Callable[[str], None]

    def run(self, n_cause: int) -> Hypotheses[F]:
        """Find how well each of ``n_cause`` causes, and each promising combination, explains the trials."""
        plan = self.explorer.plan
        self.say("the nominal leg within its tolerances")
        none = self._assess_fits([self.explorer.none()])[0]
        self.say(f"{n_cause} single causes")
        singles = self._assess_fits(self.explorer.singles())
        several: list[Assessment[F]] = []
        clear = bool(singles) and none.cost - singles[0].cost > plan.worth
        if clear and self._pulled(singles[0], none):
            self.say("pairs with the best cause")
            several = self._assess_fits(self.explorer.beside(singles[:1], singles))
        elif clear and plan.leaves(singles[0], none):
            self.say("pairs of causes")
            first = plan.first(singles)
            pairs = self._assess_fits(self.explorer.beside(first, singles))
            singles = self._with_causes_alone(pairs, singles)
            several = self._extend_by_third_cause(pairs, none, singles)
            found = _singles_found_in_sets(several, first, singles)[: plan.anchors_found]
            if found and plan.leaves(singles[0], none):
                self.say("pairs with causes found beside others")
                pairs = self._assess_fits(self.explorer.beside(found, singles))
                singles = self._with_causes_alone(pairs, singles)
                if pairs and pairs[0].cost < min(item.cost for item in several if len(item.keys) == 2):
                    pairs = self._extend_by_third_cause(pairs, none, singles)
                several = _best_assessed([*several, *pairs])
        return Hypotheses(none, tuple(singles), tuple(sorted(several, key=lambda a: a.cost)))

    def _pulled(self, found: Assessment[F], none: Assessment[F]) -> bool:
        """Whether a hypothesis leaves too little for a further cause to be named, but more than the noise, at limits.

        A number beyond its tolerance then pulls on those of the cause, which a further cause beside it shows.
        """
        plan = self.explorer.plan
        return not plan.leaves(found, none) and found.ratio > plan.satisfied and self.explorer.at_limits(found.fit)

    def _with_causes_alone(
        self, sets: Sequence[Assessment[F]], singles: Sequence[Assessment[F]]
    ) -> list[Assessment[F]]:
        """The single causes, those that were found better beside others in place of what their own search found."""
        better = self._assess_fits(self.explorer.alone(sets, singles))
        keys = {item.keys for item in better}
        return sorted([*better, *(item for item in singles if item.keys not in keys)], key=lambda item: item.cost)

    def _extend_by_third_cause(
        self, pairs: list[Assessment[F]], none: Assessment[F], singles: Sequence[Assessment[F]]
    ) -> list[Assessment[F]]:
        """Pairs in order of cost, with the best of them extended by a third cause where that may help."""
        plan, promising = self.explorer.plan, pairs[: self.explorer.plan.anchor_pairs]
        if not promising or not plan.leaves(promising[0], none):
            return pairs
        if not plan.paid(promising[0], _best_single_of(promising[0], singles)):
            return pairs
        self.say("a third cause")
        found = self._assess_fits(self.explorer.beside(promising, singles))
        alike = [pair for pair in pairs[1:] if _act_alike(pair, promising[0])][: plan.alike_pairs]
        others = self._assess_fits(self.explorer.in_place(promising[0], alike, found)) if alike else []
        return _best_assessed([*pairs, *found, *others])

    def _assess_fits(self, fits: Sequence[F]) -> list[Assessment[F]]:
        """The hypotheses with their errors, in order of cost."""
        return sorted((Assessment(fit, fit.cost, self.explorer.ratio(fit)) for fit in fits), key=lambda a: a.cost)


def _act_alike(pair: Assessment[F], best: Assessment[F]) -> bool:
    """Whether a pair differs from the best one in a single cause and leaves as much."""
    return len({*pair.keys} - {*best.keys}) == 1 and pair.ratio <= ALIKE_RATIO * best.ratio


def _best_single_of(found: Assessment[F], singles: Sequence[Assessment[F]]) -> Assessment[F]:
    """The best single cause of a set; the best of all if none of its causes was fitted alone."""
    return next((single for single in singles if set(single.keys) <= set(found.keys)), singles[0])


def _singles_found_in_sets(
    several: Sequence[Assessment[F]], first: Sequence[Assessment[F]], singles: Sequence[Assessment[F]]
) -> list[Assessment[F]]:
    """Single causes of the best pair and the best triple that were not used in pairs yet, best first."""
    best = [min(size, key=lambda item: item.cost) for n in (2, 3) if (size := [s for s in several if len(s.keys) == n])]
    used, wanted = {item.keys for item in first}, {key for item in best for key in item.keys}
    return [single for single in singles if single.keys[0] in wanted and single.keys not in used]


def _best_assessed(items: Sequence[Assessment[F]]) -> list[Assessment[F]]:
    """The best of each set of causes, in order of cost."""
    best: dict[frozenset[Key], Assessment[F]] = {}
    for item in sorted(items, key=lambda item: item.cost):
        best.setdefault(frozenset(item.keys), item)
    return list(best.values())


def best_of_each(fits: Sequence[F]) -> list[F]:
    """The best fit of each set of causes, in order of cost, without diverged ones."""
    best: dict[frozenset[Key], F] = {}
    for fit in fits:
        keys = frozenset(fit.keys)
        if keys not in best or fit.cost < best[keys].cost:
            best[keys] = fit
    return sorted((fit for fit in best.values() if fit.cost < float("inf")), key=lambda fit: fit.cost)
