"""Mass properties of rigid bodies: several bodies combined (parallel axes), and the planar link of a body.

Frame of a joint as it is drawn, with the joint straight (q = 0): x to the right, y up along the links, z along the
hinge towards the viewer. A link extends from its joint along -y.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.swing.leg_model import Link

Vector = tuple[float, float, float]
Tensor = tuple[float, float, float, float, float, float]
PLACES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))  # xx, yy, zz, xy, xz, yz


@dataclass(frozen=True)
class RigidBody:
    """``mass`` kg, ``centre`` m, ``inertia`` kg m^2 about the centre: xx, yy, zz, xy, xz, yz of the matrix."""

    mass: float
    centre: Vector
    inertia: Tensor

    @property
    def matrix(self) -> Array:
        """(3, 3) kg m^2 about the centre."""
        return _matrix(self.inertia)

    @property
    def about_hinge(self) -> float:
        """Inertia about the z axis of the frame, kg m^2."""
        x, y, _ = self.centre
        return self.inertia[2] + self.mass * (x * x + y * y)

    def shifted(self, by: Vector) -> RigidBody:
        """The body translated by ``by`` m."""
        x, y, z = (a + b for a, b in zip(self.centre, by, strict=True))
        return RigidBody(self.mass, (x, y, z), self.inertia)

    def share(self, part: float) -> RigidBody:
        """The body with this share of its mass and inertia."""
        xx, yy, zz, xy, xz, yz = (part * value for value in self.inertia)
        return RigidBody(part * self.mass, self.centre, (xx, yy, zz, xy, xz, yz))

    def link(self, length: float) -> Link:
        """The planar link that moves as this body does."""
        return Link(length, self.mass, -self.centre[1], self.inertia[2], com_across=self.centre[0])


def combined_body(bodies: Iterable[RigidBody]) -> RigidBody:
    """Several bodies combined into one.

    Raises
    ------
    ValueError : no body has a mass.
    """
    several = list(bodies)
    mass = sum(body.mass for body in several)
    if mass <= 0.0:
        raise ValueError("no body has a mass")
    x, y, z = (sum(body.mass * body.centre[axis] for body in several) / mass for axis in range(3))
    total = np.zeros((3, 3))
    for body in several:
        away = np.array(body.centre) - (x, y, z)
        total += body.matrix + body.mass * (away @ away * np.eye(3) - np.outer(away, away))
    return RigidBody(mass, (x, y, z), _tensor(total))


def link_body(link: Link) -> RigidBody:
    """A planar link as a body; its inertia about the other axes, which a link does not state, is that of a thin rod."""
    across, about, along = rod_inertias(link)
    return RigidBody(link.mass, (link.com_across, -link.com, 0.0), (across, along, about, 0.0, 0.0, 0.0))


def rod_inertias(link: Link) -> Vector:
    """Inertias kg m^2 across the hinge, about it, and along the link; those that a link does not state are a rod's."""
    across = max(link.mass * link.length**2 / 12, link.inertia)
    return across, link.inertia, max(1e-3 * link.inertia, abs(across - link.inertia) + 1e-3 * link.inertia)


def offset_torque(body: RigidBody, gravity: float) -> float:
    """Largest gravity torque, N m, due to the lateral offset of the body's centre from the line of its link."""
    return abs(body.mass * gravity * body.centre[0])


def _matrix(tensor: Tensor) -> Array:
    made = np.zeros((3, 3))
    for (i, j), value in zip(PLACES, tensor, strict=True):
        made[i, j] = made[j, i] = value
    return made


def _tensor(matrix: Array) -> Tensor:
    xx, yy, zz, xy, xz, yz = (float(matrix[place]) for place in PLACES)
    return xx, yy, zz, xy, xz, yz
