"""What drives a leg that lanes integrate: a known torque, servo commands, and steps that stop at their knots."""

from __future__ import annotations

from typing import Any

from numba import njit

from synth.compiling.numba_internals import UNCOUNTED
from synth.swing.lane_layout import LANES, MOST_LINKS, Layout

# First places of these blocks in the workspace: alike for every number of links.
TORQUE, GAIN, OFFSET, DELAY, LATE, SIGNALS = (
    Layout(1).row(block) * LANES
    for block in ("extra_torque", "torque_gain", "torque_offset", "torque_delay", "servo_delay", "command")
)
SAME_TIME = 1e-11  # s, by which a step that ends at a knot of the known torque may miss it
_called: dict[str, Any] = {"fastmath": True, "error_model": "numpy", "nogil": True, **UNCOUNTED}


@njit(inline="never", **_called)
def _torque_at(times, torques, j, t, k):  # type: ignore[no-untyped-def]
    """A joint's known torque at a time near the knot ``k``; before the first sample and after the last as there."""
    while k < len(times) - 2 and times[k + 1] < t:
        k += 1
    while k > 0 and times[k] > t:
        k -= 1
    share = min(max((t - times[k]) / (times[k + 1] - times[k]), 0.0), 1.0)
    return torques[k, j] + share * (torques[k + 1, j] - torques[k, j])


@njit(**_called)
def put_signals(Z, n, known, t, cursor):  # type: ignore[no-untyped-def]
    """Put what the servos are told into its rows, linear between samples; returns the new cursor.

    ``known[1]`` holds (m, n) torques, or these with (m, n) commands, supplies and switches beside them. The commands
    come as late as each lane has it.
    """
    times, values, _ = known
    if len(times) > 1 and values.shape[1] > n:
        while cursor < len(times) - 2 and times[cursor + 1] < t:
            cursor += 1
        while cursor > 0 and times[cursor] > t:
            cursor -= 1
        share = (t - times[cursor]) / (times[cursor + 1] - times[cursor])
        for s in range(3):
            for j in range(n):
                column = (s + 1) * n + j
                value = values[cursor, column] + share * (values[cursor + 1, column] - values[cursor, column])
                for lane in range(LANES):
                    Z[SIGNALS + (s * MOST_LINKS + j) * LANES + lane] = value
        for j in range(n):
            late = 0.0
            for lane in range(LANES):
                late = max(late, Z[LATE + j * LANES + lane])
            if late > 0.0:
                for lane in range(LANES):
                    e = j * LANES + lane
                    Z[SIGNALS + e] = _torque_at(times, values, n + j, t - Z[LATE + e], cursor)
    return cursor


@njit(**_called)
def add_known_torque(Z, n, any_active, known, t, cursor):  # type: ignore[no-untyped-def]
    """Add a known torque, linear between its samples, with each lane's gain and offset; returns the new cursor.

    Lanes share its delay, which is in ``known``, but for what stands in their rows: these are looked up one by one.
    """
    times, torques, _ = known
    if len(times) > 1:
        while cursor < len(times) - 2 and times[cursor + 1] < t:
            cursor += 1
        while cursor > 0 and times[cursor] > t:
            cursor -= 1
        share = (t - times[cursor]) / (times[cursor + 1] - times[cursor])
        for j in range(n):
            torque = torques[cursor, j] + share * (torques[cursor + 1, j] - torques[cursor, j])
            apart = 0.0
            for lane in range(LANES):
                e = j * LANES + lane
                here = (1.0 + Z[GAIN + e]) * torque + Z[OFFSET + e]
                Z[TORQUE + e] = (Z[TORQUE + e] if any_active else 0.0) + here
                apart = max(apart, abs(Z[DELAY + e]))
            if apart > 0.0:
                for lane in range(LANES):
                    e = j * LANES + lane
                    shifted = _torque_at(times, torques, j, t - Z[DELAY + e], cursor)
                    Z[TORQUE + e] += (1.0 + Z[GAIN + e]) * (shifted - torque)
    return cursor


@njit(inline="always", **_called)
def within_torque(known, cursor, t, h, most):  # type: ignore[no-untyped-def]
    """The step, cut to end at a knot of the known torque where its stages would not see what it does between.

    It passes knots as long as the torque stays near the straight line between the step's ends, and fewer than ``most``.
    Returns the step, how many knots it passes, and how far the first of them is.
    """
    times, torques, bend = known
    first = cursor
    while first < len(times) and times[first] <= t + SAME_TIME:
        first += 1
    passed = 0
    while first + passed < len(times) and times[first + passed] < t + h - SAME_TIME:
        passed += 1
    if passed == 0:
        return h, passed, h
    nearest, end, start = times[first] - t, t + h, max(first - 1, 0)
    if passed >= most:
        passed = most - 1
        end = times[first + passed]
    share = (t - times[start]) / (times[first] - times[start])
    straight = False
    while passed > 0 and not straight:
        last = min(first + passed, len(times) - 1)
        reached = (end - times[last - 1]) / (times[last] - times[last - 1])
        straight = True
        for j in range(torques.shape[1]):
            here = torques[start, j] + share * (torques[first, j] - torques[start, j])
            there = torques[last - 1, j] + reached * (torques[last, j] - torques[last - 1, j])
            for k in range(first, first + passed):
                line = here + (there - here) * (times[k] - t) / (end - t)
                straight = straight and abs(torques[k, j] - line) <= bend[j]
        if not straight:
            passed //= 2
            end = times[first + passed]
    return end - t, passed, nearest
