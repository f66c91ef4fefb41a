"""Springs and dampers of all joints chosen together, for the response of the whole leg as its parts may come.

At each joint every damper goes with every spring that meets the constraints for the rate that suits that damper; a set
is one such pair a joint. The sets that move the leg most nearly as wanted with nominal parts are found first
(``part_search``) and then judged with their tolerances (``forecast``), the springs' free angles measured and set: the
one with the least expected error is chosen. No exchange of one part that is listed beside it is better
(``part_swaps``).
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from synth.design.choose_dampers import DamperChoiceMade, DamperOption
from synth.design.choose_springs import SpringChoiceMade, SpringOption, SpringSource, sense_warning, spring_options
from synth.design.forecast import Forecast, damper_tolerance, spring_tolerance
from synth.design.judged_sets import SAMPLES_CHOSEN, SAMPLES_SHOWN, Judge, Pair, Pairs, acting
from synth.design.part_lanes import PartLanes
from synth.design.part_search import FoundSets, best_sets
from synth.design.part_swaps import JointParts, Swaps, without_better_swap
from synth.design.response import WantedResponse
from synth.errors import CannotBeHad, UserError
from synth.files.project_options import PartsOptions
from synth.swing.leg_model import Leg
from synth.units import quantity

DAMPERS = 8  # a joint that take part, the best by themselves first
PAIRS = 400  # spring and damper pairs a joint that are looked at
MOST_SETS = 4_000_000  # sets screened at most; a million take 4 s of a processor (`make bench`)
FINALISTS = 16  # sets that are judged with their tolerances
SHOWN = 8  # of these, with more samples
SAMPLES_FINAL = 32  # draws of the tolerances that rank the finalists
SAME_RATE = 1e-3  # relative: two wanted rates this near give the same springs

Option = TypeVar("Option", SpringOption, DamperOption)


@dataclass(frozen=True)
class PartSet:
    """A pair for each joint, their nominal error over all releases (rad) and what is to be expected of them.

    ``ready`` is of springs whose free angles were measured and set; ``forecast`` of parts as they come, and the same as
    ``ready`` in a set that only serves the next round.
    """

    pairs: Pairs
    error: float
    forecast: Forecast
    ready: Forecast

    @property
    def labels(self) -> tuple[tuple[str, str], ...]:
        """Spring and damper of each joint, in words."""
        return tuple((pair.spring.label, pair.damper.label) for pair in self.pairs)

    def as_json(self, names: Sequence[str], chosen: PartSet) -> dict[str, Any]:
        """Parts by joint, predicted errors and what the set costs against the chosen one."""
        return {
            "parts": {
                name: {"spring": pair.spring.label, "damper": pair.damper.label}
                for name, pair in zip(names, self.pairs, strict=True)
            },
            "rms": quantity(self.error, "deg"),
            **self.forecast.as_json(),
            "free_angles_measured": self.ready.as_json(),
            "cost": quantity(self.ready.expected - chosen.ready.expected, "deg"),
        }


@dataclass(frozen=True)
class SetsMade:
    """The chosen set, the best others, how they were found, and what may stand in for each part.

    ``springs`` and ``dampers`` are the same choice joint by joint; ``leg`` is the leg with the chosen set.
    """

    sets: tuple[PartSet, ...]
    found: FoundSets
    leg: Leg
    springs: SpringChoiceMade
    dampers: DamperChoiceMade
    cut: tuple[int, ...]  # pairs a joint that were left out because they are worst by themselves
    legs: tuple[Leg, ...]  # with each of ``sets``

    @property
    def chosen(self) -> PartSet:
        """The set that is taken."""
        return self.sets[0]

    @property
    def measured(self) -> Forecast:
        """Of the chosen set once its springs' free angles are measured and set."""
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
    """Choose springs and dampers together.

    Parameters
    ----------
    fitted
        the leg with the chosen dampers and the spring rates that were fitted with them.
    dampers
        ranked dampers of each joint, each with the spring that suits it; ``dampers.leg`` has the springs that suit the
        chosen ones together.
    sources
        where each joint's springs come from.
    barred
        dampers, by their labels, that may not stand together.
    swaps
        whether each part of the best set is held against what may stand in for it; False: the best set as it is found,
        for a round that is to be followed by another.

    Raises
    ------
    UserError : a joint asks for a bought spring and none meets its constraints, or every set is barred.
    """
    joints = [_joint_parts(source, j, fitted, dampers) for j, source in enumerate(sources)]
    lanes = PartLanes(wanted, fitted, [acting(each.pairs) for each in joints])
    pairs, cut = _cut(lanes, [list(each.pairs) for each in joints])
    lanes = PartLanes(wanted, fitted, [acting(each) for each in pairs])
    found = best_sets(lanes, [0] * len(pairs), FINALISTS, seed=seed)
    judge = Judge(wanted, fitted, parts, seed, barred)
    sets = _judged(judge, [tuple(o[k] for o, k in zip(pairs, row, strict=True)) for row in found.index])
    if not swaps:
        return _as_found(sets[:1], found, judge, joints, dampers, cut)
    best, table = without_better_swap(judge, sets[0].pairs, joints)
    chosen = PartSet(
        best,
        float(judge.errors([best])[0]),
        judge.as_they_come(best, SAMPLES_CHOSEN, shares=True),
        judge.ready(best, SAMPLES_CHOSEN, shares=True),
    )
    others = [item for item in sets if item.labels != chosen.labels][: SHOWN - 1]
    sets = (chosen, *(replace(item, forecast=judge.as_they_come(item.pairs)) for item in others))
    leg = judge.built(best)
    return SetsMade(
        sets,
        found,
        leg,
        _springs_made(chosen, table, joints, leg),
        _dampers_made(chosen, table, dampers, leg),
        cut,
        tuple(judge.built(item.pairs) for item in sets),
    )


