"""Where a spring's arms and their shafts lie, and what they sweep as the joint turns. Plain arithmetic, no solids.

Seen along z, a tangent arm of direction u starts at the tangent point T, |T| = D/2, T . u = 0. A shaft of
diameter p touches the arm of diameter d at the distance s from T with its axis at T + s u + n (d + p)/2,
n = T/|T| away from the hinge. Both arms are round and the shaft is parallel to z, so their common
perpendicular lies in this plane and the contact is exact in spite of the helix' slope.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from cad.dimensions import JointDimensions
from cad.outline import Point, unit
from cad.spring_space import SpringSpace


@dataclass(frozen=True)
class ArmLayout:
    """One arm and its two shafts in the frame of the half that carries them, canonical sense."""

    direction: float  # deg, of the arm, seen along z
    tangent: Point  # mm, where coil and arm meet
    bearing: Point  # mm, axis of the shaft that closes the coil
    keeper: Point  # mm, axis of the shaft on the arm's other side
    bottom: float  # mm, the shafts' lower end
    top: float  # mm, the shafts' upper end
    pin_radius: float  # mm, largest distance of a shaft's surface from the hinge axis


def lay_arm(
    dimensions: JointDimensions, direction: float, side: int, pin_reach: float, bottom: float, top: float
) -> ArmLayout:
    """An arm of the given direction; ``side`` +1: its tangent point lies 90 deg counter-clockwise of it."""
    spring, pin = dimensions.spring, dimensions.pin_diameter
    along, outward = unit(direction), unit(direction + 90.0 * side)
    lateral = (spring.wire_diameter + pin) / 2

    def at(distance: float) -> Point:
        return (
            outward[0] * (spring.radius + distance) + along[0] * pin_reach,
            outward[1] * (spring.radius + distance) + along[1] * pin_reach,
        )

    bearing, keeper = at(lateral), at(-lateral - dimensions.keeper_gap)
    return ArmLayout(
        direction=direction,
        tangent=(outward[0] * spring.radius, outward[1] * spring.radius),
        bearing=bearing,
        keeper=keeper,
        bottom=bottom,
        top=top,
        pin_radius=max(math.hypot(*bearing), math.hypot(*keeper)) + pin / 2,
    )


def _pin_angles(dimensions: JointDimensions, arm: ArmLayout) -> tuple[float, float]:
    """Angles (deg, relative to the arm's direction) between which its shafts lie, clearance included."""
    edges = []
    for x, y in (arm.bearing, arm.keeper):
        margin = math.degrees(math.asin((dimensions.pin_diameter / 2 + dimensions.clearance) / math.hypot(x, y)))
        angle = (math.degrees(math.atan2(y, x)) - arm.direction + 180.0) % 360.0 - 180.0
        edges += [angle - margin, angle + margin]
    return min(edges), max(edges)


def _turn(pin: Point, drawn: float, loaded: float) -> float:
    """Angle (deg) that an arm turns back on a shaft when its shaft-side distance from the hinge changes."""
    distance = math.hypot(*pin)
    return math.degrees(math.acos(max(-1.0, min(1.0, loaded / distance))) - math.acos(drawn / distance))


def arm_turns(dimensions: JointDimensions, arm: ArmLayout, space: SpringSpace) -> tuple[float, float]:
    """How far an arm turns back on its shafts at the travel's closed and open end, deg (``cad.pose``).

    Where the coil's radius changes, its arms lean on their shafts at another angle; opening, they first take up the
    keepers' gap.
    """
    lateral = (dimensions.spring.wire_diameter + dimensions.pin_diameter) / 2
    radius = dimensions.spring.radius
    closed = _turn(arm.bearing, radius + lateral, space.radius_closed + lateral)
    return closed, _turn(arm.keeper, radius - lateral - dimensions.keeper_gap, space.radius_open - lateral)


def slips(dimensions: JointDimensions, arm: ArmLayout, space: SpringSpace, pin_reach: float) -> tuple[float, float]:
    """How far the arm slides over its shaft towards the hinge (+) as the coil's radius changes, at both ends, mm."""
    lateral = (dimensions.spring.wire_diameter + dimensions.pin_diameter) / 2
    ends = ((arm.bearing, space.radius_closed + lateral), (arm.keeper, space.radius_open - lateral))
    closed, opened = (math.sqrt(max(0.0, x * x + y * y - side * side)) - pin_reach for (x, y), side in ends)
    return closed, opened


def notch(dimensions: JointDimensions, upper: ArmLayout, space: SpringSpace) -> tuple[float, float]:
    """Sector (deg, in the lower half's frame) that the upper arm and its shafts sweep over the joint's range.

    At the radius r an edge of the arm, w off its axis, lies ``asin((D/2 -+ w)/r)`` behind the arm's direction.
    The coil's own quarter turn before the tangent point belongs to the sweep as well.
    """
    width = dimensions.spring.wire_diameter / 2 + dimensions.clearance
    near = math.degrees(math.asin((space.radius_closed - width) / space.tongue_radius))
    pins = _pin_angles(dimensions, upper)
    closed, opened = arm_turns(dimensions, upper, space)
    behind, ahead = min(-90.0 - closed, pins[0]), max(-near - opened, pins[1])
    # In the lower half's frame at q = 0 the upper half stands turned back by the joint's rotation.
    turned = [upper.direction - dimensions.opening(angle) for angle in dimensions.ends]
    return turned[1] + behind, turned[0] + ahead
