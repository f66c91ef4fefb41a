"""A robot as a tree of rigid bodies, independent of the file format."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import degrees, radians
from typing import Literal

from synth.arrays import Array
from synth.errors import UserError
from synth.files.robots.robot_shapes import RobotShape
from synth.files.validate import near

# rad, two turns either way: beyond what a limb's joint turns, below most limits in degrees in a file of radians. A
# choice: limits within 12 deg pass, and a joint of many turns is told in vain.
MANY_TURNS = radians(720.0)
# The Earth's gravity (m/s^2) in the smaller units in which files are written; it is within 0.6 % everywhere.
GRAVITY_IN = {"centimetres": 981.0, "millimetres": 9810.0}
NEAR_GRAVITY = 0.01
Kind = Literal["hinge", "slide", "fixed", "free"]


@dataclass(frozen=True, eq=False)
class RobotBody:
    """A body in the robot's reference pose, in world coordinates, SI.

    ``parent`` : index of the body that it is attached to, -1 for the world. ``rotation`` (3, 3) body to world.
    ``position``, ``com`` (3,) m. ``inertia`` (3, 3) kg m^2 about the centre of mass. ``weightless`` : the share of its
    weight that the file compensates.
    """

    name: str
    parent: int
    rotation: Array
    position: Array
    mass: float
    com: Array
    inertia: Array
    shapes: tuple[RobotShape, ...]
    weightless: float = 0.0


@dataclass(frozen=True)
class RobotContact:
    """Two bodies that may touch: ``other`` by its name too; -1 if that is fixed in the world."""

    body: int
    other: int
    other_name: str


@dataclass(frozen=True)
class MimickedJoint:
    """The joint that another one follows, by name, and the law: what the other's reading is, in words."""

    name: str
    law: str


@dataclass(frozen=True, eq=False)
class RobotJoint:
    """A joint between ``body`` and its parent, SI and radians.

    ``axis``, ``anchor`` (3,) in the world. ``reading`` : the joint's value in the reference pose. ``stiffness`` with
    ``rest``, the reading at which its spring is unloaded. ``hardening`` : the spring's second term, (N m, power of the
    deflection in rad beyond ``onset``, rad), alike on both sides. ``losses`` : shares of the stiffness that the spring
    lacks above and below, and the distance in rad of that change from ``rest``. ``clamps`` : straight pieces of the
    damper's curve beside ``damping``, each (speed rad/s, slope N m s/rad). ``drag`` : a second damping term, (N m,
    power of the speed in rad/s). ``friction`` N m, dry. ``gap`` rad, the width of a backlash between link and spring.
    ``range`` of the reading. ``left_out`` : its features that a leg cannot represent; ``refused`` : why it cannot be a
    leg's joint, empty if it can. ``mimics`` : the joint that it follows, where ``reading`` follows from that law.
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
    hardening: tuple[float, float] | None = None
    clamps: tuple[tuple[float, float], ...] = ()
    drag: tuple[float, float] | None = None
    gap: float = 0.0
    left_out: tuple[str, ...] = ()
    onset: float = 0.0
    losses: tuple[float, float, float] | None = None
    refused: str = ""
    mimics: MimickedJoint | None = None


@dataclass(frozen=True, eq=False)
class Robot:
    """Bodies, each after its parent, and joints.

    ``gravity`` (3,) m/s^2. ``left_out`` : unsupported features. ``frames`` : places (3,) m in the world by name, of
    bodies without mass and of marks (MuJoCo's sites). ``contacts`` : between bodies.
    """

    name: str
    bodies: tuple[RobotBody, ...]
    joints: tuple[RobotJoint, ...]
    gravity: Array
    left_out: tuple[str, ...] = ()
    frames: Mapping[str, Array] = field(default_factory=dict)
    contacts: tuple[RobotContact, ...] = ()

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


def doubtful_limits(limits: tuple[float, float] | None, file: str) -> tuple[str, ...]:
    """A sentence where a hinge's limits, written in rad in ``file``, look like degrees."""
    if limits is None or max(map(abs, limits)) <= MANY_TURNS:
        return ()
    lower, upper = limits
    text = f"{file} has its limits in rad: {lower:.6g} and {upper:.6g} are {degrees(lower):.5g} and "
    text += f"{degrees(upper):.5g} deg. If degrees were meant, write {radians(lower):.4g} and {radians(upper):.4g} "
    return (f"{text}there; a joint of many turns is right so",)


def doubtful_gravity(gravity: float) -> tuple[str, ...]:
    """A sentence where gravity, m/s^2 if the file is in SI, looks like that of a file in smaller units."""
    for name, expected in GRAVITY_IN.items():
        if abs(gravity / expected - 1.0) < NEAR_GRAVITY:
            text = f"gravity is {gravity:.5g} and was read as m/s^2; with {name} in place of metres it is the Earth's. "
            return (f"{text}If the file is in {name}, write it anew in m, kg and s: all its numbers were read so",)
    return ()
