"""The coil's space between the stops: pocket, arbor, free arms and their motion. Plain arithmetic, no solids."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from synth.cad.arm_layout import seat_size
from synth.cad.dimensions import JointDimensions
from synth.cad.flexed_wire import flex_wire
from synth.cad.limits import DimensionProblem

SMALLEST_ARBOR_WALL = 1.2  # mm, two printed lines; a thinner arbor is left out
SETTLED = 0.01  # mm, tolerance of the iteration for the arms' free length
ROUNDS = 12  # iterations; an arm changes its pocket by a tenth of its own change, so 3 to 5 converge


@dataclass(frozen=True)
class SpringSpace:
    """Lengths in mm."""

    pocket_radius: float
    tongue_radius: float
    arbor_radius: float  # 0: none
    free_arm: float  # tangent point to seat
    sway_in: float  # that a free arm comes nearer to the hinge than it is drawn, most
    sway_out: float  # and farther from it
    growth: float  # along z, of the closing coil
    drop: float  # along z, of the opening coil, which has fewer turns
    problems: tuple[DimensionProblem, ...]


@dataclass(frozen=True)
class _Extent:
    """The wire's envelope from stop to stop: radii of its centre line about the hinge, sway of its arms; mm."""

    inner: float
    outer: float
    sway_in: float
    sway_out: float


@lru_cache(maxsize=512)
def _extent(radius: float, coils: float, arm: float, closing: float, opening: float) -> _Extent | None:
    """Over the free shape and both ends; None if no shape is found."""
    inner, outer, sway_in, sway_out = radius, radius, 0.0, 0.0
    for angle in (closing, -opening):
        if angle == 0.0:
            continue
        wire = flex_wire(radius, coils, arm, angle)
        if wire is None:
            return None
        radii = np.hypot(*wire.points[wire.first : wire.last + 1].T)
        inner, outer = min(inner, float(radii.min())), max(outer, float(radii.max()))
        aside = wire.points[: wire.first + 1, 0] - radius  # the far arm's, in its own half's frame, is the same
        sway_in, sway_out = max(sway_in, -float(aside.min())), max(sway_out, float(aside.max()))
    return _Extent(inner, outer, sway_in, sway_out)


def spring_space(dimensions: JointDimensions) -> SpringSpace:
    """The coil's space from stop to stop, and the shortest free arms that lead out of it."""
    spring, clear, wall = dimensions.spring, dimensions.clearance, dimensions.wall
    coils, problems = spring.drawn_coils, []
    closed, opened = dimensions.ends
    closing, opening = max(0.0, dimensions.closing(closed)), max(0.0, -dimensions.closing(opened))
    limit = "most" if dimensions.closes < 0 else "least"
    if coils - opening / 360.0 < 0.5 * coils:
        allowed = f"at {limit} {dimensions.free_angle - dimensions.closes * 180 * coils:.4g} deg"
        reason = f"the joint would open more than half of the spring's {coils:.3f} coils"
        problems.append(DimensionProblem(f"{dimensions.name}.range", dimensions.range, allowed, reason))
        opening = 0.0
    half_width = seat_size(dimensions).half_width
    extent: _Extent | None = _Extent(spring.radius, spring.radius, 0.0, 0.0)
    arm = shortest = 0.0
    for _ in range(ROUNDS):
        assert extent is not None
        pocket = extent.outer + spring.wire_diameter / 2 + clear
        tongue = pocket + wall
        beside = max(0.0, spring.radius - half_width)
        shortest = math.sqrt((tongue + clear) ** 2 - beside**2)
        wanted = shortest if spring.free_arm is None else max(spring.free_arm, shortest)
        settled = abs(wanted - arm) < SETTLED
        arm = wanted
        if settled:
            break
        found = _extent(spring.radius, coils, round(arm, 6), closing, opening)
        if found is None:
            text = f"the wire cannot bend through {closing:.4g} deg closing, {opening:.4g} opening"
            name = f"{dimensions.name}.range"
            problems.append(DimensionProblem(name, dimensions.range, "a smaller travel", text))
            break
        extent = found
    if spring.free_arm is not None and spring.free_arm < shortest - SETTLED:
        allowed = f"at least {shortest:.4g} mm"
        reason = "the arm must reach its seat outside the pocket's wall"
        problems.append(DimensionProblem(f"{dimensions.name}.spring.free_arm", spring.free_arm, allowed, reason))
    assert extent is not None
    inside = 2 * extent.inner - spring.wire_diameter
    if inside < dimensions.shaft_diameter + 2 * clear:
        allowed = f"at most {inside - 2 * clear:.4g} mm"
        reason = f"the coil closes to an inner diameter of {inside:.4g} mm at {closed:g} deg"
        problems.append(
            DimensionProblem(f"{dimensions.name}.shaft_diameter", dimensions.shaft_diameter, allowed, reason)
        )
    # Lee Spring requires about 10 % between a mandrel and the smallest inner diameter. For a small coil that is less
    # than the running clearance of this joint.
    arbor = min(0.9 * inside / 2, inside / 2 - clear)
    if arbor < dimensions.shaft_diameter / 2 + dimensions.fit + SMALLEST_ARBOR_WALL:
        arbor = 0.0
    return SpringSpace(
        pocket_radius=extent.outer + spring.wire_diameter / 2 + clear,
        tongue_radius=extent.outer + spring.wire_diameter / 2 + clear + wall,
        arbor_radius=arbor,
        free_arm=arm,
        sway_in=extent.sway_in,
        sway_out=extent.sway_out,
        growth=closing / 360.0 * spring.drawn_pitch,
        drop=opening / 360.0 * spring.drawn_pitch,
        problems=tuple(problems),
    )
