"""A leg as URDF and as SDF, as far as these represent springs and dampers, with a warning for the rest.

URDF's joints have a linear damping and a dry friction and no spring, which stands in Gazebo's own elements of the file;
SDF's also have a linear spring with a rest angle.
Neither represents a torque-speed curve or a varying stiffness: a curve becomes the nearest straight line.
Frames as in the MJCF: links hang along -z, joints turn about -y, angles are rotations q = sign * (measured - zero).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi
from pathlib import Path
from xml.etree.ElementTree import Comment, Element

import numpy as np

from synth.arrays import Array
from synth.files.drive_terms import drive_terms, lightened
from synth.files.joint_curves import linear_damping, without_held
from synth.files.joint_springs import spring_torque
from synth.files.output import write_text
from synth.files.robot_bodies import SCALE, Inertial, RobotLink, Visual, inertial_of, numbers, tip_names
from synth.files.robots.gazebo_extensions import REFERENCE, STIFFNESS
from synth.files.xml_text import nested, xml_text
from synth.remarks import noted
from synth.swing.leg_model import Joint, Leg, Link

SDF_VERSION = "1.9"
UNLIMITED = 1e3  # N m and rad/s; URDF wants an effort and a velocity where it has limits
_LINK_END = "_link"


@dataclass(frozen=True)
class RobotFile:
    """The text of a model file, and a sentence for each feature of the leg that it cannot represent."""

    text: str
    warnings: tuple[str, ...]


def urdf_file(leg: Leg, fastest: Array, base: RobotLink | None = None, links: Sequence[RobotLink] = ()) -> RobotFile:
    """The leg as URDF; ``fastest`` (n,) rad/s is the speed up to which each damper is represented.

    ``base`` and ``links``: whole bodies and drawn parts; without them a link is a rod.
    URDF knows no gravity either: the simulator has its own.
    """
    # The default of leg files and of MuJoCo.
    messages = [f"gravity of {leg.gravity:g} m/s^2 must be set in the simulator"] if leg.gravity != 9.81 else []
    root = Element("robot", name=leg.name)
    first, shown = nested(root, "link", name="base"), list(links) or [RobotLink()] * len(leg.joints)
    for item in (base or RobotLink()).visuals:
        _urdf_mesh(first, item.tilted(leg.tilt))  # the root link of a URDF has no pose; the first joint is tilted alike
    parent, height = "base", 0.0
    for index, joint in enumerate(leg.joints):
        rate, friction, found = _dynamics(joint, float(fastest[index]))
        messages += [f"{joint.name}: {text}" for text in found]
        if joint.spring is not None and np.any(spring_torque(joint, np.array([-pi, pi]))):
            own = f"{joint.name}: URDF has no springs: {joint.spring.rate:.4g} N*m/rad stands in Gazebo's {STIFFNESS}"
            messages.append(f"{own} and {REFERENCE}, which other simulators leave out")
            spring = nested(root, "gazebo", reference=joint.name)
            nested(spring, STIFFNESS, f"{joint.spring.rate:.10g}")
            nested(spring, REFERENCE, f"{joint.rest:.10g}")
        child = joint.name + _LINK_END
        _urdf_link(root, child, joint, shown[index])
        kind = "continuous" if joint.range is None else "revolute"
        made = nested(root, "joint", name=joint.name, type=kind)
        nested(made, "parent", link=parent)
        nested(made, "child", link=child)
        turned = {"rpy": f"0 {-leg.tilt:.10g} 0"} if index == 0 else {}
        nested(made, "origin", xyz=f"0 0 {-height:.10g}", **turned)
        nested(made, "axis", xyz="0 -1 0")
        nested(made, "dynamics", damping=f"{rate:.10g}", friction=f"{friction:.10g}")
        if joint.ends is not None:
            low, high = joint.ends
            most = f"{UNLIMITED:g}"
            nested(made, "limit", lower=f"{low:.10g}", upper=f"{high:.10g}", effort=most, velocity=most)
        parent, height = child, joint.link.length
    end = tip_names(leg.joints[-1].name)[1]
    nested(root, "link", name=end)
    made = nested(root, "joint", name=f"{end}_mount", type="fixed")
    nested(made, "parent", link=parent)
    nested(made, "child", link=end)
    nested(made, "origin", xyz=f"0 0 {-height:.10g}")
    return _finished(root, [*messages, *_base(leg)])


def _urdf_link(root: Element, name: str, joint: Joint, drawn: RobotLink) -> None:
    found, made = inertial_of(joint, drawn), nested(root, "link", name=name)
    inertial = nested(made, "inertial")
    nested(inertial, "origin", xyz=numbers(found.centre))
    nested(inertial, "mass", value=f"{found.mass:.10g}")
    nested(inertial, "inertia", **_moments(found))
    for item in drawn.visuals:
        _urdf_mesh(made, item)
    if not drawn.visuals:
        visual = nested(made, "visual")
        nested(visual, "origin", xyz=f"0 0 {-joint.link.length / 2:.10g}")
        nested(nested(visual, "geometry"), "cylinder", radius="0.008", length=f"{joint.link.length:.10g}")


def _moments(found: Inertial) -> dict[str, str]:
    names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    return {name: f"{value:.10g}" for name, value in zip(names, found.inertia, strict=True)}


def _urdf_mesh(link: Element, item: Visual) -> None:
    visual = nested(link, "visual", name=item.name)
    nested(visual, "origin", xyz=numbers(item.place), rpy=numbers(item.rpy))
    nested(nested(visual, "geometry"), "mesh", filename=item.path, scale=SCALE)
    nested(nested(visual, "material", name=f"{item.name}_colour"), "color", rgba=f"{numbers(item.colour)} 1")


def sdf_file(leg: Leg, fastest: Array, base: RobotLink | None = None, links: Sequence[RobotLink] = ()) -> RobotFile:
    """The leg as an SDF model fixed to the world; see ``urdf_file``."""
    messages: list[str] = []
    shown = list(links) or [RobotLink()] * len(leg.joints)
    root = Element("sdf", version=SDF_VERSION)
    world = nested(root, "world", name="default")
    nested(world, "gravity", f"0 0 {-leg.gravity:.10g}")
    model = nested(world, "model", name=leg.name)
    first = nested(model, "link", name="base")
    nested(first, "pose", f"0 0 0 0 {-leg.tilt:.10g} 0")
    for item in (base or RobotLink()).visuals:
        _sdf_mesh(first, item)
    mount = nested(model, "joint", name="mount", type="fixed")
    nested(mount, "parent", "world")
    nested(mount, "child", "base")
    parent, height = "base", 0.0
    for index, joint in enumerate(leg.joints):
        rate, friction, found = _dynamics(joint, float(fastest[index]))
        messages += [f"{joint.name}: {text}" for text in found]
        child = joint.name + _LINK_END
        _sdf_link(model, child, joint, shown[index], (parent, height))
        _sdf_joint(model, joint, parent, child, rate, friction)
        parent, height = child, joint.link.length
    return _finished(root, [*messages, *_base(leg)])


def _sdf_link(model: Element, name: str, joint: Joint, drawn: RobotLink, hangs: tuple[str, float]) -> None:
    """``hangs``: the link that it hangs from, and how far (m) below that one's joint."""
    found, made = inertial_of(joint, drawn), nested(model, "link", name=name)
    nested(made, "pose", f"0 0 {-hangs[1]:.10g} 0 0 0", relative_to=hangs[0])
    inertial = nested(made, "inertial")
    nested(inertial, "pose", f"{numbers(found.centre)} 0 0 0")
    nested(inertial, "mass", f"{found.mass:.10g}")
    inertia = nested(inertial, "inertia")
    for key, value in _moments(found).items():
        nested(inertia, key, value)
    for item in drawn.visuals:
        _sdf_mesh(made, item)
    if not drawn.visuals:
        _sdf_rod(made, joint.link)


