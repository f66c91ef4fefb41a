"""Model C: the leg of model A in MuJoCo, an independent engine with its own loop closure.

Two chains of hinged rods hang from a body that slides on a vertical rail; an equality constraint ``connect`` joins
their feet. MuJoCo solves constraints softly: here with a time constant of two steps and an impedance of 0.9999, so the
feet separate by micrometres (``closure_gap``). Springs are MuJoCo's own, the foot's flexure a fixed tendon, motors its
affine actuators. The ground is either ``same``, our linear law added to MuJoCo's passive forces at each stage, or
``own``, MuJoCo's soft contact with default parameters: the difference shows the contact's share of A against C.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, Literal
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np

from synth.arrays import Array
from synth.errors import UserError
from synth.jump.hopper_leg import Contact, HopperLeg, Motor, segments
from synth.jump.jump_models import Model, lane, layout_of
from synth.jump.jump_runs import DURATION, FALL
from synth.jump.outcomes import (
    COLLAPSED,
    CREEP,
    CROSSED,
    LANDED_AGAIN,
    LIFTED,
    LIMITS,
    SETTLED,
    TOO_STIFF,
    TOO_WEAK,
    JumpOutcome,
    rise_of_jump,
)  # fmt: skip
from synth.mujoco_warnings import heard_warnings

Ground = Literal["same", "own"]
STEP, LEAST_STEP = 5e-5, 2e-6  # s; half of it changes the clearance by less than 0.1 mm
SLOPE_PART = 0.5  # of the time constant by a motor's slope
# Of that on the stop, of a single piece: with the others hinged to it, it is twice as long. Momentum is lost above 8,
# where a step reaches the method's limit of 2.8 true time constants; from 6 down 0.1 m of clearance vary by 3e-6 m.
STOP_PART = 5.0
FLIGHT = 60.0  # s, of a jump by MuJoCo with its flight; only a hundredth of the standard gravity takes so long
FOOT_RADIUS = 1e-3  # m, of MuJoCo's own contact only
HOW_TO_INSTALL = 'model C needs MuJoCo, an engine that is not installed: pip install "limb-synth[mujoco]"'


def require_mujoco() -> Any:
    """The module; UserError with install instructions if it is missing."""
    try:
        import mujoco
    except ImportError:
        raise UserError(HOW_TO_INSTALL) from None
    return mujoco


@dataclass(frozen=True)
class MujocoJump:
    """A jump by MuJoCo. ``trace`` columns: time, hips' height, right hip's angle, foot's height, com speed, normal."""

    outcome: JumpOutcome
    closure_gap: float  # m, the largest distance between the two feet
    trace: Array


def mjcf(leg: HopperLeg, motor: Motor, contact: Contact, model: Model, ground: Ground, step: float = STEP) -> str:
    """The leg as an MJCF document. Hinges turn about -y: counter-clockwise with x to the right and z up."""
    if model.electric:
        raise ValueError("MuJoCo's leg has the linear motor: models A, C and D")
    z = lane(leg, motor, contact, model)
    layout = layout_of(leg)
    flexures = leg.flexures
    damping = flexures.damping if model.joint_damping else 0.0
    root = _root(leg, ground, step)
    body = SubElement(root[-1], "body", name="body")
    SubElement(body, "joint", name="rail", type="slide", axis="0 0 1")
    mass = leg.structure_mass + 2 * motor.mass
    SubElement(body, "inertial", pos="0 0 0", mass=repr(mass), diaginertia="1e-5 1e-5 1e-5")
    for out in (1, -1):
        _add_chain(body, leg, out, z[layout.block("beam")], damping)
    equality = SubElement(root, "equality")
    soft = {"solref": f"{2 * step!r} 1", "solimp": "0.9999 0.9999 0.001 0.5 2"}
    SubElement(equality, "connect", {"site1": "foot_r", "site2": "foot_l", **soft})
    foot = {"stiffness": repr(flexures.rate), "damping": repr(damping), "springlength": repr(flexures.foot_rest)}
    tendon = SubElement(SubElement(root, "tendon"), "fixed", {"name": "foot", **foot})
    for side, coefficient in (("l", "1"), ("r", "-1")):
        for i in range(len(segments(leg)[0])):
            SubElement(tendon, "joint", joint=f"{side}{i}", coef=coefficient)
    torque, slope = (float(z[layout.row(name)]) for name in ("linear_torque", "torque_slope"))
    actuators = SubElement(root, "actuator")
    for side, out in (("r", 1), ("l", -1)):
        line = {"gaintype": "fixed", "gainprm": "0", "biastype": "affine", "biasprm": f"{-out * torque!r} 0 {-slope!r}"}
        SubElement(actuators, "general", {"joint": f"{side}0", **line})
    return tostring(root, encoding="unicode")


