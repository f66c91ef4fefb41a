"""The upper arm's way with its seat turned: the loaded spring clears the lower half at either end of the seat's travel.

The seat takes up by how much a spring's own free angle is off. Its arm then lies that far aside, so it sweeps another
sector of the lower half's pocket; ``cad.layout`` opens the pocket's wall for all of them.
"""

from __future__ import annotations

from dataclasses import replace

from synth.cad.dimensions import JointDimensions
from synth.cad.free_wire import free_wire
from synth.cad.joint import spring_seats
from synth.cad.layout import JointLayout
from synth.cad.results import CheckResult, check_at_most
from synth.cad.travel import COARSE, OVERLAP_LIMIT, Bodies, manifold, turn_solid


def with_seat_turned(
    dimensions: JointDimensions, layout: JointLayout, turn: float
) -> tuple[JointDimensions, JointLayout]:
    """Dimensions and layout for a spring whose arms' angle is off, its seat ``turn`` deg towards larger free angles.

    The joint's free angle is the designed one again. Only the spring's arm moves: the halves' bodies stay as they are.
    """
    opened = -dimensions.closes * turn
    spring = dimensions.spring
    angle = (spring.included_angle - opened) % 360.0
    other = replace(spring, coils=spring.drawn_coils + opened / 360.0, included_angle=angle)
    upper = replace(layout.upper, direction=layout.upper.direction + opened)
    return replace(dimensions, spring=other), replace(layout, upper=upper)


def seat_overlap_at(bodies: Bodies, angle: float, turn: float) -> float:
    """Common volume (mm^3) of a loaded spring with the lower half at a joint ``angle``, its seat turned; deg."""
    joint = bodies.joint
    found = []
    for seat in spring_seats(joint.dimensions, joint.layout):
        coil = manifold(free_wire(*with_seat_turned(*seat, turn), angle, COARSE).whole())
        body = turn_solid(coil, -joint.turn("lower", angle))
        found.append(float((body ^ bodies.near["lower"].near(body)).volume()))
    return max(found)


def check_seat_room(bodies: Bodies) -> list[CheckResult]:
    """The worst of both stops and rest, with the seat at either end of its travel."""
    dimensions, name = bodies.joint.dimensions, bodies.joint.part("spring").name
    travel = dimensions.seat_travel
    if travel == 0.0:
        return []
    # The arm sweeps one way with the angle, so the ends are the worst.
    angles = (*dimensions.stop_angles, dimensions.rest_angle)
    places = [(turn, angle) for turn in (-travel, travel) for angle in angles]
    volume, turn, angle = max((seat_overlap_at(bodies, angle, turn), turn, angle) for turn, angle in places)
    text = f"with the lower half, its seat at {-travel:g} and {travel:+g} deg, most at {turn:+g} and a joint angle of"
    return [check_at_most("overlap", name, volume, OVERLAP_LIMIT, "mm^3", f"{text} {angle:.4g}", angle=angle)]
