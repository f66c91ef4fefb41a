"""The command that a servo follows: sampled, interpolated, or approached at a limited rate."""

from __future__ import annotations

import numpy as np

from synth.planting.model import Array, PlantedServo, ServoInputs
from synth.planting.torque_laws import SAME_TIME

SLEW_STEP = 5e-4  # s, of a command that is approached at a limited rate: 0.01 deg at 1 rad/s is a step's largest error
JUST_BEFORE = 0.01  # of a control period: a command that comes so little after a look counts for it


def followed(inputs: ServoInputs, servo: PlantedServo) -> ServoInputs:
    """With the command that the servo follows: sampled, interpolated, or approached at a limited rate.

    It is in terms of the true angle, see ``PlantedServo.of_true_angle``.
    """
    found = _as_controlled(inputs, servo)
    if servo.seen_scale == 0.0 and servo.seen_offset == 0.0:
        return found
    command = found.command.copy()
    command[:, servo.joint] = (command[:, servo.joint] - servo.seen_offset) / (1.0 + servo.seen_scale)
    return found._replace(command=command)


def _as_controlled(inputs: ServoInputs, servo: PlantedServo) -> ServoInputs:
    """With the command that the servo follows, in terms of the angle that it sees."""
    if servo.control_period > 0.0:
        return _sampled(inputs, servo)
    if servo.linear or servo.command_rate > 0.0:
        return _in_small_steps(inputs, servo)
    return inputs


def _in_small_steps(inputs: ServoInputs, servo: PlantedServo) -> ServoInputs:
    """With the servo's command in steps of ``SLEW_STEP``, each at the middle of what it goes through in them."""
    time = np.arange(inputs.time[0], inputs.time[-1] + SLEW_STEP, SLEW_STEP)
    own = np.interp(time + 0.5 * SLEW_STEP, inputs.time, inputs.command[:, servo.joint])
    if not servo.linear:
        own = _held_at(inputs, servo.joint, time + SAME_TIME)
    if servo.command_rate > 0.0:
        own = _slewed(own, servo.command_rate * SLEW_STEP, 0.5)
    return _with_command(inputs, servo.joint, time, own)


def _sampled(inputs: ServoInputs, servo: PlantedServo) -> ServoInputs:
    """With the command that the servo has from each of its looks to the next.

    Its delay counts in control steps. A fraction of one lies between the two commands, and a command that comes
    ``JUST_BEFORE`` a look or after it counts for that look, as a log's rounded times need it.
    """
    period, first = servo.control_period, servo.first_look
    second = first % period  # a winding's lag may be longer than a period
    looks = np.r_[0.0, np.arange(second if second > SAME_TIME else period, inputs.time[-1] + period, period)]
    if servo.linear:
        own = np.interp(looks - servo.delay, inputs.time, inputs.command[:, servo.joint])
    else:
        whole, part = divmod(max(servo.delay - first, 0.0) / period + 1e-6, 1.0)
        at = looks - first - (whole - JUST_BEFORE) * period
        new, old = (_held_at(inputs, servo.joint, at - late) for late in (0.0, period))
        own = new + max(part - 1e-6, 0.0) * (old - new)
    if servo.command_rate > 0.0:
        own = _slewed(own, servo.command_rate * period, 1.0)
    between = inputs.time[np.abs(inputs.time[:, None] - _nearest(looks, inputs.time)).min(axis=1) > SAME_TIME]
    time = np.union1d(looks, between)
    last = np.searchsorted(looks, time + SAME_TIME, side="right") - 1
    return _with_command(inputs, servo.joint, time, own[np.maximum(last, 0)])


def _nearest(looks: Array, time: Array) -> Array:
    """(m, 2) of ``looks``, the ones before and after each ``time`` (m,)."""
    after = np.clip(np.searchsorted(looks, time), 1, len(looks) - 1)
    return np.stack([looks[after - 1], looks[after]], axis=1)


def _held_at(inputs: ServoInputs, joint: int, time: Array) -> Array:
    """(m,) rad, a joint's command that is held at ``time`` (m,) s; the first before it."""
    last = np.clip(np.searchsorted(inputs.time, time, side="right") - 1, 0, None)
    return np.asarray(inputs.command[last, joint])


def _slewed(goals: Array, most: float, shown: float) -> Array:
    """(m,) rad, a command that comes nearer to each goal by at most ``most``; after the share ``shown`` of each way."""
    now, own = float(goals[0]), np.empty(len(goals))
    for k, goal in enumerate(goals.tolist()):
        move = min(max(goal - now, -most), most)
        own[k] = now + shown * move
        now += move
    return own


def _with_command(inputs: ServoInputs, joint: int, time: Array, own: Array) -> ServoInputs:
    """The inputs at other times (m,) s, with a joint's own command (m,) rad; those of the others are not used."""
    command = np.zeros((len(time), inputs.command.shape[1]))
    command[:, joint] = own

    def between(values: Array) -> Array:
        return np.stack([np.interp(time, inputs.time, column) for column in values.T], axis=1)

    return ServoInputs(time, command, between(inputs.supply), between(inputs.enabled))
