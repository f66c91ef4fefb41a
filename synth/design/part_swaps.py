"""Exchanges of single parts of a set, and their response errors; an exchange that improves the set is made.

An exchange changes one joint: another spring with the chosen damper, or another damper with its best spring among those
that meet the joint's constraints for that damper. Every exchange is evaluated in the same way as the set, with nominal
parts and with tolerances on the same draws. If an exchange has a lower expected error, on its own or with the springs
to wind of the other joints tuned to it, it is made, and the table is computed again. The chosen set is therefore never
worse than an entry of the table of substitutes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from synth.design.choose_dampers import DamperOption
from synth.design.choose_springs import SpringOption, SpringSource, other_springs, spring_to_wind
from synth.design.judged_sets import Judge, Pair, Pairs
from synth.errors import UserError

MOST_TUNED = 8  # dampers, best first, to which the other joints' wound springs are tuned: some 0.1 s each
MOST_SWAPS = 8  # largest number of exchanges, each to a lower expected error
WORTH = np.radians(0.002)  # least improvement of an exchange; errors of the draws and the integrator are smaller
RATE_FACTORS = (0.7, 0.85, 0.94, 0.98, 1.02, 1.06, 1.18, 1.43)  # on a wound spring's rate; these rates are tried too
SAME_RATE = 0.005  # relative: a spring wound for a rate this near is the same


@dataclass(frozen=True)
class JointParts:
    """The candidate parts of a joint.

    ``springs``: by damper label, the springs that meet the constraints for that damper. ``pairs``: all combinations of
    these. ``warnings``: whichever of them is chosen.
    """

    source: SpringSource
    dampers: tuple[DamperOption, ...]
    springs: Mapping[str, tuple[SpringOption, ...]]
    pairs: tuple[Pair, ...]
    warnings: tuple[str, ...]


@dataclass(frozen=True)
class Swap:
    """One exchange at one joint: the new pair, and the nominal and expected error (rad) of the whole leg with it."""

    pair: Pair
    error: float
    expected: float

    @property
    def allowed(self) -> bool:
        """Whether the joint's constraints allow it; a spring of another rate is listed for comparison only."""
        return not (self.pair.spring.outside or self.pair.spring.compared)


@dataclass(frozen=True)
class Swaps:
    """For each joint the exchanges of its spring and of its damper, lowest expected error first."""

    springs: tuple[tuple[Swap, ...], ...]
    dampers: tuple[tuple[Swap, ...], ...]
    chosen: float = field(default=float("nan"))  # rad, expected error of the unchanged set, on the same draws


def without_better_swap(judge: Judge, chosen: Pairs, joints: Sequence[JointParts]) -> tuple[Pairs, Swaps]:
    """The set after all exchanges that improve it, and the remaining exchanges."""
    for _ in range(MOST_SWAPS):
        chosen = _wound_to_suit(judge, chosen, joints)
        table = swaps(judge, chosen, joints)
        allowed = sorted(
            (
                (swap.expected, j, _with_pair(chosen, j, swap.pair))
                for j in range(len(joints))
                for swap in (*table.springs[j], *table.dampers[j])
                if swap.allowed and judge.allows(_with_pair(chosen, j, swap.pair))
            ),
            key=lambda item: item[:2],
        )
        better = _better(judge, allowed, table.chosen - WORTH, joints)
        if better is None:
            break
        chosen = better
    return chosen, table


def _better(
    judge: Judge, exchanged: list[tuple[float, int, Pairs]], least: float, joints: Sequence[JointParts]
) -> Pairs | None:
    """The best exchange if its expected error is below ``least`` (rad), else the first that is so with the springs of
    the other joints wound to suit it; None if there is none.

    ``exchanged``: expected error (rad), joint and set of each exchange, best first. Without the second step a set in
    which a wound spring suits one damper would hold on to that damper.
    """
    if exchanged and exchanged[0][0] < least:
        return exchanged[0][2]
    best: dict[tuple[int, str], Pairs] = {}  # springs of other rates with the same damper are wound to suit anyway
    for _, joint, pairs in exchanged:
        best.setdefault((joint, pairs[joint].damper.label), pairs)
    for (joint, _), pairs in list(best.items())[:MOST_TUNED]:
        tuned = _wound_to_suit(judge, pairs, joints, held=joint)
        if tuned is not pairs and judge.expected(tuned) < least:
            return tuned
    return None


