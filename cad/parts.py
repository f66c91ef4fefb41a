"""A built part: its solid, its mesh, and its closed-form properties."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from synth.cad.kernel import is_faceted, moments
from synth.cad.moments import Moments
from synth.cad.standard_part import Made

Array = NDArray[np.float64]
Faces = NDArray[np.int64]
Group = Literal["upper", "lower", "spring"]

# Chord error of the meshes. The angular one dominates on small radii and is therefore always given.
LINEAR_TOLERANCE = 0.05  # mm: an eighth of a print line
ANGULAR_TOLERANCE = 0.15  # rad: 42 chords to a circle, 0.1 % off its radius at 5 mm
SORTED_TO = 6  # decimals of mm, of the points by which a mesh is sorted

# RGB; distinguishable without colour vision.
COLOURS: dict[str, tuple[float, float, float]] = {
    "upper": (0.30, 0.47, 0.66),
    "lower": (0.95, 0.56, 0.17),
    "damper_bracket": (0.35, 0.63, 0.31),
    "damper": (0.25, 0.25, 0.28),
    "spring": (0.72, 0.73, 0.76),
    "shaft": (0.55, 0.56, 0.60),
    "seat": (0.80, 0.30, 0.30),
    "cap": (0.55, 0.20, 0.20),
    "screw": (0.35, 0.37, 0.42),
    "link": (0.86, 0.86, 0.84),
    "damper_adapter": (0.55, 0.35, 0.65),
    "damper_insert": (0.55, 0.35, 0.65),
    "bearing": (0.80, 0.82, 0.86),
    "collar": (0.42, 0.44, 0.50),
    "washer": (0.75, 0.66, 0.35),
    "pin": (0.30, 0.32, 0.36),
    "nut": (0.40, 0.42, 0.46),
    "encoder_seat": (0.45, 0.70, 0.70),
    "encoder": (0.15, 0.35, 0.25),
}

# g/cm^3 of parts that are not printed; those of bought dampers and encoders are unknown.
STEEL = ("shaft", "screw", "nut", "pin", "collar", "washer")  # families
DENSITIES = {"spring": 7.85, "link": 2.70} | dict.fromkeys(STEEL, 7.85)
MATERIALS = {"spring": "spring steel", "link": "aluminium tube (EN AW-6060 T6 or stronger)"} | dict.fromkeys(
    STEEL, "steel"
)


@dataclass(frozen=True)
class Mesh:
    """Triangles: ``vertices`` (n, 3) mm, ``faces`` (m, 3), outward."""

    vertices: Array
    faces: Faces

    @property
    def size(self) -> tuple[float, float, float]:
        """Extent along x, y and z, mm, to a hundredth."""
        x, y, z = (round(float(extent), 2) for extent in np.ptp(self.vertices, axis=0))
        return x, y, z

    @property
    def own_size(self) -> tuple[float, float, float]:
        """Sides of the smallest box round it with an edge along z, largest first, mm, to a hundredth.

        It is the same wherever the part points in its joint. An edge of the smallest rectangle lies on an edge of the
        outline's hull (Freeman and Shapira, Comm. ACM 18 (1975) 409).
        """
        from scipy.spatial import ConvexHull

        flat = self.vertices[:, :2]
        corners = flat[ConvexHull(flat).vertices]
        edges = np.roll(corners, -1, axis=0) - corners
        along = edges / np.linalg.norm(edges, axis=1, keepdims=True)
        across = np.column_stack([-along[:, 1], along[:, 0]])
        sides = np.stack([np.ptp(corners @ way.T, axis=0) for way in (along, across)])
        length, width = sides[:, np.argmin(np.prod(sides, axis=0))]
        x, y, z = sorted((round(float(side), 2) for side in (length, width, np.ptp(self.vertices[:, 2]))), reverse=True)
        return x, y, z

    def turned(self, angle: float, shift: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Mesh:
        """Rotated by ``angle`` deg about z, then shifted by mm; a mesh that stays where it is, is the same object."""
        if angle == 0.0 and not any(shift):
            return self
        c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        return Mesh(self.vertices @ rotation.T + np.array(shift), self.faces)

    def scaled(self, signs: tuple[int, int, int]) -> Mesh:
        """Mirrored in the axes whose sign is -1; faces stay outward."""
        flipped = signs[0] * signs[1] * signs[2] < 0
        return Mesh(self.vertices * np.array(signs, dtype=np.float64), self.faces[:, ::-1] if flipped else self.faces)

    @cached_property
    def box(self) -> tuple[Array, Array]:
        """Least and largest coordinates (3,), mm."""
        return self.vertices.min(axis=0), self.vertices.max(axis=0)

    @cached_property
    def manifold(self) -> Any:
        """The mesh as a manifold3d solid; empty where it is not closed."""
        import manifold3d

        return manifold3d.Manifold(
            manifold3d.Mesh(
                vert_properties=np.ascontiguousarray(self.vertices, dtype=np.float32),
                tri_verts=np.ascontiguousarray(self.faces, dtype=np.uint32),
            )
        )

    @cached_property
    def triangles(self) -> tuple[Array, Array, Array, NDArray[np.bool_]]:
        """Corners (m, 3, 3) mm, unit normals (m, 3) and areas (m,) mm^2 of triangles with an area, and their mask."""
        corners = self.vertices[self.faces]
        cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        length = np.linalg.norm(cross, axis=1)
        kept = length > 1e-12
        return corners[kept], cross[kept] / length[kept, None], length[kept] / 2, kept

    def __reduce__(self) -> tuple[type[Mesh], tuple[Array, Faces]]:
        """To send it to another process: without what has been computed from it."""
        return Mesh, (self.vertices, self.faces)

    @property
    def volume(self) -> float:
        """Signed volume, mm^3, by the divergence theorem."""
        a, b, c = (self.vertices[self.faces[:, i]] for i in range(3))
        return float(np.sum(np.cross(a, b) * c) / 6.0)


class LateMesh(Mesh):
    """A mesh created on first access; masses do not need it."""

    def __init__(self, make: Callable[[], Mesh]) -> None:
        object.__setattr__(self, "_make", make)

    def __getattr__(self, name: str) -> Any:
        if name not in ("vertices", "faces"):
            raise AttributeError(name)
        made = object.__getattribute__(self, "_make")()
        object.__setattr__(self, "vertices", made.vertices)
        object.__setattr__(self, "faces", made.faces)
        return getattr(made, name)


@dataclass(frozen=True)
class BuiltPart:
    """One part in its joint's frame, the lower half's parts with the joint straight (q = 0)."""

    name: str
    family: str  # key of COLOURS
    group: Group  # what it moves with
    solid: Any  # cadquery Shape
    mesh: Mesh
    printed: bool
    exact_volume: float | None  # mm^3 in closed form, if there is one
    made: Made  # how to buy or make it
    bought_mass: float | None = None  # g, if its table states it

    @property
    def colour(self) -> tuple[float, float, float]:
        """Red, green, blue in 0-1."""
        return COLOURS[self.family]

    @property
    def material(self) -> str:
        """Its material, if known."""
        return "print" if self.printed else MATERIALS.get(self.family, "")

    @property
    def size(self) -> tuple[float, float, float]:
        """The mesh's."""
        return self.mesh.size

    def moments(self) -> Moments:
        """Volume, centre and second moment of the solid, by the kernel; the lower half's parts with q = 0."""
        return self._moments

    @cached_property
    def _moments(self) -> Moments:
        found = moments(self.solid)
        if self.exact_volume is None or not is_faceted(self.solid):
            return found
        # Facets are as exact as the part's closed form, if it has one.
        return found.with_volume(self.exact_volume)

    def mass(self, print_density: float) -> float | None:
        """Mass in g, printed parts solid at ``print_density`` g/cm^3; None if the material is unknown."""
        if self.bought_mass is not None:
            return self.bought_mass
        density = print_density if self.printed else DENSITIES.get(self.family)
        return None if density is None else density * self._moments.volume * 1e-3


