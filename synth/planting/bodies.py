"""Accelerations of a planar chain of bodies: the articulated-body algorithm.

Source: Featherstone, Rigid Body Dynamics Algorithms, 2008, ch. 7, written for the plane. All vectors are in world axes
at each body's hinge: acceleration (alpha, ax, ay), force (moment, fx, fy). A hinge or a slide connects a body to the
one before it. A locked coordinate is a rigid constraint, and its constraint force is computed.

x points right and y up; angles are counter-clockwise; a body at absolute angle 0 points straight down. A rotor turns
with its hinge's own angle, like a motor behind a gear (ibid., section 9.6), and adds only to the inertia of the hinge.
"""

# mypy: disable-error-code="no-untyped-def,untyped-decorator,no-untyped-call"
from __future__ import annotations

import math

from numba import njit

# Columns of ``body``; ``BESIDE``: distance of the centre of mass from the line, to the right of a hanging body
LENGTH, MASS, COM, INERTIA, RATE, DAMPING, FREE, BODY_KIND, DIRECTION, OFFSET, ROTOR, BESIDE = range(12)
HINGE, SLIDE = 0.0, 1.0


# Columns of the scratch array, a row a body: hinge from the parent's hinge, velocity-dependent acceleration, slide's
# direction, the symmetric articulated inertia (alpha, x, y) and the bias force.
RX, RY, BX, BY, SX, SY, I00, I01, I02, I11, I12, I22, P0, P1, P2 = range(15)


@njit
def accelerate(body, gravity, locked, tau, q, w, acc, force, s):
    """Write accelerations into ``acc`` (n,) and hinge forces (moment, fx, fy) into ``force`` (n, 3).

    ``tau`` (n,) : torques along the free coordinates. The acceleration of a locked coordinate is zero. ``s`` (n, 15)
    is scratch.
    """
    n = body.shape[0]
    phi, spin, ex, ey = 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        phi += body[i, OFFSET]
        rx, ry = ex, ey
        bx, by = 0.0, 0.0
        before = spin
        if body[i, BODY_KIND] == SLIDE:
            sx, sy = math.cos(phi + body[i, DIRECTION]), math.sin(phi + body[i, DIRECTION])
            rx += sx * q[i]
            ry += sy * q[i]
            bx -= 2.0 * spin * sy * w[i]
            by += 2.0 * spin * sx * w[i]
        else:
            sx, sy = 0.0, 0.0
            phi += q[i]
            spin += w[i]
        s[i, RX], s[i, RY], s[i, SX], s[i, SY] = rx, ry, sx, sy
        s[i, BX], s[i, BY] = bx - before * before * rx, by - before * before * ry
        across, along = math.sin(phi), math.cos(phi)
        ex, ey = body[i, LENGTH] * across, -body[i, LENGTH] * along
        m, h, b = body[i, MASS], body[i, MASS] * body[i, COM], body[i, MASS] * body[i, BESIDE]
        hx, hy = h * across + b * along, b * across - h * along
        s[i, I00], s[i, I01], s[i, I02] = body[i, INERTIA] + h * body[i, COM] + b * body[i, BESIDE], -hy, hx
        s[i, I11], s[i, I12], s[i, I22] = m, 0.0, m
        s[i, P0], s[i, P1], s[i, P2] = hx * gravity, -spin * spin * hx, m * gravity - spin * spin * hy
    _inward(body, locked, tau, s)
    _outward(body, locked, tau, s, acc, force)


@njit
def _inward(body, locked, tau, s):
    """Articulated inertias and bias forces, from the tip to the root."""
    for i in range(body.shape[0] - 1, 0, -1):
        bx, by = s[i, BX], s[i, BY]
        a00, a01, a02, a11, a12, a22 = s[i, I00], s[i, I01], s[i, I02], s[i, I11], s[i, I12], s[i, I22]
        b0 = s[i, P0] + a01 * bx + a02 * by
        b1 = s[i, P1] + a11 * bx + a12 * by
        b2 = s[i, P2] + a12 * bx + a22 * by
        if not locked[i]:
            if body[i, BODY_KIND] == SLIDE:
                sx, sy = s[i, SX], s[i, SY]
                u0, u1, u2 = a01 * sx + a02 * sy, a11 * sx + a12 * sy, a12 * sx + a22 * sy
                d, rest = sx * u1 + sy * u2, tau[i] - sx * s[i, P1] - sy * s[i, P2]
            else:
                u0, u1, u2 = a00, a01, a02
                d, rest = a00 + body[i, ROTOR], tau[i] - s[i, P0]
            e = (rest - (u1 * bx + u2 * by)) / d
            b0, b1, b2 = b0 + u0 * e, b1 + u1 * e, b2 + u2 * e
            a00, a01, a02 = a00 - u0 * u0 / d, a01 - u0 * u1 / d, a02 - u0 * u2 / d
            a11, a12, a22 = a11 - u1 * u1 / d, a12 - u1 * u2 / d, a22 - u2 * u2 / d
        # to the parent's hinge: ax = axp - alpha ry, ay = ayp + alpha rx
        x, y = s[i, RX], s[i, RY]
        s[i - 1, I00] += a00 + 2.0 * (x * a02 - y * a01) + x * x * a22 + y * y * a11 - 2.0 * x * y * a12
        s[i - 1, I01] += a01 - y * a11 + x * a12
        s[i - 1, I02] += a02 - y * a12 + x * a22
        s[i - 1, I11] += a11
        s[i - 1, I12] += a12
        s[i - 1, I22] += a22
        s[i - 1, P0] += b0 - y * b1 + x * b2
        s[i - 1, P1] += b1
        s[i - 1, P2] += b2


@njit
def _outward(body, locked, tau, s, acc, force):
    """Accelerations from the root to the tip, and the force through each hinge."""
    alpha, ax, ay = 0.0, 0.0, 0.0
    for i in range(body.shape[0]):
        ax, ay = ax - alpha * s[i, RY] + s[i, BX], ay + alpha * s[i, RX] + s[i, BY]
        a00, a01, a02, a11, a12, a22 = s[i, I00], s[i, I01], s[i, I02], s[i, I11], s[i, I12], s[i, I22]
        acc[i] = 0.0
        if not locked[i]:
            if body[i, BODY_KIND] == SLIDE:
                sx, sy = s[i, SX], s[i, SY]
                u0, u1, u2 = a01 * sx + a02 * sy, a11 * sx + a12 * sy, a12 * sx + a22 * sy
                rest = tau[i] - sx * s[i, P1] - sy * s[i, P2] - u0 * alpha - u1 * ax - u2 * ay
                acc[i] = rest / (sx * u1 + sy * u2)
                ax += sx * acc[i]
                ay += sy * acc[i]
            else:
                acc[i] = (tau[i] - s[i, P0] - a00 * alpha - a01 * ax - a02 * ay) / (a00 + body[i, ROTOR])
                alpha += acc[i]
        force[i, 0] = a00 * alpha + a01 * ax + a02 * ay + s[i, P0]
        force[i, 1] = a01 * alpha + a11 * ax + a12 * ay + s[i, P1]
        force[i, 2] = a02 * alpha + a12 * ax + a22 * ay + s[i, P2]
