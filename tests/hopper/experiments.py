"""Recordings of the study's three experiments, made by MuJoCo with noise."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from synth.jump.hopper_leg import Contact, HopperLeg, Motor
from synth.jump.jump_models import MODELS
from synth.jump.mujoco_model import mjcf, mujoco_jump

Array = NDArray[np.float64]


@dataclass(frozen=True)
class TrueMotor:
    """Constants at the rotor."""

    resistance: float = 3.9
    inductance: float = 1.2e-3
    back_emf: float = 1.75e-3
    friction: float = 1.6e-4
    viscous: float = 2.0e-8
    rotor_inertia: float = 1.5e-8
    ratio: float = 150.58


def run_up(motor: TrueMotor, voltage: float, duration: float, rng: np.random.Generator, noise: bool = True) -> Array:
    """(n, 4) time, voltage, current, output speed at 2 kHz: the rotor MuJoCo's hinge, the winding exact in a step."""
    step = 1e-5
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{step}" gravity="0 0 0" integrator="implicit"/><worldbody><body><joint name="j" '
        f'axis="0 0 1" damping="{motor.viscous!r}" frictionloss="{motor.friction!r}"/>'
        f'<inertial pos="0 0 0" mass="1" diaginertia="1e-9 1e-9 {motor.rotor_inertia!r}"/></body></worldbody>'
        '<actuator><motor joint="j"/></actuator></mujoco>'.replace("1e-9 1e-9", f"{motor.rotor_inertia!r} " * 2)
    )
    data = mujoco.MjData(model)
    current, rows = 0.0, []
    decay = math.exp(-step * motor.resistance / motor.inductance)
    every = round(5e-4 / step)
    for k in range(int(duration / step)):
        speed = float(data.qvel[0])
        if k % every == 0:
            rows.append((k * step, voltage, current, speed / motor.ratio))
        steady = (voltage - motor.back_emf * speed) / motor.resistance
        current = steady + (current - steady) * decay
        data.ctrl[0] = motor.back_emf * current
        mujoco.mj_step(model, data)
    found = np.array(rows)
    if noise:
        found[:, 1] += rng.normal(0.0, 0.01, len(found))
        found[:, 2] += rng.normal(0.0, 0.01, len(found))
        found[:, 3] += rng.normal(0.0, 0.05, len(found))
    return found


def pull_up(leg: HopperLeg, motor: Motor, torque: float, duration: float, rng: np.random.Generator) -> Array:
    """(n, 3) time, upper link angle, motor torque outward, of a leg hung by its foot, body down, folding; 1 kHz."""
    step = 5e-5
    text = mjcf(leg, motor, Contact(), MODELS["D"], "same", step)
    text = text.replace(f'gravity="0 0 {-leg.gravity!r}"', f'gravity="0 0 {leg.gravity!r}"')  # upside down
    anchor = '<site name="overhead" pos="0 0 0"/>'
    text = text.replace("<worldbody>", f"<worldbody>{anchor}")
    pin = '<connect site1="foot_r" site2="overhead" solref="1e-4 1" solimp="0.9999 0.9999 0.001 0.5 2"/>'
    text = text.replace("</equality>", f"{pin}</equality>")
    text = re.sub(r"<actuator>.*</actuator>", '<actuator><motor joint="r0"/><motor joint="l0"/></actuator>', text)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    start = math.radians(15.0)
    b = leg.lower_angle(start)
    data.qpos[0] = leg.height(start)
    n = (model.nv - 1) // 2
    relative = np.diff([start] * (n - 1) + [-b], prepend=0.0)
    data.qpos[1 : 1 + n], data.qpos[1 + n :] = relative, -relative
    rows = []
    for k in range(int(duration / step)):
        t = k * step
        pull = torque * (0.6 + 0.4 * math.sin(2 * math.pi * 3.0 * t))
        data.ctrl[:] = pull, -pull
        if k % 20 == 0:
            rows.append((t, float(data.qpos[1]), pull))
        mujoco.mj_step(model, data)
    found = np.array(rows)
    found[:, 1] += rng.normal(0.0, math.radians(0.1), len(found))
    found[:, 2] += rng.normal(0.0, 0.002, len(found))
    return found


def plate_jump(leg: HopperLeg, motor: Motor, rng: np.random.Generator) -> Array:
    """(n, 3) time, ground force, upper link angle of model D in MuJoCo at 1 kHz, to shortly after the highest point."""
    jump = mujoco_jump(leg, motor, Contact(), MODELS["D"])
    times = np.arange(0.0, jump.trace[-1, 0], 1e-3)
    force = np.interp(times, jump.trace[:, 0], jump.trace[:, 5]) + rng.normal(0.0, 0.02, len(times))
    angle = np.interp(times, jump.trace[:, 0], jump.trace[:, 2]) + rng.normal(0.0, math.radians(0.1), len(times))
    return np.column_stack([times, force, angle])
