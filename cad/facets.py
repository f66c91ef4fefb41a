"""Solids as fine facets: what cadquery's solids offer to the builders of this package, at a fiftieth of the time.

For masses only: circles are regular polygons of their area, so volume, centre and inertia of a joint's parts are within
``1e-5`` of those of the exact solids (a test compares all of them). Files, checks and pictures use exact solids.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from synth.cad.moments import Moments, Vector

SAGITTA = 0.02  # mm, of a chord under its arc: masses of the built-in example's parts are then within 1e-5 (test)
LEAST_CHORDS = 32  # chords to a whole circle


class Facets:
    """A manifold3d solid with the names of cadquery's ``Solid``; lengths in mm, angles in deg."""

    def __init__(self, body: Any) -> None:
        self.body = body

    def rotate(self, start: Vector, end: Vector, angle: float) -> Facets:
        """Turned about an axis through the origin along y or z, which is all that the builders ask for."""
        if start != (0, 0, 0) or end[0] != 0 or (end[1] != 0) == (end[2] != 0):
            raise ValueError(f"no axis along y or z through the origin: {start} to {end}")
        signed = math.copysign(1.0, end[1] or end[2]) * angle
        return Facets(self.body.rotate((0.0, signed, 0.0) if end[1] else (0.0, 0.0, signed)))

    def translate(self, way: Vector) -> Facets:
        """Shifted."""
        return Facets(self.body.translate(tuple(float(step) for step in way)))

    def mirror(self, plane: str) -> Facets:
        """Mirrored in a plane through the origin: XY or YZ."""
        return Facets(self.body.mirror({"XY": (0.0, 0.0, 1.0), "YZ": (1.0, 0.0, 0.0)}[plane]))

    def fuse(self, *others: Facets) -> Facets:
        """United with others."""
        return Facets(_batch([self, *others], "Add"))

    def cut(self, *tools: Facets) -> Facets:
        """Without what is in the tools."""
        return Facets(_batch([self, *tools], "Subtract"))

    def Solids(self) -> list[Facets]:  # cadquery's name
        """The solid itself."""
        return [self]

    def moments(self) -> Moments:
        """Volume, centre and second moment."""
        mesh = self.body.to_mesh64()
        return moments_of(np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts, dtype=np.int64))


def _batch(bodies: Sequence[Facets], operation: str) -> Any:
    import manifold3d

    kind = getattr(manifold3d.OpType, operation)
    return manifold3d.Manifold.batch_boolean([each.body for each in bodies], kind)


def _chords(radius: float, sweep: float) -> int:
    """Number of chords of an arc of ``sweep`` rad."""
    step = 2 * math.acos(1.0 - min(SAGITTA / radius, 0.5))
    return max(2, math.ceil(sweep / min(step, 2 * math.pi / LEAST_CHORDS)))


@lru_cache(maxsize=256)
def circle_points(radius: float) -> list[tuple[float, float]]:
    """Corners of a regular polygon of the circle's area."""
    count = _chords(radius, math.tau)
    step = math.tau / count
    wide = radius * math.sqrt(step / math.sin(step))
    return [(wide * math.cos(step * k), wide * math.sin(step * k)) for k in range(count)]


def arc_points(x: float, y: float, radius: float, start: float, end: float) -> list[tuple[float, float]]:
    """Points of an arc from ``start`` to ``end`` rad: its ends, and between them points outside it, as far as makes
    the area of the chords' triangles that of the sector.
    """
    count = _chords(radius, end - start)
    step = (end - start) / count
    # (count - 2) wide^2 + 2 wide = count step / sin(step), in units of the radius
    area, inner = count * step / math.sin(step), count - 2
    wide = area / 2 if inner == 0 else (math.sqrt(1.0 + inner * area) - 1.0) / inner
    reach = [radius, *(radius * wide,) * (count - 1), radius]
    turns = [start + step * k for k in range(count + 1)]
    return [(x + r * math.cos(turn), y + r * math.sin(turn)) for r, turn in zip(reach, turns, strict=True)]


