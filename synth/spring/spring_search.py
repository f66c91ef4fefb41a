"""The search for springs to wind: every stock wire and every whole number of coils, ranked by the objective.

For one wire the rate determines the product D N of mean diameter and coils. Wire length and mass therefore depend on
the wire alone. The split between D and N trades the outer diameter against the arbor and the spring index. The search
tries every stock size and every whole number of coils (the fraction follows from the included angle). It is
exhaustive: some thousand candidates.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeVar

from synth.files.spring_words import Objective
from synth.parts.coil_angle import coil_fraction
from synth.parts.coil_rate import coil_product, mean_diameter_for
from synth.parts.wire import WireMaterial
from synth.spring import evaluate
from synth.spring.evaluate import check_spring, kept_spring
from synth.spring.sizes_alone import Room, least_mass, may_bear, room_of, surely_broken
from synth.spring.space import cylinder
from synth.spring.spring_requirements import SpringRequirements
from synth.spring.spring_result import FEWEST_COILS, SpringDesign
from synth.spring.spring_task import SpringLimits
from synth.spring.unit_text import MeasuredText, UnitText

# Designs up to this multiple of the least mass are ranked by size, heavier ones by mass. The lightest wire that keeps
# the limits does so only as the widest coil with the fewest turns, where the curvature factor is lowest: a tenth more
# wire often halves the diameter.
NEARLY_AS_LIGHT = 1.25
SAME_WIRE = 1e-6  # relative: wire diameters this close are one size
ALIKE_WIRES = 0.02  # relative: an inch and a metric size this close
ENDLESS = 1.5  # strength over stress at 1e6 cycles; above it, more strength does not count as longer life

S = TypeVar("S", SpringDesign, "_SizedCandidate")


def feasible_candidates(
    wish: SpringRequirements, material: WireMaterial, only: float | None = None
) -> Iterator[SpringDesign]:
    """The candidates that keep all limits; ``only`` as in ``candidates``."""
    for sizes in _sizes(wish, material, only):
        if (design := _feasible(material, sizes, wish)) is not None:
            yield design


def _feasible(
    material: WireMaterial, sizes: tuple[float, float, float], wish: SpringRequirements
) -> SpringDesign | None:
    """The spring of these sizes, if it keeps all limits."""
    return None if surely_broken(material, sizes, wish.task) else kept_spring(material, sizes, wish.task)


def suits(design: SpringDesign, limits: SpringLimits) -> bool:
    """Whether a spring meets every preference."""
    return design.body_coils >= FEWEST_COILS and lasts(design, limits)


class SpringSearch:
    """The springs that keep all limits and ``suits``, best first; not for the objective ``life``, which ranks by load.

    Mass and size need no load, so the candidates are ranked first, and their loads computed only until each wire has
    its spring: a third of the time. Wires that break for certain, or that are heavier than what is sought, are not
    looked at. ``only``: a wire diameter, m, to which the search is restricted.
    """

    def __init__(self, wish: SpringRequirements, material: WireMaterial, only: float | None = None) -> None:
        self._wish, self._material, self._task = wish, material, wish.task
        self._wires = [each for each in _wires(wish, material, only) if may_bear(wish.rate, self._task, material, each)]
        self._least = {wire: least_mass(wish.rate, self._task, material, wire) for wire in self._wires}
        self._of_wire: dict[float, list[_SizedCandidate]] = {}
        self._known: dict[tuple[float, float, float], SpringDesign | None] = {}

    def lightest(self) -> SpringDesign | None:
        """The spring of the least mass; None if there is no spring."""
        bounds, below = sorted({*self._least.values(), math.inf}), 0.0
        for bound in bounds:
            window = [one for one in self._sized(bound) if below <= one.mass < bound]
            found = next(filter(None, map(self._found, sorted(window, key=lambda one: one.mass))), None)
            if found is not None:
                return found
            below = bound
        return None

    def best_of_wires(self, most: int) -> list[SpringDesign]:
        """The first ``most`` of ``distinct_wires(ranked(...))`` of the springs."""
        lightest = self.lightest()
        kept: list[SpringDesign] = []
        if lightest is None:
            return kept
        by_size = self._wish.objective == "space"
        for bound in (math.inf,) if by_size else (NEARLY_AS_LIGHT * lightest.mass, math.inf):
            kept = self._first(most, [one for one in self._sized(bound) if one.mass <= bound], lightest.mass)
            if len(kept) == most:
                break
        return kept

    def _first(self, most: int, sized: list[_SizedCandidate], lightest: float) -> list[SpringDesign]:
        kept: list[SpringDesign] = []
        for one in _in_order(sized, self._wish.objective, lightest):
            if all(_other_wire(one.sizes[0], design.wire_diameter) for design in kept):
                design = self._found(one)
                kept += [design] if design is not None else []
                if len(kept) == most:
                    break
        return kept

    def _sized(self, most: float) -> list[_SizedCandidate]:
        """The candidates of all wires of which a spring of ``most`` kg or less may be wound."""
        found: list[_SizedCandidate] = []
        for wire in self._wires:
            if self._least[wire] <= most:
                if wire not in self._of_wire:
                    self._of_wire[wire] = [
                        _SizedCandidate(sizes, room_of(self._material, sizes, self._task))
                        for sizes in _sizes_of(wire, self._wish, self._material)
                        if sizes[2] >= FEWEST_COILS and not surely_broken(self._material, sizes, self._task)
                    ]
                found += self._of_wire[wire]
        return found

    def _found(self, one: _SizedCandidate) -> SpringDesign | None:
        if one.sizes not in self._known:
            self._known[one.sizes] = kept_spring(self._material, one.sizes, self._task, lasting=True)
        return self._known[one.sizes]


@dataclass(frozen=True)
class _SizedCandidate:
    """A candidate's sizes, as of ``_sizes``, and its room; named as in ``SpringDesign``."""

    sizes: tuple[float, float, float]
    room: Room

    @property
    def mass(self) -> float:
        return self.room.mass

    @property
    def widest_outer_diameter(self) -> float:
        return self.room.widest_outer_diameter

    @property
    def wound_body_length(self) -> float:
        return self.room.wound_body_length

    @property
    def volume(self) -> float:
        return cylinder(self.room.widest_outer_diameter, self.room.wound_body_length)


