"""A stop in a recorded motion: a swing's turning point, also where a gap hides it, or a hold before a release."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synth.arrays import Array, Mask

TURNING = 0.8  # of the velocity's variance over a stop explained by a straight line: a turning swing, not a hold
# One polynomial over a gap and as long a stretch of samples before and after it. Measured on turning points of two
# links at 2 Hz with noise of 0.05 deg, over gaps of 65 to 150 ms, and of three links with faster modes, 75 and 100
# ms: all continue within SMOOTH (0.004 misses 5 of 31 of the last). Of gaps with a hold in them that begins and ends
# unseen 86 to 99 % pass too, but a hand that catches, holds and lets go needs longer: it reacts after some 0.2 s. At
# 200 ms 33 % pass, at 250 ms 11 %, at 300 ms none.
DEGREE = 6
SMOOTH = 0.01  # of the largest joint's range of angle there, RMS beside the noise; see above
NOISE_SPREAD = 1.3  # times the noise that the RMS of 30 samples reaches in one of 50 recordings
LEAST_STRETCH = 0.06  # s, of samples on each side: below it the polynomial has hardly more samples than coefficients
LEAST_SIDE = 4  # samples on each side: a side with fewer tells no angle, rate and acceleration


def turns(velocity: Array) -> bool:
    """Whether a stop is the turning point of a swing: its velocity (m, n) runs straight through zero."""
    line = np.stack([np.ones(len(velocity)), np.linspace(-1.0, 1.0, len(velocity))], axis=1)
    residual = velocity - line @ np.linalg.lstsq(line, velocity, rcond=None)[0]
    whole = float(((velocity - velocity.mean(axis=0)) ** 2).sum())
    return float((residual**2).sum()) < (1.0 - TURNING) * whole


def continues(time: Array, rotation: Array, lost: Mask, stop: tuple[float, float], noise: Array) -> bool:
    """Whether the motion after a stop that a gap hides continues the one before it: all joints cross it smoothly.

    Parameters
    ----------
    time : (n,) s; rotation : (n, n_joint) rad, of the joints that can move; lost : (n, n_joint), unusable samples.
    stop : s, the last moment of motion before it and the first one after it.
    noise : (n_joint,) rad, of the angles.
    """
    begin, end = stop
    stretch = max(end - begin, LEAST_STRETCH)
    inside = (time >= begin - stretch) & (time <= end + stretch)
    misfits, ranges = list[float](), list[float]()
    for j in range(rotation.shape[1]):
        good = inside & ~lost[:, j]
        if min((good & (time <= begin)).sum(), (good & (time >= end)).sum()) < LEAST_SIDE or good.sum() <= DEGREE + 1:
            return False
        misfits.append(_misfit((time[good] - 0.5 * (begin + end)) / stretch, rotation[good, j]))
        ranges.append(float(np.ptp(rotation[good, j])))
    allowed = np.hypot(NOISE_SPREAD * noise, SMOOTH * max(ranges, default=0.0))
    return bool((np.array(misfits) <= allowed).all())


def gap_ends(grid: Array, gap: Sequence[bool] | Mask, first: int, last: int) -> tuple[float, float] | None:
    """The ends in s of a stop between the indices ``first`` and ``last``, moved out of the gaps it meets; None: none.

    ``grid`` (n,) s; ``gap`` (n,) where no samples determine the motion: there it may have seemed to move.
    """
    flags = np.asarray(gap)
    if not flags[first : last + 1].any():
        return None
    while first > 0 and flags[first]:
        first -= 1
    while last < len(flags) - 1 and flags[last]:
        last += 1
    return float(grid[first]), float(grid[last])


def _misfit(place: Array, angle: Array) -> float:
    """Residual standard deviation in rad of the polynomial; ``place`` (m,) of about -1.5 to 1.5."""
    design = place[:, None] ** np.arange(DEGREE + 1)
    residual = angle - design @ np.linalg.lstsq(design, angle, rcond=None)[0]
    return float(np.sqrt(residual @ residual / (len(angle) - DEGREE - 1)))
