"""The gates that an export must pass. A kernel calls a wrong solid valid, so each gate has its own oracle.

Interference is computed on meshes (manifold3d) at the angular tolerance of ``cad.parts``. Over the travel the
lower half's parts turn against the upper half's; the spring is redrawn loaded at each of those poses
(``cad.pose``), not left out. Meant contacts are those of ``MEANT``, everything else must not overlap.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from cad.joint import BuiltJoint
from cad.leg import BuiltLeg
from cad.parts import BuiltPart, Mesh, file_name

OVERLAP_LIMIT = 0.05  # mm^3; chords of two coaxial bores 0.1 mm apart leave nothing, this is rounding
CONTACT_LIMIT = 1.0  # mm^3, of an arm in the shaft that it bears on, as meshes of both touch
SPRING_VOLUME_LIMIT = 1e-4  # relative
SOLID_VOLUME_LIMIT = 1e-5  # relative, of parts with a closed form
MESH_VOLUME_LIMIT = 5e-3  # relative, mesh against solid
CONTACT_TOLERANCE = 1e-3  # mm, arm to shaft on the unloaded spring
ANGLE_TOLERANCE = 1e-3  # deg
POSES = 13  # over the travel, its ends included

# Pairs that are meant to touch, by the end of their names: the spring's arms on their shafts.
MEANT = tuple(("spring", f"{half}_{role}") for half in ("upper", "lower") for role in ("arm_shaft", "keeper"))


@dataclass(frozen=True)
class CheckResult:
    """One gate: what was measured, against which limit, and whether it holds."""

    name: str
    part: str
    passed: bool
    value: float
    limit: float
    unit: str
    text: str

    def __str__(self) -> str:
        verdict = "passed" if self.passed else "FAILED"
        return (
            f"{verdict}: {self.part}: {self.name}: {self.value:.6g} (limit {self.limit:.6g}) {self.unit}; {self.text}"
        )


class GateError(RuntimeError):
    """One or more gates failed; ``results`` holds all of them, passed and failed."""

    def __init__(self, results: tuple[CheckResult, ...]) -> None:
        self.results = results
        super().__init__("\n".join(str(result) for result in results if not result.passed))


def _at_most(name: str, part: str, value: float, limit: float, unit: str, text: str) -> CheckResult:
    return CheckResult(name, part, bool(value <= limit), float(value), float(limit), unit, text)


def _at_least(name: str, part: str, value: float, limit: float, unit: str, text: str) -> CheckResult:
    return CheckResult(name, part, bool(value >= limit), float(value), float(limit), unit, text)


def check_part(part: BuiltPart) -> list[CheckResult]:
    """One valid solid, the volume that the closed form gives, and a closed mesh of that volume."""
    import trimesh

    solids, volume = len(part.solid.Solids()), float(part.solid.Volume())
    valid = solids == 1 and part.solid.isValid() and volume > 0
    results = [
        CheckResult("one valid solid", part.name, valid, float(solids), 1.0, "solids", "exactly one, valid, volume > 0")
    ]
    if part.exact_volume is not None:
        limit = SPRING_VOLUME_LIMIT if part.family == "spring" else SOLID_VOLUME_LIMIT
        error = abs(volume / part.exact_volume - 1.0)
        results.append(_at_most("volume", part.name, error, limit, "", f"solid against {part.exact_volume:.2f} mm^3"))
    mesh = trimesh.Trimesh(part.mesh.vertices, part.mesh.faces, process=False)
    # manifold3d turns a mesh that it cannot use into nothing, and nothing overlaps nothing.
    usable = not _manifold(part.mesh).is_empty()
    closed = bool(mesh.is_watertight and mesh.is_winding_consistent and usable)
    bodies = int(mesh.body_count)
    results.append(
        CheckResult(
            "closed mesh", part.name, closed and bodies == 1, float(bodies), 1.0, "bodies", "watertight, outward"
        )
    )
    error = abs(part.mesh.volume / volume - 1.0) if volume else math.inf
    results.append(
        _at_most("mesh volume", part.name, error, MESH_VOLUME_LIMIT, "", "mesh against solid, sign included")
    )
    box = part.solid.BoundingBox()
    low, high = part.mesh.vertices.min(axis=0), part.mesh.vertices.max(axis=0)
    off = np.abs(np.array([box.xmin, box.ymin, box.zmin, box.xmax, box.ymax, box.zmax]) - np.concatenate([low, high]))
    results.append(_at_most("bounding box", part.name, float(off.max()), 0.3, "mm", "solid against mesh"))
    return results


def check_pitch(joint: BuiltJoint) -> CheckResult:
    """Neighbouring coils must not run through each other: ``pitch cos(helix angle) >= d``; no kernel check sees it."""
    spring = joint.dimensions.spring
    angle = math.atan(spring.drawn_pitch / (math.pi * spring.mean_diameter))
    return _at_least(
        "pitch",
        joint.part("spring").name,
        spring.drawn_pitch * math.cos(angle),
        spring.wire_diameter,
        "mm",
        "pitch * cos(helix angle) against the wire's diameter",
    )


@dataclass(frozen=True)
class _Arm:
    """An arm's straight axis as the solid has it: a point (3,) and a unit direction (3,) outwards, mm."""

    point: np.ndarray[Any, Any]
    direction: np.ndarray[Any, Any]

    def seen_angle(self) -> float:
        """Direction seen along z, deg."""
        return math.degrees(math.atan2(self.direction[1], self.direction[0]))

    def distance_to(self, pin: BuiltPart, turn: float) -> float:
        """Shortest distance (mm) from the arm's axis to a shaft's axis, which is parallel to z."""
        centre = pin.solid.rotate((0, 0, 0), (0, 0, 1), turn).Center()
        across = np.array([self.direction[1], -self.direction[0]])
        across /= np.linalg.norm(across)
        return float(abs(np.dot(np.array([centre.x, centre.y]) - self.point[:2], across)))


