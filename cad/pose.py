"""How the spring stands at a joint angle: closed or opened, its arms still on their shafts."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from cad.dimensions import JointDimensions, SpringDimensions
from cad.layout import JointLayout
from cad.spring_space import loaded_diameter


@dataclass(frozen=True)
class SpringPose:
    """The spring at one joint angle, in the canonical upper frame."""

    spring: SpringDimensions  # with the loaded diameter, coils and included angle
    closing: float  # deg, by which the coil is closed (negative: opened)
    upper_direction: float  # deg, of the upper arm


def pose_spring(dimensions: JointDimensions, layout: JointLayout, angle: float) -> SpringPose:
    """The spring at the measured joint ``angle`` (deg), coil concentric with the hinge, arms straight.

    The wire keeps its length, so a coil closed by c has ``D N / (N + c/360)``. Its tangent arms then run
    nearer to the hinge and turn a little on their shafts: an arm of a coil of radius R touches a shaft at P
    when its normal is ``acos((R +- (d + p)/2) / |P|)`` from P. Closing presses the arms on the bearing
    shafts, opening on the keepers; within the keepers' gap it keeps its shape and both arms share the play.
    The closing is found by bisection.
    """
    wanted = dimensions.closing(angle)  # deg that the joint closes beyond the unloaded pose
    spring, coils = dimensions.spring, dimensions.spring.drawn_coils
    lateral = (spring.wire_diameter + dimensions.pin_diameter) / 2
    if wanted >= 0.0:
        pin, offset, drawn = layout.upper.bearing, lateral, spring.radius + lateral
    else:
        pin, offset = layout.upper.keeper, -lateral
        drawn = spring.radius - lateral - dimensions.keeper_gap
    distance = math.hypot(*pin)

    def turned(closing: float) -> float:
        """Angle (deg) that each arm turns back on its shaft when the coil closes by ``closing``."""
        radius = loaded_diameter(spring.mean_diameter, coils, closing) / 2
        cosine = max(-1.0, min(1.0, (radius + offset) / distance))
        return math.degrees(math.acos(cosine) - math.acos(drawn / distance))

    def excess(closing: float) -> float:
        return closing + 2 * turned(closing) - wanted

    if (wanted >= 0.0) == (excess(0.0) >= 0.0):
        closing, turn = 0.0, wanted / 2  # within the keepers' gap the spring only turns, half as far as the joint
    else:
        near, far = 0.0, wanted
        for _ in range(60):
            middle = (near + far) / 2
            near, far = (middle, far) if (excess(middle) < 0.0) == (excess(near) < 0.0) else (near, middle)
        closing = (near + far) / 2
        turn = turned(closing)
    loaded = replace(
        spring,
        mean_diameter=loaded_diameter(spring.mean_diameter, coils, closing),
        coils=coils + closing / 360.0,
        included_angle=spring.included_angle - closing,
        pitch=spring.drawn_pitch,
    )
    return SpringPose(loaded, closing, layout.upper.direction - turn)
