"""A whole leg: its joints, the tubes between them, and their positions in the rest pose."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TypeVar, overload

from synth.cad import kernel
from synth.cad.arm_shaft import cross_volume
from synth.cad.checked_layout import lay_out
from synth.cad.dimensions import JointDimensions, LegDimensions
from synth.cad.fitting_problems import least_bolt_circle
from synth.cad.hinge import cross_screw, cylinder
from synth.cad.joint import BuiltJoint, assemble
from synth.cad.kernel import faceted
from synth.cad.layout import JointLayout
from synth.cad.limits import DimensionError, DimensionProblem, rounded_up
from synth.cad.parts import BuiltPart, Mesh, file_name, mesh_of
from synth.cad.standard_part import CutPart

T = TypeVar("T")
JOINTS_KEPT = 8  # cached joints: those of the last one or two legs, whose masses are computed before they are drawn


@dataclass(frozen=True)
class Placement:
    """A joint's frame in the leg: turn about z, then shift. x to the right, y up, z towards the viewer."""

    x: float  # mm
    y: float  # mm
    turn: float  # deg


class BuiltWhenUsed(Sequence[T]):
    """``count`` solids or groups of them, each built by ``build(index)`` on first access."""

    def __init__(self, count: int, build: Callable[[int], T]) -> None:
        self._built: list[T | None] = [None] * count
        self._build = build

    def __len__(self) -> int:
        return len(self._built)

    @overload
    def __getitem__(self, index: int) -> T: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[T]: ...
    def __getitem__(self, index: int | slice) -> T | Sequence[T]:
        if isinstance(index, slice):
            return [self[k] for k in range(*index.indices(len(self)))]
        found = self._built[index]
        if found is None:
            found = self._built[index] = self._build(index)
        return found


@dataclass(frozen=True)
class BuiltLeg:
    """Joints proximal to distal with the link tube that each carries (drawn in the joint's frame, q = 0).

    Both are built on first access: a process that draws one joint does not build the others.
    """

    dimensions: LegDimensions
    joints: Sequence[BuiltJoint]
    links: Sequence[BuiltPart]

    @property
    def parts(self) -> tuple[BuiltPart, ...]:
        """Every part, joint by joint, each joint's link tube last."""
        return tuple(part for joint, link in zip(self.joints, self.links, strict=True) for part in (*joint.parts, link))

    def placements(self, *, filed: bool = False) -> tuple[Placement, ...]:
        """The position of each joint with every joint at its rest (or files') angle; the first is at the origin."""
        x = y = 0.0
        turn, result = self.dimensions.tilt, []
        for joint in self.dimensions.joints:
            result.append(Placement(x, y, turn))
            turn += joint.rotation(joint.filed_angle if filed else joint.rest_angle)
            x += joint.link_length * math.sin(math.radians(turn))
            y -= joint.link_length * math.cos(math.radians(turn))
        return tuple(result)

    def rest_meshes(self) -> list[tuple[BuiltPart, Mesh]]:
        """Every part's mesh in the leg's rest pose."""
        result = []
        for joint, link, place in zip(self.joints, self.links, self.placements(), strict=True):
            for part in (*joint.parts, link):
                mesh = joint.mesh_at(part, joint.dimensions.rest_angle)
                result.append((part, mesh.turned(place.turn, (place.x, place.y, 0.0))))
        return result


def build_leg(dimensions: LegDimensions) -> BuiltLeg:
    """Build all parts of a leg. Only the dimensions are checked; see ``cad.checks.check_leg``.

    Raises
    ------
    DimensionError
        with everything that does not fit, in all joints.
    """
    layouts, count = lay_out_leg(dimensions), len(dimensions.joints)

    def link(index: int) -> BuiltPart:
        length, following = tube_length(dimensions, layouts, index), layouts[index + 1 : index + 2]
        return _link(dimensions.joints[index], layouts[index], length, following)

    joints = BuiltWhenUsed(count, lambda index: _joint(dimensions.joints[index]))
    return BuiltLeg(dimensions, joints, BuiltWhenUsed(count, link))


def build_leg_of_facets(dimensions: LegDimensions) -> BuiltLeg:
    """As ``build_leg``, with parts of facets: only for their masses, at a twentieth of the time.

    Raises
    ------
    DimensionError
        with everything that does not fit, in all joints.
    """
    exact, count = build_leg(dimensions), len(dimensions.joints)

    def joint(index: int) -> BuiltJoint:
        with faceted():
            return assemble(dimensions.joints[index], lay_out(dimensions.joints[index]))

    def link(index: int) -> BuiltPart:
        with faceted():
            return exact.links[index]

    return replace(exact, joints=BuiltWhenUsed(count, joint), links=BuiltWhenUsed(count, link))


@lru_cache(maxsize=2)  # one leg is worked on at a time; the next one's joints may be the same
def built_leg(dimensions: LegDimensions) -> BuiltLeg:
    """The leg of these dimensions, from the cache if this process has begun to build it."""
    return build_leg(dimensions)


@lru_cache(maxsize=JOINTS_KEPT)
def _joint(dimensions: JointDimensions) -> BuiltJoint:
    return assemble(dimensions, lay_out(dimensions))


