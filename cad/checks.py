"""The checks that an export must pass. A kernel may call a wrong solid valid, so each check has its own reference.

This module has the checks of each part, alone and on its shafts. Moving parts are checked in ``cad.travel``, printing
in ``cad.printing``, strength in ``cad.strength``.
"""

from __future__ import annotations

import math

import numpy as np

from synth.cad.chain_checks import check_chain
from synth.cad.fittings import PrintDimensions
from synth.cad.flexed_wire import effective_length
from synth.cad.hardware_checks import check_axial_play, check_keyed, check_screws
from synth.cad.joint import BuiltJoint
from synth.cad.leg_joints import BuiltLeg
from synth.cad.parts import BuiltPart
from synth.cad.play import check_play
from synth.cad.printing import check_printing
from synth.cad.results import CheckResult, GateError, check_at_least, check_at_most, require
from synth.cad.seat_room import check_seat_room
from synth.cad.spring_solid import measured_arms, measured_stiff_length
from synth.cad.travel import OVERLAP_LIMIT, Bodies, check_gaps, check_spring_room, check_travel, check_within, manifold

SPRING_VOLUME_LIMIT = 1e-4  # relative, of the swept wire against its length times cross-section
SOLID_VOLUME_LIMIT = 1e-5  # relative, of parts with a closed form
VOLUME_ERROR = 1e-3  # relative, bound on the kernel's error; the actual error is 3e-8
MESH_VOLUME_LIMIT = 5e-3  # relative, mesh against solid: chords of LINEAR_TOLERANCE on small radii
LEVERS_LIMIT = 5e-3  # relative, of the drawn spring's rate against the designed one's
ANGLE_TOLERANCE = 1e-3  # deg, for rounding in the solids; windings are off by degrees (synth/parts/part_tolerance.py)


def check_part(part: BuiltPart) -> list[CheckResult]:
    """One valid solid, the volume from the closed form, and a closed mesh of that volume."""
    import trimesh

    solids, volume = len(part.solid.Solids()), _volume(part)
    valid = solids == 1 and part.solid.isValid() and volume > 0
    results = [
        CheckResult("one valid solid", part.name, valid, float(solids), 1.0, "solids", "exactly one, valid, volume > 0")
    ]
    if part.exact_volume is not None:
        limit = SPRING_VOLUME_LIMIT if part.family == "spring" else SOLID_VOLUME_LIMIT
        error = abs(volume / part.exact_volume - 1.0)
        results.append(
            check_at_most("volume", part.name, error, limit, "", f"solid against {part.exact_volume:.2f} mm^3")
        )
    mesh = trimesh.Trimesh(part.mesh.vertices, part.mesh.faces, process=False)
    # manifold3d turns a mesh that it cannot use into an empty body, which would pass every overlap check.
    usable = not manifold(part.mesh).is_empty()
    closed = bool(mesh.is_watertight and mesh.is_winding_consistent and usable)
    bodies = int(mesh.body_count)
    results.append(
        CheckResult(
            "closed mesh", part.name, closed and bodies == 1, float(bodies), 1.0, "bodies", "watertight, outward"
        )
    )
    error = abs(part.mesh.volume / volume - 1.0) if volume else math.inf
    results.append(
        check_at_most("mesh volume", part.name, error, MESH_VOLUME_LIMIT, "", "mesh against solid, sign included")
    )
    box = part.solid.BoundingBox()
    low, high = part.mesh.vertices.min(axis=0), part.mesh.vertices.max(axis=0)
    off = np.abs(np.array([box.xmin, box.ymin, box.zmin, box.xmax, box.ymax, box.zmax]) - np.concatenate([low, high]))
    results.append(check_at_most("bounding box", part.name, float(off.max()), 0.3, "mm", "solid against mesh"))
    return results


def _volume(part: BuiltPart) -> float:
    """Volume of the solid, mm^3; to 1e-7 if a closed form is compared that tightly.

    The kernel's default method takes a fixed number of points per face; its error is 6e-6 if a screw hole crosses a
    tube.
    """
    if part.exact_volume is None or part.family == "spring":
        return part.moments().volume
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    found = GProp_GProps()
    BRepGProp.VolumeProperties_s(part.solid.wrapped, found, VOLUME_ERROR)
    return float(found.Mass())


def check_pitch(joint: BuiltJoint) -> CheckResult:
    """Neighbouring coils must not intersect: ``pitch cos(helix angle) >= d``; no kernel check detects it."""
    spring = joint.dimensions.spring
    angle = math.atan(spring.drawn_pitch / (math.pi * spring.mean_diameter))
    return check_at_least(
        "pitch",
        joint.part("spring").name,
        spring.drawn_pitch * math.cos(angle),
        spring.wire_diameter,
        "mm",
        "pitch * cos(helix angle) against the wire's diameter",
    )


