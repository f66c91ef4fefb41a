"""Servos as MuJoCo's actuators: they follow a command as ours do, and omissions are reported."""

from __future__ import annotations

from dataclasses import replace
from math import radians

import mujoco
import numpy as np
import pytest

from synth.arrays import Array
from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo, ServoSignals
from synth.files.mjcf import mjcf_text
from synth.files.robot_usd import usd_file
from synth.files.robot_xml import urdf_file
from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

MOTOR = GearedMotor(3.5, 0.37 / 200.0, 200.0, 0.9, 4e-8)
POSITION = Servo(gain=2.0, damping_gain=0.05, delay=0.02, duty_limit=0.8, supply=7.4, motor=MOTOR)
UNDAMPED = replace(POSITION, damping_gain=0.0)  # with inductance its controller's damping is negative
PLAIN = Servo(gain=6.0, damping_gain=0.2, torque_limit=1.2)
LINKS = Link(0.12, 0.49, 0.1, 1e-3), Link(0.1, 0.2, 0.05, 3e-4)
TIMES = np.arange(0.0, 2.0 + 1e-9, 5e-4)


def leg(first: Servo, second: Servo | None = None, **effects: dict[str, float]) -> Leg:
    hip = Joint("hip", LINKS[0], drive=first, armature=0.003, damper=Damper(0.01), effects=effects)
    knee = Joint("knee", LINKS[1], sign=-1, zero=0.3, drive=second, damper=Damper(0.02), spring=Spring(0.3, 0.4))
    return Leg("arm", (hip, knee))


def both(built: Leg, command: Array, supply: float = 7.4) -> tuple[Array, Array]:
    """The motion from rest in ours and in the written model, (n_time, 2) rad."""
    volts = np.tile(
        [supply if isinstance(j.drive, Servo) and j.drive.motor else 1.0 for j in built.joints], (len(TIMES), 1)
    )
    signals = ServoSignals(TIMES, command, volts, np.ones_like(volts))
    ours = simulate(built, [0.1, -0.2], [0.0, 0.0], TIMES, tolerance=1e-9, signals=signals)
    model = mujoco.MjModel.from_xml_string(mjcf_text(built, np.full(2, 20.0)))
    data = mujoco.MjData(model)
    data.qpos[:] = 0.1, -0.2
    theirs, driven = np.empty((len(TIMES), 2)), [j for j, one in enumerate(built.joints) if one.drive is not None]
    step = model.opt.timestep
    for index, time in enumerate(TIMES):
        while data.time < time - 0.5 * step:
            moment = [np.interp(data.time + 0.5 * step, TIMES, command[:, j]) for j in driven]
            data.ctrl[:] = moment
            mujoco.mj_step(model, data)
        theirs[index] = data.qpos
    return ours, theirs


def chirp(size: float) -> Array:
    wave = size * np.sin(2 * np.pi * (0.5 * TIMES + 1.0 * TIMES**2))
    return np.column_stack([wave, -0.5 * wave])


@pytest.mark.parametrize(
    ("built", "size"),
    [
        (leg(replace(POSITION, delay=0.0)), 0.8),
        (leg(POSITION), 0.4),
        (leg(PLAIN, PLAIN), 0.5),
        (leg(replace(POSITION, control_period=4e-3, duty_steps=885.0)), 0.4),
        (leg(replace(UNDAMPED, motor=replace(MOTOR, inductance=3.5e-3))), 0.4),
        (leg(POSITION, command_delay={"delay": 0.01}, servo_gain={"share": -0.2}), 0.4),
    ],
    ids=["duty cut off", "delayed", "two joints", "control steps", "inductance", "with what was diagnosed"],
)
def test_mujoco_follows_the_command_within_a_tenth_of_a_degree(built: Leg, size: float) -> None:
    ours, theirs = both(built, chirp(size))
    assert np.ptp(ours, axis=0).min() > 0.1
    assert np.abs(theirs - ours).max() < radians(0.1)


def test_features_that_an_actuator_lacks_are_reported() -> None:
    servo = replace(POSITION, dead_band=0.01, source_resistance=0.5, current_limit=1.0)
    text = mjcf_text(leg(servo), np.full(2, 20.0))
    for part in ("its dead band of 0.01 rad", "the sag of its supply", "the torque limit on the braking"):
        assert f"not in this model, of the drive: {part}" in text


def test_usd_gives_the_servo_its_drive_and_urdf_names_it() -> None:
    free = replace(leg(POSITION), joints=leg(POSITION).joints[:1])
    stiffness = 2.0 * MOTOR.strength * 7.4
    found = usd_file(free, np.full(1, 20.0))
    assert f"physics:stiffness = {stiffness * radians(1.0):.9g}" in found.text
    assert f"physics:maxForce = {0.8 * MOTOR.strength * 7.4:.9g}" in found.text
    assert any("0.02 s late" in text for text in found.warnings)
    assert any("not held: the drive" in text for text in urdf_file(free, np.full(1, 20.0)).warnings)


def test_a_lag_above_the_rotor_s_inertia_is_reported_in_every_format() -> None:
    """A stated inductance without a rotor inertia: the late braking of the winding is as an inertia less than none."""
    built = leg(replace(UNDAMPED, motor=replace(MOTOR, rotor_inertia=0.0, inductance=3.5e-3)))
    bare = replace(built, joints=(replace(built.joints[0], armature=0.0), built.joints[1]))
    lack = f"{-bare.joints[0].with_rotor:.3g} kg*m^2 by which its winding's lag lightens the joint"
    fast = np.full(2, 20.0)
    assert lack in mjcf_text(bare, fast)
    for found in (usd_file(bare, fast), urdf_file(bare, fast)):
        assert any(lack in text for text in found.warnings)
    assert "lightens" not in mjcf_text(built, np.full(2, 20.0))
