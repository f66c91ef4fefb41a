"""Choosing springs: a bought one where one meets the constraints, else one to wind; ranked by the leg's response."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import degrees, radians
from typing import Any

import numpy as np

from synth.errors import UserError
from synth.files.options import CadOptions, JointChoice, SpringChoice
from synth.model.leg import Leg, Spring
from synth.parts.candidates import no_spring, spring_candidates
from synth.parts.catalog import Catalogue
from synth.parts.response import WantedResponse
from synth.parts.rows import TorsionSpringRow
from synth.spring.design import SpringResult, SpringWish, design_spring
from synth.spring.evaluate import check_spring
from synth.spring.result import SpringDesign, SpringLimits, SpringTask
from synth.units import quantity

KEPT = 4  # springs a joint that take part in the choice for all joints together
INCLUDED_ANGLE = radians(120.0)  # of a spring to wind where none is asked: that of the thesis' springs
ARM_LENGTH = 0.025  # m, of a spring to wind, up to where it bears


@dataclass(frozen=True)
class Travel:
    """How far a joint's spring is turned from its free angle: the farther side, which winds it, and the other; rad."""

    winding: float
    opening: float


@dataclass(frozen=True)
class SpringOption:
    """A spring at a joint: bought (``row``) or to wind (``design``, with how it was found in ``result``).

    ``rate`` N m/rad is what acts at the joint, all parallel springs together.
    """

    rate: float
    included_angle: float
    row: TorsionSpringRow | None = None
    design: SpringDesign | None = None
    result: SpringResult | None = None
    check: SpringDesign | None = None
    error: float = float("nan")

    @property
    def part(self) -> str:
        """Part number, or what is to be wound."""
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
                "rate": quantity(self.rate, "N*m/rad"),
                "included_angle": quantity(self.included_angle, "deg"),
                "material": row.material,
                "hand": row.hand or None,
                "source": row.source,
            }
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
            written["nearest"] = [
                {"kind": item.kind, "text": item.text, "make": item.design.as_json()} for item in self.result.nearest
            ]
        return written


@dataclass(frozen=True)
class SpringChoiceMade:
    """The chosen springs, the ranking a joint, what was left out, the leg as built, and the next best sets."""

    chosen: tuple[SpringOption, ...]
    ranked: tuple[tuple[SpringOption, ...], ...]
    left_out: tuple[Mapping[str, int], ...]
    leg: Leg
    sets: tuple[tuple[tuple[SpringOption, ...], float], ...]
    warnings: tuple[tuple[str, ...], ...]


def travels(leg: Leg, motions: Sequence[np.ndarray[Any, Any]]) -> list[Travel]:
    """Each spring's travel from its free angle: over the joint's range where the leg has one, else as the leg moves.

    ``motions`` : (m, n) rotations, rad. The farther side of the two winds the coil.
    """
    found = []
    for j, joint in enumerate(leg.joints):
        assert joint.spring is not None
        if joint.range is not None:
            ends = [angle - joint.spring.free_angle for angle in joint.range]
        else:
            rest = joint.sign * (joint.spring.free_angle - joint.zero)
            turned = np.concatenate([motion[:, j] for motion in motions]) - rest
            ends = [float(turned.min()), float(turned.max())]
        sides = sorted((abs(min(0.0, *ends)), abs(max(0.0, *ends))))
        found.append(Travel(sides[1], sides[0]))
    return found


def choose_springs(
    wanted: WantedResponse,
    fitted: Leg,
    choices: Mapping[str, JointChoice],
    catalogue: Catalogue,
    travel: Sequence[Travel],
    cad: CadOptions,
) -> SpringChoiceMade:
    """Choose every joint's spring for the leg whose dampers are chosen and whose spring rates were fitted with them.

    Every set is judged with free angles that bring the leg to rest in the wanted pose: the arm offset is ours to set.

    Raises
    ------
    UserError : a joint asks for a bought spring and none meets its constraints.
    """
    per_joint, left_out, warnings = [], [], []
    for joint, turned in zip(fitted.joints, travel, strict=True):
        assert joint.spring is not None
        choice = choices[joint.name].spring
        options, reasons, said = _options(joint.name, choice, joint.spring.rate, turned, catalogue, cad)
        legs = [wanted.at_rest_like_wanted(_with(fitted, {joint.name: option.rate})) for option in options]
        errors = wanted.overall(legs)
        order = np.argsort(errors, kind="stable")
        per_joint.append(tuple(replace(options[k], error=float(errors[k])) for k in order))
        left_out.append(reasons)
        warnings.append(tuple(said))
    names = fitted.joint_names
    sets = list(product(*(options[:KEPT] for options in per_joint)))
    legs = [
        wanted.at_rest_like_wanted(_with(fitted, {n: o.rate for n, o in zip(names, chosen, strict=True)}))
        for chosen in sets
    ]
    errors = wanted.overall(legs)
    order = np.argsort(errors, kind="stable")
    tried = tuple((sets[k], float(errors[k])) for k in order)
    chosen, leg = tried[0][0], legs[order[0]]
    return SpringChoiceMade(chosen, tuple(per_joint), tuple(left_out), leg, tried, tuple(warnings))


