"""The three-link leg that every engine swings: the thesis' masses, spring and damper rates, seven releases from rest.

Links 0.20, 0.18 and 0.15 m, uniform rods (their inertia is assumed); free angles made up. The other engines get the
equations of motion written out here, in absolute link angles from straight down, from Lagrange's equations of a chain
of rods; nothing of the project's own generated code is in them.
"""

from __future__ import annotations

from math import cos, sin
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

LENGTH, MASS = np.array([0.20, 0.18, 0.15]), np.array([0.75, 0.30, 0.10])
COM, INERTIA, GRAVITY = LENGTH / 2, MASS * LENGTH**2 / 12, 9.81
NOMINAL = np.array([23.7, 1.71, 0.454, 1.29, 0.105, 0.063, 0.05, -0.08, 0.10])  # k N m/rad, b N m s/rad, free angle rad
TIMES = np.arange(501) / 500.0
RELEASES = np.array(
    [[0.5, 0, 0], [-0.5, 0, 0], [0.4, -0.6, 0.3], [0, -0.8, 0], [0, 0.2, 0.6], [-0.3, -0.5, -0.5], [0.5, -1.0, 0.5]]
)
FRICTION = np.array([0.15, 0.02, 0.005])  # N m, where it is on


def parameters(count: int) -> Array:
    """(count, 9) k and b by exp(+-0.3), free angles by +-0.1 rad; the first is nominal."""
    generator = np.random.default_rng(0)
    found = np.tile(NOMINAL, (count, 1))
    found[1:, :6] *= np.exp(generator.uniform(-0.3, 0.3, (count - 1, 6)))
    found[1:, 6:] += generator.uniform(-0.1, 0.1, (count - 1, 3))
    return found


def leg(values: Array = NOMINAL) -> Leg:
    """The leg with these k, b and free angles."""
    joints = [
        Joint(
            name,
            Link(float(LENGTH[j]), float(MASS[j]), float(COM[j]), float(INERTIA[j])),
            spring=Spring(float(values[j]), float(values[6 + j])),
            damper=Damper(float(values[3 + j])),
        )
        for j, name in enumerate(("hip", "knee", "ankle"))
    ]
    return Leg("thesis leg", tuple(joints), gravity=GRAVITY)


def constants() -> Array:
    """(9,) inertia terms a11, a22, a33, a12, a13, a23 (kg m^2) and gravity moments (N m) of the chain."""
    m, c, length = MASS, COM, LENGTH
    inertia = [
        INERTIA[0] + m[0] * c[0] ** 2 + (m[1] + m[2]) * length[0] ** 2,
        INERTIA[1] + m[1] * c[1] ** 2 + m[2] * length[1] ** 2,
        INERTIA[2] + m[2] * c[2] ** 2,
        (m[1] * c[1] + m[2] * length[1]) * length[0],
        m[2] * c[2] * length[0],
        m[2] * c[2] * length[1],
    ]
    moments = [m[0] * c[0] + (m[1] + m[2]) * length[0], m[1] * c[1] + m[2] * length[1], m[2] * c[2]]
    return np.array([*inertia, *(GRAVITY * np.array(moments))])


def accelerations(x: Any, p: Any, a: Any, sine: Any = sin, cosine: Any = cos) -> tuple[Any, Any, Any]:
    """Accelerations of the absolute angles; x = (3 angles, 3 rates), p as ``NOMINAL``, a as ``constants``.

    Plain arithmetic, so that numpy, numba, CasADi and JAX all take it: LDL' of the mass matrix written out.
    """
    f1, f2, f3, w1, w2, w3 = x[0], x[1], x[2], x[3], x[4], x[5]
    t1 = -p[0] * (f1 - p[6]) - p[3] * w1
    t2 = -p[1] * (f2 - f1 - p[7]) - p[4] * (w2 - w1)
    t3 = -p[2] * (f3 - f2 - p[8]) - p[5] * (w3 - w2)
    m12, m13, m23 = a[3] * cosine(f1 - f2), a[4] * cosine(f1 - f3), a[5] * cosine(f2 - f3)
    h12, h13, h23 = a[3] * sine(f1 - f2), a[4] * sine(f1 - f3), a[5] * sine(f2 - f3)
    r1 = t1 - t2 - h12 * w2 * w2 - h13 * w3 * w3 - a[6] * sine(f1)
    r2 = t2 - t3 + h12 * w1 * w1 - h23 * w3 * w3 - a[7] * sine(f2)
    r3 = t3 + h13 * w1 * w1 + h23 * w2 * w2 - a[8] * sine(f3)
    l21, l31 = m12 / a[0], m13 / a[0]
    d2 = a[1] - l21 * m12
    u = m23 - l31 * m12
    l32 = u / d2
    y2 = r2 - l21 * r1
    e3 = (r3 - l31 * r1 - l32 * y2) / (a[2] - l31 * m13 - l32 * u)
    e2 = y2 / d2 - l32 * e3
    return r1 / a[0] - l21 * e2 - l31 * e3, e2, e3


CONSTANTS = constants()


def derivative(time: float, x: Array, p: Array) -> Array:
    """(6,) the right-hand side with numpy, as one would write it for ``solve_ivp``."""
    return np.array([x[3], x[4], x[5], *accelerations(x, p, CONSTANTS, np.sin, np.cos)])


def start(release: Array) -> Array:
    """(6,) absolute angles and rates of a release (3,) of the joints."""
    return np.concatenate([np.cumsum(release), np.zeros(3)])


def joints(absolute: Array) -> Array:
    """Joint rotations from absolute angles, last axis 3."""
    return np.diff(absolute, axis=-1, prepend=0.0)
