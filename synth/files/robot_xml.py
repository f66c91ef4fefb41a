"""A leg as URDF and as SDF, with what these can hold of springs and dampers, and a warning for what they cannot.

URDF's joints have a linear damping and a dry friction and no spring; SDF's have a linear spring with its rest as well.
Neither holds a torque-speed curve or a stiffness that changes: a curve becomes the straight line nearest to it.
Frames as in the MJCF: links hang along -z, joints turn about -y, angles are rotations q = sign * (measured - zero).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from pathlib import Path
from xml.etree.ElementTree import Comment, Element

from synth.arrays import Array
from synth.files.joint_curves import linear_damping, without_held
from synth.files.mjcf import inertias
from synth.files.output import write_text
from synth.files.xml_text import nested, xml_text
from synth.swing.leg_model import Joint, Leg, Link

SDF_VERSION = "1.9"
WORTH_SAYING = 0.02  # of the largest torque, that a straight line may be off without a word
UNLIMITED = 1e3  # N m and rad/s; URDF wants an effort and a velocity where it has limits
_LINK_END = "_link"


@dataclass(frozen=True)
class RobotFile:
    """The text of a model file, and a sentence for each thing of the leg that it does not hold."""

    text: str
    warnings: tuple[str, ...]


def urdf_file(leg: Leg, fastest: Array) -> RobotFile:
    """The leg as URDF; ``fastest`` (n,) rad/s is up to where each damper is to be followed.

    URDF knows no gravity either: the simulator has its own.
    """
    said = [f"gravity of {leg.gravity:g} m/s^2 is the simulator's to set"] if leg.gravity != 9.81 else []
    root = Element("robot", name=leg.name)
    nested(root, "link", name="base")
    parent, height = "base", 0.0
    for index, joint in enumerate(leg.joints):
        rate, friction, found = _dynamics(joint, float(fastest[index]))
        said += [f"{joint.name}: {text}" for text in found]
        if joint.spring is not None:
            said.append(f"{joint.name}: URDF has no springs: {joint.spring.rate:.4g} N*m/rad is left out")
        child = joint.name + _LINK_END
        _urdf_link(root, child, joint.link)
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
    return _finished(root, [*said, *_base(leg)])


def _urdf_link(root: Element, name: str, link: Link) -> None:
    across, about, along = inertias(link)
    made = nested(root, "link", name=name)
    inertial = nested(made, "inertial")
    nested(inertial, "origin", xyz=f"0 0 {-link.com:.10g}")
    nested(inertial, "mass", value=f"{link.mass:.10g}")
    moments = {"ixx": f"{across:.10g}", "iyy": f"{about:.10g}", "izz": f"{along:.10g}"}
    nested(inertial, "inertia", **moments, ixy="0", ixz="0", iyz="0")
    visual = nested(made, "visual")
    nested(visual, "origin", xyz=f"0 0 {-link.length / 2:.10g}")
    nested(nested(visual, "geometry"), "cylinder", radius="0.008", length=f"{link.length:.10g}")


def sdf_file(leg: Leg, fastest: Array) -> RobotFile:
    """The leg as an SDF model fixed to the world; see ``urdf_file``."""
    said: list[str] = []
    root = Element("sdf", version=SDF_VERSION)
    world = nested(root, "world", name="default")
    nested(world, "gravity", f"0 0 {-leg.gravity:.10g}")
    model = nested(world, "model", name=leg.name)
    nested(nested(model, "link", name="base"), "pose", f"0 0 0 0 {-leg.tilt:.10g} 0")
    mount = nested(model, "joint", name="mount", type="fixed")
    nested(mount, "parent", "world")
    nested(mount, "child", "base")
    parent, height = "base", 0.0
    for index, joint in enumerate(leg.joints):
        rate, friction, found = _dynamics(joint, float(fastest[index]))
        said += [f"{joint.name}: {text}" for text in found]
        child = joint.name + _LINK_END
        _sdf_link(model, child, joint.link, parent, height)
        _sdf_joint(model, joint, parent, child, rate, friction)
        parent, height = child, joint.link.length
    return _finished(root, [*said, *_base(leg)])


def _sdf_link(model: Element, name: str, link: Link, parent: str, height: float) -> None:
    across, about, along = inertias(link)
    made = nested(model, "link", name=name)
    nested(made, "pose", f"0 0 {-height:.10g} 0 0 0", relative_to=parent)
    inertial = nested(made, "inertial")
    nested(inertial, "pose", f"0 0 {-link.com:.10g} 0 0 0")
    nested(inertial, "mass", f"{link.mass:.10g}")
    inertia = nested(inertial, "inertia")
    for key, value in (("ixx", across), ("iyy", about), ("izz", along), ("ixy", 0.0), ("ixz", 0.0), ("iyz", 0.0)):
        nested(inertia, key, f"{value:.10g}")
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
    rate, error = linear_damping(joint, fastest)
    said = []
    if error > WORTH_SAYING:
        said.append(
            f"the damper's torque-speed curve is a straight line here, at most {error:.0%} of its torque off up to "
            f"{fastest * 30 / pi:.3g} rpm"
        )
    friction = joint.effects.get("coulomb_friction", {}).get("torque", 0.0)
    lost = without_held(joint, ("coulomb_friction", "shear_thinning_damping", "quadratic_damping"))
    if lost:
        said.append(f"not held: {', '.join(lost)}")
    return rate, friction, said


def _base(leg: Leg) -> list[str]:
    return [f"not held: {', '.join(sorted(leg.effects))} of the base"] if leg.effects else []


def _finished(root: Element, said: list[str]) -> RobotFile:
    notes = ["written by synth; joint angles are rotations q = sign * (measured - zero)", *said]
    for index, text in enumerate(notes):
        root.insert(index, Comment(f" {text} "))
    return RobotFile(xml_text(root, declared=True), tuple(said))


def write_robot_files(leg: Leg, fastest: Array, folder: Path) -> list[str]:
    """Write ``leg.urdf`` and ``leg.sdf`` into ``folder``; returns a warning a file for what it does not hold."""
    said = []
    for name, made in (("leg.urdf", urdf_file(leg, fastest)), ("leg.sdf", sdf_file(leg, fastest))):
        write_text(folder / name, made.text)
        if made.warnings:
            said.append(f"{name} does not hold all of the leg: {'; '.join(made.warnings)}")
    return said
