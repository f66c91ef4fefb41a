"""A link in robot files beyond the planar leg: its full inertia, and the drawn parts.

A joint is drawn with x to the right, y up and z along the hinge towards the viewer; robot files have z up. So a drawn
vector (x, y, z) is (x, -z, y) here: a quarter turn about x.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import asin, atan2, cos, pi, sin, sqrt

import numpy as np

from synth.arrays import Array
from synth.swing.leg_model import Joint
from synth.swing.rigid_body import RigidBody, Vector, link_body

UPRIGHT = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])  # drawn -> robot frame
SCALE = "0.001 0.001 0.001"  # STL files are in mm
LOCKED = 1e-9  # of the cosine of the pitch, below which roll and yaw turn about one axis


@dataclass(frozen=True)
class Visual:
    """A part's STL: ``path`` beside the robot file, turned by ``turn`` rad about the hinge, moved by ``shift`` m."""

    name: str
    path: str
    turn: float
    shift: Vector
    colour: Vector  # red, green, blue, 0 to 1

    def tilted(self, tilt: float) -> Visual:
        """The part turned about the frame's hinge by ``tilt`` rad, counter-clockwise positive."""
        (x, y, z), c, s = self.shift, cos(tilt), sin(tilt)
        return replace(self, turn=self.turn + tilt, shift=(c * x - s * y, s * x + c * y, z))

    @property
    def place(self) -> Vector:
        """Where its frame's origin stands in the robot's frame, m."""
        return upright(self.shift)

    @property
    def quaternion(self) -> tuple[float, float, float, float]:
        """W, x, y, z: a quarter turn about x after the turn about the hinge."""
        half, quarter = self.turn / 2, sqrt(0.5)
        return quarter * cos(half), quarter * cos(half), -quarter * sin(half), quarter * sin(half)

    @property
    def rpy(self) -> Vector:
        """Roll, pitch, yaw (rad) about fixed axes, as URDF and SDF want them."""
        c, s = cos(self.turn), sin(self.turn)
        return rpy_of(UPRIGHT @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]))


@dataclass(frozen=True)
class RobotLink:
    """A link's whole body in its joint's drawn frame, and what is drawn of it; None: the planar link, as a rod."""

    body: RigidBody | None = None
    visuals: tuple[Visual, ...] = ()


@dataclass(frozen=True)
class Inertial:
    """Centre (m), mass (kg) and inertia about the centre (kg m^2; xx, yy, zz, xy, xz, yz) in the robot's frame."""

    centre: Vector
    mass: float
    inertia: tuple[float, float, float, float, float, float]


def inertial_of(joint: Joint, drawn: RobotLink) -> Inertial:
    """The link's mass properties, the drawn body's where there is one."""
    body = link_body(joint.link) if drawn.body is None else drawn.body
    turned = UPRIGHT @ body.matrix @ UPRIGHT.T
    places = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    xx, yy, zz, xy, xz, yz = (float(turned[place]) + 0.0 for place in places)
    return Inertial(upright(body.centre), body.mass, (xx, yy, zz, xy, xz, yz))


def upright(drawn: Vector) -> Vector:
    """A drawn vector in the robot's frame."""
    x, y, z = drawn
    return x, 0.0 - z, y


def rpy_of(rotation: Array) -> Vector:
    """Roll, pitch and yaw (rad) of a rotation (3, 3), R = Rz(yaw) Ry(pitch) Rx(roll)."""
    pitch = asin(float(np.clip(-rotation[2, 0], -1.0, 1.0)))
    if cos(pitch) < LOCKED:
        return atan2(-rotation[1, 2], rotation[1, 1]), pi / 2 if pitch > 0 else -pi / 2, 0.0
    return atan2(rotation[2, 1], rotation[2, 2]), pitch, atan2(rotation[1, 0], rotation[0, 0])


def numbers(values: tuple[float, ...]) -> str:
    """Numbers as they stand in an attribute."""
    return " ".join(f"{value + 0.0:.10g}" for value in values)


def tip_names(joint: str) -> tuple[str, str]:
    """Names of the frame at the end of the last link, below that joint: as an MJCF's site, and as a URDF's link."""
    return f"{joint} tip", f"{joint}_tip"
