"""A chain of bodies with torque laws at its joints, integrated by Runge-Kutta 4 with a small fixed step.

It is independent of the diagnosing program. A moving mount or a bending link is an additional body. A joint that sticks
is a rigid constraint, and the constraint reaction is the friction torque: the joint does not creep.
"""

# mypy: disable-error-code="no-untyped-def,untyped-decorator,no-untyped-call"
from __future__ import annotations

import math

import numpy as np
from numba import njit

from synth.planting import torque_laws
from synth.planting.bodies import DAMPING, FREE, RATE, accelerate
from synth.planting.torque_laws import (
    BEARING,
    BRISTLES,
    GEAR,
    GEAR_MESH,
    SAME_TIME,
    SAMPLED_SERVO,
    SLACK,
    STICK_SLIP,
    STUCK_LAWS,
    look,
    servo_torque,
    stribeck_torque,
    winding_torque,
)


@njit
def _bristle_limits(law, p, q, w):
    """Torque and deflection at which the bristles start to slide."""
    if law == BRISTLES:
        return stribeck_torque(w, p[0], p[1], p[2], p[3]), p[4]
    return p[0] * abs(p[1] * (q - p[2])) + p[3], p[4]


@njit
def _advance_bristle(z, w, deflection, h):
    """Bristle deflection after time ``h`` of z' = w - |w| z / deflection at constant w; exact for every step size."""
    end = math.copysign(deflection, w) if w != 0.0 else z
    return end + (z - end) * math.exp(-abs(w) * h / deflection)


@njit
def _servo_load(p, table, t, q, w, z):
    """Torque that the gear of a servo transmits, of a cold winding: friction that a warm one lowers is second order."""
    if p[4] > 0.0:
        return abs(winding_torque(table, int(p[2]), int(p[3]), t, w, 0.0, z[int(p[4]) - 1, 1]))
    return abs(servo_torque(table, int(p[2]), int(p[3]), t, q, w, 0.0, z[int(p[5]) - 1, 1] if p[5] > 0.0 else 0.0))


@njit
def _look_if_due(law, at, par, table, due, summed, first, t, q, w, z):
    """Let the servos whose control step is now set the duty that they hold; returns the time of the next step.

    ``summed`` (k,) : duties of their integrals, to which the first look adds nothing.
    """
    soonest = math.inf
    for k in range(law.shape[0]):
        if law[k] == SAMPLED_SERVO:
            if due[k] <= t + SAME_TIME:
                since = 0.0 if first else par[k, 2]
                z[k, 1], due[k], summed[k] = look(par[k], table, t, q[at[k, 0]], w[at[k, 0]], summed[k], since)
            soonest = min(soonest, due[k])
    return soonest


@njit
def derivative(body, gravity, locked, law, at, par, table, mode, t, dt, q, w, w0, z, tau, acc, force, load, dz, s):
    """Accelerations and memory rates at one stage, ``dt`` after the start of the step, where the speeds were ``w0``."""
    for i in range(body.shape[0]):
        tau[i] = -body[i, RATE] * (q[i] - body[i, FREE]) - body[i, DAMPING] * w[i]
    for k in range(law.shape[0]):
        i, j, p = at[k, 0], at[k, 1], par[k]
        dz[k, 0] = dz[k, 1] = 0.0
        if law[k] == STICK_SLIP:
            tau[i] -= mode[k] * stribeck_torque(w[i], p[0], p[1], p[2], p[3])
        elif law[k] == BEARING or law[k] == GEAR:
            if law[k] == GEAR:
                load[k] = _servo_load(p, table, t, q[i], w[i], z)
            tau[i] -= mode[k] * (p[0] * load[k] + p[1])
        elif law[k] == BRISTLES or law[k] == GEAR_MESH:
            mean = 0.5 * (w0[i] + w[i])
            limit, deflection = _bristle_limits(law[k], p, q[i], w[i])
            bristle = _advance_bristle(z[k, 0], mean, deflection, dt)
            tau[i] -= limit * bristle / deflection + p[5] * (w[i] - abs(w[i]) * bristle / deflection)
        elif law[k] == SLACK:
            if mode[k] != 0:
                tau[i] -= p[0] * (q[i] - p[1] - mode[k] * p[2]) + p[3] * w[i]
        else:
            a, b, dz[k, 0], dz[k, 1] = torque_laws.torque(law[k], p, table, t, q[i], w[i], q[j], z[k, 0], z[k, 1])
            tau[i] += a
            if j != i:
                tau[j] += b
    accelerate(body, gravity, locked, tau, q, w, acc, force, s)
    for k in range(law.shape[0]):
        if law[k] == BEARING:
            load[k] = math.hypot(force[at[k, 0], 1], force[at[k, 0], 2])


@njit
def _limit_at_rest(law, p, load):
    return p[1] if law == STICK_SLIP else p[0] * load + p[1]


