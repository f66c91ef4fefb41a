"""A leg's mass matrix and gravity torques by a robot's joint readings, beside MuJoCo's of the whole robot."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from synth.arrays import Array
from synth.swing.leg_model import Leg


def forces_of(leg: Leg, readings: Array) -> tuple[Array, Array]:
    """(n, n) kg m^2 with armatures and (n,) N m that hold the leg, at readings (n,) rad.

    Lagrange's: sums over links of m J'J + I w w' and m g J_up, J the Jacobian of a centre of mass.
    """
    count = len(leg.joints)
    turned = leg.tilt + np.cumsum(leg.to_rotation(readings))
    inertia, weight = np.diag([joint.armature for joint in leg.joints]), np.zeros(count)
    for last, joint in enumerate(leg.joints):
        moved, turns = np.zeros((2, count)), np.zeros(count)
        turns[: last + 1] = leg.sign[: last + 1]
        for above in range(last + 1):
            arm = joint.link.com if above == last else leg.joints[above].link.length
            way = arm * np.array([np.cos(turned[above]), np.sin(turned[above])])
            if above == last:
                way += joint.link.com_across * np.array([-np.sin(turned[above]), np.cos(turned[above])])
            moved[:, : above + 1] += np.outer(way, leg.sign[: above + 1])
        inertia = inertia + joint.link.mass * moved.T @ moved + joint.link.inertia * np.outer(turns, turns)
        weight += joint.link.mass * leg.gravity * moved[1]
    return inertia, weight


def farthest_from_mujoco(leg: Leg, model: Any, locked: dict[str, float] | None = None) -> float:
    """Largest difference of either over five poses, as a share of MuJoCo's largest entry there.

    ``locked`` : readings of other joints by name, rad; those that are not named stand at MuJoCo's reference.
    """
    data, rng, farthest = mujoco.MjData(model), np.random.default_rng(1), 0.0
    places = [int(model.joint(name).qposadr[0]) for name in leg.joint_names]
    freedoms = [int(model.joint(name).dofadr[0]) for name in leg.joint_names]
    for name, reading in (locked or {}).items():
        data.joint(name).qpos[0] = reading
    for _ in range(5):
        readings = rng.uniform(-3.0, 3.0, len(leg.joints))
        data.qpos[places] = readings
        mujoco.mj_forward(model, data)
        whole = np.zeros((model.nv, model.nv))
        for column in range(model.nv):
            mujoco.mj_mulM(model, data, whole[column], np.eye(model.nv)[column])
        theirs = whole[np.ix_(freedoms, freedoms)], data.qfrc_bias[freedoms]
        for ours, wanted in zip(forces_of(leg, readings), theirs, strict=True):
            farthest = max(farthest, float(np.abs(ours - wanted).max() / max(np.abs(wanted).max(), 1e-12)))
    return farthest
