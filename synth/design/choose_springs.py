"""Choice of springs: a bought one if any meets the constraints, else one to wind; ranked by the leg's response."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from math import inf, log

from synth.cad.dimensions import CLOSE_WOUND_PITCH
from synth.design.arms_apart import INCLUDED_ANGLE, first_found, with_room_on_shaft
from synth.design.clamped_arms import JointArms, leg_that_bends_as_much, rate_in_joint
from synth.design.coil_room import arbor_of
from synth.design.drawable_springs import STOP_ROOM, drawable_sizes, reasons_not_drawn
from synth.design.wanted_travel import WantedTravel as WantedTravel
from synth.design.wanted_travel import travels as travels
from synth.design.wound_warnings import nearest_taken, wound_warnings
from synth.errors import CannotBeHad, UserError
from synth.files.project_options import CadOptions, PartsOptions, SpringChoice
from synth.parts.catalogs import Catalogue
from synth.parts.coil_rate import RATE_FORMS
from synth.parts.part_candidates import (
    ANY,
    Candidates,
    count_reasons,
    mirror_of,
    no_spring,
    of_family,
    spring_candidates,
    spring_reason,
)
from synth.parts.rows import TorsionSpringRow
from synth.remarks import noted
from synth.spring.bought_spring import PassedLimit, check_bought, passed_as_held, passed_limits, unknown_yield
from synth.spring.design import SpringResult, design_spring
from synth.spring.loose_test import LooseTest
from synth.spring.spring_requirements import SpringRequirements
from synth.spring.spring_result import SpringDesign
from synth.spring.spring_search import lasts
from synth.spring.spring_task import SpringLimits
from synth.swing.leg_model import Leg

MOST_CANDIDATES = 48  # candidate springs per joint and damper, nearest rates first
NEAREST = 16  # springs per joint that are evaluated beyond the rate tolerance, nearest first
ROUNDING = 1.0 - 1e-9  # of a rate that is held to its limit
TOO_WEAK = "too weak: its free angle would be farther away than the drawn joint can wind it up"
ARM_LENGTH = 0.025  # m, about as soft as the clamped arms of a spring to wind; start of the first of two searches


@dataclass(frozen=True)
class SpringOption:
    """A spring at a joint: bought (``row``) or to wind (``design``, with how it was found in ``result``).

    ``rate`` (N m/rad) is that of all ``count`` parallel springs at the joint; ``asked`` is the wanted rate, for which
    the spring was searched: a bought one's ``rate`` is within the tolerance of it. ``error``, ``expected`` (rad):
    response error of the whole leg with it, nominal and with tolerances. ``outside``: the rate is outside the requested
    tolerance. ``compared``: the spring is listed for comparison only, because bought springs have priority over springs
    to wind, and a spring requested by its part number has priority over all others. ``closes``: -1 if smaller measured
    angles close its arms, +1 if larger ones do.
    ``turned_to_hold``: it is seated so because the seat of ``WantedTravel`` would let it yield.
    ``passed``: of a bought spring, its limits that the joint's travel passes; ``unchecked``: why it is not known where
    it yields; ``loose``: how to measure one of it, once
    its joint is drawn; ``mirror``: of two, the part of the other hand, None if no catalogue has it. ``held``: ``asked``
    is the least rate of a spring that its joint can wind up, because a weaker one was wanted.
    """

    rate: float
    included_angle: float
    row: TorsionSpringRow | None = None
    design: SpringDesign | None = None
    result: SpringResult | None = None
    check: SpringDesign | None = None
    error: float = float("nan")
    expected: float = float("nan")
    count: int = 1
    outside: bool = False
    compared: bool = False
    closes: int = -1
    turned_to_hold: bool = False
    asked: float = 0.0
    passed: tuple[PassedLimit, ...] = ()
    unchecked: str = ""
    loose: LooseTest | None = None
    mirror: TorsionSpringRow | None = None
    held: bool = False

    @property
    def test(self) -> LooseTest | None:
        """How to measure the loose spring; None: a bought one whose joint is not drawn."""
        return self.loose if self.design is None else self.design.test

    @property
    def label(self) -> str:
        """Part number and count, or the description of the spring to wind."""
        return f"{self.count} x {self.part}" if self.row is not None and self.count > 1 else self.part

    @property
    def part(self) -> str:
        """Part number, or the description of the spring to wind."""
        if self.row is not None:
            return self.row.part
        assert self.design is not None
        number = f"{self.design.count} x " if self.design.count > 1 else ""
        return f"{number}wind {self.design.wire_diameter * 1e3:.4g} mm {self.design.material}"

    @property
    def as_sold(self) -> float:
        """Rate (N m/rad) of all springs of the joint, of bought ones as their vendor states it, without arms."""
        return self.rate if self.row is None or self.row.rate is None else self.row.rate * self.count

    @property
    def number(self) -> int:
        """How many equal springs act in parallel, bought or wound."""
        return self.count if self.design is None else self.design.count


@dataclass(frozen=True)
class SpringChoiceMade:
    """The chosen springs, their substitutes (best first), the excluded rows by reason, and notes on the choice.

    ``leg``: with the chosen springs, in the order of its joints.
    """

    chosen: tuple[SpringOption, ...]
    ranked: tuple[tuple[SpringOption, ...], ...]
    left_out: tuple[Mapping[str, int], ...]
    leg: Leg
    notes: tuple[tuple[str, ...], ...]

    @property
    def warnings(self) -> tuple[tuple[str, ...], ...]:
        """Of each joint the notes on the choice and what is told of its spring to wind, as that is now."""
        each = zip(self.leg.joint_names, self.chosen, self.notes, strict=True)
        return tuple((*notes, *warnings_of_wound(name, option)) for name, option, notes in each)


@dataclass(frozen=True)
class SpringSource:
    """The source of springs for one joint: requirements, available space, catalogue.

    ``drawn``: the joint is drawn, so only springs that can be are candidates. ``least_rate`` (N m/rad): of those that
    it can wind up from their free angle, see ``arm_sweep``.
    """

    joint: str
    choice: SpringChoice
    travel: WantedTravel
    catalogue: Catalogue
    cad: CadOptions
    parts: PartsOptions = ANY
    held_wire: float | None = None  # m, wire of the spring to wind with which the links' masses were computed
    drawn: bool = False
    least_rate: float = 0.0

    @property
    def turned(self) -> WantedTravel:
        """The travel that the project requires, else the joint's."""
        if self.choice.travel is None:
            return self.travel
        return replace(self.travel, winding=self.choice.travel, opening=min(self.travel.opening, self.choice.travel))

    def winds_up(self, rate: float) -> bool:
        """Whether the joint can wind up springs of this rate (N m/rad) together."""
        return rate >= self.least_rate * ROUNDING

    def acting(self, row: TorsionSpringRow) -> float:
        """Rate (N m/rad) of one spring of this row in the joint, which is what the wanted rate is compared with."""
        return rate_in_joint(row, self.turned.opening, self.cad)


