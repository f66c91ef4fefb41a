"""Interference over the travel: overlap at every degree, contact angles by bisection, smallest gaps.

All on meshes (manifold3d). A pose of two bodies costs half a millisecond, so every degree is tested, with the parts of
each half as one body; the two overlapping parts are determined only if there is an overlap. The loaded spring is drawn
at every second degree (``cad.pose``), with a coarser mesh between the ends of the travel.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from synth.cad.free_wire import FreeWire, free_wire
from synth.cad.joint import BuiltJoint, spring_seats
from synth.cad.near_body import NearBody
from synth.cad.parts import BuiltPart, Group, Mesh
from synth.cad.results import CheckResult, check_at_least, check_at_most
from synth.cad.turning_rings import body_of, meeting_place, rings_of

OVERLAP_LIMIT = 0.05  # mm^3, rounding; the chords of two coaxial bores 0.1 mm apart do not overlap
TOUCHING = 1e-9  # mm^3, rounding of the common volume of parts that touch: up to 2e-13 in the built-in example
CHORD_DEPTH = 1e-4  # mm, mean depth of overlapping chords of a pin in its hole: 5e-5 at most on a shaft of 20 mm
CONTACT_SHARE = 0.01  # of a clamped arm's volume: overlap of its mesh with its seat by chords of a 20-sided wire
STEP = 1.0  # deg, between poses of the halves
SPRING_STEP = 2.0  # deg, between poses of the spring, whose arms sweep less than half a wire in that
CONTACT_ANGLE = 0.05  # deg, to which the angle of a first contact is bisected
STOP_ACCURACY = 0.3  # deg, tolerance of a stop's contact angle on the solids; printed faces 0.2 mm off cause as much
GAP_STEP = 5.0  # deg, between poses at which the smallest gap is measured
RUNNING = 0.5  # mm, between print and a shaft that runs in ball bearings: more than any print's error
CHORDS = 0.02  # mm, error of the gap between the meshes of round parts 0.4 mm apart
COARSE = 10  # sides of the spring's mesh between the ends of the travel

# Families that turn with the shaft, round about the hinge axis but for flats, pins and a set screw.
ROUND = ("shaft", "damper_adapter", "damper_insert", "collar", "washer")
ON_DAMPER = ("damper_pin", "damper_output_pin", "damper_set_screw")  # ends of names, of what is in those


def manifold(mesh: Mesh) -> Any:
    """The mesh as a manifold3d solid."""
    return mesh.manifold


def turn_solid(solid: Any, angle: float) -> Any:
    """A manifold3d solid turned by ``angle`` deg about the hinge axis."""
    return solid.rotate((0.0, 0.0, angle))


def gather_meshes(meshes: Sequence[Mesh]) -> Any:
    """Closed meshes as one manifold3d solid, without being united: they may touch."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]
    return manifold(Mesh(np.vstack([mesh.vertices for mesh in meshes]), np.vstack(faces)))


def is_round(part: BuiltPart) -> bool:
    """Whether a part of the lower half is round about the hinge axis, so that it can be tested separately."""
    return part.family in ROUND or part.name.endswith(ON_DAMPER)


