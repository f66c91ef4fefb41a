"""Compiled torque laws of joints as functions of time, angle, speed and memory; the engine calls them at every stage.

A law consists of a number (below), the coordinate on which it acts, optionally a second coordinate, and up to eight
parameters. Angles are relative to the spring's free angle if the law belongs to a spring, otherwise rotations. The
diagnosing program uses none of these forms. The source is given at each formula.
"""

# mypy: disable-error-code="no-untyped-def,untyped-decorator,no-untyped-call"
from __future__ import annotations

import math

from numba import njit

# Dry friction with true sticking: the engine locks the coordinate; par: sliding torque, static torque, Stribeck speed,
# shape (0: 1 / (1 + (w/ws)^2), 1: exp(-|w|/ws), 2: exp(-(w/ws)^2)).
STICK_SLIP = 1
# LuGre bristles (Canudas de Wit et al., IEEE TAC 40, 1995); par: as above, bristle deflection [rad], micro-damping.
BRISTLES = 2
# Dry friction of a plain bearing, true sticking; par: mu * radius [m], constant part [N m].
BEARING = 3
# Bristle friction on the torque that spring and damper transmit; par: mu, spring rate, free angle, -, deflection [rad].
GEAR_MESH = 4
CROSS = 5  # Cross fluid: b w / (1 + (|w|/wc)^m); par: b, wc, m. The law gives the difference to b w.
PLATEAU = 6  # power law b w (|w|/wc)^(n-1) above wc, b w below; par: b, wc, n
DRAG = 7  # par: a, c, v: -(a |w| w + c w^3)
EYRING = 8  # par: a, w0: -a w0 (sinh(w/w0) - w/w0), Eyring's thermally activated flow less its linear part
TANH_SPRING = 9  # par: k, x0, u0: softening, -k (u0 tanh(u/u0) - u)
QUINTIC_SPRING = 10  # par: c, x0: -c u^5
SINH_SPRING = 11  # par: k, x0, u0: -k (u0 sinh(u/u0) - u)
PIECEWISE_SPRING = 12  # par: k, x0, u1: further rate k beyond |u| > u1
SOFT_ONE_SIDED = 13  # par: dk, x0, width: -dk (u + sqrt(u^2 + width^2) - width) / 2
SHIFTED_ONE_SIDED = 14  # par: dk, x0, shift: -dk max(u - shift, 0)
BOUC_WEN = 15  # par: k1, delta, n, gamma share; z' = w - |w| |z/d|^(n-1) z/d (1-g) - g w |z/d|^n (Wen, 1976)
TWO_MAXWELL = 16  # par: k1, tau1, k2, tau2: Prony series, torque -(k1 z0 + k2 z1), z' = w - z/tau
SLACK = 17  # backlash with a massless arm that loses contact; par: k, x0, half gap, b; memory: arm angle less x0
SLACK_ARM = 18  # the same with an arm of inertia J and Hunt-Crossley flanks; par: k, x0, half gap, b, J, flank, loss
HUNT_CROSSLEY = 19  # par: stiffness, angle, side, exponent, loss: k d^n (1 + c d') (Hunt and Crossley, 1975)
RUBBER_STOP = 20  # par: stiffness, angle, side, depth, damping: k D (exp(d/D) - 1) + c d' (pressing only)
# Not in any library:
CABLE = 21  # spring between two joints (biarticular); par: k, r_i, r_j, x0, one-sided (0/1)
COGGING = 22  # par: a, count a turn, phase
FADING_DAMPER = 23  # par: b, share lost, time constant, time before the release: heats up during a trial
CREEPING_SPRING = 24  # par: k, shift, time constant: free angle creeps within a trial
MAGNET = 25  # par: a, harmonic, phase
RUB_SPOT = 26  # par: a, angle, width: friction felt only near one angle; -a bump(q) tanh(w/0.05)
KNOCKS = 27  # par: torque, period, phase, width: short pulses, as of a tugging cable
DRIVE = 29  # known torque; par: amplitude, angular frequency and phase of each of two sines, offset, delay
DRIVE_TABLE = 30  # known torque as recorded; par: gain, offset, delay, first row of the table, number of rows
# damper as measured; par: linear rate that the chain already has, first row of the table, number of rows
DAMPER_TABLE = 31
SERVO = 32  # position servo; par: first row of its numbers in the table, number of samples of its inputs; memory: heat
SERVO_NUMBERS = 15  # rows of these numbers
# The same with control steps; par: as before, then period, first step and steps of the duty; memories: heat, held duty.
SAMPLED_SERVO = 34
# Dry friction of a servo's gear, true sticking; par: share of the servo's torque, constant part [N m], and those of its
# servo, which the simulation adds: first row, number of samples, and the servo's law + 1 if it has control steps, or 0.
GEAR = 33
LOOSE_SPRING = 28  # par: k, x0, share, time constant: rate falls during the trial (clamp slipping)

