"""Recorded velocities: compared with the slope of the angles, and used if their noise is lower."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from synth.arrays import Array
from synth.motion.smoothing import Smoothed, odd_points, polynomial_noise, savitzky_golay
from synth.noise import white_noise

SCALE_ERROR = 0.15  # largest scale error of a velocity that is accepted as the angle's
# Least correlation of a velocity with the slope; deg/s labelled rad/s, or another joint's, has less
LEAST_CORRELATION = 0.9
ORDER = 4  # order of the differences that isolate noise
LEAST_SAMPLES = 20  # samples with a velocity for a comparison


def unlike(smoothed: Smoothed, time: Array, velocity: Array, joint: int) -> str:
    """Why a joint's velocity (m,) rad/s at ``time`` (m,) s is not the slope of its angle; empty if it is.

    Compared where the joint is fast enough that noise does not matter, above a tenth of its greatest speed, and
    smoothed as the angles are: a motor's own speed holds what shakes it, or its noise, which they have lost.
    """
    good = np.isfinite(velocity)
    slope = np.interp(time[good], smoothed.time, smoothed.rate[:, joint])
    fast = np.abs(slope) > 0.1 * np.abs(slope).max(initial=0.0)  # a tenth of the greatest speed
    if fast.sum() < LEAST_SAMPLES or np.abs(slope).max() < 10.0 * white_noise(slope, ORDER):
        return ""
    seen = np.interp(time[good], smoothed.time, _smoothed_alike(smoothed, time[good], velocity[good]))[fast]
    slope = slope[fast]
    size = float(np.sqrt(np.mean(seen**2) * np.mean(slope**2)))
    likeness = float(np.mean(seen * slope)) / size if size > 0.0 else 0.0
    factor = float(np.sqrt(np.mean(seen**2) / np.mean(slope**2)))
    if likeness > LEAST_CORRELATION and abs(factor - 1.0) < SCALE_ERROR:
        return ""
    if likeness < -LEAST_CORRELATION:
        return "has the opposite sign of the angle's slope"
    if likeness > LEAST_CORRELATION:
        hint = "; is its unit right (rad/s or deg/s)?" if abs(np.log(factor)) > 3.0 else ""
        return f"is {factor:.3g} times the angle's slope{hint}"
    return f"is not the angle's slope (correlation {likeness:.2f}); is it another joint's, or late?"


def _smoothed_alike(smoothed: Smoothed, time: Array, velocity: Array) -> Array:
    """A velocity (m,) rad/s at ``time`` (m,) s on the grid of the angles, by polynomials of their support."""
    interpolated = np.interp(smoothed.time, time, velocity)
    return savitzky_golay(interpolated[:, None], _points(smoothed), 3, _step(smoothed))[0][:, 0]


def _step(smoothed: Smoothed) -> float:
    """Of the grid, s."""
    return float(smoothed.time[1] - smoothed.time[0])


def _points(smoothed: Smoothed) -> int:
    """Of the grid in a polynomial's support."""
    return min(odd_points(smoothed.width, _step(smoothed)), len(smoothed.time) // 2 * 2 - 1)


def with_velocities(smoothed: Smoothed, time: Array, velocities: Array) -> Smoothed:
    """Rates from the velocity columns (m, n) rad/s, smoothed like the angles, if these have less noise.

    A slope's scatter is that of the readings times what the polynomials make of it (see ``smoothing.savitzky_golay``).
    """
    step, points = _step(smoothed), _points(smoothed)
    of_value, of_slope = polynomial_noise(points, 3, step)
    rate = smoothed.rate.copy()
    for j in range(rate.shape[1]):
        good = np.isfinite(velocities[:, j])
        if good.sum() < LEAST_SAMPLES:
            continue
        inside = (smoothed.time >= time[good][0]) & (smoothed.time <= time[good][-1])
        if of_value * white_noise(velocities[good, j], ORDER) < of_slope * smoothed.noise[j]:
            rate[inside, j] = _smoothed_alike(smoothed, time[good], velocities[good, j])[inside]
    return replace(smoothed, rate=rate)