@njit
def _release(law, at, par, mode, held, fixed, tau, force, load):
    """Release the sticking coordinate whose reaction exceeds its friction limit most; True if there is one."""
    worst, which, sense = 0.0, -1, 0
    for k in range(law.shape[0]):
        i = at[k, 0]
        if (law[k] in STUCK_LAWS) and mode[k] == 0 and not fixed[i]:
            reaction = force[i, 0] - tau[i]  # the friction torque that would hold the hinge
            over = abs(reaction) - _limit_at_rest(law[k], par[k], load[k])
            if over > worst:
                worst, which, sense = over, k, (-1 if reaction > 0.0 else 1)
    if which < 0:
        return False
    mode[which] = sense
    held[at[which, 0]] = False
    return True


@njit
def _margin(k, law, at, par, mode, fixed, q, w, z):
    """Event function of law ``k``, which changes sign at the event; 1 if the law has no event."""
    i, p = at[k, 0], par[k]
    if fixed[i]:
        return 1.0
    if law[k] in STUCK_LAWS:
        return mode[k] * w[i] if mode[k] != 0 else 1.0  # the joint comes to rest
    if law[k] == SLACK:
        u = q[i] - p[1]
        if mode[k] != 0:
            return mode[k] * (p[0] * (u - mode[k] * p[2]) + p[3] * w[i])  # a flank can push but not pull
        return p[2] - abs(u - z[k, 0])
    return 1.0


@njit
def _apply_event(k, law, at, par, mode, held, q, w, z):
    """Apply the event of law ``k``: the joint sticks, or the backlash opens or closes."""
    i, p = at[k, 0], par[k]
    if law[k] == SLACK:
        u = q[i] - p[1]
        if mode[k] != 0:
            z[k, 0], mode[k] = u - mode[k] * p[2], 0
        else:
            mode[k] = 1 if u > z[k, 0] else -1
    else:
        w[i], mode[k], held[i] = 0.0, 0, True


@njit
def _stage(h, q, w, a, z, d, w_start, qs, ws, zs):
    """Write the state (q, w_start, z) + ``h`` * rates (w, a, d) into (qs, ws, zs)."""
    for i in range(q.shape[0]):
        qs[i] = q[i] + h * w[i]
        ws[i] = w_start[i] + h * a[i]
    for k in range(z.shape[0]):
        zs[k, 0] = z[k, 0] + h * d[k, 0]
        zs[k, 1] = z[k, 1] + h * d[k, 1]


@njit
def _advance(
    body, gravity, held, law, at, par, table, mode, t, h, q, w, z, a1, d1, tau, force, load, qn, wn, zn, v, m3, s
):
    """One Runge-Kutta 4 step from (q, w, z) with rates (w, a1, d1) into (qn, wn, zn).

    ``v`` (7, n) and ``m3`` (4, k, 2) hold the stages; ``s`` (n, 15) is scratch for ``accelerate``.
    """
    qs, w2, w3, w4, a2, a3, a4 = v[0], v[1], v[2], v[3], v[4], v[5], v[6]
    zs, d2, d3, d4 = m3[0], m3[1], m3[2], m3[3]
    half = 0.5 * h
    _stage(half, q, w, a1, z, d1, w, qs, w2, zs)
    derivative(
        body, gravity, held, law, at, par, table, mode, t + half, half, qs, w2, w, zs, tau, a2, force, load, d2, s
    )
    _stage(half, q, w2, a2, z, d2, w, qs, w3, zs)
    derivative(
        body, gravity, held, law, at, par, table, mode, t + half, half, qs, w3, w, zs, tau, a3, force, load, d3, s
    )
    _stage(h, q, w3, a3, z, d3, w, qs, w4, zs)
    derivative(body, gravity, held, law, at, par, table, mode, t + h, h, qs, w4, w, zs, tau, a4, force, load, d4, s)
    for i in range(body.shape[0]):
        qn[i] = q[i] + h / 6.0 * (w[i] + 2.0 * w2[i] + 2.0 * w3[i] + w4[i])
        wn[i] = w[i] + h / 6.0 * (a1[i] + 2.0 * a2[i] + 2.0 * a3[i] + a4[i])
    for k in range(law.shape[0]):
        for c in range(2):
            zn[k, c] = z[k, c] + h / 6.0 * (d1[k, c] + 2.0 * d2[k, c] + 2.0 * d3[k, c] + d4[k, c])
        i, p = at[k, 0], par[k]
        if law[k] == BRISTLES or law[k] == GEAR_MESH:
            deflection = _bristle_limits(law[k], p, qn[i], wn[i])[1]
            zn[k, 0] = _advance_bristle(z[k, 0], 0.5 * (w[i] + wn[i]), deflection, h)
        elif law[k] == SLACK and mode[k] == 0:
            zn[k, 0] = z[k, 0] * math.exp(-p[0] * h / p[3])  # a massless arm with only spring and damper


