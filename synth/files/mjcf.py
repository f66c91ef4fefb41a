"""A leg as MJCF for MuJoCo: springs, dampers with their curves, dry friction, inertias.

A torque-speed curve that bends downwards goes in exactly, as a row of MuJoCo's dry frictions on one joint (fixed
tendons with ``frictionloss``). Below its torque limit such a friction is a constraint with reference acceleration
``-b w`` and regularisation R = (1 - d)/d A, A being the joint's inverse inertia in the straight pose
(MuJoCo, Computation: Constraint model); its force is then ``-(b/R) w`` but for a share d of what accelerates the joint,
and d is the smallest that MuJoCo allows. What else a curve holds is MuJoCo's own polynomial damping
``-(a w + b w|w| + c w^3)``. A spring's curve is a row of tendons too (``mjcf_springs``). Backlash is a second hinge
(``mjcf_backlash``). Effects that MuJoCo's joints lack are named in a comment.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, floor, inf, log10
from pathlib import Path
from xml.etree.ElementTree import Comment, Element, SubElement

import numpy as np

from synth.arrays import Array
from synth.files.drive_terms import IN_SERVO, DriveTerms, drive_terms, lightened
from synth.files.joint_curves import IN_DAMPING, DampingTerms, stops_at_range, without_held
from synth.files.joint_springs import IN_SPRING
from synth.files.mjcf_backlash import add_arm, add_limit, arm_name, arm_weight, play_of
from synth.files.mjcf_laws import JointLaws, joint_laws
from synth.files.mjcf_springs import add_spring_pieces
from synth.files.output import write_text
from synth.files.robot_bodies import SCALE, RobotLink, inertial_of, numbers, tip_names
from synth.files.xml_text import xml_text
from synth.swing.leg_model import Joint, Leg
from synth.swing.mechanics import coefficients, mass_matrix

IMPEDANCE = 1e-4  # the smallest value MuJoCo accepts (mjMINIMP): the friction's share of the other acceleration
SHARP = {"solreffriction": "0.002 1", "solimpfriction": "0.99 0.99 1"}  # dry friction almost as stiff as ours
HARD = {"solreflimit": "0.002 1.6", "solimplimit": "0.99 0.99 1"}  # a stop that hardly rebounds, as ours of a design
LARGEST_STEP = 5e-4  # s: MuJoCo then follows the chain within 0.1 deg (tests/files/test_mjcf.py)
STABLE = 1.0  # step times the fastest damping rate; Runge-Kutta is stable to 2.8
# MuJoCo takes a positive third biasprm for a damping ratio where gain and stiffness are equal (dampratio of a position
# actuator); a late winding's damping is to be a damping.
UNEQUAL = 1.0 + 1e-9
NOT_IN_MODEL = "not in this model"  # begins a comment on what the file omits; `synth check` shows these
HELD = ("backlash", "coulomb_friction", *IN_DAMPING, *IN_SPRING, *IN_SERVO)


def mjcf_text(
    leg: Leg,
    fastest: Array,
    base: RobotLink | None = None,
    links: Sequence[RobotLink] = (),
    notes: Sequence[str] = (),
    deflected: Array | None = None,
) -> str:
    """The leg as an MJCF document; ``fastest`` and ``deflected`` as for ``joint_laws``.

    Links hang along -z of their body, joints turn about -y so that a positive angle is counter-clockwise seen with x to
    the right and z up. ``base`` and ``links``: whole bodies and drawn parts; without them a link is a rod, whose
    inertias other than about the joint axis are those of one of its length. ``notes`` are comments.
    """
    shown = list(links) or [RobotLink()] * len(leg.joints)
    weights, drives = inverse_inertia(leg), drive_terms(leg)
    laws = joint_laws(leg, fastest, deflected, drives)
    terms = [item.damper for item in laws]
    plays = [play_of(joint, driven=drive is not None) for joint, drive in zip(leg.joints, drives, strict=True)]
    borne = np.array(  # of the hinges with the dampers
        [
            arm_weight(stiffest(item), float(weight)) if play else weight
            for item, weight, play in zip(terms, weights, plays, strict=True)
        ]
    )
    root = Element("mujoco", model=leg.name)
    root.append(Comment(" written by synth; joint angles are rotations q = sign * (measured - zero) "))
    for note in notes:
        root.append(Comment(f" {note} "))
    if leg.effects:
        root.append(Comment(f" {NOT_IN_MODEL}: {', '.join(sorted(leg.effects))} of the base "))
    SubElement(root, "compiler", angle="radian", autolimits="true")
    step = time_step(terms, borne, drives)
    SubElement(root, "option", gravity=f"0 0 {-leg.gravity:.10g}", integrator="RK4", timestep=f"{step:.10g}")
    visuals = [item for link in (base or RobotLink(), *shown) for item in link.visuals]
    if visuals:
        asset = SubElement(root, "asset")
        for visual in visuals:
            SubElement(asset, "mesh", name=visual.name, file=visual.path, scale=SCALE)
    body = SubElement(SubElement(root, "worldbody"), "body", name="base", euler=f"0 {-leg.tilt:.10g} 0")
    _geoms(body, base or RobotLink())
    for index, joint in enumerate(leg.joints):
        height = 0.0 if index == 0 else leg.joints[index - 1].link.length
        if plays[index]:
            add_arm(body, joint.name, height, float(borne[index]), laws[index].attributes(joint))
        body = _body(body, joint, height, laws[index], shown[index], drives[index])
    last = leg.joints[-1]
    SubElement(body, "site", name=tip_names(last.name)[0], pos=f"0 0 {-last.link.length:.10g}")
    _tendons(root, leg, laws, borne + np.where(plays, _links_above(leg), 0.0), plays)
    _actuators(root, leg, drives, step)
    return xml_text(root)


def _actuators(root: Element, leg: Leg, drives: Sequence[DriveTerms | None], step: float) -> None:
    """Each servo as one affine actuator, in the order of the joints: the controls are in its comment."""
    if not any(drives):
        return
    actuator = SubElement(root, "actuator")
    for joint, drive in zip(leg.joints, drives, strict=True):
        if drive is None:
            continue
        actuator.append(Comment(f" control of {joint.name}: {drive.control} "))
        gain = (drive.stiffness + drive.volt) * (UNEQUAL if drive.damping < 0.0 else 1.0)
        attributes = {
            "name": f"{joint.name} drive", "joint": joint.name, "gainprm": f"{gain:.12g}",
            "biastype": "affine", "biasprm": f"0 {-drive.stiffness:.10g} {-drive.damping:.10g}",
        }  # fmt: skip
        if drive.limit < inf and drive.stiffness:
            attributes["forcerange"] = f"{-drive.limit:.10g} {drive.limit:.10g}"
        if drive.delay:  # MuJoCo 3.5 and later
            attributes |= {
                "delay": f"{drive.delay:.10g}",
                "interp": "linear",
                "nsample": str(ceil(drive.delay / step) + 2),
            }
        SubElement(actuator, "general", attributes)


def inverse_inertia(leg: Leg) -> Array:
    """(n,) 1/(kg m^2), each joint's acceleration by a unit torque with the leg straight and the others free."""
    straight = mass_matrix(coefficients(leg), np.zeros(len(leg.joints)), leg.tilt)
    return np.asarray(np.diag(np.linalg.inv(straight)))


