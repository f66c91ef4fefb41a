"""Which low-pass filter the readings' noise went through, if any, by its spectrum.

A smooth motion hardly has frequencies above some times its own; noise has. There the spectrum of unfiltered readings is
flat; of filtered ones it is that of the filter down to the rounding of the file: the zeros of a mean of N readings, the
edge of a Butterworth filter. Differences of neighbours, which tell the noise of independent readings, see of filtered
ones only what is left at the highest frequencies.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise

import numpy as np

from synth.arrays import Array
from synth.fit.recordings import Recording
from synth.motion.low_pass import LowPass
from synth.noise import EVEN, difference_scale

SEGMENT = 512  # samples of a spectrum, at most: a filter has no finer features
LEAST_SEGMENT = 96  # samples: of fewer, the taper's width leaves nothing beside the motion
# Of the Kaiser window: side lobes of -136 dB (Kaiser & Schafer, IEEE Trans. ASSP 28 (1980) 105), below the rounding of
# a motion of 90 deg to 1e-5 deg; half of its main lobe's width, and its equivalent width, in frequency steps.
KAISER, HALF_LOBE, EQUIVALENT = 14.0, 4.6, 2.15
MOTION_BANDS = (2.5, 3.5, 5.0, 7.0, 10.0)  # of the motion's own frequency, above which it may have ended
TAILS = (4.0, 6.0, 10.0)  # powers with which a motion's spectrum falls: jumps of speed, of acceleration, smoother
LEAST_BINS = 12  # frequencies of a spectrum between the motion's and the highest
LEAST_GAIN = 12.0  # of log likelihood over white noise: odds of 1e5 to 1, for some hundred filters
WORST_FIT = 1.6  # mean deviance of the spectrum from its model; 1 is expected
GOOD_FIT = 1.2  # of white noise, which is then believed
MOST_WEIGHT = 16.0  # spectra: of more, a fit within some 20 % of each power is good enough
PLATEAU = 1.5  # of the lowest frequency, least cutoff: nearer, what a filter let through is not seen
EDGE_STEP = 1.15  # ratio of neighbouring cutoffs that are tried
LEAST_POWER = 1e-24  # rad^2, far below any rounding
MEDIAN_WEIGHT = 0.7  # of a mean of as many spectra: what their median tells
ALIKE = 0.8  # of the noise, that of neighbours from which it counts as independent: as two sensors of one kind are
LAST_EDGE = 0.48  # of the sampling rate, highest cutoff that is tried: half of the rate passes all
WINDOW_IN_FILTERS, LEAST_WINDOW = 4, 8  # readings in which noise behind a filter is looked for, in filter lengths
QUIETEST, LEAST_OF_NOISE = 0.1, 0.2  # quantile of such windows; share of the noise that they must show
LONG_REACH = 30.0  # readings to either side; such a filter is as slow as the slowest that are tried, or slower
COARSER = 4  # readings that are then taken together
ROUNDS = 40  # of the scaling of two levels, which converges within some tens


@dataclass(frozen=True)
class FilteredNoise:
    """``filter`` of a channel, and the RMS (rad) of the noise that it let through."""

    filter: LowPass
    noise: float


WHITE = LowPass("mean", points=1)  # no filter


@lru_cache(maxsize=1)
def _filters() -> tuple[LowPass, ...]:
    cutoffs = (0.025 * EDGE_STEP ** np.arange(21)).tolist()
    return (
        *(LowPass("mean", points=n) for n in range(2, 26)),
        *(LowPass("polynomial", points=n, order=d) for d in (2, 4) for n in range(d + 3, 32, 2)),
        *(LowPass("butterworth", order=n, cutoff=c, passes=k) for k in (1, 2) for n in (1, 2, 4) for c in cutoffs),
    )


def filtered_noise(recordings: Sequence[Recording], joint: int, step: float) -> FilteredNoise | None:
    """The filter and noise of a joint's readings; None for unfiltered ones, and where they do not show it.

    Parameters
    ----------
    step : rad, of the readings, 0 if not visible.
    """
    found = _Spectrum.of(recordings, joint)
    if found is None:
        return None
    for times in MOTION_BANDS:
        first = int(times * found.own * found.length + HALF_LOBE) + 1
        if len(found.power) - first < LEAST_BINS * EQUIVALENT:
            return None
        white = _Fits.of(found, first, (WHITE,), step)
        if white.deviance[0] < GOOD_FIT:
            return None
        fits = _refined(found, first, step, _filters())
        best = int(np.argmax(fits.likelihood))
        if min(fits.deviance[best], white.deviance[0]) > WORST_FIT:
            continue
        which = fits.filters[best]
        edge = which.kind == "butterworth" and which.cutoff < PLATEAU * first / found.length
        if edge or fits.likelihood[best] - white.likelihood[0] < LEAST_GAIN:
            return None
        gain = which.response(np.linspace(0.0, 0.5, 2001))
        noise = float(np.sqrt(fits.level[best] * np.mean(gain**2)))
        return FilteredNoise(which, noise) if _is_everywhere(recordings, joint, which, noise) else None
    return None


def filter_of_noise(parts: Sequence[Array], step: float) -> LowPass | None:
    """The filter of noise whose motion is taken away, (k,) rad each at even times; None for white noise or too little.

    Of Butterworth filters only those that run to and fro, as labs do: fourth order once has nearly the spectrum of
    second order twice, but not its droop at the motion's frequencies, which bends the motion.

    ``step`` : rad, of rounding. A filter as slow as the slowest that are tried is looked for in means of ``COARSER``.
    """
    usual = [part for part in parts if len(part) >= LEAST_SEGMENT]
    if not usual:
        return None
    spectrum, first = _Spectrum.of_parts(usual, 0.0), int(HALF_LOBE) + 1
    twice = tuple(one for one in _filters() if one.points or one.passes == 2)
    white, fits = _Fits.of(spectrum, first, (WHITE,), step), _refined(spectrum, first, step, twice)
    best = int(np.argmax(fits.likelihood))
    found = fits.filters[best]
    if found.reach >= LONG_REACH:
        coarse = [part[: len(part) // COARSER * COARSER].reshape(-1, COARSER).mean(axis=1) for part in usual]
        slow = filter_of_noise(coarse, step / np.sqrt(COARSER))
        if slow is not None:
            return slow.slower(COARSER)
    return found if fits.likelihood[best] - white.likelihood[0] >= LEAST_GAIN else None


def _is_everywhere(recordings: Sequence[Recording], joint: int, which: LowPass, noise: float) -> bool:
    """Whether the quietest readings have that noise (rad) too: where a leg rests the motion ends, and noise does not.

    The spectrum of a servo's steps, of a leg that rests in between, is that of noise behind a slow filter. Noise behind
    it has some six independent readings in a window, less a line: of such windows a tenth is below half of the noise.
    """
    window = which.points if which.points else round(1.0 / which.cutoff)
    window = max(WINDOW_IN_FILTERS * window, LEAST_WINDOW)
    line = np.vander(np.linspace(-1.0, 1.0, window), 2)
    found = []
    for recording in recordings:
        if joint in recording.free:
            for part in even_stretches(recording, joint):
                pieces = np.array([part[k : k + window] for k in range(0, len(part) - window + 1, window // 2)])
                if len(pieces):
                    rest = pieces.T - line @ np.linalg.lstsq(line, pieces.T, rcond=None)[0]
                    found += np.sqrt(np.mean(rest**2, axis=0)).tolist()
    return not found or float(np.quantile(found, QUIETEST)) > LEAST_OF_NOISE * noise


def filter_with_ratio(ratio: float, order: int) -> LowPass | None:
    """The Butterworth filter, run to and fro as labs do, after which noise seems so much smaller; None from 1 on.

    ``ratio`` : noise by differences of that ``order`` over the noise's RMS.
    """
    if ratio >= ALIKE:
        return None
    grid = np.linspace(0.0, 0.5, 4001)
    seen = (2.0 * np.sin(np.pi * grid)) ** (2 * order) / difference_scale(order) ** 2
    filters = [LowPass("butterworth", order=2, cutoff=c, passes=2) for c in np.geomspace(0.01, LAST_EDGE, 80).tolist()]
    powers = [one.response(grid) ** 2 for one in filters]
    found = [abs(np.log(np.sqrt(np.mean(seen * power) / np.mean(power)) / max(ratio, 1e-9))) for power in powers]
    return filters[int(np.argmin(found))]


def _refined(spectrum: _Spectrum, first: int, step: float, filters: tuple[LowPass, ...]) -> _Fits:
    """Fits of the filters; where an edge fits best, of edges about it."""
    fits = _Fits.of(spectrum, first, filters, step)
    for reach in (EDGE_STEP, EDGE_STEP**0.25):
        best = fits.filters[int(np.argmax(fits.likelihood))]
        if best.kind != "butterworth":
            break
        cutoffs = np.minimum(best.cutoff * np.geomspace(1.0 / reach, reach, 9), LAST_EDGE)
        fits = _Fits.of(spectrum, first, tuple(replace(best, cutoff=c) for c in cutoffs.tolist()), step)
    return fits


@dataclass(frozen=True)
class _Spectrum:
    """``power`` (m,) rad^2 a reading at frequencies k / ``length`` of the sampling rate, of so many ``segments``;
    ``own`` : the motion's frequency.
    """

    power: Array
    length: int
    segments: int
    own: float

    @classmethod
    def of(cls, recordings: Sequence[Recording], joint: int) -> _Spectrum | None:
        """Of a joint, the median over its trials' segments: an impact in one of them does not count."""
        parts, own = [], 0.0
        for recording in recordings:
            if joint in recording.free:
                parts += list(even_stretches(recording, joint))
                own = max(own, recording.step / (4.0 * np.pi * recording.smoothed.pace))
        return cls.of_parts(parts, own) if parts else None

    @classmethod
    def of_parts(cls, parts: Sequence[Array], own: float) -> _Spectrum:
        """Of even stretches (k,) rad of a channel, in which the motion has the frequency ``own``."""
        length = min(SEGMENT, max(len(part) for part in parts)) // 2 * 2
        pieces = [p[k : k + length] for p in parts for k in range(0, len(p) - length + 1, length // 2)]
        line = np.vander(np.linspace(-1.0, 1.0, length), 2)
        values = np.array(pieces)
        values = values - (line @ np.linalg.lstsq(line, values.T, rcond=None)[0]).T
        taper = _taper(length)
        power = np.abs(np.fft.rfft(values * taper)) ** 2 + LEAST_POWER
        count = len(pieces)
        # Of so many exponential variables, the median in terms of their mean.
        ranks = count // 2 + 1, (count + 1) // 2
        share = float(np.mean([sum(1.0 / k for k in range(count - rank + 1, count + 1)) for rank in ranks]))
        return cls(np.median(power, axis=0) / share, length, count, own)


def _taper(length: int) -> Array:
    """(length,) of unit power."""
    taper = np.kaiser(length, KAISER)
    return np.asarray(taper / np.linalg.norm(taper))


@lru_cache(maxsize=4)
def _expected(filters: tuple[LowPass, ...], length: int) -> Array:
    """(n, m) spectra of unit noise behind filters, as the taper shows them: it fills their zeros."""
    gain = np.array([one.response(np.arange(2 * length + 1) / (4 * length)) for one in filters])
    own = np.fft.irfft(gain**2)[:, :length]
    seen = own * np.correlate(_taper(length), _taper(length), "full")[length - 1 :]
    both = np.concatenate([seen, np.zeros((len(seen), 1)), seen[:, :0:-1]], axis=1)
    return np.maximum(np.fft.rfft(both).real[:, ::2], LEAST_POWER)


def even_stretches(recording: Recording, joint: int) -> Iterator[Array]:
    """Runs of good readings (k,) rad at even times."""
    time, value, good = recording.channel(joint)
    if len(time) < LEAST_SEGMENT:
        return
    steps = np.diff(time)
    usual = float(np.median(steps))
    broken = (np.abs(steps - usual) > EVEN * usual) | ~good[1:] | ~good[:-1]
    edges = np.r_[0, np.flatnonzero(broken) + 1, len(time)]
    for first, last in pairwise(edges.tolist()):
        if last - first >= LEAST_SEGMENT:
            yield value[first:last]


@dataclass(frozen=True)
class _Fits:
    """Whittle's likelihood (Ark. Mat. 2 (1953) 423) of noise of each gain, beside rounding and a tail of the motion.

    ``likelihood``, ``level`` (rad^2 of the noise before the filter) and ``deviance`` (1 is expected), each (n,), of
    the ``filters``.
    """

    likelihood: Array
    level: Array
    deviance: Array

    filters: tuple[LowPass, ...]

    @classmethod
    def of(cls, spectrum: _Spectrum, first: int, filters: tuple[LowPass, ...], step: float) -> _Fits:
        """For filters (n,) at the frequencies from number ``first``; of each the tail that fits best.

        ``step`` : rad, of rounding.
        """
        power, floor = spectrum.power[first:], step**2 / 12.0 + LEAST_POWER
        weight = min(MEDIAN_WEIGHT * spectrum.segments, MOST_WEIGHT)
        noise = _expected(filters, spectrum.length)[:, None, first:]
        tail = (np.arange(first, len(spectrum.power)) / first) ** -np.array(TAILS)[:, None]
        # Multiplicative steps keep the levels positive and never lower the likelihood (Fevotte & Idier, Neural Comput.
        # 23 (2011) 2421).
        level = np.median(power / (noise + 1e-6), axis=-1, keepdims=True) * np.ones((len(TAILS), 1))
        rest = np.full_like(level, power[0])
        for _ in range(ROUNDS):
            inverse = 1.0 / (level * noise + rest * tail + floor)
            slope = power * inverse**2
            level *= np.sqrt((noise * slope).sum(-1, keepdims=True) / (noise * inverse).sum(-1, keepdims=True))
            rest *= np.sqrt((tail * slope).sum(-1, keepdims=True) / (tail * inverse).sum(-1, keepdims=True))
        ratio = power / (level * noise + rest * tail + floor)
        likelihood = weight / EQUIVALENT * np.sum(np.log(ratio) - ratio, axis=-1)
        deviance = 2.0 * weight * np.mean(ratio - 1.0 - np.log(ratio), axis=-1)
        best = np.argmax(likelihood, axis=1), np.arange(len(filters))
        return cls(likelihood[best[::-1]], level[..., 0][best[::-1]], deviance[best[::-1]], filters)