def _root(leg: HopperLeg, ground: Ground, step: float) -> Element:
    """The document with its options and an empty world."""
    root = Element("mujoco")
    SubElement(root, "compiler", angle="radian", inertiafromgeom="false")
    numbers = {"gravity": f"0 0 {-leg.gravity!r}", "integrator": "RK4", "timestep": repr(step)}
    option = SubElement(root, "option", {**numbers, "tolerance": "1e-14", "iterations": "200"})
    SubElement(option, "flag", eulerdamp="disable")
    SubElement(SubElement(root, "default"), "geom", contype="0", conaffinity="0")
    world = SubElement(root, "worldbody")
    if ground == "own":
        SubElement(world, "geom", type="plane", size="1 1 0.1", contype="1", conaffinity="1", condim="1")
    return root


def _add_chain(body: Element, leg: HopperLeg, out: int, beams: Array, damping: float) -> None:
    """One side's nested bodies; ``out`` +1 right, -1 left. Joint angles are relative to the parent.

    ``beams`` (n_beam,) N m/rad of the bending links' pieces; ``damping`` N m s/rad of the flexures.
    """
    lengths, masses, knee = segments(leg)
    flexures, side = leg.flexures, "r" if out > 0 else "l"
    parent = body
    for i, (length, mass) in enumerate(zip(lengths, masses, strict=True)):
        rate, rest, loss = float(beams[i - 1]) if i else 0.0, 0.0, 0.0
        if i == 0:
            rate, rest, loss = flexures.rate, out * flexures.hip_rest, damping
        elif i == knee:
            rate, rest, loss = flexures.rate, -out * flexures.knee_rest, damping
        place = f"{out * 0.5 * leg.hip_spacing!r} 0 0" if i == 0 else f"0 0 {-lengths[i - 1]!r}"
        parent = SubElement(parent, "body", name=f"body_{side}{i}", pos=place)
        spring = {"stiffness": repr(float(rate)), "springref": repr(float(rest)), "damping": repr(loss)}
        SubElement(parent, "joint", {"name": f"{side}{i}", "type": "hinge", "axis": "0 -1 0", **spring})
        across = mass * length**2 / 12.0
        inertia = f"{across!r} {across!r} {1e-3 * across!r}"
        SubElement(parent, "inertial", pos=f"0 0 {-0.5 * length!r}", mass=repr(mass), diaginertia=inertia)
    _add_foot(parent, leg, side, lengths[-1])


def _add_foot(link: Element, leg: HopperLeg, side: str, length: float) -> None:
    """The foot at the end of a side's last piece: its mark, on the right its shape, and half its mass."""
    SubElement(link, "site", name=f"foot_{side}", pos=f"0 0 {-length!r}")
    if side == "r":
        place = f"0 0 {FOOT_RADIUS - length!r}"
        SubElement(link, "geom", type="sphere", size=repr(FOOT_RADIUS), pos=place, conaffinity="1")
    if leg.foot_mass > 0.0:
        foot = SubElement(link, "body", pos=f"0 0 {-length!r}")
        SubElement(foot, "inertial", pos="0 0 0", mass=repr(0.5 * leg.foot_mass), diaginertia="1e-12 1e-12 1e-12")


