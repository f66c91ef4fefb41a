"""Where everything of a joint lies: plain arithmetic from its dimensions, no solids.

Canonical frame, mm: the hinge axis is z, the middle of the tongue z = 0, the upper link points along +y,
the straight lower link along -y. It holds a right-hand spring whose arms open as the lower link turns
counter-clockwise seen from +z. Every other joint is this one mirrored (see ``flips``), except the spring,
which is drawn in its own hand and laid in, so that the contact checks test the mirror too.

Along z, upwards: damper and bracket | ear A | floor plate of the tongue | coil in its pocket | ear B.
The lower arm leaves the coil at the floor, where stubby arm shafts stand on the floor plate; the upper arm
leaves it at the top, where stubby shafts come down from ear B. So the shafts never meet the other arm.

Of a pair of springs the second is the first mirrored in z, in a pocket below the floor, its upper arm on shafts that
stand on ear A; the lower arms' shafts go through the floor and bear both. z = 0 is then the middle of the floor:
ear A | coil in its pocket | floor plate | coil in its pocket | ear B.

How an arm lies on its shafts: ``cad.arm_layout``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from cad.arm_layout import ArmLayout, arm_turns, lay_arm, notch, slips
from cad.dimensions import JointDimensions
from cad.fitting_layout import damper_screws, fitting_problems, seat_radius
from cad.folding import travel_problems
from cad.limits import DimensionError, DimensionProblem
from cad.outline import Point
from cad.spring_space import PIN_OVERHANG, SpringSpace, spring_space


@dataclass(frozen=True)
class JointLayout:
    """Derived lengths (mm) and angles (deg) of one joint; the comments name what each one is."""

    arm_length: float  # along the wire
    arm_reach: float  # the arm's length seen along z
    pin_reach: float  # tangent point to contact, seen along z
    slips: tuple[float, float]  # that the tangent point moves along the arm, off its shaft: travel's closed, open end
    arm_turns: tuple[float, float]  # deg, that an arm turns back on its shafts; at the travel's closed, open end
    coil_start: float  # z of the wire's centre at the lower tangent point
    coil_height: float  # lower to upper tangent point
    coil_drop: float  # that the upper one sinks to the travel's open end, where the coil has fewer turns
    half_width: float  # of the tongue along z
    gap: float  # ear A's or ear B's inner face from z = 0
    pocket_radius: float
    tongue_radius: float  # outside of the pocket's wall
    arbor_radius: float  # 0: none
    radius_closed: float  # mean coil radius at the travel's closed end
    radius_open: float
    floor_top: float
    web_radius: float  # the upper half's web starts here; all that turns under it is smaller
    socket_radius: float  # the lower half's socket starts here
    bracket_radius: float
    bracket_height: float
    seat_radius: float  # of the encoder's seat on ear B; 0: none
    socket_outer: float  # radius of the sockets' outside
    socket_depth: float
    web_thickness: float
    notch_bottom: float  # z from which the pocket's wall is open for the upper arm's sweep
    notch: tuple[float, float]  # deg, from and to, in the lower half's frame at q = 0
    upper: ArmLayout  # in the upper half's frame
    lower: ArmLayout  # in the lower half's frame, at q = 0
    screws: tuple[Point, ...]  # axes of the damper's screws, which go into ear A
    mirrored: bool  # a second spring below the floor
    flips: tuple[int, int]  # sign of x and of z: canonical to this joint

    @property
    def upper_bottom(self) -> float:
        """Hinge axis to the end of the link tube in the upper socket."""
        return self.web_radius + self.web_thickness

    @property
    def lower_bottom(self) -> float:
        """Hinge axis to the end of the link tube in the lower socket."""
        return self.socket_radius + self.web_thickness


@dataclass(frozen=True)
class _Heights:
    """Along z, mm."""

    half_width: float
    floor_top: float
    coil_start: float
    coil: float


def _heights(dimensions: JointDimensions, space: SpringSpace, drift: float) -> _Heights:
    """Floor, coil and the arms' rise beside it (``drift``), once, or twice with the floor in the middle."""
    spring, floor, clear = dimensions.spring, dimensions.floor_thickness, dimensions.clearance
    beside = drift + spring.wire_diameter / 2 + clear
    coil = spring.drawn_coils * spring.drawn_pitch
    room = beside + coil + space.growth + beside
    half_width = floor / 2 + room if dimensions.springs == 2 else (floor + room) / 2
    floor_top = floor / 2 if dimensions.springs == 2 else floor - half_width
    return _Heights(half_width, floor_top, floor_top + beside, coil)


