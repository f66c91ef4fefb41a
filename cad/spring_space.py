"""The coil's room over the joint's travel: pocket, arbor, and how long an arm must be. Plain arithmetic, no solids."""

from __future__ import annotations

import math
from dataclasses import dataclass

from cad.dimensions import JointDimensions
from cad.limits import DimensionProblem

PIN_OVERHANG = 1.0  # mm that an arm reaches past its shaft, and a shaft past its arm
SMALLEST_ARBOR_WALL = 1.2  # mm, two printed lines; a thinner arbor is left out


@dataclass(frozen=True)
class SpringSpace:
    pocket_radius: float
    tongue_radius: float
    arbor_radius: float
    radius_closed: float
    radius_open: float
    growth: float  # along z, of the closing coil
    drop: float  # along z, of the opening coil, which has fewer turns
    shortest_arm: float
    problems: tuple[DimensionProblem, ...]


def loaded_diameter(mean_diameter: float, coils: float, closing: float) -> float:
    """Mean diameter after the arms close by ``closing`` deg: the wire keeps its length, so D N stays constant."""
    return mean_diameter * coils / (coils + closing / 360.0)


def spring_space(dimensions: JointDimensions) -> SpringSpace:
    """The coil's room over the joint's travel: open it is wider, closed it is narrower and longer."""
    spring, clear = dimensions.spring, dimensions.clearance
    coils, problems = spring.drawn_coils, []
    closed, opened = dimensions.ends
    closing, opening = max(0.0, dimensions.closing(closed)), max(0.0, -dimensions.closing(opened))
    if coils - opening / 360.0 < 0.5 * coils:
        limit = "most" if dimensions.closes < 0 else "least"
        problems.append(
            DimensionProblem(
                f"{dimensions.name}.range",
                dimensions.range,
                f"at {limit} {dimensions.free_angle - dimensions.closes * 180 * coils:.4g} deg",
                f"the joint would open more than half of the spring's {coils:.3f} coils",
            )
        )
        opening = 180.0 * coils
    widest = loaded_diameter(spring.mean_diameter, coils, -opening) + spring.wire_diameter
    narrowest = loaded_diameter(spring.mean_diameter, coils, closing) - spring.wire_diameter
    pocket = widest / 2 + clear
    if narrowest < dimensions.shaft_diameter + 2 * clear:
        problems.append(
            DimensionProblem(
                f"{dimensions.name}.shaft_diameter",
                dimensions.shaft_diameter,
                f"at most {narrowest - 2 * clear:.4g} mm",
                f"the coil closes to an inner diameter of {narrowest:.4g} mm at {closed:g} deg",
            )
        )
    # Lee Spring asks for about 10 % between a mandrel and the smallest inner diameter; of a small coil that is less
    # than what moves here needs.
    arbor = min(0.9 * narrowest / 2, narrowest / 2 - clear)
    if arbor < dimensions.shaft_diameter / 2 + dimensions.fit + SMALLEST_ARBOR_WALL:
        arbor = 0.0
    tongue = pocket + dimensions.wall
    pin = dimensions.pin_diameter
    inner = abs(spring.radius - (spring.wire_diameter + pin) / 2 - dimensions.keeper_gap)
    free = tongue + clear + pin / 2
    pin_reach = math.sqrt(max(free**2 - inner**2, 0.0))
    slope = spring.drawn_pitch / (2 * math.pi * spring.radius)
    shortest = (pin_reach + pin / 2 + PIN_OVERHANG) * math.hypot(1.0, slope)
    growth = closing / 360.0 * spring.drawn_pitch
    return SpringSpace(
        pocket_radius=pocket,
        tongue_radius=tongue,
        arbor_radius=arbor,
        radius_closed=(narrowest + spring.wire_diameter) / 2,
        radius_open=(widest - spring.wire_diameter) / 2,
        growth=growth,
        drop=opening / 360.0 * spring.drawn_pitch,
        shortest_arm=shortest,
        problems=tuple(problems),
    )
