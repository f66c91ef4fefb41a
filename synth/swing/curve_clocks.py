"""Clocks of sixteen lanes that step implicitly: whose step has ended, whether it is kept, and how long the next is.

See ``curve_integrator``. The numbers of the lanes have rows in its working array (``stage_rows.CLOCKS``). Lanes that
start alike, as perturbed copies of a leg do, have one of them as leader: they iterate together and their steps are of
one size, so that they remain smooth functions of the perturbation.
"""

from __future__ import annotations

import math
from typing import Any

from numba import int64, njit

from synth.compiling.numba_internals import UNCOUNTED
from synth.swing.lane_clocks import ALIKE_ACCELERATION, ALIKE_ANGLE, ALIKE_RATE, ALIKE_SHARE
from synth.swing.lane_layout import LANES
from synth.swing.stage_rows import CLOCKS, MASSES, WIDTH, mass_entry, place

(
    CLOCK, SIZE, RATIO, BEFORE, PREVIOUS, ITERATIONS, LAST, ENDED, SOLVED, MOVED, COMING, LEADER, ERROR, CUT, STEPS,
    LARGEST,
) = (place(row) for row in CLOCKS)  # fmt: skip
_STEP, _CHANGE, _ANGLE, _SPEED, _START, _SLOPE, _DAMPERS, _TORQUE = (
    place(row) for row in ("step", "change", "angle", "rate", "start", "start_slope", "damper", "start_torque")
)
_FORCE = _START + MASSES * LANES
ALIKE_DAMPING = 1.0  # 1/s; as ``ALIKE_ACCELERATION``, of slope over inertia at rest
FIRST_STEP = 1e-4  # s; from rest a steep curve takes hold within this time
SHORTEST = 1e-10  # s, as in ``chain_integrator``
MOST_ITERATIONS = 8  # of Newton's method; two or three are usual, at the bends of a curve five
# Largest change of a rate by an iteration, as a share of its tolerance, after which no further one is made. The second
# iteration corrects a twentieth of the first, later ones less; with 1e-3 and 3e-2 the errors of power laws, tables and
# friction-like curves in three links are the same, after a quarter more iterations.
FIRST_CHANGE, LATER_CHANGE = 3e-2, 1.0
SLOW = 0.1  # ratio of two changes above which the matrix is made anew: its slopes are those of other segments
# Step control, tuned for speed on the legs of ``make bench`` (a larger share rejects more steps): share of the step
# that the error would allow; smallest and largest change of a step; the least error that counts as the last one, to the
# power 3/64.
_SAFE, _LEAST, _MOST = 0.8, 0.2, 4.0
LEAST_PREVIOUS = 1e-4 ** (3 / 64)

_called: dict[str, Any] = {"fastmath": True, "error_model": "numpy", "nogil": True, **UNCOUNTED}


@njit(**_called)
def start(begin, longest, S):  # type: ignore[no-untyped-def]
    """Set the lanes' clocks; ``longest`` : s from the first sample to the last."""
    for lane in range(LANES):
        S[CLOCK + lane], S[SIZE + lane], S[BEFORE + lane] = begin, min(FIRST_STEP, longest), 1.0
        S[PREVIOUS + lane], S[ITERATIONS + lane], S[LAST + lane] = LEAST_PREVIOUS, 0.0, 1e300
        S[ENDED + lane], S[COMING + lane], S[STEPS + lane], S[CUT + lane] = 1.0, 1.0, 0.0, 0.0


@njit(**_called)
def find_leaders(n, S):  # type: ignore[no-untyped-def]
    """Find for each lane the first that starts as it does, by angles, rates, accelerations and damping of each joint.

    An acceleration is the joint's torque over its own entry of the mass matrix.
    """
    for lane in range(LANES):
        S[LEADER + lane] = lane
        for other in range(lane):
            alike, differs, all_of = S[LEADER + other] == other, 0.0, ALIKE_ACCELERATION / ALIKE_SHARE
            damps, damping = 0.0, ALIKE_DAMPING / ALIKE_SHARE
            diagonal = 0
            for i in range(n):
                a, b = i * LANES + lane, i * LANES + other
                alike = alike and abs(S[_ANGLE + a] - S[_ANGLE + b]) < ALIKE_ANGLE
                alike = alike and abs(S[_SPEED + a] - S[_SPEED + b]) < ALIKE_RATE
                mine, its = S[_START + diagonal * LANES + lane], S[_START + diagonal * LANES + other]
                first, second = (S[_FORCE + a] - S[_TORQUE + a]) / mine, (S[_FORCE + b] - S[_TORQUE + b]) / its
                differs += abs(first - second)
                all_of += abs(first) + abs(second)
                first, second = (S[_SLOPE + a] + S[_DAMPERS + a]) / mine, (S[_SLOPE + b] + S[_DAMPERS + b]) / its
                damps += abs(first - second)
                damping += abs(first) + abs(second)
                diagonal += n - i
            if alike and differs < ALIKE_SHARE * all_of and damps < ALIKE_SHARE * damping:
                S[LEADER + lane] = other
                break


