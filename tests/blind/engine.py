"""A planar chain of bodies, stepped by Runge-Kutta 4 at a fixed fine step; independent of the diagnosing program.

Articulated-body algorithm (Featherstone, Rigid Body Dynamics Algorithms, 2008, ch. 7), written for the plane with all
vectors in world axes at each body's hinge: acceleration (alpha, ax, ay), force (moment, fx, fy). A body hangs from the
one before it by a hinge or a slide; a moving mount or a bending link is one more body. A locked coordinate, or one that
friction holds, is rigid: its reaction is what friction must bear, so sticking is true sticking, not slow creep.

x to the right, y up, angles counter-clockwise; a body at absolute angle 0 points straight down.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from blind import laws
from blind.laws import BEARING, BRISTLES, MESH, SLACK, STICK_SLIP, fall

# Columns of ``body``
LENGTH, MASS, COM, INERTIA, RATE, DAMPING, FREE, KIND, DIRECTION, OFFSET = range(10)
HINGE, SLIDE = 0.0, 1.0


@njit(cache=True)
def accelerate(body, gravity, locked, tau, q, w, acc, force):
    """Accelerations (into ``acc``) and the forces through each hinge (into ``force``, rows moment, fx, fy).

    ``tau`` are the torques along the free coordinates; a locked one accelerates not at all.
    """
    n = body.shape[0]
    phi = np.empty(n)
    spin = np.empty(n)
    rx, ry = np.empty(n), np.empty(n)  # from the parent's hinge to this one
    bx, by = np.empty(n), np.empty(n)  # velocity-dependent acceleration of this hinge
    sx, sy = np.zeros(n), np.zeros(n)  # the slide's direction
    inertia = np.empty((n, 3, 3))
    p = np.empty((n, 3))
    before, spin_before, ex, ey = 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        slide = body[i, KIND] == SLIDE
        before += body[i, OFFSET]
        rx[i], ry[i] = ex, ey
        bx[i], by[i] = 0.0, 0.0
        if slide:
            sx[i], sy[i] = math.cos(before + body[i, DIRECTION]), math.sin(before + body[i, DIRECTION])
            rx[i] += sx[i] * q[i]
            ry[i] += sy[i] * q[i]
            bx[i] -= 2.0 * spin_before * sy[i] * w[i]
            by[i] += 2.0 * spin_before * sx[i] * w[i]
            phi[i], spin[i] = before, spin_before
        else:
            phi[i], spin[i] = before + q[i], spin_before + w[i]
        bx[i] -= spin_before**2 * rx[i]
        by[i] -= spin_before**2 * ry[i]
        s, c = math.sin(phi[i]), math.cos(phi[i])
        ex, ey = body[i, LENGTH] * s, -body[i, LENGTH] * c
        m, h = body[i, MASS], body[i, MASS] * body[i, COM]
        hx, hy = h * s, -h * c
        inertia[i, 0, 0] = body[i, INERTIA] + h * body[i, COM]
        inertia[i, 0, 1] = inertia[i, 1, 0] = -hy
        inertia[i, 0, 2] = inertia[i, 2, 0] = hx
        inertia[i, 1, 1] = inertia[i, 2, 2] = m
        inertia[i, 1, 2] = inertia[i, 2, 1] = 0.0
        p[i, 0] = hx * gravity
        p[i, 1] = -(spin[i] ** 2) * hx
        p[i, 2] = -(spin[i] ** 2) * hy + m * gravity
        before, spin_before = phi[i], spin[i]
    _inward(body, locked, tau, rx, ry, bx, by, sx, sy, inertia, p)
    _outward(body, locked, tau, rx, ry, bx, by, sx, sy, inertia, p, acc, force)


@njit(cache=True)
def _inward(body, locked, tau, rx, ry, bx, by, sx, sy, inertia, p):
    """Articulated inertias and bias forces, from the tip to the root."""
    n = body.shape[0]
    u = np.empty(3)
    a = np.empty((3, 3))
    b = np.empty(3)
    for i in range(n - 1, 0, -1):
        for r in range(3):
            b[r] = p[i, r] + inertia[i, r, 1] * bx[i] + inertia[i, r, 2] * by[i]
            for c in range(3):
                a[r, c] = inertia[i, r, c]
        if not locked[i]:
            slide = body[i, KIND] == SLIDE
            for r in range(3):
                u[r] = inertia[i, r, 1] * sx[i] + inertia[i, r, 2] * sy[i] if slide else inertia[i, r, 0]
            d = sx[i] * u[1] + sy[i] * u[2] if slide else u[0]
            rest = tau[i] - (sx[i] * p[i, 1] + sy[i] * p[i, 2] if slide else p[i, 0])
            # bias of what hangs outboard: (rest - u.b)/d is the coordinate's acceleration under the bias alone
            e = (rest - (u[1] * bx[i] + u[2] * by[i])) / d
            for r in range(3):
                b[r] += u[r] * e
                for c in range(3):
                    a[r, c] -= u[r] * u[c] / d
        # to the parent's hinge: ax = axp - alpha ry, ay = ayp + alpha rx
        x, y = rx[i], ry[i]
        a01, a02, a11, a12, a22 = a[0, 1], a[0, 2], a[1, 1], a[1, 2], a[2, 2]
        inertia[i - 1, 0, 0] += a[0, 0] + 2.0 * (x * a02 - y * a01) + x * x * a22 + y * y * a11 - 2.0 * x * y * a12
        v1, v2 = a01 - y * a11 + x * a12, a02 - y * a12 + x * a22
        inertia[i - 1, 0, 1] += v1
        inertia[i - 1, 1, 0] += v1
        inertia[i - 1, 0, 2] += v2
        inertia[i - 1, 2, 0] += v2
        inertia[i - 1, 1, 1] += a11
        inertia[i - 1, 1, 2] += a12
        inertia[i - 1, 2, 1] += a12
        inertia[i - 1, 2, 2] += a22
        p[i - 1, 0] += b[0] - y * b[1] + x * b[2]
        p[i - 1, 1] += b[1]
        p[i - 1, 2] += b[2]


@njit(cache=True)
def _outward(body, locked, tau, rx, ry, bx, by, sx, sy, inertia, p, acc, force):
    """Accelerations from the root to the tip, and the force through each hinge."""
    alpha, ax, ay = 0.0, 0.0, 0.0
    for i in range(body.shape[0]):
        ax, ay = ax - alpha * ry[i] + bx[i], ay + alpha * rx[i] + by[i]
        acc[i] = 0.0
        if not locked[i]:
            if body[i, KIND] == SLIDE:
                u0 = inertia[i, 0, 1] * sx[i] + inertia[i, 0, 2] * sy[i]
                u1 = inertia[i, 1, 1] * sx[i] + inertia[i, 1, 2] * sy[i]
                u2 = inertia[i, 2, 1] * sx[i] + inertia[i, 2, 2] * sy[i]
                rest = tau[i] - sx[i] * p[i, 1] - sy[i] * p[i, 2] - u0 * alpha - u1 * ax - u2 * ay
                acc[i] = rest / (sx[i] * u1 + sy[i] * u2)
                ax += sx[i] * acc[i]
                ay += sy[i] * acc[i]
            else:
                u0, u1, u2 = inertia[i, 0, 0], inertia[i, 1, 0], inertia[i, 2, 0]
                acc[i] = (tau[i] - p[i, 0] - u0 * alpha - u1 * ax - u2 * ay) / u0
                alpha += acc[i]
        for r in range(3):
            force[i, r] = inertia[i, r, 0] * alpha + inertia[i, r, 1] * ax + inertia[i, r, 2] * ay + p[i, r]


@njit(cache=True)
def _bristle_limits(law, p, q, w, load):
    """Torque at which the bristles slide, and the deflection at which they do."""
    if law == BRISTLES:
        return fall(w, p[0], p[1], p[2], p[3]), p[4]
    return p[0] * abs(p[1] * (q - p[2])) + p[3], p[4]


@njit(cache=True)
def _bristle_ahead(z, w, deflection, h):
    """Z after ``h`` of z' = w - |w| z / deflection at constant w: exact, so that no step is too long."""
    end = math.copysign(deflection, w) if w != 0.0 else z
    return end + (z - end) * math.exp(-abs(w) * h / deflection)


