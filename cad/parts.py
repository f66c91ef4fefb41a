"""A part as built: its solid, its mesh, and what is known of it in closed form."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Faces = NDArray[np.int64]
Group = Literal["upper", "lower", "spring"]

# Chord error of the meshes. The angular one dominates on small radii and is therefore always given.
LINEAR_TOLERANCE = 0.05  # mm
ANGULAR_TOLERANCE = 0.15  # rad

# RGB; told apart without colour vision.
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
    "encoder_seat": (0.45, 0.70, 0.70),
    "encoder": (0.15, 0.35, 0.25),
}

# g/cm^3 of what is not printed; the bought damper's and encoder's insides are not known.
DENSITIES = {"spring": 7.85, "shaft": 7.85, "screw": 7.85, "link": 2.70}
MATERIALS = {"spring": "spring steel", "shaft": "steel", "screw": "steel", "link": "aluminium tube"}


@dataclass(frozen=True)
class Mesh:
    """Triangles: ``vertices`` (n, 3) mm, ``faces`` (m, 3), outward."""

    vertices: Array
    faces: Faces

    def turned(self, angle: float, shift: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Mesh:
        """Turned by ``angle`` deg about z, then shifted by mm."""
        c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        return Mesh(self.vertices @ rotation.T + np.array(shift), self.faces)

    def scaled(self, signs: tuple[int, int, int]) -> Mesh:
        """Mirrored in the axes whose sign is -1; faces stay outward."""
        flipped = signs[0] * signs[1] * signs[2] < 0
        return Mesh(self.vertices * np.array(signs, dtype=np.float64), self.faces[:, ::-1] if flipped else self.faces)

    @property
    def volume(self) -> float:
        """Signed volume, mm^3, by the divergence theorem."""
        a, b, c = (self.vertices[self.faces[:, i]] for i in range(3))
        return float(np.sum(np.cross(a, b) * c) / 6.0)


@dataclass(frozen=True)
class Moments:
    """What mass and inertia follow from by the density: volume mm^3, its centre mm, about z through it mm^5."""

    volume: float
    centre: tuple[float, float, float]
    about_z: float


@dataclass(frozen=True)
class BuiltPart:
    """One part in its joint's frame, the lower half's parts with the joint straight (q = 0)."""

    name: str
    family: str  # key of COLOURS
    group: Group  # what it moves with
    solid: Any  # cadquery Shape
    mesh: Mesh
    printed: bool
    exact_volume: float | None  # mm^3 in closed form, where there is one
    made: str  # how one gets it, for people

    @property
    def colour(self) -> tuple[float, float, float]:
        """Red, green, blue in 0-1."""
        return COLOURS[self.family]

    @property
    def material(self) -> str:
        """What it is made of, where that is known."""
        return "print" if self.printed else MATERIALS.get(self.family, "")

    @property
    def size(self) -> tuple[float, float, float]:
        """Extent along x, y and z, mm, to a hundredth."""
        x, y, z = (round(float(extent), 2) for extent in np.ptp(self.mesh.vertices, axis=0))
        return x, y, z

    def moments(self) -> Moments:
        """Volume, centre and second moment of the solid, by the kernel; the lower half's parts with q = 0."""
        from OCP.BRepGProp import BRepGProp
        from OCP.GProp import GProp_GProps

        found = GProp_GProps()
        BRepGProp.VolumeProperties_s(self.solid.wrapped, found)
        centre, matrix = found.CentreOfMass(), found.MatrixOfInertia()
        return Moments(float(found.Mass()), (centre.X(), centre.Y(), centre.Z()), float(matrix.Value(3, 3)))

    def mass(self, print_density: float) -> float | None:
        """Mass in g, printed parts solid at ``print_density`` g/cm^3; None where the material is not known."""
        density = print_density if self.printed else DENSITIES.get(self.family)
        return None if density is None else density * float(self.solid.Volume()) * 1e-3


def mesh_of(solid: Any) -> Mesh:
    """Mesh of a solid whose faces share their edges' points, so that merging them closes it."""
    import trimesh

    points, triangles = solid.tessellate(LINEAR_TOLERANCE, ANGULAR_TOLERANCE)
    vertices = np.array([(p.x, p.y, p.z) for p in points], dtype=np.float64)
    merged = trimesh.Trimesh(vertices, np.array(triangles, dtype=np.int64), process=True)
    return Mesh(np.asarray(merged.vertices, dtype=np.float64), np.asarray(merged.faces, dtype=np.int64))


def file_name(name: str) -> str:
    """A part's or joint's name as a file name: blanks become underscores (other characters are refused earlier)."""
    return name.replace(" ", "_")
