"""Sensor model: delay, lag, cross-talk, scale, offset, eccentricity, noise and encoder counts."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from synth.planting.model import Array, PlantedLeg
from synth.planting.simulation import Motion


@dataclass(frozen=True)
class PlantedSensor:
    """Errors of the readings, (n,) one per joint; zero or empty means no error. Angles in rad, times in s."""

    offset: Array
    scale: Array
    width: Array  # rad, width of one count, if coarser than the design's
    latency: Array
    lag: Array  # time constant of a first-order filter
    talk: Array  # (n, n), cross-talk: reading += talk @ (reading - talk_about)
    talk_about: Array
    wobble: tuple[int, float, float, float] | None = None  # eccentric disc: joint, amplitude, harmonic, phase
    drops: tuple[tuple[float, float], ...] = ()  # lost samples: s after the recording's start, duration in s

    @staticmethod
    def good(n: int) -> PlantedSensor:
        """Sensors whose only errors are the design's noise and counts."""
        zero = np.zeros(n)
        return PlantedSensor(zero, zero, zero, zero, zero, np.zeros((n, n)), zero)

    def times(self, times: Array, start: float) -> Array:
        """True times (m,) s from the release at which the samples with nominal ``times`` (m,) s were taken."""
        late = np.zeros(len(times))
        for when, lost in self.drops:
            late += lost * (times >= when)
        return times + start + late

    @property
    def reach(self) -> float:
        """Time by which the motion must be longer than the recording, s."""
        return sum(lost for _, lost in self.drops)

    def read(self, leg: PlantedLeg, motion: Motion, times: Array, start: float, *, counted: bool = True) -> Array:
        """Noise-free readings (m, n) rad at nominal ``times`` (m,) s; ``counted`` : round coarse counts."""
        taken = self.times(times, start)
        rotation = np.empty((len(times), leg.n))
        for j in range(leg.n):
            seen = motion
            if self.lag[j] > 0:
                share = 1 - math.exp(-motion.step / self.lag[j])
                first = motion.angle[0, j]
                slow = first + lfilter([share], [1, share - 1], motion.angle[:, j] - first)
                angle, speed = motion.angle.copy(), motion.speed.copy()
                angle[:, j] = slow
                speed[:, j] = np.gradient(slow, motion.step)
                seen = Motion(motion.step, angle, speed)
            rotation[:, j] = seen.joint(j, taken - self.latency[j])
        angle = leg.reading(rotation)
        angle = angle + (angle - self.talk_about) @ self.talk.T
        if self.wobble is not None:
            j, size, harmonic, phase = self.wobble
            angle[:, j] += size * np.sin(harmonic * angle[:, j] + phase)
        angle = angle * (1 + self.scale) + self.offset
        if counted:
            angle = np.where(self.width > 0, _round_to_counts(angle, self.width), angle)
        return np.asarray(angle)

    def record(
        self,
        angle: Array,
        noise: float | Array,
        counts: float | Array,
        rng: np.random.Generator,
        shaken_by: Array | None = None,
    ) -> Array:
        """Recorded angles (m, n) rad: ``angle`` with noise, rounded to counts.

        ``noise`` : rad, standard deviation. ``counts`` : of the design, per turn; infinite for no rounding. A coarser
        ``width`` takes precedence. ``shaken_by`` : (m, n), the noise in terms of its deviation; None: white.
        """
        width = np.where(self.width > 0, self.width, 2 * math.pi / np.asarray(counts))
        shaken = angle + noise * (rng.standard_normal(angle.shape) if shaken_by is None else shaken_by)
        return np.where(width > 0, _round_to_counts(shaken, width), shaken)


def _round_to_counts(angle: Array, width: Array) -> Array:
    safe = np.where(width > 0, width, 1.0)
    return np.asarray(np.round(angle / safe) * safe)
