"""Inputs of a driven leg in the integrator: known torque, servo signals, and steps that end at their knots."""

from __future__ import annotations

from typing import Any

from numba import njit

from synth.compiling.numba_internals import UNCOUNTED
from synth.swing.lane_layout import LANES, MOST_LINKS, Layout

# First indices of these blocks in the workspace, the same for every number of links.
TORQUE, GAIN, OFFSET, DELAY, LATE, SIGNALS = (
    Layout(1).row(block) * LANES
    for block in ("extra_torque", "torque_gain", "torque_offset", "torque_delay", "servo_delay", "command")
)
SAME_TIME = 1e-11  # s, difference by rounding between the end of a step and the knot at which it ends
_called: dict[str, Any] = {"fastmath": True, "error_model": "numpy", "nogil": True, **UNCOUNTED}


@njit(inline="never", **_called)
def _torque_at(times, torques, j, t, k):  # type: ignore[no-untyped-def]
    """A joint's known torque at a time near knot ``k``, interpolated linearly; constant outside the samples."""
    while k < len(times) - 2 and times[k + 1] < t:
        k += 1
    while k > 0 and times[k] > t:
        k -= 1
    share = min(max((t - times[k]) / (times[k + 1] - times[k]), 0.0), 1.0)
    return torques[k, j] + share * (torques[k + 1, j] - torques[k, j])


@njit(**_called)
def put_signals(Z, n, known, t, cursor):  # type: ignore[no-untyped-def]
    """Write the servo signals, interpolated linearly, to their rows; returns the new cursor.

    ``known[1]`` contains (m, n) torques, or (m, 4 n) torques, commands, supplies and switches. Each lane has its own
    delay of the commands.
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
    """Add the known torque, interpolated linearly, with each lane's gain and offset; returns the new cursor.

    ``known`` contains the delay common to all lanes. A lane's row contains its difference from that; lanes with a
    difference are interpolated one by one.
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
    """The step, shortened to end at a knot of the known torque if its stages would not resolve the torque.

    A step passes fewer than ``most`` knots, and only while the torque stays close to the straight line between the ends
    of the step. Returns the step, the number of knots that it passes, and the time to the first of them.
    """
    times, torques, bend = known
    first = cursor
    while first > 0 and times[first - 1] > t + SAME_TIME:  # a step that is tried again starts before its stages
        first -= 1
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