def spring_options(
    source: SpringSource, rate: float, *, lasting: bool = True
) -> tuple[list[SpringOption], Mapping[str, int], list[str]]:
    """The springs that a joint may have (bought, or one to wind), the excluded rows by reason, and notes on the choice.

    ``lasting`` as in ``spring_to_wind``. A ``rate`` (N m/rad) below the source's least is held to it. What is told of a
    spring to wind itself: ``warnings_of_wound``.

    Bought springs that yield, break early or pass their vendor's limits in the joint's travel are excluded, unless one
    is named by its part number, or no other spring can be had: their ``passed`` is then not empty.

    Raises
    ------
    UserError : a bought spring is required and none meets the constraints.
    """
    joint, choice, catalogue, rate = source.joint, source.choice, source.catalogue, max(rate, source.least_rate)
    if choice.make:
        return [spring_to_wind(source, rate, lasting=lasting)[0]], {}, []
    if choice.part is not None:
        named = spring_candidates(catalogue, choice, rate, source.parts, acting=source.acting)
        return [_bought(row, source, choice.parallel, rate) for row in named.rows], named.left_out, []
    found, borne = _bought_for(source, rate)
    if borne.holding:
        return borne.holding, found.left_out, []
    if choice.make is False:
        if borne.passing:
            return borne.passing, found.left_out, []
        raise no_spring(joint, found, catalogue.springs)
    try:
        option, _ = spring_to_wind(source, rate, lasting=lasting)
    except CannotBeHad:
        if borne.passing:
            return borne.passing, found.left_out, []
        raise
    return [option], found.left_out, [_none_bought(joint, found, borne)]