@dataclass(frozen=True)
class DrawnPart:
    """A part in the canonical frame, before it is mirrored to its joint."""

    suffix: str  # of its name, behind the joint's
    family: str
    group: Group
    solid: Any
    exact: float | None
    printed: bool
    made: Made
    mass: float | None = None  # g, if its table states it


def mesh_of(solid: Any, signs: tuple[int, int, int] = (1, 1, 1)) -> Mesh:
    """Mesh of a solid, mirrored as ``Mesh.scaled`` does; created on first access."""
    return LateMesh(lambda: _mesh_of(solid).scaled(signs))


def _mesh_of(solid: Any) -> Mesh:
    """Mesh of a solid; of one that ``kernel.placed`` has shifted, that of the solid in its first place, shifted."""
    place = solid.wrapped.Location()
    if place.IsIdentity():
        return _sorted_mesh(*_merged_mesh(solid))
    vertices, faces = _merged_mesh_once(type(solid)(solid.wrapped.Located(type(place)())))
    shift = place.Transformation().TranslationPart()
    return _sorted_mesh(vertices + np.array([shift.X(), shift.Y(), shift.Z()]), faces)


def _merged_mesh(solid: Any) -> tuple[Array, Faces]:
    """Mesh of a solid whose faces share the points of their edges, so that merging them closes it."""
    import trimesh

    merged = trimesh.Trimesh(*_triangles(solid), process=True)
    return np.asarray(merged.vertices, dtype=np.float64), np.asarray(merged.faces, dtype=np.int64)


