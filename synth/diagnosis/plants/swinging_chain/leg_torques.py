"""Torques that a leg exerts along a recorded motion: springs, dampers, effects of its file, drives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.drives.servo import OF_THE_LAW, Servo, ServoSignals, integral_along
from synth.fit.recordings import Recording
from synth.motion.smoothing import Smoothed, odd_points, savitzky_golay
from synth.swing.chain import Conditions
from synth.swing.damper_curves import torque_at
from synth.swing.effect_directions import in_rotation
from synth.swing.effects import Effect, effect_named
from synth.swing.effects.torque_along_motion import AlongMotion, torque_along
from synth.swing.integral_starts import held_integrals
from synth.swing.known_torque import average_torques, delay_torques
from synth.swing.lane_layout import SERVO
from synth.swing.leg_lanes import LegLanes
from synth.swing.leg_model import Damper, Joint, Leg
from synth.swing.mechanics import absolute


def acting_torques(leg: Leg, recording: Recording) -> Array:
    """(n_time, n) N m on q that the leg's joints exert along the smoothed motion, as the simulation has them.

    Springs, dampers, known torques, servos, and of the effects in the leg file the torques and the errors of drives. A
    common source and a limited rate of a command are left out; effects of structure and reading are none of a torque.
    """
    smoothed = recording.smoothed
    driven = driving_torques(leg, recording)
    torque = joint_torques(leg, smoothed.angle, smoothed.rate)
    if driven is not None:
        torque += driven
    forces = None
    for j, joint in enumerate(leg.joints):
        for name, given in joint.effects.items():
            effect = effect_named(name)
            if effect.way != "torque":
                continue
            if effect.uses_load and forces is None:
                forces = bearing_forces(leg, smoothed, recording.conditions)
            force = np.zeros(len(smoothed.time)) if forces is None else forces[:, j]
            if effect.uses_drive:
                force = np.zeros(len(smoothed.time)) if driven is None else driven[:, j]
            angle, rate = smoothed.angle[:, j], smoothed.rate[:, j]
            spring = joint.spring.rate if joint.spring is not None else 0.0
            damper = (joint.damper.rate or 0.0) if joint.damper is not None else 0.0
            resisting = _damper_torque(joint.damper, rate)
            motion = AlongMotion(smoothed.time, angle, rate, angle - joint.rest, spring, damper, resisting, force)
            torque[:, j] += torque_along(effect, motion, in_rotation(effect, joint.sign, joint.zero, given))
    return torque


def joint_torques(leg: Leg, angle: Array, rate: Array) -> Array:
    """(n_time, n) N m of springs and dampers along a motion; effects of the leg file are not included."""
    torque = np.zeros_like(angle)
    for j, joint in enumerate(leg.joints):
        spring = joint.spring.rate if joint.spring else 0.0
        torque[:, j] -= spring * (angle[:, j] - joint.rest) + _damper_torque(joint.damper, rate[:, j])
    return torque


def _damper_torque(damper: Damper | None, rate: Array) -> Array:
    """(n_time,) N m of a damper, which resists positive rates."""
    if damper is not None and damper.curve is not None:
        return torque_at(damper.curve, rate)
    return ((damper.rate or 0.0) if damper is not None else 0.0) * rate


def driving_torques(leg: Leg, recording: Recording) -> Array | None:
    """(n_time, n) N m on q of known torques and servos, with the errors that the leg file states; None without both."""
    effects = [effect_named(name) for joint in leg.joints for name in joint.effects]
    if not recording.driven or not any(effect.way == "drive" or _warms_winding(effect) for effect in effects):
        return recording.known_force(leg)
    legs, torque = LegLanes.of(leg), np.zeros_like(recording.smoothed.angle)
    if recording.known_torque is not None:
        gain, offset, delay = legs.drive[:, :, 0]
        times, known = recording.known_torque
        torque += average_torques(delay_torques((times, (1.0 + gain) * known + offset), delay), recording.smoothed.time)
    if recording.signals is not None:
        torque += _servo_torques(leg, legs.servo_numbers()[:, :, 0], recording.signals, recording)
    return torque


def _servo_torques(leg: Leg, numbers: Array, signals: ServoSignals, recording: Recording) -> Array:
    """(n_time, n) N m on q of servos with these ``numbers`` (17, n), in the order of ``SERVO``."""
    from synth.drives.servo_law import servo_torque  # with numba, see ``Servo.torque``

    along = np.vectorize(servo_torque.py_func, otypes=[float])
    smoothed, conditions = recording.smoothed, recording.conditions
    command, supply, enabled = signals.at(smoothed.time, numbers[SERVO.index("servo_delay")])
    torque = np.zeros_like(smoothed.angle)
    starts = held_integrals(leg, conditions.tip, conditions.tilt, smoothed.angle[0], supply[0])
    for j, joint in enumerate(leg.joints):
        if isinstance(joint.drive, Servo):
            error, law = command[:, j] - smoothed.angle[:, j], numbers[:OF_THE_LAW, j].tolist()
            inputs = [error, smoothed.rate[:, j], supply[:, j], enabled[:, j]]
            warm = _winding_resistance(joint, smoothed.time, inputs, law)
            integral = integral_along(smoothed.time, error, enabled[:, j], numbers[:, j], starts[j])
            torque[:, j] = along(*inputs, *law, warm, integral)
    return torque


def _warms_winding(effect: Effect) -> bool:
    return effect.uses_drive == "warms its winding"


def _winding_resistance(joint: Joint, time: Array, inputs: Sequence[Array], law: Sequence[float]) -> Array:
    """(m,) resistance of a joint's winding over the stated one, by Euler's method from sample to sample.

    ``inputs``, ``law`` : arguments of ``servo_torque``. A winding warms in seconds to minutes.
    """
    from synth.drives.servo_law import servo_torque  # with numba, see ``Servo.torque``

    warm = np.ones(len(time))
    for effect in (found for found in map(effect_named, joint.effects) if _warms_winding(found)):
        given = in_rotation(effect, joint.sign, joint.zero, joint.effects[effect.name])
        grows: Any = effect.function()
        memory = 0.0
        for i in range(1, len(time)):
            drive = servo_torque.py_func(*(values[i - 1] for values in inputs), *law, 1.0 + memory)
            _, change = grows.py_func(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, drive, memory, *given)
            memory = max(memory + (time[i] - time[i - 1]) * change, 0.0)
            warm[i] = 1.0 + memory
    return warm


def bearing_forces(leg: Leg, smoothed: Smoothed, conditions: Conditions) -> Array:
    """(n_time, n) N in each hinge: weight and inertial force of all that is outboard (Newton's law), tip included.

    The rate is smoothed once more before its derivative is taken, by polynomials as wide as its own: differences from
    sample to sample amplify the noise, by the sampling's frequency, until it decides the greatest force of a swing.
    """
    phi, omega = absolute(smoothed.angle, leg.tilt + conditions.tilt), np.cumsum(smoothed.rate, axis=1)
    step = float(smoothed.time[1] - smoothed.time[0])
    points = min(odd_points(smoothed.width, step), len(phi) // 2 * 2 - 1)
    even, _, _ = savitzky_golay(omega, points, 3, step)
    turning = savitzky_golay(even, points, 3, step)[1]
    sine, cosine = np.sin(phi), np.cos(phi)
    # Of a point at distance 1 on each link, and of one beside it, against the hinge: horizontal, upward acceleration.
    there = np.stack([turning * cosine - omega**2 * sine, turning * sine + omega**2 * cosine])
    beside = np.stack([-there[1], there[0]])
    force, hinge = np.zeros((2, *phi.shape)), np.zeros((2, len(phi)))
    up = np.array([0.0, leg.gravity])[:, None]
    for j, joint in enumerate(leg.joints):
        centre = joint.link.com * there[:, :, j] + joint.link.com_across * beside[:, :, j]
        own = joint.link.mass * (hinge + centre + up)
        if j == len(leg.joints) - 1:
            reach = float(conditions.tip.place(joint.link.length))
            own += conditions.tip.mass * (hinge + reach * there[:, :, j] + up)
        force[:, :, : j + 1] += own[:, :, None]
        hinge = hinge + joint.link.length * there[:, :, j]
    return np.asarray(np.hypot(force[0], force[1]))
