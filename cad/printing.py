"""Printability: wall thickness, best orientation, support, and bed size."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from synth.cad.fittings import PrintDimensions
from synth.cad.hinge import cross_screw
from synth.cad.joint import BuiltJoint
from synth.cad.parts import BuiltPart, Mesh
from synth.cad.results import CheckResult, check_at_least, check_at_most
from synth.cad.strength import Axis, check_strength
from synth.cad.travel import CHORDS, manifold

Array = NDArray[np.float64]
SAMPLES = 1000  # points on a part's surface at which its thickness is measured
PERCENTILE = 1.0  # of those; the smallest value is at an edge that two faces share
FIRST = 15.0  # mm, of the first ray, which most walls end; a ray through the whole part takes four times as long
OPPOSED = 0.7  # cosine between the faces of a wall; a ray that leaves through an oblique face measures a corner
BASE_LAYER = 0.3  # mm above the bed; faces below this height lie on the bed
FLAT = 0.9999  # cosine between bed and a face on it: 0.8 deg, so that of a round only its lowest facet counts
LEAST_CONTACT = 0.05  # of the footprint; a part that stands on less needs a brim or a raft
# Overhangs that count as the same, relative and mm^2 (a support tower of 7 x 7 mm): there the contact decides as well.
ALIKE_OVERHANGS = (1.25, 50.0)
MOST_SUPPORT = 0.3  # of the surface; above this the part should be designed differently
# Directions in which a part may be printed: the axis that points up.
WAYS_UP: dict[str, Axis] = {
    "+z": (0.0, 0.0, 1.0),
    "-z": (0.0, 0.0, -1.0),
    "+y": (0.0, 1.0, 0.0),
    "-y": (0.0, -1.0, 0.0),
    "+x": (1.0, 0.0, 0.0),
    "-x": (-1.0, 0.0, 0.0),
}


@dataclass(frozen=True)
class PrintPlan:
    """The best orientation of a part in its own file's frame, and its requirements."""

    part: str
    up: str  # key of WAYS_UP
    overhang: float  # mm^2 that needs support
    share: float  # of the surface
    size: tuple[float, float, float]  # mm, on the bed (two) and high
    fits: bool
    strong: bool
    contact: float  # mm^2 of flat faces on the bed

    @property
    def wobbly(self) -> bool:
        """Whether the part stands on so little of its footprint that it needs a brim or a raft."""
        return self.contact < LEAST_CONTACT * self.size[0] * self.size[1]


def wall_thickness(mesh: Mesh, samples: int = SAMPLES, seed: int = 0) -> tuple[Array, Array]:
    """Points (n, 3) distributed over the surface by area, and the thickness (n,) mm there, inwards to the opposite
    face.

    Rays that leave through a face that is not nearly opposite are left out: they measure a corner, not a wall.
    """
    corners, normals, areas, _ = mesh.triangles
    random = np.random.default_rng(seed)
    chosen = random.choice(len(areas), samples, p=areas / areas.sum())
    first, second = np.sqrt(random.random(samples)), random.random(samples)
    weights = np.column_stack([1 - first, first * (1 - second), first * second])
    points = np.einsum("nk,nkj->nj", weights, corners[chosen])
    far = 2 * float(np.ptp(mesh.vertices, axis=0).sum())
    solid, places, found = manifold(mesh), [], []
    for point, normal in zip(points, normals[chosen], strict=True):
        hits: list[Any] = solid.ray_cast(point - 1e-4 * normal, point - min(FIRST, far) * normal)
        if not hits:
            hits = solid.ray_cast(point - 1e-4 * normal, point - far * normal)
        if hits and float(np.dot(hits[0].normal, normal)) < -OPPOSED:
            places.append(point)
            found.append(float(np.linalg.norm(np.array(hits[0].position) - point)))
    return np.array(places).reshape(-1, 3), np.array(found)


def thin_points(mesh: Mesh, thinnest: float) -> Array:
    """Points (n, 3) mm of the surface above walls thinner than ``thinnest`` mm."""
    points, thickness = wall_thickness(mesh)
    return points[thickness < thinnest]


def hanging_faces(mesh: Mesh, up: Axis, angle: float) -> NDArray[np.int64]:
    """Indices of the faces that overhang by more than ``angle`` deg from the vertical, except those on the bed."""
    return np.asarray(np.flatnonzero(mesh.triangles[3])[_hanging_triangles(mesh, up, angle)], dtype=np.int64)


def overhang(mesh: Mesh, up: Axis, angle: float) -> float:
    """Area (mm^2) that needs support; see :func:`hanging_faces`."""
    return float(mesh.triangles[2][_hanging_triangles(mesh, up, angle)].sum())


def _hanging_triangles(mesh: Mesh, up: Axis, angle: float) -> NDArray[np.bool_]:
    """Which of the mesh's ``triangles`` hang over."""
    corners, normals, _, _ = mesh.triangles
    height = corners @ np.array(up)
    leaning = normals @ np.array(up) < -math.sin(math.radians(angle))
    return np.asarray(leaning & (height.max(axis=1) > height.min() + BASE_LAYER))


def contact(mesh: Mesh, up: Axis) -> float:
    """Area (mm^2) of the flat faces that lie on the bed."""
    corners, normals, areas, _ = mesh.triangles
    height = corners @ np.array(up)
    lying = (normals @ np.array(up) < -FLAT) & (height.max(axis=1) <= height.min() + BASE_LAYER)
    return float(areas[lying].sum())