@njit
def simulate(body, gravity, fixed, law, at, par, table, mode, z, q0, w0, start, h, count):
    """Angles and speeds at ``count`` + 1 instants ``h`` s apart; ``mode`` is changed in place.

    A step ends at an event (sticking, slipping, contact), located by the secant method to about h^3, and where a servo
    looks.

    Parameters
    ----------
    body : (n, 11), columns as in ``bodies``; SI units.
    gravity : m/s^2.
    fixed : (n,) bool, coordinates that are locked for the whole trial.
    law, at, par : (k,) law numbers, (k, 2) coordinates, (k, 8) parameters.
    table : (rows, 2), tables that laws interpolate; their rows are among the laws' parameters.
    mode, z : (k,) and (k, 2), contact or sticking modes, and memories, at the start.
    q0, w0 : (n,) coordinates and speeds at the start.
    start : s, time at the first instant, as the laws see it.

    Returns
    -------
    Angles (count + 1, n) rad, speeds (count + 1, n) rad/s.
    """
    n, m = body.shape[0], law.shape[0]
    angle, speed = np.empty((count + 1, n)), np.empty((count + 1, n))
    held, load = fixed.copy(), np.zeros(m)
    tau, force = np.zeros(n), np.zeros((n, 3))
    a1, d1 = np.zeros(n), np.zeros((m, 2))
    v, m3, s = np.zeros((7, n)), np.zeros((4, m, 2)), np.zeros((n, 15))
    q, w, z = q0.copy(), w0.copy(), z.copy()
    qn, wn, zn = q.copy(), w.copy(), z.copy()
    due, summed = np.full(m, start), z[:, 1].copy()
    for k in range(m):
        if law[k] in STUCK_LAWS:
            i = at[k, 0]
            mode[k] = 0 if w[i] == 0.0 else (1 if w[i] > 0.0 else -1)
            held[i] = fixed[i] or mode[k] == 0
    angle[0], speed[0] = q, w
    _look_if_due(law, at, par, table, due, summed, True, start, q, w, z)
    derivative(body, gravity, held, law, at, par, table, mode, start, 0.0, q, w, w, z, tau, a1, force, load, d1, s)
    for step in range(count):
        rest, cuts = h, 0
        while rest > 0.0:
            t = start + (step + 1) * h - rest
            soonest = _look_if_due(law, at, par, table, due, summed, False, t, q, w, z)
            part = soonest - t if soonest < t + rest - SAME_TIME else rest
            derivative(body, gravity, held, law, at, par, table, mode, t, 0.0, q, w, w, z, tau, a1, force, load, d1, s)
            while _release(law, at, par, mode, held, fixed, tau, force, load):
                derivative(
                    body, gravity, held, law, at, par, table, mode, t, 0.0, q, w, w, z, tau, a1, force, load, d1, s
                )
            _advance(
                body, gravity, held, law, at, par, table, mode,
                t, part, q, w, z, a1, d1, tau, force, load, qn, wn, zn, v, m3, s,
            )  # fmt: skip
            used, first = part, -1
            for k in range(m):
                if _margin(k, law, at, par, mode, fixed, qn, wn, zn) < 0.0:
                    if cuts > 12:  # chatter: the event is applied at the end of the step
                        first = k
                        continue
                    used, first = _locate(
                        k, used, first,
                        body, gravity, held, law, at, par, table, mode, fixed,
                        t, q, w, z, a1, d1, tau, force, load, qn, wn, zn, v, m3, s,
                    )  # fmt: skip
            q[:], w[:], z[:, :] = qn, wn, zn
            if first >= 0:
                _apply_event(first, law, at, par, mode, held, q, w, z)
                cuts += 1
            rest = rest - used if first >= 0 or part < rest else 0.0
        angle[step + 1], speed[step + 1] = q, w
    return angle, speed


@njit
def _locate(
    k, used, first,
    body, gravity, held, law, at, par, table, mode, fixed,
    t, q, w, z, a1, d1, tau, force, load, qn, wn, zn, v, m3, s,
):  # fmt: skip
    """Shorten the step to the event of law ``k`` if it comes before ``used``; the state is then at the new end."""
    low, at_low = 0.0, max(_margin(k, law, at, par, mode, fixed, q, w, z), 0.0)
    high, at_high = used, _margin(k, law, at, par, mode, fixed, qn, wn, zn)
    if at_high >= 0.0:
        return used, first
    here = used
    for _ in range(3):
        here = low + (high - low) * at_low / (at_low - at_high) if at_low > 0.0 else 0.0
        _advance(
            body, gravity, held, law, at, par, table, mode,
            t, here, q, w, z, a1, d1, tau, force, load, qn, wn, zn, v, m3, s,
        )  # fmt: skip
        value = _margin(k, law, at, par, mode, fixed, qn, wn, zn)
        if here == 0.0 or value == 0.0:
            break
        if value < 0.0:
            high, at_high = here, value
        else:
            low, at_low = here, value
    return here, k
