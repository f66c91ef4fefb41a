"""A planar chain of a robot as a leg: named joints, with all others locked and their bodies lumped."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import atan2, degrees

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.names import name_fault
from synth.files.robot_bodies import tip_names
from synth.files.robots.inertia_doubts import inertia_messages, require_moments
from synth.files.robots.last_link import last_link
from synth.files.robots.leg_plane import LegPlane, plane_of_leg
from synth.files.robots.mjcf_dampers import curve_of
from synth.files.robots.outer_forces import contact_messages, felt_share
from synth.files.robots.robot_tree import Robot, RobotJoint
from synth.swing.leg_model import AT_STOP, Damper, Joint, Leg, Link, Spring

NOTHING = 1e-12  # kg or m, that counts as none


@dataclass(frozen=True)
class PickedLeg:
    """The leg, and a sentence for each feature of the robot that it omits."""

    leg: Leg
    messages: tuple[str, ...]


def pick_leg(robot: Robot, chain: Sequence[str], plane: str | None = None, tip: float | None = None) -> PickedLeg:
    """The chain of joints as a leg whose measured angles are the robot's joint readings.

    Parameters
    ----------
    chain
        1 to 6 hinges, proximal to distal, each below the one before it.
    plane
        two axes of the world, to the right and up, such as ``xz``; None: the one that the joints' axes are normal to,
        or where these are parallel to none of the world's the plane normal to them, unless it is level.
    tip
        m, from the last joint to the end of the last link; None: to the frame ``JOINT tip`` or ``JOINT_tip``, if
        there is one, else to the end of its farthest shape or fixed frame, if beyond its centre of mass.

    Raises
    ------
    UserError
        If the joints are not such a chain, an axis deviates from the plane's normal by more than 5 degrees, a link's
        body has a negative moment of inertia, or the file compensates the weight of its bodies by different shares.
    """
    joints = _chain(robot, chain)
    seen, found = plane_of_leg(robot, joints, plane)
    messages = [*robot.left_out, *found]
    groups = _groups(robot, joints, messages)
    require_moments(robot, groups)
    anchors = seen.flat(np.stack([joint.anchor for joint in joints]))
    base = robot.bodies[joints[0].body].parent
    tilt = _turn(robot.bodies[base].rotation, seen) if base >= 0 else 0.0
    pull = 0.0 - float(robot.gravity @ seen.up)  # not -0.0
    before, made = tilt, list[Joint]()
    for index, joint in enumerate(joints):
        lumped = _Lumped.of(robot, groups[index], seen)
        if lumped.mass <= NOTHING:
            raise UserError(f"nothing below {joint.name} has a mass: it would have no inertia")
        if index + 1 < len(joints):
            along = anchors[index + 1] - anchors[index]
            length = float(np.hypot(*along))
            if length <= NOTHING:
                text = f"{joint.name} and {joints[index + 1].name} turn about the same place: one link would have no "
                raise UserError(f"{text}length; leave one of them out of the chain")
        else:
            marked = next((robot.frames[name] for name in tip_names(joint.name) if name in robot.frames), None)
            if marked is not None and tip is None:
                along = seen.flat(marked) - anchors[index]
                length = float(np.hypot(*along))
            else:
                size = max(sum(joint.link.length for joint in made), lumped.gyration(anchors[index]))
                of_last = (robot, groups[index], anchors[index], lumped.com, seen)
                along, length = last_link(*of_last, size, tip, messages)
        direction = atan2(along[0], -along[1])  # counter-clockwise from straight down
        made.append(_joint(joint, seen, anchors[index], lumped, length, (direction, before), messages))
        before = direction
    gravity = pull * felt_share(robot, groups, messages)
    messages += inertia_messages(robot, groups) + contact_messages(robot, groups)
    name = robot.name if robot.name else "robot"
    return PickedLeg(Leg(name, tuple(made), gravity, tilt), tuple(dict.fromkeys(messages)))


def _chain(robot: Robot, chain: Sequence[str]) -> list[RobotJoint]:
    """The joints by name, checked to hang below one another."""
    if not 1 <= len(chain) <= 6:
        raise UserError(f"--chain names {len(chain)} joints; a leg has 1 to 6")
    problems, joints = [], []
    for name in chain:
        try:
            joint = robot.joint(name)
        except UserError as error:
            problems += error.problems
            continue
        joints.append(joint)
        if joint.kind != "hinge":
            problems.append(Problem(f'"{name}" is a {joint.kind} joint; a leg has hinges only'))
        if joint.refused:
            problems.append(Problem(f"{name}: {joint.refused}"))
        if (fault := name_fault(name)) is not None:
            problems.append(Problem(f'"{name}" cannot be a joint\'s name here: it {fault}'))
    if not problems:
        for upper, lower in pairwise(joints):
            if upper.body not in robot.above(lower.body)[1:]:
                text = f"{lower.name} does not hang below {upper.name}: name the joints from the body outward"
                problems.append(Problem(text))
    if problems:
        raise UserError(problems)
    return joints


def _groups(robot: Robot, joints: Sequence[RobotJoint], messages: list[str]) -> list[list[int]]:
    """The bodies of each link: all below its joint and above the next; every other joint is locked."""
    owner = {joint.body: index for index, joint in enumerate(joints)}
    groups: list[list[int]] = [[] for _ in joints]
    for body in range(len(robot.bodies)):
        link = next((owner[above] for above in robot.above(body) if above in owner), None)
        if link is not None:
            groups[link].append(body)
    inside = {body for group in groups for body in group}
    base = set(robot.above(joints[0].body)[1:])
    chosen = {joint.name for joint in joints}
    locked = [
        joint for joint in robot.joints if joint.kind != "fixed" and joint.name not in chosen and joint.body in inside
    ]
    for joint in locked:
        where = f"at {degrees(joint.reading):.4g} deg" if joint.kind == "hinge" else "where it stands"
        if joint.kind == "hinge" and joint.range is not None and not _within(joint.reading, joint.range):
            where += f", out of its range {degrees(joint.range[0]):.4g} to {degrees(joint.range[1]):.4g} deg"
        text = f"{joint.name or 'a joint without a name'} is locked {where}, and its bodies are lumped"
        messages.append(text + _following(robot, joint, chosen))
    above = [joint.name or "the free joint" for joint in robot.joints if joint.body in base and joint.kind != "fixed"]
    if above:
        messages.append(f"the body is held: {', '.join(above)} above the chain cannot move")
    return groups


def _within(reading: float, ends: tuple[float, float]) -> bool:
    """Whether a reading is in the range, rad, or that is none."""
    return ends[0] >= ends[1] or ends[0] - AT_STOP <= reading <= ends[1] + AT_STOP


def _following(robot: Robot, joint: RobotJoint, chosen: set[str]) -> str:
    """The end of a locked joint's sentence: what it mimics, and whether it moves with the chain in the robot."""
    if joint.mimics is None:
        return ""
    by = {each.name: each for each in robot.joints}
    leader, seen = joint.mimics.name, {joint.name}
    while leader in by and leader not in chosen | seen and (above := by[leader].mimics) is not None:
        seen.add(leader)
        leader = above.name
    text = f"; it mimics {joint.mimics.name} ({joint.mimics.law})"
    return f"{text} and moves with {leader} in the robot, which the leg lacks" if leader in chosen else text


