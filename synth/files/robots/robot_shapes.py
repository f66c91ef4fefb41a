"""How far the shapes of a robot's body reach."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import product

import numpy as np

from synth.arrays import Array

CORNERS = np.array(list(product((-1.0, 1.0), repeat=3)))  # of a cube with half edges of 1


@dataclass(frozen=True, eq=False)
class RobotShape:
    """The hull of equal ellipsoids about its ``corners``, in the world, SI.

    ``line`` (k, 3): where its axis ends, or its centre. ``corners`` (m, 3). ``half_axes`` (3, 3): those of the
    ellipsoid as rows, 0 for sharp corners. ``unread`` : why only its centre is known, empty if it is known. ``title`` :
    what it is in the file, ``mesh shank.stl``.
    """

    line: Array
    corners: Array
    half_axes: Array = field(default_factory=lambda: np.zeros((3, 3)))
    unread: str = ""
    title: str = "shape"

    def reach(self, from_: Array, way: Array) -> float:
        """Largest distance of its surface from a point (3,) along a unit vector (3,), m.

        The support function of an ellipsoid with half axes a_i is the root of the sum of (a_i . way)^2 (Ericson,
        Real-Time Collision Detection, 2005, section 9.5).
        """
        return float(np.max((self.corners - from_) @ way) + np.linalg.norm(self.half_axes @ way))

    def moved(self, place: Array, turn: Array) -> RobotShape:
        """The shape in the world, from that in a frame at ``place`` (3,) with the rotation ``turn`` (3, 3)."""
        line, corners = (place + points @ turn.T for points in (self.line, self.corners))
        return RobotShape(line, corners, self.half_axes @ turn.T, self.unread, self.title)


def capsule(half_length: float) -> RobotShape:
    """Along z. Its caps do not count: a limb's capsule runs from joint to joint and ends there."""
    line = np.array([[0.0, 0.0, -half_length], [0.0, 0.0, half_length]])
    return RobotShape(line, line)


def cylinder(half_length: float, radius: float) -> RobotShape:
    """Along z."""
    line = capsule(half_length).line
    return RobotShape(line, line, np.diag([radius, radius, 0.0]))


def box(half_edges: Array) -> RobotShape:
    """With edges (3,) m along the axes."""
    return RobotShape(np.zeros((1, 3)), CORNERS * half_edges)


def ellipsoid(half_axes: Array) -> RobotShape:
    """With half axes (3,) m along the axes; a sphere where they are equal."""
    centre = np.zeros((1, 3))
    return RobotShape(centre, centre, np.diag(half_axes))


def of_points(points: Array) -> RobotShape:
    """The hull of points (m, 3) m."""
    return RobotShape((points.min(axis=0) + points.max(axis=0))[None, :] / 2.0, points)


def unread(why: str) -> RobotShape:
    """A shape of which only the centre is known."""
    return RobotShape(np.zeros((1, 3)), np.zeros((1, 3)), unread=why)
