"""The plane in which a robot's chain of joints turns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import degrees, radians

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.robots.robot_tree import Robot, RobotJoint

MOST_OFF_PLANE = radians(5.0)  # more moves the limb sideways by over 9 % of its motion, which is lost
NEAREST = radians(45.0)  # from up, beyond which another axis of the same plane is nearer to up
ROUNDING = radians(0.01)  # of axes in robot files
ALIKE = 1e-3  # of a direction's components, which of the world's axes it is nearer to
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}  # of the world


@dataclass(frozen=True, eq=False)
class LegPlane:
    """Unit vectors (3,): to the right, up, and the one that counter-clockwise rotation is about."""

    right: Array
    up: Array

    @property
    def normal(self) -> Array:
        return np.cross(self.right, self.up)

    @property
    def name(self) -> str:
        """As ``--plane`` has it, by the nearest axes."""
        return "".join(
            max(AXES, key=lambda key: abs(float(way @ np.array(AXES[key])))) for way in (self.right, self.up)
        )

    def flat(self, points: Array) -> Array:
        """(..., 2) coordinates right and up of points (..., 3)."""
        return np.asarray(points @ np.stack([self.right, self.up], axis=1))

    def lifted(self, point: Array) -> Array:
        """(3,) in the plane through the world's origin, from coordinates (2,) right and up."""
        return np.asarray(point @ np.stack([self.right, self.up]))


def plane_of_leg(robot: Robot, joints: Sequence[RobotJoint], plane: str | None) -> tuple[LegPlane, list[str]]:
    """The plane as given, else that of the axes, and sentences on small deviations.

    Raises
    ------
    UserError
        If an axis is more than 5 degrees off the plane's normal, gravity more than 5 degrees out of the given plane, or
        the second axis of that is not up.
    """
    if robot.gravity.any():
        vertical = _unit(-robot.gravity)
    else:  # any plane will do
        vertical = np.array(AXES["z" if abs(joints[0].axis[2]) < np.cos(NEAREST) else "y"])
    own = _of_the_axes(joints, vertical)
    if plane is not None:
        seen, found = _given(plane, -vertical if robot.gravity.any() else robot.gravity)
        other = ", or another --plane" if own is None else ", or leave --plane out"
        return seen, [*found, *_off_plane(joints, seen, other)]
    seen = _of_the_world(joints, vertical)
    off = max(_off(joint, seen) for joint in joints)
    parallel = all(abs(float(joint.axis @ joints[0].axis)) >= np.cos(ROUNDING) for joint in joints)
    if own is None or off <= (ROUNDING if parallel else MOST_OFF_PLANE):
        return seen, _off_plane(joints, seen, "")
    found = []
    if float(own.right @ seen.right) < np.cos(ROUNDING):
        way = ", ".join(f"{value:.4g}" for value in np.round(own.right, 9) + 0.0)
        found.append(
            f"no plane of the world's axes is normal to the joints' axes; seen in their own, to the right is ({way})"
        )
    leaning = float(np.arccos(np.clip(float(own.up @ vertical), -1.0, 1.0)))
    if leaning > ROUNDING:
        felt = f"{float(np.linalg.norm(robot.gravity)) * np.cos(leaning):.4g} m/s^2"
        found.append(f"the joints' plane leans {degrees(leaning):.3g} deg; the leg has gravity's part in it, {felt}")
    return own, [*found, *_off_plane(joints, own, "")]


