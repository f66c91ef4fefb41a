"""A leg as URDF and as SDF, with what these can hold of springs and dampers, and a warning for what they cannot.

URDF's joints have a linear damping and a dry friction and no spring; SDF's have a linear spring with its rest as well.
Neither holds a torque-speed curve or a stiffness that changes: a curve becomes the straight line nearest to it.
Frames as in the MJCF: links hang along -z, joints turn about -y, angles are rotations q = sign * (measured - zero).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import pi
from pathlib import Path
from xml.sax.saxutils import quoteattr

from synth.arrays import Array
from synth.files.joint_curves import linear_damping, without_held
from synth.files.mjcf import inertias
from synth.files.output import write_text
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
    lines = [f"<robot name={quoteattr(leg.name)}>", '  <link name="base"/>']
    parent, height = "base", 0.0
    for index, joint in enumerate(leg.joints):
        rate, friction, found = _dynamics(joint, float(fastest[index]))
        said += [f"{joint.name}: {text}" for text in found]
        if joint.spring is not None:
            said.append(f"{joint.name}: URDF has no springs: {joint.spring.rate:.4g} N*m/rad is left out")
        lines += _urdf_link(joint.name + _LINK_END, joint.link)
        turned = f' rpy="0 {-leg.tilt:.10g} 0"' if index == 0 else ""
        lines += [
            f'  <joint name={quoteattr(joint.name)} type="{"continuous" if joint.range is None else "revolute"}">',
            f"    <parent link={quoteattr(parent)}/><child link={quoteattr(joint.name + _LINK_END)}/>",
            f'    <origin xyz="0 0 {-height:.10g}"{turned}/><axis xyz="0 -1 0"/>',
            f'    <dynamics damping="{rate:.10g}" friction="{friction:.10g}"/>',
        ]
        if joint.ends is not None:
            low, high = joint.ends
            lines.append(
                f'    <limit lower="{low:.10g}" upper="{high:.10g}" effort="{UNLIMITED:g}" velocity="{UNLIMITED:g}"/>'
            )
        lines.append("  </joint>")
        parent, height = joint.name + _LINK_END, joint.link.length
    return _finished(lines, "</robot>", [*said, *_base(leg)])


def _urdf_link(name: str, link: Link) -> list[str]:
    across, about, along = inertias(link)
    return [
        f"  <link name={quoteattr(name)}>",
        f'    <inertial><origin xyz="0 0 {-link.com:.10g}"/><mass value="{link.mass:.10g}"/>',
        f'      <inertia ixx="{across:.10g}" iyy="{about:.10g}" izz="{along:.10g}" ixy="0" ixz="0" iyz="0"/>',
        "    </inertial>",
        f'    <visual><origin xyz="0 0 {-link.length / 2:.10g}"/>',
        f'      <geometry><cylinder radius="0.008" length="{link.length:.10g}"/></geometry></visual>',
        "  </link>",
    ]


def sdf_file(leg: Leg, fastest: Array) -> RobotFile:
    """The leg as an SDF model fixed to the world; see ``urdf_file``."""
    said: list[str] = []
    lines = [
        f'<sdf version="{SDF_VERSION}">',
        '  <world name="default">',
        f"    <gravity>0 0 {-leg.gravity:.10g}</gravity>",
        f"    <model name={quoteattr(leg.name)}>",
        f'      <link name="base"><pose>0 0 0 0 {-leg.tilt:.10g} 0</pose></link>',
        '      <joint name="mount" type="fixed"><parent>world</parent><child>base</child></joint>',
    ]
    parent, height = "base", 0.0
    for index, joint in enumerate(leg.joints):
        rate, friction, found = _dynamics(joint, float(fastest[index]))
        said += [f"{joint.name}: {text}" for text in found]
        child = joint.name + _LINK_END
        lines += [f"      {line}" for line in _sdf_link(child, joint.link, parent, height)]
        lines += [f"      {line}" for line in _sdf_joint(joint, parent, child, rate, friction)]
        parent, height = child, joint.link.length
    lines += ["    </model>", "  </world>"]
    return _finished(lines, "</sdf>", [*said, *_base(leg)])


def _sdf_link(name: str, link: Link, parent: str, height: float) -> list[str]:
    across, about, along = inertias(link)
    return [
        f"<link name={quoteattr(name)}>",
        f"  <pose relative_to={quoteattr(parent)}>0 0 {-height:.10g} 0 0 0</pose>",
        f"  <inertial><pose>0 0 {-link.com:.10g} 0 0 0</pose><mass>{link.mass:.10g}</mass>",
        f"    <inertia><ixx>{across:.10g}</ixx><iyy>{about:.10g}</iyy><izz>{along:.10g}</izz>"
        "<ixy>0</ixy><ixz>0</ixz><iyz>0</iyz></inertia></inertial>",
        f'  <visual name="rod"><pose>0 0 {-link.length / 2:.10g} 0 0 0</pose>',
        f"    <geometry><cylinder><radius>0.008</radius><length>{link.length:.10g}</length></cylinder></geometry>"
        "</visual>",
        "</link>",
    ]


def _sdf_joint(joint: Joint, parent: str, child: str, rate: float, friction: float) -> list[str]:
    spring = ""
    if joint.spring is not None:
        spring = (
            f"<spring_reference>{joint.rest:.10g}</spring_reference>"
            f"<spring_stiffness>{joint.spring.rate:.10g}</spring_stiffness>"
        )
    lines = [
        f'<joint name={quoteattr(joint.name)} type="revolute">',
        f"  <parent>{_escaped(parent)}</parent><child>{_escaped(child)}</child>",
        "  <axis><xyz>0 -1 0</xyz>",
        f"    <dynamics><damping>{rate:.10g}</damping><friction>{friction:.10g}</friction>{spring}</dynamics>",
    ]
    if joint.ends is not None:
        low, high = joint.ends
        lines.append(f"    <limit><lower>{low:.10g}</lower><upper>{high:.10g}</upper></limit>")
    return [*lines, "  </axis>", "</joint>"]


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


def _finished(lines: Iterable[str], end: str, said: list[str]) -> RobotFile:
    head = [
        '<?xml version="1.0"?>',
        "<!-- written by synth; joint angles are rotations q = sign * (measured - zero) -->",
    ]
    head += [f"<!-- {_comment(text)} -->" for text in said]
    return RobotFile("\n".join([*head, *lines, end, ""]), tuple(said))


def _comment(text: str) -> str:
    """Text that may stand in an XML comment, which must not hold two hyphens in a row."""
    while "--" in text:
        text = text.replace("--", "- -")
    return text


def _escaped(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def write_robot_files(leg: Leg, fastest: Array, folder: Path) -> list[str]:
    """Write ``leg.urdf`` and ``leg.sdf`` into ``folder``; returns a warning a file for what it does not hold."""
    said = []
    for name, made in (("leg.urdf", urdf_file(leg, fastest)), ("leg.sdf", sdf_file(leg, fastest))):
        write_text(folder / name, made.text)
        if made.warnings:
            said.append(f"{name} does not hold all of the leg: {'; '.join(made.warnings)}")
    return said
