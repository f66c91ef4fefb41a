"""Choice of springs: a bought one if any meets the constraints, else one to wind; ranked by the leg's response."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from math import degrees, log, radians
from typing import Any

import numpy as np

from synth.cad.dimensions import CLOSE_WOUND_PITCH
from synth.design.clamped_arms import JointArms, leg_that_bends_as_much, softening
from synth.errors import CannotBeHad, UserError
from synth.files.project_options import CadOptions, PartsOptions, SpringChoice
from synth.parts.catalogs import Catalogue
from synth.parts.coil_rate import RATE_FORMS
from synth.parts.part_candidates import ANY, no_spring, of_family, spring_candidates, spring_reason
from synth.parts.rows import TorsionSpringRow
from synth.remarks import about, decisive, noted
from synth.spring.design import SpringResult, design_spring
from synth.spring.evaluate import check_spring
from synth.spring.spring_requirements import SpringRequirements
from synth.spring.spring_result import DESIGN_LIFE, FreeArm, SpringDesign, SpringLimits, SpringTask
from synth.swing.leg_model import Leg
from synth.units import quantity

MOST = 48  # candidate springs per joint and damper, nearest rates first
NEAREST = 16  # springs per joint that are evaluated beyond the rate tolerance, nearest first
INCLUDED_ANGLE = radians(120.0)  # default for a spring to wind: that of the thesis' springs
ARM_LENGTH = 0.025  # m, about as soft as the clamped arms of a spring to wind; start of the first of two searches
STOP_ROOM = radians(3.5)  # beyond the travel; a spring to wind must bear it, because the joint's hard stops are there


@dataclass(frozen=True)
class WantedTravel:
    """Travel of a joint's spring from its free angle, rad: the larger side, which winds it, and the other.

    ``below``: the larger side is at smaller measured angles, at which a joint drawn as the thesis' closes the arms.
    """

    winding: float
    opening: float
    below: bool = True

    @property
    def turned_round(self) -> bool:
        """Whether the travel is mainly towards larger angles: the spring is then seated so that they close its arms."""
        return not self.below and self.winding >= 2.0 * self.opening and self.winding >= radians(2.0)


@dataclass(frozen=True)
class SpringOption:
    """A spring at a joint: bought (``row``) or to wind (``design``, with how it was found in ``result``).

    ``rate`` (N m/rad) is that of all ``count`` parallel springs at the joint; ``asked`` is the rate for which the
    spring was searched. ``error``, ``expected`` (rad): response error of the whole leg with it, nominal and with
    tolerances. ``outside``: the rate is outside the requested tolerance. ``compared``: the spring is listed for
    comparison only, because bought springs have priority over springs to wind, and a spring requested by its part
    number has priority over all others. ``closes``: -1 if smaller measured angles close its arms, +1 if larger ones do.
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
    asked: float = 0.0

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

    def as_json(self) -> dict[str, Any]:
        """The joint's ``spring`` entry, without the free angle."""
        if self.row is not None:
            row = self.row
            written: dict[str, Any] = {
                "part": row.part,
                "vendor": row.vendor,
                "count": self.count,
                "rate": quantity(self.rate, "N*m/rad"),
                "included_angle": quantity(self.included_angle, "deg"),
                "material": row.material,
                "hand": row.hand or None,
                "source": row.source,
            }
            if row.derived:
                written["derived"], written["measure_before_printing"] = list(row.derived), list(row.measure)
            for name, value, unit in (
                ("wire_diameter", row.wire_diameter, "mm"),
                ("outer_diameter", row.outer_diameter, "mm"),
                ("body_coils", row.body_coils, "1"),
                ("body_length", row.body_length, "mm"),
            ):
                if value is not None:
                    written[name] = quantity(value, unit)
            if self.check is not None:
                written["free_travel"] = quantity(self.check.free_travel, "deg")
                written["travel"] = quantity(self.check.travel, "deg")
                written["rate_bending_form"] = quantity(self.check.rate_bending_form, "N*m/rad")
            return written
        assert self.design is not None
        written = {"make": self.design.as_json()}
        if self.result is not None:
            written["binding"] = list(self.result.binding)
            written["nearest"] = [item.as_json() for item in self.result.nearest]
            written["lasting"] = [item.as_json() for item in self.result.lasting]
            written["notes"] = list(self.result.notes)
        return written


@dataclass(frozen=True)
class SpringChoiceMade:
    """The chosen springs, their substitutes (best first), the excluded rows by reason, and warnings."""

    chosen: tuple[SpringOption, ...]
    ranked: tuple[tuple[SpringOption, ...], ...]
    left_out: tuple[Mapping[str, int], ...]
    leg: Leg
    warnings: tuple[tuple[str, ...], ...]


