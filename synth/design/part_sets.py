"""Choice of the springs and dampers of all joints together, by the response of the whole leg with tolerances.

At each joint every damper is combined with every spring that meets the constraints for the one rate that is wanted with
that damper. A set has one such pair per joint. The sets with the lowest nominal response errors
are found first (``part_search``). They are then evaluated with tolerances, the springs' free angles measured and the
seats adjusted (``forecast``). The set with the lowest expected error is chosen. No listed exchange of a single part
improves it (``part_swaps``).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, TypeVar

import numpy as np

from synth.design.choose_dampers import DamperChoiceMade, DamperOption
from synth.design.choose_springs import (
    SpringChoiceMade,
    SpringOption,
    SpringSource,
    remarks_on_bought,
    spring_options,
    with_lasting,
)
from synth.design.forecast import Forecast
from synth.design.judged_sets import SAMPLES_CHOSEN, SAMPLES_SHOWN, Judge, Pair, Pairs, acting_elements
from synth.design.link_room import LinkRoom
from synth.design.part_lanes import PartLanes
from synth.design.part_search import FoundSets, best_allowed
from synth.design.part_swaps import JointParts, Swaps, judged_again, without_better_swap
from synth.design.response import WantedResponse
from synth.design.spring_warnings import BEAR_IT, sense_warning
from synth.design.wanted_rates import springs_for, wanted_rates
from synth.errors import CannotBeHad, UserError
from synth.files.project_options import PartsOptions
from synth.remarks import decisive
from synth.swing.leg_model import Leg
from synth.units import quantity

DAMPERS = 8  # candidate dampers per joint, the best single ones first
PAIRS = 400  # candidate pairs of spring and damper per joint
MOST_SETS = 4_000_000  # sets screened at most; a million take 4 s of a processor (`make bench`)
FINALISTS = 16  # sets that are evaluated with tolerances
SETS_SHOWN = 8  # of the finalists, evaluated with more samples and listed on the page: a choice
SAMPLES_FINAL = 32  # draws of the tolerances that rank the finalists
SAME_RATE = 1e-3  # relative: two wanted rates this near give the same springs

Option = TypeVar("Option", SpringOption, DamperOption)


@dataclass(frozen=True)
class PartSet:
    """A pair for each joint, their nominal error over all releases (rad) and their forecasts.

    ``ready`` is the forecast with measured free angles and adjusted seats, ``forecast`` that with unmeasured parts. In
    a set that is only a step to the next round both are the same. ``compared``: of the chosen set, whose forecasts have
    more draws, the expected error (rad) of ``ready`` by the draws of the others.
    """

    pairs: Pairs
    error: float
    forecast: Forecast
    ready: Forecast
    compared: float | None = None

    @property
    def labels(self) -> tuple[tuple[str, str], ...]:
        """Spring and damper of each joint, as text."""
        return tuple((pair.spring.label, pair.damper.label) for pair in self.pairs)

    @property
    def expected_as_others(self) -> float:
        """Expected error (rad), angles measured, by the draws of the other sets."""
        return self.ready.expected if self.compared is None else self.compared

    def as_json(self, names: Sequence[str], chosen: PartSet) -> dict[str, Any]:
        """Parts by joint, predicted errors, and the difference of the expected error from the chosen set's."""
        return {
            "parts": {
                name: {"spring": pair.spring.label, "damper": pair.damper.label}
                for name, pair in zip(names, self.pairs, strict=True)
            },
            "rms": quantity(self.error, "deg"),
            **self.forecast.as_json(),
            "free_angles_measured": self.ready.as_json(),
            "cost": quantity(self.ready.expected - chosen.expected_as_others, "deg"),
        }


ForecastSets = tuple[tuple[PartSet, ...], tuple[Leg, ...]]