class Bodies:
    """A joint's two halves as bodies that turn against each other; the spring, which changes shape, separately.

    Parts of a half touch each other in many faces, so to unite them takes longer than all tests. They are gathered in
    one body instead; what would lie in two of them counts twice in a volume.
    """

    def __init__(self, joint: BuiltJoint, link: BuiltPart | None = None) -> None:
        self.joint = joint
        parts = [part for part in (*joint.parts, *([link] if link else [])) if part.group != "spring"]
        groups: tuple[Group, ...] = ("upper", "lower")
        self.parts = {group: [part for part in parts if part.group == group] for group in groups}
        self.solids = {part.name: manifold(part.mesh) for part in parts}
        self.names = self._moving()  # of the parts that can collide, by half
        moving = {
            group: [part.mesh for part in self.parts[group] if part.name in self.names[group]] for group in groups
        }
        self.moving = {group: gather_meshes(meshes) for group, meshes in moving.items()}
        place = meeting_place(moving["upper"], moving["lower"])
        self.meeting = {group: body ^ place for group, body in self.moving.items()}  # all that can meet the other half
        self.halves = {group: gather_meshes([part.mesh for part in found]) for group, found in self.parts.items()}
        self.near = {group: NearBody(half) for group, half in self.halves.items()}

    def _moving(self) -> dict[Group, list[str]]:
        """Each half's parts, by name, without those that cannot collide: round ones, those beside the other half."""
        lower = [part for part in self.parts["lower"] if not is_round(part)]
        low, high = (end([end(p.mesh.vertices[:, 2]) for p in lower]) for end in (min, max))
        upper = [
            p for p in self.parts["upper"] if p.mesh.vertices[:, 2].min() < high and p.mesh.vertices[:, 2].max() > low
        ]
        return {"upper": [part.name for part in upper], "lower": [part.name for part in lower]}

    def overlap(self, angle: float) -> float:
        """Common volume (mm^3) of both halves at a measured joint angle, deg, without round parts."""
        turn = self.joint.turn("lower", angle)
        return float((self.meeting["upper"] ^ turn_solid(self.meeting["lower"], turn)).volume())

    def round_overlap(self) -> float:
        """Common volume (mm^3) of the upper half with the shaft, and what is keyed on it, turned in eight ways."""
        found = [part for part in self.parts["lower"] if is_round(part)]
        held = body_of([ring for part in found for ring in rings_of(part.mesh)])
        if (self.halves["upper"] ^ held).is_empty():
            return 0.0
        return max(self._most_turned(self.solids[part.name]) for part in found)

    def _most_turned(self, body: Any) -> float:
        """Largest common volume (mm^3) of the upper half with a round body, turned in steps of an eighth."""
        near = NearBody(self.halves["upper"])  # its own: what is near a washer is little
        bodies = [turn_solid(body, 45.0 * step) for step in range(8)]
        return max(float((near.near(each) ^ each).volume()) for each in bodies)

    def pair(self, angle: float) -> tuple[str, str, float]:
        """The two parts that overlap most at an angle, and their common volume, mm^3."""
        turn = self.joint.turn("lower", angle)
        found = [
            (float((self.solids[a.name] ^ turn_solid(self.solids[b.name], turn)).volume()), a.name, b.name)
            for a in self.parts["upper"]
            for b in self.parts["lower"]
            if not is_round(b)
        ]
        volume, first, second = max(found)
        return first, second, volume

    def spring_gap(self, angle: float, search: float) -> tuple[float, str]:
        """Least gap (mm, at most ``search``) of the loaded spring outside its seats to either half, and to which."""
        turns = {"upper": 0.0, "lower": self.joint.turn("lower", angle)}
        bodies = [(turn_solid(coil, -turns[group]), group) for coil in self.coils(angle) for group in self.parts]
        return min((float(body.min_gap(self.near[group].near(body, search), search)), group) for body, group in bodies)

    def coils(self, angle: float, sides: int | None = None) -> list[Any]:
        """Each loaded spring at an angle, outside its seats."""
        return [manifold(wire.whole()) for wire in self.wires(angle, sides)]

    def wires(self, angle: float, sides: int | None = None) -> list[FreeWire]:
        """Each loaded spring at an angle, outside its seats, as a tube."""
        seats = spring_seats(self.joint.dimensions, self.joint.layout)
        return [free_wire(*seat, angle, sides) for seat in seats]

    def clear_of_coils(self, wires: Sequence[FreeWire]) -> list[str]:
        """The halves that a spring's coil meets at none of its poses: nothing of them is in the ring that holds it."""
        ring = wires[0].coil_ring()
        for wire in wires[1:]:
            ring = ring.with_other(wire.coil_ring())
        held = body_of([ring])
        return [group for group, near in self.near.items() if (near.near(held) ^ held).is_empty()]

    def wire_overlap(self, body: Any, angle: float, group: Group) -> float:
        """Common volume (mm^3) of a spring or its arms with a half at an angle."""
        # The wire is turned into the half's frame: one small body is moved.
        moved = turn_solid(body, -self.joint.turn(group, angle))
        return float((moved ^ self.near[group].near(moved)).volume())

    def seat_overlap(self) -> tuple[float, str]:
        """Common volume (mm^3) of the unloaded spring with the halves, and with which: its clamped arms touch there."""
        angle = self.joint.dimensions.free_angle
        found = []
        for spring in self.joint.springs:
            whole = manifold(self.joint.mesh_at(spring, angle))
            for group in self.parts:
                moved = turn_solid(whole, -self.joint.turn(group, angle))
                found.append((float((moved ^ self.halves[group]).volume()), group))
        return max(found)


def poses(low: float, high: float, step: float, *more: float) -> list[float]:
    """Angles from ``low`` to ``high`` deg at most ``step`` apart, both ends and ``more`` among them."""
    count = max(1, math.ceil((high - low) / step))
    return sorted({*np.linspace(low, high, count + 1).tolist(), *more})


