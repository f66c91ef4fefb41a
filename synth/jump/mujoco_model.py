"""Model C: the leg of model A in MuJoCo, an engine that shares no line with ours and closes the loop its own way.

Two chains of hinged rods hang from a body that slides on a vertical rail; an equality constraint ``connect`` joins
their feet. MuJoCo solves constraints softly: here with a time constant of two steps and an impedance of 0.9999, so the
feet part by micrometres (``closure_gap``). Springs are MuJoCo's own, the foot's flexure a fixed tendon, motors its
affine actuators. The ground is either ``same``, our linear law added to MuJoCo's passive forces at each stage, or
``own``, MuJoCo's soft contact with its default parameters: where A and C part by contact is told by the two.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from synth.arrays import Array
from synth.errors import UserError
from synth.jump.hopper_leg import Contact, HopperLeg, Motor, segments
from synth.jump.jump_models import Model, lane, layout_of
from synth.jump.jump_runs import FALL
from synth.jump.outcomes import (
    COLLAPSED,
    CREEP,
    LANDED_AGAIN,
    LIFTED,
    LIMITS,
    SETTLED,
    TOO_STIFF,
    TOO_WEAK,
    Outcome,
)  # fmt: skip

Ground = Literal["same", "own"]
STEP, LEAST_STEP = 5e-5, 4e-6  # s; half of it changes the clearance by less than 0.1 mm
FOOT_RADIUS = 1e-3  # m, of MuJoCo's own contact only
HOW_TO_INSTALL = 'model C needs MuJoCo, an engine that is not installed: pip install "mujoco>=3.7"'


def require_mujoco() -> Any:
    """The module; UserError with how to install it where it is missing."""
    try:
        import mujoco
    except ImportError:
        raise UserError(HOW_TO_INSTALL) from None
    return mujoco


@dataclass(frozen=True)
class MujocoJump:
    """A jump by MuJoCo. ``trace`` columns: time, hips' height, right hip's angle, foot's height, com speed, normal."""

    outcome: Outcome
    closure_gap: float  # m, the greatest distance between the feet that should be one
    trace: Array


def mjcf(leg: HopperLeg, motor: Motor, contact: Contact, model: Model, ground: Ground, step: float = STEP) -> str:
    """The leg as an MJCF document. Hinges turn about -y: counter-clockwise with x to the right and z up."""
    if model.electric:
        raise ValueError("MuJoCo's leg has the linear motor: models A, C and D")
    z = lane(leg, motor, contact, model)
    layout = layout_of(leg)
    lengths, masses, knee = segments(leg)
    right, left = (_chain(leg, out, lengths, masses, knee, z[layout.block("beam")], model) for out in (1, -1))
    last = len(lengths) - 1
    floor = '<geom type="plane" size="1 1 0.1" contype="1" conaffinity="1" condim="1"/>' if ground == "own" else ""
    flexures = leg.flexures
    damping = flexures.damping if model.joint_damping else 0.0
    sums = "".join(
        f'<joint joint="{side}{i}" coef="{coefficient}"/>'
        for side, coefficient in (("l", 1), ("r", -1))
        for i in range(last + 1)
    )
    torque, slope = (float(z[layout.row(name)]) for name in ("linear_torque", "torque_slope"))
    actuators = "".join(
        f'<general joint="{side}0" gaintype="fixed" gainprm="0" biastype="affine" '
        f'biasprm="{-out * torque!r} 0 {-slope!r}"/>'
        for side, out in (("r", 1), ("l", -1))
    )
    body = leg.structure_mass + 2 * motor.mass
    return (
        '<mujoco><compiler angle="radian" inertiafromgeom="false"/>'
        f'<option gravity="0 0 {-leg.gravity!r}" integrator="RK4" timestep="{step!r}" '
        'tolerance="1e-14" iterations="200">'
        '<flag eulerdamp="disable"/></option><default><geom contype="0" conaffinity="0"/></default>'
        f'<worldbody>{floor}<body name="body"><joint name="rail" type="slide" axis="0 0 1"/>'
        f'<inertial pos="0 0 0" mass="{body!r}" diaginertia="1e-5 1e-5 1e-5"/>{right}{left}</body></worldbody>'
        f'<equality><connect site1="foot_r" site2="foot_l" '
        f'solref="{2 * step!r} 1" solimp="0.9999 0.9999 0.001 0.5 2"/></equality>'
        f'<tendon><fixed name="foot" stiffness="{flexures.rate!r}" damping="{damping!r}" '
        f'springlength="{flexures.foot_rest!r}">{sums}</fixed></tendon>'
        f"<actuator>{actuators}</actuator></mujoco>"
    )


