"""URDF, read with the standard library: links, joints, dynamics, limits, Gazebo's springs. Shapes give a limb's end."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import degrees
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np
from scipy.spatial.transform import Rotation

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.robots.gazebo_extensions import (
    REFERENCE,
    STIFFNESS,
    gazebo_words,
    omitted_dynamics,
    omitted_of_joint,
    omitted_of_links,
    spring_words,
)
from synth.files.robots.mesh_points import mesh_points
from synth.files.robots.robot_shapes import RobotShape, box, capsule, cylinder, ellipsoid, of_points, unread
from synth.files.robots.robot_tree import Kind, MimickedJoint, Robot, RobotBody, RobotJoint, doubtful_limits
from synth.files.robots.xml_root import root_element

LARGEST = 20_000_000  # bytes; meshes are files of their own
GRAVITY = 9.81  # m/s^2; URDF leaves it to the simulator
KINDS: dict[str, Kind] = {
    "revolute": "hinge",
    "continuous": "hinge",
    "prismatic": "slide",
    "fixed": "fixed",
    "floating": "free",
    "planar": "free",
}


def read_urdf(path: Path) -> Robot:
    """The robot with every joint at zero, or where that puts it if it mimics another.

    Raises
    ------
    UserError
        With every mistake found in the file.
    """
    root = _root(path)
    gazebo = gazebo_words(root)
    reader = _UrdfReader(path, gazebo)
    links = reader.named(root.findall("link"))  # not those of simulators' extensions, deeper in the file
    joints = [item for item in root.findall("joint") if item.find("parent") is not None]
    reader.named(joints)
    order = reader.ordered(links, joints)
    readings = reader.readings(joints)
    reader.finish()
    bodies: list[RobotBody] = []
    found: list[RobotJoint] = []
    places: dict[str, int] = {}
    for name, joint in order:
        if joint is None:
            parent, turn, place = -1, np.eye(3), np.zeros(3)
        else:
            parent = places[_named(joint, "parent")]
            own_place, own_turn = reader.origin(joint)
            above = bodies[parent]
            turn, place = above.rotation @ own_turn, above.position + above.rotation @ own_place
            found.append(_followed(reader.joint(joint, len(bodies), turn, place), readings, joint.find("mimic")))
            turn, place = _moved(found[-1], turn, place)
        places[name] = len(bodies)
        bodies.append(reader.body(links[name], name, parent, turn, place))
    reader.finish()
    transmissions = len(root.findall("transmission"))
    left_out = (f"{transmissions} transmission{'s' if transmissions > 1 else ''} left out",) if transmissions else ()
    left_out = (*left_out, *omitted_of_links(gazebo, links))
    springs = spring_words(gazebo, [joint.name for joint in found])
    messages = (f"{springs}, and gravity is taken as 9.81 m/s^2 downward",)
    roots = [body.name for body in bodies if body.parent < 0]
    if len(roots) > 1:
        text = f"{', '.join(roots)} hang by no joint: what is not below one of the chain's joints is not in the leg"
        left_out = (*left_out, text)
    gravity = np.array([0.0, 0.0, -GRAVITY])
    frames = {body.name: body.position for body in bodies if not body.mass}
    return Robot(root.get("name") or path.stem, tuple(bodies), tuple(found), gravity, messages + left_out, frames)


def _root(path: Path) -> Element:
    root = root_element(path, LARGEST, "a URDF holds no meshes", write_out="xacro")
    space, closed, _ = str(root.tag).rpartition("}")
    for item in root.iter():  # Drake's files are in a namespace of their own
        item.tag = str(item.tag).removeprefix(space + closed)
    if root.tag != "robot":
        raise UserError(Problem(f"is no URDF: its root is <{root.tag}>, not <robot>", str(path)))
    if any("xacro" in str(item.tag) or "${" in " ".join(item.attrib.values()) for item in root.iter()):
        raise UserError(Problem("is a xacro file; expand it first: xacro robot.xacro > robot.urdf", str(path)))
    return root


def _named(joint: Element, tag: str) -> str:
    item = joint.find(tag)
    return "" if item is None else item.get("link", "")


def _followed(joint: RobotJoint, readings: Mapping[str, _Followed], mimic: Element | None) -> RobotJoint:
    """The joint at its reading; one that mimics another with the law."""
    if mimic is None or joint.name not in readings:
        return joint
    own = readings[joint.name]
    shown = f"{degrees(own.offset):.4g} deg" if joint.kind == "hinge" else f"{own.offset:.4g} m"
    mimicked = MimickedJoint(own.joint, f"{own.multiplier:g} times the reading of {own.joint}, plus {shown}")
    left_out = (
        *joint.left_out,
        f"it mimics {mimicked.name} ({mimicked.law}), which is left out",
    )
    return replace(joint, reading=own.reading, mimics=mimicked, left_out=left_out)


def _moved(joint: RobotJoint, turn: Array, place: Array) -> tuple[Array, Array]:
    """Rotation (3, 3) and position (3,) of the body below a joint at its reading, from those at 0."""
    if joint.kind == "slide":
        return turn, place + joint.reading * joint.axis
    if joint.kind != "hinge" or not joint.reading:
        return turn, place
    return Rotation.from_rotvec(joint.reading * joint.axis).as_matrix() @ turn, place


@dataclass(frozen=True)
class _Followed:
    """A joint's reading, rad or m, of one that mimics ``joint`` by a multiplier and an offset, rad or m."""

    reading: float = 0.0
    joint: str = ""
    multiplier: float = 0.0
    offset: float = 0.0