def _given(plane: str, gravity: Array) -> tuple[LegPlane, list[str]]:
    """The plane of two of the world's axes, up in it being against gravity, and sentences where these differ.

    ``gravity`` (3,): its direction, or 0 where there is none.
    """
    words = plane.replace(",", "").strip().casefold()
    if len(words) != 2 or words[0] == words[1] or not set(words) <= set(AXES):
        raise UserError(Problem(f'"{plane}" is no plane; write two axes of the world, such as xz', key="--plane"))
    named = LegPlane(np.array(AXES[words[0]]), np.array(AXES[words[1]]))
    if not gravity.any():
        return named, []
    out = float(np.arcsin(np.clip(abs(gravity @ named.normal), 0.0, 1.0)))
    lean = float(np.arccos(np.clip(-float(gravity @ named.up), -1.0, 1.0)))
    if out > MOST_OFF_PLANE or lean > NEAREST:
        text = f"{words[1]} is {degrees(lean):.3g} deg from up: gravity would leave the plane; the second axis is up"
        if lean <= NEAREST:
            text = f"gravity is {degrees(out):.3g} deg out of the plane; at most {degrees(MOST_OFF_PLANE):.0f} deg are "
            text += "allowed"
        raise UserError(Problem(text, key="--plane"))
    up = _unit(named.normal * (gravity @ named.normal) - gravity)
    seen = LegPlane(np.cross(up, named.normal), up)
    within = float(np.arccos(np.clip(float(up @ named.up), -1.0, 1.0)))
    messages = []
    if within > ROUNDING:
        text = f"gravity is {degrees(within):.3g} deg off -{words[1]} in the plane {words}: the leg's angles and its "
        messages.append(f"{text}gravity are those of gravity's own direction, which is straight down")
    if out > ROUNDING:
        text = f"gravity is {degrees(out):.2g} deg out of the plane {words}; the leg has its part in the plane"
        messages.append(text)
    return seen, messages


def _unit(way: Array) -> Array:
    return np.asarray(way / np.linalg.norm(way))


def _of_the_world(joints: Sequence[RobotJoint], vertical: Array) -> LegPlane:
    """That of the level directions of two world axes nearest to the first joint's plane of motion."""
    axis, upright = np.abs(joints[0].axis), int(np.argmax(np.abs(vertical)))
    level = [np.array(AXES[name]) for index, name in enumerate("xyz") if index != upright]
    right = max(level, key=lambda each: -float(axis @ each))
    return LegPlane(_unit(right - (right @ vertical) * vertical), vertical)


def _of_the_axes(joints: Sequence[RobotJoint], vertical: Array) -> LegPlane | None:
    """The plane normal to the axes' mean, where all are within 5 degrees of its normal and it is not level; else None.

    Up is what it has of the vertical. To the right is x of the world or nearly, of a plane that is nearer to y that.
    """
    first = joints[0].axis
    normal = _unit(sum((joint.axis if joint.axis @ first > 0.0 else -joint.axis for joint in joints), np.zeros(3)))
    upward = vertical - (vertical @ normal) * normal
    if float(np.linalg.norm(upward)) < np.sin(ROUNDING):
        return None
    up = _unit(upward)
    right = np.cross(normal, up)
    x, y = float(right[0]), float(right[1])
    ahead = x if abs(x) > abs(y) - ALIKE else y
    own = LegPlane(right if ahead > 0.0 else -right, up)
    return own if all(_off(joint, own) <= MOST_OFF_PLANE for joint in joints) else None


def _off(joint: RobotJoint, seen: LegPlane) -> float:
    """The angle between a joint's axis and the plane's normal, rad."""
    return float(np.arccos(np.clip(abs(joint.axis @ seen.normal), 0.0, 1.0)))


def _off_plane(joints: Sequence[RobotJoint], seen: LegPlane, other: str) -> list[str]:
    """Refuse axes that leave the plane; report small deviations. ``other`` : what to do beside other joints."""
    problems, messages = [], []
    for joint in joints:
        off = _off(joint, seen)
        if off > MOST_OFF_PLANE:
            text = f"the axis of {joint.name} is {degrees(off):.1f} deg off the normal of the plane {seen.name}; at "
            text += f"most {degrees(MOST_OFF_PLANE):.0f} deg are allowed: choose other joints{other}"
            problems.append(Problem(text))
        elif off > ROUNDING:
            messages.append(
                f"the axis of {joint.name} is {degrees(off):.2g} deg off the plane's normal; taken as normal"
            )
    if problems:
        raise UserError(problems)
    return messages