def measured_arms(solid: Any) -> tuple[_Arm, _Arm]:
    """Both arms of a spring's solid, read from its flat ends: lower end first.

    Each end is a disc square to its arm, so its centre and outward normal are the arm's axis.
    """
    ends = [face for face in solid.Faces() if face.geomType() == "PLANE"]
    if len(ends) != 2:
        raise ValueError(f"a spring has two flat ends, this solid has {len(ends)}")
    arms = []
    for face in sorted(ends, key=lambda face: face.Center().z):
        centre, normal = face.Center(), face.normalAt()
        arms.append(_Arm(np.array(centre.toTuple()), np.array(normal.toTuple())))
    return arms[0], arms[1]


def check_arms(joint: BuiltJoint) -> list[CheckResult]:
    """At the free angle the unloaded spring's arms touch their shafts: the arm offset, measured on the solids."""
    dimensions, name = joint.dimensions, file_name(joint.dimensions.name)
    spring = joint.part("spring")
    arms = measured_arms(spring.solid)
    low_is_lower = joint.layout.flips[1] > 0
    lower, upper = arms if low_is_lower else arms[::-1]
    between = (lower.seen_angle() - upper.seen_angle()) * dimensions.sign % 360.0
    error = abs((between - dimensions.spring.included_angle + 180.0) % 360.0 - 180.0)
    results = [_at_most("included angle", spring.name, error, ANGLE_TOLERANCE, "deg", "between the drawn arms")]
    touching = (dimensions.spring.wire_diameter + dimensions.pin_diameter) / 2
    turn = joint.turn("lower", dimensions.free_angle)
    for half, arm in (("upper", upper), ("lower", lower)):
        for role, wanted in (("arm_shaft", touching), ("keeper", touching + dimensions.keeper_gap)):
            pin = joint.part(f"{half}_{role}")
            gap = arm.distance_to(pin, turn if half == "lower" else 0.0) - wanted
            text = f"{name}: arm to shaft at the free angle {dimensions.free_angle:g} deg, off by"
            results.append(_at_most("arm contact", pin.name, abs(gap), CONTACT_TOLERANCE, "mm", text))
    return results


def _manifold(mesh: Mesh) -> Any:
    import manifold3d

    return manifold3d.Manifold(
        manifold3d.Mesh(
            vert_properties=np.ascontiguousarray(mesh.vertices, dtype=np.float32),
            tri_verts=np.ascontiguousarray(mesh.faces, dtype=np.uint32),
        )
    )


def _turned(solid: Any, angle: float) -> Any:
    return solid.rotate((0.0, 0.0, angle))


def _meant(first: BuiltPart, second: BuiltPart) -> bool:
    return any(
        (first.name.endswith(a) and second.name.endswith(b)) or (first.name.endswith(b) and second.name.endswith(a))
        for a, b in MEANT
    )


def check_interference(joint: BuiltJoint, link: BuiltPart | None = None) -> list[CheckResult]:
    """Overlap of every pair of parts at the rest pose, and of all that moves on each other over the travel."""
    dimensions = joint.dimensions
    parts = [part for part in (*joint.parts, *([link] if link else [])) if part.group != "spring"]
    solids = {part.name: _manifold(part.mesh) for part in parts}
    results = _fixed_pairs(parts, solids)
    low, high = dimensions.range
    angles = sorted({*np.linspace(low, high, POSES).tolist(), dimensions.rest_angle})
    worst: dict[tuple[str, str], tuple[float, float]] = {}
    for angle in angles:
        for pair, volume in _overlaps_at(joint, parts, solids, angle).items():
            if volume > worst.get(pair, (-1.0, 0.0))[0]:
                worst[pair] = (volume, angle)
    for (first, second), (volume, angle) in worst.items():
        limit = CONTACT_LIMIT if any(first.endswith(a) and second.endswith(b) for a, b in MEANT) else OVERLAP_LIMIT
        text = f"with {second} over {low:g} to {high:g} deg, most at {angle:g}"
        results.append(_at_most("overlap", first, volume, limit, "mm^3", text))
    return results