def _as_found(
    sets: tuple[PartSet, ...],
    found: FoundSets,
    judge: Judge,
    joints: Sequence[JointParts],
    dampers: DamperChoiceMade,
    cut: tuple[int, ...],
) -> SetsMade:
    """The best set, with nothing that could stand in its parts' place."""
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
    """The dampers chosen by themselves, each with the spring nearest to the rate that was fitted with it.

    What stands in for a part is not looked at.

    Raises
    ------
    UserError : a joint asks for a bought spring and none meets its constraints.
    """
    pairs, reasons, said = [], [], []
    for joint, source, damper in zip(fitted.joints, sources, dampers.chosen, strict=True):
        assert joint.spring is not None
        options, left_out, words = spring_options(source, joint.spring.rate)
        pairs.append(Pair(options[0], damper))
        reasons.append(left_out)
        said.append(tuple(words))
    judge, chosen = Judge(wanted, fitted, parts, seed), tuple(pairs)
    error, leg = judge.errors([chosen]), judge.built(chosen)
    forecast = judge.ready(chosen, SAMPLES_FINAL)
    one = PartSet(chosen, float(error[0]), forecast, forecast)
    found = FoundSets(np.zeros((1, len(pairs)), dtype=np.int64), error, 1, 1, None, False)
    springs = tuple(pair.spring for pair in pairs)
    made = SpringChoiceMade(springs, tuple((spring,) for spring in springs), tuple(reasons), leg, tuple(said))
    return SetsMade((one,), found, leg, made, replace(dampers, leg=leg), (0,) * len(pairs), (leg,))


def _joint_parts(source: SpringSource, joint: int, fitted: Leg, dampers: DamperChoiceMade) -> JointParts:
    """Every damper with the springs for the rates that suit it: by itself, and of the chosen one also by the fit.

    Reasons and words are those of the chosen damper's fitted rate.
    """
    spring, together = fitted.joints[joint].spring, dampers.leg.joints[joint].spring
    assert spring is not None
    chosen = dampers.chosen[joint]
    springs, reasons, said = spring_options(source, spring.rate)
    known = {chosen.label: springs}
    for rate in (item.rate for item in (together, chosen.spring) if item is not None):
        _add_springs(known[chosen.label], source, rate)
    others = [option for option in dampers.ranked[joint] if option.label != chosen.label][: DAMPERS - 1]
    for damper in others:
        assert damper.spring is not None
        _add_springs(known.setdefault(damper.label, []), source, damper.spring.rate)
    pairs = [Pair(spring, damper) for damper in (chosen, *others) for spring in known[damper.label]]
    said = [*said, *sense_warning(source.joint, source.turned)]
    by_label = {label: tuple(found) for label, found in known.items()}
    return JointParts(source, spring.rate, (chosen, *others), by_label, tuple(pairs[:PAIRS]), reasons, tuple(said))