def candidates(wish: SpringRequirements, material: WireMaterial) -> Iterator[SpringDesign]:
    """Every spring of stock wire with the required rate and included angle, including those that violate limits."""
    return (check_spring(material, *sizes, wish.task) for sizes in _sizes(wish, material, None))


def _sizes(
    wish: SpringRequirements, material: WireMaterial, only: float | None
) -> Iterator[tuple[float, float, float]]:
    """Wire diameter, mean diameter (m) and body coils of every candidate.

    ``only``: a wire diameter, m, to which the search is restricted. All candidates keep the limits on spring index and
    coils, because the formulas do not hold outside them, and have an allowed wire.
    """
    for wire in _wires(wish, material, only):
        yield from _sizes_of(wire, wish, material)


def _wires(wish: SpringRequirements, material: WireMaterial, only: float | None) -> Iterator[float]:
    """The allowed stock diameters, m."""
    for row in material.stock(wish.system):
        assert row.diameter is not None
        wire = row.diameter
        if only is not None and not math.isclose(wire, only, rel_tol=SAME_WIRE):
            continue
        if wish.wire_range[0] * (1.0 - SAME_WIRE) <= wire <= wish.wire_range[1] * (1.0 + SAME_WIRE):
            yield wire


def _sizes_of(wire: float, wish: SpringRequirements, material: WireMaterial) -> Iterator[tuple[float, float, float]]:
    """As ``_sizes``, of one wire (diameter, m)."""
    limits = wish.limits
    fraction = coil_fraction(wish.included_angle, wish.convention)
    modulus = material.properties(wire).elastic_modulus * wish.calibration.rate
    product = coil_product(modulus, wire, wish.rate, wish.rate_form)
    # Other arms than tangent ones take a share of the product that depends on the coil: from none on.
    tangent = wish.convention == "tangent"
    most = mean_diameter_for(product, 1.0, wish.leg_lengths) if tangent else product
    for whole in _whole_coils(most / wire, limits, from_first=not tangent):
        coils = whole + fraction
        if not limits.min_coils <= coils <= limits.max_coils:
            continue
        mean = mean_diameter_for(product, coils, wish.leg_lengths, wish.convention)
        if limits.index_range[0] <= mean / wire <= limits.index_range[1]:
            yield wire, mean, coils


