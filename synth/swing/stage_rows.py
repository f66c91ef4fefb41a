"""Layout of the implicit step's working array: places of its blocks, each of rows of sixteen lanes.

As in ``lane_layout``, places that are known at compile time let LLVM vectorise without checks for overlap.
"""

from __future__ import annotations

import numpy as np

from synth.swing.lane_layout import CURVE_POINTS, LANES, WORKING

STAGES = 3  # of Radau IIA of order 5
MOST_STAGED = 4  # links; the unrolled elimination has (3 n)^3 / 3 lines, 600 for four links and 3000 for seven
MASSES = MOST_STAGED * (MOST_STAGED + 1) // 2  # entries of a symmetric mass matrix
EVALUATED = MASSES + MOST_STAGED  # rows of mass matrix and torques at one state
PAIRS = STAGES * (STAGES + 1) // 2  # of stages, in the order of ``pair``
WIDTH = MOST_STAGED * LANES  # doubles of one quantity of all joints

# Rows of ``curve_clocks``: a lane's time and the size of its steps, s; the last kept step over the next one; the
# last error; the iterations of this step and the change by the one before; 1 if a step has ended, if its equations
# are solved, if it is kept; the index of the next sample; the first lane that starts alike; the error over the
# tolerance; the share of a step behind a sharp bend; the number of steps; largest values of alike lanes.
CLOCKS = (
    "clock", "size", "ratio", "before", "previous", "iterations", "last_change", "ended", "solved", "moved", "coming",
    "leader", "error", "cut", "steps", "largest",
)  # fmt: skip

_SIZES = {
    # Of each entry of a state its lane's step, s; largest change of a rate by the last iteration, relative to the
    # tolerance's scale.
    "step": MOST_STAGED, "change": 1,
    **dict.fromkeys(CLOCKS, 1),
    "angle": MOST_STAGED, "rate": MOST_STAGED,  # at the start of the step
    "start": EVALUATED, "start_torque": MOST_STAGED, "start_slope": MOST_STAGED,
    "spring": MOST_STAGED, "damper": MOST_STAGED,  # linear rates
    "stage_rate": STAGES * MOST_STAGED, "stages": STAGES * EVALUATED,
    "torque": STAGES * MOST_STAGED,  # of the damper, averaged over the step
    "course": STAGES * MOST_STAGED,  # coefficients of the rate over the share of the step
    "angle_error": MOST_STAGED, "rate_error": MOST_STAGED,
    "curve_speed": MOST_STAGED * CURVE_POINTS, "curve_slope": MOST_STAGED * CURVE_POINTS,
    "sharp_bend": MOST_STAGED,  # rad/s
}  # fmt: skip
# First row of each block.
_FIRSTS = dict(zip(_SIZES, np.cumsum([0, *_SIZES.values()]).tolist(), strict=False))
assert sum(_SIZES.values()) * LANES <= WORKING, "the blocks exceed the array that both integrators share"
# Of the array of single precision, from which Newton's matrix is made: a loop that mixes both precisions has only as
# many lanes in a register as doubles fit.
_SINGLE_SIZES = {
    "factors": (STAGES * MOST_STAGED) ** 2,  # of the eliminated matrix
    "curve_speed": MOST_STAGED * CURVE_POINTS, "curve_slope": MOST_STAGED * CURVE_POINTS,
    "stage_rate": STAGES * MOST_STAGED, "stages": STAGES * MASSES,
    "slope": PAIRS * MOST_STAGED,  # of the damper, averaged over the step
    "step": 1, "damper": MOST_STAGED, "spring": MOST_STAGED,  # linear rates, times the step and its square
    "residual": STAGES * MOST_STAGED,  # of the stages' equations, then their changes
}  # fmt: skip
_SINGLE_FIRSTS = dict(zip(_SINGLE_SIZES, np.cumsum([0, *_SINGLE_SIZES.values()]).tolist(), strict=False))
SINGLE_ROOM = sum(_SINGLE_SIZES.values()) * LANES


def place(block: str, row: int = 0) -> int:
    """First index of a row of a block in the flat array."""
    return (int(_FIRSTS[block]) + row) * LANES


def single_place(block: str, row: int = 0) -> int:
    """First index of a row of a block in the flat array of single precision."""
    return (int(_SINGLE_FIRSTS[block]) + row) * LANES


def pair(i: int, m: int) -> int:
    """Number of an entry of a symmetric matrix of stages."""
    i, m = min(i, m), max(i, m)
    return i * STAGES - i * (i - 1) // 2 + m - i


def mass_entry(i: int, j: int, n: int) -> int:
    """Number of an entry of a symmetric mass matrix of ``n`` links."""
    i, j = min(i, j), max(i, j)
    return i * n - i * (i - 1) // 2 + j - i


# Radau IIA of order 5: Hairer & Wanner, Solving ODEs II, 2nd ed. 1996, table IV.5.6. The step's end is the last stage.
_ROOT = 6.0**0.5
NODES = np.array([(4.0 - _ROOT) / 10.0, (4.0 + _ROOT) / 10.0, 1.0])
_POWERS = np.vander(NODES, increasing=True)
# Collocation: a stage's weights integrate the parabola through the stages from the start of the step.
INTEGRAL = (_POWERS * NODES[:, None] / np.arange(1.0, 4.0)) @ np.linalg.inv(_POWERS)
INVERSE = np.linalg.inv(INTEGRAL)
COURSE = np.linalg.inv(_POWERS)  # coefficients of 1, s, s^2 from the stages
WEIGHTS = INTEGRAL[-1]
# Error estimate of order 3 with the rate at the start: ibid., section IV.8, eqs. 8.17 to 8.20.
_REAL_ROOT = 3.6378342527444957  # the real eigenvalue of ``INVERSE``: 3 + 3^(2/3) - 3^(1/3), ibid.
FILTER = 1.0 / _REAL_ROOT
ERROR = FILTER / 3.0 * np.array([-13.0 - 7.0 * _ROOT, -13.0 + 7.0 * _ROOT, -1.0])
# rad/s of a rate's error that count as 1 rad of an angle's: those of a swing at 3 Hz, and this share of the rate (1/s)
# at which a damper ends a wrong speed: its least slope in the step over the joint's entry of the mass matrix. With 0
# legs with power laws and tables take 1.7 times the steps and err 0.5 to 0.9 times as much; with 1 they err 1.1 times
# as much.
RATE_SCALE, DAMPED = 20.0, 0.7
# Gauss nodes in a step at which the damper's torque is averaged: Abramowitz & Stegun, table 25.4. Against four, six
# halve the errors of power laws and tables at equal steps; twelve gain nothing more and double the curve's time.
AVERAGED = 6
# Abscissae and weights in a step of length 1.
_gauss = np.polynomial.legendre.leggauss(AVERAGED)
SHARES, SHARE_WEIGHTS = (1.0 + _gauss[0]) / 2.0, _gauss[1] / 2.0
AT_SHARES = np.vander(SHARES, STAGES, increasing=True) @ COURSE  # (share, stage) value of each stage's parabola