def _add_springs(known: list[SpringOption], source: SpringSource, rate: float) -> None:
    """Add the springs for another wanted rate; a rate for which none can be bought, where one must be, adds none.

    One spring to wind is enough: its rate is moved to where it suits best when a set is chosen.
    """
    if any(abs(option.asked / rate - 1.0) < SAME_RATE for option in known):
        return
    bought = {(option.part, option.count) for option in known if option.row is not None}
    wound = any(option.row is None for option in known)
    with suppress(UserError):
        known += [
            option
            for option in spring_options(source, rate)[0]
            if (not wound if option.row is None else (option.part, option.count) not in bought)
        ]


def _cut(lanes: PartLanes, pairs: list[list[Pair]]) -> tuple[list[list[Pair]], tuple[int, ...]]:
    """At most ``MOST_SETS`` sets: of each joint the pairs that are best with the first pair of the other joints."""
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


def _judged(judge: Judge, sets: Sequence[Pairs]) -> tuple[PartSet, ...]:
    """The finalists with their tolerances, least expected error first; those that are shown with more samples."""
    sets = [pairs for pairs in sets if judge.allows(pairs)]
    if not sets:
        raise CannotBeHad("with none of the best sets of dampers can the leg be fitted to the motion")
    errors = judge.errors(sets)
    shown = list(range(len(sets)))
    if len(sets) > SHOWN:
        rough = {k: judge.expected(sets[k], SAMPLES_FINAL) for k in shown}
        shown = sorted(shown, key=lambda k: (rough[k], k))[:SHOWN]
    fine = {k: judge.ready(sets[k], SAMPLES_SHOWN) for k in shown}
    order = sorted(fine, key=lambda k: (fine[k].expected, k))
    return tuple(PartSet(sets[k], float(errors[k]), fine[k], fine[k]) for k in order)


def _springs_made(chosen: PartSet, table: Swaps, joints: Sequence[JointParts], leg: Leg) -> SpringChoiceMade:
    """The chosen springs and what could be had in the place of each, by what it costs in response."""
    taken = [replace(p.spring, error=chosen.error, expected=table.chosen) for p in chosen.pairs]
    ranked = [
        _by_error([own, *(replace(s.pair.spring, error=s.error, expected=s.expected) for s in swaps)])
        for own, swaps in zip(taken, table.springs, strict=True)
    ]
    left_out, said = tuple(each.left_out for each in joints), tuple(each.warnings for each in joints)
    return SpringChoiceMade(tuple(taken), tuple(ranked), left_out, leg, said)


def _dampers_made(chosen: PartSet, table: Swaps, dampers: DamperChoiceMade, leg: Leg) -> DamperChoiceMade:
    """The chosen dampers and what could be had in the place of each, with the spring that then goes best with it."""
    taken = [replace(p.damper, error=chosen.error, expected=table.chosen) for p in chosen.pairs]
    ranked = []
    for j, (own, swaps) in enumerate(zip(taken, table.dampers, strict=True)):
        held = chosen.pairs[j].spring
        others = [
            replace(
                swap.pair.damper,
                error=swap.error,
                expected=swap.expected,
                partner=_partner(swap.pair.spring, held),
            )
            for swap in swaps
        ]
        ranked.append(_by_error([own, *others]))
    return replace(dampers, chosen=tuple(taken), ranked=tuple(ranked), leg=leg)


def _partner(spring: SpringOption, held: SpringOption) -> str:
    """The spring that goes with another damper, empty where it is the one that is chosen."""
    if spring.label == held.label and abs(spring.rate / held.rate - 1.0) < SAME_RATE:
        return ""
    return spring.label if spring.row is not None else f"{spring.label}, {spring.rate:.4g} N*m/rad"


def _by_error(options: list[Option]) -> tuple[Option, ...]:
    return tuple(sorted(options, key=lambda option: (option.expected, option.error)))


def tolerance_json(parts: PartsOptions, chosen: PartSet, joint: int) -> dict[str, Any]:
    """What one joint's parts are reckoned to keep to, and on whose word."""
    pair = chosen.pairs[joint]
    spring, damper = spring_tolerance(pair.spring, parts.tolerance), damper_tolerance(pair.damper, parts.tolerance)
    return {
        "rate": quantity(spring.rate, "percent"),
        "free_angle": quantity(spring.free_angle, "deg"),
        "torque": quantity(damper.torque, "percent"),
        "spring_source": spring.source,
        "damper_source": damper.source,
    }
