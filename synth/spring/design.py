"""Design of a spring to wind: the best one and the next best wires, or the reasons why there is none."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from itertools import islice
from typing import Any

from synth.parts.catalogs import Catalogue
from synth.parts.coil_rate import RATE_FORMULA
from synth.parts.wire import WireMaterial
from synth.spring.nearest_springs import NearestSpring, limits_in_the_way, nearest_lasting, nearest_springs
from synth.spring.preferred_springs import prefer_springs
from synth.spring.spring_requirements import SpringRequirements, require_possible
from synth.spring.spring_result import DESIGN_LIFE, SpringDesign
from synth.spring.spring_search import (
    SAME_WIRE,
    SpringSearch,
    candidates,
    distinct_wires,
    endurance,
    feasible_candidates,
    lasts,
    rank_springs,
    suits,
)
from synth.units import quantity

# A spring of the held wire may be this much heavier, larger or less enduring than the best: two inch sizes, each of
# which changes the mass by 1.1 to 1.3; a metric one changes it by 1.3 to 2.1. More than ``NEARLY_AS_LIGHT``, else two
# wires at that limit could alternate.
HELD_RATIO = 1.4


@dataclass(frozen=True)
class SpringResult:
    """The best spring and the next best wires, or the limits that prevent one and the nearest that can be made.

    ``binding``: the limits that prevent a spring, as text with their numbers; empty if there is a spring. ``lasting``:
    if the best spring does not last ``DESIGN_LIFE``, the nearest springs that do. ``notes``: why the best spring has
    few coils, or does not last.
    """

    wish: SpringRequirements
    best: SpringDesign | None
    alternatives: tuple[SpringDesign, ...]
    binding: tuple[str, ...]
    nearest: tuple[NearestSpring, ...]
    lasting: tuple[NearestSpring, ...] = ()
    notes: tuple[str, ...] = ()

    def as_json(self) -> dict[str, Any]:
        """For ``spring.json``."""
        return {
            "format": "synth/spring/1",
            "wanted": {
                "rate": quantity(self.wish.rate, "N*m/rad"),
                "travel": quantity(self.wish.travel, "deg"),
                "opening_travel": quantity(self.wish.opening_travel, "deg"),
                "included_angle": quantity(self.wish.included_angle, "deg"),
                "leg_convention": self.wish.convention,
                "objective": self.wish.objective,
                "hand": self.wish.hand,
                "material": self.wish.material,
                "rate_formula": RATE_FORMULA[self.wish.rate_form],
            },
            "make": None if self.best is None else self.best.as_json(),
            "alternatives": [design.as_json() for design in self.alternatives],
            "binding": list(self.binding),
            "nearest": [item.as_json() for item in self.nearest],
            "design_life": {
                **quantity(self.wish.limits.cycles or DESIGN_LIFE, "1"),
                "asked": self.wish.limits.cycles is not None,
                "kept": None if self.best is None else lasts(self.best, self.wish.limits),
            },
            "lasting": [item.as_json() for item in self.lasting],
            "notes": list(self.notes),
        }


def design_spring(
    wish: SpringRequirements,
    catalogue: Catalogue | None = None,
    n_alternative: int = 4,
    *,
    lasting: bool = True,
    n_nearest: int | None = None,
) -> SpringResult:
    """Find the spring to wind.

    ``n_alternative`` is the largest number of other wires that the result lists. ``lasting``: whether to look for the
    nearest springs that last, if the best one does not; that takes longer than the best spring itself.
    ``n_nearest``: the largest number of nearest springs, if there is none; None: all.

    Raises
    ------
    UserError
        For impossible requirements (such as a rate or travel that is not positive), with every one of them at once;
        for a calibration of another wire or rate formula.
    """
    require_possible(wish)
    catalogue = catalogue or Catalogue.load()
    material = catalogue.find_material(wish.material)
    wish.calibration.require_for(material.name, wish.rate_form)
    if wish.objective != "life":
        search = SpringSearch(wish, material)
        if wires := search.best_of_wires(n_alternative + 1):
            held = _of_held_wire(wish, material, search.lightest() if wish.objective == "mass" else wires[0])
            best, *others = wires if held is None else [held]
            return SpringResult(wish, best, tuple(others), (), ())
    good = list(feasible_candidates(wish, material))
    if good:
        kept, notes = prefer_springs(good, partial(candidates, wish, material), wish)
        best, *others = distinct_wires(rank_springs(kept, wish.objective))
        if (same := _as_enduring(kept, wish, best)) is not None:
            return SpringResult(wish, same, (), (), ())
        wanting = lasting and not lasts(best, wish.limits)
        longer = tuple(nearest_lasting(wish, material, catalogue)) if wanting else ()
        return SpringResult(wish, best, tuple(others[:n_alternative]), (), (), longer, notes)
    found = list(candidates(wish, material))
    nearest = islice(nearest_springs(found, wish, material, catalogue), n_nearest)
    return SpringResult(wish, None, (), tuple(limits_in_the_way(found, wish)), tuple(nearest))


def _of_held_wire(wish: SpringRequirements, material: WireMaterial, least: SpringDesign | None) -> SpringDesign | None:
    """The spring of ``wish.held_wire``, if it suits and is not much heavier, or larger, than the ``least``."""
    if wish.held_wire is None or least is None:
        return None
    for held in SpringSearch(wish, material, wish.held_wire).best_of_wires(1):
        size, smallest = (each.mass if wish.objective == "mass" else each.volume for each in (held, least))
        return held if size <= HELD_RATIO * smallest else None
    return None


def _as_enduring(kept: list[SpringDesign], wish: SpringRequirements, best: SpringDesign) -> SpringDesign | None:
    """For the objective ``life``, the spring of ``wish.held_wire``, if it suits and endures nearly as much."""
    if wish.held_wire is None or wish.objective != "life":
        return None
    held = [
        d for d in kept if math.isclose(d.wire_diameter, wish.held_wire, rel_tol=SAME_WIRE) and suits(d, wish.limits)
    ]
    return next((d for d in rank_springs(held, "life") if HELD_RATIO * endurance(d) >= endurance(best)), None)
