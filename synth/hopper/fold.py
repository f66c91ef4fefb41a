"""Inverted pull-ups of many legs at once: the equation of ``identify_damping`` in closed form, compiled.

    M a'' + M' a'^2 / 2 + V' = 2 tau - b D a',   D = 2 + 2 (1 + db/da)^2 + (2 db/da)^2

with rigid links, and the leg's stop at full extension; a and b are the angles of upper and lower links, tau is a
motor's torque on its upper link, outward positive, as recorded, so motor and gear do not appear; D sums the squared
rates of the five joints. Fourth-order Runge-Kutta, steps of at most ``STEP``.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.compiling.compiled import compiled_when_called
from synth.jump.hopper_leg import HopperLeg
from synth.jump.jump_lanes import JumpLanes

STEP = 1e-3  # s; recordings of 1 kHz take one step per sample
FASTEST = 300.0  # rad/s; keeps a diverging guess finite
NAMES = (
    "length", "lower_length", "hip_spacing", "body_mass", "mass_per_length", "flexure_rate", "joint_damping",
    "hip_rest", "knee_rest", "foot_rest", "gravity", "extended", "stop_rate", "stop_dissipation",
)  # fmt: skip
_options: dict[str, Any] = {"error_model": "numpy", "nogil": True}


@compiled_when_called(**_options)
def _mechanics(a, p):  # type: ignore[no-untyped-def]
    """M, M'/2, V' and D at an angle."""
    length, lower, spacing, body, density, rate = p[0], p[1], p[2], p[3], p[4], p[5]
    s, c = math.sin(a), math.cos(a)
    # The lower link nearly level, where it locks.
    sine = min(0.9999, max(-0.9999, (0.5 * spacing + length * s) / lower))
    b, cb = math.asin(sine), math.sqrt(1.0 - sine * sine)
    db = length * c / (lower * cb)
    ddb = (-length * s + lower * sine * db * db) / (lower * cb)
    upper_mass, lower_mass = density * length, density * lower
    bent = -lower * (cb * db * db + sine * ddb)
    dy, ddy = -length * s - lower * sine * db, -length * c + bent  # hips from the foot
    uy, ddu = -0.5 * length * s - lower * sine * db, -0.5 * length * c + bent  # an upper link's middle
    ux, ddx = 0.5 * length * c, -0.5 * length * s
    turn = upper_mass * length * length / 12.0
    inertia = body * dy * dy + 2.0 * (upper_mass * (uy * uy + ux * ux) + turn)
    inertia += 2.0 * lower_mass * lower * lower / 3.0 * db * db
    slope = body * dy * ddy + 2.0 * upper_mass * (uy * ddu + ux * ddx) + 2.0 * lower_mass * lower**2 / 3.0 * db * ddb
    force = -p[10] * (body * dy + 2.0 * upper_mass * uy - lower_mass * lower * sine * db)
    force += 2.0 * rate * (a - p[7] + (a + b - p[8]) * (1.0 + db)) + rate * (2.0 * b - p[9]) * 2.0 * db
    joints = 2.0 + 2.0 * (1.0 + db) ** 2 + 4.0 * db * db
    return inertia, slope, force, joints


@compiled_when_called(**_options)
def _acceleration(a, w, tau, p):  # type: ignore[no-untyped-def]
    inertia, slope, force, joints = _mechanics(a, p)
    past = max(0.0, p[11] - a)  # the leg's stop, as in ``jump_source``
    force -= 2.0 * p[12] * past * max(0.0, 1.0 - p[13] * w)
    return (2.0 * tau - force - p[6] * joints * w - slope * w * w) / inertia


@compiled_when_called(**_options)
def _tabulate(angle, p, out):  # type: ignore[no-untyped-def]
    for k in range(len(angle)):
        out[0, k], out[1, k], out[2, k], out[3, k] = _mechanics(angle[k], p)


@compiled_when_called(**_options)
def _fold(time, torque, start, rate, parameters, out):  # type: ignore[no-untyped-def]
    for lane in range(out.shape[1]):
        p = parameters[:, lane]
        a, w = start[lane], rate[lane]
        out[0, lane] = a
        for k in range(len(time) - 1):
            span = time[k + 1] - time[k]
            steps = max(1, math.ceil(span / STEP))
            h = span / steps
            for s in range(steps):
                t0 = torque[k] + (torque[k + 1] - torque[k]) * s / steps
                t1 = torque[k] + (torque[k + 1] - torque[k]) * (s + 1) / steps
                tm = 0.5 * (t0 + t1)
                a1 = _acceleration(a, w, t0, p)
                a2 = _acceleration(a + 0.5 * h * w, w + 0.5 * h * a1, tm, p)
                a3 = _acceleration(a + 0.5 * h * (w + 0.5 * h * a1), w + 0.5 * h * a2, tm, p)
                a4 = _acceleration(a + h * (w + 0.5 * h * a2), w + h * a3, t1, p)
                a += h * (w + h * (a1 + a2 + a3) / 6.0)
                w = min(FASTEST, max(-FASTEST, w + h * (a1 + 2.0 * a2 + 2.0 * a3 + a4) / 6.0))
            out[k + 1, lane] = a


def parameters_of(jumps: JumpLanes) -> Array:
    """(n_parameter, n_lane) what ``fold`` needs of legs."""
    return np.ascontiguousarray([getattr(jumps, name) for name in NAMES])


def leg_parameters(leg: HopperLeg, body_mass: float, joint_damping: Array) -> Array:
    """(n_parameter, n_lane) of one leg with a body of that mass (kg), for joint dampings (n_lane,) N m s/rad."""
    flexures = leg.flexures
    common = (
        leg.length, leg.lower_length, leg.hip_spacing, body_mass, leg.laminate.mass_per_length, flexures.rate, 0.0,
        flexures.hip_rest, flexures.knee_rest, flexures.foot_rest, leg.gravity, leg.extended, leg.stop_rate,
        leg.stop_dissipation,
    )  # fmt: skip
    parameters = np.repeat(np.array(common)[:, None], len(joint_damping), axis=1)
    parameters[NAMES.index("joint_damping")] = joint_damping
    return parameters


def mechanics(angle: Array, parameters: Array) -> tuple[Array, Array, Array, Array]:
    """M (kg m^2), M', V' (N m, without the stop) and D (n,) at angles (n,) rad of one leg (n_parameter,)."""
    out = np.empty((4, len(angle)))
    _tabulate(angle, parameters, out)
    inertia, half_slope, force, joints = out
    return inertia, 2.0 * half_slope, force, joints


def fold(parameters: Array, time: Array, torque: Array, start: Array, rate: Array) -> Array:
    """(n_time, n_lane) rad: the upper link's angle under the recorded torque (n_time,) N m.

    ``parameters`` (n_parameter, n_lane): of ``parameters_of`` or ``leg_parameters``. ``start`` rad and ``rate`` rad/s
    (n_lane,): where each lane is at the first sample, and how fast.
    """
    out = np.empty((len(time), parameters.shape[1]))
    _fold(time, torque, start, rate, parameters, out)
    return out


def first_state(time: Array, angle: Array) -> tuple[float, float]:
    """Angle (rad) and rate (rad/s) at the first sample, by a parabola through the first 20 ms.

    Not by a straight line: light links reach 300 rad/s^2, and start from rest.
    """
    head = slice(0, max(5, int(np.searchsorted(time, time[0] + 0.02))))
    _, slope, level = np.polyfit(time[head] - time[0], angle[head], 2)
    return float(level), float(slope)