def _bought_for(source: SpringSource, rate: float) -> tuple[Candidates[TorsionSpringRow], _BoughtBorne]:
    """The bought springs of a rate (N m/rad), with every reason against others, and which of them bear the travel."""
    choice, catalogue = source.choice, source.catalogue
    by_count = [
        spring_candidates(catalogue, choice, rate, source.parts, count, source.acting)
        for count in range(1, choice.parallel + 1)
    ]
    found = by_count[0]
    rows = [(row, count) for count, each in enumerate(by_count, 1) for row in each.rows]
    rows.sort(key=lambda item: abs(log(source.acting(item[0]) * item[1] / rate)))
    borne = _borne(rows, source, rate, MOST_CANDIDATES)
    reasons = {**found.left_out, **borne.left_out}
    if borne.more:
        reasons[f"rate further from {rate:.4g} N*m/rad than those of {MOST_CANDIDATES} others"] = borne.more
    return replace(found, left_out=reasons), borne


def _none_bought(joint: str, found: Candidates[TorsionSpringRow], borne: _BoughtBorne) -> str:
    of_these = f"; with this rate, {count_reasons(borne.left_out)}" if borne.left_out else ""
    return noted(
        f"{joint}: no bought spring meets the constraints ({found.nearest}{of_these}); one to wind is designed"
    )


def remarks_on_bought(source: SpringSource, option: SpringOption) -> tuple[Mapping[str, int], list[str]]:
    """The bought springs excluded by reason, and why none is taken, both for the rate wanted of the chosen spring."""
    if source.choice.make:
        return {}, []
    if source.choice.part is not None:
        return spring_options(source, option.asked)[1], []
    found, borne = _bought_for(source, option.asked)
    if option.row is not None:
        return found.left_out, []
    if not borne.holding:
        return found.left_out, [_none_bought(source.joint, found, borne)]
    names = ", ".join(each.label for each in borne.holding[:2])
    text = (
        f"{source.joint}: what can be bought near the rate that suits the whole leg best, {option.asked:.4g} N*m/rad "
        f"({names}), leaves a larger expected error than one to wind"
    )
    return found.left_out, [noted(text)]


@dataclass(frozen=True)
class _BoughtBorne:
    """Bought springs that bear the travel, those that do not, how many are left out by reason, and not looked at."""

    holding: list[SpringOption]
    passing: list[SpringOption]
    left_out: Mapping[str, int]
    more: int


def _borne(rows: Sequence[tuple[TorsionSpringRow, int]], source: SpringSource, rate: float, most: int) -> _BoughtBorne:
    """The first ``most`` of these springs (each with its number in parallel) that bear the travel and can be drawn."""
    holding: list[SpringOption] = []
    passing: list[SpringOption] = []
    against: dict[str, str] = {}
    looked, turned = 0, source.turned
    for row, count in rows:
        if len(holding) == most:
            break
        looked += 1
        against_it = reasons_not_drawn(row, turned.winding, source.cad, turned.opening) if source.drawn else iter(())
        reason = next(against_it, None) if source.winds_up(source.acting(row) * count) else TOO_WEAK
        if reason is None:
            option = _bought(row, source, count, rate)
            if not option.passed:
                holding.append(option)
                continue
            reason = option.passed[0].reason
            if len(passing) < most:
                passing.append(option)
        against[f"{row.vendor} {row.part}"] = reason
    kept = {f"{option.row.vendor} {option.row.part}" for option in holding if option.row is not None}
    reasons = Counter(reason for name, reason in against.items() if name not in kept)
    return _BoughtBorne(holding, passing, dict(sorted(reasons.items())), len(rows) - looked)


def other_springs(source: SpringSource, rate: float, taken: Sequence[SpringOption]) -> list[SpringOption]:
    """Substitutes for a spring, nearest rates first: bought ones of any rate that bear the travel, or one to wind."""
    known = {(option.part, option.count) for option in taken if option.row is not None}
    parts = of_family(source.parts, source.catalogue.springs)
    found = []
    for count in range(1, source.choice.parallel + 1):
        for row in source.catalogue.springs:
            if (row.part, count) not in known and spring_reason(row, source.choice, None, parts, count) is None:
                found.append((abs(log(source.acting(row) * count / rate)), count, row))
    found.sort(key=lambda item: (item[0], item[1], item[2].part))
    others = [
        replace(
            option,
            outside=abs(option.rate / rate - 1.0) > source.choice.rate_tolerance,
            compared=source.choice.part is not None,
        )
        for option in _borne([(row, count) for _, count, row in found], source, rate, NEAREST).holding
    ]
    if source.choice.make is not False and all(option.row is not None for option in taken):
        with suppress(UserError):  # no spring can be wound either
            others.append(replace(spring_to_wind(source, rate, lasting=False)[0], compared=True))
    return others


