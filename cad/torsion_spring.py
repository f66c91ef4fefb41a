"""A torsion spring as one swept solid, and as a mesh of nearly its exact volume for pictures, STL and clearance.

Own frame, mm: the coil's axis is z, its first tangent point lies on +x at z = 0, the first arm points
along -y (right hand) or +y (left hand), the second arm leaves at the top.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from synth.cad import facets, kernel
from synth.cad.dimensions import SpringDimensions

Array = NDArray[np.float64]
SIDES = 20  # of the mesh's tube
STEPS_PER_TURN = 48  # points of the helix: 1 - cos(pi/48) = 0.2 % of the radius between two
FINE_SIDES, FINE_STEPS = 12, 144  # of the facets from which its mass is computed


def coil_length(spring: SpringDimensions) -> float:
    """Length (mm) of the wire in the coil: a helix of ``drawn_coils`` turns."""
    return spring.drawn_coils * math.hypot(math.pi * spring.mean_diameter, spring.drawn_pitch)


def wire_length(spring: SpringDimensions, arm_length: float) -> float:
    """Length (mm) of the whole wire, both arms included."""
    return coil_length(spring) + 2 * arm_length


def spring_volume(spring: SpringDimensions, arm_length: float) -> float:
    """Volume (mm^3), exact: a disc swept normal to a curve through its centre (Pappus)."""
    return math.pi * spring.wire_diameter**2 / 4 * wire_length(spring, arm_length)


def top_arm_direction(spring: SpringDimensions) -> float:
    """Direction (deg, seen along z, own frame) of the arm that leaves at the top."""
    return spring.hand_sign * (360.0 * spring.drawn_coils + 90.0)


def bottom_arm_direction(spring: SpringDimensions) -> float:
    """Direction (deg, seen along z, own frame) of the arm that leaves at the bottom."""
    return -90.0 * spring.hand_sign


def _tangent(spring: SpringDimensions, angle: float) -> Array:
    """Unit tangent (3,) of the helix at ``angle`` rad; its axial part makes the transition to the arms smooth."""
    rise = spring.drawn_pitch / (2 * math.pi)
    hand = spring.hand_sign
    tangent = np.array(
        [-spring.radius * math.sin(angle), hand * spring.radius * math.cos(angle), rise], dtype=np.float64
    )
    return np.asarray(tangent / math.hypot(spring.radius, rise), dtype=np.float64)


def _ends(spring: SpringDimensions, arm_length: float) -> tuple[Array, Array, Array, Array]:
    """The four corners of the wire's centre line (3,), mm: free end, tangent point, tangent point, free end."""
    turned = 2 * math.pi * spring.drawn_coils
    start = np.array([spring.radius, 0.0, 0.0])
    finish = np.array(
        [
            spring.radius * math.cos(turned),
            spring.hand_sign * spring.radius * math.sin(turned),
            spring.drawn_coils * spring.drawn_pitch,
        ]
    )
    return (
        start - arm_length * _tangent(spring, 0.0),
        start,
        finish,
        finish + arm_length * _tangent(spring, turned),
    )


def build_spring(spring: SpringDimensions, arm_length: float) -> Any:
    """The spring as one cadquery Solid in its own frame.

    One wire line-helix-line, smooth where they meet, swept by a circle that starts at a free end with the
    Frenet frame. A sweep with a fixed binormal is valid and watertight but has 4 % of the volume; with a spline
    through helix points the volume is 8 % off. Neither may be used; the volume check would detect both.
    """
    if kernel.in_facets():
        # Points of the helix stand outside it by as much as makes their chords' mean square radius its own.
        step = math.tau / FINE_STEPS
        wide = 1.0 / math.sqrt(1.0 - 2.0 / 3.0 * math.sin(step / 2) ** 2)
        line = centre_line(replace(spring, mean_diameter=wide * spring.mean_diameter), arm_length, FINE_STEPS)
        return facets.solid_of_mesh(*tube_mesh(line, spring.wire_diameter, FINE_SIDES))
    import cadquery as cq

    free, start, finish, far = (cq.Vector(*corner) for corner in _ends(spring, arm_length))
    helix = cq.Wire.makeHelix(
        spring.drawn_pitch,
        spring.drawn_pitch * spring.drawn_coils,
        spring.radius,
        lefthand=spring.hand_sign < 0,
    )
    path = cq.Wire.assembleEdges([cq.Edge.makeLine(free, start), *helix.Edges(), cq.Edge.makeLine(finish, far)])
    plane = cq.Plane(origin=free.toTuple(), normal=tuple(_tangent(spring, 0.0)))
    swept = cq.Workplane(plane).circle(spring.wire_diameter / 2).sweep(cq.Workplane(path), isFrenet=True)
    solids = swept.solids().vals()
    return solids[0] if len(solids) == 1 else cq.Compound.makeCompound(solids)


