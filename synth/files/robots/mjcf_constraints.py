"""MJCF's equality constraints on joints: one joint's reading is a polynomial of another's, as a mimic's of URDF."""

from __future__ import annotations

from math import degrees
from typing import Any

from synth.arrays import Array
from synth.files.robots.robot_tree import MimickedJoint


def follow_constraints(mujoco: Any, model: Any, readings: Array) -> dict[int, MimickedJoint]:
    """Joints that follow others, by index; ``readings`` (nq,) rad or m, changed to what the constraints demand.

    MuJoCo, documentation of ``equality/joint``: y - y0 = a0 + a1 (x - x0) + ... + a4 (x - x0)^4, with the readings x0
    and y0 of the reference pose. Without a second joint y - y0 = a0.
    """
    kind, hinges = int(mujoco.mjtEq.mjEQ_JOINT), int(mujoco.mjtJoint.mjJNT_HINGE)
    tied = [index for index in range(model.neq) if int(model.eq_type[index]) == kind and model.eq_active0[index]]
    found: dict[int, MimickedJoint] = {}
    for _ in tied:  # a joint may follow one that follows another: as often as there are constraints is enough
        for index in tied:
            joint, other = int(model.eq_obj1id[index]), int(model.eq_obj2id[index])
            place, terms = int(model.jnt_qposadr[joint]), [float(term) for term in model.eq_data[index, :5]]
            if other < 0:
                readings[place] = model.qpos0[place] + terms[0]
                continue
            source = int(model.jnt_qposadr[other])
            moved = float(readings[source] - model.qpos0[source])
            readings[place] = model.qpos0[place] + sum(term * moved**power for power, term in enumerate(terms))
            name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_JOINT, other) or f"joint number {other + 1}"
            start = float(model.qpos0[place] + terms[0] - terms[1] * model.qpos0[source])
            shown = f"{degrees(start):.4g} deg" if int(model.jnt_type[joint]) == hinges else f"{start:.4g} m"
            law = f"{terms[1]:g} times the reading of {name}, plus {shown}"
            found[joint] = MimickedJoint(name, "by a curve" if any(terms[2:]) else law)
    return found