def _sdf_mesh(link: Element, item: Visual) -> None:
    visual = nested(link, "visual", name=item.name)
    nested(visual, "pose", f"{numbers(item.place)} {numbers(item.rpy)}")
    mesh = nested(nested(visual, "geometry"), "mesh")
    nested(mesh, "uri", item.path)
    nested(mesh, "scale", SCALE)
    nested(nested(visual, "material"), "diffuse", f"{numbers(item.colour)} 1")


def _sdf_rod(made: Element, link: Link) -> None:
    visual = nested(made, "visual", name="rod")
    nested(visual, "pose", f"0 0 {-link.length / 2:.10g} 0 0 0")
    cylinder = nested(nested(visual, "geometry"), "cylinder")
    nested(cylinder, "radius", "0.008")
    nested(cylinder, "length", f"{link.length:.10g}")


def _sdf_joint(model: Element, joint: Joint, parent: str, child: str, rate: float, friction: float) -> None:
    made = nested(model, "joint", name=joint.name, type="revolute")
    nested(made, "parent", parent)
    nested(made, "child", child)
    axis = nested(made, "axis")
    nested(axis, "xyz", "0 -1 0")
    dynamics = nested(axis, "dynamics")
    nested(dynamics, "damping", f"{rate:.10g}")
    nested(dynamics, "friction", f"{friction:.10g}")
    if joint.spring is not None:
        nested(dynamics, "spring_reference", f"{joint.rest:.10g}")
        nested(dynamics, "spring_stiffness", f"{joint.spring.rate:.10g}")
    if joint.ends is not None:
        limit = nested(axis, "limit")
        nested(limit, "lower", f"{joint.ends[0]:.10g}")
        nested(limit, "upper", f"{joint.ends[1]:.10g}")


