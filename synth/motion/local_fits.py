"""Local cubics through the samples themselves, where a recording has gaps or an uneven clock.

On a uniform grid a missing sample is bridged by a straight line, whose error on a curved motion looks like a torque. A
cubic through the samples that are there has none; what it does not determine is marked as a gap.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from synth.arrays import Array, Mask
from synth.motion.smoothing import Smoothed, odd_points

UNIFORM_STEP = 0.02  # of the step, by which samples may be off the grid
# Times the rate's noise with all samples, from which a grid point is a gap: a cubic that its own samples do not
# determine makes a torque of their noise, and a gap hides a hand that acts in it. Between the two it is a choice;
# ``tests/motion/test_release.py`` reads free and driven releases with gaps.
GAP_NOISE = 3.0


def by_samples(smoothed: Smoothed, time: Array, angle: Array, lost: Mask) -> Smoothed:
    """``smoothed`` with local cubics through its own samples; unchanged if none is lost and their clock is even.

    Parameters
    ----------
    time : (n,) s; angle : (n, n_joint) rad; lost : (n, n_joint), as given to ``smooth``.
    """
    grid = smoothed.time
    step = float(grid[1] - grid[0])
    places = (time - grid[0]) / step
    even = len(time) == len(grid) and np.abs(places - np.round(places)).max() < UNIFORM_STEP
    if even and not lost.any():
        return smoothed
    value, rate, gap = smoothed.angle.copy(), smoothed.rate.copy(), np.zeros(len(grid), dtype=bool)
    points = min(odd_points(smoothed.width, step), len(grid) // 2 * 2 - 1)
    for j in range(angle.shape[1]):
        good = ~lost[:, j]
        found, noise = _cubics(time[good], angle[good, j], grid, points * step)
        usual = _cubics(grid, grid, grid, points * step)[1]
        known = noise < GAP_NOISE * usual
        value[known, j], rate[known, j] = found[known, 0], found[known, 1]
        gap |= ~known
    return replace(smoothed, angle=value, rate=rate, gap=gap)


def _cubics(time: Array, value: Array, grid: Array, width: float) -> tuple[Array, Array]:
    """(m, 2) value and slope at each grid point, and (m,) noise of the slope, 1/s for unit noise; inf if unknown.

    The window of ``width`` s about a point is one-sided at the ends, as in ``savitzky_golay``.
    """
    half = 0.5 * width * (1.0 - 1e-9)
    centre = np.clip(grid, grid[0] + half, max(grid[-1] - half, grid[0] + half))
    first, last = np.searchsorted(time, centre - half), np.searchsorted(time, centre + half, "right")
    place = first[:, None] + np.arange(max(int((last - first).max()), 1))
    inside = place < last[:, None]
    place = np.minimum(place, len(time) - 1)
    since = np.where(inside, (time[place] - grid[:, None]) / half, 0.0)
    columns = np.where(inside[:, :, None], since[:, :, None] ** np.arange(4), 0.0)
    normal = columns.transpose(0, 2, 1) @ columns
    enough = (last - first > 4) & (np.linalg.eigvalsh(normal)[:, 0] > 1e-9)
    normal[~enough] = np.eye(4)
    inverse = np.linalg.inv(normal)
    found = (inverse @ (columns.transpose(0, 2, 1) @ value[place][:, :, None]))[:, :2, 0] / (1.0, half)
    noise = np.where(enough, np.sqrt(inverse[:, 1, 1]) / half, np.inf)
    return found, noise
