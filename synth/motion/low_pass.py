"""Low-pass filters as labs and sensors have them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array
from synth.motion.smoothing import smoothing_weights

# Of its first value, of a filter's response to a stroke, where it counts as over: some 1.25 / cutoff of a second order.
# Fits to releases behind one of 12 Hz, of small swings of 4.9 Hz without noise, are then off by less than 0.1 % of the
# damper rate; from 1 / cutoff on by 0.26 %.
LEFT_OVER = 0.004


@dataclass(frozen=True)
class LowPass:
    """A filter of readings: ``kind`` and its numbers; see ``response``.

    ``kind`` : ``mean`` of ``points`` readings; ``polynomial`` of ``order`` through ``points`` readings
    (Savitzky-Golay); ``butterworth`` of that ``order``, run ``passes`` times, with ``cutoff`` in terms of the
    sampling rate.
    """

    kind: str
    points: int = 0
    order: int = 0
    cutoff: float = 0.0
    passes: int = 1

    def response(self, frequency: Array) -> Array:
        """(m,) gain at frequencies (m,) in terms of the sampling rate, 0 to 0.5."""
        if self.kind == "mean":
            return _gain_of(np.full(self.points, 1.0 / self.points), frequency)
        if self.kind == "polynomial":
            return _gain_of(smoothing_weights(self.points, self.order)[0], frequency)
        with np.errstate(over="ignore"):
            ratio = np.tan(np.pi * np.minimum(frequency, 0.5 - 1e-9)) / np.tan(np.pi * self.cutoff)
            return np.asarray((1.0 + ratio ** (2 * self.order)) ** (-0.5 * self.passes))

    @property
    def reach(self) -> float:
        """Readings on either side of one of which the filter takes some: beyond, less than ``LEFT_OVER``.

        Of a Butterworth filter by its slowest pole, which decays with ``2 pi cutoff sin(pi / (2 order))`` a reading.
        """
        if self.points:
            return 0.5 * self.points
        return float(np.log(1.0 / LEFT_OVER) / (2.0 * np.pi * self.cutoff * np.sin(0.5 * np.pi / self.order)))

    def slower(self, times: int) -> LowPass:
        """The filter of so many times as many readings."""
        return replace(self, points=self.points * times, cutoff=self.cutoff / times)

    @property
    def words(self) -> str:
        """As a reader would say it."""
        if self.kind == "mean":
            return f"a mean of {self.points} readings"
        if self.kind == "polynomial":
            return f"a local polynomial through {self.points} readings"
        return f"a filter that cuts off at some {self.cutoff:.2g} of the sampling rate"

    def noise(self, count: int, rng: np.random.Generator) -> Array:
        """(count,) noise of deviation 1 that went through the filter."""
        long = 2 * count + 256  # so that the end does not agree with the start
        gain = self.response(np.arange(count + 129) / long)
        power = np.full(len(gain), 2.0)
        power[0] = 1.0
        power[-1] = 1.0 if long % 2 == 0 else 2.0
        gain /= np.sqrt(float(power @ gain**2) / long)
        return np.fft.irfft(gain * np.fft.rfft(rng.standard_normal(long)), long)[128 : 128 + count]


@dataclass(frozen=True)
class SeenFilter:
    """``joints`` whose readings look filtered; the ``filter`` of readings ``step`` s apart, None of unknown kind."""

    joints: tuple[str, ...]
    filter: LowPass | None = None
    step: float = 0.0

    @property
    def reach(self) -> float:
        """In s, of the filter to either side; 0 of unknown kind."""
        return 0.0 if self.filter is None else self.filter.reach * self.step

    @property
    def words(self) -> str:
        """The joints and the filter, as a reader would say it."""
        text = f"the readings of {', '.join(self.joints)} look low-pass filtered"
        if self.filter is None:
            return text
        kind = self.filter.words
        return f"{text}, by {kind if self.filter.points else f'one that cuts off at some {self.cutoff_hertz:.2g} Hz'}"

    @property
    def cutoff_hertz(self) -> float:
        """Hz, of a filter with a cutoff."""
        return 0.0 if self.filter is None else self.filter.cutoff / self.step


def _gain_of(weights: Array, frequency: Array) -> Array:
    at = np.arange(len(weights)) - 0.5 * (len(weights) - 1)
    return np.asarray(np.abs(np.cos(2.0 * np.pi * np.outer(frequency, at)) @ weights))