def lay_out(dimensions: JointDimensions) -> JointLayout:
    """Place everything of a joint.

    Raises
    ------
    DimensionError
        naming every dimension whose part would not fit, with the value that does.
    """
    found = dimensions.problems()
    if found:
        raise DimensionError(found)
    space = spring_space(dimensions)
    problems = list(space.problems)
    spring, clear, wall = dimensions.spring, dimensions.clearance, dimensions.wall
    arm_length = spring.arm_length if spring.arm_length is not None else math.ceil(space.shortest_arm)
    if arm_length < space.shortest_arm:
        problems.append(
            DimensionProblem(
                f"{dimensions.name}.spring.arm_length",
                arm_length,
                f"at least {space.shortest_arm:.4g} mm",
                "the arm must reach its shafts outside the pocket's wall",
            )
        )
    slope = spring.drawn_pitch / (2 * math.pi * spring.radius)
    reach = arm_length / math.hypot(1.0, slope)
    pin_reach = reach - dimensions.pin_diameter / 2 - PIN_OVERHANG
    wire_radius = spring.wire_diameter / 2
    heights = _heights(dimensions, space, slope * reach)
    gap, pair = heights.half_width + clear, dimensions.springs == 2
    ref = 270.0 + dimensions.closes * (dimensions.zero_angle - dimensions.upper_arm_angle)
    # The coil stands on the floor: opened it is lower, and its upper arm with it.
    lowest = heights.coil_start + heights.coil - space.drop - wire_radius - PIN_OVERHANG
    pin_bottom = max(lowest, heights.floor_top + clear)
    upper = lay_arm(dimensions, ref, -1, pin_reach, pin_bottom, gap + dimensions.plate)
    pin_top = heights.coil_start + wire_radius + PIN_OVERHANG
    pin_bottom = -pin_top if pair else -heights.half_width
    lower = lay_arm(dimensions, 270.0 + dimensions.closes * dimensions.arm_offset, 1, pin_reach, pin_bottom, pin_top)
    tip = math.hypot(space.radius_open + wire_radius, reach)
    seat = max(upper.pin_radius, lower.pin_radius) + wall
    damper = dimensions.damper
    adapter = damper.adapter.length + clear if damper.adapter is not None else 0.0
    bracket_radius = damper.bolt_circle / 2 + damper.bolt_diameter / 2 + wall
    # The bracket must not reach the upper socket, all that turns must pass under the web.
    web_radius = max(
        max(tip, seat, space.tongue_radius) + 2 * clear,
        bracket_radius + clear - 2 * wall,
        seat_radius(dimensions) + clear - 2 * wall,
    )
    notch_bottom = upper.bottom - clear
    layout = JointLayout(
        arm_length=arm_length,
        arm_reach=reach,
        pin_reach=pin_reach,
        slips=slips(dimensions, upper, space, pin_reach),
        arm_turns=arm_turns(dimensions, upper, space),
        coil_start=heights.coil_start,
        coil_height=heights.coil,
        coil_drop=space.drop,
        half_width=heights.half_width,
        gap=gap,
        pocket_radius=space.pocket_radius,
        tongue_radius=space.tongue_radius,
        arbor_radius=space.arbor_radius,
        radius_closed=space.radius_closed,
        radius_open=space.radius_open,
        floor_top=heights.floor_top,
        web_radius=web_radius,
        socket_radius=max(web_radius, bracket_radius + clear),
        bracket_radius=bracket_radius,
        bracket_height=wall + damper.body_length + clear + adapter,
        seat_radius=seat_radius(dimensions),
        socket_outer=dimensions.link_width / 2 + dimensions.fit + wall,
        socket_depth=1.2 * dimensions.link_width,
        web_thickness=2 * wall,
        notch_bottom=notch_bottom,
        notch=notch(dimensions, upper, space),
        upper=upper,
        lower=lower,
        screws=damper_screws(dimensions.damper, upper if pair else None),
        mirrored=pair,
        flips=(dimensions.opening_sign, dimensions.opening_sign * spring.hand_sign),
    )
    problems += travel_problems(dimensions, layout) + fitting_problems(dimensions, layout)
    if problems:
        raise DimensionError(problems)
    return layout


def clear_upper_arm_angle(dimensions: JointDimensions) -> float:
    """An ``upper_arm_angle`` that the joint's travel allows.

    0 (the thesis' way) where it is free, else along the upper link, else the free direction nearest to that in steps of
    15 deg; the arm offset follows from it, whichever it is.

    Raises
    ------
    DimensionError
        where none is.
    """
    along = dimensions.zero_angle - 180.0
    turns = sorted(range(-165, 181, 15), key=abs)
    problems: list[DimensionProblem] = []
    for angle in dict.fromkeys((0.0, *(along + turn for turn in turns))):
        if not -360.0 <= angle <= 360.0:
            continue
        try:
            lay_out(replace(dimensions, upper_arm_angle=angle))
        except DimensionError as error:
            problems = problems or error.problems
        else:
            return angle
    raise DimensionError(problems)
