"""The same release in MuJoCo, an independent engine, if installed."""

from __future__ import annotations

import math
from typing import Any
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np

from synth.arrays import Array
from synth.model_checks.checked import ModelCheck
from synth.model_checks.swinging import AWAY, FINE, without_effects
from synth.mujoco_warnings import heard_warnings
from synth.swing.chain import simulate
from synth.swing.leg_model import DamperCurve, Joint, Leg
from synth.swing.mechanics import rest_pose

HOW = 'the other engine: MuJoCo is not installed (pip install "limb-synth[mujoco]")'
STEP = 1e-4  # s, fourth-order Runge-Kutta: half of it changes the built-in leg by less than 1e-6 deg
FINER, ROUNDS = 4, 3  # of the step of a leg that differs: small links and steep dampers need shorter ones
OWN_SHARE = 0.1  # of the limit, by which MuJoCo's results with two steps may differ
LENGTH = 1.0  # s: a few swings; a longer chaotic motion would amplify rounding
LIMIT = math.radians(0.01)  # a tenth of a good encoder's count; both engines lose accuracy at corners of damper curves


def same_release(leg: Leg) -> tuple[list[ModelCheck], list[str]]:
    """Every joint's angle in a release from ``AWAY`` off the equilibrium, by both engines; and what is left out."""
    try:
        import mujoco
    except ImportError:
        return [], [HOW]
    plain = without_effects(leg)
    try:
        pose = rest_pose(plain)
    except ArithmeticError as error:
        return [], [f"the other engine: {error}"]
    start = pose + AWAY
    times = np.arange(0.0, LENGTH + 5e-3, 0.01)
    ours = simulate(plain, start, np.zeros(len(start)), times, tolerance=FINE)
    step, theirs = STEP, _by_mujoco(mujoco, plain, start, times, STEP)
    if np.abs(ours - theirs).max() > LIMIT:
        step, theirs, own = _converged(mujoco, plain, start, times, theirs)
        if own > OWN_SHARE * LIMIT:
            text = f"MuJoCo's own results with steps of {FINER * step:.2g} s and {step:.2g} s differ by up to "
            return [], [f"the other engine: {text}{math.degrees(own):.2g} deg"]
    source = f"MuJoCo {mujoco.__version__}, Runge-Kutta 4, {step:g} s per step, largest difference within {LENGTH:g} s"
    checks = []
    for j, joint in enumerate(leg.joints):
        worst = int(np.argmax(np.abs(ours[:, j] - theirs[:, j])))
        mine, other = (leg.to_measured(motion[worst])[j] for motion in (ours, theirs))
        checks.append(
            ModelCheck("angle by another engine", joint.name, float(other), float(mine), LIMIT, "deg", source)
        )
    return checks, []


def _converged(mujoco: Any, leg: Leg, start: Array, times: Array, coarse: Array) -> tuple[float, Array, float]:
    """A step s with which MuJoCo agrees with itself, its motion (m, n) rad, and the last change by a shorter step."""
    step, change = STEP, math.inf
    for _ in range(ROUNDS):
        step /= FINER
        fine = _by_mujoco(mujoco, leg, start, times, step)
        change, coarse = float(np.abs(fine - coarse).max()), fine
        if change <= OWN_SHARE * LIMIT:
            break
    return step, coarse, change


def _by_mujoco(mujoco: Any, leg: Leg, start: Array, times: Array, step: float) -> Array:
    """(m, n) rad; damper curves through MuJoCo's callback for passive forces, at each of a step's four stages."""
    model = mujoco.MjModel.from_xml_string(_mjcf(leg))
    data = mujoco.MjData(model)
    data.qpos[:] = start
    curves = {j: joint.damper.curve for j, joint in enumerate(leg.joints) if joint.damper and joint.damper.curve}
    out = np.tile(start, (len(times), 1))

    def add(model: Any, data: Any) -> None:
        for j, curve in curves.items():
            data.qfrc_passive[j] -= _torque(curve, float(data.qvel[j]))

    mujoco.set_mjcb_passive(add if curves else None)
    try:
        with heard_warnings(mujoco):  # a motion that diverges is told by its difference
            for sample, interval in enumerate(np.diff(times), start=1):
                count = max(1, math.ceil(interval / step - 1e-9))
                model.opt.timestep = interval / count
                mujoco.mj_step(model, data, nstep=count)
                out[sample] = data.qpos
    finally:
        mujoco.set_mjcb_passive(None)
    return out


def _torque(curve: DamperCurve, rate: float) -> float:
    """Torque against ``rate``: odd, piecewise linear from (0, 0), and on along the last segment if it rises, N m."""
    speed, torque = [0.0, *curve.speed], [0.0, *curve.torque]
    value = abs(rate)
    last = len(speed) - 1
    k = next((i for i in range(1, last) if value < speed[i]), last)
    slope = (torque[k] - torque[k - 1]) / (speed[k] - speed[k - 1])
    value = min(value, speed[last]) if slope < 0.0 else value
    return math.copysign(torque[k - 1] + slope * (value - speed[k - 1]), rate)


def _mjcf(leg: Leg) -> str:
    """The chain with its springs and linear dampers; x to the right, z up, every hinge's axis -y."""
    root = Element("mujoco", model=leg.name)
    SubElement(root, "compiler", angle="radian", inertiafromgeom="false", autolimits="false")
    option = SubElement(root, "option", gravity=f"0 0 {-leg.gravity!r}", integrator="RK4")
    SubElement(option, "flag", contact="disable", constraint="disable", eulerdamp="disable", warmstart="disable")
    parent = SubElement(root, "worldbody")
    height, turned = 0.0, leg.tilt
    for joint in leg.joints:
        link = joint.link
        turn = f"{math.cos(turned / 2)!r} 0 {-math.sin(turned / 2)!r} 0"
        parent = SubElement(parent, "body", pos=f"0 0 {height!r}", quat=turn)
        SubElement(parent, "joint", _hinge(joint))
        inertia = f"{link.inertia!r} {link.inertia!r} {link.inertia!r}"
        SubElement(
            parent, "inertial", pos=f"{link.com_across!r} 0 {-link.com!r}", mass=repr(link.mass), diaginertia=inertia
        )
        height, turned = -link.length, 0.0
    return tostring(root, encoding="unicode")


def _hinge(joint: Joint) -> dict[str, str]:
    """The attributes of MuJoCo's joint."""
    found = {"type": "hinge", "axis": "0 -1 0", "armature": repr(joint.armature), "limited": "false"}
    if joint.spring is not None:
        found |= {"stiffness": repr(joint.spring.rate), "springref": repr(joint.rest)}
    if joint.damper is not None and joint.damper.rate is not None:
        found["damping"] = repr(joint.damper.rate)
    return found
