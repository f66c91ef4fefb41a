"""Springs and dampers of all joints chosen together, for the response of the whole leg as its parts may come.

At each joint every damper goes with every spring that meets the constraints for the rate that suits that damper; a set
is one such pair a joint. The sets that move the leg most nearly as wanted with nominal parts are found first
(``search``) and then judged with their tolerances (``forecast``): the one with the least expected error is chosen.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from math import radians
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.design.choose_dampers import DamperChoiceMade, DamperOption
from synth.design.choose_springs import (
    SpringChoiceMade,
    SpringOption,
    SpringSource,
    other_springs,
    sense_warning,
    spring_options,
)
from synth.design.forecast import Forecast, Forecaster, damper_tolerance, spring_tolerance
from synth.design.part_lanes import Acting, Index, PartLanes
from synth.design.part_search import Found, best_sets
from synth.design.response import WantedResponse
from synth.errors import UserError
from synth.files.project_options import PartsOptions
from synth.swing.leg_model import Damper, Leg, Spring
from synth.units import quantity

DAMPERS = 8  # a joint that take part, the best by themselves first
PAIRS = 400  # spring and damper pairs a joint that are looked at
MOST_SETS = 4_000_000
FINALISTS = 12  # sets that are judged with their tolerances
SHOWN = 8  # of these, with more samples
SAMPLES_FINAL, SAMPLES_SHOWN, SAMPLES_CHOSEN = 32, 64, 256
MEASURED_ANGLE = radians(1.0)  # what a protractor leaves open
RELEASES = 7  # about so many serve for tolerances


@dataclass(frozen=True)
class Pair:
    """A spring and a damper at one joint."""

    spring: SpringOption
    damper: DamperOption


@dataclass(frozen=True)
class PartSet:
    """A pair for each joint, their nominal error over all releases (rad) and what is to be expected of them."""

    pairs: tuple[Pair, ...]
    error: float
    forecast: Forecast

    def as_json(self, names: Sequence[str], chosen: PartSet) -> dict[str, Any]:
        """Parts by joint, predicted errors and what the set costs against the chosen one."""
        return {
            "parts": {
                name: {"spring": pair.spring.label, "damper": pair.damper.label}
                for name, pair in zip(names, self.pairs, strict=True)
            },
            "rms": quantity(self.error, "deg"),
            **self.forecast.as_json(),
            "cost": quantity(self.forecast.expected - chosen.forecast.expected, "deg"),
        }


@dataclass(frozen=True)
class SetsMade:
    """The chosen set, the best others, how they were found, and what may stand in for each part.

    ``springs`` and ``dampers`` are the same choice joint by joint; ``leg`` is the leg with the chosen set.
    """

    sets: tuple[PartSet, ...]
    found: Found
    leg: Leg
    springs: SpringChoiceMade
    dampers: DamperChoiceMade
    cut: tuple[int, ...]  # pairs a joint that were left out because they are worst by themselves
    measured: Forecast  # of the chosen set if its springs' free angles are measured before the arms are made
    legs: tuple[Leg, ...]  # with each of ``sets``

    @property
    def chosen(self) -> PartSet:
        return self.sets[0]


def choose_sets(
    wanted: WantedResponse,
    fitted: Leg,
    dampers: DamperChoiceMade,
    sources: Sequence[SpringSource],
    parts: PartsOptions,
    *,
    settled: bool = False,
    seed: int = 0,
) -> SetsMade:
    """Choose springs and dampers together.

    Parameters
    ----------
    fitted
        the leg with the chosen dampers and the spring rates that were fitted with them.
    dampers
        ranked dampers of each joint, each with the spring that suits it.
    sources
        where each joint's springs come from.
    settled
        the chosen dampers stay; other sets are alternatives only.

    Raises
    ------
    UserError : a joint asks for a bought spring and none meets its constraints.
    """
    pairs, left_out, warnings = [], [], []
    for j, source in enumerate(sources):
        spring = fitted.joints[j].spring
        assert spring is not None
        chosen = dampers.chosen[j]
        others = [option for option in dampers.ranked[j] if option.label != chosen.label]
        made, reasons, said = _pairs(source, chosen, spring.rate, others[: DAMPERS - 1])
        said = [*said, *sense_warning(source.joint, source.turned)]
        pairs.append(made)
        left_out.append(reasons)
        warnings.append(tuple(said))
    lanes = PartLanes(wanted, fitted, [_acting(each) for each in pairs])
    pairs, cut = _cut(lanes, pairs)
    lanes = PartLanes(wanted, fitted, [_acting(each) for each in pairs])
    found = best_sets(lanes, [0] * len(pairs), FINALISTS, seed=seed)
    sets = _judged(wanted, fitted, pairs, _with_settled(lanes, pairs, found), parts, settled, seed)
    leg = _leg(lanes, fitted, sets[0].pairs)
    return SetsMade(
        sets,
        found,
        leg,
        _springs_made(lanes, sets[0], pairs, sources, left_out, warnings, leg),
        _dampers_made(lanes, sets[0], dampers, leg),
        cut,
        _if_measured(wanted, fitted, sets[0], parts, seed),
        tuple(_leg(lanes, fitted, item.pairs) for item in sets),
    )


def _if_measured(wanted: WantedResponse, leg: Leg, chosen: PartSet, parts: PartsOptions, seed: int) -> Forecast:
    """What is to be expected if each spring is measured and its arm made to suit: free angles are right to a degree."""
    tolerance = replace(parts.tolerance, free_angle=min(MEASURED_ANGLE, parts.tolerance.free_angle or MEASURED_ANGLE))
    lanes = PartLanes(wanted, leg, [_acting([pair]) for pair in chosen.pairs], RELEASES)
    pairs = [(pair.spring, pair.damper) for pair in chosen.pairs]
    return Forecaster(lanes, tolerance, parts.within, seed).forecast(pairs, SAMPLES_CHOSEN, shares=True)


def _pairs(
    source: SpringSource, chosen: DamperOption, rate: float, others: Sequence[DamperOption]
) -> tuple[list[Pair], Mapping[str, int], list[str]]:
    """Every damper with the springs for the rate that suits it; reasons and words are those of the chosen damper."""
    springs, reasons, said = spring_options(source, rate)
    made = [Pair(spring, chosen) for spring in springs]
    for damper in others:
        with suppress(UserError):  # a damper for which no spring can be bought takes no part
            assert damper.spring is not None
            made += [Pair(spring, damper) for spring in spring_options(source, damper.spring.rate)[0]]
    return made[:PAIRS], reasons, said


def _acting(pairs: Sequence[Pair]) -> list[Acting]:
    return [Acting(pair.spring.rate, pair.damper.damper) for pair in pairs]


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


def _with_settled(lanes: PartLanes, pairs: Sequence[Sequence[Pair]], found: Found) -> Found:
    """The finalists, and where none has the first damper of every joint, the set of first pairs too."""
    if any(_has_first_dampers(pairs, row) for row in found.index):
        return found
    first = np.zeros((1, len(pairs)), dtype=np.int64)
    return replace(
        found, index=np.concatenate([found.index, first]), error=np.concatenate([found.error, lanes.errors(first)])
    )


def _has_first_dampers(pairs: Sequence[Sequence[Pair]], numbers: Index) -> bool:
    return all(options[k].damper is options[0].damper for options, k in zip(pairs, numbers, strict=True))


def _judged(
    wanted: WantedResponse,
    leg: Leg,
    pairs: list[list[Pair]],
    found: Found,
    parts: PartsOptions,
    settled: bool,
    seed: int,
) -> tuple[PartSet, ...]:
    """The finalists with their tolerances, least expected error first; those that are shown with more samples.

    ``settled``: a set with the first damper of every joint stands before all others.
    """
    behind = [settled and not _has_first_dampers(pairs, row) for row in found.index]
    lanes = PartLanes(wanted, leg, [_acting(each) for each in pairs], RELEASES)
    forecaster = Forecaster(lanes, parts.tolerance, parts.within, seed)
    sets = [tuple(options[k] for options, k in zip(pairs, row, strict=True)) for row in found.index]

    def judged(n_sample: int, chosen: Sequence[int]) -> dict[int, Forecast]:
        return {k: forecaster.forecast([(p.spring, p.damper) for p in sets[k]], n_sample) for k in chosen}

    shown = list(range(len(sets)))
    if len(sets) > SHOWN:
        rough = judged(SAMPLES_FINAL, shown)
        shown.sort(key=lambda k: (behind[k], rough[k].expected, k))
        shown = [*shown[:1], *sorted(shown[1:], key=lambda k: (rough[k].expected, k))][:SHOWN]
    fine = judged(SAMPLES_SHOWN, shown)
    order = sorted(fine, key=lambda k: (behind[k], fine[k].expected, k))
    order = [*order[:1], *sorted(order[1:], key=lambda k: (fine[k].expected, k))]
    best = [(p.spring, p.damper) for p in sets[order[0]]]
    fine[order[0]] = forecaster.forecast(best, SAMPLES_CHOSEN, shares=True)
    return tuple(PartSet(sets[k], float(found.error[k]), fine[k]) for k in order)


def _leg(lanes: PartLanes, leg: Leg, pairs: Sequence[Pair]) -> Leg:
    """The leg with a set of parts, resting as wanted."""
    joints = []
    for j, (joint, pair) in enumerate(zip(leg.joints, pairs, strict=True)):
        free = joint.zero + joint.sign * lanes.rest(j, pair.spring.rate)
        joints.append(replace(joint, spring=Spring(pair.spring.rate, free), damper=pair.damper.damper))
    return replace(leg, joints=tuple(joints))


def _instead(lanes: PartLanes, chosen: PartSet, joint: int, options: Sequence[tuple[float, Damper]]) -> Array:
    """(n_option,) rad, the error of the chosen set with another rate and damper at one joint."""
    acting = [[Acting(pair.spring.rate, pair.damper.damper)] for pair in chosen.pairs]
    acting[joint] = [Acting(rate, damper) for rate, damper in options]
    other = PartLanes(lanes.wanted, lanes.leg, acting)
    index = np.zeros((len(options), len(acting)), dtype=np.int64)
    index[:, joint] = np.arange(len(options))
    return other.errors(index)


def _springs_made(
    lanes: PartLanes,
    chosen: PartSet,
    pairs: Sequence[Sequence[Pair]],
    sources: Sequence[SpringSource],
    left_out: Sequence[Mapping[str, int]],
    warnings: Sequence[tuple[str, ...]],
    leg: Leg,
) -> SpringChoiceMade:
    """The chosen springs and what could be had in the place of each, by what it costs in response."""
    ranked, taken = [], []
    for j, source in enumerate(sources):
        spring, damper = chosen.pairs[j].spring, chosen.pairs[j].damper
        same = [pair.spring for pair in pairs[j] if pair.damper is damper and pair.spring is not spring]
        options = [spring, *same, *other_springs(source, spring.rate, [spring, *same])]
        errors = _instead(lanes, chosen, j, [(option.rate, damper.damper) for option in options])
        judged = [replace(option, error=float(error)) for option, error in zip(options, errors, strict=True)]
        taken.append(judged[0])
        ranked.append(tuple(sorted(judged, key=lambda option: option.error)))
    return SpringChoiceMade(tuple(taken), tuple(ranked), tuple(left_out), leg, tuple(warnings))


def _dampers_made(lanes: PartLanes, chosen: PartSet, dampers: DamperChoiceMade, leg: Leg) -> DamperChoiceMade:
    """The chosen dampers and what could be had in the place of each; a spring to wind is wound to suit the other."""
    ranked, taken = [], []
    for j, options in enumerate(dampers.ranked):
        spring, damper = chosen.pairs[j].spring, chosen.pairs[j].damper
        others = [option for option in options if option.label != damper.label]
        acting = [
            (option.spring.rate if spring.row is None and option.spring is not None else spring.rate, option.damper)
            for option in others
        ]
        errors = _instead(lanes, chosen, j, [(spring.rate, damper.damper), *acting])
        judged = [replace(o, error=float(e)) for o, e in zip([damper, *others], errors, strict=True)]
        taken.append(judged[0])
        ranked.append(tuple(sorted(judged, key=lambda option: option.error)))
    return replace(dampers, chosen=tuple(taken), ranked=tuple(ranked), leg=leg)


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