def _whole_coils(product: float, limits: SpringLimits, *, from_first: bool = False) -> range:
    """Whole coils to try where spring index times coils is ``product``: all of an allowed index, and some more.

    ``from_first`` : that product is the largest, and there may be fewer coils.
    """
    low, high = (product / index if index > 0.0 else math.inf for index in limits.index_range[::-1])
    first = 0.0 if from_first else max(0.0, low - 2.0)  # a fraction of a coil is added to each; one more for rounding
    return range(math.floor(first), math.floor(max(first, min(limits.max_coils, high + 1.0))) + 1)


def lasts(design: SpringDesign, limits: SpringLimits) -> bool:
    """Whether the spring lasts the required number of full-travel cycles, or ``DESIGN_LIFE`` if none is required."""
    return evaluate.lasts(design.life, limits)


def rank_springs(designs: list[SpringDesign], objective: Objective) -> list[SpringDesign]:
    """The springs, best first by the objective of ``SpringRequirements``."""
    if objective == "life":
        return sorted(designs, key=lambda design: (-endurance(design), design.mass, design.volume))
    return _in_order(designs, objective, min((design.mass for design in designs), default=0.0))


def _in_order(designs: list[S], objective: Objective, lightest: float) -> list[S]:
    """Best first by size or mass; ``lightest``: the least mass (kg) that is possible."""
    if objective == "space":
        return sorted(designs, key=lambda design: (design.volume, design.mass))
    enough = NEARLY_AS_LIGHT * lightest
    light = sorted((d for d in designs if d.mass <= enough), key=lambda d: (_larger_dimension(d), d.mass))
    return light + sorted((d for d in designs if d.mass > enough), key=lambda d: (d.mass, d.volume))


def _larger_dimension(design: SpringDesign | _SizedCandidate) -> float:
    """Widest outer diameter or wound body length, whichever is larger, m."""
    return max(design.widest_outer_diameter, design.wound_body_length)


def endurance(design: SpringDesign) -> float:
    """The figure that the objective ``life`` maximises: strength over stress at 1e6 cycles, at most ``ENDLESS``.

    For a wire without fatigue data: yield stress over stress.
    """
    return min(ENDLESS, design.safety if design.life is None else design.life.factor_1e6)


def distinct_wires(ranked: list[SpringDesign]) -> list[SpringDesign]:
    """The best spring of each wire; sizes within ``ALIKE_WIRES`` of each other count as one wire."""
    kept: list[SpringDesign] = []
    for design in ranked:
        if all(_other_wire(design.wire_diameter, other.wire_diameter) for other in kept):
            kept.append(design)
    return kept


def _other_wire(wire: float, kept: float) -> bool:
    return abs(wire / kept - 1.0) > ALIKE_WIRES


def worst_excess(design: SpringDesign) -> float:
    """The largest ratio by which a limit is violated; 1 if none is."""
    return max((violation.excess for violation in design.violations), default=1.0)


def describe(design: SpringDesign) -> UnitText:
    """The spring in one line of text."""
    wire, mean = MeasuredText(design.wire_diameter, "m"), MeasuredText(design.mean_diameter, "m")
    coils, rate = f", {design.body_coils:.4g} coils, ", MeasuredText(design.rate, "N*m/rad")
    return UnitText("wire ", wire, ", mean diameter ", mean, coils, rate)