def resolved_step(leg: HopperLeg, motor: Motor) -> float:
    """A step within the limits for the two dampers of a link's first piece: the motor's slope, and the stop's.

    The stop's grows with its push, which in flight is the motors' stall torque: it is the stronger one. Over a step too
    long for it, the Runge-Kutta method leaves the straight leg turning on its stop and loses momentum in flight.
    """
    lengths, masses, _ = segments(leg)
    inertia = masses[0] * lengths[0] ** 2 / 3.0
    slope = motor.stall_torque / motor.no_load_speed
    on_stop = slope + leg.stop_dissipation * motor.stall_torque
    return float(np.clip(min(SLOPE_PART * inertia / slope, STOP_PART * inertia / on_stop), LEAST_STEP, STEP))


@dataclass(frozen=True)
class Drop:
    """A drop from rest with the motors off: the foot ``height`` m above the ground, for ``duration`` s."""

    height: float
    duration: float = 1.0


@dataclass
class _WatchedJump:
    """Data collected during MuJoCo's simulation.

    ``takeoff`` and last ``contact`` : time s, speed m/s, energy J, and until then ``peaks``, torque N m and current A.
    """

    rows: list[tuple[float, ...]] = field(default_factory=list)
    gap: float = 0.0
    peaks: tuple[float, float] = (0.0, 0.0)
    energy: float = 0.0
    highest: float = 0.0
    crossed: bool = False
    takeoff: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)
    contact: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)

    def outcome(self, status: int | None, step: float, touching: float) -> JumpOutcome:
        """Outcome of a jump that ended so; the foot touches the ground at the height ``touching`` (m) or below."""
        trace = np.array(self.rows)
        rise = np.concatenate([[0.0], np.cumsum(0.5 * step * (trace[1:, 4] + trace[:-1, 4]))])
        status = CROSSED if status == LANDED_AGAIN and self.crossed else status
        return JumpOutcome(
            clearance=self.highest if status == LANDED_AGAIN else 0.0,
            rise=rise_of_jump(rise, trace[:, 3], touching),
            takeoff_time=self.takeoff[0],
            takeoff_speed=self.takeoff[1],
            peak_gear_torque=self.takeoff[3],
            peak_current=self.takeoff[4],
            energy=self.takeoff[2],
            peak_normal=float(trace[:, 5].max()),
            limit=LIMITS[TOO_WEAK if status is None else status],
        )