@dataclass(frozen=True)
class SetsMade:
    """The chosen set, the next best sets, the result of the search, and the substitutes for each part.

    ``springs`` and ``dampers`` are the same choice by joint; ``leg`` is the leg with the chosen set.
    """

    sets: tuple[PartSet, ...]
    found: FoundSets
    leg: Leg
    springs: SpringChoiceMade
    dampers: DamperChoiceMade
    cut: tuple[int, ...]  # number of pairs per joint that were left out, those with the largest errors on their own
    legs: tuple[Leg, ...]  # with each of ``sets``
    swaps: Swaps | None = None  # exchanges of single parts, as evaluated; None: a step to the next round
    beside: Callable[[Judge], ForecastSets] | None = None  # finds what ``shown`` adds to the chosen set
    judge: Judge | None = None  # of the forecasts that ``shown`` adds

    def shown(self) -> SetsMade:
        """With the next best sets and all forecasts, which a step to the next round does not need."""
        if self.beside is None or self.judge is None:
            return self
        sets, legs = self.beside(self.judge)
        return replace(self, sets=sets, legs=legs, swaps=None, beside=None, judge=None)

    def judged_by(self, judge: Judge, taken: Sequence[SpringOption]) -> SetsMade:
        """The same choice with its errors and those of its substitutes in another leg, before ``shown``.

        ``taken``: the chosen springs as drawn.
        """
        if self.swaps is None:
            return self
        pairs, leg = self.chosen.pairs, judge.built(self.chosen.pairs)
        table, ready = judged_again(judge, pairs, self.swaps), judge.ready(pairs, SAMPLES_CHOSEN)
        chosen = PartSet(pairs, float(judge.errors([pairs])[0]), ready, ready)
        springs = tuple(replace(option, error=chosen.error, expected=table.chosen) for option in taken)
        return replace(
            self,
            sets=(chosen,),
            leg=leg,
            springs=replace(self.springs, chosen=springs, ranked=ranked_springs(springs, table), leg=leg),
            dampers=_dampers_made(chosen, table, self.dampers, leg),
            legs=(leg,),
            swaps=table,
            judge=judge,
        )

    @property
    def added_by_tolerances(self) -> list[float]:
        """Of each of ``sets``, what tolerances add to the square of its error, angles measured, rad^2."""
        return [each.expected_as_others**2 - each.ready.nominal**2 for each in self.sets]

    @property
    def chosen(self) -> PartSet:
        """The chosen set."""
        return self.sets[0]

    @property
    def measured(self) -> Forecast:
        """Forecast of the chosen set with measured free angles and adjusted seats."""
        return self.chosen.ready


def choose_sets(
    wanted: WantedResponse,
    fitted: Leg,
    dampers: DamperChoiceMade,
    sources: Sequence[SpringSource],
    parts: PartsOptions,
    *,
    barred: frozenset[tuple[str, ...]] = frozenset(),
    seed: int = 0,
    swaps: bool = True,
) -> SetsMade:
    """Choose springs and dampers together; ``SetsMade.shown`` of the result adds the next best sets.

    Parameters
    ----------
    fitted
        the leg with the chosen dampers and the spring rates that were fitted with them.
    dampers
        ranked dampers of each joint, each with the spring tuned to it; ``dampers.leg`` has the springs tuned to the
        chosen dampers together.
    sources
        source of springs for each joint.
    barred
        combinations of dampers, by their labels, that are excluded.
    swaps
        whether the substitutes for each part of the best set are evaluated; False: the best set as found, for a round
        that is followed by another.

    Raises
    ------
    UserError : a joint requires a bought spring and none meets its constraints, or every set is excluded.
    """
    rates = wanted_rates(wanted, fitted, dampers)
    joints = [_joint_parts(source, j, rates[j], dampers) for j, source in enumerate(sources)]
    lanes = PartLanes(wanted, fitted, [acting_elements(each.pairs) for each in joints])
    pairs, cut = _cut(lanes, [list(each.pairs) for each in joints])
    lanes = lanes.of([acting_elements(each) for each in pairs])
    judge = Judge(wanted, fitted, parts, seed, barred, room=LinkRoom(sources, fitted))

    def of(row: Sequence[int]) -> Pairs:
        return tuple(options[k] for options, k in zip(pairs, row, strict=True))

    found, rows = best_allowed(lanes, FINALISTS, lambda row: judge.allows(of(row)), seed=seed)
    if not rows:  # all need longer links: the drawing says how long
        judge.room, rows = None, found.index.tolist()
    sets = _rank_finalists(judge, [of(row) for row in rows])
    if not swaps:
        return _as_found((_as_measured(judge, *sets[0]),), found, judge, joints, dampers, cut)
    best, table = without_better_swap(judge, sets[0][0], joints)
    springs = (with_lasting(p.spring, s.catalogue) for p, s in zip(best, sources, strict=True))
    best = tuple(replace(p, spring=spring) for p, spring in zip(best, springs, strict=True))
    ready = judge.ready(best, SAMPLES_CHOSEN)
    chosen, leg = PartSet(best, float(judge.errors([best])[0]), ready, ready), judge.built(best)
    return SetsMade(
        (chosen,),
        found,
        leg,
        _springs_made(chosen, table, joints, leg),
        _dampers_made(chosen, table, dampers, leg),
        cut,
        (leg,),
        table,
        partial(_with_next_best, chosen.pairs, [pairs for pairs, _ in sets]),
        judge,
    )


