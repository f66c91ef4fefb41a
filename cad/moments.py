"""Mass properties of a solid apart from its density."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

Vector = tuple[float, float, float]


def about_z(vector: Vector, angle: float) -> Vector:
    """The vector turned about z by ``angle`` deg."""
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    x, y, z = vector
    return c * x - s * y, s * x + c * y, z


@dataclass(frozen=True)
class Moments:
    """Volume mm^3, its centre mm, inertia of unit density mm^5.

    ``tensor``: xx, yy, zz, xy, xz, yz of the inertia matrix about the centre; products with the minus sign that they
    have in the matrix.
    """

    volume: float
    centre: Vector
    tensor: tuple[float, float, float, float, float, float]

    @property
    def about_z(self) -> float:
        """About the hinge's direction through the centre, mm^5."""
        return self.tensor[2]

    def with_volume(self, volume: float) -> Moments:
        """The same shape of material with a known volume: facets' moments corrected by a closed form."""
        xx, yy, zz, xy, xz, yz = (value * volume / self.volume for value in self.tensor)
        return replace(self, volume=volume, tensor=(xx, yy, zz, xy, xz, yz))


def exact_moments(solid: Any) -> Moments:
    """The moments of a cadquery solid, by its kernel."""
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    found = GProp_GProps()
    BRepGProp.VolumeProperties_s(solid.wrapped, found)
    centre, matrix = found.CentreOfMass(), found.MatrixOfInertia()
    places = ((1, 1), (2, 2), (3, 3), (1, 2), (1, 3), (2, 3))
    xx, yy, zz, xy, xz, yz = (float(matrix.Value(*place)) for place in places)
    return Moments(float(found.Mass()), (centre.X(), centre.Y(), centre.Z()), (xx, yy, zz, xy, xz, yz))