def travels(leg: Leg, motions: Sequence[np.ndarray[Any, Any]]) -> list[WantedTravel]:
    """Each spring's travel from its free angle: over the joint's range if the leg states one, else over the motions.

    ``motions`` : (m, n) rotations, rad. The larger side of the two winds the coil.
    """
    found = []
    for j, joint in enumerate(leg.joints):
        assert joint.spring is not None
        if joint.range is not None:
            ends = [angle - joint.spring.free_angle for angle in joint.range]
        else:
            turned = joint.sign * (np.concatenate([motion[:, j] for motion in motions]) - joint.rest)
            ends = [float(turned.min()), float(turned.max())]
        below, above = abs(min(0.0, *ends)), abs(max(0.0, *ends))
        found.append(WantedTravel(max(below, above), min(below, above), below >= above))
    return found


@dataclass(frozen=True)
class SpringSource:
    """The source of springs for one joint: requirements, available space, catalogue."""

    joint: str
    choice: SpringChoice
    travel: WantedTravel
    catalogue: Catalogue
    cad: CadOptions
    parts: PartsOptions = ANY
    held_wire: float | None = None  # m, wire of the spring to wind with which the links' masses were computed

    @property
    def turned(self) -> WantedTravel:
        """The travel that the project requires, else the joint's."""
        if self.choice.travel is None:
            return self.travel
        return WantedTravel(self.choice.travel, min(self.travel.opening, self.choice.travel), self.travel.below)


def spring_options(source: SpringSource, rate: float) -> tuple[list[SpringOption], Mapping[str, int], list[str]]:
    """The springs that a joint may have (bought, or one to wind), the excluded rows by reason, and warnings.

    Raises
    ------
    UserError : a bought spring is required and none meets the constraints.
    """
    joint, choice, catalogue = source.joint, source.choice, source.catalogue
    travel = source.turned
    reasons: dict[str, int] = {}
    if not choice.make:
        found = spring_candidates(catalogue, choice, rate, source.parts)
        reasons = dict(found.left_out)
        rows = [(row, 1) for row in found.rows]
        for count in range(2, choice.parallel + 1 if choice.part is None else 2):
            rows += [(row, count) for row in spring_candidates(catalogue, choice, rate, source.parts, count).rows]
        rows.sort(key=lambda item: abs(log((item[0].rate or rate) * item[1] / rate)))
        if len(rows) > MOST:
            reasons[f"rate further from {rate:.4g} N*m/rad than those of {MOST} others"] = len(rows) - MOST
        if rows:
            return [_bought(row, travel, source, count, rate) for row, count in rows[:MOST]], reasons, []
        if choice.make is False:
            raise no_spring(joint, found, catalogue.springs)
        warnings = [
            noted(f"{joint}: no bought spring meets the constraints ({found.nearest}); one to wind is designed")
        ]
    else:
        warnings = []
    option, more = spring_to_wind(source, rate)
    return [option], reasons, warnings + more


def other_springs(source: SpringSource, rate: float, taken: Sequence[SpringOption]) -> list[SpringOption]:
    """Substitutes for a spring, nearest rates first: bought ones of any rate, or one to wind."""
    known = {(option.part, option.count) for option in taken if option.row is not None}
    parts = of_family(source.parts, source.catalogue.springs)
    found = []
    for count in range(1, source.choice.parallel + 1):
        for row in source.catalogue.springs:
            if (row.part, count) not in known and spring_reason(row, source.choice, None, parts, count) is None:
                assert row.rate is not None
                found.append((abs(log(row.rate * count / rate)), count, row))
    found.sort(key=lambda item: (item[0], item[1], item[2].part))
    others = [
        replace(
            _bought(row, source.turned, source, count, rate),
            outside=off > log(1 + source.choice.rate_tolerance),
            compared=source.choice.part is not None,
        )
        for off, count, row in found[:NEAREST]
    ]
    if source.choice.make is not False and all(option.row is not None for option in taken):
        with suppress(UserError):  # no spring can be wound either
            others.append(replace(spring_to_wind(source, rate)[0], compared=True))
    return others


def _bought(
    row: TorsionSpringRow, travel: WantedTravel, source: SpringSource, count: int, asked: float
) -> SpringOption:
    """A bought spring with its rate including the arms; vendors state the rate of the body alone."""
    assert row.rate is not None
    assert row.included_angle is not None
    closes, rate, check = 1 if travel.turned_round else -1, row.rate * count, None
    if row.wire_diameter and row.mean_diameter and row.body_coils:
        rate *= softening(row.wire_diameter, row.mean_diameter, row.body_coils, travel.opening, source.cad)
        clamped = JointArms(travel.opening, source.cad)
        check = checked(row, (travel.winding, travel.opening), rate / count, clamped, source.catalogue)
    return SpringOption(rate, row.included_angle, row=row, check=check, count=count, closes=closes, asked=asked)