class _UrdfReader:
    """Reads elements and collects all mistakes."""

    def __init__(self, path: Path, gazebo: Mapping[str, Element]) -> None:
        self.path, self.gazebo, self.problems = path, gazebo, list[Problem]()
        self.meshes: dict[str, Array | str] = {}  # points, or why there are none

    def refuse(self, text: str, key: str) -> None:
        self.problems.append(Problem(text, str(self.path), key=key))

    def finish(self) -> None:
        if self.problems:
            raise UserError(self.problems)

    def named(self, elements: list[Element]) -> dict[str, Element]:
        """Links or joints by name, of which each has its own."""
        found: dict[str, Element] = {}
        for item in elements:
            name = item.get("name", "")
            if name in found:
                self.refuse("stands twice in the file; every link and every joint has a name of its own",
                            f"{item.tag} {name}")  # fmt: skip
            found[name] = item
        return found

    def numbers(self, element: Element | None, name: str, default: str, key: str) -> Array:
        """An attribute with as many numbers as its default."""
        text = default if element is None else element.get(name, default)
        try:
            values = np.array([float(word) for word in text.split()])
        except ValueError:
            values = np.array([np.nan])
        if len(values) != len(default.split()) or not np.isfinite(values).all():
            self.refuse(f'{name}="{text}" is not {len(default.split())} finite numbers', key)
            return np.array([float(word) for word in default.split()])
        return values

    def number(self, element: Element | None, name: str, key: str) -> float:
        return float(self.numbers(element, name, "0", key)[0])

    def origin(self, owner: Element | None) -> tuple[Array, Array]:
        """Position (3,) m and rotation (3, 3) of an ``origin``; a quaternion is URDF 1.1's."""
        element = None if owner is None else owner.find("origin")
        key = "" if owner is None else f"{owner.tag} {owner.get('name', '')}"
        place = self.numbers(element, "xyz", "0 0 0", key)
        if element is not None and "quat_xyzw" in element.attrib:
            if "rpy" in element.attrib:
                self.refuse("has an origin with both rpy and quat_xyzw; give one", key)
            quaternion = self.numbers(element, "quat_xyzw", "0 0 0 1", key)
            if not quaternion.any():
                self.refuse('quat_xyzw="0 0 0 0" is no rotation; none is 0 0 0 1', key)
            return place, Rotation.from_quat(quaternion if quaternion.any() else [0.0, 0.0, 0.0, 1.0]).as_matrix()
        return place, Rotation.from_euler("xyz", self.numbers(element, "rpy", "0 0 0", key)).as_matrix()

    def ordered(self, links: Mapping[str, Element], joints: list[Element]) -> list[tuple[str, Element | None]]:
        """Links, each after its parent, with the joint to the parent."""
        by: dict[str, Element] = {}
        for joint in joints:
            child = _named(joint, "child")
            for tag in ("parent", "child"):
                if _named(joint, tag) not in links:
                    self.refuse(f'names a {tag} "{_named(joint, tag)}" that is no link', f"joint {joint.get('name')}")
            if child in by:
                self.refuse(
                    f'"{child}" hangs by two joints; a URDF is a tree without loops', f"joint {joint.get('name')}"
                )
            by[child] = joint
        self.finish()
        done: dict[str, Element | None] = {name: None for name in links if name not in by}
        waiting = [name for name in links if name in by]
        while waiting:
            ready = [name for name in waiting if _named(by[name], "parent") in done]
            if not ready:
                self.refuse(f"hangs from itself by way of {waiting[0]}", f"link {waiting[0]}")
                break
            for name in ready:
                done[name] = by[name]
            waiting = [name for name in waiting if name not in done]
        return list(done.items())

    def readings(self, joints: list[Element]) -> dict[str, _Followed]:
        """The reading of each joint by name: 0, or where that puts one that mimics another."""
        laws = {joint.get("name", ""): mimic for joint in joints if (mimic := joint.find("mimic")) is not None}
        found = {joint.get("name", ""): _Followed() for joint in joints if joint.find("mimic") is None}
        waiting = list(laws)
        for name in waiting:
            if (other := laws[name].get("joint", "")) not in laws and other not in found:
                self.refuse(f'mimics "{other}", which is no joint of the file', f"joint {name}")
                return found
        while waiting:
            ready = [name for name in waiting if laws[name].get("joint") in found]
            if not ready:
                self.refuse("mimics itself, by way of other joints or at once", f"joint {waiting[0]}")
                break
            for name in ready:
                other, key = laws[name].get("joint", ""), f"joint {name}"
                multiplier = float(self.numbers(laws[name], "multiplier", "1", key)[0])
                offset = self.number(laws[name], "offset", key)
                found[name] = _Followed(multiplier * found[other].reading + offset, other, multiplier, offset)
            waiting = [name for name in waiting if name not in found]
        return found

    def body(self, link: Element, name: str, parent: int, turn: Array, place: Array) -> RobotBody:
        """A link with its inertia and the ends of its shapes, in the world."""
        inertial, key = link.find("inertial"), f"link {name}"
        own_place, own_turn = self.origin(inertial)
        matter = None if inertial is None else inertial.find("inertia")
        xx, xy, xz, yy, yz, zz = (self.number(matter, item, key) for item in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"))
        inertia = turn @ own_turn @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ (turn @ own_turn).T
        mass = self.number(None if inertial is None else inertial.find("mass"), "value", key)
        if mass < 0.0:
            self.refuse(f"has the mass {mass:g} kg", key)
        drawn = [item for tag in ("collision", "visual") for item in link.findall(tag)]
        shapes = tuple(self.shape(item, key).moved(place, turn) for item in drawn)
        return RobotBody(name, parent, turn, place, mass, place + turn @ own_place, inertia, shapes)

    def shape(self, owner: Element, key: str) -> RobotShape:
        """A collision's or visual's shape in the link's frame."""
        geometry = owner.find("geometry")
        kind, item = next(((one.tag, one) for one in (geometry if geometry is not None else ())), ("", None))
        if kind in ("cylinder", "capsule"):  # the capsule is Drake's and Bullet's
            half, radius = self.number(item, "length", key) / 2.0, self.number(item, "radius", key)
            found = cylinder(half, radius) if kind == "cylinder" else capsule(half)
        elif kind == "box":
            found = box(self.numbers(item, "size", "0 0 0", key) / 2.0)
        elif kind == "sphere":
            found = ellipsoid(np.full(3, self.number(item, "radius", key)))
        elif kind == "mesh" and item is not None:
            found = self.mesh(item.get("filename", ""), self.numbers(item, "scale", "1 1 1", key))
        else:
            found = unread(f"a <{kind}>" if kind else "a shape without a geometry")
        title = f"mesh {item.get('filename', '')}" if kind == "mesh" and item is not None else kind
        return replace(found.moved(*self.origin(owner)), title=title)

    def mesh(self, name: str, scale: Array) -> RobotShape:
        """A mesh's shape; of one that cannot be read only the centre is known."""
        if name not in self.meshes:
            try:
                self.meshes[name] = mesh_points(self.path.parent, name)
            except UserError as error:
                self.meshes[name] = f"the mesh {name}: {error.problems[0].text}"
        points = self.meshes[name]
        return unread(points) if isinstance(points, str) else of_points(points * scale)

    def joint(self, joint: Element, body: int, turn: Array, place: Array) -> RobotJoint:
        """A joint with its axis and anchor in the world."""
        name = joint.get("name", "")
        key, kind = f"joint {name}", KINDS.get(joint.get("type", ""))
        if kind is None:
            self.refuse(f'type="{joint.get("type", "")}" is not one of {", ".join(KINDS)}', key)
        # A joint that turns and slides about none has no use for an axis: CAD exporters write 0 0 0 there.
        has_axis = kind in ("hinge", "slide")
        axis = self.numbers(joint.find("axis") if has_axis else None, "xyz", "1 0 0", key)
        length = float(np.linalg.norm(axis))
        if length == 0.0:
            self.refuse(f'is {joint.get("type", "")} and has axis xyz="0 0 0"; write the direction that it moves along '
                        'or about, such as "0 1 0"', key)  # fmt: skip
        dynamics, limit = joint.find("dynamics"), joint.find("limit")
        span = None
        if joint.get("type") in ("revolute", "prismatic") and limit is not None:
            span = (self.number(limit, "lower", key), self.number(limit, "upper", key))
            if span[0] > span[1]:
                self.refuse(f"has the limits {span[0]:g} and {span[1]:g}; the lower one comes first", key)
        damping, friction = (self.number(dynamics, item, key) for item in ("damping", "friction"))
        if damping < 0.0 or friction < 0.0:
            self.refuse(f"has the damping {damping:g} and the friction {friction:g}; neither may be negative", key)
        words = self.gazebo.get(name)
        stiffness, rest = self.number(words, STIFFNESS, key), self.number(words, REFERENCE, key)
        if stiffness < 0.0:
            self.refuse(f"has the {STIFFNESS} {stiffness:g}; it may not be negative", key)
        doubts = doubtful_limits(span, self.path.name) if kind == "hinge" else ()
        return RobotJoint(
            name,
            body,
            kind or "fixed",
            turn @ axis / (length or 1.0),
            place,
            stiffness=stiffness,
            rest=rest,
            damping=damping,
            friction=friction,
            range=span,
            left_out=(*doubts, *omitted_dynamics(dynamics), *omitted_of_joint(words)),
        )