@njit(cache=True)
def derivative(body, gravity, locked, law, at, par, mode, t, dt, q, w, w0, z, tau, acc, force, load, dz):
    """Accelerations and memory rates at one stage, ``dt`` after the step's start, where the speeds were ``w0``."""
    for i in range(body.shape[0]):
        tau[i] = -body[i, RATE] * (q[i] - body[i, FREE]) - body[i, DAMPING] * w[i]
    for k in range(law.shape[0]):
        i, j, p = at[k, 0], at[k, 1], par[k]
        dz[k, 0] = dz[k, 1] = 0.0
        if law[k] == STICK_SLIP:
            tau[i] -= mode[k] * fall(w[i], p[0], p[1], p[2], p[3])
        elif law[k] == BEARING:
            tau[i] -= mode[k] * (p[0] * load[k] + p[1])
        elif law[k] == BRISTLES or law[k] == MESH:
            mean = 0.5 * (w0[i] + w[i])
            limit, deflection = _bristle_limits(law[k], p, q[i], w[i], load[k])
            bristle = _bristle_ahead(z[k, 0], mean, deflection, dt)
            tau[i] -= limit * bristle / deflection + p[5] * (w[i] - abs(w[i]) * bristle / deflection)
        elif law[k] == SLACK:
            if mode[k] != 0:
                tau[i] -= p[0] * (q[i] - p[1] - mode[k] * p[2]) + p[3] * w[i]
        else:
            a, b, dz[k, 0], dz[k, 1] = laws.torque(law[k], p, t, q[i], w[i], q[j], w[j], z[k, 0], z[k, 1])
            tau[i] += a
            if j != i:
                tau[j] += b
    accelerate(body, gravity, locked, tau, q, w, acc, force)
    for k in range(law.shape[0]):
        if law[k] == BEARING:
            load[k] = math.hypot(force[at[k, 0], 1], force[at[k, 0], 2])