def _with_next_best(chosen: Pairs, found: Sequence[Pairs], judge: Judge) -> ForecastSets:
    """The chosen set and the next best ones, with every forecast that is shown of them, and the leg with each."""
    forecast, ready = (each(chosen, SAMPLES_CHOSEN, shares=True) for each in (judge.as_they_come, judge.ready))
    errors = [float(error) for sets in ([chosen], found) for error in judge.errors(sets)]
    own = PartSet(chosen, errors[0], forecast, ready, judge.expected(chosen))
    others = [item for item in map(partial(_as_measured, judge), found, errors[1:]) if item.labels != own.labels]
    others = sorted(others, key=lambda item: item.ready.expected)[: SETS_SHOWN - 1]
    shown = (own, *(replace(item, forecast=judge.as_they_come(item.pairs)) for item in others))
    return shown, tuple(judge.built(item.pairs) for item in shown)


def _as_found(
    sets: tuple[PartSet, ...],
    found: FoundSets,
    judge: Judge,
    joints: Sequence[JointParts],
    dampers: DamperChoiceMade,
    cut: tuple[int, ...],
) -> SetsMade:
    """The best set, without substitutes for its parts."""
    leg, none = judge.built(sets[0].pairs), ((),) * len(joints)
    table = Swaps(none, none, sets[0].ready.expected)
    springs, others = _springs_made(sets[0], table, joints, leg), _dampers_made(sets[0], table, dampers, leg)
    return SetsMade(sets, found, leg, springs, others, cut, (leg,))


def unjudged_set(
    wanted: WantedResponse,
    fitted: Leg,
    dampers: DamperChoiceMade,
    sources: Sequence[SpringSource],
    parts: PartsOptions,
    seed: int = 0,
) -> SetsMade:
    """The best single dampers, each with the spring nearest to the rate that is wanted with it.

    Substitutes are not evaluated.

    Raises
    ------
    UserError : a joint requires a bought spring and none meets its constraints.
    """
    pairs, reasons, warnings = [], [], []
    for rates, source, damper in zip(wanted_rates(wanted, fitted, dampers), sources, dampers.chosen, strict=True):
        options, left_out, words = springs_for(source, rates)
        pairs.append(Pair(options[0], damper))
        reasons.append(left_out)
        warnings.append(tuple(words))
    judge, chosen = Judge(wanted, fitted, parts, seed), tuple(pairs)
    error, leg = judge.errors([chosen]), judge.built(chosen)
    forecast = judge.ready(chosen, SAMPLES_FINAL)
    one = PartSet(chosen, float(error[0]), forecast, forecast)
    found = FoundSets(np.zeros((1, len(pairs)), dtype=np.int64), error, 1, 1, None, False)
    springs = tuple(pair.spring for pair in pairs)
    made = SpringChoiceMade(springs, tuple((spring,) for spring in springs), tuple(reasons), leg, tuple(warnings))
    return SetsMade((one,), found, leg, made, replace(dampers, leg=leg), (0,) * len(pairs), (leg,))


def _joint_parts(source: SpringSource, joint: int, rates: tuple[float, float], dampers: DamperChoiceMade) -> JointParts:
    """Every damper with the springs for its wanted rate; ``rates``: those of the damper chosen first."""
    chosen = dampers.chosen[joint]
    known = {chosen.label: springs_for(source, rates)[0]}
    others = [option for option in dampers.ranked[joint] if option.label != chosen.label][: DAMPERS - 1]
    for damper in others:
        assert damper.spring is not None
        with suppress(UserError):  # a bought spring is required, and none has this rate
            known.setdefault(damper.label, spring_options(source, damper.spring.rate, lasting=False)[0])
    known, spared = _without_last_resort(source, known, dampers.ranked[joint][0].label)
    pairs = [Pair(spring, damper) for damper in (chosen, *others) for spring in known.get(damper.label, [])]
    warnings = (*spared, *sense_warning(source.joint, source.turned))
    by_label = {label: tuple(found) for label, found in known.items()}
    return JointParts(source, (chosen, *others), by_label, tuple(pairs[:PAIRS]), warnings)


def _without_last_resort(
    source: SpringSource, known: dict[str, list[SpringOption]], best: str
) -> tuple[dict[str, list[SpringOption]], list[str]]:
    """Without springs that do not bear the travel, if with some damper one does; a warning if ``best`` loses all."""
    if source.choice.part is not None or all(spring.passed for found in known.values() for spring in found):
        return known, []
    kept = {label: [spring for spring in found if not spring.passed] for label, found in known.items()}
    lost = known.get(best, [])
    if not lost or kept[best]:
        return kept, []
    text = (
        f"{source.joint}: the damper that alone suits the motion best, {best}, is left out: no bought spring for it "
        f"bears the joint's travel. {lost[0].part} {lost[0].passed[0].text}"
    )
    return kept, [decisive(text, BEAR_IT)]


