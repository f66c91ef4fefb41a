"""A robot as a tree of rigid bodies, independent of the file format."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from synth.arrays import Array
from synth.errors import UserError
from synth.files.validate import near

Kind = Literal["hinge", "slide", "fixed", "free"]


@dataclass(frozen=True, eq=False)
class RobotBody:
    """A body in the robot's reference pose, in world coordinates, SI.

    ``parent`` : index of the body that it is attached to, -1 for the world. ``rotation`` (3, 3) body to world.
    ``position``, ``com`` (3,) m. ``inertia`` (3, 3) kg m^2 about the centre of mass. ``points``
    (k, 3) m: ends of its shapes.
    """

    name: str
    parent: int
    rotation: Array
    position: Array
    mass: float
    com: Array
    inertia: Array
    points: Array


@dataclass(frozen=True, eq=False)
class RobotJoint:
    """A joint between ``body`` and its parent, SI and radians.

    ``axis``, ``anchor`` (3,) in the world. ``reading`` : the joint's value in the reference pose. ``stiffness`` with
    ``rest``, the reading at which its spring is unloaded. ``friction`` N m, dry. ``range`` of the reading. ``left_out``
    : its features that a leg cannot represent.
    """

    name: str
    body: int
    kind: Kind
    axis: Array
    anchor: Array
    reading: float = 0.0
    stiffness: float = 0.0
    rest: float = 0.0
    damping: float = 0.0
    armature: float = 0.0
    friction: float = 0.0
    range: tuple[float, float] | None = None
    left_out: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Robot:
    """Bodies, each after its parent, and joints. ``gravity`` (3,) m/s^2. ``left_out`` : unsupported features."""

    name: str
    bodies: tuple[RobotBody, ...]
    joints: tuple[RobotJoint, ...]
    gravity: Array
    left_out: tuple[str, ...] = ()

    def joint(self, name: str) -> RobotJoint:
        """The joint of that name.

        Raises
        ------
        UserError
            Where there is none, with the names that there are.
        """
        for joint in self.joints:
            if joint.name == name:
                return joint
        names = [joint.name for joint in self.joints if joint.kind == "hinge" and joint.name]
        raise UserError(f'"{name}" is no joint of {self.name}{near(name, names)}')

    def above(self, body: int) -> list[int]:
        """The body and its ancestors, nearest first."""
        found = []
        while body >= 0:
            found.append(body)
            body = self.bodies[body].parent
        return found