@njit(cache=True)
def _limit_at_rest(law, p, load):
    return p[1] if law == STICK_SLIP else p[0] * load + p[1]


@njit(cache=True)
def _release(body, law, at, par, mode, held, fixed, tau, force, load):
    """Let go the one coordinate whose friction is overcome most; True if one was."""
    worst, which, sense = 0.0, -1, 0
    for k in range(law.shape[0]):
        i = at[k, 0]
        if (law[k] == STICK_SLIP or law[k] == BEARING) and mode[k] == 0 and not fixed[i]:
            reaction = force[i, 0] - tau[i]  # what friction must supply for the hinge to stay
            over = abs(reaction) - _limit_at_rest(law[k], par[k], load[k])
            if over > worst:
                worst, which, sense = over, k, (-1 if reaction > 0.0 else 1)
    if which < 0:
        return False
    mode[which] = sense
    held[at[which, 0]] = False
    return True


@njit(cache=True)
def _margin(k, law, at, par, mode, fixed, q, w, z):
    """How far law ``k`` is from its event (the sign changes there); 1 where it has none coming."""
    i, p = at[k, 0], par[k]
    if fixed[i]:
        return 1.0
    if law[k] == STICK_SLIP or law[k] == BEARING:
        return mode[k] * w[i] if mode[k] != 0 else 1.0  # a slider comes to rest
    if law[k] == SLACK:
        u = q[i] - p[1]
        if mode[k] != 0:
            return mode[k] * (p[0] * (u - mode[k] * p[2]) + p[3] * w[i])  # a flank pushes, it cannot pull
        return p[2] - abs(u - z[k, 0])
    return 1.0


@njit(cache=True)
def _happen(k, law, at, par, mode, held, q, w, z):
    """The event of law ``k``: the slider sticks, the arm leaves its flank or meets one."""
    i, p = at[k, 0], par[k]
    if law[k] == SLACK:
        u = q[i] - p[1]
        if mode[k] != 0:
            z[k, 0], mode[k] = u - mode[k] * p[2], 0
        else:
            mode[k] = 1 if u > z[k, 0] else -1
    else:
        w[i], mode[k], held[i] = 0.0, 0, True


@njit(cache=True)
def _advance(body, gravity, held, law, at, par, mode, t, h, q, w, z, a1, d1, tau, force, load, qn, wn, zn):
    """One Runge-Kutta 4 step from (q, w, z), where the rates are (w, a1, d1), into (qn, wn, zn)."""
    n, m = body.shape[0], law.shape[0]
    a2, a3, a4 = np.empty(n), np.empty(n), np.empty(n)
    d2, d3, d4 = np.empty((m, 2)), np.empty((m, 2)), np.empty((m, 2))
    half = 0.5 * h
    w2, z2 = w + half * a1, z + half * d1
    derivative(
        body, gravity, held, law, at, par, mode, t + half, half, q + half * w, w2, w, z2, tau, a2, force, load, d2
    )
    w3, z3 = w + half * a2, z + half * d2
    derivative(
        body, gravity, held, law, at, par, mode, t + half, half, q + half * w2, w3, w, z3, tau, a3, force, load, d3
    )
    w4, z4 = w + h * a3, z + h * d3
    derivative(body, gravity, held, law, at, par, mode, t + h, h, q + h * w3, w4, w, z4, tau, a4, force, load, d4)
    for i in range(n):
        qn[i] = q[i] + h / 6.0 * (w[i] + 2.0 * w2[i] + 2.0 * w3[i] + w4[i])
        wn[i] = w[i] + h / 6.0 * (a1[i] + 2.0 * a2[i] + 2.0 * a3[i] + a4[i])
    for k in range(m):
        for c in range(2):
            zn[k, c] = z[k, c] + h / 6.0 * (d1[k, c] + 2.0 * d2[k, c] + 2.0 * d3[k, c] + d4[k, c])
        i, p = at[k, 0], par[k]
        if law[k] == BRISTLES or law[k] == MESH:
            deflection = _bristle_limits(law[k], p, qn[i], wn[i], 0.0)[1]
            zn[k, 0] = _bristle_ahead(z[k, 0], 0.5 * (w[i] + wn[i]), deflection, h)
        elif law[k] == SLACK and mode[k] == 0:
            zn[k, 0] = z[k, 0] * math.exp(-p[0] * h / p[3])  # a massless arm on spring and damper alone