def _fixed_pairs(parts: list[BuiltPart], solids: dict[str, Any]) -> list[CheckResult]:
    """Pairs that move together overlap nowhere; one result a pair of groups."""
    results = []
    for group in ("upper", "lower"):
        members = [part for part in parts if part.group == group]
        worst, pair = 0.0, "none"
        for index, first in enumerate(members):
            for second in members[index + 1 :]:
                volume = float((solids[first.name] ^ solids[second.name]).volume())
                if volume > worst:
                    worst, pair = volume, f"{first.name} in {second.name}"
        text = f"parts of the {group} half in each other; most: {pair}"
        results.append(_at_most("overlap within", members[0].name, worst, OVERLAP_LIMIT, "mm^3", text))
    return results


def _overlaps_at(
    joint: BuiltJoint, parts: list[BuiltPart], solids: dict[str, Any], angle: float
) -> dict[tuple[str, str], float]:
    """Common volume (mm^3) of each moving pair, and of the loaded spring with everything, at one joint angle."""
    turn = joint.turn("lower", angle)
    placed = {
        part.name: _turned(solids[part.name], turn) if part.group == "lower" else solids[part.name] for part in parts
    }
    spring = joint.part("spring")
    coil = _manifold(joint.mesh_at(spring, angle))
    result = {}
    for part in parts:
        result[(spring.name, part.name)] = float((coil ^ placed[part.name]).volume())
    for first in parts:
        for second in parts:
            if first.group == "upper" and second.group == "lower":
                result[(first.name, second.name)] = float((placed[first.name] ^ placed[second.name]).volume())
    return result


def check_keyed(joint: BuiltJoint) -> list[CheckResult]:
    """The D-shaft turns its own half and no other: turned a quarter in its bore it overlaps the lower half only."""
    shaft = _manifold(joint.part("shaft").mesh).rotate((0.0, 0.0, 90.0))
    keyed = float((shaft ^ _manifold(joint.part("lower").mesh)).volume())
    free = float((shaft ^ _manifold(joint.part("upper").mesh)).volume())
    name = joint.part("shaft").name
    return [
        _at_least("keyed", name, keyed, 1.0, "mm^3", "overlap with the lower half when turned a quarter"),
        _at_most("free", name, free, OVERLAP_LIMIT, "mm^3", "overlap with the upper half when turned a quarter"),
    ]


def check_gaps(joint: BuiltJoint) -> list[CheckResult]:
    """Least gap (mm) between upper and lower half over the travel: nothing tighter than the clearance."""
    dimensions = joint.dimensions
    upper, lower = (_manifold(joint.part(half).mesh) for half in ("upper", "lower"))
    low, high = dimensions.range
    search = 2 * dimensions.clearance
    gap = min(
        float(upper.min_gap(_turned(lower, joint.turn("lower", angle)), search)) for angle in np.linspace(low, high, 3)
    )
    limit = dimensions.clearance - 0.02  # chords of the meshes
    return [_at_least("gap", joint.part("lower").name, gap, limit, "mm", "least gap to the upper half at three poses")]


def check_joint(joint: BuiltJoint, link: BuiltPart | None = None) -> tuple[CheckResult, ...]:
    """Every gate of one joint; ``link`` is the tube in its lower socket, where there is one."""
    results: list[CheckResult] = []
    for part in (*joint.parts, *([link] if link else [])):
        results += check_part(part)
    results.append(check_pitch(joint))
    results += check_arms(joint)
    results += check_keyed(joint)
    results += check_gaps(joint)
    results += check_interference(joint, link)
    return tuple(results)


def check_links(leg: BuiltLeg) -> list[CheckResult]:
    """Each link's tube ends free in the next joint's upper socket, reaching its bottom."""
    results = []
    for joint, link, following in zip(leg.joints, leg.links, leg.joints[1:], strict=False):
        # Tube and next upper half share the link's line: the next frame lies one link length further down.
        tube = link.mesh.turned(0.0, (0.0, joint.dimensions.link_length, 0.0))
        upper = following.part("upper")
        volume = float((_manifold(tube) ^ _manifold(upper.mesh)).volume())
        results.append(_at_most("overlap", link.name, volume, OVERLAP_LIMIT, "mm^3", f"with {upper.name}"))
        gap = abs(float(tube.vertices[:, 1].min()) - following.layout.upper_bottom)
        results.append(
            _at_most("seat", link.name, gap, 1e-6, "mm", f"tube's end to the bottom of {upper.name}'s socket")
        )
    return results


def check_leg(leg: BuiltLeg) -> tuple[CheckResult, ...]:
    """Every gate of every joint, and of the links between them."""
    results: list[CheckResult] = []
    for joint, link in zip(leg.joints, leg.links, strict=True):
        results += check_joint(joint, link)
    return (*results, *check_links(leg))


def require(results: tuple[CheckResult, ...]) -> None:
    """Raise :class:`GateError` when any gate failed."""
    if not all(result.passed for result in results):
        raise GateError(results)