def on_bed(mesh: Mesh, up: Axis, bed: tuple[float, float, float]) -> tuple[tuple[float, float, float], bool]:
    """Size (mm) on the bed and height, and whether it fits, with or without a quarter turn."""
    size = np.ptp(mesh.vertices, axis=0)
    axis = int(np.argmax(np.abs(up)))
    flat = sorted((float(size[i]) for i in range(3) if i != axis), reverse=True)
    room = sorted(bed[:2], reverse=True)
    fits = flat[0] <= room[0] and flat[1] <= room[1] and float(size[axis]) <= bed[2]
    return (flat[0], flat[1], float(size[axis])), fits


def plan_part(joint: BuiltJoint, part: BuiltPart, printing: PrintDimensions) -> PrintPlan:
    """The best orientation: first those that fit the bed and bear the load, then least support, then lowest height.

    Among orientations whose support is alike the contact with the bed counts against it. The joint caches the plan for
    checks, files and report.
    """
    key = ("plan", part.name, printing)
    if key not in joint.kept:
        joint.kept[key] = _best_way_up(joint, part, printing)
    plan: PrintPlan = joint.kept[key]
    return plan


def _best_way_up(joint: BuiltJoint, part: BuiltPart, printing: PrintDimensions) -> PrintPlan:
    surface = float(part.mesh.triangles[2].sum())
    plans = []
    for name, up in WAYS_UP.items():
        size, fits = on_bed(part.mesh, up, printing.bed)
        checks = check_strength(joint.dimensions, joint.layout, printing, {part.name: up})
        strong = all(check.passed for check in checks if check.part == part.name)
        area = overhang(part.mesh, up, printing.overhang)
        plans.append(PrintPlan(part.name, name, area, area / surface, size, fits, strong, contact(part.mesh, up)))
    return best_of(plans)


def best_of(plans: Sequence[PrintPlan]) -> PrintPlan:
    """The best of a part's orientations, as ``plan_part`` ranks them."""
    first = min((not plan.fits, not plan.strong) for plan in plans)
    able = [plan for plan in plans if (not plan.fits, not plan.strong) == first]
    most = ALIKE_OVERHANGS[0] * min(plan.overhang for plan in able) + ALIKE_OVERHANGS[1]
    alike = [plan for plan in able if plan.overhang <= most]
    return min(alike, key=lambda plan: (round(plan.overhang - plan.contact), round(plan.size[2], 3)))


def plan_joint(joint: BuiltJoint, printing: PrintDimensions) -> tuple[PrintPlan, ...]:
    """The plan of every printed part."""
    return tuple(plan_part(joint, part, printing) for part in joint.parts if part.printed)


def _thicker(family: str) -> str:
    """What makes the thinnest walls of a printed part thicker."""
    if family == "damper_insert":  # between the shaft and the damper's bore
        return "use a thinner shaft, or a damper with a larger bore"
    return "increase wall"


def _check_socket_walls(joint: BuiltJoint, printing: PrintDimensions) -> list[CheckResult]:
    """What the flats for its screw's head and nut leave of each socket, which bears their clamping force.

    In closed form: the flats are less than ``PERCENTILE`` of a half's surface.
    """
    dimensions = joint.dimensions
    left = cross_screw(joint.layout).flat - (dimensions.link_width / 2 + dimensions.fit)
    text = "left of the tube's socket under its screw's head and nut; increase wall"
    halves = ("lower",) if dimensions.mount is not None else ("upper", "lower")
    names = [joint.part(half).name for half in halves]
    return [check_at_least("print: wall", name, left, printing.thinnest, "mm", text) for name in names]


def check_printing(joint: BuiltJoint, printing: PrintDimensions) -> list[CheckResult]:
    """Walls, bed, support and strength of the printed parts in their best orientations; strength of steel ones."""
    results: list[CheckResult] = []
    plans = plan_joint(joint, printing)
    for plan in plans:
        part = next(part for part in joint.parts if part.name == plan.part)
        wall = float(np.percentile(wall_thickness(part.mesh)[1], PERCENTILE))
        text = f"{PERCENTILE:g} % of the surface is thinner; {_thicker(part.family)}"
        results.append(check_at_least("print: wall", part.name, wall, printing.thinnest - CHORDS, "mm", text))
        long, wide, high = plan.size
        room = " x ".join(f"{size:g}" for size in printing.bed)
        text = f"{long:.1f} x {wide:.1f} x {high:.1f} mm with {plan.up} up, bed {room} mm"
        text += "; use a smaller spring or plate, or a larger printing.bed"
        room_each = (*sorted(printing.bed[:2], reverse=True), printing.bed[2])
        tight = max(range(3), key=lambda k: plan.size[k] / room_each[k])
        value, limit = plan.size[tight], room_each[tight]
        results.append(CheckResult("print: bed", part.name, plan.fits, value, limit, "mm", text))
        text = f"of the surface ({plan.overhang:.0f} mm^2) needs support with {plan.up} up"
        results.append(check_at_most("print: support", part.name, plan.share, MOST_SUPPORT, "", text))
    results += _check_socket_walls(joint, printing)
    layers = {plan.part: WAYS_UP[plan.up] for plan in plans}
    return results + check_strength(joint.dimensions, joint.layout, printing, layers)
