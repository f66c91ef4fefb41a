"""The search for springs to wind: every stock wire and every whole number of coils, ranked by the objective.

For one wire the rate determines the product D N of mean diameter and coils. Wire length and mass therefore depend on
the wire alone. The split between D and N trades the outer diameter against the arbor and the spring index. The search
tries every stock size and every whole number of coils (the fraction follows from the included angle). It is
exhaustive: some thousand candidates.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from synth.parts.coil_angle import coil_fraction
from synth.parts.coil_rate import coil_product, mean_diameter_for
from synth.parts.wire import WireMaterial
from synth.spring.evaluate import check_spring, surely_broken
from synth.spring.spring_requirements import Objective, SpringRequirements
from synth.spring.spring_result import DESIGN_LIFE, SpringDesign, SpringLimits

# Designs up to this multiple of the least mass are ranked by size, heavier ones by mass. The lightest wire that keeps
# the limits does so only as the widest coil with the fewest turns, where the curvature factor is lowest: a tenth more
# wire often halves the diameter.
NEARLY_AS_LIGHT = 1.25
SAME_WIRE = 1e-6  # relative: wire diameters this close are one size
ENDLESS = 1.5  # strength over stress at 1e6 cycles; above it, more strength does not count as longer life


def feasible_candidates(
    wish: SpringRequirements, material: WireMaterial, only: float | None = None
) -> Iterator[SpringDesign]:
    """The candidates that keep all limits; ``only`` as in ``candidates``."""
    for sizes in _sizes(wish, material, only):
        if not surely_broken(material, sizes, wish.task):
            design = check_spring(material, *sizes, wish.task)
            if design.feasible:
                yield design


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
    limits = wish.limits
    fraction = coil_fraction(wish.included_angle, wish.convention)
    for row in material.stock(wish.system):
        assert row.diameter is not None
        wire = row.diameter
        if only is not None and not math.isclose(wire, only, rel_tol=SAME_WIRE):
            continue
        if not wish.wire_range[0] * (1.0 - SAME_WIRE) <= wire <= wish.wire_range[1] * (1.0 + SAME_WIRE):
            continue
        modulus = material.properties(wire).elastic_modulus * wish.calibration.rate
        product = coil_product(modulus, wire, wish.rate, wish.rate_form)
        for whole in _whole_coils(mean_diameter_for(product, 1.0, wish.leg_lengths) / wire, limits):
            coils = whole + fraction
            if not limits.min_coils <= coils <= limits.max_coils:
                continue
            mean = mean_diameter_for(product, coils, wish.leg_lengths)
            if limits.index_range[0] <= mean / wire <= limits.index_range[1]:
                yield wire, mean, coils


def _whole_coils(product: float, limits: SpringLimits) -> range:
    """Whole coils to try where spring index times coils is ``product``: all of an allowed index, and some more."""
    low, high = (product / index if index > 0.0 else math.inf for index in limits.index_range[::-1])
    first = max(0.0, low - 2.0)  # a fraction of a coil is added to each; one more for rounding
    return range(math.floor(first), math.floor(max(first, min(limits.max_coils, high + 1.0))) + 1)


def lasts(design: SpringDesign, limits: SpringLimits) -> bool:
    """Whether the spring lasts the required number of full-travel cycles, or ``DESIGN_LIFE`` if none is required."""
    cycles = DESIGN_LIFE if limits.cycles is None else limits.cycles
    return design.life is not None and design.life.factor(cycles) >= limits.fatigue_safety


def ranked(designs: list[SpringDesign], objective: Objective) -> list[SpringDesign]:
    """The springs, best first by the objective of ``SpringRequirements``."""
    if objective == "life":
        return sorted(designs, key=lambda design: (-endurance(design), design.mass, design.volume))
    if objective == "space":
        return sorted(designs, key=lambda design: (design.volume, design.mass))
    enough = NEARLY_AS_LIGHT * min((design.mass for design in designs), default=0.0)
    light = sorted((d for d in designs if d.mass <= enough), key=lambda d: (_larger_dimension(d), d.mass))
    return light + sorted((d for d in designs if d.mass > enough), key=lambda d: (d.mass, d.volume))


def _larger_dimension(design: SpringDesign) -> float:
    """Outer diameter or wound body length, whichever is larger, m."""
    return max(design.outer_diameter, design.wound_body_length)


def endurance(design: SpringDesign) -> float:
    """The figure that the objective ``life`` maximises: strength over stress at 1e6 cycles, at most ``ENDLESS``.

    For a wire without fatigue data: yield stress over stress.
    """
    return min(ENDLESS, design.safety if design.life is None else design.life.factor_1e6)


def distinct_wires(ranked: list[SpringDesign]) -> list[SpringDesign]:
    """The best spring of each wire; inch and metric sizes within 2 % of each other count as one wire."""
    kept: list[SpringDesign] = []
    for design in ranked:
        if all(abs(design.wire_diameter / other.wire_diameter - 1.0) > 0.02 for other in kept):
            kept.append(design)
    return kept


def worst_excess(design: SpringDesign) -> float:
    """The largest ratio by which a limit is violated; 1 if none is."""
    return max((violation.excess for violation in design.violations), default=1.0)


def describe(design: SpringDesign) -> str:
    """The spring in one line of text."""
    return (
        f"wire {design.wire_diameter * 1e3:.4g} mm, mean diameter {design.mean_diameter * 1e3:.4g} mm, "
        f"{design.body_coils:.4g} coils, {design.rate:.4g} N*m/rad"
    )