@njit(**_called)
def of_alike(row, S):  # type: ignore[no-untyped-def]
    """Replace each lane's number in a row by the largest of all lanes with the same leader; nan stays."""
    for lane in range(LANES):
        S[LARGEST + lane] = 0.0
    for lane in range(LANES):
        first = LARGEST + (int64(S[LEADER + lane]) & (LANES - 1))
        S[first] = S[first] if S[row + lane] <= S[first] else S[row + lane]
    for lane in range(LANES):
        S[row + lane] = S[LARGEST + (int64(S[LEADER + lane]) & (LANES - 1))]


@njit(**_called)
def judge(scale, S):  # type: ignore[no-untyped-def]
    """Find the lanes whose step has ended, its equations solved or not; ``scale`` : 1 over the tolerance of a rate.

    Returns whether any has, and whether the matrix must be made anew for one that has not.
    """
    of_alike(_CHANGE, S)
    ended, anew = 0.0, 0.0
    for lane in range(LANES):
        change, count = S[_CHANGE + lane], S[ITERATIONS + lane]
        solved = change * scale < (FIRST_CHANGE if count == 0.0 else LATER_CHANGE)
        under_way = S[_STEP + lane] > 0.0
        ends = under_way & (solved | (count >= MOST_ITERATIONS - 1.0))
        S[SOLVED + lane], S[ENDED + lane] = 1.0 if solved else 0.0, 1.0 if ends else 0.0
        ended += S[ENDED + lane]
        anew += 1.0 if under_way & (not ends) & (change > SLOW * S[LAST + lane]) else 0.0
        S[LAST + lane] = 1e300 if ends else change
        S[ITERATIONS + lane] = 0.0 if ends else count + 1.0
    return ended > 0.0, anew > 0.0


@njit(**_called)
def keep(S):  # type: ignore[no-untyped-def]
    """Decide which of the ended steps are kept: solved ones with an allowed error and no sharp bend. Whether any is."""
    kept = 0.0
    for lane in range(LANES):
        moved = (S[ENDED + lane] != 0.0) & (S[SOLVED + lane] != 0.0) & (S[ERROR + lane] <= 1.0)
        moved = moved & (S[CUT + lane] == 0.0)
        S[MOVED + lane] = 1.0 if moved else 0.0
        kept += S[MOVED + lane]
    return kept > 0.0


@njit(**_called)
def advance(end, S):  # type: ignore[no-untyped-def]
    """Move the clocks of the lanes that keep their step."""
    for lane in range(LANES):
        left, own = end - S[CLOCK + lane], S[_STEP + lane]
        moved = S[MOVED + lane] != 0.0
        S[CLOCK + lane] = (end if own >= left else S[CLOCK + lane] + own) if moved else S[CLOCK + lane]
        S[BEFORE + lane] = own if moved else S[BEFORE + lane]


@njit(**_called)
def resize(S):  # type: ignore[no-untyped-def]
    """Change the size of the steps of lanes whose step has ended, by its error.

    Proportional-integral control for an estimate of order 3, as in ``chain_integrator``, with powers as products of
    square roots, which are vectorised: 7/32 of the error and 3/64 of the last; 1/4 after a rejected step.
    """
    for lane in range(LANES):
        error, moved = S[ERROR + lane], S[MOVED + lane] != 0.0
        known = max(error if error < 1e12 else 1e12, 1e-12)  # also if it is nan
        of_4 = math.sqrt(math.sqrt(known))
        of_8 = math.sqrt(of_4)
        of_16 = math.sqrt(of_8)
        of_32 = math.sqrt(of_16)
        rising = min(_MOST, _SAFE * S[PREVIOUS + lane] / (of_8 * of_16 * of_32))
        falling = _SAFE / of_4 if S[SOLVED + lane] != 0.0 else 0.5
        factor = max(_LEAST, rising if moved else falling)
        factor = 1.0 - S[CUT + lane] if S[CUT + lane] > 0.0 else factor
        ended = S[ENDED + lane] != 0.0
        S[PREVIOUS + lane] = max(of_32 * math.sqrt(of_32), LEAST_PREVIOUS) if moved else S[PREVIOUS + lane]
        S[SIZE + lane] = S[_STEP + lane] * factor if ended else S[SIZE + lane]
        S[STEPS + lane] += S[ENDED + lane]


@njit(**_called)
def own_steps(end, most, n, S):  # type: ignore[no-untyped-def]
    """Set the next step of lanes whose step has ended, up to the end; 0 of a lane that is there, or that is lost.

    Returns whether a lane is under way, and whether one is lost: it needs more than ``most`` steps, or too short ones.
    """
    under_way, lost = 0.0, 0.0
    for lane in range(LANES):
        left = end - S[CLOCK + lane]
        ended = S[ENDED + lane] != 0.0
        fails = ended & (left > 0.0) & ((S[SIZE + lane] < SHORTEST) | (S[STEPS + lane] >= most))
        own = (0.0 if fails else min(S[SIZE + lane], left)) if ended else S[_STEP + lane]
        S[RATIO + lane] = own / S[BEFORE + lane]
        S[_STEP + lane] = own
        under_way += 1.0 if own > 0.0 else 0.0
        lost += 1.0 if fails else 0.0
    for j in range(1, n):
        for lane in range(LANES):
            S[_STEP + (j * LANES & (WIDTH - 1)) + lane] = S[_STEP + lane]
    return under_way > 0.0, lost > 0.0


assert mass_entry(1, 1, 3) == 3  # the order of the diagonal in ``find_leaders``