def swaps(judge: Judge, chosen: Pairs, joints: Sequence[JointParts]) -> Swaps:
    """Every exchange of one spring or one damper of a set."""
    springs = tuple(
        _rank_swaps(
            judge,
            chosen,
            j,
            [_with_tuned_spring(judge, chosen, j, pair, p.source) for pair in _other_springs(chosen[j], p)],
        )
        for j, p in enumerate(joints)
    )
    dampers = tuple(
        _rank_swaps(judge, chosen, j, _with_other_dampers(judge, chosen, j, p)) for j, p in enumerate(joints)
    )
    return Swaps(springs, dampers, judge.expected(chosen))


def judged_again(judge: Judge, chosen: Pairs, known: Swaps) -> Swaps:
    """The same exchanges of a set, evaluated in another leg."""
    springs, dampers = (
        tuple(_rank_swaps(judge, chosen, j, [swap.pair for swap in found]) for j, found in enumerate(each))
        for each in (known.springs, known.dampers)
    )
    return Swaps(springs, dampers, judge.expected(chosen))


def _with_pair(pairs: Pairs, joint: int, pair: Pair) -> Pairs:
    return (*pairs[:joint], pair, *pairs[joint + 1 :])


def _rank_swaps(judge: Judge, chosen: Pairs, joint: int, pairs: Sequence[Pair]) -> tuple[Swap, ...]:
    sets = [_with_pair(chosen, joint, pair) for pair in pairs]
    found = [
        Swap(pair, float(error), judge.expected(one))
        for pair, error, one in zip(pairs, judge.errors(sets), sets, strict=True)
    ]
    return tuple(sorted(found, key=lambda swap: swap.expected))


def _other_springs(pair: Pair, parts: JointParts) -> list[Pair]:
    """Other springs for the chosen damper: those that meet its constraints, then others for comparison."""
    known = [s for s in parts.springs[pair.damper.label] if s is not pair.spring and not _same_but_rate(s, pair.spring)]
    # A wound spring is tuned to the set: bought ones are measured by its rate, which suits better than the fitted one.
    rate = pair.spring.asked if pair.spring.row is not None else pair.spring.rate
    others = other_springs(parts.source, rate, [pair.spring, *known])
    return [Pair(spring, pair.damper) for spring in (*known, *others)]


def _same_but_rate(one: SpringOption, other: SpringOption) -> bool:
    """Whether two springs to wind differ only in their rate."""
    return one.row is None and other.row is None and one.design is not None


def _with_other_dampers(judge: Judge, chosen: Pairs, joint: int, parts: JointParts) -> list[Pair]:
    """Each other damper with its best spring."""
    pair, found = chosen[joint], []
    for damper in parts.dampers:
        if damper.label == pair.damper.label:
            continue
        options = [Pair(spring, damper) for spring in parts.springs.get(damper.label, ())]
        if options:
            errors = judge.errors([_with_pair(chosen, joint, option) for option in options])
            found.append(_with_tuned_spring(judge, chosen, joint, options[int(np.argmin(errors))], parts.source))
    return found


def _with_tuned_spring(judge: Judge, chosen: Pairs, joint: int, pair: Pair, source: SpringSource) -> Pair:
    """The pair with a spring to wind of the rate tuned to the set with this pair; bought springs are unchanged."""
    spring = pair.spring
    if spring.row is not None:
        return pair
    rates = [spring.rate, *filter(source.winds_up, (spring.rate * factor for factor in RATE_FACTORS))]
    tried = [_with_pair(chosen, joint, replace(pair, spring=replace(spring, rate=rate))) for rate in rates]
    best = int(np.argmin(judge.errors(tried)))
    wound = _wound(source, rates[best]) if best > 0 else None
    return pair if wound is None else replace(pair, spring=replace(wound, compared=spring.compared))


def _wound_to_suit(judge: Judge, chosen: Pairs, joints: Sequence[JointParts], held: int | None = None) -> Pairs:
    """The set with the rates of its springs to wind tuned to the lowest expected error of the whole leg.

    One joint after the other, but not joint ``held``; a rate is accepted if it can be wound and reduces the expected
    error.
    """
    for j, parts in enumerate(joints):
        if j == held:
            continue
        pair = _with_tuned_spring(judge, chosen, j, chosen[j], parts.source)
        if pair is not chosen[j]:
            other = _with_pair(chosen, j, pair)
            if judge.expected(other) < judge.expected(chosen) - WORTH:
                chosen = other
    return chosen


def _wound(source: SpringSource, rate: float) -> SpringOption | None:
    """A spring to wind for exactly these requirements; None if only a different one can be made."""
    try:
        option, _ = spring_to_wind(source, rate, lasting=False)
    except UserError:
        return None
    made_as_asked = option.result is not None and option.result.best is not None
    return option if made_as_asked and abs(option.rate / rate - 1.0) < SAME_RATE else None
