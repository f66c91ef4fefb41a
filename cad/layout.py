"""Where everything of a joint lies: plain arithmetic from its dimensions, no solids.

Canonical frame, mm: the hinge axis is z, the middle of the tongue z = 0, the upper link points along +y,
the straight lower link along -y. It holds a right-hand spring and a joint whose measured angle grows
counter-clockwise seen from +z. Every other joint is this one mirrored (see ``flips``), except the spring,
which is drawn in its own hand and laid in, so that the contact checks test the mirror too.

Along z, upwards: damper and bracket | ear A | floor plate of the tongue | coil in its pocket | ear B.
The lower arm leaves the coil at the floor, where stubby arm shafts stand on the floor plate; the upper arm
leaves it at the top, where stubby shafts come down from ear B. So the shafts never meet the other arm.

Seen along z, a tangent arm of direction u starts at the tangent point T, |T| = D/2, T . u = 0. A shaft of
diameter p touches the arm of diameter d at the distance s from T with its axis at T + s u + n (d + p)/2,
n = T/|T| away from the hinge. Both arms are round and the shaft is parallel to z, so their common
perpendicular lies in this plane and the contact is exact in spite of the helix' slope.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from cad.dimensions import JointDimensions
from cad.fitting_layout import fitting_problems, seat_radius
from cad.folding import folding_problems
from cad.limits import DimensionError, DimensionProblem

Point = tuple[float, float]
PIN_OVERHANG = 1.0  # mm that an arm reaches past its shaft, and a shaft past its arm
SMALLEST_ARBOR_WALL = 1.2  # mm, two printed lines; a thinner arbor is left out


def unit(angle: float) -> Point:
    """Unit vector at ``angle`` deg from +x, counter-clockwise."""
    return math.cos(math.radians(angle)), math.sin(math.radians(angle))


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
    flips: tuple[int, int]  # sign of x and of z: canonical to this joint

    @property
    def upper_bottom(self) -> float:
        """Hinge axis to the end of the link tube in the upper socket."""
        return self.web_radius + self.web_thickness

    @property
    def lower_bottom(self) -> float:
        """Hinge axis to the end of the link tube in the lower socket."""
        return self.socket_radius + self.web_thickness


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
    space = _spring_space(dimensions)
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
    drift, wire_radius = slope * reach, spring.wire_diameter / 2
    height = spring.drawn_coils * spring.drawn_pitch
    above = drift + wire_radius + space.growth + clear
    below = drift + wire_radius + clear + dimensions.floor_thickness
    half_width = (height + above + below) / 2
    start = below - half_width
    gap = half_width + clear
    ref = 270.0 - dimensions.zero_angle + dimensions.upper_arm_angle
    upper = _arm(dimensions, ref, -1, pin_reach, start + height - wire_radius - PIN_OVERHANG, gap + dimensions.plate)
    lower = _arm(
        dimensions, 270.0 - dimensions.arm_offset, 1, pin_reach, -half_width, start + wire_radius + PIN_OVERHANG
    )
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
        slips=_slips(dimensions, upper, space, pin_reach),
        arm_turns=_arm_turns(dimensions, upper, space),
        coil_start=start,
        coil_height=height,
        half_width=half_width,
        gap=gap,
        pocket_radius=space.pocket_radius,
        tongue_radius=space.tongue_radius,
        arbor_radius=space.arbor_radius,
        radius_closed=space.radius_closed,
        radius_open=space.radius_open,
        floor_top=dimensions.floor_thickness - half_width,
        web_radius=web_radius,
        socket_radius=max(web_radius, bracket_radius + clear),
        bracket_radius=bracket_radius,
        bracket_height=wall + damper.body_length + clear + adapter,
        seat_radius=seat_radius(dimensions),
        socket_outer=dimensions.link_width / 2 + dimensions.fit + wall,
        socket_depth=1.2 * dimensions.link_width,
        web_thickness=2 * wall,
        notch_bottom=notch_bottom,
        notch=_notch(dimensions, upper, space),
        upper=upper,
        lower=lower,
        flips=(dimensions.sign, dimensions.sign * spring.hand_sign),
    )
    problems += _travel_problems(dimensions, layout) + fitting_problems(dimensions, layout)
    if problems:
        raise DimensionError(problems)
    return layout


@dataclass(frozen=True)
class _SpringSpace:
    pocket_radius: float
    tongue_radius: float
    arbor_radius: float
    radius_closed: float
    radius_open: float
    growth: float
    shortest_arm: float
    problems: tuple[DimensionProblem, ...]


def loaded_diameter(mean_diameter: float, coils: float, closing: float) -> float:
    """Mean diameter after the arms close by ``closing`` deg: the wire keeps its length, so D N stays constant."""
    return mean_diameter * coils / (coils + closing / 360.0)


def _spring_space(dimensions: JointDimensions) -> _SpringSpace:
    """The coil's room over the joint's travel: open it is wider, closed it is narrower and longer."""
    spring, clear = dimensions.spring, dimensions.clearance
    coils, problems = spring.drawn_coils, []
    low, high = dimensions.range
    closing, opening = max(0.0, dimensions.free_angle - low), max(0.0, high - dimensions.free_angle)
    if coils - opening / 360.0 < 0.5 * coils:
        problems.append(
            DimensionProblem(
                f"{dimensions.name}.range",
                dimensions.range,
                f"at most {dimensions.free_angle + 180 * coils:.4g} deg",
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
                f"the coil closes to an inner diameter of {narrowest:.4g} mm at {low:g} deg",
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
    return _SpringSpace(
        pocket_radius=pocket,
        tongue_radius=tongue,
        arbor_radius=arbor,
        radius_closed=(narrowest + spring.wire_diameter) / 2,
        radius_open=(widest - spring.wire_diameter) / 2,
        growth=growth,
        shortest_arm=shortest,
        problems=tuple(problems),
    )


def _arm(
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


def _arm_turns(dimensions: JointDimensions, arm: ArmLayout, space: _SpringSpace) -> tuple[float, float]:
    """How far an arm turns back on its shafts at the travel's closed and open end, deg (``cad.pose``).

    Where the coil's radius changes, its arms lean on their shafts at another angle; opening, they first take up the
    keepers' gap.
    """
    lateral = (dimensions.spring.wire_diameter + dimensions.pin_diameter) / 2
    radius = dimensions.spring.radius
    closed = _turn(arm.bearing, radius + lateral, space.radius_closed + lateral)
    return closed, _turn(arm.keeper, radius - lateral - dimensions.keeper_gap, space.radius_open - lateral)


def _slips(dimensions: JointDimensions, arm: ArmLayout, space: _SpringSpace, pin_reach: float) -> tuple[float, float]:
    """How far the arm slides over its shaft towards the hinge (+) as the coil's radius changes, at both ends, mm."""
    lateral = (dimensions.spring.wire_diameter + dimensions.pin_diameter) / 2
    ends = ((arm.bearing, space.radius_closed + lateral), (arm.keeper, space.radius_open - lateral))
    closed, opened = (math.sqrt(max(0.0, x * x + y * y - side * side)) - pin_reach for (x, y), side in ends)
    return closed, opened


