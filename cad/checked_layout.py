"""A joint's layout with all checks that need no solids: collisions, and parts that do not fit.

Web, flange, sockets and tubes all cross z = 0 and are widest there, so they collide in that plane first. The seats of
both arms are outside the pocket's wall. There they can collide with the other half's stem or, in a joint with a short
coil, with each other. All these outlines are convex along the hinge axis, so their gap is exact.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache

from synth.cad.dimensions import JointDimensions
from synth.cad.fitting_problems import fitting_problems
from synth.cad.layout import JointLayout, place
from synth.cad.limits import DimensionError, DimensionProblem
from synth.cad.outlines import cup_outline, lower_bodies, upper_bodies
from synth.cad.seats_apart import seats_meet, swept_angles

ROUNDING = 1e-6  # mm, rounding error of a gap that equals the clearance by construction
HALVINGS = 20  # bisections of half a turn: to 0.0002 deg
MORE_APART = "one that the travel neither closes nor opens so far, or a smaller travel"
LARGEST_NOTCH = 300.0  # deg, of the pocket's wall
REMEMBERED = 1024  # layouts; the built-in example's joints take 340 in all, each asked for again and again


def lay_out(dimensions: JointDimensions) -> JointLayout:
    """Lay out all parts of a joint and check that they fit.

    Raises
    ------
    DimensionError
        naming every dimension whose part would not fit, with the value that does.
    """
    layout, found = _laid_out(dimensions)
    if layout is None:
        raise DimensionError(list(found))
    return layout


@lru_cache(maxsize=REMEMBERED)
def _laid_out(dimensions: JointDimensions) -> tuple[JointLayout | None, tuple[DimensionProblem, ...]]:
    """The layout and no problem, or None and the problems."""
    found = dimensions.problems()
    if found:
        return None, tuple(found)
    layout = place(dimensions)
    found = list(layout.space.problems)
    if not found:
        found += _meeting_stops(dimensions, layout) + _swept(dimensions, layout) + fitting_problems(dimensions, layout)
    return (None if found else layout), tuple(found)


def clear_upper_arm_angle(dimensions: JointDimensions) -> float:
    """An ``upper_arm_angle`` that the joint's travel allows.

    0 (as in the thesis) if possible, else along the upper link, else the possible direction nearest to that in steps of
    15 deg, or else of 5 deg. The arm offset follows from it.

    Raises
    ------
    DimensionError
        if no direction is possible.
    """
    along = dimensions.zero_angle - 180.0
    turns = [*sorted(range(-165, 181, 15), key=abs), *sorted(range(-175, 180, 5), key=abs)]
    problems: list[DimensionProblem] = []
    for angle in dict.fromkeys((0.0, *(along + turn for turn in turns))):
        if not -360.0 <= angle <= 360.0:
            continue
        try:
            lay_out(replace(dimensions, upper_arm_angle=angle))
        except DimensionError as error:
            if not any(problem.dimension.endswith("upper_arm_angle") for problem in error.problems):
                raise  # another direction does not help
            problems = problems or error.problems
        else:
            return angle
    raise DimensionError(problems)


def _meeting_stops(dimensions: JointDimensions, layout: JointLayout) -> list[DimensionProblem]:
    """Stops before which the links would collide, or at which their gap is smaller than the clearance."""
    half = layout.socket_outer + dimensions.clearance
    most = 180.0 - 2 * math.degrees(math.atan2(half, layout.web_radius))
    least = dimensions.clearance - ROUNDING
    upper, lower = upper_bodies(dimensions, layout), lower_bodies(dimensions, layout)

    def clear(rotation: float) -> bool:
        turned = [hull.turned(rotation) for hull in lower]
        return abs(rotation) <= most and all(a.clear_of(b, least) for a in upper for b in turned)

    low, high = dimensions.stop_angles
    if clear(dimensions.opening(low)) and clear(dimensions.opening(high)):
        return []
    limits = []
    for end in (-180.0, 180.0):
        free, met = 0.0, end
        for _ in range(HALVINGS):
            middle = (free + met) / 2
            free, met = (middle, met) if clear(middle) else (free, middle)
        limits.append(dimensions.zero_angle - dimensions.closes * free)
    limits.sort()
    # Rounded inwards, so that the stated range is allowed. The stops are outside the wanted travel.
    inside = (limits[0] + dimensions.range[0] - low, limits[1] - high + dimensions.range[1])
    allowed = f"{math.ceil(100 * inside[0]) / 100:.6g} to {math.floor(100 * inside[1]) / 100:.6g} deg"
    reason = "the links would meet" if dimensions.mount is None else "the link would meet the web or the mount's flange"
    return [DimensionProblem(f"{dimensions.name}.range", dimensions.range, allowed, reason)]


def _too_wide(dimensions: JointDimensions, excess: float) -> DimensionProblem:
    """The problem of a sweep of the upper arm that is ``excess`` deg too wide: of the free angle, or of the travel."""
    name, free, (low, high) = dimensions.name, dimensions.free_angle, dimensions.stop_angles
    if free - excess > high:
        allowed = f"at most {math.floor(free - excess):g} deg"
    elif free + excess < low:
        allowed = f"at least {math.ceil(free + excess):g} deg"
    else:
        reason = "the arm's sweep would take the whole pocket wall"
        return DimensionProblem(f"{name}.range", dimensions.range, "a smaller travel", reason)
    reason = "the spring is put in unloaded and wound up by its upper arm, whose way would take the whole pocket wall"
    return DimensionProblem(f"{name}.free_angle", free, allowed, reason)


def _swept(dimensions: JointDimensions, layout: JointLayout) -> list[DimensionProblem]:
    """Seats that collide with the other half's stem, or with each other, between the stops and at the free angle."""
    name, sweep = dimensions.name, layout.notch[1] - layout.notch[0]
    if sweep > LARGEST_NOTCH:
        return [_too_wide(dimensions, sweep - LARGEST_NOTCH)]
    stem, least = cup_outline(layout), dimensions.clearance - ROUNDING
    seat = layout.upper.outline()
    if not all(seat.clear_of(stem.turned(angle), least) for angle in swept_angles(dimensions)):
        reason = "the upper arm's seat would meet the lower link"
        allowed = "a direction in which the travel leaves it free, or a smaller range"
        return [DimensionProblem(f"{name}.upper_arm_angle", dimensions.upper_arm_angle, allowed, reason)]
    if seats_meet(dimensions, layout.upper, layout.lower):
        reason = "the seats of both arms would meet; other angles between the arms, or more coils, keep them apart"
        return [DimensionProblem(f"{name}.spring.included_angle", dimensions.spring.included_angle, MORE_APART, reason)]
    return []