def _chain(
    leg: HopperLeg, out: int, lengths: list[float], masses: list[float], knee: int, beams: Array, model: Model
) -> str:
    """One side's nested bodies; ``out`` +1 right, -1 left. Joint angles are relative to the parent."""
    flexures, side = leg.flexures, "r" if out > 0 else "l"
    damping = flexures.damping if model.joint_damping else 0.0
    text = ""
    for i in reversed(range(len(lengths))):
        rate, rest, loss = beams[i - 1] if i else 0.0, 0.0, 0.0
        if i == 0:
            rate, rest, loss = flexures.rate, out * flexures.hip_rest, damping
        elif i == knee:
            rate, rest, loss = flexures.rate, -out * flexures.knee_rest, damping
        length, mass = lengths[i], masses[i]
        place = f"{out * 0.5 * leg.hip_spacing!r} 0 0" if i == 0 else f"0 0 {-lengths[i - 1]!r}"
        across = mass * length**2 / 12.0
        end = ""
        if i == len(lengths) - 1:
            end = f'<site name="foot_{side}" pos="0 0 {-length!r}"/>'
            if side == "r":
                end += (
                    f'<geom type="sphere" size="{FOOT_RADIUS!r}" pos="0 0 {FOOT_RADIUS - length!r}" conaffinity="1"/>'
                )
            if leg.foot_mass > 0.0:
                half = 0.5 * leg.foot_mass
                end += (f'<body pos="0 0 {-length!r}"><inertial pos="0 0 0" mass="{half!r}" '
                        'diaginertia="1e-12 1e-12 1e-12"/></body>')  # fmt: skip
        text = (
            f'<body name="body_{side}{i}" pos="{place}"><joint name="{side}{i}" type="hinge" axis="0 -1 0" '
            f'stiffness="{float(rate)!r}" springref="{float(rest)!r}" damping="{loss!r}"/>'
            f'<inertial pos="0 0 {-0.5 * length!r}" mass="{mass!r}" '
            f'diaginertia="{across!r} {across!r} {1e-3 * across!r}"/>'
            f"{end}{text}</body>"
        )
    return text


def followed(leg: HopperLeg, motor: Motor) -> float:
    """A step that follows the motor's slope on the first piece of a link, half its time constant, within the limits."""
    lengths, masses, _ = segments(leg)
    slope = motor.stall_torque / motor.no_load_speed
    return float(np.clip(0.5 * masses[0] * lengths[0] ** 2 / 3.0 / slope, LEAST_STEP, STEP))


def mujoco_jump(
    leg: HopperLeg,
    motor: Motor,
    contact: Contact,
    model: Model,
    *,
    ground: Ground = "same",
    step: float | None = None,
    duration: float = 1.0,
    height: float | None = None,
    powered: bool = True,
) -> MujocoJump:
    """One jump, or with ``height`` (m, the foot above the ground) a drop from rest.

    ``powered`` False switches the motors off. A drop ends after ``duration``.

    Raises
    ------
    UserError : MuJoCo is not installed.
    """
    mujoco = require_mujoco()
    step = step or followed(leg, motor)
    model_ = mujoco.MjModel.from_xml_string(mjcf(leg, motor, contact, model, ground, step))
    if not powered:
        model_.actuator_biasprm[:] = 0.0
    data = _at_rest(mujoco, model_, leg, lane(leg, motor, contact, model), height)
    slope, stall = motor.stall_torque / motor.no_load_speed, motor.stall_torque
    drop = (motor.stall_current - motor.no_load_current) / motor.no_load_speed
    touching = 1e-6 if ground == "same" else 1e-4  # m, of the foot above the ground
    rows: list[tuple[float, ...]] = []
    gap = torque = current = energy = highest = 0.0
    takeoff = (0.0, 0.0, 0.0)  # s, m/s, J
    status: int | None = None
    with _passive(mujoco, model_, leg, contact, layout_of(leg).n, ground):
        mujoco.mj_forward(model_, data)
        while data.time < duration and status is None:
            foot, foot_v = _foot(mujoco, model_, data)
            speed = _com_speed(mujoco, model_, data)
            normal = _linear_ground(contact, foot, foot_v) if ground == "same" else _own_normal(mujoco, model_, data)
            rows.append((float(data.time), float(data.qpos[0]), float(data.qpos[1]), foot, speed, normal))
            omega = -float(data.qvel[1])
            drawn = 2 * (motor.stall_current - drop * omega) if powered else 0.0
            energy += motor.voltage * drawn * step
            highest = max(highest, foot)
            if foot <= touching and highest < LIFTED:
                torque, current = max(torque, abs(stall - slope * omega)), max(current, abs(drawn))
                takeoff = (float(data.time), speed, energy)
            gap = max(gap, float(np.linalg.norm(data.site("foot_r").xpos - data.site("foot_l").xpos)))
            still = abs(speed) < CREEP and len(rows) > 1 and abs(speed - rows[-2][4]) < 0.5 * step
            if height is None and highest > LIFTED and speed < -FALL and (foot_v < 0.0 or foot <= 0.0):
                status = LANDED_AGAIN
            elif data.qpos[0] <= 0.0:
                status = COLLAPSED
            elif height is None and still and data.time > SETTLED and foot <= 0.0:
                status = TOO_WEAK  # as the lanes do: it stands, and is not going to lift
            elif data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number:
                status = TOO_STIFF
            else:
                mujoco.mj_step(model_, data)
    trace = np.array(rows)
    rise = np.concatenate([[0.0], np.cumsum(0.5 * step * (trace[1:, 4] + trace[:-1, 4]))])
    outcome = Outcome(
        clearance=highest if status == LANDED_AGAIN else 0.0,
        rise=float(rise.max()),
        takeoff_time=takeoff[0],
        takeoff_speed=takeoff[1],
        peak_gear_torque=torque,
        peak_current=current,
        energy=takeoff[2],
        peak_normal=float(trace[:, 5].max()),
        limit=LIMITS[TOO_WEAK if status is None else status],
    )
    return MujocoJump(outcome, gap, trace)


