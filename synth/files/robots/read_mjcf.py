"""MJCF, read by MuJoCo itself, which resolves defaults, frames and the inertias of shapes."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from synth.errors import Problem, UserError
from synth.files.robots.mjcf_actuators import UndrivenActuators, undriven_actuators
from synth.files.robots.mjcf_constraints import follow_constraints
from synth.files.robots.mjcf_contacts import contacts_of
from synth.files.robots.mjcf_dampers import HeldByTendons, held_by_tendons, with_arm
from synth.files.robots.mjcf_files import require_files_inside
from synth.files.robots.mjcf_spring_tendons import with_springs
from synth.files.robots.robot_shapes import RobotShape, box, capsule, cylinder, ellipsoid, of_points, unread
from synth.files.robots.robot_tree import Kind, Robot, RobotBody, RobotJoint, doubtful_gravity, doubtful_limits
from synth.mujoco_warnings import heard_warnings

NONE: dict[int, float] = defaultdict(float)  # of each joint, where an older MuJoCo has no such attribute
NO_POWERS: dict[int, tuple[float, float]] = defaultdict(lambda: (0.0, 0.0))  # terms beyond the linear one, likewise
SHOWN = 4  # names of what is left out
LINEAR = 1e-12  # of the linear coefficient, below which other terms of a polynomial are ignored
UNKNOWN_SPRING = (
    "the springs of its tendons are left out, and its linear rate alone is kept: a leg knows one power of the "
    "deflection beyond an onset, alike on both sides, or a rate on either side"
)
EVEN_SPRING = (
    'stiffness="{:.6g} {:.6g} {:.6g}": the second number, of u^2, pulls the same way on both sides, unlike any spring '
    "of a leg; make it 0, or write the file anew if synth wrote it"
)


def read_mjcf(path: Path) -> Robot:
    """The robot in its reference pose (``qpos0``), with joints where an equality constraint on them puts them there.

    Raises
    ------
    UserError
        If MuJoCo is not installed, the file names one outside its folder, or MuJoCo cannot compile it.
    """
    try:
        import mujoco
    except ImportError:
        text = 'MJCF is read by MuJoCo, which is not installed: pip install "limb-synth[mujoco]"'
        raise UserError(Problem(text, str(path))) from None
    require_files_inside(path)
    try:
        with heard_warnings(mujoco) as heard:
            model = mujoco.MjModel.from_xml_path(str(path))
    except ValueError as error:
        lines = [line.strip() for line in str(error).splitlines() if line.strip()]
        raise UserError(Problem(f"cannot be compiled by MuJoCo: {'; '.join(lines)[:400]}", str(path))) from None
    data = mujoco.MjData(model)
    followed = follow_constraints(mujoco, model, data.qpos)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    held = held_by_tendons(mujoco, model)
    arms = {arm for arm, _ in held.plays.values()}
    massless = {int(model.jnt_bodyid[arm]) for arm in arms}
    bodies = tuple(_body(model, data, index, massless=index in massless) for index in range(1, model.nbody))
    actuators = undriven_actuators(mujoco, model)
    read = {
        index: replace(_joint(model, data, index, held, actuators), mimics=followed.get(index))
        for index in range(model.njnt)
    }
    title, in_radians = _written(path)
    for index, joint in read.items() if in_radians else ():
        doubt = doubtful_limits(joint.range, path.name) if joint.kind == "hinge" else ()
        read[index] = replace(joint, left_out=(*joint.left_out, *doubt))
    for index, tendons in held.springs.items():
        sprung = with_springs(read[index], tendons)
        if sprung is None:
            # A cubic term without the rest of its curve may pull away from rest.
            read[index] = replace(read[index], hardening=None, left_out=(*read[index].left_out, UNKNOWN_SPRING))
        else:
            read[index] = sprung
            held.read.update(item.tendon for item in tendons)
    for index, (arm, gap) in held.plays.items():
        read[index] = with_arm(read[index], read[arm], gap)
    joints = tuple(joint for index, joint in read.items() if index not in arms)
    name = _name(mujoco, model, "mjOBJ_BODY", 1) if model.nbody > 1 else ""
    title = title or name or path.stem
    marks = {_name(mujoco, model, "mjOBJ_SITE", index): data.site_xpos[index].copy() for index in range(model.nsite)}
    weighs = not int(model.opt.disableflags) & int(mujoco.mjtDisableBit.mjDSBL_GRAVITY)
    gravity = np.array(model.opt.gravity) if weighs else np.zeros(3)
    left_out = _left_out(mujoco, model, held.read, actuators)
    left_out += (*(f"MuJoCo warns: {text}" for text in heard), *doubtful_gravity(float(np.linalg.norm(gravity))))
    return Robot(title, bodies, joints, gravity, left_out, marks, contacts_of(mujoco, model))


def _written(path: Path) -> tuple[str, bool]:
    """What the compiled model does not tell: the root's ``model`` attribute, and whether angles are in radians."""
    from xml.etree.ElementTree import ParseError, parse

    try:
        root = parse(path).getroot()
    except (ParseError, OSError):
        return "", False
    return root.get("model") or "", any(item.get("angle") == "radian" for item in root.iter("compiler"))


