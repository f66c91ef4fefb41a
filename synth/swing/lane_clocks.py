"""Clocks of sixteen lanes that step together: each lane's own step, its size, and whether it is kept.

See ``friction_integrator``. The numbers of the lanes have places in its array ``S``. Lanes that start alike, as
perturbed copies of a leg do, have one of them as leader: their steps are of one size.
"""

from __future__ import annotations

import math
from typing import Any

from numba import int64, njit

from synth.compiling.numba_internals import UNCOUNTED
from synth.swing.explicit_steps import BACK, DUE, K1, XW, V, X
from synth.swing.lane_layout import LANES, PLACE
from synth.swing.turning_events import NEVER

# Of the step control, as in ``chain_integrator``, but with a larger reserve: a rejected step costs as much as
# one that is kept. Tuned for speed on the legs of ``make bench``.
_SAFE, _LEAST, _MOST = 0.85, 0.2, 5.0
LEAST_PREVIOUS = 1e-4 ** (5 / 128)  # power of the least error that counts as the last one, 1e-4 as in ``dopri5``
MOST_CUTS = 20  # of one step of a lane, as in ``chain_integrator``
# Differences of two starts that count as those of a leg and its perturbed copy: rad, rad/s, rad/s^2, and a share of the
# accelerations.
ALIKE_ANGLE, ALIKE_RATE, ALIKE_ACCELERATION, ALIKE_SHARE = 0.01, 0.3, 10.0, 0.02
# Places of numbers of the lanes: their own step, clock and size of the steps, s; the time from the start of the step to
# a turn, s, and how often it was cut there; 1 if the step was kept; the index of the next sample; the share of the
# tolerance and a power of the last one; the lane with the same size of steps.
OWN, CLOCK, SIZE, CUT, CUTS, MOVED, COMING, ERROR, PREVIOUS, LEADER, LONGEST, ANY_MOVED = (
    BACK + k * LANES for k in range(2, 14)
)
STEP = DUE  # of each entry of a state, s

_called: dict[str, Any] = {"fastmath": True, "error_model": "numpy", "nogil": True, **UNCOUNTED}


@njit(**_called)
def find_leaders(n, S):  # type: ignore[no-untyped-def]
    """Find for each lane the first that starts as it does: perturbed copies of a leg have one leader."""
    for lane in range(LANES):
        S[LEADER + lane] = lane
        for other in range(lane):
            alike, difference, total = S[LEADER + other] == other, 0.0, ALIKE_ACCELERATION / ALIKE_SHARE
            for i in range(n):
                a, b = i * LANES + lane, i * LANES + other
                alike = alike and abs(S[X + a] - S[X + b]) < ALIKE_ANGLE and abs(S[XW + a] - S[XW + b]) < ALIKE_RATE
                difference += abs(S[K1 + a] - S[K1 + b])
                total += abs(S[K1 + a]) + abs(S[K1 + b])
            if alike and difference < ALIKE_SHARE * total:
                S[LEADER + lane] = other
                break


@njit(**_called)
def own_steps(end, S, rows):  # type: ignore[no-untyped-def]
    """Find each lane's step: its size, up to its turn or the end; 0 of a lane that is at the end.

    It is written to so many rows, for all states.
    """
    for lane in range(LANES):
        S[OWN + lane] = min(S[CUT + lane] if S[CUT + lane] < NEVER else S[SIZE + lane], end - S[CLOCK + lane])
    for j in range(rows):
        for lane in range(LANES):
            S[STEP + (j * LANES & PLACE) + lane] = S[OWN + lane]


