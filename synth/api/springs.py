"""``synth.spring``: design a torsion spring for a rate and a travel, or check a given one."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from synth.api.report import Cell, Panel, Report
from synth.api.spring_wish import spring_wish
from synth.files.shown_units import METRIC, ShownUnits
from synth.files.turns import WIDEST
from synth.parts.catalogs import Catalogue
from synth.spring.design import SpringResult, design_spring
from synth.spring.evaluate import check_spring
from synth.spring.spring_files import write_spring
from synth.spring.spring_requirements import SpringRequirements
from synth.spring.spring_result import SpringDesign
from synth.units import quantity


@dataclass(frozen=True, eq=False, repr=False)
class SpringAnswer(Report):
    """The designed spring, or the nearest ones that can be made.

    ``wish`` : the requirements. ``best`` : the spring, None if there is none. ``others`` : the next best, or the
    nearest to the requirements. ``in_the_way`` : the limits that prevent it. ``content`` : ``spring.json``.
    ``found`` : the complete search result, None if a given spring was checked.
    """

    wish: SpringRequirements
    best: SpringDesign | None
    others: tuple[SpringDesign, ...]
    in_the_way: tuple[str, ...]
    content: Mapping[str, Any]
    found: SpringResult | None = None
    shown: ShownUnits = METRIC

    @property
    def headline(self) -> str:
        """The spring to wind, or a statement that none can be made."""
        if self.best is None:
            asked = f"{self.wish.rate:.4g} N*m/rad over {math.degrees(self.wish.travel):.4g} deg"
            text = f"No single spring gives {asked} within the limits"
            if self.wish.travel <= WIDEST:
                return text
            # Some long coils of thin wire turn so far, so that it is no mistake by itself.
            return f'{text}. A number is in rad: for degrees write "{self.wish.travel:.6g} deg"'
        best = self.best
        return (
            f"{best.body_coils:.4g} coils of {best.wire_diameter * 1e3:.4g} mm {best.material}, mean diameter "
            f"{best.mean_diameter * 1e3:.2f} mm: {best.rate:.4g} N*m/rad"
        )

    @property
    def springs(self) -> tuple[SpringDesign, ...]:
        """The best and the others."""
        return (*(() if self.best is None else (self.best,)), *self.others)

    def columns(self) -> dict[str, list[Cell]]:
        """One row per spring, the best first."""
        rows = self.springs
        return {
            "material": [s.material for s in rows],
            "count": [s.count for s in rows],
            "wire diameter [mm]": [s.wire_diameter * 1e3 for s in rows],
            "mean diameter [mm]": [s.mean_diameter * 1e3 for s in rows],
            "body coils": [s.body_coils for s in rows],
            "rate [N*m/rad]": [s.rate for s in rows],
            "travel [deg]": [math.degrees(s.travel) for s in rows],
            "stress [MPa]": [s.stress / 1e6 for s in rows],
            "allowed stress [MPa]": [s.allowed_stress / 1e6 for s in rows],
            "mass [g]": [s.mass * 1e3 for s in rows],
            "feasible": [s.feasible for s in rows],
        }

    def panels(self) -> Sequence[Panel]:
        """Stress in the wire over the angle from rest up to the travel; the torque is the same for all."""
        curves = {}
        for number, spring in enumerate(self.springs):
            angle = np.array([0.0, spring.travel])
            name = f"{number + 1}: {spring.wire_diameter * 1e3:.4g} mm"
            curves[name] = (np.degrees(angle), spring.stress / 1e6 * angle / spring.travel)
        return [Panel("stress in the wire", "angle from rest [deg]", "stress [MPa]", curves)] if curves else []

    def inputs(self) -> tuple[list[Path], list[str]]:
        """None: a wish is no file."""
        return [], []

    def write(self, folder: Path) -> None:
        """``spring.json``; for a feasible spring its solid, winding sheet and request for quotation too."""
        write_spring(self.best, self.content, folder, self.shown)


def spring(
    rate: str | float,
    travel: str | float,
    *,
    wish: Mapping[str, Any] | None = None,
    catalogue: Catalogue | None = None,
) -> SpringAnswer:
    """Design a torsion spring.

    Parameters
    ----------
    rate
        spring rate: text with a unit, or N m/rad.
    travel
        largest angle from rest that winds the coil up: text with a unit, or rad.
    wish
        further fields of ``SpringRequirements``: ``included_angle``, ``material``, ``limits``, ...; quantities are text
        with a unit, or in SI and radians. ``limits`` : ``{"max_outer_diameter": "20 mm", ...}``, or ``SpringLimits``.
    catalogue
        of wire; default: the built-in one.

    Raises
    ------
    UserError
        If a quantity cannot be read or is outside the range of the command, or a name, a word or the material is
        unknown. That no spring can be made is a valid result.
    """
    return to_wind(spring_wish(rate, travel, wish or {}), catalogue or Catalogue.load())


def to_wind(wish: SpringRequirements, catalogue: Catalogue, shown: ShownUnits = METRIC) -> SpringAnswer:
    """The spring for a complete request."""
    result = design_spring(wish, catalogue)
    content = result.as_json()
    content["wanted"] |= limits_json(wish)
    others = result.alternatives if result.best is not None else tuple(item.design for item in result.nearest)
    return SpringAnswer(wish, result.best, tuple(others), tuple(result.binding), content, result, shown)


def given_spring(
    wish: SpringRequirements,
    sizes: tuple[float, float, float],
    catalogue: Catalogue,
    *,
    included_angle: float | None = None,
    stated_rate: float | None = None,
    shown: ShownUnits = METRIC,
) -> SpringAnswer:
    """Check a spring of wire diameter m, mean diameter m and body coils; ``stated_rate`` N m/rad as measured."""
    material = catalogue.find_material(wish.material)
    wish.calibration.require_for(material.name, wish.rate_form)
    made = check_spring(material, *sizes, wish.task, included_angle=included_angle, stated_rate=stated_rate)
    broken = tuple(violation.text for violation in made.violations)
    content = {
        "format": "synth/spring/1",
        "wanted": {
            "travel": quantity(wish.travel, "deg"),
            "opening_travel": quantity(wish.opening_travel, "deg"),
            "leg_convention": wish.convention,
            "material": wish.material,
            **limits_json(wish),
        },
        "checked": made.as_json(),
        "make": made.as_json() if made.feasible else None,
        "alternatives": [],
        "binding": list(broken),
        "nearest": [],
    }
    return SpringAnswer(wish, made, (), broken, content, None, shown)


def limits_json(wish: SpringRequirements) -> dict[str, Any]:
    """The given legs and limits with their units."""
    limits = wish.limits
    lengths = {name: getattr(limits, name) for name in ("arbor_diameter", "max_outer_diameter", "max_body_length")}
    return {
        "leg_lengths": [quantity(length, "mm") for length in wish.leg_lengths],
        **{name: quantity(value, "mm") for name, value in lengths.items() if value is not None},
        "safety": quantity(limits.safety, "1"),
        **({} if limits.cycles is None else {"cycles": quantity(limits.cycles, "1")}),
        **({} if limits.cycles is None else {"fatigue_safety": quantity(limits.fatigue_safety, "1")}),
    }
