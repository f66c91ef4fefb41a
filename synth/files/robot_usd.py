"""A leg's joints as a USD layer for Isaac Sim and other users of USD physics, to lie over the imported URDF.

UsdPhysics' angular drive is a spring with its rest and a linear damper; its rates are per degree (UsdPhysics schema,
``PhysicsDriveAPI``: mass distance^2 / degree / second^2). PhysX adds the armature. A torque-speed curve, a stiffness
that changes and a dry friction in N m have no place there: PhysX's joint friction is a coefficient of the joint's load.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from math import degrees, inf, radians

from synth.arrays import Array
from synth.files.drive_terms import IN_SERVO, DriveTerms, drive_terms, lightened
from synth.files.joint_curves import linear_damping, without_held
from synth.files.robot_bodies import RobotLink, inertial_of
from synth.files.robot_xml import RobotFile
from synth.swing.leg_model import Joint, Leg

IN_RATE = ("shear_thinning_damping", "quadratic_damping")  # parts of the damper that the straight line stands for


def usd_file(leg: Leg, fastest: Array) -> RobotFile:
    """The layer; ``fastest`` (n,) rad/s is the speed up to which each damper is represented."""
    texts = [f"not held: {', '.join(sorted(leg.effects))} of the base"] if leg.effects else []
    links, joints = [], []
    for joint, speed, drive in zip(leg.joints, fastest, drive_terms(leg), strict=True):
        lines, lost = _joint(joint, float(speed), drive)
        texts += [f"{joint.name}: {text}" for text in lost]
        joints += lines
        links += _link(joint)
    notes = ["written by synth; lies over leg.urdf as Isaac Sim imports it: link NAME_link, joint NAME", *texts]
    head = "\\n".join(_quoted(note) for note in notes)
    body = "\n".join(['    over "joints"', "    {", *joints, "    }"])
    text = f'#usda 1.0\n(\n    defaultPrim = "{identifier(leg.name)}"\n    doc = "{head}"\n    kilogramsPerUnit = 1\n'
    text += '    metersPerUnit = 1\n    upAxis = "Z"\n)\n\n'
    text += f'over "{identifier(leg.name)}"\n{{\n' + "\n".join(links) + f"\n{body}\n}}\n"
    return RobotFile(text, tuple(texts))


def identifier(name: str) -> str:
    """A name that a USD path can hold: letters, digits and ``_``, no digit first."""
    plain = re.sub(r"[^A-Za-z0-9_]", "_", name) or "leg"
    return f"_{plain}" if plain[0].isdigit() else plain


def _quoted(text: str) -> str:
    return text.replace("\\", "\\\\").replace('"', '\\"')


def _link(joint: Joint) -> list[str]:
    link = joint.link
    across, about, along = inertial_of(joint, RobotLink()).inertia[:3]
    return [
        f'    over "{identifier(joint.name)}_link" (prepend apiSchemas = ["PhysicsMassAPI"])',
        "    {",
        f"        float physics:mass = {link.mass:.9g}",
        f"        point3f physics:centerOfMass = ({link.com_across:.9g}, 0, {-link.com:.9g})",
        f"        float3 physics:diagonalInertia = ({across:.9g}, {about:.9g}, {along:.9g})",
        "        quatf physics:principalAxes = (1, 0, 0, 0)",
        "    }",
    ]


def _joint(joint: Joint, fastest: float, drive: DriveTerms | None) -> tuple[list[str], list[str]]:
    """The joint's lines, and what they omit."""
    rate, words = linear_damping(joint, fastest)
    texts = [words] if words else []
    if lightened(joint):
        texts.append(f"not held, {lightened(joint)}")
    stiffness, target = (0.0, 0.0) if joint.spring is None else (joint.spring.rate, joint.rest)
    held = drive is not None and not stiffness
    lost = without_held(joint, (*IN_RATE, *IN_SERVO) if held else IN_RATE)
    if lost:
        texts.append(f"not held: {', '.join(lost)}")
    limit = []
    if drive is not None and held:  # the angular drive is free for the servo; its target is the command
        stiffness, target, rate = drive.stiffness, 0.0, rate + drive.damping + drive.braking
        most = min(drive.limit, drive.cut)
        limit = [f"float drive:angular:physics:maxForce = {most:.9g}"] if most < inf else []
        texts += [f"not held, of the drive: {text}" for text in drive.lost]
        if rate < 0.0:
            texts.append(
                f"not held, of the drive: {-rate:.3g} N*m*s/rad by which it is late, more than all its damping"
            )
        texts += ["maxForce cuts the damping with the servo's torque"] if limit else []
        texts += [f"the command comes {drive.delay:.3g} s late: send it so"] if drive.delay else []
        texts += ["the voltage that turns it"] if drive.volt else []
    elif drive is not None:
        texts.append(f"not held: the drive ({drive.in_words}); the angular drive is the joint's spring")
    lines = [
        'uniform token drive:angular:physics:type = "force"',
        f"float drive:angular:physics:stiffness = {stiffness * radians(1.0):.9g}",
        f"float drive:angular:physics:damping = {max(rate, 0.0) * radians(1.0):.9g}",
        f"float drive:angular:physics:targetPosition = {degrees(target):.9g}",
        *limit,
        f"float physxJoint:armature = {max(joint.with_rotor, 0.0):.9g}",
    ]
    if joint.ends is not None:
        lines += [f"float physics:{end}Limit = {degrees(value):.9g}" for end, value in _ends(joint.ends)]
    apis = 'prepend apiSchemas = ["PhysicsDriveAPI:angular", "PhysxJointAPI"]'
    return [
        f'        over "{identifier(joint.name)}" ({apis})',
        "        {",
        *(f"            {line}" for line in lines),
        "        }",
    ], texts


def _ends(ends: Sequence[float]) -> list[tuple[str, float]]:
    return [("lower", ends[0]), ("upper", ends[1])]