def _links_above(leg: Leg) -> Array:
    """(n,) 1/(kg m^2), angular acceleration of the link above each joint by a unit torque on it, in the straight pose.

    A torque on an arm beside the joint's link presses on that one alone; the first joint's base does not move.
    """
    inverse = np.linalg.inv(mass_matrix(coefficients(leg), np.zeros(len(leg.joints)), leg.tilt))
    return np.array([inverse[:above, :above].sum() for above in range(len(leg.joints))])


def stiffest(terms: DampingTerms) -> float:
    """A damper's largest rate, N m s/rad: at rest."""
    return sum(terms.slope) + terms.polynomial[0]


def time_step(terms: list[DampingTerms], weights: Array, drives: Sequence[DriveTerms | None] = ()) -> float:
    """A step (s) at which the stiffest damper and servo are stable, in round numbers."""
    slopes = np.array([stiffest(item) for item in terms])
    servos = np.array([(drive.damping, drive.stiffness) if drive else (0.0, 0.0) for drive in drives]).reshape(-1, 2).T
    if drives:
        slopes = slopes + servos[0]
    fastest = float(np.max(slopes * weights, initial=0.0))
    if drives:
        fastest = max(fastest, float(np.sqrt(np.max(servos[1] * weights))))
    step = min(LARGEST_STEP, STABLE / fastest) if fastest > 0.0 else LARGEST_STEP
    power = 10.0 ** floor(log10(step))
    return next(factor * power for factor in (5.0, 2.0, 1.0) if factor * power <= step * (1.0 + 1e-9))


def _tendons(root: Element, leg: Leg, laws: Sequence[JointLaws], weights: Array, plays: Sequence[float]) -> None:
    """The dampers' frictions, pieces of the springs and limits of the backlashes, where there are any.

    ``weights`` (n,) 1/(kg m^2): inverse inertia that MuJoCo computes for a tendon on the hinge with the damper.
    """
    sloped = any(item.damper.slope for item in laws)
    sprung = any(item.spring.pieces for item in laws if item.spring is not None)
    if not sloped and not sprung and not any(plays):
        return
    if sloped:
        root.append(Comment(" each friction is one straight piece of a damper's torque-speed curve "))
    tendon = SubElement(root, "tendon")
    for joint, item, weight, play in zip(leg.joints, laws, weights, plays, strict=True):
        hinge = arm_name(joint.name) if play else joint.name
        _frictions(tendon, hinge, item.damper, float(weight))
        if item.spring is not None:
            add_spring_pieces(tendon, hinge, joint.rest, item.spring)
        if play:
            add_limit(tendon, joint.name, play)