def extrude_polygon(points: Sequence[tuple[float, float]], bottom: float, top: float) -> Facets:
    """A flat polygon, counter-clockwise, between two heights."""
    import manifold3d

    flat = manifold3d.CrossSection([np.array(points, dtype=np.float64)])
    return Facets(flat.extrude(top - bottom).translate((0.0, 0.0, bottom)))


def cylinder(radius: float, height: float, base: Vector, direction: Vector, angle: float) -> Facets:
    """A cylinder, or the sector of one from the x axis on; see ``kernel.cylinder``."""
    sector = angle < 360.0
    points = [(0.0, 0.0), *arc_points(0.0, 0.0, radius, 0.0, math.radians(angle))] if sector else circle_points(radius)
    return Facets(extrude_polygon(points, 0.0, height).body.transform(_frame(base, direction)))


def prism(corners: Sequence[Vector], way: Vector) -> Facets:
    """A flat polygon extruded along a vector."""
    points, along = np.array(corners, dtype=np.float64), np.array(way, dtype=np.float64)
    after = np.roll(points, -1, axis=0)
    normal = np.cross(points - points[0], after - points[0]).sum(axis=0)  # counter-clockwise about it, twice the area
    if normal @ along < 0.0:
        points, normal = points[::-1], -normal
    aside = points[1] - points[0]
    aside = aside / np.linalg.norm(aside)
    across = np.cross(normal / np.linalg.norm(normal), aside)
    flat = [(float(x), float(y)) for x, y in (points - points[0]) @ np.column_stack([aside, across])]
    matrix = np.column_stack([aside, across, along, points[0]])
    return Facets(extrude_polygon(flat, 0.0, 1.0).body.transform(matrix))


def solid_of_mesh(vertices: Any, faces: Any) -> Facets:
    """A closed mesh, its faces outward, as a solid.

    Raises
    ------
    ValueError
        if it is not closed.
    """
    import manifold3d

    mesh = manifold3d.Mesh64(
        vert_properties=np.ascontiguousarray(vertices, dtype=np.float64),
        tri_verts=np.ascontiguousarray(faces, dtype=np.uint64),
    )
    body = manifold3d.Manifold(mesh)
    if body.is_empty():
        raise ValueError(f"not a closed mesh: {body.status()}")
    return Facets(body)


def _frame(base: Vector, direction: Vector) -> Any:
    """The matrix (3, 4) that brings z to ``direction`` and the origin to ``base``."""
    along = np.array(direction, dtype=np.float64) / np.linalg.norm(direction)
    if along[2] == 1.0:
        axes = np.eye(3)
    else:
        aside = np.cross((0.0, 0.0, 1.0), along)
        aside = aside / np.linalg.norm(aside)
        axes = np.column_stack([aside, np.cross(along, aside), along])
    return np.column_stack([axes, np.array(base, dtype=np.float64)])


def moments_of(vertices: Any, faces: Any) -> Moments:
    """Moments of a closed mesh: the sum over the tetrahedra from its centre to its faces.

    Of a tetrahedron with corners 0, a, b, c the integral of x_i x_j is its volume times (s_i s_j + the sum over the
    corners of x_i x_j) / 20, where s = a + b + c (Tonon, "Explicit exact formulas for the 3-D tetrahedron inertia
    tensor", J. Math. Stat. 1 (2005) 8-11).
    """
    middle = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
    a, b, c = ((vertices - middle)[faces[:, k]] for k in range(3))
    volumes = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    total, sums = volumes.sum(), a + b + c
    centre = volumes @ sums / 4.0 / total
    products = sum(np.einsum("i,ij,ik->jk", volumes, each, each) for each in (sums, a, b, c)) / 20.0
    products -= total * np.outer(centre, centre)
    xx, yy, zz = (float(products[k, k]) for k in range(3))
    xy, xz, yz = (-float(products[place]) for place in ((0, 1), (0, 2), (1, 2)))
    x, y, z = (float(place) for place in middle + centre)
    return Moments(float(total), (x, y, z), (yy + zz, xx + zz, xx + yy, xy, xz, yz))
