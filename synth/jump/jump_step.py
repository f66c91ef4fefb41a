"""One step for sixteen jumps in common: Bogacki and Shampine's 3(2) pair, linearly implicit in what brakes the motor.

Coefficients: Bogacki & Shampine, Applied Mathematics Letters 2 (1989) 321-325; the last stage is the next step's
first. In flight the motor stands, held by its friction, whose smoothed sign decays at up to 3e4/s. A maker's line
without rotor inertia decays at up to 9e6/s (25D LP 6V 498.87:1, links of 5 cm), the leg's stop at up to 6e6/s where a
strong motor presses a light link on it. The friction alone would limit an explicit step to a sixth of what its accuracy
needs, line and stop to far less. So this part A of the Jacobian is treated as in a W-method (Steihaug & Wolfbrandt,
Mathematics of Computation 33 (1979) 521-534; Hairer & Wanner, *Solving Ordinary Differential Equations II*, section
IV.7):

    (1 - g h A) k_i = f(x + h sum_j a_ij k_j) + h A sum_j g_ij k_j,    x_new = x + h sum_i b_i k_i

A is one column, the slopes of the accelerations over the motor's rate by friction, gear, a maker's line and the stop
(rows ``own_slope`` of the right-hand side at the start of the step), so that the solution is one division. Of a line it
has what exceeds ``jump_source.EXPLICIT_DECAY``. The g_ij follow from the conditions
of a W-method up to the third order but for that of A A f, whose error is g^2/2 h^3; g from a motion of A alone, which
is damped for all steps, and at once for a large one. With A = 0 the pair is the explicit one. The winding, which decays
at 4e3/s, is not part of A: its error of that kind made clearances 0.14 mm wrong where they are 0.05 mm wrong now.

It is inlined into the loops that use it (``jump_integrator.jump``, ``recorder.record``).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from numba import njit

from synth.jump.jump_layout import LANES

G = 0.2837703455755491  # the stability function of A alone then vanishes for large steps: ``tests/hopper/test_step``
# From the order conditions of a W-method (the same test).
G21, G31, G32 = -1.5 * G, 1.125 * G, -2.25 * G

# In the norm of the error, where metres and radians have 1: of their rates a second, and of a winding's current, A.
RATE_WEIGHT, CURRENT_WEIGHT = 1.0 / 30.0, 0.3

# First indices of state, derivatives of the stages, slopes, weights and auxiliary lanes in the step's own array. With
# constant indices in one array LLVM can prove that stores and loads do not overlap; separate arrays would cost checks.
_ROOM = 12 * LANES  # the largest state has 11 rows
_X, _K0, _K1, _K2, _K3, _A, _W, _V, _C = (k * _ROOM for k in range(9))
_INVERSE, _RATE, _C0, _C1, _C2, _ERROR = (_C + k * LANES for k in range(6))
ROOM = 9 * _ROOM + 6 * LANES  # doubles
_PLACE = (1 << 48) - 1  # mask that excludes negative indices; wrap-around indexing would need a gather instruction


def compiled_step(rules: Mapping[str, Any]) -> tuple[Any, Any, Any]:
    """``_views``, ``_try_step`` and ``_take``, compiled with a loop's own floating-point ``rules``.

    Inlined as Python they would count references at every step; cached separately they would be shared by
    loops with different rules.
    """
    return njit(**rules)(_views), njit(**rules)(_try_step), njit(**rules)(_take)


def _views(S, n):  # type: ignore[no-untyped-def]
    """State, derivatives at its start and at its end, slopes (n_own, 16), and each lane's squared error (16,)."""
    n_own = (n - 3) // 2
    size = n * LANES
    for j in range(n):
        weight = 1.0 if j <= n_own else (RATE_WEIGHT if j < n - 2 else (CURRENT_WEIGHT if j == n - 2 else 0.0))
        for lane in range(LANES):
            S[_W + j * LANES + lane] = weight
    return (
        S[_X : _X + size].reshape(n, LANES),
        S[_K0 : _K0 + size].reshape(n, LANES),
        S[_K3 : _K3 + size].reshape(n, LANES),
        S[_A : _A + n_own * LANES].reshape(n_own, LANES),
        S[_ERROR : _ERROR + LANES],
    )