def _dynamics(joint: Joint, fastest: float) -> tuple[float, float, list[str]]:
    """Linear damping (N m s/rad), dry friction (N m), and what these two leave out."""
    rate, words = linear_damping(joint, fastest)
    messages = [words] if words else []
    if lightened(joint):
        messages.append(f"not held, {lightened(joint)}")
    elif joint.with_rotor:
        messages.append(f"not held: {joint.with_rotor:.4g} kg*m^2 that turn with the joint itself (armature, rotor)")
    dry = joint.effects.get("coulomb_friction", {})
    messages += ["not held: creep of coulomb_friction"] if dry.get("creep") else []
    lost = without_held(joint, ("coulomb_friction", "shear_thinning_damping", "quadratic_damping"))
    if lost:
        messages.append(f"not held: {', '.join(lost)}")
    return rate, dry.get("torque", 0.0), messages


def _base(leg: Leg) -> list[str]:
    messages = [f"not held: {', '.join(sorted(leg.effects))} of the base"] if leg.effects else []
    drives = zip(leg.joints, drive_terms(leg), strict=True)
    return [*messages, *(f"{joint.name}: not held: the drive ({drive.in_words})" for joint, drive in drives if drive)]


def _finished(root: Element, messages: list[str]) -> RobotFile:
    notes = ["written by synth; joint angles are rotations q = sign * (measured - zero)", *messages]
    for index, text in enumerate(notes):
        root.insert(index, Comment(f" {text} "))
    return RobotFile(xml_text(root, declared=True), tuple(messages))


def write_robot_files(
    leg: Leg, fastest: Array, folder: Path, base: RobotLink | None = None, links: Sequence[RobotLink] = ()
) -> list[str]:
    """Write ``leg.urdf`` and ``leg.sdf`` into ``folder``; return a warning for each file with omissions."""
    messages = []
    for name, made in (
        ("leg.urdf", urdf_file(leg, fastest, base, links)),
        ("leg.sdf", sdf_file(leg, fastest, base, links)),
    ):
        write_text(folder / name, made.text)
        if made.warnings:
            messages.append(noted(f"{name} does not represent all of the leg: {'; '.join(made.warnings)}"))
    return messages
