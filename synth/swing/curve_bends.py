"""Sharp bends of damper curves: a step that passes one is repeated up to it.

A curve that is nearly dry friction has such a bend. The acceleration changes there within a step so much that the
estimated error of the rates, a difference of a few stages, may miss it. Weaker bends are left to the estimate.
"""

from __future__ import annotations

from typing import Any

from numba import njit

from synth.compiling.numba_internals import UNCOUNTED
from synth.swing.curve_clocks import CUT, ENDED, ERROR, SOLVED, of_alike
from synth.swing.lane_layout import CURVE_POINTS, LANES
from synth.swing.stage_rows import NODES, WIDTH, place

_SPEED, _STAGE, _CURVE_SPEED, _CURVE_SLOPE, _SHARP = (
    place(block) for block in ("rate", "stage_rate", "curve_speed", "curve_slope", "sharp_bend")
)
_C1, _C2 = NODES[:2].tolist()  # of Radau IIA, see ``stage_rows``
_CURVE = CURVE_POINTS * LANES
SHARPNESS = 0.8  # share of the slope that ends at a bend; at those of power laws and measured tables it is below 0.6
NONE = 1e9  # rad/s, beyond any joint's speed
EARLY, LATE = 0.05, 0.95  # shares of a step; a bend nearer to its ends changes little

_called: dict[str, Any] = {"fastmath": True, "error_model": "numpy", "nogil": True, **UNCOUNTED}


@njit(**_called)
def find_sharp(n, S):  # type: ignore[no-untyped-def]
    """Find the speed of each joint's first sharp bend in each lane; whether there is any."""
    found = False
    for j in range(n):
        for lane in range(LANES):
            slope, sharp = 0.0, NONE
            for k in range(CURVE_POINTS):
                m = CURVE_POINTS - 1 - k
                ends = S[_CURVE_SLOPE + j * _CURVE + m * LANES + lane]
                slope += ends
                if ends > SHARPNESS * slope and k > 0 and S[_CURVE_SPEED + j * _CURVE + m * LANES + lane] < NONE:
                    sharp = S[_CURVE_SPEED + j * _CURVE + m * LANES + lane]
            S[_SHARP + j * LANES + lane] = sharp
            found = found or sharp < NONE
    return found


@njit(**_called)
def _passed(speed, w0, w1, w2, w3):  # type: ignore[no-untyped-def]
    """Share of a step after which a rate first passes a speed, by a line from stage to stage; 1 if it does not."""
    f0, f1, f2, f3 = w0 - speed, w1 - speed, w2 - speed, w3 - speed
    third = _C2 + (1.0 - _C2) * f2 / (f2 - f3) if f2 * f3 < 0.0 else 1.0
    second = _C1 + (_C2 - _C1) * f1 / (f1 - f2) if f1 * f2 < 0.0 else third
    first = _C1 * f0 / (f0 - f1) if f0 * f1 < 0.0 else 1.0
    return first if (first > EARLY) & (first < LATE) else second


@njit(**_called)
def find_passed(n, S):  # type: ignore[no-untyped-def]
    """Find for each lane whose step would be kept the share of it behind the first sharp bend; 0 without one."""
    for lane in range(LANES):
        S[CUT + lane] = 0.0
    for j in range(n):
        for lane in range(LANES):
            e = (j * LANES & (WIDTH - 1)) + lane
            w0, w1, w2, w3 = S[_SPEED + e], S[_STAGE + e], S[_STAGE + WIDTH + e], S[_STAGE + 2 * WIDTH + e]
            speed = S[_SHARP + e]
            share = min(_passed(speed, w0, w1, w2, w3), _passed(-speed, w0, w1, w2, w3))
            kept = (S[ENDED + lane] != 0.0) & (S[SOLVED + lane] != 0.0) & (S[ERROR + lane] <= 1.0)
            S[CUT + lane] = max(S[CUT + lane], 1.0 - share) if kept & (share < LATE) else S[CUT + lane]
    of_alike(CUT, S)
