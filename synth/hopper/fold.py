"""Inverted pull-ups of many legs at once: the equation of ``identify_damping`` in closed form, compiled.

    M a'' + M' a'^2 / 2 + V' = 2 tau - b D a'

with rigid links, and the leg's stop at full extension; tau is a motor's torque on its upper link, outward
positive, as recorded, so motor and gear do not appear. Fourth-order Runge-Kutta, steps of at most ``STEP``.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.compiling.compiled import compiled_when_called
from synth.jump.jump_lanes import JumpLanes

STEP = 1e-3  # s; recordings of 1 kHz take one step per sample
FASTEST = 300.0  # rad/s; keeps a diverging guess finite
NAMES = (
    "length", "lower_length", "hip_spacing", "body_mass", "mass_per_length", "flexure_rate", "joint_damping",
    "hip_rest", "knee_rest", "foot_rest", "gravity", "extended", "stop_rate", "stop_dissipation",
)  # fmt: skip
_options: dict[str, Any] = {"error_model": "numpy", "nogil": True}


@compiled_when_called(**_options)
def _acceleration(a, w, tau, p):  # type: ignore[no-untyped-def]
    length, lower, spacing, body, density, rate, damping = p[0], p[1], p[2], p[3], p[4], p[5], p[6]
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
    past = max(0.0, p[11] - a)  # the leg's stop, as in ``jump_source``
    force -= 2.0 * p[12] * past * max(0.0, 1.0 - p[13] * w)
    return (2.0 * tau - force - damping * joints * w - slope * w * w) / inertia


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


def fold(jumps: JumpLanes, time: Array, torque: Array, start: Array, rate: Array) -> Array:
    """(n_time, n_lane) rad: the upper link's angle under the recorded torque (n_time,) N m.

    ``start`` rad and ``rate`` rad/s (n_lane,): where each lane is at the first sample, and how fast.
    """
    parameters = np.ascontiguousarray([getattr(jumps, name) for name in NAMES])
    out = np.empty((len(time), jumps.count))
    _fold(time, torque, start, rate, parameters, out)
    return out