def _options(
    joint: str, choice: SpringChoice, rate: float, travel: Travel, catalogue: Catalogue, cad: CadOptions
) -> tuple[list[SpringOption], Mapping[str, int], list[str]]:
    """What a joint may have: bought springs, or one to wind; why rows were left out; what is to be said."""
    if choice.travel is not None:
        travel = Travel(choice.travel, min(travel.opening, choice.travel))
    reasons: Mapping[str, int] = {}
    if not choice.make:
        found = spring_candidates(catalogue, choice, rate)
        reasons = found.left_out
        if found.rows:
            options = [_bought(row, travel, catalogue) for row in found.rows]
            return options, reasons, []
        if choice.make is False:
            raise no_spring(joint, found, catalogue.springs)
        said = [f"{joint}: no bought spring meets the constraints ({found.nearest}); one to wind is designed"]
    else:
        said = []
    option, more = _to_wind(joint, choice, rate, travel, catalogue, cad)
    return [option], reasons, said + more


def _bought(row: TorsionSpringRow, travel: Travel, catalogue: Catalogue) -> SpringOption:
    assert row.rate is not None
    assert row.included_angle is not None
    check = None
    if row.material and row.wire_diameter and row.mean_diameter and row.body_coils:
        try:
            task = SpringTask(travel.winding, travel.opening, limits=SpringLimits(index_range=(1.0, 100.0)))
            material = catalogue.find_material(row.material)
            check = check_spring(
                material, row.wire_diameter, row.mean_diameter, row.body_coils, task, stated_rate=row.rate
            )
        except UserError:
            check = None  # no strength is known for this wire; ``spring_warnings`` says that nothing was checked
    return SpringOption(row.rate, row.included_angle, row=row, check=check)


def _to_wind(
    joint: str, choice: SpringChoice, rate: float, travel: Travel, catalogue: Catalogue, cad: CadOptions
) -> tuple[SpringOption, list[str]]:
    """The spring to wind, or the nearest that can be made with what gives way."""
    wish = SpringWish(
        rate=rate,
        travel=travel.winding,
        opening_travel=travel.opening,
        included_angle=choice.included_angle or INCLUDED_ANGLE,
        leg_lengths=(ARM_LENGTH, ARM_LENGTH),
        material=choice.wire or "music",
        limits=SpringLimits(
            arbor_diameter=cad.shaft_diameter,
            min_inside_diameter=choice.min_inner_diameter,
            max_outer_diameter=choice.max_outer_diameter,
            max_body_length=choice.max_body_length,
        ),
    )
    result = design_spring(wish, catalogue)
    if result.best is not None:
        design, said = result.best, [f"{joint}: {text}" for text in result.best.warnings]
    else:
        if not result.nearest:
            raise UserError(f"{joint}: no spring can be wound for {rate:.4g} N*m/rad: {'; '.join(result.binding)}")
        order = {"parallel": 0, "smaller_travel": 1, "other_material": 2, "more_room": 3}
        nearest = min(result.nearest, key=lambda item: order[item.kind])
        design = nearest.design
        said = [
            f"{joint}: no single spring can do {rate:.4g} N*m/rad over {degrees(travel.winding):.1f} deg: "
            f"{'; '.join(result.binding)}. The nearest that can is taken: {nearest.text}"
        ]
    total = design.rate * design.count
    return SpringOption(total, design.included_angle, design=design, result=result), said


def spring_warnings(joint: str, option: SpringOption) -> list[str]:
    """A bought spring that would yield over the wanted travel."""
    if option.row is not None and option.check is None:
        return [f"{joint}: the catalogue knows too little of {option.part} to tell at which angle it yields"]
    if option.check is None or option.check.travel <= option.check.free_travel:
        return []
    return [
        f"{joint}: {option.part} yields at {degrees(option.check.free_travel):.0f} deg from its free angle, the joint "
        f"turns it {degrees(option.check.travel):.0f} deg"
    ]


def _with(leg: Leg, rates: Mapping[str, float]) -> Leg:
    joints = []
    for joint in leg.joints:
        assert joint.spring is not None
        rate = rates.get(joint.name, joint.spring.rate)
        joints.append(replace(joint, spring=Spring(rate, joint.spring.free_angle)))
    return replace(leg, joints=tuple(joints))