def _try_step(rhs, Z, F, S, n, d, h, tolerance):  # type: ignore[no-untyped-def]
    """Advance the state in ``S`` by ``h`` s.

    The new state is in the first rows of ``Z`` (n_row, 16), in ``F`` the same memory as a flat array. See ``_views``
    for what ``S`` holds before and after; the error is a sum of squares over ``tolerance`` in metres, radians, and
    their rates over 30 per second. ``n`` : rows of the state; ``d`` : row of the derivative in ``Z``.

    The solution of a stage is k = f + A c, with c = s + g h k of the motor's rate and s that component of the sum
    over the stages before.
    """
    size, g = (n & 15) * LANES, h * G
    own = ((n - 3) // 2 & 15) * LANES
    first = (own + LANES) & _PLACE
    turning = (first + LANES) & _PLACE
    D = (d * LANES) & _PLACE
    for lane in range(LANES):
        S[_INVERSE + lane] = 1.0 / (1.0 - g * S[_A + LANES + lane])
        S[_RATE + lane] = S[_K0 + turning + lane] * S[_INVERSE + lane]
        S[_C0 + lane] = g * S[_RATE + lane]
    for e in range(size):
        F[e] = S[_X + e] + 0.5 * h * S[_K0 + e]
    for j in range(0, own, LANES):
        for lane in range(LANES):
            F[first + j + lane] += 0.5 * h * S[_A + j + lane] * S[_C0 + lane]
    rhs(Z)
    for e in range(size):
        S[_K1 + e] = F[D + e]
        F[e] = S[_X + e] + 0.75 * h * F[D + e]
    for lane in range(LANES):
        coupled = h * G21 * S[_RATE + lane]
        rate = (S[_K1 + turning + lane] + S[_A + LANES + lane] * coupled) * S[_INVERSE + lane]
        S[_C1 + lane] = coupled + g * rate
        S[_RATE + lane] = h * (G31 * S[_RATE + lane] + G32 * rate)
    for j in range(0, own, LANES):
        for lane in range(LANES):
            F[first + j + lane] += 0.75 * h * S[_A + j + lane] * S[_C1 + lane]
    rhs(Z)
    for e in range(size):
        S[_K2 + e] = F[D + e]
        F[e] = S[_X + e] + h / 9.0 * (2.0 * S[_K0 + e] + 3.0 * S[_K1 + e] + 4.0 * F[D + e])
    for lane in range(LANES):
        coupled = S[_RATE + lane]
        rate = (S[_K2 + turning + lane] + S[_A + LANES + lane] * coupled) * S[_INVERSE + lane]
        S[_C2 + lane] = coupled + g * rate
        S[_RATE + lane] = h / 9.0 * (2.0 * S[_C0 + lane] + 3.0 * S[_C1 + lane] + 4.0 * S[_C2 + lane])
    for j in range(0, own, LANES):
        for lane in range(LANES):
            F[first + j + lane] += S[_A + j + lane] * S[_RATE + lane]
    rhs(Z)
    for e in range(size):
        S[_K3 + e] = F[D + e]
        S[_V + e] = -5.0 / 72.0 * S[_K0 + e] + S[_K1 + e] / 12.0 + S[_K2 + e] / 9.0 - F[D + e] / 8.0
    # The stage of the error estimate alone: g_4j = -2 g b_j satisfies the condition of second order.
    for lane in range(LANES):
        coupled = -2.0 * G * (F[turning + lane] - S[_X + turning + lane])
        rate = (S[_K3 + turning + lane] + S[_A + LANES + lane] * coupled) * S[_INVERSE + lane]
        last = coupled + g * rate
        S[_RATE + lane] = -5.0 / 72.0 * S[_C0 + lane] + S[_C1 + lane] / 12.0 + S[_C2 + lane] / 9.0 - last / 8.0
        S[_ERROR + lane] = 0.0
    for j in range(0, own, LANES):
        for lane in range(LANES):
            S[_V + first + j + lane] += S[_A + j + lane] * S[_RATE + lane]
    for j in range(0, size, LANES):
        for lane in range(LANES):
            v = S[_V + j + lane] * S[_W + j + lane] * (h / tolerance)
            S[_ERROR + lane] += v * v


def _take(F, S, n, d):  # type: ignore[no-untyped-def]
    """Let the next step begin at the state in ``F``, from the derivative and the slopes that were computed last."""
    size, own = (n & 15) * LANES, ((n - 3) // 2 & 15) * LANES
    D = (d * LANES) & _PLACE
    for e in range(size):
        S[_X + e] = F[e]
        S[_K0 + e] = F[D + e]
    for e in range(own):
        S[_A + e] = F[D + size + e]