def _cut(lanes: PartLanes, pairs: list[list[Pair]]) -> tuple[list[list[Pair]], tuple[int, ...]]:
    """At most ``MOST_SETS`` sets: each joint's best pairs, evaluated with the first pair of every other joint."""
    most = max(2, int(MOST_SETS ** (1.0 / len(pairs))))
    kept = []
    for j, options in enumerate(pairs):
        if lanes.n_set > MOST_SETS and len(options) > most:
            index = np.zeros((len(options), len(pairs)), dtype=np.int64)
            index[:, j] = np.arange(len(options))
            order = np.sort(np.argsort(lanes.errors(index), kind="stable")[:most])
            kept.append([options[k] for k in order])
        else:
            kept.append(options)
    return kept, tuple(len(a) - len(b) for a, b in zip(pairs, kept, strict=True))


def _as_measured(judge: Judge, pairs: Pairs, error: float) -> PartSet:
    """A set with its nominal error (rad) and the forecast with measured free angles."""
    ready = judge.ready(pairs, SAMPLES_SHOWN)
    return PartSet(pairs, error, ready, ready)


def _rank_finalists(judge: Judge, sets: Sequence[Pairs]) -> list[tuple[Pairs, float]]:
    """The finalists, lowest expected error first, and their nominal errors (rad); the first ones with more samples."""
    sets = [pairs for pairs in sets if judge.allows(pairs)]
    if not sets:
        raise CannotBeHad("the fit to the motion failed with each of the best sets of dampers")
    errors = judge.errors(sets)
    shown = list(range(len(sets)))
    if len(sets) > SETS_SHOWN:
        rough = {k: judge.expected(sets[k], SAMPLES_FINAL) for k in shown}
        shown = sorted(shown, key=lambda k: (rough[k], k))[:SETS_SHOWN]
    fine = {k: judge.expected(sets[k], SAMPLES_SHOWN) for k in shown}
    return [(sets[k], float(errors[k])) for k in sorted(fine, key=lambda k: (fine[k], k))]


def _springs_made(chosen: PartSet, table: Swaps, joints: Sequence[JointParts], leg: Leg) -> SpringChoiceMade:
    """The chosen springs and the substitutes for each, by response error."""
    taken = [replace(p.spring, error=chosen.error, expected=table.chosen) for p in chosen.pairs]
    told = [remarks_on_bought(each.source, option) for each, option in zip(joints, taken, strict=True)]
    notes = tuple((*words, *each.warnings) for each, (_, words) in zip(joints, told, strict=True))
    left_out = tuple(reasons for reasons, _ in told)
    return SpringChoiceMade(tuple(taken), ranked_springs(taken, table), left_out, leg, notes)


def ranked_springs(taken: Sequence[SpringOption], table: Swaps) -> tuple[tuple[SpringOption, ...], ...]:
    """Each joint's chosen spring and its substitutes, by response error."""
    return tuple(
        _by_error([own, *(replace(s.pair.spring, error=s.error, expected=s.expected) for s in swaps)])
        for own, swaps in zip(taken, table.springs, strict=True)
    )


def _dampers_made(chosen: PartSet, table: Swaps, dampers: DamperChoiceMade, leg: Leg) -> DamperChoiceMade:
    """The chosen dampers and the substitutes for each, with the best spring for each substitute."""
    taken = [replace(p.damper, error=chosen.error, expected=table.chosen) for p in chosen.pairs]
    ranked = []
    for j, (own, swaps) in enumerate(zip(taken, table.dampers, strict=True)):
        held = chosen.pairs[j].spring
        others = []
        for swap in swaps:
            partner = _partner(swap.pair.spring, held)
            rate = swap.pair.spring.rate if partner else None
            damper = replace(swap.pair.damper, error=swap.error, expected=swap.expected)
            others.append(replace(damper, partner=partner, partner_rate=rate))
        ranked.append(_by_error([own, *others]))
    return replace(dampers, chosen=tuple(taken), ranked=tuple(ranked), leg=leg)


def _partner(spring: SpringOption, held: SpringOption) -> str:
    """Label of the spring for another damper; empty if it is the chosen one."""
    if spring.label == held.label and abs(spring.rate / held.rate - 1.0) < SAME_RATE:
        return ""
    return spring.label if spring.row is not None else f"{spring.label}, {spring.rate:.4g} N*m/rad"


def _by_error(options: list[Option]) -> tuple[Option, ...]:
    return tuple(sorted(options, key=lambda option: (option.expected, option.error)))