def lay_out_leg(dimensions: LegDimensions) -> tuple[JointLayout, ...]:
    """Lay out every joint of a leg and check that there is space for the link tubes between them.

    Raises
    ------
    DimensionError
        with the problems of all joints.
    """
    found = dimensions.problems()
    if found:
        raise DimensionError(found)
    layouts: list[JointLayout] = []
    for joint in dimensions.joints:
        try:
            layouts.append(lay_out(joint))
        except DimensionError as error:
            found += error.problems
    if found:
        raise DimensionError(found)
    found += [_short_link(dimensions, layouts, *each) for each in _short_links(dimensions, layouts)]
    if found:
        raise DimensionError(found)
    return tuple(layouts)


def link_problems(dimensions: LegDimensions) -> list[DimensionProblem]:
    """The links that are too short for their hinges, whatever makes these long; the joints fit by themselves."""
    layouts = [lay_out(joint) for joint in dimensions.joints]
    return [_sockets_meet(dimensions, *each) for each in _short_links(dimensions, layouts)]


def _short_links(dimensions: LegDimensions, layouts: Sequence[JointLayout]) -> Iterator[tuple[int, float]]:
    """Index and least length (mm) of each link that is too short for its hinges."""
    for index, (joint, layout) in enumerate(zip(dimensions.joints, layouts, strict=True)):
        shortest = layout.lower_bottom + layout.socket_depth
        if index + 1 < len(layouts):
            shortest += layouts[index + 1].upper_bottom + layouts[index + 1].socket_depth
        if joint.link_length < shortest:
            yield index, shortest


def _short_link(
    dimensions: LegDimensions, layouts: Sequence[JointLayout], index: int, shortest: float
) -> DimensionProblem:
    """A link too short for its hinges, under the responsible name: a damper as large as the link, or itself."""
    joint = dimensions.joints[index]
    widest = max(range(index, min(index + 2, len(layouts))), key=lambda k: layouts[k].bracket_radius)
    damper = layouts[widest].bracket_radius
    if damper >= layouts[widest].socket_radius - joint.clearance - 1e-9:
        name, spare = dimensions.joints[widest].name, (shortest - joint.link_length) / 2
        circle = dimensions.joints[widest].damper.bolt_circle
        fewer, longer = circle - 2 * spare, f"a link_length of {joint.name} of {rounded_up(shortest)} mm"
        smaller = replace(dimensions.joints[widest].damper, bolt_circle=fewer)
        least = least_bolt_circle(dimensions.joints[widest])
        allowed = longer if smaller.problems() or fewer < least else f"about {fewer:.3g} mm, or {longer}"
        reason = f"the damper's bracket is too wide for the link of {joint.link_length:g} mm beside it"
        return DimensionProblem(f"{name}.damper.bolt_circle", circle, allowed, reason)
    return _sockets_meet(dimensions, index, shortest)


def _sockets_meet(dimensions: LegDimensions, index: int, shortest: float) -> DimensionProblem:
    """A link too short for its hinges, under its own name; ``shortest`` mm."""
    joint = dimensions.joints[index]
    reason = "the sockets of its two hinges would meet; smaller springs or dampers make them shorter"
    if index + 1 == len(dimensions.joints):
        reason = "its one hinge and the tube's socket are as long; a smaller spring or damper makes them shorter"
    return DimensionProblem(
        f"{joint.name}.link_length", joint.link_length, f"at least {rounded_up(shortest)} mm", reason
    )


def tube_length(dimensions: LegDimensions, layouts: tuple[JointLayout, ...], index: int) -> float:
    """Length (mm) of the tube of link ``index``: from socket to socket, the last one to the leg's tip."""
    length = dimensions.joints[index].link_length - layouts[index].lower_bottom
    return length - layouts[index + 1].upper_bottom if index + 1 < len(layouts) else length


def link_name(dimensions: JointDimensions) -> str:
    """The name of the tube attached to a joint's lower half."""
    return f"{file_name(dimensions.name)}_link"


def _link(
    dimensions: JointDimensions, layout: JointLayout, length: float, following: Sequence[JointLayout]
) -> BuiltPart:
    """The tube attached to a joint's lower socket, drilled for the screws of both sockets."""
    along = ((0.0, -layout.lower_bottom, 0.0), (0.0, -1.0, 0.0))
    outer, inner = dimensions.link_width / 2, dimensions.link_width / 2 - dimensions.tube_wall
    tube = kernel.cylinder(outer, length, *along).cut(kernel.cylinder(inner, length, *along))
    far = -layout.lower_bottom - length
    holes = [(cross_screw(layout).screw.hole / 2, -layout.lower_bottom - layout.socket_depth / 2)]
    holes += [(cross_screw(other).screw.hole / 2, far + other.socket_depth / 2) for other in following]
    drilled = tube.cut(*(cylinder(radius, -outer - 1, outer + 1, (0.0, y)) for radius, y in holes)).Solids()[0]
    exact = math.pi * (outer**2 - inner**2) * length - sum(cross_volume(outer, inner, radius) for radius, _ in holes)
    return BuiltPart(
        name=link_name(dimensions),
        family="link",
        group="lower",
        solid=drilled,
        mesh=mesh_of(drilled),
        printed=False,
        exact_volume=exact,
        made=CutPart("tube", f"{2 * outer:g} x {dimensions.tube_wall:g}", length, "drilled"),
    )