def first_contact(bodies: Bodies, start: float, end: float) -> float | None:
    """The angle (deg) at which the halves first overlap on the way from a free ``start`` to ``end``; None: never.

    In steps of a degree, then by bisection.
    """
    way = 1.0 if end > start else -1.0
    free, angle = start, start
    while angle != end:
        angle = end if abs(end - angle) <= STEP else angle + way * STEP
        if bodies.overlap(angle) > OVERLAP_LIMIT:
            while abs(angle - free) > CONTACT_ANGLE:
                middle = (angle + free) / 2
                free, angle = (free, middle) if bodies.overlap(middle) > OVERLAP_LIMIT else (middle, angle)
            return free
        free = angle
    return None


def stop_contacts(bodies: Bodies) -> list[tuple[float | None, str]]:
    """Angles (deg) of first contact of the halves downwards and upwards, with the parts; None: not within a turn."""
    rest = bodies.joint.dimensions.rest_angle
    found: list[tuple[float | None, str]] = []
    if bodies.overlap(rest) > OVERLAP_LIMIT:
        first, second, _ = bodies.pair(rest)
        return [(rest, f"{first} with {second}")] * 2
    for way in (-1.0, 1.0):
        angle = first_contact(bodies, rest, rest + way * 360.0)
        if angle is None:
            found.append((None, "nothing"))
        else:
            first, second, _ = bodies.pair(angle + way * 2 * CONTACT_ANGLE)
            found.append((angle, f"{first} with {second}"))
    return found


def check_travel(bodies: Bodies) -> list[CheckResult]:
    """From rest, the first contact in either direction is the stop, beyond the travel and before the spring yields."""
    joint, results = bodies.joint, []
    dimensions, name = joint.dimensions, joint.part("lower").name
    meant = {f"{joint.part('upper').name} with {name}"}
    for (found, parts), stop, end, what in zip(
        stop_contacts(bodies), dimensions.stop_angles, dimensions.range, ("low", "high"), strict=True
    ):
        off = math.inf if found is None or parts not in meant else abs(found - stop)
        at = "nowhere" if found is None else f"at {found:.5g} deg"
        text = f"{what} stop at {stop:.5g} deg, travel to {end:.5g}: {parts} meet {at}"
        results.append(check_at_most("stops", name, off, STOP_ACCURACY, "deg", text, angle=end))
    limits = dimensions.yields
    if limits is not None:
        spare = min(dimensions.stop_angles[0] - limits[0], limits[1] - dimensions.stop_angles[1])
        text = f"from the stops to where the spring yields ({limits[0]:.4g} and {limits[1]:.4g} deg)"
        results.append(check_at_least("stops before yield", name, spare, STOP_ACCURACY, "deg", text))
    return [
        *results,
        check_at_most("overlap", bodies.joint.part("shaft").name, bodies.round_overlap(), OVERLAP_LIMIT, "mm^3",
                "shaft and what is keyed on it with the upper half, turned in eight ways"),
    ]  # fmt: skip


def check_within(bodies: Bodies) -> list[CheckResult]:
    """Parts that move together overlap nowhere."""
    results = []
    for group, members in bodies.parts.items():
        worst, most = 0.0, ""
        for index, first in enumerate(members):
            near = [part for part in members[index + 1 :] if not _boxes_apart(first.mesh, part.mesh)]
            for second, volume in _overlapping_parts(bodies, first, near):
                if volume > worst:
                    worst, most = volume, f"; most: {first.name} in {second.name}"
        text = f"parts of the {group} half in each other{most}"
        results.append(check_at_most("overlap within", members[0].name, worst, OVERLAP_LIMIT, "mm^3", text))
    return results


def _overlapping_parts(bodies: Bodies, first: BuiltPart, near: Sequence[BuiltPart]) -> list[tuple[BuiltPart, float]]:
    """Those of some parts that overlap a ``first``, with the common volume, mm^3.

    The parts are tested together, and one by one only if any of them overlaps.
    """
    own = bodies.solids[first.name]
    if not near or (len(near) > 1 and float((own ^ gather_meshes([part.mesh for part in near])).volume()) < TOUCHING):
        return []
    found = [(part, _common_volume(bodies, first, part)) for part in near]
    return [(part, volume) for part, volume in found if volume >= TOUCHING]


def _common_volume(bodies: Bodies, first: BuiltPart, second: BuiltPart) -> float:
    """Common volume (mm^3) of two parts' meshes; of their solids where the meshes' may be that of chords alone."""
    meshes = bodies.solids[first.name], bodies.solids[second.name]
    volume = float((meshes[0] ^ meshes[1]).volume())
    if OVERLAP_LIMIT < volume < CHORD_DEPTH * min(float(mesh.surface_area()) for mesh in meshes):
        return float(first.solid.intersect(second.solid).Volume())
    return volume