def _at_rest(mujoco: Any, model: Any, leg: HopperLeg, z: Array, height: float | None) -> Any:
    """Data of the leg in its crouch as lane ``z`` (n_row,) has it; with ``height``, its foot that far (m) above."""
    layout = layout_of(leg)
    data, n = mujoco.MjData(model), layout.n
    relative = np.diff(z[layout.block("angle")], prepend=0.0)
    data.qpos[0] = z[layout.row("height")] if height is None else leg.height(leg.start) + height
    data.qpos[1 : 1 + n], data.qpos[1 + n :] = relative, -relative
    return data


def _linear_ground(contact: Contact, foot: float, foot_v: float) -> float:
    """Our linear law, N."""
    return -contact.stiffness * foot - contact.damping * foot_v if foot < 0.0 else 0.0


def _foot(mujoco: Any, model: Any, data: Any) -> tuple[float, float]:
    """Height and vertical speed of the foot, the mean of both sides."""
    jacobian, other = np.zeros((3, model.nv)), np.zeros((3, model.nv))
    mujoco.mj_jacSite(model, data, jacobian, None, model.site("foot_r").id)
    mujoco.mj_jacSite(model, data, other, None, model.site("foot_l").id)
    height = 0.5 * (data.site("foot_r").xpos[2] + data.site("foot_l").xpos[2])
    return float(height), float(0.5 * (jacobian[2] + other[2]) @ data.qvel)


def _com_speed(mujoco: Any, model: Any, data: Any) -> float:
    jacobian = np.zeros((3, model.nv))
    mujoco.mj_jacSubtreeCom(model, data, jacobian, 1)
    return float(jacobian[2] @ data.qvel)


def _own_normal(mujoco: Any, model: Any, data: Any) -> float:
    force, total = np.zeros(6), 0.0
    for index in range(data.ncon):
        mujoco.mj_contactForce(model, data, index, force)
        total += float(force[0])
    return total


@contextmanager
def _passive(mujoco: Any, model: Any, leg: HopperLeg, contact: Contact, n: int, ground: Ground) -> Iterator[None]:
    """Our stop and, where asked for, our ground, added at every stage of a step."""
    right, left = model.site("foot_r").id, model.site("foot_l").id
    jacobian, other = np.zeros((3, model.nv)), np.zeros((3, model.nv))

    def add(_: Any, data: Any) -> None:
        for out, hip in ((1.0, 1), (-1.0, 1 + n)):
            past = max(0.0, leg.extended - out * data.qpos[hip])
            push = leg.stop_rate * past * max(0.0, 1.0 - leg.stop_dissipation * out * data.qvel[hip])
            data.qfrc_passive[hip] += out * push
        if ground == "same":
            height = 0.5 * (data.site_xpos[right, 2] + data.site_xpos[left, 2])
            if height < 0.0:
                mujoco.mj_jacSite(model, data, jacobian, None, right)
                mujoco.mj_jacSite(model, data, other, None, left)
                along = 0.5 * (jacobian[2] + other[2])
                data.qfrc_passive[:] += along * _linear_ground(contact, height, float(along @ data.qvel))

    warned = mujoco.get_mju_user_warning()
    mujoco.set_mjcb_passive(add)
    mujoco.set_mju_user_warning(lambda _: None)  # else it writes a log into the current folder; see the status
    try:
        yield
    finally:
        mujoco.set_mjcb_passive(None)
        mujoco.set_mju_user_warning(warned)