def _frictions(parent: Element, joint: str, terms: DampingTerms, weight: float) -> None:
    """One fixed tendon per clamp: a friction whose slope below its limit is the clamp's."""
    regularisation = (1.0 - IMPEDANCE) / IMPEDANCE * weight
    for index, (speed, slope) in enumerate(zip(terms.speed, terms.slope, strict=True)):
        fixed = SubElement(parent, "fixed", {
            "name": f"{joint} damper {index + 1}",
            "frictionloss": f"{slope * speed:.10g}",
            "solimpfriction": f"{IMPEDANCE} {IMPEDANCE} 1",
            "solreffriction": f"-1 {-slope * regularisation * IMPEDANCE:.10g}",
        })  # fmt: skip
        SubElement(fixed, "joint", joint=joint, coef="1")


def _geoms(body: Element, drawn: RobotLink) -> None:
    """The drawn parts, without mass or contact."""
    for item in drawn.visuals:
        SubElement(body, "geom", {
            "name": item.name, "type": "mesh", "mesh": item.name, "pos": numbers(item.place),
            "quat": numbers(item.quaternion), "rgba": f"{numbers(item.colour)} 1", "mass": "0", "contype": "0",
            "conaffinity": "0", "group": "1",
        })  # fmt: skip


def _body(
    parent: Element, joint: Joint, height: float, laws: JointLaws, drawn: RobotLink, drive: DriveTerms | None
) -> Element:
    """The body of a joint's link, which the next one's hangs from."""
    link, inertial = joint.link, inertial_of(joint, drawn)
    attributes, notes = {"name": joint.name, "axis": "0 -1 0"}, laws.notes()
    if not play_of(joint, driven=drive is not None):
        attributes |= laws.attributes(joint)
    else:
        attributes |= laws.drag_attributes()
    if lightened(joint):
        notes.append(f"{NOT_IN_MODEL}, {lightened(joint)}")
    elif joint.with_rotor:
        attributes["armature"] = f"{joint.with_rotor:.10g}"
    friction = joint.effects.get("coulomb_friction")
    if friction is not None:
        attributes |= {"frictionloss": f"{friction['torque']:.10g}", **SHARP}
        notes += [f"{NOT_IN_MODEL}: creep of coulomb_friction"] if friction.get("creep") else []
    lost = without_held(joint, held_effects(driven=drive is not None))
    if lost:
        notes.append(f"{NOT_IN_MODEL}: {', '.join(lost)}")
    if drive is not None and drive.cut < inf:
        attributes["actuatorfrcrange"] = f"{-drive.cut:.10g} {drive.cut:.10g}"
    notes += [f"{NOT_IN_MODEL}, of the drive: {text}" for text in (drive.lost if drive is not None else ())]
    if joint.ends is not None:
        attributes["range"] = f"{joint.ends[0]:.10g} {joint.ends[1]:.10g}"
        attributes |= HARD if stops_at_range(joint) else {}
    body = SubElement(parent, "body", name=joint.name, pos=f"0 0 {-height:.10g}")
    for note in notes:
        body.append(Comment(f" {note} "))
    SubElement(body, "joint", attributes)
    kind = "diaginertia" if not any(inertial.inertia[3:]) else "fullinertia"
    SubElement(body, "inertial", {
        "pos": numbers(inertial.centre), "mass": f"{inertial.mass:.10g}",
        kind: numbers(inertial.inertia[:3] if kind == "diaginertia" else inertial.inertia),
    })  # fmt: skip
    if drawn.visuals:
        _geoms(body, drawn)
    else:
        SubElement(body, "geom", type="capsule", fromto=f"0 0 0 0 0 {-link.length:.10g}", size="0.008", contype="0",
                   conaffinity="0")  # fmt: skip
    return body


def held_effects(*, driven: bool) -> tuple[str, ...]:
    """The effects of a joint that the file has; backlash only where no drive acts."""
    return tuple(name for name in HELD if not (driven and name == "backlash"))


def write_mjcf(
    leg: Leg,
    fastest: Array,
    path: Path,
    base: RobotLink | None = None,
    links: Sequence[RobotLink] = (),
    deflected: Array | None = None,
) -> None:
    """Write ``mjcf_text``."""
    write_text(path, mjcf_text(leg, fastest, base, links, deflected=deflected))