def _name(mujoco: Any, model: Any, kind: str, index: int) -> str:
    return mujoco.mj_id2name(model, getattr(mujoco.mjtObj, kind), index) or ""


def _body(model: Any, data: Any, index: int, *, massless: bool) -> RobotBody:
    import mujoco

    turn = data.ximat[index].reshape(3, 3)
    inertia = turn @ np.diag(model.body_inertia[index]) @ turn.T
    first, count = int(model.body_geomadr[index]), int(model.body_geomnum[index])
    shapes = tuple(_shape(mujoco, model, data, geom) for geom in range(first, first + count))
    return RobotBody(
        _name(mujoco, model, "mjOBJ_BODY", index) or f"body {index}",
        int(model.body_parentid[index]) - 1,
        data.xmat[index].reshape(3, 3).copy(),
        data.xpos[index].copy(),
        0.0 if massless else float(model.body_mass[index]),
        data.xipos[index].copy(),
        0.0 * inertia if massless else inertia,
        shapes,
        float(model.body_gravcomp[index]),
    )


def _shape(mujoco: Any, model: Any, data: Any, geom: int) -> RobotShape:
    """A geom's shape in the world; of a height field or a signed distance only the centre is known."""
    kind, (x, y, z) = int(model.geom_type[geom]), (float(size) for size in model.geom_size[geom])
    names, mesh = mujoco.mjtGeom, int(model.geom_dataid[geom])
    if kind == names.mjGEOM_CAPSULE:
        found = capsule(y)
    elif kind == names.mjGEOM_CYLINDER:
        found = cylinder(y, x)
    elif kind == names.mjGEOM_BOX:
        found = box(np.array([x, y, z]))
    elif kind in (names.mjGEOM_SPHERE, names.mjGEOM_ELLIPSOID):
        found = ellipsoid(np.array([x, x, x] if kind == names.mjGEOM_SPHERE else [x, y, z]))
    elif kind == names.mjGEOM_MESH:
        first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        found = of_points(np.array(model.mesh_vert[first : first + count], float))
    else:
        found = unread(f"a geom of the kind {names(kind).name.removeprefix('mjGEOM_').lower()}")
    title = names(kind).name.removeprefix("mjGEOM_").lower()
    if kind == names.mjGEOM_MESH:
        title = f"mesh {_name(mujoco, model, 'mjOBJ_MESH', mesh)}"
    return replace(found.moved(data.geom_xpos[geom], data.geom_xmat[geom].reshape(3, 3)), title=title)