def checked(
    row: TorsionSpringRow, turned: tuple[float, float], rate: float, arm: FreeArm, catalogue: Catalogue
) -> SpringDesign | None:
    """A bought spring as the joint holds it, with clamped arms; None if the strength of its wire is unknown.

    ``turned``: winding and opening travel, rad; ``rate``: of one spring with these arms, N m/rad.
    """
    if not (row.material and row.wire_diameter and row.mean_diameter and row.body_coils):
        return None
    task = SpringTask(*turned, limits=SpringLimits(index_range=(1.0, 100.0)), free_arm=arm)
    try:
        material = catalogue.find_material(row.material)
        return check_spring(material, row.wire_diameter, row.mean_diameter, row.body_coils, task, stated_rate=rate)
    except UserError:
        return None  # ``spring_warnings`` reports that nothing was checked


def spring_to_wind(source: SpringSource, rate: float) -> tuple[SpringOption, list[str]]:
    """The spring to wind for a rate (N m/rad), or the nearest that can be made, and warnings.

    Raises
    ------
    UserError : no spring can be wound.
    """
    joint, choice, travel, catalogue, cad = source.joint, source.choice, source.turned, source.catalogue, source.cad
    wish = SpringRequirements(
        rate=rate,
        travel=travel.winding + STOP_ROOM,
        opening_travel=travel.opening + STOP_ROOM,
        included_angle=choice.included_angle or INCLUDED_ANGLE,
        leg_lengths=(ARM_LENGTH, ARM_LENGTH),
        material=choice.wire or "music",
        objective=choice.objective,
        rate_form=RATE_FORMS[choice.rate_formula],
        held_wire=source.held_wire,
        free_arm=JointArms(travel.opening + STOP_ROOM, cad),
        pitch=CLOSE_WOUND_PITCH,
        limits=SpringLimits(
            arbor_diameter=cad.shaft_diameter + 2.0 * cad.clearance,
            min_inside_diameter=choice.min_inner_diameter,
            max_outer_diameter=choice.max_outer_diameter,
            max_body_length=choice.max_body_length,
            cycles=choice.cycles,
        ),
    )
    result = design_spring(wish, catalogue, lasting=False)  # only its size is needed, for its arms
    if (first := result.best or (result.nearest[0].design if result.nearest else None)) is not None:
        size = (first.wire_diameter, first.mean_diameter, first.body_coils)
        leg = leg_that_bends_as_much(*size, wish.opening_travel, cad)
        result = design_spring(replace(wish, leg_lengths=(leg, leg)), catalogue)
    if result.best is not None:
        design, warnings = result.best, [about(joint, text) for text in (*result.notes, *result.best.warnings)]
        warnings += [f"{joint}: to last {DESIGN_LIFE:.0f} full turns: {item.text}" for item in result.lasting[:1]]
    else:
        if not result.nearest:
            raise CannotBeHad(f"{joint}: no spring can be wound for {rate:.4g} N*m/rad: {'; '.join(result.binding)}")
        order = {"parallel": 0, "smaller_travel": 1, "other_material": 2, "more_room": 3}
        nearest = min(result.nearest, key=lambda item: order[item.kind])
        design = nearest.design
        text = (
            f"{joint}: no single spring can have {rate:.4g} N*m/rad over {degrees(travel.winding):.1f} deg: "
            f"{'; '.join(result.binding)}. The nearest that can be made is taken: {nearest.text}"
        )
        warnings = [decisive(text)]
    total = design.rate * design.count
    closes = 1 if travel.turned_round else -1
    return SpringOption(total, design.included_angle, design=design, result=result, closes=closes, asked=rate), warnings


def sense_warning(joint: str, travel: WantedTravel) -> list[str]:
    """A warning if the travel would open a spring seated as in the thesis, so that the other seat is drawn."""
    if not travel.turned_round:
        return []
    return [
        f"{joint}: its spring turns {degrees(travel.winding):.0f} deg towards larger measured angles and only "
        f"{degrees(travel.opening):.0f} deg the other way. A torsion spring must be loaded in the winding direction, "
        "so it is seated the other way round: larger angles close its arms, and its arm offset is the free angle "
        "plus the included angle"
    ]


def _plain(option: SpringOption) -> SpringOption:
    """The option without the remarks on its row."""
    assert option.row is not None
    return replace(option, row=replace(option.row, derived=()))


def spring_warnings(joint: str, option: SpringOption) -> list[str]:
    """Warnings on a bought spring: it would yield within the travel, or values must be measured first."""
    if option.row is not None and option.row.derived:
        return [f"{joint}: {option.part} is {option.row.status}", *spring_warnings(joint, _plain(option))]
    if option.row is not None and option.check is None:
        return [f"{joint}: the catalogue has too few data of {option.part} to compute the angle at which it yields"]
    if option.check is None:
        return []
    check, found = option.check, []
    ways = (
        ("at", "turns", check.free_travel, check.travel),
        ("when opened", "opens", check.free_opening_travel, check.opening_travel),
    )
    for at, turns, free, turned in ways:
        if turned > free:
            text = f"{joint}: {option.part} yields {at} {degrees(free):.0f} deg from its free angle, but the joint "
            found.append(decisive(f"{text}{turns} it {degrees(turned):.0f} deg"))
    return found