def _notch(dimensions: JointDimensions, upper: ArmLayout, space: _SpringSpace) -> tuple[float, float]:
    """Sector (deg, in the lower half's frame) that the upper arm and its shafts sweep over the joint's range.

    At the radius r an edge of the arm, w off its axis, lies ``asin((D/2 -+ w)/r)`` behind the arm's direction.
    The coil's own quarter turn before the tangent point belongs to the sweep as well.
    """
    width = dimensions.spring.wire_diameter / 2 + dimensions.clearance
    near = math.degrees(math.asin((space.radius_closed - width) / space.tongue_radius))
    pins = _pin_angles(dimensions, upper)
    closed, opened = _arm_turns(dimensions, upper, space)
    behind, ahead = min(-90.0 - closed, pins[0]), max(-near - opened, pins[1])
    low, high = dimensions.range
    # In the lower half's frame at q = 0 the upper half stands turned back by the joint's rotation.
    turned = [upper.direction - (angle - dimensions.zero_angle) for angle in (low, high)]
    return turned[1] + behind, turned[0] + ahead


def _stem_half_width(layout: JointLayout) -> float:
    """Half width (mm) of the lower link's stem where it passes the web: it tapers from the tongue to the socket."""
    taper = max(0.0, layout.tongue_radius - layout.socket_outer)
    return layout.socket_outer + taper * (1.0 - layout.web_radius / layout.lower_bottom)


def _travel_problems(dimensions: JointDimensions, layout: JointLayout) -> list[DimensionProblem]:
    """Travel that the hinge cannot give: link against web, upper arm shafts against the lower link."""
    low, high = dimensions.range
    half = _stem_half_width(layout) + dimensions.clearance
    largest = 180.0 - 2 * math.degrees(math.atan2(half, layout.web_radius))
    name, found = dimensions.name, folding_problems(dimensions, layout, largest)
    if layout.notch[1] - layout.notch[0] > 300.0:
        found.append(
            DimensionProblem(
                f"{name}.range", (low, high), "a smaller travel", "the arm's sweep would take the whole pocket wall"
            )
        )
    if layout.slips[0] > dimensions.pin_diameter / 2 + PIN_OVERHANG:
        found.append(
            DimensionProblem(
                f"{name}.range",
                (low, high),
                "a smaller travel",
                "the closing coil would pull its arms off their shafts",
            )
        )
    margin = math.degrees(math.asin(min(1.0, _stem_half_width(layout) / layout.web_radius)))
    middle = (layout.notch[0] + layout.notch[1]) / 2
    off = abs((middle - 270.0 + 180.0) % 360.0 - 180.0)
    if not found and off - (layout.notch[1] - layout.notch[0]) / 2 < margin:
        found.append(
            DimensionProblem(
                f"{name}.upper_arm_angle",
                dimensions.upper_arm_angle,
                "a direction in which the travel leaves it free, or a smaller range",
                "the upper arm's shafts would sweep through the lower link",
            )
        )
    return found


def clear_upper_arm_angle(dimensions: JointDimensions) -> float:
    """An ``upper_arm_angle`` that the joint's travel allows.

    0 (the thesis' way) where it is free, else along the upper link, else the free direction nearest to that in steps of
    15 deg; the arm offset follows from it, whichever it is.

    Raises
    ------
    DimensionError
        where none is.
    """
    from dataclasses import replace

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