def _joint(model: Any, data: Any, index: int, held: HeldByTendons, actuators: UndrivenActuators) -> RobotJoint:
    import mujoco

    kinds: dict[int, Kind] = {0: "free", 1: "free", 2: "slide", 3: "hinge"}  # free, ball: locked as a whole
    kind = kinds[int(model.jnt_type[index])]
    dof, place = int(model.jnt_dofadr[index]), int(model.jnt_qposadr[index])
    limited = bool(model.jnt_limited[index])
    left_out: list[str] = []
    own = [float(model.dof_damping[dof]), *getattr(model, "dof_dampingpoly", NO_POWERS)[dof]]
    damping = [float(value) for value in own + actuators.damping[dof]]
    stiffness = float(model.jnt_stiffness[index])
    square, cube = getattr(model, "jnt_stiffnesspoly", NO_POWERS)[index]
    hardening, refused = _hardening(stiffness, float(square), float(cube), left_out)
    drag = _drag(damping[0], damping[1:], left_out)
    if stiffness and getattr(model, "jnt_springyield", NONE)[index]:
        left_out.append("its spring's yield is left out: a leg's spring is elastic")
    return RobotJoint(
        _name(mujoco, model, "mjOBJ_JOINT", index),
        int(model.jnt_bodyid[index]) - 1,
        kind,
        data.xaxis[index].copy(),
        data.xanchor[index].copy(),
        float(data.qpos[place]) if kind in ("hinge", "slide") else 0.0,
        stiffness,
        float(model.qpos_spring[place]) if kind in ("hinge", "slide") else 0.0,
        damping[0],
        float(model.dof_armature[dof] + actuators.armature[dof]),
        float(model.dof_frictionloss[dof]),
        (float(model.jnt_range[index, 0]), float(model.jnt_range[index, 1])) if limited else None,
        hardening,
        tuple(held.clamps.get(index, ())),
        drag,
        left_out=tuple(left_out),
        refused=refused,
    )


def _hardening(
    linear: float, square: float, cube: float, left_out: list[str]
) -> tuple[tuple[float, float] | None, str]:
    """The cubic term of a spring with its power, and why the spring is refused: MuJoCo's quadratic term is even."""
    least = LINEAR * max(abs(linear), LINEAR)
    if abs(square) > least:
        return None, EVEN_SPRING.format(linear, square, cube)
    if abs(cube) <= least:
        return None, ""
    if not linear:
        left_out.append(
            f"the stiffness is {cube:.4g} u^3 without a linear term, and left out: a leg's spring has a rate"
        )
    return (cube, 3.0), ""


def _drag(linear: float, terms: Sequence[float], left_out: list[str]) -> tuple[float, float] | None:
    """The one damping term beside the linear one, with its power; two of them, which no effect holds, are left out."""
    kept = [(float(value), power) for power, value in enumerate(terms, 2) if abs(value) > LINEAR * max(linear, LINEAR)]
    if len(kept) > 1:
        shown = ", ".join(f"{value:.4g}" for value in terms)
        left_out.append(f"the damping is {linear:.4g} plus higher powers ({shown}), which are left out")
    return kept[0] if len(kept) == 1 else None


def _left_out(mujoco: Any, model: Any, read: set[int], actuators: UndrivenActuators) -> tuple[str, ...]:
    """Forces on the robot that a leg of hinges with springs and dampers cannot represent."""
    found = []
    for indices, kind, what in (
        (range(len(model.actuator_trntype)), "mjOBJ_ACTUATOR", "actuators"),
        (range(model.neq), "mjOBJ_EQUALITY", "equality constraints"),
        ([index for index in range(model.ntendon) if index not in read], "mjOBJ_TENDON", "tendons"),
    ):
        count = len(indices)
        if count:
            names = [_name(mujoco, model, kind, index) or f"number {index + 1}" for index in indices[:SHOWN]]
            more = " and others" if count > SHOWN else ""
            found.append(f"{count} {what if count > 1 else what.removesuffix('s')} left out: {', '.join(names)}{more}")
    for these, what in (
        (actuators.kept, "kept as its joint's, through the gear"),
        (actuators.lost, "left out: it does not act on one hinge alone"),
    ):
        for index in these:
            name = _name(mujoco, model, "mjOBJ_ACTUATOR", index) or f"number {index + 1}"
            found.append(f"armature and damping of the actuator {name} are {what}")
    if model.opt.density or model.opt.viscosity:
        found.append("the medium's density and viscosity are left out")
    for bit, what in (("SPRING", "springs"), ("DAMPER", "dampers"), ("FRICTIONLOSS", "dry friction")):
        if int(model.opt.disableflags) & int(getattr(mujoco.mjtDisableBit, f"mjDSBL_{bit}", 0)):
            found.append(f"a flag of the file switches its {what} off; the leg has them")
    return tuple(found)
