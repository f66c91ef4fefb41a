"""One or two links held by position servos, stepped as servo firmware and a rigid body would: for blind cases alone.

Independent of the diagnosing program: fixed steps of ``STEP`` with torques at their middle, friction as the torque
that would stop the joint within a step, cut off at its budget (as in Duclusaud et al., BAM, arXiv 2410.08650, section
III.C), the controller at its own period with the command held between (no interpolation), the winding at steady
current. Play of a gear has rigid flanks: blows by Newton's restitution, then rotor and link as one body until their
contact would have to pull.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
STEP = 1e-4  # s; within 0.0005 deg RMS of the program's engine with each command held (tests/blind/test_servos.py)
PERIOD = 1  # steps between two samples of the controller: 10 kHz
# Columns a joint. Link: length, mass, com, inertia about it. Servo: duty a radian, duty s a radian, largest duty,
# torque constant, resistance, largest current, dead band, delay of the command, rotor's inertia. Friction: dry, more at
# rest, speed over which that falls, its power, share of the motor's torque, share of the load's, viscous. What is in no
# library: cogging torque, cogs a turn, integral gain, s over which the controller smooths the command; and in it, the
# rate to which the controller limits the command (0: none).
LINK = ("length", "mass", "com", "inertia")
SERVO = ("gain", "damping", "duty", "constant", "resistance", "current", "dead", "delay", "rotor")
FRICTION = ("dry", "rest", "speed", "power", "of_motor", "of_load", "viscous")
OTHER = ("rate", "cogging", "cogs", "integral", "smooth")
# Winding: growth of its resistance in the end at a torque of ``reference``, two thirds of it after ``warming`` s.
HEAT = ("rise", "reference", "warming")
# Play of the gear, rad, and on which side of it the recorded angle and the controller's are read (1: the link's).
GEAR = ("play", "read_beyond", "controlled_beyond")
# The servo's own encoder, which is recorded: shift, rad, and scale error about the command 0.
ENCODER = ("shift", "scaled")
COLUMNS = (*LINK, *SERVO, *FRICTION, *OTHER, *HEAT, *GEAR, *ENCODER)
RESTITUTION = 0.3  # of a blow of the flanks
STILL = 2e-3  # rad/s: after a blow with less, the flanks stay together
FREE, LOCKED = 0, 2  # of a joint's mode: within the play, without play; -1 and 1: at a flank
AT = {name: k for k, name in enumerate(COLUMNS)}


class Rig(NamedTuple):
    """``joints`` (n, column) and the ohms of the source."""

    joints: Array
    source: float

    def changed(self, joint: int, **values: float) -> Rig:
        """With other numbers at one joint."""
        joints = self.joints.copy()
        for name, value in values.items():
            joints[joint, AT[name]] = value
        return Rig(joints, self.source)


def shown_as(effect: str, joint: int, n: int) -> list[tuple[str, int]]:
    """A cause that was put at one of ``n`` joints, and what it cannot be told from: (effect, joint), itself first.

    One source feeds all joints: of several it is the whole leg's (joint -1, its base). One joint alone read late is as
    its command late: from rest the whole motion is later. A shifted encoder by which the first joint's servo controls
    tilts the whole leg, unseen, as a base that is not level does.
    """
    if effect == "voltage_sag" and n > 1:
        return [("shared_source_resistance", -1)]
    if effect == "encoder_offset" and joint == 0:
        return [(effect, joint), ("base_tilt", -1)]
    return [(effect, joint), *([("latency", joint)] if effect == "command_delay" and n == 1 else [])]


def follow(rig: Rig, times: Array, command: Array, supply: float) -> Array:
    """(m, n) rad at ``times`` (m,) s, evenly spaced, of a rig told ``command`` (m, n) rad from rest at its first."""
    return np.asarray(_follow(rig.joints, rig.source, times, np.ascontiguousarray(command), supply))


@njit(cache=True)
def _follow(joints, source, times, command, supply):  # type: ignore[no-untyped-def]
    n, count = joints.shape[0], len(times)
    spacing = times[1] - times[0]
    per = max(round(spacing / STEP), 1)
    h = spacing / per
    q, w = (command[0] - joints[:, 31]) / (1.0 + joints[:, 32]), np.zeros(n)
    duty, wound, slewed, smooth = np.zeros(n), np.zeros(n), command[0].copy(), command[0].copy()
    motor, load, warm = np.zeros(n), np.zeros(n), np.zeros(n)
    qm, wm, before = q.copy(), w.copy(), w.copy()  # in the middle of a step; rates at the end of the one before
    mode, rotor, turning = _at_rest(joints, q)
    rm, tm, ago = rotor.copy(), turning.copy(), turning.copy()  # the same of the rotors
    seen, rate = np.zeros(n), np.zeros(n)
    out = np.empty((count, n))
    for i in range(count):
        for j in range(n):
            shown = q[j] if mode[j] == LOCKED or joints[j, 29] > 0.0 else rotor[j]
            out[i, j] = shown * (1.0 + joints[j, 32]) + joints[j, 31]
        for s in range(per if i < count - 1 else 0):
            now = i * spacing + s * h
            for j in range(n):
                qm[j] = q[j] + 0.5 * h * w[j]
                wm[j] = w[j] + 0.5 * (w[j] - before[j])
                before[j] = w[j]
                rm[j] = rotor[j] + 0.5 * h * turning[j]
                tm[j] = turning[j] + 0.5 * (turning[j] - ago[j])
                ago[j] = turning[j]
                own = mode[j] == LOCKED or joints[j, 30] > 0.0
                seen[j], rate[j] = (qm[j], wm[j]) if own else (rm[j], tm[j])
                seen[j] = seen[j] * (1.0 + joints[j, 32]) + joints[j, 31]
                rate[j] *= 1.0 + joints[j, 32]
                if mode[j] == LOCKED:
                    rm[j], tm[j] = qm[j], wm[j]
            if (i * per + s) % PERIOD == 0:
                for j in range(n):
                    p = joints[j]
                    k = min(max(int((now - p[11]) / spacing + 1e-6), 0), count - 1)
                    wanted = command[k, j]
                    if p[20] > 0.0:  # in the middle of the step, as all that acts in it
                        most = p[20] * PERIOD * h
                        moved = min(max(wanted - slewed[j], -most), most)
                        wanted = slewed[j] + 0.5 * moved
                        slewed[j] += moved
                    if p[24] > 0.0:
                        smooth[j] += PERIOD * h / p[24] * (wanted - smooth[j])
                        wanted = smooth[j]
                    error = wanted - seen[j]
                    error -= min(max(error, -p[10]), p[10])
                    wound[j] = min(max(wound[j] + p[23] * error * PERIOD * h, -p[6]), p[6])
                    duty[j] = min(max(p[4] * error - p[5] * rate[j] + wound[j], -p[6]), p[6])
            _torques(joints, source, supply, duty, qm, rm, tm, motor, load, warm, h)
            _step(joints, h, q, w, qm, wm, motor, load, mode, rotor, turning, rm, tm)
    return out


@njit(cache=True)
def _at_rest(joints, q):  # type: ignore[no-untyped-def]
    """Modes, and the rotors' angles and rates at the start: with play each link hangs at a flank.

    ``q`` is what the encoders read; it becomes the links' angles.
    """
    n = len(q)
    mode, rotor, load = np.full(n, LOCKED), q.copy(), np.zeros(n)
    _weight(joints, q, load)
    for j in range(n):
        play = joints[j, 28]
        if play > 0.0:
            mode[j] = 1 if load[j] > 0.0 else -1
            if joints[j, 29] > 0.0:
                rotor[j] = q[j] - mode[j] * 0.5 * play
            else:
                q[j] = rotor[j] + mode[j] * 0.5 * play
    return mode, rotor, np.zeros(n)


@njit(cache=True)
def _torques(joints, source, supply, duty, q, rotor, w, motor, load, warm, h):  # type: ignore[no-untyped-def]
    """Motors' torques and gravity's, and the growth of the windings' resistances after h s, in place.

    ``rotor`` rad and ``w`` rad/s of the rotors.
    """
    volts = _behind_source(joints, source, supply, duty, w, warm)
    for j in range(len(q)):
        p = joints[j]
        current = (duty[j] * volts - p[7] * w[j]) / (p[8] * (1.0 + warm[j]))
        current = min(max(current, -p[9]), p[9])
        motor[j] = p[7] * current
        if p[25] != 0.0:
            warm[j] += h / p[27] * (p[25] * (motor[j] / p[26]) ** 2 * (1.0 + warm[j]) - warm[j])
        if p[21] != 0.0:
            motor[j] += p[21] * math.sin(p[22] * rotor[j])
    _weight(joints, q, load)


@njit(cache=True)
def _weight(joints, q, load):  # type: ignore[no-untyped-def]
    """Torques of gravity, in place."""
    g = 9.81
    if len(q) == 1:
        load[0] = -joints[0, 1] * g * joints[0, 2] * math.sin(q[0])
    else:
        far = joints[1, 1] * g * joints[1, 2] * math.sin(q[0] + q[1])
        near = (joints[0, 1] * joints[0, 2] + joints[1, 1] * joints[0, 0]) * g * math.sin(q[0])
        load[0], load[1] = -near - far, -far


@njit(cache=True)
def _behind_source(joints, source, supply, duty, w, warm):  # type: ignore[no-untyped-def]
    """V that all joints get, by bisection: what the source carries is the power that the windings take, over it.

    A limit of a winding's current lowers the voltage that it takes, not the current alone.
    """
    if source == 0.0:
        return supply
    low, high = 0.05 * supply, 4.0 * supply
    for _ in range(45):
        volts, drawn = 0.5 * (low + high), 0.0
        for j in range(len(duty)):
            p = joints[j]
            ohms = p[8] * (1.0 + warm[j])
            current = min(max((duty[j] * volts - p[7] * w[j]) / ohms, -p[9]), p[9])
            drawn += current * (ohms * current + p[7] * w[j]) / volts
        if volts + source * drawn > supply:
            high = volts
        else:
            low = volts
    return 0.5 * (low + high)


@njit(cache=True)
def _step(joints, h, q, w, qm, wm, motor, load, mode, rotor, turning, rm, tm):  # type: ignore[no-untyped-def]
    """One step of h s in place. A joint within its play moves link and rotor apart; else the rotor is of the link."""
    n = len(q)
    held = np.zeros(n)  # torque of friction on what turns with the link
    faster = np.zeros(n)
    if n == 1:
        p = joints[0]
        inertia = p[3] + p[1] * p[2] * p[2]
        acting = load[0]
        if mode[0] != FREE:
            inertia += p[12]
            acting += motor[0]
            held[0] = _friction(p, acting, inertia, motor[0], load[0], w[0], wm[0], h)
            acting += held[0]
        faster[0] = acting / inertia
        _advance(joints, h, q, w, qm, faster, held, motor, load, mode, rotor, turning, rm, tm)
        if joints[0, 28] > 0.0:
            _meet(0, 1.0 / (p[3] + p[1] * p[2] * p[2]), 0.0, joints, q, w, mode, rotor, turning)
        return
    a, b = joints[0], joints[1]
    c = b[1] * a[0] * b[2]
    far = b[3] + b[1] * b[2] * b[2]
    near = a[3] + a[1] * a[2] * a[2] + b[1] * a[0] * a[0] + far + 2.0 * c * math.cos(qm[1])
    m11 = near + (a[12] if mode[0] != FREE else 0.0)
    m12 = far + c * math.cos(qm[1])
    m22 = far + (b[12] if mode[1] != FREE else 0.0)
    bend = c * math.sin(qm[1])
    f0 = load[0] + bend * (2.0 * wm[0] * wm[1] + wm[1] * wm[1]) + (motor[0] if mode[0] != FREE else 0.0)
    f1 = load[1] - bend * wm[0] * wm[0] + (motor[1] if mode[1] != FREE else 0.0)
    det = m11 * m22 - m12 * m12
    # Joint by joint, each with the other's latest friction: four rounds settle what sticks.
    for _ in range(4):
        if mode[0] != FREE:
            seen = f0 - m12 / m22 * (f1 + held[1])
            held[0] = _friction(a, seen, det / m22, motor[0], load[0], w[0], wm[0], h)
        if mode[1] != FREE:
            seen = f1 - m12 / m11 * (f0 + held[0])
            held[1] = _friction(b, seen, det / m11, motor[1], load[1], w[1], wm[1], h)
    faster[0] = (m22 * (f0 + held[0]) - m12 * (f1 + held[1])) / det
    faster[1] = (m11 * (f1 + held[1]) - m12 * (f0 + held[0])) / det
    _advance(joints, h, q, w, qm, faster, held, motor, load, mode, rotor, turning, rm, tm)
    if a[28] > 0.0:
        m = far + (b[12] if mode[1] != FREE else 0.0)
        det = near * m - m12 * m12
        _meet(0, m / det, -m12 / det, joints, q, w, mode, rotor, turning)
    if b[28] > 0.0:
        m = near + (a[12] if mode[0] != FREE else 0.0)
        det = m * far - m12 * m12
        _meet(1, m / det, -m12 / det, joints, q, w, mode, rotor, turning)


@njit(cache=True)
def _advance(  # type: ignore[no-untyped-def]
    joints, h, q, w, qm, faster, held, motor, load, mode, rotor, turning, rm, tm
):
    """Move links by their accelerations, ``faster`` rad/s^2, and rotors; a flank that would have to pull lets go."""
    for j in range(len(q)):
        p = joints[j]
        w[j] += h * faster[j]
        q[j] = qm[j] + 0.5 * h * w[j]
        if mode[j] == FREE:
            rubbed = _friction(p, motor[j], p[12], motor[j], load[j], turning[j], tm[j], h)
            turning[j] += h * (motor[j] + rubbed) / p[12]
            rotor[j] = rm[j] + 0.5 * h * turning[j]
        elif mode[j] != LOCKED:
            turning[j] = w[j]
            rotor[j] = q[j] - mode[j] * 0.5 * p[28]
            from_link = p[12] * faster[j] - motor[j] - held[j]
            if mode[j] * from_link < 0.0:
                mode[j] = FREE


@njit(cache=True)
def _meet(j, own, other, joints, q, w, mode, rotor, turning):  # type: ignore[no-untyped-def]
    """A blow where rotor and link have met: ``own``, ``other`` rad/s that each joint's link gains by 1 N m s there."""
    p = joints[j]
    apart = q[j] - rotor[j]
    side = 1 if apart > 0.0 else -1
    closing = side * (w[j] - turning[j])
    if mode[j] != FREE or side * apart < 0.5 * p[28] or closing <= 0.0:
        return
    blow = -side * (1.0 + RESTITUTION) * closing / (own + 1.0 / p[12])
    w[j] += own * blow
    if len(w) > 1:
        w[1 - j] += other * blow
    turning[j] -= blow / p[12]
    if RESTITUTION * closing < STILL:
        mode[j] = side
        turning[j] = w[j]
        rotor[j] = q[j] - side * 0.5 * p[28]


@njit(cache=True)
def _friction(p, acting, inertia, motor, load, w, wm, h):  # type: ignore[no-untyped-def]
    """Torque of friction: what would stop the joint within the step, cut off at its budget at the rate ``wm``."""
    budget = p[13] + abs(p[17] * motor - p[18] * load) + p[19] * abs(wm)
    if p[14] != 0.0:  # the power takes half of a step's time
        budget += p[14] * math.exp(-((abs(wm) / p[15]) ** p[16]))
    stopping = inertia / h * w + acting
    return -math.copysign(min(abs(stopping), budget), stopping)
