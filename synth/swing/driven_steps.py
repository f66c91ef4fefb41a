"""Inputs of a driven leg in the integrator: known torque, servo signals, and steps that end at their knots.

``known`` and ``commands_held`` are the result of ``known_torque.for_integrator``: what is linear between its knots, and
the commands that are held. A held command is constant within a step, because a step ends wherever a lane's command
changes. The right-hand side gets ``known`` alone: each further array would be copied at every stage.
"""

from __future__ import annotations

import math
from typing import Any

from numba import njit

from synth.compiling.numba_internals import UNCOUNTED
from synth.drives.servo_law import integral_change, servo_duty
from synth.swing.lane_layout import CONTROLLED, INTEGRAL, INTEGRAL_LAW, LANES, MOST_LINKS, Layout

# First indices of these blocks in the workspace, the same for every number of links.
TORQUE, GAIN, OFFSET, DELAY, LATE, SIGNALS, KNOWN, DRIVE = (
    Layout(1).row(block) * LANES
    for block in (
        "extra_torque", "torque_gain", "torque_offset", "torque_delay", "servo_delay", "command", "known_torque",
        "drive_torque",
    )
)  # fmt: skip
ROTATION, RATE, DUTY_GAIN, DAMPING, DEAD, MOST_DUTY, PERIOD, PHASE, STEPS, HELD, NEXT = (
    Layout(1).row(block) * LANES
    for block in (
        "rotation", "rate", "servo_gain", "servo_damping_gain", "servo_dead_band", "servo_duty_limit", "servo_period",
        "servo_phase", "servo_duty_steps", "held_duty", "next_control",
    )
)  # fmt: skip
_, INTEGRAL_GAIN, INTEGRAL_LIMIT = (Layout(1).row(block) * LANES for block in INTEGRAL_LAW)
SUMMED, ENABLED = (Layout(1).row(block) * LANES for block in (f"{INTEGRAL} memory", "enabled"))
BEYOND, SEEN_SCALE, SEEN_OFFSET = (Layout(1).row(block) * LANES for block in CONTROLLED)
SLEW_RATE, SLEW_FROM, SLEW_SINCE, SLEW_GOAL, SLEW_SHOWN, SLEW_SLOPE, SLEW_SHORT = (
    Layout(1).row(block) * LANES
    for block in (
        "servo_command_rate", "slew_from", "slew_since", "slew_goal", "slew_shown", "slew_slope", "slew_short",
    )
)  # fmt: skip
SHARE = 1e-6  # of a control period, rounding of a delay in periods
NEVER = 1e300  # s
ANY_BEND, HELD_STILL = 1e100, 1e200  # tolerated deviations of a command that is sampled, and of one that is held
JITTER = 0.01  # of a control period: a command that comes so little after a look counts for it (rounded times of a log)
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

    Beyond their samples they are constant. ``known[1]`` contains (m, 4 n) torques, commands, supplies and switches.
    Each lane has its own delay of the commands. Held commands are written by ``hold_commands`` alone, but for those
    that approach another at a limited rate.
    """
    times, values, bend = known
    if len(times) > 1:
        while cursor < len(times) - 2 and times[cursor + 1] < t:
            cursor += 1
        while cursor > 0 and times[cursor] > t:
            cursor -= 1
        share = min(max((t - times[cursor]) / (times[cursor + 1] - times[cursor]), 0.0), 1.0)
        for s in range(3):
            for j in range(n):
                column = (s + 1) * n + j
                if bend[column] >= HELD_STILL:
                    for e in range(j * LANES, (j + 1) * LANES):
                        if Z[SLEW_SLOPE + e] != 0.0:
                            Z[SIGNALS + e] = Z[SLEW_SHOWN + e] + Z[SLEW_SLOPE + e] * (t - Z[SLEW_SINCE + e])
                    continue
                value = values[cursor, column] + share * (values[cursor + 1, column] - values[cursor, column])
                for lane in range(LANES):
                    Z[SIGNALS + (s * MOST_LINKS + j) * LANES + lane] = value
        for j in range(n):
            late = 0.0
            for lane in range(LANES):
                late = max(late, Z[LATE + j * LANES + lane])
            if (
                late > 0.0 and bend[n + j] < HELD_STILL and Z[PERIOD + j * LANES] == 0.0
            ):  # control steps count the delay themselves
                for lane in range(LANES):
                    e = j * LANES + lane
                    Z[SIGNALS + e] = _torque_at(times, values, n + j, t - Z[LATE + e], cursor)
    return cursor


@njit(**_called)
def put_known_torque(Z, n, known, t, cursor):  # type: ignore[no-untyped-def]
    """Write the known torque, interpolated linearly, with each lane's gain and offset; returns the new cursor.

    It is a drive's torque too, by which a gear may rub. Beyond its samples it is constant. ``known`` contains the delay
    common to all lanes. A lane's row contains its difference from that; lanes with a difference are interpolated one by
    one.
    """
    times, torques, _ = known
    if len(times) > 1:
        while cursor < len(times) - 2 and times[cursor + 1] < t:
            cursor += 1
        while cursor > 0 and times[cursor] > t:
            cursor -= 1
        share = min(max((t - times[cursor]) / (times[cursor + 1] - times[cursor]), 0.0), 1.0)
        for j in range(n):
            torque = torques[cursor, j] + share * (torques[cursor + 1, j] - torques[cursor, j])
            apart = 0.0
            for lane in range(LANES):
                e = j * LANES + lane
                Z[KNOWN + e] = (1.0 + Z[GAIN + e]) * torque + Z[OFFSET + e]
                apart = max(apart, abs(Z[DELAY + e]))
            if apart > 0.0:
                for lane in range(LANES):
                    e = j * LANES + lane
                    shifted = _torque_at(times, torques, j, t - Z[DELAY + e], cursor)
                    Z[KNOWN + e] += (1.0 + Z[GAIN + e]) * (shifted - torque)
            for e in range(j * LANES, (j + 1) * LANES):
                Z[DRIVE + e] = Z[KNOWN + e]
    return cursor


@njit(**_called)
def add_known_torque(Z, n, any_active, known):  # type: ignore[no-untyped-def]
    """Add what ``put_known_torque`` wrote to the other torques, if there are ``any_active``."""
    if len(known[0]) > 1:
        for e in range(n * LANES):
            Z[TORQUE + e] = (Z[TORQUE + e] if any_active else 0.0) + Z[KNOWN + e]


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
    share = (t - times[start]) / (times[first] - times[start]) if first > 0 else 0.0  # constant before the first knot
    straight = False
    while passed > 0 and not straight:
        last = min(first + passed, len(times) - 1)
        reached = min((end - times[last - 1]) / (times[last] - times[last - 1]), 1.0)  # constant after the last
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


@njit(inline="never", **_called)
def _held_sample(moments, t, k):  # type: ignore[no-untyped-def]
    """Index of the sample that is held at a time near sample ``k``; the first one before the first sample."""
    k = min(k, len(moments) - 1)
    while k < len(moments) - 1 and moments[k + 1] <= t + SAME_TIME:
        k += 1
    while k > 0 and moments[k] > t + SAME_TIME:
        k -= 1
    return k


@njit(**_called)
def hold_commands(Z, n, known, commands_held, t, start, sample):  # type: ignore[no-untyped-def]
    """Set what is held from now on and the time at which it changes, for joints that are due; at the ``start`` all.

    A servo with control steps holds its duty, any other servo a held command. Rotations and rates are those in the
    workspace. ``sample`` is near the sample that is held; returns the new one.
    """
    for j in range(n):
        if Z[PERIOD + j * LANES] > 0.0:
            if start or Z[NEXT + j * LANES] <= t + SAME_TIME:
                sample = _control(Z, n, j, known, commands_held, t, sample, start)
        elif known[2][n + j] >= HELD_STILL:
            moments, commands = commands_held
            for lane in range(LANES):
                e = j * LANES + lane
                if start or Z[NEXT + e] <= t + SAME_TIME:
                    sample = k = _held_sample(moments, t - Z[LATE + e], sample)
                    Z[SIGNALS + e] = commands[k, j]
                    while k < len(moments) and commands[k, j] == Z[SIGNALS + e]:
                        k += 1
                    Z[NEXT + e] = moments[k] + Z[LATE + e] if k < len(moments) else NEVER
                    if Z[SLEW_RATE + e] > 0.0:
                        _slew(Z, e, t, start)
    return sample


@njit(inline="never", **_called)
def _slew(Z, e, t, start):  # type: ignore[no-untyped-def]
    """Let a lane's own command approach the held one at its limited rate, until that changes or is reached.

    Where it is reached within a short interval between two commands, a line with the same mean and first moment stands
    for it: steps that ended at each lane's own moment in each interval would take far longer.
    """
    goal, rate = Z[SIGNALS + e], Z[SLEW_RATE + e]
    now = goal
    if not start:
        most = rate * (t - Z[SLEW_SINCE + e])
        now = Z[SLEW_FROM + e] + min(max(Z[SLEW_GOAL + e] - Z[SLEW_FROM + e], -most), most)
    away, left = goal - now, Z[NEXT + e] - t
    needed = abs(away) / rate
    Z[SLEW_FROM + e], Z[SLEW_SINCE + e], Z[SLEW_GOAL + e] = now, t, goal
    Z[SLEW_SHOWN + e], Z[SLEW_SLOPE + e] = goal, 0.0
    if needed > SAME_TIME and left <= Z[SLEW_SHORT + e] and needed < left:
        share = needed / left
        slope = away * share * (3.0 - 2.0 * share) / left
        Z[SLEW_SLOPE + e] = slope
        Z[SLEW_SHOWN + e] = goal - 0.5 * (away * share + slope * left)
    elif needed > SAME_TIME:
        Z[SLEW_SLOPE + e] = math.copysign(rate, away)
        Z[SLEW_SHOWN + e] = now
        Z[NEXT + e] = min(Z[NEXT + e], t + needed)
    Z[SIGNALS + e] = Z[SLEW_SHOWN + e]


@njit(**_called)
def _limited_step(Z, e, command, period):  # type: ignore[no-untyped-def]
    """The command of a servo with control steps: it comes nearer by at most the limited rate times its period."""
    most = Z[SLEW_RATE + e] * period
    limited = Z[SLEW_FROM + e] + min(max(command - Z[SLEW_FROM + e], -most), most)
    Z[SLEW_FROM + e] = limited
    return limited


@njit(**_called)
def _control(Z, n, j, known, commands_held, t, sample, start):  # type: ignore[no-untyped-def]
    """Set the duty of a servo whose control step is now, and the time of its next; returns the new sample.

    A lane's delay counts in control steps; a fraction of one is linear between the two commands, so that a motion is
    continuous in the delay. Period and phase are those of the first lane.
    """
    times, values, bend = known
    moments, commands = commands_held
    period, phase = Z[PERIOD + j * LANES], Z[PHASE + j * LANES]
    following = phase + (math.floor((t - phase) / period + SHARE) + 1.0) * period
    for lane in range(LANES):
        e = j * LANES + lane
        late = max((Z[LATE + e] - phase) / period, 0.0)
        whole = math.floor(late + SHARE)
        share = max(late - whole, 0.0)
        if bend[n + j] < HELD_STILL:
            near = (
                (t - Z[LATE + e] - times[0]) / (times[-1] - times[0]) * (len(times) - 1)
            )  # of even times, it is there
            near = min(max(near, 0.0), len(times) - 2.0)
            command = _torque_at(times, values, n + j, t - Z[LATE + e], int(near))
        else:
            moment = t - phase - (whole - JITTER) * period
            sample = _held_sample(moments, moment, sample)
            command = commands[sample, j]
            if share > SHARE:
                earlier = commands[_held_sample(moments, moment - period, sample), j]
                command += share * (earlier - command)
        if Z[SLEW_RATE + e] > 0.0:
            if start:
                Z[SLEW_FROM + e] = command
            command = _limited_step(Z, e, command, period)
        scale = 1.0 + Z[SEEN_SCALE + e]
        error = command - (scale * (Z[ROTATION + e] + Z[BEYOND + e] * Z[ROTATION + e + LANES]) + Z[SEEN_OFFSET + e])
        if not start:
            change = integral_change(error, Z[SUMMED + e], Z[DEAD + e], Z[INTEGRAL_GAIN + e], Z[INTEGRAL_LIMIT + e])
            grown = Z[SUMMED + e] + Z[ENABLED + e] * change * period
            Z[SUMMED + e] = min(max(grown, -Z[INTEGRAL_LIMIT + e]), Z[INTEGRAL_LIMIT + e])
        duty = servo_duty(
            error,
            scale * (Z[RATE + e] + Z[BEYOND + e] * Z[RATE + e + LANES]),
            Z[DUTY_GAIN + e],
            Z[DAMPING + e],
            Z[DEAD + e],
            Z[MOST_DUTY + e],
            Z[SUMMED + e],
        )
        steps = Z[STEPS + e]
        if steps > 0.0:
            duty = math.floor(duty * steps + 0.5) / steps
            duty = max(-Z[MOST_DUTY + e], min(Z[MOST_DUTY + e], duty))
        Z[HELD + e] = duty
        Z[NEXT + e] = following
    return sample


@njit(**_called)
def next_look(Z, n, known):  # type: ignore[no-untyped-def]
    """S, time at which some joint's duty or held command changes in some lane; ``NEVER`` without."""
    soonest = NEVER
    for j in range(n):
        if Z[PERIOD + j * LANES] > 0.0:
            soonest = min(soonest, Z[NEXT + j * LANES])
        elif known[2][n + j] >= HELD_STILL:
            for lane in range(LANES):
                soonest = min(soonest, Z[NEXT + j * LANES + lane])
    return soonest
