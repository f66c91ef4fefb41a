"""What MuJoCo's fixed tendons say of a hinge: pieces of a damper's torque-speed curve, springs, and backlash.

The other direction of ``synth.files.mjcf`` and ``synth.files.mjcf_backlash``, by MuJoCo's own formulas, so that a file
that was edited or written by hand is read by the same rule.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np

from synth.files.robots.mjcf_spring_tendons import SpringTendon, spring_of
from synth.files.robots.robot_tree import RobotJoint
from synth.swing.leg_model import DamperCurve

VISCOUS = 1e-2  # largest impedance of a friction that is viscous below its limit: its share of other accelerations
SAME_PLACE = 1e-6  # m or as a sine: the arm's hinge coincides with the joint's
ARM_SHARE = 1e-3  # of the joint's own body's mass: an arm of more is a body of the robot
EVEN = 1e-6  # relative: both halves of the play


@dataclass
class HeldByTendons:
    """``clamps`` : index of a hinge -> pieces of its damper's curve, (speed rad/s, slope N m s/rad) each.

    ``plays`` : index of a hinge -> (index of its arm's hinge, width of the backlash in rad). ``springs`` : index of a
    hinge -> springs of tendons on it. ``read`` : the tendons that are represented, of the springs once they are read.
    """

    clamps: dict[int, list[tuple[float, float]]] = field(default_factory=dict)
    plays: dict[int, tuple[int, float]] = field(default_factory=dict)
    springs: dict[int, list[SpringTendon]] = field(default_factory=dict)
    read: set[int] = field(default_factory=set)


def held_by_tendons(mujoco: Any, model: Any) -> HeldByTendons:
    """The dampers' pieces and the backlashes among the model's fixed tendons."""
    found = HeldByTendons()
    for tendon in range(model.ntendon):
        first, count = int(model.tendon_adr[tendon]), int(model.tendon_num[tendon])
        wraps = range(first, first + count)
        if any(int(model.wrap_type[wrap]) != int(mujoco.mjtWrap.mjWRAP_JOINT) for wrap in wraps):
            continue
        joints = [int(model.wrap_objid[wrap]) for wrap in wraps]
        arms = [float(model.wrap_prm[wrap]) for wrap in wraps]
        spring = spring_of(model, tendon)
        if spring is not None and arms == [1.0]:
            found.springs.setdefault(joints[0], []).append(spring)
        if spring is not None or model.tendon_stiffness[tendon] or model.tendon_damping[tendon]:
            continue
        if arms == [1.0] and not model.tendon_limited[tendon]:
            piece = _piece(model, tendon)
            if piece is not None:
                found.clamps.setdefault(joints[0], []).append(piece)
                found.read.add(tendon)
        elif arms == [1.0, -1.0] and model.tendon_limited[tendon] and _is_arm(model, joints[0], joints[1]):
            low, high = (float(value) for value in model.tendon_range[tendon])
            if abs(low + high) <= EVEN * (high - low):
                found.plays[joints[0]] = (joints[1], high - low)
                found.read.add(tendon)
    return found


def _piece(model: Any, tendon: int) -> tuple[float, float] | None:
    """Speed (rad/s) at which a tendon's friction reaches its limit, and its slope (N m s/rad) below.

    With a direct ``solreffriction`` of damping B and a constant impedance d, the reference acceleration is -B/d w and
    the regularisation R = (1 - d)/d A, A being the inverse inertia at ``qpos0`` (MuJoCo, Computation: Constraint model;
    Modeling: Solver parameters): below its limit the force is -B/((1 - d) A) w.
    """
    limit = float(model.tendon_frictionloss[tendon])
    stiffness, damping = (float(value) for value in model.tendon_solref_fri[tendon])
    least, most = (float(value) for value in model.tendon_solimp_fri[tendon][:2])
    if not limit or stiffness > 0.0 or damping >= 0.0 or least != most or most > VISCOUS:
        return None
    slope = -damping / ((1.0 - most) * float(model.tendon_invweight0[tendon]))
    return limit / slope, slope


def _is_arm(model: Any, joint: int, arm: int) -> bool:
    """Whether the second hinge is a light arm beside the first one's body, on the same axis."""
    body, other = int(model.jnt_bodyid[joint]), int(model.jnt_bodyid[arm])
    axes = [
        (_turned(model.body_quat[place], model.jnt_axis[hinge]), model.body_pos[place] + model.jnt_pos[hinge])
        for hinge, place in ((joint, body), (arm, other))
    ]
    return bool(
        int(model.body_parentid[body]) == int(model.body_parentid[other])
        and float(model.body_mass[other]) <= ARM_SHARE * float(model.body_mass[body])
        and not (model.body_parentid[1:] == other).any()
        and np.linalg.norm(np.cross(axes[0][0], axes[1][0])) <= SAME_PLACE
        and float(axes[0][0] @ axes[1][0]) > 0.0
        and np.linalg.norm(np.cross(axes[1][1] - axes[0][1], axes[0][0])) <= SAME_PLACE
        and not model.jnt_stiffness[joint]
    )


def _turned(quaternion: Any, axis: Any) -> Any:
    """An axis of a body in its parent's frame."""
    import mujoco

    turned = np.zeros(3)
    mujoco.mju_rotVecQuat(turned, axis, quaternion)
    return turned


def with_arm(joint: RobotJoint, arm: RobotJoint, gap: float) -> RobotJoint:
    """The joint with the spring and damper of its arm, behind the backlash; drag may act on either side."""
    return replace(
        joint, stiffness=arm.stiffness, rest=arm.rest, damping=arm.damping, clamps=arm.clamps,
        drag=joint.drag or arm.drag, hardening=arm.hardening, onset=arm.onset, losses=arm.losses, gap=gap,
        refused=arm.refused, left_out=(*joint.left_out, *arm.left_out),
    )  # fmt: skip


def curve_of(joint: RobotJoint) -> DamperCurve | None:
    """The torque-speed curve of a joint's pieces and linear damping; None where there are no pieces.

    Its last point, twice as fast as the last corner, sets the slope beyond.
    """
    if not joint.clamps:
        return None
    corners = sorted({speed for speed, _ in joint.clamps})
    # Corners that differ by the rounding of a file are one.
    kept = [corners[0], *(after for before, after in pairwise(corners) if after > before * (1.0 + 1e-9))]
    speeds = np.array([*kept, 2.0 * kept[-1]])
    limits, slopes = np.array(joint.clamps).T
    torque = joint.damping * speeds + np.minimum(speeds[:, None], limits) @ slopes
    return DamperCurve(tuple(speeds.tolist()), tuple(torque.tolist()))