@dataclass(frozen=True, eq=False)
class _Lumped:
    """Several bodies as one: kg, (2,) m in the plane, kg m^2 about the normal through the centre of mass."""

    mass: float
    com: Array
    inertia: float

    def gyration(self, anchor: Array) -> float:
        """Radius of gyration about a point (2,), m: no body is smaller than that."""
        return float(np.sqrt(self.inertia / self.mass + ((self.com - anchor) ** 2).sum()))

    @classmethod
    def of(cls, robot: Robot, bodies: Sequence[int], seen: LegPlane) -> _Lumped:
        parts = [robot.bodies[index] for index in bodies]
        mass = sum(body.mass for body in parts)
        if mass <= NOTHING:
            return cls(0.0, np.zeros(2), 0.0)
        places = seen.flat(np.stack([body.com for body in parts]))
        weights = np.array([body.mass for body in parts])
        com = weights @ places / mass
        about = sum(float(seen.normal @ body.inertia @ seen.normal) for body in parts)
        about += float(weights @ ((places - com) ** 2).sum(axis=1))
        return cls(mass, com, max(about, 0.0))  # below 0 by rounding alone: require_moments refuses the rest


def _joint(
    joint: RobotJoint,
    seen: LegPlane,
    anchor: Array,
    lumped: _Lumped,
    length: float,
    turned: tuple[float, float],
    messages: list[str],
) -> Joint:
    """The joint with its link; ``turned`` : absolute rotation of this link and of the one above, rad."""
    direction, above = turned
    along = np.array([np.sin(direction), -np.cos(direction)])
    across = np.array([-along[1], along[0]])
    com, beside = float((lumped.com - anchor) @ along), float((lumped.com - anchor) @ across)
    link = Link(length, lumped.mass, com, lumped.inertia, com_across=beside)
    sign = 1 if float(joint.axis @ seen.normal) > 0.0 else -1
    rotation = (direction - above + np.pi) % (2.0 * np.pi) - np.pi
    messages += [f"{joint.name}: {text}" for text in joint.left_out]
    span = joint.range if joint.range is not None and joint.range[0] < joint.range[1] else None
    return Joint(
        joint.name,
        link,
        zero=joint.reading - sign * rotation,
        sign=sign,
        range=span,
        spring=Spring(joint.stiffness, joint.rest) if joint.stiffness else None,
        damper=_damper(joint),
        effects=_effects(joint),
        armature=joint.armature,
    )


def _damper(joint: RobotJoint) -> Damper | None:
    curve = curve_of(joint)
    if curve is not None:
        return Damper(curve=curve)
    return Damper(rate=joint.damping) if joint.damping else None


def _effects(joint: RobotJoint) -> dict[str, dict[str, float]]:
    """What springs and dampers of a leg hold as effects."""
    effects = {}
    if joint.friction:
        effects["coulomb_friction"] = {"torque": joint.friction}
    if joint.gap:
        effects["backlash"] = {"gap": joint.gap}
    if joint.drag is not None:
        effects["quadratic_damping"] = {"coefficient": joint.drag[0], "exponent": joint.drag[1], "speed": 1.0}
    if joint.hardening is not None and joint.stiffness:
        effects["hardening_spring"] = {"stiffening": joint.hardening[0], "exponent": joint.hardening[1], "reach": 1.0}
        if joint.onset:
            effects["hardening_spring"]["onset"] = joint.onset
    if joint.losses is not None:
        effects["one_sided_spring"] = dict(zip(("loss_above", "loss_below", "shift"), joint.losses, strict=True))
    return effects


def _turn(rotation: Array, seen: LegPlane) -> float:
    """The rotation of a body's frame in the plane, rad; 0 if it is rotated out of the plane."""
    up = rotation @ seen.up
    return float(atan2(-(up @ seen.right), up @ seen.up)) if abs(up @ seen.normal) < 1e-9 else 0.0