STUCK_LAWS = (STICK_SLIP, BEARING, GEAR)
SAME_TIME = 1e-9  # s, rounding of times


@njit
def stribeck_torque(w, weak, strong, speed, shape):
    """Stribeck friction torque at speed ``w``: ``strong`` at rest, ``weak`` at high speed."""
    if strong == weak:
        return weak
    r = abs(w) / speed
    share = 1.0 / (1.0 + r * r) if shape == 0.0 else math.exp(-(r if shape == 1.0 else r * r))
    return weak + (strong - weak) * share


@njit
def spring_torque(law, p, u):
    """Torque of a nonlinear spring, from ``TANH_SPRING`` to ``SHIFTED_ONE_SIDED``, at a deflection ``u`` (rad)."""
    if law == TANH_SPRING:
        return -p[0] * (p[2] * math.tanh(u / p[2]) - u)
    if law == QUINTIC_SPRING:
        return -p[0] * u**5
    if law == SINH_SPRING:
        return -p[0] * (p[2] * math.sinh(u / p[2]) - u)
    if law == PIECEWISE_SPRING:
        over = abs(u) - p[2]
        return -p[0] * math.copysign(over, u) if over > 0.0 else 0.0
    if law == SOFT_ONE_SIDED:
        return -0.5 * p[0] * (u + math.sqrt(u * u + p[2] * p[2]) - p[2])
    return -p[0] * (u - p[2]) if u > p[2] else 0.0


@njit
def stop_torque(law, p, q, w):
    """Torque of a stop, ``HUNT_CROSSLEY`` or ``RUBBER_STOP``; zero before contact."""
    depth = p[2] * (q - p[1])
    if depth <= 0.0:
        return 0.0
    if law == HUNT_CROSSLEY:
        return -p[2] * max(p[0] * depth ** p[3] * (1.0 + p[4] * p[2] * w), 0.0)
    # exp(30): beyond any depth that is reached.
    press = p[0] * p[3] * (math.exp(min(depth / p[3], 30.0)) - 1.0) + p[4] * max(p[2] * w, 0.0)
    return -p[2] * press