def mujoco_jump(
    leg: HopperLeg,
    motor: Motor,
    contact: Contact,
    model: Model,
    *,
    ground: Ground = "same",
    step: float | None = None,
    drop: Drop | None = None,
) -> MujocoJump:
    """One jump, whose push may take a second, or a drop.

    Raises
    ------
    UserError : MuJoCo is not installed.
    """
    mujoco = require_mujoco()
    step = step or resolved_step(leg, motor)
    model_ = mujoco.MjModel.from_xml_string(mjcf(leg, motor, contact, model, ground, step))
    if drop is not None:
        model_.actuator_biasprm[:] = 0.0
    data = _crouched_data(mujoco, model_, leg, lane(leg, motor, contact, model), None if drop is None else drop.height)
    slope, stall = motor.stall_torque / motor.no_load_speed, motor.stall_torque
    fall = (motor.stall_current - motor.no_load_current) / motor.no_load_speed
    touching = 1e-6 if ground == "same" else 1e-4  # m, of the foot above the ground
    seen, status, knees = _WatchedJump(), None, [f"body_{side}{segments(leg)[2]}" for side in "rl"]
    # That a simulation is lost is judged by its state, see ``_broken``.
    with heard_warnings(mujoco), _passive(mujoco, model_, leg, contact, layout_of(leg).n, ground):
        mujoco.mj_forward(model_, data)
        while data.time < (FLIGHT if drop is None else drop.duration) and status is None:
            foot, foot_v = _foot(mujoco, model_, data)
            speed = _com_speed(mujoco, model_, data)
            normal = _linear_ground(contact, foot, foot_v) if ground == "same" else _own_normal(mujoco, model_, data)
            seen.rows.append((float(data.time), float(data.qpos[0]), float(data.qpos[1]), foot, speed, normal))
            omega = -float(data.qvel[1])
            drawn = 2 * (motor.stall_current - fall * omega) if drop is None else 0.0
            seen.energy += motor.voltage * drawn * step
            if foot <= touching or seen.highest >= LIFTED:  # not of the first lift, below that height
                seen.peaks = (max(seen.peaks[0], abs(stall - slope * omega)), max(seen.peaks[1], abs(drawn)))
            if foot <= touching:
                seen.contact = (float(data.time), speed, seen.energy, *seen.peaks)
            if foot > seen.highest or seen.highest < LIFTED:  # as in the lanes
                seen.takeoff = seen.contact
            seen.highest = max(seen.highest, foot)
            seen.gap = max(seen.gap, float(np.linalg.norm(data.site("foot_r").xpos - data.site("foot_l").xpos)))
            seen.crossed |= bool(data.body(knees[0]).xpos[0] < data.body(knees[1]).xpos[0])
            status = _end_reason(mujoco, data, seen, step, foot_v) if drop is None else _broken(mujoco, data)
            if status is None:
                mujoco.mj_step(model_, data)
    return MujocoJump(seen.outcome(status, step, touching), seen.gap, np.array(seen.rows))


def _end_reason(mujoco: Any, data: Any, seen: _WatchedJump, step: float, foot_v: float) -> int | None:
    """The reason for the jump's end here; None if it continues."""
    *_, foot, speed, _ = seen.rows[-1]
    still = abs(speed) < CREEP and len(seen.rows) > 1 and abs(speed - seen.rows[-2][4]) < 0.5 * step
    if seen.highest > LIFTED and speed < -FALL and (foot_v < 0.0 or foot <= 0.0):
        return LANDED_AGAIN
    lifted, late = seen.highest > LIFTED, data.time >= DURATION
    if data.qpos[0] > 0.0 and lifted and late and foot <= 0.0:
        return LANDED_AGAIN  # as in the lanes: it stands, without ever having fallen so fast
    if data.qpos[0] > 0.0 and not lifted and ((still and data.time > SETTLED and foot <= 0.0) or late):
        return TOO_WEAK  # as in the lanes: it stands, and will not lift off
    return _broken(mujoco, data)


def _broken(mujoco: Any, data: Any) -> int | None:
    """Whether the leg has folded up, or the simulation is lost."""
    if data.qpos[0] <= 0.0:
        return COLLAPSED
    return TOO_STIFF if data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number else None


def _crouched_data(mujoco: Any, model: Any, leg: HopperLeg, z: Array, height: float | None) -> Any:
    """Data of the leg in the crouch of lane ``z`` (n_row,); with ``height``, its foot that far (m) above."""
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
    """Our stop and, if requested, our ground, added at every stage of a step."""
    right, left = model.site("foot_r").id, model.site("foot_l").id
    jacobian, other = np.zeros((3, model.nv)), np.zeros((3, model.nv))

    def add(_: Any, data: Any) -> None:
        angle, rate = data.qpos, data.qvel
        for out, hip in ((1.0, 1), (-1.0, 1 + n)):
            past = leg.extended - out * angle[hip]
            if past > 0.0:
                push = leg.stop_rate * past * max(0.0, 1.0 - leg.stop_dissipation * out * rate[hip])
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
    mujoco.set_mju_user_warning(lambda _: None)  # otherwise it writes a log into the current folder; see the status
    try:
        yield
    finally:
        mujoco.set_mjcb_passive(None)
        mujoco.set_mju_user_warning(warned)