_merged_mesh_once = lru_cache(maxsize=256)(_merged_mesh)


def _sorted_mesh(vertices: Array, faces: Faces) -> Mesh:
    """The same mesh with points and triangles sorted, because the kernel's order may change between calls.

    So do the last bits of its points, which must not decide between those of an edge that is straight along an axis.
    """
    order = np.lexsort(np.round(vertices, SORTED_TO).T[::-1])
    place = np.empty(len(order), dtype=np.int64)
    place[order] = np.arange(len(order))
    moved = place[faces]
    rows = np.arange(len(moved))[:, None]
    moved = moved[rows, (np.argmin(moved, axis=1)[:, None] + np.arange(3)) % 3]
    return Mesh(vertices[order], moved[np.lexsort(moved.T[::-1])])


def _triangles(solid: Any) -> tuple[Array, Faces]:
    """Vertices (n, 3) mm and faces (m, 3) of a solid, as cadquery's ``tessellate`` gives them, without an object each.

    Faces come one after the other, each with vertices of its own, in its own frame until it is moved.
    """
    from OCP.BRep import BRep_Tool
    from OCP.TopAbs import TopAbs_Orientation
    from OCP.TopLoc import TopLoc_Location

    solid.mesh(LINEAR_TOLERANCE, ANGULAR_TOLERANCE)
    vertices: list[tuple[float, float, float]] = []
    faces: list[tuple[int, int, int]] = []
    for face in solid.Faces():
        place = TopLoc_Location()
        surface = BRep_Tool.Triangulation_s(face.wrapped, place)
        if surface is None:
            continue
        first, node, triangle = len(vertices) - 1, surface.Node, surface.Triangle
        points = [node(index) for index in range(1, surface.NbNodes() + 1)]
        if not place.IsIdentity():
            points = [point.Transformed(place.Transformation()) for point in points]
        vertices += [point.Coord() for point in points]
        corners = [triangle(index).Get() for index in range(1, surface.NbTriangles() + 1)]
        if face.wrapped.Orientation() == TopAbs_Orientation.TopAbs_REVERSED:
            corners = [(a, c, b) for a, b, c in corners]
        faces += [(first + a, first + b, first + c) for a, b, c in corners]
    return np.array(vertices, dtype=np.float64), np.array(faces, dtype=np.int64)


def file_name(name: str) -> str:
    """A part's or joint's name as a file name: spaces become underscores.

    Raises
    ------
    ValueError : it is a path or a hidden name. The dimensions refuse such names already; this is a second check.
    """
    if not name or name != Path(name).name or "\\" in name or name.startswith("."):
        raise ValueError(f"a file cannot be called {name!r}")
    return name.replace(" ", "_")