@njit(**_called)
def find_errors(S, n_state):  # type: ignore[no-untyped-def]
    """Find for each lane the largest ratio of error to tolerance of all lanes with the same leader."""
    share = 1.0 / n_state
    for lane in range(LANES):
        S[V + lane] = S[V + lane] * share
        S[ERROR + lane] = 1e-24
    for lane in range(LANES):
        first = ERROR + (int64(S[LEADER + lane]) & (LANES - 1))
        S[first] = S[first] if S[V + lane] <= S[first] else S[V + lane]  # nan stays
    for lane in range(LANES):
        S[V + lane] = S[ERROR + (int64(S[LEADER + lane]) & (LANES - 1))]
    for lane in range(LANES):
        S[ERROR + lane] = math.sqrt(S[V + lane])


@njit(**_called)
def keep(S):  # type: ignore[no-untyped-def]
    """Decide which lanes keep their step: those without a turn within it whose error is allowed. Whether any does."""
    kept = 0.0
    for lane in range(LANES):
        good, turns = S[ERROR + lane] <= 1.0, S[CUT + lane] < NEVER
        cuts = S[CUTS + lane] + (1.0 if good & turns else 0.0)
        moved = good & (S[OWN + lane] > 0.0) & ((not turns) | (cuts > MOST_CUTS))
        S[CUT + lane] = S[CUT + lane] if good & (not moved) else NEVER
        S[CUTS + lane] = 0.0 if moved else cuts
        S[MOVED + lane] = 1.0 if moved else 0.0
        kept += S[MOVED + lane]
    return kept > 0.0


@njit(**_called)
def advance(end, S):  # type: ignore[no-untyped-def]
    """Move the clocks of the lanes that keep their step; whether all are at the end."""
    under_way = 0.0
    for lane in range(LANES):
        left = end - S[CLOCK + lane]
        moved = end if S[OWN + lane] >= left else S[CLOCK + lane] + S[OWN + lane]
        S[CLOCK + lane] = moved if S[MOVED + lane] != 0.0 else S[CLOCK + lane]
        under_way += 1.0 if S[CLOCK + lane] < end else 0.0
    return under_way == 0.0


@njit(**_called)
def resize(S):  # type: ignore[no-untyped-def]
    """Change the size of each lane's steps by its error; returns the smallest. Lanes with one leader have one size.

    As in ``chain_integrator``, but powers are products of square roots, which are vectorised: the exponents are 11/64
    and 5/128 for 0.17 and 0.04, and 13/64 for 0.2.
    """
    for lane in range(LANES):
        S[LONGEST + lane], S[ANY_MOVED + lane] = 0.0, 0.0
    for lane in range(LANES):
        first = int64(S[LEADER + lane]) & (LANES - 1)
        S[LONGEST + first] = max(S[LONGEST + first], S[OWN + lane])
        S[ANY_MOVED + first] = max(S[ANY_MOVED + first], S[MOVED + lane])
    for lane in range(LANES):
        error, own, size = S[ERROR + lane], S[LONGEST + lane], S[SIZE + lane]
        good, moved = error <= 1.0, S[ANY_MOVED + lane] > 0.0
        known = max(error if error < 1e12 else 1e12, 1e-12)  # also if it is nan
        eighth = math.sqrt(math.sqrt(math.sqrt(known)))
        of_16 = math.sqrt(eighth)
        of_32 = math.sqrt(of_16)
        of_64 = math.sqrt(of_32)
        rising = max(_LEAST, min(_MOST, _SAFE * S[PREVIOUS + lane] / (eighth * of_32 * of_64)))
        falling = max(_LEAST, _SAFE / (eighth * of_16 * of_64))
        # A step that was cut at a turn tells only that the next may be longer than it.
        grown = max(own * rising, size if own < size else 0.0)
        S[PREVIOUS + lane] = max(of_32 * math.sqrt(of_64), LEAST_PREVIOUS) if moved else S[PREVIOUS + lane]
        S[SIZE + lane] = grown if moved else (size if good | (own == 0.0) else own * falling)
    least = NEVER
    for lane in range(LANES):
        S[SIZE + lane] = S[SIZE + int64(S[LEADER + lane])]
        least = min(least, S[SIZE + lane])
    return least