@njit
def torque(law, p, table, t, q, w, qj, z0, z1):
    """Torques on the law's coordinate and on its second one, and rates of change of its two memories."""
    if law == CROSS:
        return p[0] * w * (1.0 - 1.0 / (1.0 + (abs(w) / p[1]) ** p[2])), 0.0, 0.0, 0.0
    if law == PLATEAU:
        r = abs(w) / p[1]
        return (p[0] * w * (1.0 - r ** (p[2] - 1.0)) if r > 1.0 else 0.0), 0.0, 0.0, 0.0
    if law == DRAG:
        return -(p[0] * abs(w) * w + p[1] * w * w * w), 0.0, 0.0, 0.0
    if law == EYRING:
        r = w / p[1]
        return -p[0] * p[1] * (math.sinh(r) - r), 0.0, 0.0, 0.0
    if TANH_SPRING <= law <= SHIFTED_ONE_SIDED:
        return spring_torque(law, p, q - p[1]), 0.0, 0.0, 0.0
    if law == BOUC_WEN:
        r = z0 / p[1]
        size = abs(r) ** (p[2] - 1.0)
        rate = w - (1.0 - p[3]) * abs(w) * size * r - p[3] * w * size * abs(r)
        return -p[0] * z0, 0.0, rate, 0.0
    if law == TWO_MAXWELL:
        return -(p[0] * z0 + p[2] * z1), 0.0, w - z0 / p[1], w - z1 / p[3]
    if law == SLACK_ARM:
        y, v = z0, z1
        over = (q - p[1]) - y
        push, depth, closing = 0.0, abs(over) - p[2], math.copysign(1.0, over) * (w - v)
        if depth > 0.0:
            push = math.copysign(max(p[5] * depth**1.5 * (1.0 + p[6] * closing), 0.0), over)  # Hertz: exponent 1.5
        return -push, 0.0, v, (push - p[0] * y - p[3] * v) / p[4]
    if law in (HUNT_CROSSLEY, RUBBER_STOP):
        return stop_torque(law, p, q, w), 0.0, 0.0, 0.0
    if law == DRIVE:
        late = t - p[7]
        return p[0] * math.sin(p[1] * late + p[2]) + p[3] * math.sin(p[4] * late + p[5]) + p[6], 0.0, 0.0, 0.0
    if law == DRIVE_TABLE:
        return p[0] * interpolated(table, int(p[3]), int(p[4]), t - p[2], False) + p[1], 0.0, 0.0, 0.0
    if law == SERVO:
        driven = servo_torque(table, int(p[0]), int(p[1]), t, q, w, z0, z1)
        summed = summing(table, int(p[0]), int(p[1]), t - table[int(p[0]) + 9, 0], q, z1)
        on = interpolated(table, int(p[0]) + SERVO_NUMBERS + 2 * int(p[1]), int(p[1]), t, False)
        return driven, 0.0, warming(table, int(p[0]), driven, z0), on * summed
    if law == SAMPLED_SERVO:
        driven = winding_torque(table, int(p[0]), int(p[1]), t, w, z0, z1)
        return driven, 0.0, warming(table, int(p[0]), driven, z0), 0.0
    if law == DAMPER_TABLE:
        return p[0] * w - math.copysign(interpolated(table, int(p[1]), int(p[2]), abs(w), True), w), 0.0, 0.0, 0.0
    return unlisted_torque(law, p, t, q, w, qj)


@njit
def warming(table, first, driven, warm):
    """Rate of change of the growth ``warm`` of a servo's winding, whose loss is its resistance times current^2."""
    if table[first + 10, 0] == 0.0:
        return 0.0
    share = driven / table[first + 11, 0]
    return (table[first + 10, 0] * share * share * (1.0 + warm) - warm) / table[first + 12, 0]


@njit
def servo_torque(table, first, count, t, q, w, warm, summed):
    """Torque of a servo whose numbers are the rows from ``first`` on, in the order of ``model.PlantedServo``.

    ``warm`` : growth of its winding's resistance (a share); ``summed`` : duty of its integral.
    """
    duty = servo_duty(table, first, count, t - table[first + 9, 0], q, w, summed)
    return winding_torque(table, first, count, t, w, warm, duty)


@njit
def beyond_band(table, first, count, told, q):
    """Error outside the dead band, rad, from the command held at the time ``told``."""
    error = held_row(table, first + SERVO_NUMBERS, count, told) - q
    return math.copysign(max(abs(error) - table[first + 2, 0], 0.0), error)


@njit
def summing(table, first, count, told, q, summed):
    """Rate of change of the integral's duty ``summed``, which stops at its limit."""
    rate = table[first + 13, 0] * beyond_band(table, first, count, told, q)
    full = abs(summed) >= table[first + 14, 0]
    return 0.0 if full and rate * summed >= 0.0 else rate


@njit
def servo_duty(table, first, count, told, q, w, summed):
    """Duty that the servo sets for the command held at the time ``told``."""
    most = table[first + 14, 0]
    duty = table[first, 0] * beyond_band(table, first, count, told, q) - table[first + 1, 0] * w
    duty += min(max(summed, -most), most)
    return min(max(duty, -table[first + 3, 0]), table[first + 3, 0]) + table[first + 4, 0]