def centre_line(spring: SpringDimensions, arm_length: float, steps_per_turn: int = STEPS_PER_TURN) -> Array:
    """Points (n, 3) mm on the wire's centre line, from free end to free end, all distinct."""
    steps = max(8, math.ceil(steps_per_turn * spring.drawn_coils))
    angle = np.linspace(0.0, 2 * math.pi * spring.drawn_coils, steps + 1)
    coil = np.column_stack(
        [
            spring.radius * np.cos(angle),
            spring.hand_sign * spring.radius * np.sin(angle),
            spring.drawn_pitch * angle / (2 * math.pi),
        ]
    )
    free, _, _, far = _ends(spring, arm_length)
    return np.vstack([free, coil, far])


def spring_mesh(
    spring: SpringDimensions, arm_length: float, sides: int = SIDES, steps_per_turn: int = STEPS_PER_TURN
) -> tuple[Array, NDArray[np.int64]]:
    """Closed tube mesh in the spring's own frame: vertices (n, 3) mm and faces (m, 3), outward."""
    return tube_mesh(centre_line(spring, arm_length, steps_per_turn), spring.wire_diameter, sides)


def tube_mesh(points: Array, diameter: float, sides: int = SIDES) -> tuple[Array, NDArray[np.int64]]:
    """Closed mesh of round wire along ``points`` (n, 3) mm: vertices (m, 3) and faces (k, 3), outward.

    The section is a polygon of the wire's area (circumradius enlarged by ``sqrt(pi / (n/2 sin(2 pi/n)))``),
    so the volume is right to 4e-3 where a tessellated sweep of the same size is 2 % short.
    Rings stand square to the curve: a normal along z x tangent, which no wire here is parallel to, and the binormal.
    """
    steps = np.diff(points, axis=0)
    steps /= np.linalg.norm(steps, axis=1, keepdims=True)
    tangents = np.vstack([steps[:1], steps[1:] + steps[:-1], steps[-1:]])
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    radial = np.column_stack([tangents[:, 1], -tangents[:, 0], np.zeros(len(points))])
    radial /= np.linalg.norm(radial, axis=1, keepdims=True)
    binormal = np.cross(tangents, radial)
    around = 2 * math.pi * np.arange(sides) / sides
    size = diameter / 2 * math.sqrt(math.pi / (sides / 2 * math.sin(2 * math.pi / sides)))
    ring = size * (
        np.cos(around)[None, :, None] * radial[:, None, :] + np.sin(around)[None, :, None] * binormal[:, None, :]
    )
    vertices = np.vstack([(points[:, None, :] + ring).reshape(-1, 3), points[:1], points[-1:]])
    return vertices, tube_faces(len(points), sides)


@lru_cache(maxsize=64)  # the springs of a leg's poses have a handful of sizes
def tube_faces(rings: int, sides: int) -> NDArray[np.int64]:
    """Faces (m, 3) of a tube of ``rings`` rings of ``sides`` points whose two end centres are the last two vertices."""
    here = np.arange(sides)
    after = (here + 1) % sides
    faces = []
    base = sides * np.arange(rings - 1)[:, None]
    a, b, c, d = base + here, base + after, base + sides + here, base + sides + after
    faces.append(np.stack([a, b, d], axis=-1).reshape(-1, 3))
    faces.append(np.stack([a, d, c], axis=-1).reshape(-1, 3))
    first, last = rings * sides, rings * sides + 1
    final = (rings - 1) * sides
    faces.append(np.column_stack([np.full(sides, first), after, here]))
    faces.append(np.column_stack([np.full(sides, last), final + here, final + after]))
    return np.vstack(faces).astype(np.int64)
