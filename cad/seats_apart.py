"""Whether the seats of both arms of a spring meet, between the stops or on the way there from the free angle.

The outlines are convex along the hinge axis, so their gap is exact.
"""

from __future__ import annotations

import math

from synth.cad.arm_layout import ArmLayout, lay_arm, seat_size
from synth.cad.dimensions import JointDimensions
from synth.cad.layout import jaw_height
from synth.cad.outline import Disc, Hull, hull_of

SWEEP = 3.0  # deg, between the angles at which the seats' gaps are computed


def swept_angles(dimensions: JointDimensions) -> list[float]:
    """Rotations of the lower half (deg) from stop to stop and to the free angle, with the seat turned to either side.

    From a free angle beyond a stop the upper arm's seat is turned to the travel when the joint is assembled.
    """
    first, *_, last = sorted(dimensions.opening(angle) for angle in (*dimensions.stop_angles, dimensions.free_angle))
    first, last = first - dimensions.seat_travel, last + dimensions.seat_travel
    count = max(1, math.ceil((last - first) / SWEEP))
    return [first + (last - first) * index / count for index in range(count + 1)]


def seats_meet(dimensions: JointDimensions, upper: ArmLayout, lower: ArmLayout) -> bool:
    """Whether the arms' seats, with their caps and screws' heads, come nearer to each other than the clearance."""
    clear = dimensions.clearance
    low, high = jaw_heights(upper, lower)
    if low + clear <= high:
        return False
    pairs = [
        (upper.outline(), _with_arm(dimensions, lower)),
        (_with_arm(dimensions, upper), lower.outline()),
    ]
    return not all(
        one.clear_of(other.turned(angle), clear) for angle in swept_angles(dimensions) for one, other in pairs
    )


def seats_would_meet(dimensions: JointDimensions, free_arm: float) -> bool:
    """``seats_meet`` of a joint that is not laid out yet, for arms that are free for ``free_arm`` mm."""
    spring, seat = dimensions.spring, seat_size(dimensions)
    coil = spring.drawn_coils * spring.drawn_pitch
    ends = 270.0 + dimensions.closes * dimensions.zero_angle, 270.0 + dimensions.closes * dimensions.arm_offset
    upper = lay_arm(dimensions, seat, ends[0], -1, free_arm, coil, 0.0)
    lower = lay_arm(dimensions, seat, ends[1], 1, free_arm, 0.0, 0.0)
    return seats_meet(dimensions, upper, lower)


def jaw_heights(upper: ArmLayout, lower: ArmLayout) -> tuple[float, float]:
    """Z (mm) of the lower jaw's top and of the upper jaw's bottom, screws' heads included."""
    more = jaw_height(lower.seat)
    return lower.wire_height(lower.middle) + more, upper.wire_height(upper.middle) - more


def _with_arm(dimensions: JointDimensions, arm: ArmLayout) -> Hull:
    """An arm's seat with the free arm outside the pocket's wall."""
    wire = dimensions.spring.wire_diameter / 2
    start = arm.at(max(0.0, arm.free - arm.seat.half_width), 0.0)
    return hull_of([*arm.outline().discs, Disc(*start, wire)])