@njit(cache=True)
def simulate(body, gravity, fixed, law, at, par, mode, z, q0, w0, start, h, count):
    """Angles and speeds at ``count`` + 1 instants ``h`` apart; ``mode`` is changed in place.

    A step in which something sticks, lets go or touches is cut there (secant on the event's margin, to about h^3).

    Parameters
    ----------
    body : (n, 10), the columns named above; SI units.
    fixed : (n,) bool, coordinates that are locked for the whole trial.
    law, at, par : (k,) law numbers, (k, 2) coordinates, (k, 8) parameters.
    mode, z : (k,) and (k, 2), state of contact or sticking, and memories, at the start.
    start : s, the laws' time at the first instant.

    Returns
    -------
    (count + 1, n), (count + 1, n)
    """
    n, m = body.shape[0], law.shape[0]
    angle, speed = np.empty((count + 1, n)), np.empty((count + 1, n))
    held, load = fixed.copy(), np.zeros(m)
    tau, force = np.zeros(n), np.zeros((n, 3))
    a1, d1 = np.zeros(n), np.zeros((m, 2))
    q, w, z = q0.copy(), w0.copy(), z.copy()
    qn, wn, zn = q.copy(), w.copy(), z.copy()
    for k in range(m):
        if law[k] == STICK_SLIP or law[k] == BEARING:
            i = at[k, 0]
            mode[k] = 0 if w[i] == 0.0 else (1 if w[i] > 0.0 else -1)
            held[i] = fixed[i] or mode[k] == 0
    angle[0], speed[0] = q, w
    derivative(body, gravity, held, law, at, par, mode, start, 0.0, q, w, w, z, tau, a1, force, load, d1)
    for step in range(count):
        rest, cuts = h, 0
        while rest > 0.0:
            t = start + (step + 1) * h - rest
            derivative(body, gravity, held, law, at, par, mode, t, 0.0, q, w, w, z, tau, a1, force, load, d1)
            while _release(body, law, at, par, mode, held, fixed, tau, force, load):
                derivative(body, gravity, held, law, at, par, mode, t, 0.0, q, w, w, z, tau, a1, force, load, d1)
            _advance(body, gravity, held, law, at, par, mode, t, rest, q, w, z, a1, d1, tau, force, load, qn, wn, zn)
            used, first = rest, -1
            for k in range(m):
                if _margin(k, law, at, par, mode, fixed, qn, wn, zn) < 0.0:
                    if cuts > 12:  # chatter: the event is taken at the step's end
                        first = k
                        continue
                    used, first = _locate(
                        k, used, first,
                        body, gravity, held, law, at, par, mode, fixed, t, q, w, z, a1, d1, tau, force, load, qn, wn, zn,
                    )  # fmt: skip
            q[:], w[:], z[:, :] = qn, wn, zn
            if first >= 0:
                _happen(first, law, at, par, mode, held, q, w, z)
            cuts += 1
            rest = rest - used if first >= 0 else 0.0
        angle[step + 1], speed[step + 1] = q, w
    return angle, speed


@njit(cache=True)
def _locate(
    k, used, first, body, gravity, held, law, at, par, mode, fixed, t, q, w, z, a1, d1, tau, force, load, qn, wn, zn
):
    """Shorten the step to law ``k``'s event, if it comes before ``used``; leaves the state at the new end."""
    low, at_low = 0.0, max(_margin(k, law, at, par, mode, fixed, q, w, z), 0.0)
    high, at_high = used, _margin(k, law, at, par, mode, fixed, qn, wn, zn)
    if at_high >= 0.0:
        return used, first
    here = used
    for _ in range(3):
        here = low + (high - low) * at_low / (at_low - at_high) if at_low > 0.0 else 0.0
        _advance(body, gravity, held, law, at, par, mode, t, here, q, w, z, a1, d1, tau, force, load, qn, wn, zn)
        value = _margin(k, law, at, par, mode, fixed, qn, wn, zn)
        if here == 0.0 or value == 0.0:
            break
        if value < 0.0:
            high, at_high = here, value
        else:
            low, at_low = here, value
    return here, k