def _boxes_apart(one: Mesh, other: Mesh) -> bool:
    """Whether the bounding boxes of two meshes have so little in common that the meshes do not overlap."""
    common = np.minimum(one.box[1], other.box[1]) - np.maximum(one.box[0], other.box[0])
    return bool(np.any(common <= 0.0) or np.prod(common) < TOUCHING)


def spring_overlaps(bodies: Bodies) -> dict[Group, tuple[float, float]]:
    """Largest common volume (mm^3) of a loaded spring with each half over the travel, and the angle, deg.

    The first of several angles. Where a coil is clear of a half at all angles, only its arms are tested at each.
    """
    dimensions = bodies.joint.dimensions
    ends = (*dimensions.stop_angles, dimensions.rest_angle)
    angles = poses(*dimensions.stop_angles, SPRING_STEP, dimensions.rest_angle)
    worst: dict[Group, tuple[float, float]] = {}
    found = [bodies.wires(angle, None if angle in ends else COARSE) for angle in angles]
    clear = [bodies.clear_of_coils(wires) for wires in zip(*found, strict=True)]
    for angle, wires in zip(angles, found, strict=True):
        for group in bodies.parts:
            volumes = [
                bodies.wire_overlap(manifold(wire.arms() if group in free else wire.whole()), angle, group)
                for wire, free in zip(wires, clear, strict=True)
            ]
            if max(volumes) > worst.get(group, (-1.0, 0.0))[0]:
                worst[group] = (max(volumes), angle)
    return worst


def check_spring_room(bodies: Bodies) -> list[CheckResult]:
    """The loaded spring overlaps nothing at any second degree; unloaded, its arms touch their seats."""
    dimensions = bodies.joint.dimensions
    low, high = dimensions.stop_angles
    worst = spring_overlaps(bodies)
    name, results = bodies.joint.part("spring").name, []
    for half, (volume, angle) in worst.items():
        text = f"with the {half} half, over {low:g} to {high:g} deg, most at {angle:.4g}"
        results.append(check_at_most("overlap", name, volume, OVERLAP_LIMIT, "mm^3", text, angle=angle))
    seat, wire = bodies.joint.layout.seat, dimensions.spring.wire_diameter
    volume, group = bodies.seat_overlap()
    limit = CONTACT_SHARE * math.pi / 4 * wire**2 * seat.length + OVERLAP_LIMIT
    text = f"of a clamped arm in its seat in the {group} half, unloaded: they touch without overlap"
    results.append(check_at_most("seated", name, volume, limit, "mm^3", text))
    ends = (low, dimensions.rest_angle, high)
    (gap, nearest), angle = min((bodies.spring_gap(end, 2 * dimensions.clearance), end) for end in ends)
    text = f"least gap to the {nearest} half at both stops and at rest, at {angle:.4g}; half the clearance is required"
    limit = dimensions.clearance / 2 - CHORDS
    return [*results, check_at_least("spring gap", name, gap, limit, "mm", text, angle=angle)]


def check_gaps(bodies: Bodies) -> list[CheckResult]:
    """Smallest gaps (mm) over the travel: between the halves, and around the shaft except in its bearings.

    Interference fits within a half are not checked, because nothing moves in them.
    """
    joint, dimensions = bodies.joint, bodies.joint.dimensions
    shaft = joint.part("shaft").name
    upper, lower = bodies.moving["upper"], bodies.moving["lower"]
    search = 2 * dimensions.clearance
    low, high = dimensions.range
    gap, angle = search, low
    for pose in poses(low, high, GAP_STEP):  # a search that ends at the least gap so far takes less time
        found = float(upper.min_gap(turn_solid(lower, joint.turn("lower", pose)), gap))
        gap, angle = min((gap, angle), (found, pose))
    if gap < dimensions.clearance - CHORDS:  # chords of large round faces reduce the mesh's gap: measure the solids
        gap = float(joint.part("upper").solid.distance(joint.solid_at(joint.part("lower"), angle)))
    printed = NearBody(gather_meshes([part.mesh for part in bodies.parts["upper"] if part.printed]))
    fit = float(printed.near(bodies.solids[shaft], search).min_gap(bodies.solids[shaft], search))
    text = f"least gap to the upper half over {low:g} to {high:g} deg, at {angle:.4g}"
    least = min(dimensions.clearance, RUNNING) - CHORDS
    return [
        check_at_least("gap", joint.part("lower").name, gap, dimensions.clearance - CHORDS, "mm", text, angle=angle),
        check_at_least("running gap", shaft, fit, least, "mm", "shaft to print round it"),
    ]