@njit
def look(p, table, t, q, w, summed, since):
    """Duty that a servo with control steps sets at one of them, the time of the next, and the duty of its integral.

    ``p`` of its law; ``summed`` : that duty before; ``since`` s of the controller's time that it adds: none at first.
    """
    first, count = int(p[0]), int(p[1])
    on = interpolated(table, first + SERVO_NUMBERS + 2 * count, count, t, False)
    limit = table[first + 14, 0]
    summed += on * since * table[first + 13, 0] * beyond_band(table, first, count, t + SAME_TIME, q)
    summed = min(max(summed, -limit), limit)
    duty = servo_duty(table, first, count, t + SAME_TIME, q, w, summed)
    if p[4] > 0.0:
        most = table[first + 3, 0]
        duty = min(max(math.floor(duty * p[4] + 0.5) / p[4], -most), most)
    return duty, p[3] + (math.floor((t - p[3]) / p[2] + 1e-6) + 1.0) * p[2], summed


@njit
def winding_torque(table, first, count, t, w, warm, duty):
    """Torque of the servo's motor at a duty."""
    start = first + SERVO_NUMBERS
    supply = interpolated(table, start + count, count, t, False)
    driven = table[first + 5, 0] * duty * supply - table[first + 6, 0] * w
    driven = driven / (1.0 + warm + table[first + 8, 0] * duty * duty)
    most = table[first + 7, 0]
    return interpolated(table, start + 2 * count, count, t, False) * min(max(driven, -most), most)


@njit
def held_row(table, first, count, x):
    """The last value not after ``x`` in rows ``first`` to ``first + count - 1`` of ``table``; else the first."""
    return table[last_row(table, first, first + count, x), 1]


@njit
def last_row(table, low, high, x):
    """The last row from ``low`` to ``high - 1`` of ``table`` whose first column is at most ``x``; else ``low``."""
    while high - low > 1:
        middle = (low + high) // 2
        if table[middle, 0] <= x:
            low = middle
        else:
            high = middle
    return low


@njit
def interpolated(table, first, count, x, extrapolate):
    """Linear interpolation in rows ``first`` to ``first + count - 1`` of ``table``.

    Before the first row the value is constant. After the last row it is constant, or linearly extrapolated if
    ``extrapolate`` and the last two rows do not fall: a damper's torque held there never drives.
    """
    low, high = first, first + count - 1
    if x <= table[low, 0]:
        return table[low, 1]
    if x >= table[high, 0]:
        if not extrapolate or table[high, 1] < table[high - 1, 1]:
            return table[high, 1]
        low = high - 1
    low = last_row(table, low, high, x)
    high = low + 1
    share = (x - table[low, 0]) / (table[high, 0] - table[low, 0])
    return table[low, 1] + share * (table[high, 1] - table[low, 1])


@njit
def unlisted_torque(law, p, t, q, w, qj):
    """Torques of the laws that no library of usual effects contains."""
    if law == CABLE:
        u = p[1] * q + p[2] * qj - p[3]
        pull = 0.0 if (p[4] > 0.5 and u < 0.0) else p[0] * u
        return -p[1] * pull, -p[2] * pull, 0.0, 0.0
    if law in (COGGING, MAGNET):
        return p[0] * math.sin(p[1] * q + p[2]), 0.0, 0.0, 0.0
    if law == FADING_DAMPER:
        return p[0] * p[1] * (1.0 - math.exp(-(t + p[3]) / p[2])) * w, 0.0, 0.0, 0.0
    if law == CREEPING_SPRING:
        return p[0] * p[1] * (1.0 - math.exp(-t / p[2])), 0.0, 0.0, 0.0
    if law == RUB_SPOT:
        return -p[0] * math.exp(-(((q - p[1]) / p[2]) ** 2)) * math.tanh(w / 0.05), 0.0, 0.0, 0.0
    if law == KNOCKS:
        r = ((t + p[2]) % p[1]) / p[3]
        return (p[0] * math.sin(math.pi * r) if r < 1.0 else 0.0), 0.0, 0.0, 0.0
    if law == LOOSE_SPRING:
        return p[0] * (q - p[1]) * p[2] * (1.0 - math.exp(-t / p[3])), 0.0, 0.0, 0.0
    return 0.0, 0.0, 0.0, 0.0
