"""The zero of a current sensor, from the rest that run-ups and jumps record before the switch-on.

A motor that stands without voltage draws no current: what its sensor shows then is its zero, an offset of all samples.
Hall sensors are off by percents of their range, as much as a small motor draws when it runs freely, and friction is
what it draws then times K. All runs are of one sensor: the mean of all samples at rest is its zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array
from synth.estimation.intervals import NORMAL90
from synth.files.hopper_recordings import HopperRecording
from synth.hopper.quiet_voltage import DROP_DEVIATIONS, SMALL
from synth.noise import difference_scale, robust_deviation

LEAST_ZERO = 0.005  # of a column's largest value: a voltage or a speed below it hardly moves anything
LARGEST_ZERO = 0.1  # of the largest current; more is no sensor's zero but another column, or a motor that is driven


@dataclass(frozen=True)
class CurrentZero:
    """``value`` A that the sensor shows without a current, and its standard ``deviation``; 0 where it shows none."""

    value: float = 0.0
    deviation: float = 0.0

    @property
    def interval90(self) -> tuple[float, float]:
        """90 % interval, A."""
        return self.value - NORMAL90 * self.deviation, self.value + NORMAL90 * self.deviation

    @property
    def sentence(self) -> str:
        """What is subtracted, for the user; empty where nothing is."""
        if self.value == 0.0:
            return ""
        return (
            f"the current is {1e3 * self.value:.3g} mA at rest before the switch-on, where a motor draws none: "
            "this is its sensor's zero, and is subtracted"
        )

    def subtracted(self, run: HopperRecording) -> HopperRecording:
        """The recording with its current counted from this zero."""
        return replace(run, columns={**run.columns, "current": run["current"] - self.value})


def current_zero(runs: Sequence[HopperRecording]) -> CurrentZero:
    """The zero of the sensor of all ``runs``, if some begin at rest and it differs from 0 by more than noise."""
    resting = np.concatenate([run["current"][: samples_at_rest(run)] for run in runs])
    found = _mean_at_rest(resting, max(_noise(run["current"]) for run in runs))
    largest = max(float(np.max(np.abs(run["current"]))) for run in runs)
    return found if abs(found.value) <= LARGEST_ZERO * largest else CurrentZero()


def current_before(jump: HopperRecording, switch_on: float) -> CurrentZero:
    """What the sensor of a jump shows before the motors are switched on at that time, s; 0 without a current or a rest.

    Of any size, as it may be other electronics: ``switch_on.from_switch_on`` finds the push beside it.
    """
    if "current" not in jump.columns:
        return CurrentZero()
    return _mean_at_rest(jump["current"][jump["time"] < switch_on], _noise(jump["current"]))


def _mean_at_rest(resting: Array, noise: float) -> CurrentZero:
    """The mean of samples (n,) A at rest, if it differs from 0 by more than white noise of that deviation."""
    if not len(resting):
        return CurrentZero()
    value, deviation = float(np.mean(resting)), noise / len(resting) ** 0.5
    return CurrentZero(value, deviation) if abs(value) > DROP_DEVIATIONS * deviation else CurrentZero()


def _noise(current: Array) -> float:
    """Deviation of a column's white noise, A."""
    return robust_deviation(np.diff(current)) / difference_scale(1)


def samples_at_rest(run: HopperRecording) -> int:
    """How many first samples are before the switch-on, of a rotor that stands without voltage; 0 if none are."""
    voltage = run["voltage"]
    first = int(np.argmax(np.abs(voltage) > SMALL * float(np.max(np.abs(voltage)))))
    return first if first > 0 and all(is_nothing(run, name, first) for name in ("voltage", "speed")) else 0


def is_nothing(run: HopperRecording, name: str, first: int) -> bool:
    """Whether a column is zero in the first so many samples, but for its sensor's noise and a small zero."""
    values = run[name]
    noise = robust_deviation(np.diff(values)) / difference_scale(1)
    least = max(LEAST_ZERO * float(np.max(np.abs(values))), DROP_DEVIATIONS * noise / float(np.sqrt(first)))
    return abs(float(np.mean(values[:first]))) <= least
