"""What MJCF's actuators add to a hinge that nothing drives: their rotor's inertia and damping, through the gear."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from synth.arrays import Array


@dataclass(frozen=True, eq=False)
class UndrivenActuators:
    """By degree of freedom: ``armature`` (nv,) kg m^2, ``damping`` (nv, 3) of speed, its square and its cube.

    ``kept`` : actuators whose share is in these, ``lost`` : those that act on several joints or elsewhere; indices.
    """

    armature: Array
    damping: Array
    kept: tuple[int, ...]
    lost: tuple[int, ...]


def undriven_actuators(mujoco: Any, model: Any) -> UndrivenActuators:
    """Of all actuators with an armature or damping, whether switched on or not.

    On a joint both act by the square of the moment arm; MuJoCo 4 multiplies every power of the joint's speed by it.
    """
    armature, damping = np.zeros(model.nv), np.zeros((model.nv, 3))
    if not hasattr(model, "actuator_armature"):  # older versions of MuJoCo have none
        return UndrivenActuators(armature, damping, (), ())
    kept, lost = [], []
    for index in range(len(model.actuator_trntype)):
        powers = np.array([model.actuator_damping[index], *model.actuator_dampingpoly[index]], float)
        if not model.actuator_armature[index] and not powers.any():
            continue
        found = _hinge(mujoco, model, index)
        if found is None:
            lost.append(index)
            continue
        freedom, arm = found
        armature[freedom] += arm**2 * float(model.actuator_armature[index])
        damping[freedom] += arm**2 * powers
        kept.append(index)
    return UndrivenActuators(armature, damping, tuple(kept), tuple(lost))


def _hinge(mujoco: Any, model: Any, index: int) -> tuple[int, float] | None:
    """Degree of freedom and moment arm of an actuator on one hinge or slide, or on a tendon of one."""
    kind, target = int(model.actuator_trntype[index]), int(model.actuator_trnid[index, 0])
    arm = float(model.actuator_gear[index, 0])
    if kind == mujoco.mjtTrn.mjTRN_TENDON:
        first = int(model.tendon_adr[target])
        if int(model.tendon_num[target]) != 1 or int(model.wrap_type[first]) != int(mujoco.mjtWrap.mjWRAP_JOINT):
            return None
        target, arm = int(model.wrap_objid[first]), arm * float(model.wrap_prm[first])
    elif kind not in (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT):
        return None
    single = int(model.jnt_type[target]) in (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
    return (int(model.jnt_dofadr[target]), arm) if single else None