def warnings_of_wound(joint: str, option: SpringOption) -> list[str]:
    """What is told of a spring to wind, as drawn if its joint is; nothing of a bought one."""
    if option.design is None or option.result is None:
        return []
    return wound_warnings(joint, option.asked, option.result, option.design)


def _bought(row: TorsionSpringRow, source: SpringSource, count: int, asked: float) -> SpringOption:
    """A bought spring with its rate in the joint."""
    assert row.included_angle is not None
    travel, rate = source.turned, source.acting(row)
    known = row.wire_diameter and row.mean_diameter and row.body_coils
    arm = JointArms(travel.opening, source.cad) if known else None
    check = check_bought(row, source.catalogue, travel.winding, travel.opening, arm=arm, rate=rate)
    yields = None if check is None else check.free_travel
    passed = passed_limits(row, source.catalogue, travel.winding, yields=yields)
    unchecked = "" if check is not None else unknown_yield(row, source.catalogue)
    return SpringOption(
        rate * count,
        row.included_angle,
        row=row,
        check=check,
        count=count,
        closes=1 if travel.turned_round else -1,
        asked=asked,
        passed=(*passed, *passed_as_held(check, source.choice.cycles, unchecked)),
        unchecked=unchecked,
        mirror=mirror_of(row, source.catalogue.springs, source.parts) if count == 2 else None,
        held=asked <= source.least_rate,
    )


def spring_to_wind(source: SpringSource, rate: float, *, lasting: bool = True) -> tuple[SpringOption, list[str]]:
    """The spring to wind for a rate (N m/rad), or the nearest that can be made, and warnings.

    ``lasting``: whether to look for the nearest springs that last, if it does not; ``with_lasting`` adds them.

    Raises
    ------
    UserError : no spring can be wound.
    """
    joint, travel, catalogue, cad = source.joint, source.turned, source.catalogue, source.cad
    choice = drawable_sizes(source.choice) if source.drawn else source.choice
    wish = SpringRequirements(
        rate=rate,
        travel=travel.winding + STOP_ROOM,
        opening_travel=travel.opening + STOP_ROOM,
        included_angle=choice.included_angle or INCLUDED_ANGLE,
        leg_lengths=(ARM_LENGTH, ARM_LENGTH),
        material=choice.wire or "music",
        objective=choice.objective,
        rate_form=RATE_FORMS[choice.rate_formula],
        system=source.parts.system,
        wire_range=(choice.min_wire_diameter or 0.0, choice.max_wire_diameter or inf),
        held_wire=source.held_wire,
        free_arm=JointArms(travel.opening + STOP_ROOM, cad),
        pitch=CLOSE_WOUND_PITCH,
        limits=SpringLimits(
            arbor_diameter=arbor_of(cad),
            min_inside_diameter=choice.min_inner_diameter,
            min_outer_diameter=choice.min_outer_diameter,
            min_body_length=choice.min_body_length,
            max_outer_diameter=choice.max_outer_diameter,
            max_body_length=choice.max_body_length,
            cycles=choice.cycles,
        ),
    )
    wish, first = first_found(wish, catalogue, cad, drawn=source.drawn, free=choice.included_angle is None)
    if first is not None:
        sizes = (first.wire_diameter, first.mean_diameter, first.body_coils, wish.opening_travel)
        leg = leg_that_bends_as_much(*sizes, cad)
        wish = replace(wish, leg_lengths=(leg, leg))
    result = with_room_on_shaft(wish, catalogue, cad, drawn=source.drawn, lasting=lasting)
    if result.best is None and not result.nearest:
        raise CannotBeHad(f"{joint}: no spring can be wound for {rate:.4g} N*m/rad: {'; '.join(result.binding)}")
    design = result.best or nearest_taken(result).design
    total = design.rate * design.count
    held = rate <= source.least_rate
    option = SpringOption(total, design.included_angle, design=design, result=result, asked=rate, held=held)
    return replace(option, closes=1 if travel.turned_round else -1), warnings_of_wound(joint, option)


def with_lasting(option: SpringOption, catalogue: Catalogue) -> SpringOption:
    """The spring with the nearest ones that last, if it is to be wound, does not last, and they are not known yet."""
    result = option.result
    if result is None or result.best is None or result.lasting or lasts(result.best, result.wish.limits):
        return option
    return replace(option, result=design_spring(result.wish, catalogue, 0))
