"""Local polynomials through recorded motion: smoothed angles and rates; lost samples detected and bridged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array, Mask
from synth.motion.filled_gaps import filled_gaps
from synth.motion.stuck_readings import repeated_readings, stuck_readings
from synth.noise import robust_deviation
from synth.pace import pace
from synth.sampling import channel_step, usual_step

Indices = NDArray[np.intp]

# Of the motion's pace: the error of a cubic over this range of a sinusoid is 1e-5 of its amplitude. 30 ms at 2 Hz.
SUPPORT = 0.7
LONGEST_RUN = 3  # samples: a marker taken for another, or a bus that repeats a wrong reading
STEP_BESIDE = 0.3  # of a run's steps there and back, the largest step within it and beside it
# Times the second differences beyond it, that of a sample at an end which is off, of so many samples.
ALONE, END = 5.0, 6
# Of the shorter of two steps in time, the longer, above which a sample between was lost. A shaky clock's stamps differ
# less, and do not tell when the samples were taken.
UNEVEN = 1.5
LEAST_NOISE_SHARE = 0.1  # of the noise's share in a residual of uniform samples; where less is shown, it is not used
HOLE = 4.5  # steps of a channel, above which it has a gap
COARSEST_COUNT = np.radians(0.5)  # no encoder in use is coarser: a larger smallest difference is not a count


@dataclass(frozen=True)
class Smoothed:
    """A recording on a uniform grid: ``time`` (n,) s, ``angle`` and ``rate`` (n, n_joint) rad, rad/s.

    ``noise`` (n_joint,) rad is the scatter of the samples (not of the grid) about the polynomials; ``gap`` (n,) marks
    grid points in a gap of the recording; ``width`` s is the polynomials' support, ``pace`` s its time scale, see
    ``synth.pace``.
    """

    time: Array
    angle: Array
    rate: Array
    noise: Array
    gap: Mask
    width: float = 0.03
    pace: float = 0.03


def odd_points(width: float, step: float) -> int:
    """Samples of a polynomial's support of ``width`` s: odd, at least five."""
    return max(5, round(width / step) // 2 * 2 + 1)


def lost_samples(time: Array, angle: Array, limit: float = 8.0) -> Mask:
    """(n_time, n_joint) True for a missing sample, an outlier, alone or in a run of up to ``LONGEST_RUN``, and for
    readings of a sensor that drops out or repeats its last reading, see ``stuck_readings``, and gaps that a program
    filled, see ``filled_gaps``.

    A Hampel filter on second differences: a sample is lost when it departs from the line between its two neighbours by
    more than ``limit`` robust standard deviations of that departure while its neighbours agree with theirs
    (Pearson, *Mining Imperfect Data*, 2005, section 3.2). ``time`` (n_time,) s: beside lost samples the neighbours are
    not equally far. A run is lost when the steps to it and back are larger than
    that and those beside them are small: a swing as fast would have steps as large beside them. The deviation is at
    least that of rounding to the encoder's counts: in a quiet recording most departures are zero and a flicker of one
    count is not a spike.
    """
    lost = ~np.isfinite(angle)
    for j in range(angle.shape[1]):
        good = np.flatnonzero(~lost[:, j])
        if len(good) < 7:
            continue
        value = angle[good, j]
        middle, later, reach = _departures(time[good], value)
        floor = 1e-9 + 1e-6 * float(np.ptp(value))
        counts = np.diff(np.unique(value))
        rounding = np.sqrt(1.5 / 12.0) * float(counts.min(initial=COARSEST_COUNT, where=counts > 1e-12))
        scale = max(robust_deviation(middle - np.median(middle)) + floor, rounding)
        spike = np.abs(middle) > limit * scale * reach
        # A lone spike of height h shows as h in its own difference and -h/2 in both neighbours', or by its weight there
        # if the steps are unequal; a fast swing does not. Four tenths of that leave room for noise.
        before, after = np.r_[0.0, middle[:-1]], np.r_[middle[1:], 0.0]
        least_before, least_after = 0.4 * np.r_[0.5, later[:-1]], 0.4 * np.r_[1.0 - later[1:], 0.5]
        alone = (before * middle < -least_before * middle**2) & (after * middle < -least_after * middle**2)
        lost[good[1:-1][spike & alone], j] = True
        rest = np.flatnonzero(~lost[:, j])
        lost[rest[_runs(angle[rest, j], limit * scale)], j] = True
        rest = np.flatnonzero(~lost[:, j])
        stuck = stuck_readings(angle[rest, j], limit * scale) | repeated_readings(angle[rest, j], limit * scale)
        lost[rest[stuck], j] = True
        lost[good[filled_gaps(time[good], value)], j] = True
        rest = np.flatnonzero(~lost[:, j])
        for ends in (rest[:END], rest[: -END - 1 : -1]):
            lost[ends[_at_end(np.abs(time[ends] - time[ends[0]]), angle[ends, j], limit * scale)], j] = True
    return lost


def _departures(time: Array, value: Array) -> tuple[Array, Array, Array]:
    """(n - 2,) of samples from the line between their neighbours, the later neighbour's weight in it, and the longer of
    the steps to them in terms of the shorter: the departure of a curved motion grows with it.
    """
    step = np.diff(time)
    before, after = step[:-1], step[1:]
    reach = np.maximum(before, after) / np.minimum(before, after)
    later = np.where(reach > UNEVEN, before / (before + after), 0.5)
    middle = value[1:-1] - ((1.0 - later) * value[:-2] + later * value[2:])
    return middle, later, np.where(reach > UNEVEN, reach, 1.0)


def _at_end(time: Array, value: Array, least: float) -> Mask:
    """(n,) True for the first or second sample of a series that stands alone: no difference beyond it is as large."""
    (middle, later, reach), found = _departures(time, value), np.zeros(len(value), dtype=bool)
    if len(value) == END and np.abs(middle[0]) > max(least * reach[0], ALONE * np.abs(middle[2:]).max()):
        # The first shows as -h/2 in one difference only, the second as h, and as -h/2 in the next.
        found[0] = np.abs(middle[0]) > ALONE * np.abs(middle[1])
        found[1] = middle[1] * middle[0] < -0.4 * (1.0 - later[1]) * middle[0] ** 2
    return found


def _runs(value: Array, least: float) -> Mask:
    """(n,) True in runs of 2 to ``LONGEST_RUN`` samples beside the series, by steps above ``least`` there and back."""
    found = np.zeros(len(value), dtype=bool)
    step = np.diff(value)
    for length in range(2, LONGEST_RUN + 1):
        # So many steps before and after are looked at: a swing of four samples a period has its next half there.
        far = length + 2
        if len(step) < length + 3:
            break  # a run with a step beside it on either end is longer than the series
        windows = np.lib.stride_tricks.sliding_window_view(np.pad(step, far - 1), length + 1 + 2 * far)
        size = np.minimum(np.abs(windows[:, far]), np.abs(windows[:, -far - 1]))
        others = np.delete(np.abs(windows), [far, windows.shape[1] - far - 1], axis=1).max(axis=1)
        back = windows[:, far] * windows[:, -far - 1] < 0.0
        for start in np.flatnonzero(back & (size > least) & (STEP_BESIDE * size > others)) + 2:
            found[start : start + length] = True
    return found


def smooth(time: Array, angle: Array, lost: Mask, width: float | None = None, locked: Sequence[int] = ()) -> Smoothed:
    """Cubic Savitzky-Golay smoothing on a uniform grid of the usual sample step, see ``usual_step``.

    Parameters
    ----------
    time : (n,) s; angle : (n, n_joint) rad; lost : (n, n_joint), from ``lost_samples``.
    width : s, the polynomial's support; at least five samples are used. None: ``SUPPORT`` of the motion's own pace.
    locked : joints that do not move. What a fine sensor reads there is slower than its noise and faster than any swing,
        and would be the pace.

    Raises
    ------
    ValueError : fewer than seven samples, or a joint with fewer than seven good ones.
    """
    step = usual_step(time, ~lost)
    count = max(round((time[-1] - time[0]) / step) + 1, 2)
    grid = time[0] + step * np.arange(count)
    n_joint = angle.shape[1]
    even = np.zeros((count, n_joint))
    gap = np.zeros(count, dtype=bool)
    shares = []
    for j in range(n_joint):
        good = ~lost[:, j]
        if good.sum() < 7:
            raise ValueError(f"joint {j}: {int(good.sum())} good samples, at least 7 are needed")
        even[:, j] = np.interp(grid, time[good], angle[good, j])
        position = np.searchsorted(time[good], grid).clip(1, int(good.sum()) - 1)
        shares.append(_Shares.of(time[good], grid, position))
        # Four lost samples or more; fewer are bridged by the polynomials.
        gap |= (time[good][position] - time[good][position - 1]) > HOLE * channel_step(time, good)
    own = pace(step, np.delete(even, list(locked), axis=1))
    width = SUPPORT * own if width is None else width
    points = min(odd_points(width, step), count // 2 * 2 - 1)
    if points < 5:
        raise ValueError(f"{count} samples, at least 7 are needed")
    value, rate, kept = savitzky_golay(even, points, 3, step)
    residual = np.eye(points)[points // 2] - smoothing_weights(points, 3)[0]
    noise = [_scatter(even[:, j] - value[:, j], shares[j].kept(residual), kept) for j in range(n_joint)]
    return Smoothed(grid, value, rate, np.array(noise), gap, width, own)


@dataclass(frozen=True)
class _Shares:
    """Linear interpolation on the grid: point i is ``1 - right[i]`` of sample ``left[i]``, and the rest the next."""

    left: Indices
    right: Array

    @classmethod
    def of(cls, time: Array, grid: Array, position: Indices) -> _Shares:
        """The shares of the grid's points (n,) between the samples ``position - 1`` and ``position``."""
        left = position - 1
        return cls(left, ((grid - time[left]) / (time[position] - time[left])).clip(0.0, 1.0))

    def kept(self, residual: Array) -> Array:
        """(n,) share of the samples' noise variance in the grid's residuals, given the weights of one (points,).

        Two neighbours' mean has less noise than either, and grid points that share a sample share its noise: the grid's
        residuals are smaller than the samples'.
        """
        points, half = len(residual), len(residual) // 2
        variance = np.zeros(len(self.left) - points + 1)
        for lag in range(points):
            covariance = self._covariance(lag)
            if lag and not covariance.any():
                break
            products = residual[: points - lag] * residual[lag:]
            variance += (2.0 if lag else 1.0) * np.correlate(covariance, products, "valid")
        return np.pad(variance, (half, len(self.left) - half - len(variance)), mode="edge")

    def _covariance(self, lag: int) -> Array:
        """(n - lag,) of the interpolated noise of grid points ``lag`` apart, in units of a sample's variance."""
        first, later = slice(len(self.left) - lag), slice(lag, None)
        a, b = self.right[first], self.right[later]
        apart = self.left[later] - self.left[first]
        same, next_one = a * b + (1.0 - a) * (1.0 - b), a * (1.0 - b)
        return np.where(apart == 0, same, np.where(apart == 1, next_one, 0.0))


def _scatter(residual: Array, share: Array, kept: float) -> float:
    """The samples' noise, rad, from the grid's residuals (n,), which show a ``share`` (n,) of its variance.

    By the median, so that undetected glitches do not count as noise. In gaps the polynomials follow the bridging line
    and the residuals show nothing: those whose share is a small part of ``kept``, that of even samples, are left out.
    """
    shown = share > LEAST_NOISE_SHARE * kept
    if not shown.any():
        return 0.0
    return robust_deviation(residual[shown] / np.sqrt(share[shown]))


def smoothing_weights(points: int, degree: int) -> Array:
    """(degree + 1, points) weights of the samples in a local polynomial's coefficients at the middle."""
    half = points // 2
    return np.linalg.pinv(np.vander(np.arange(-half, half + 1.0), degree + 1, increasing=True))


def polynomial_noise(points: int, degree: int, step: float) -> tuple[float, float]:
    """Standard deviation of a local polynomial's value (1) and rate (1/s) for independent noise of 1 a sample."""
    value, rate = smoothing_weights(points, degree)[:2]
    return float(np.linalg.norm(value)), float(np.linalg.norm(rate)) / step


def savitzky_golay(value: Array, points: int, degree: int, step: float) -> tuple[Array, Array, float]:
    """Value and rate by local polynomials of an odd number of ``points`` along axis 0, one-sided at the ends.

    Savitzky & Golay, Analytical Chemistry 36 (1964) 1627. The third result is the residual's share of the noise
    variance, in the middle. A test compares this code with ``scipy.signal.savgol_filter(mode="interp")``. It does not
    call scipy, because every fit and gap comes here and importing ``scipy.signal`` costs 0.9 s of processor time,
    against 4.1 s for the whole ``synth fit`` of the example. One decomposition gives value and rate, for which scipy
    filters twice (1.6 ms and 1.8 ms for 4 000 x 3 samples, 31 points).
    """
    half = points // 2
    offset = np.arange(-half, half + 1.0)
    inverse = smoothing_weights(points, degree)
    windows = np.lib.stride_tricks.sliding_window_view(value, points, axis=0)
    smoothed, rate = np.empty_like(value), np.empty_like(value)
    smoothed[half:-half] = windows @ inverse[0]
    rate[half:-half] = windows @ inverse[1]
    for part, segment, at in (
        (slice(0, half), value[:points], offset[:half]),
        (slice(len(value) - half, None), value[-points:], offset[half + 1 :]),
    ):
        coefficient = inverse @ segment
        powers = np.vander(at, degree + 1, increasing=True)
        smoothed[part] = powers @ coefficient
        rate[part] = (np.arange(1, degree + 1) * powers[:, :-1]) @ coefficient[1:]
    kept = 1.0 - 2.0 * inverse[0][half] + float(inverse[0] @ inverse[0])
    return smoothed, rate / step, kept


def initial_state(smoothed: Smoothed) -> tuple[Array, Array]:
    """Rotation (n,) rad and rate (n,) rad/s at the recording's start, from the smoothed curves."""
    return smoothed.angle[0].copy(), smoothed.rate[0].copy()