def check_arms(joint: BuiltJoint) -> list[CheckResult]:
    """The drawn spring is the designed one: its arms' angle and its rate, measured on the solids."""
    return [
        result
        for spring, which in zip(joint.springs, ("", "_2"), strict=False)
        for result in _check_arms(joint, spring, which)
    ]


def _check_arms(joint: BuiltJoint, spring: BuiltPart, which: str) -> list[CheckResult]:
    dimensions = joint.dimensions
    arms = measured_arms(spring.solid)
    low_is_lower = joint.seat(spring)[1].flips[1] > 0
    lower, upper = arms if low_is_lower else arms[::-1]
    between = (lower.seen_angle() - upper.seen_angle()) * dimensions.opening_sign % 360.0
    error = abs((between - dimensions.spring.included_angle + 180.0) % 360.0 - 180.0)
    results = [check_at_most("included angle", spring.name, error, ANGLE_TOLERANCE, "deg", "between the drawn arms")]
    turn = joint.turn("lower", dimensions.free_angle)
    frees = (
        upper.start_of(joint.part(f"upper_cap{which}").solid, 0.0),
        lower.start_of(joint.part(f"lower_cap{which}").solid, turn),
    )
    found = measured_stiff_length(spring.solid, dimensions.spring.wire_diameter, frees)
    wanted = dimensions.spring.stiff_length
    if wanted is None:
        wanted = effective_length(dimensions.spring.radius, dimensions.spring.drawn_coils, joint.layout.free_arm)
    text = f"rate of the drawn spring with arms free over {frees[0]:.3f} and {frees[1]:.3f} mm, over the designed one"
    results.append(check_at_most("levers", spring.name, abs(wanted / found - 1.0), LEVERS_LIMIT, "", text))
    return results


def check_interference(joint: BuiltJoint, link: BuiltPart | None = None) -> list[CheckResult]:
    """Pairs that must not overlap: parts of one half, the halves over the travel, the spring and all but its shafts."""
    bodies = Bodies(joint, link)
    return [
        *check_within(bodies),
        *check_travel(bodies),
        *check_spring_room(bodies),
        *check_seat_room(bodies),
        *check_gaps(bodies),
        *check_play(bodies),
        *check_axial_play(bodies),
    ]


def check_parts(joint: BuiltJoint, link: BuiltPart | None = None) -> list[CheckResult]:
    """Each part alone, the spring's sizes, and what is keyed and screwed on."""
    results: list[CheckResult] = []
    for part in (*joint.parts, *([link] if link else [])):
        results += check_part(part)
    return [*results, check_pitch(joint), *check_arms(joint), *check_keyed(joint), *check_screws(joint)]


def check_joint(
    joint: BuiltJoint, link: BuiltPart | None = None, printing: PrintDimensions | None = None
) -> tuple[CheckResult, ...]:
    """Every gate of one joint; ``link`` is the tube in its lower socket, if any."""
    return (
        *check_parts(joint, link),
        *check_interference(joint, link),
        *check_printing(joint, printing or PrintDimensions()),
    )


def check_link(leg: BuiltLeg, index: int) -> list[CheckResult]:
    """A link's tube ends in the next joint's upper socket and reaches its bottom."""
    # Tube and next upper half share the link's line: the next frame lies one link length further down.
    link, following = leg.links[index], leg.joints[index + 1]
    tube = link.mesh.turned(0.0, (0.0, leg.dimensions.joints[index].link_length, 0.0))
    upper = following.part("upper")
    volume = float((manifold(tube) ^ manifold(upper.mesh)).volume())
    gap = abs(float(tube.vertices[:, 1].min()) - following.layout.upper_bottom)
    return [
        check_at_most("overlap", link.name, volume, OVERLAP_LIMIT, "mm^3", f"with {upper.name}"),
        check_at_most("seat", link.name, gap, 1e-6, "mm", f"tube's end to the bottom of {upper.name}'s socket"),
    ]


def check_links(leg: BuiltLeg) -> list[CheckResult]:
    """Every link that another joint follows."""
    return [result for index in range(len(leg.joints) - 1) for result in check_link(leg, index)]


def check_leg(leg: BuiltLeg) -> tuple[CheckResult, ...]:
    """Every gate of every joint, of the links between them, and of parts of different joints."""
    results: list[CheckResult] = []
    for joint, link in zip(leg.joints, leg.links, strict=True):
        results += check_joint(joint, link, leg.dimensions.printing)
    return (*results, *check_links(leg), *check_chain(leg))


__all__ = [
    "CheckResult",
    "GateError",
    "check_arms",
    "check_axial_play",
    "check_chain",
    "check_interference",
    "check_joint",
    "check_keyed",
    "check_leg",
    "check_link",
    "check_links",
    "check_part",
    "check_parts",
    "check_pitch",
    "check_screws",
    "measured_arms",
    "require",
]
