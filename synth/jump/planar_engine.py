"""The full planar five-bar: body with x, y and pitch, independent sides, a foot that can slip.

Every piece has its own absolute angle and the two feet are joined by two constraint equations, so only the parameters
are shared with the symmetric lanes: the two forms check each other. Coordinates q = (x, y, pitch,
angles of the right side's pieces, angles of the left side's), angles from straight down, counter-clockwise positive.
With J the constraints' Jacobian (foot right - foot left = 0),

    [ M  J' ] [ q''    ]   [ f                                     ]
    [ J  0  ] [ lambda ] = [ -J' q' - 2 alpha J q' - alpha^2 c(q)  ]

(Featherstone, Rigid Body Dynamics Algorithms, 2008, section 3.2; the last two terms are Baumgarte's, Computer Methods
in Applied Mechanics and Engineering 1 (1972) 1-16, with alpha = 300/s). The gears' torques enter linearly and are
solved for as in the lanes. Motor and gear are ``synth.drives.motor_law``, inlined. Steps are those of the same
Bogacki-Shampine pair.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from synth.compiling.compiled import compiled_when_called
from synth.drives.motor_law import after_friction, current_change, direction, steady_line, transmitted_share
from synth.jump.outcomes import COLLAPSED, LANDED_AGAIN, LIFTED, TOO_STIFF, TOO_WEAK

BAUMGARTE = 300.0  # 1/s: constraint errors decay in 3 ms, slower than the shortest steps, faster than a push
_options: dict[str, Any] = {"error_model": "numpy", "nogil": True}

# Scalars of a planar jump, in the order in which they are passed.
SCALARS = (
    "half_spacing", "gravity", "hip_rate", "joint_damping", "hip_rest", "knee_rest", "foot_rest", "stop", "stop_rate",
    "stop_dissipation", "linear_torque", "torque_slope", "linear_current", "current_slope", "voltage", "resistance",
    "inverse_inductance", "back_emf", "torque_constant", "rotor_inertia", "friction", "viscous", "driving", "braking",
    "reverse_speed", "contact_stiffness", "contact_damping", "contact_dissipation", "may_pull",
    "knee_rate", "foot_rate",
)  # fmt: skip


@compiled_when_called(**_options)
def _eliminate(K, f):  # type: ignore[no-untyped-def]
    """Solve K x = f in place, f (n, m) becoming x: Gauss with partial pivoting (Golub & Van Loan, section 3.4).

    For (11, 3) it takes 1.1 us, numba's ``np.linalg.solve`` 2.0 us and scipy's LAPACK, which commands do not load.
    """
    n, m = f.shape
    for c in range(n):
        pivot = c
        for r in range(c + 1, n):
            if abs(K[r, c]) > abs(K[pivot, c]):
                pivot = r
        if pivot != c:
            for k in range(n):
                K[c, k], K[pivot, k] = K[pivot, k], K[c, k]
            for k in range(m):
                f[c, k], f[pivot, k] = f[pivot, k], f[c, k]
        for r in range(c + 1, n):
            share = K[r, c] / K[c, c]
            if share != 0.0:
                for k in range(c, n):
                    K[r, k] -= share * K[c, k]
                for k in range(m):
                    f[r, k] -= share * f[c, k]
    for c in range(n - 1, -1, -1):
        for k in range(m):
            total = f[c, k]
            for j in range(c + 1, n):
                total -= K[c, j] * f[j, k]
            f[c, k] = total / K[c, c]


@compiled_when_called(**_options)
def _accelerations(q, v, current, lengths, masses, beams, body, ground, p, foot_mass):  # type: ignore[no-untyped-def]
    """Accelerations (n,), winding slopes, drawn currents and gear torques (2,), normal and friction force, foot."""
    half, gravity, b, hip_rest, knee_rest, foot_rest = p[0], p[1], p[3], p[4], p[5], p[6]
    hip_rate, knee_rate, foot_rate = p[2], p[29], p[30]
    m_side = len(lengths)
    knee = int(ground[2])
    n = 3 + 2 * m_side
    K = np.zeros((n + 2, n + 2))
    f = np.zeros((n + 2, 3))
    c0, s0 = math.cos(q[2]), math.sin(q[2])
    K[0, 0] += body[0]
    K[1, 1] += body[0]
    K[2, 2] += body[1]
    f[1, 0] -= body[0] * gravity
    foot = np.zeros((2, 2))
    foot_v = np.zeros((2, 2))
    tip = np.zeros((2, 2, n))  # Jacobian of each side's foot
    bias = np.zeros((2, 2))
    point = np.zeros((2, n))
    for side in range(2):
        out = 1.0 if side == 0 else -1.0
        first = 3 + side * m_side
        point[:] = 0.0
        point[0, 0] = point[1, 1] = 1.0
        point[0, 2], point[1, 2] = -out * half * s0, out * half * c0
        ax, ay = -out * half * c0 * v[2] ** 2, -out * half * s0 * v[2] ** 2
        px, py = q[0] + out * half * c0, q[1] + out * half * s0
        for i in range(m_side):
            j = first + i
            s, c = math.sin(q[j]), math.cos(q[j])
            length, mass = lengths[i], masses[i]
            point[0, j], point[1, j] = 0.5 * length * c, 0.5 * length * s
            bx, by = ax - 0.5 * length * s * v[j] ** 2, ay + 0.5 * length * c * v[j] ** 2
            for r in range(n):
                if point[0, r] == 0.0 and point[1, r] == 0.0:
                    continue
                f[r, 0] -= mass * (point[0, r] * bx + point[1, r] * (by + gravity))
                for t in range(n):
                    K[r, t] += mass * (point[0, r] * point[0, t] + point[1, r] * point[1, t])
            K[j, j] += mass * length**2 / 12.0
            point[0, j], point[1, j] = length * c, length * s
            ax, ay = ax - length * s * v[j] ** 2, ay + length * c * v[j] ** 2
            px, py = px + length * s, py - length * c
        foot[side, 0], foot[side, 1] = px, py
        bias[side, 0], bias[side, 1] = ax, ay
        tip[side] = point
        half_foot = 0.5 * foot_mass
        for r in range(n):
            foot_v[side, 0] += point[0, r] * v[r]
            foot_v[side, 1] += point[1, r] * v[r]
            f[r, 0] -= half_foot * (point[0, r] * ax + point[1, r] * (ay + gravity))
            for t in range(n):
                K[r, t] += half_foot * (point[0, r] * point[0, t] + point[1, r] * point[1, t])
    # ground under the foot
    at = 0.5 * (foot[0, 1] + foot[1, 1])
    vx, vy = 0.5 * (foot_v[0, 0] + foot_v[1, 0]), 0.5 * (foot_v[0, 1] + foot_v[1, 1])
    normal = 0.0
    if at < 0.0:
        normal = -p[25] * at * (1.0 - p[27] * vy) - p[26] * vy
        if p[28] == 0.0:
            normal = max(0.0, normal)
    slip = -ground[0] * max(0.0, normal) * vx / math.sqrt(vx * vx + ground[1] * ground[1])
    for side in range(2):
        for r in range(n):
            f[r, 0] += 0.5 * (normal * tip[side, 1, r] + slip * tip[side, 0, r])
    # flexures, bending, stops
    for side in range(2):
        out = 1.0 if side == 0 else -1.0
        h = 3 + side * m_side
        torque = hip_rate * (out * (q[h] - q[2]) - hip_rest) + b * out * (v[h] - v[2])
        past = max(0.0, p[7] - out * (q[h] - q[2]))
        torque -= p[8] * past * max(0.0, 1.0 - p[9] * out * (v[h] - v[2]))
        f[h, 0] -= out * torque
        f[2, 0] += out * torque
        u, w = h + knee - 1, h + knee
        torque = knee_rate * (out * (q[u] - q[w]) - knee_rest) + b * out * (v[u] - v[w])
        f[u, 0] -= out * torque
        f[w, 0] += out * torque
        for i in range(m_side - 1):
            if i != knee - 1:
                torque = beams[i] * (q[h + i + 1] - q[h + i])
                f[h + i, 0] += torque
                f[h + i + 1, 0] -= torque
    right, left = 3 + m_side - 1, 3 + 2 * m_side - 1
    torque = foot_rate * (q[left] - q[right] - foot_rest) + b * (v[left] - v[right])
    f[left, 0] -= torque
    f[right, 0] += torque
    # closure
    for axis in range(2):
        row = n + axis
        gap = foot[0, axis] - foot[1, axis]
        gap_v = foot_v[0, axis] - foot_v[1, axis]
        f[row, 0] = -(bias[0, axis] - bias[1, axis]) - 2 * BAUMGARTE * gap_v - BAUMGARTE**2 * gap
        for r in range(n):
            K[row, r] = K[r, row] = tip[0, axis, r] - tip[1, axis, r]
    for side in range(2):
        out = 1.0 if side == 0 else -1.0
        f[3 + side * m_side, 1 + side] = -out
        f[2, 1 + side] = out
    _eliminate(K, f)
    solved = f
    # motors and gears
    push, factor = np.zeros(2), np.zeros(2)
    slope, drawn = np.zeros(2), np.zeros(2)
    A = np.eye(2)
    for side in range(2):
        out = 1.0 if side == 0 else -1.0
        h = 3 + side * m_side
        omega = -out * (v[h] - v[2])
        sign = direction(omega, p[24])
        slope[side] = current_change(p[14], current[side], omega, p[15], p[17], p[16])
        drawn[side] = steady_line(p[12], p[13], omega) + current[side]
        torque = steady_line(p[10], p[11], omega) + p[18] * current[side]
        push[side] = after_friction(torque, sign, omega, p[20], p[21]) + p[19] * out * (solved[h, 0] - solved[2, 0])
        factor[side] = transmitted_share(push[side], sign, p[22], p[23])
        for other in range(2):
            A[side, other] -= factor[side] * p[19] * out * (solved[h, 1 + other] - solved[2, 1 + other])
    torques = factor * push
    whole = A[0, 0] * A[1, 1] - A[0, 1] * A[1, 0]
    gear = np.array([A[1, 1] * torques[0] - A[0, 1] * torques[1], A[0, 0] * torques[1] - A[1, 0] * torques[0]]) / whole
    acceleration = solved[:n, 0] + solved[:n, 1] * gear[0] + solved[:n, 2] * gear[1]
    return acceleration, slope, drawn, gear, normal, slip, 0.5 * (foot[0] + foot[1]), vy


@compiled_when_called(**_options)
def _derivative(x, n, arguments):  # type: ignore[no-untyped-def]
    lengths, masses, beams, body, ground, p, foot_mass = arguments
    found = _accelerations(
        x[:n], x[n : 2 * n], x[2 * n : 2 * n + 2], lengths, masses, beams, body, ground, p, foot_mass
    )
    out = np.empty(2 * n + 3)
    out[:n] = x[n : 2 * n]
    out[n : 2 * n] = found[0]
    out[2 * n : 2 * n + 2] = found[1]
    out[2 * n + 2] = p[14] * (found[2][0] + found[2][1])
    aside = np.array([found[4], found[5], found[6][0], found[6][1], found[7], found[3][0], found[3][1],
                      found[2][0] + found[2][1]])  # fmt: skip
    return out, aside


@compiled_when_called(**_options)
def integrate(x, n, arguments, weight, tolerance, ends, fall, mass, steps_of, trace):  # type: ignore[no-untyped-def]
    """State and outputs at every accepted step until the outcome is known; returns rows written and the status.

    ends : (2,) s, ``duration`` and ``longest`` of ``jump_integrator.jump``. steps_of : the first step and the longest,
    s, and the most steps: arguments, because a constant of another module would stay in the cached code.
    """
    K0, aside = _derivative(x, n, arguments)
    first_step, longest_step, max_steps = steps_of
    t, h, rows, steps = 0.0, first_step, 0, 0
    highest = 0.0
    trace[0, 0] = 0.0
    trace[0, 1 : 1 + len(x)] = x
    trace[0, 1 + len(x) :] = aside
    rows = 1
    while steps < max_steps and h > 1e-10:
        steps += 1
        K1, _ = _derivative(x + 0.5 * h * K0, n, arguments)
        K2, _ = _derivative(x + 0.75 * h * K1, n, arguments)
        new = x + h / 9.0 * (2.0 * K0 + 3.0 * K1 + 4.0 * K2)
        K3, aside_new = _derivative(new, n, arguments)
        e = h * (-5.0 / 72.0 * K0 + K1 / 12.0 + K2 / 9.0 - K3 / 8.0) * weight / tolerance
        error = math.sqrt(np.mean(e * e)) + 1e-30
        if error <= 1.0:
            t += h
            x, K0, aside = new, K3, aside_new
            if rows < len(trace):
                trace[rows, 0] = t
                trace[rows, 1 : 1 + len(x)] = x
                trace[rows, 1 + len(x) :] = aside
                rows += 1
            highest = max(highest, aside[3])
            speed = com_speed(x, n, arguments, mass)
            if highest > LIFTED and speed < -fall and (aside[4] < 0.0 or aside[3] <= 0.0):
                return rows, LANDED_AGAIN
            if t >= ends[0] and aside[3] <= 0.0 and highest > LIFTED:
                return rows, LANDED_AGAIN
            if x[1] <= 0.0:
                return rows, COLLAPSED
            if (t >= ends[0] and aside[3] <= 0.0) or t >= ends[1]:
                return rows, TOO_WEAK
        # Safety 0.9, between a fifth and four times: Hairer et al., Solving ODEs I, section II.4.
        factor = 0.9 * error ** (-1.0 / 3.0)
        if not (factor > 0.2):
            factor = 0.2
        h = min(h * min(4.0, factor), longest_step)
    return rows, TOO_STIFF


@compiled_when_called(**_options)
def com_speed(x, n, arguments, mass):  # type: ignore[no-untyped-def]
    """Vertical speed of the centre of mass, m/s."""
    lengths, masses, _, body, _, p, foot_mass = arguments
    m_side = len(lengths)
    total = body[0] * x[n + 1]
    for side in range(2):
        out = 1.0 if side == 0 else -1.0
        v = x[n + 1] + out * p[0] * math.cos(x[2]) * x[n + 2]
        for i in range(m_side):
            j = 3 + side * m_side + i
            total += masses[i] * (v + 0.5 * lengths[i] * math.sin(x[j]) * x[n + j])
            v += lengths[i] * math.sin(x[j]) * x[n + j]
        total += 0.5 * foot_mass * v
    return total / mass
