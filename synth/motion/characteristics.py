"""Characteristics of a release: rise time, damping ratio, damped frequency, overshoot, settling time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from synth.arrays import Array

SETTLE_BAND = 0.1  # of the amplitude: 2 or 5 % would lie in the noise and dry friction of small limbs


@dataclass(frozen=True)
class Characteristics:
    """One joint's response in one trial; None for characteristics that the motion does not show, see ``validity``.

    ``rise_time`` s, 10-90 % of the way from start to rest; ``damping_ratio`` by the logarithmic decrement;
    ``damped_frequency`` rad/s; ``overshoot`` share of the amplitude; ``settling_time`` s, until the angle stays within
    10 % of it. ``validity``: ``valid``, or why the damping ratio is missing or doubtful.
    """

    amplitude: float  # rad, start to rest
    rise_time: float | None
    damping_ratio: float | None
    damped_frequency: float | None
    overshoot: float | None
    settling_time: float | None
    validity: str


def characteristics(time: Array, angle: Array, noise: float = 0.0) -> Characteristics:
    """Response characteristics of one joint, from a smooth curve (fitted or smoothed), time (n,) s and angle (n,) rad.

    Rest is the mean of the last tenth. Peaks are alternate extremes about rest larger than three times ``noise``
    (rad). The logarithmic decrement over m half cycles, ``delta = ln|x_0/x_m| * 2/m``, gives
    ``zeta = delta / sqrt(4 pi^2 + delta^2)`` (Inman, *Engineering Vibration*, 4th ed., eq. 1.88); it holds for one
    decaying mode, so it is marked doubtful if successive half cycles disagree by more than a factor of two.
    """
    rest = float(np.mean(angle[-max(2, len(angle) // 10) :]))
    away = angle - rest
    amplitude = float(away[0])
    if abs(amplitude) < max(3 * noise, 1e-6):  # rad: a microradian is no motion
        return Characteristics(amplitude, None, None, None, None, None, "starts at rest")
    level = away / amplitude
    rise = _rise_time(time, level)
    outside = np.flatnonzero(np.abs(level) > SETTLE_BAND)
    settled = outside[-1] + 1 < len(time) * 0.9  # not seen to settle if outside until the last tenth
    settling = float(time[outside[-1] + 1] - time[0]) if settled else None
    overshoot = float(max(0.0, -level.min()))
    times, peaks = _peaks(time, level, max(3 * noise / abs(amplitude), 0.02))
    if len(peaks) < 2:
        return Characteristics(amplitude, rise, None, None, overshoot, settling, "fewer than two swings past rest")
    logs = np.log(np.abs(peaks))
    decrement = 2.0 * float(logs[0] - logs[-1]) / (len(peaks) - 1)
    frequency = float(np.pi * (len(peaks) - 1) / (times[-1] - times[0]))
    ratio = decrement / np.hypot(2 * np.pi, decrement)
    steps = -np.diff(logs)
    steady = steps.min() > 0 and steps.max() <= 2.0 * steps.min()
    validity = "valid" if steady else "doubtful: successive swings do not decay at one rate"
    if len(peaks) == 2:
        validity = "valid, from one half cycle"
    if decrement <= 0:
        return Characteristics(amplitude, rise, None, frequency, overshoot, settling, "the swings grow")
    return Characteristics(amplitude, rise, float(ratio), frequency, overshoot, settling, validity)


def _rise_time(time: Array, level: Array) -> float | None:
    """10-90 % rise time, s, from the last time above 0.9 before the first time below 0.1, linearly interpolated."""
    below = np.flatnonzero(level <= 0.1)
    if not len(below) or below[0] == 0:
        return None
    end = below[0]
    above = np.flatnonzero(level[:end] >= 0.9)
    if not len(above):
        return None

    def crossing(index: int, at: float) -> float:
        share = (level[index] - at) / (level[index] - level[index + 1])
        return float(time[index] + share * (time[index + 1] - time[index]))

    return crossing(int(end) - 1, 0.1) - crossing(int(above[-1]), 0.9)


def _peaks(time: Array, level: Array, least: float) -> tuple[Array, Array]:
    """Times (m,) and heights (m,) of the extremes between successive zero crossings about rest, after the first one."""
    crossings = np.flatnonzero(level[:-1] * level[1:] < 0) + 1
    times, heights = [], []
    ends = [*crossings[1:], len(level)] if len(crossings) else []  # rounded to counts, a curve may only touch it
    for first, last in zip(crossings, ends, strict=True):
        segment = level[first:last]
        k = int(np.argmax(np.abs(segment)))
        inner = 0 < k < len(segment) - 1
        if np.abs(segment[k]) < least or not inner:
            break
        a, b, c = segment[k - 1 : k + 2]
        bend = a - 2 * b + c
        shift = 0.5 * (a - c) / bend if bend else 0.0
        at = first + k
        times.append(time[at] + shift * 0.5 * (time[at + 1] - time[at - 1]))
        heights.append(b - 0.25 * (a - c) * shift)
    return np.array(times), np.array(heights)
