"""A recorded voltage as the input of a simulation: without its sensor's noise, and in pieces between its switches.

Noise of the voltage would drive the simulation, and never drove the motor: a fit then prefers constants that attenuate
it, a larger resistance and inductance. When the source switched between two samples is not known; with L/R of a
sample's length, that would decide the inductance. A source with internal resistance drops as the current rises, within
a sample or two after the switch-on. That drop is no noise: a smoothing over it gave an inductance that is a fifth too
large. Where the samples do not resolve it, the voltage between them is not known, as at a switch.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from synth.arrays import Array, Mask
from synth.noise import robust_deviation

WIDTHS = (41, 11)  # samples that are smoothed together; the wider that loses nothing is taken
SMALL = 0.05  # of the largest voltage: more is no sensor's noise but a source that switches
GROUP = 7  # samples whose mean deviation shows that the median has lost a sag or a ripple
SURE_DEVIATIONS = 5.0  # standard deviations of that mean; of 1e5 groups of noise alone the largest has 4.4
# Standard deviations of a first change from one sample to the next, above which it is a drop, not noise: few are tested
DROP_DEVIATIONS, QUIET_DEVIATIONS = 3.0, 2.0
LEAST_DROP = 0.005  # of the largest voltage: a change below it moves the current by less than its sensor's noise
UNRESOLVED = 2.0  # times the next change, from which a decay of the voltage is faster than 1.4 samples
SHORTEST = 5  # samples between two switches; of their current and speed, two numbers each are the state at the first
WAVE_CORRELATION = 0.3  # correlation of neighbours above which what is left is a wave; of noise alone, n**-0.5


def driven_pieces(voltage: Array) -> list[tuple[slice, Array]]:
    """The samples between switches of a recorded voltage (n,) V, and the voltage there without its noise, V.

    A piece begins after the drop at its switch-on, where that is too fast for the samples.
    """
    found = []
    for piece in pieces(_smoothed(voltage)):
        first = piece.start + _unresolved_drop(voltage[piece])
        found.append((slice(first, piece.stop), quiet_voltage(voltage[first : piece.stop])))
    return found


def quiet_voltage(voltage: Array) -> Array:
    """A smooth voltage (n,) V from which the recorded one (n,) V differs by white noise alone, else the recorded one.

    The first samples stay as recorded, up to the first two that differ by noise alone: the source may drop there.
    """
    first = 1 + _leading(np.abs(np.diff(voltage)) > QUIET_DEVIATIONS * robust_deviation(np.diff(voltage)))
    return np.concatenate([voltage[:first], _smoothed(voltage[first:])])


def _leading(which: Mask) -> int:
    """How many of them (n,) are true before the first that is not."""
    return len(which) if which.all() else int(np.argmin(which))


def _unresolved_drop(voltage: Array) -> int:
    """How many first samples of a voltage (n,) V are before the end of a drop that these samples do not resolve."""
    size = np.abs(np.diff(voltage))
    noise = robust_deviation(size)
    least = max(LEAST_DROP * float(np.max(np.abs(voltage))), DROP_DEVIATIONS * noise)
    drops = _leading(size[:-1] > np.maximum(least, UNRESOLVED * (size[1:] + noise)))
    return drops if len(voltage) - drops >= SHORTEST else 0


def _smoothed(voltage: Array) -> Array:
    """Smooth voltage (n,) V from which the recorded one (n,) V differs by white noise alone, else the recorded one.

    Running medians hold between switches, cubics (Savitzky & Golay, Analytical Chemistry 36 (1964) 1627) along waves.
    """
    from scipy.ndimage import median_filter  # imported here: only run-ups need them
    from scipy.signal import savgol_filter

    for width in WIDTHS:
        if len(voltage) > 2 * width:
            whole = np.concatenate(
                [_voltage_before(voltage, width), voltage, _voltage_before(voltage[::-1], width)[::-1]]
            )
            smooth = np.asarray(median_filter(whole, width))[width:-width]
            if _noise_alone(voltage, smooth):
                return smooth
    for width in WIDTHS:
        if len(voltage) > 2 * width:
            smooth = np.asarray(savgol_filter(voltage, width, 3))
            if _noise_alone(voltage, smooth):
                return smooth
    return voltage


def _noise_alone(voltage: Array, smooth: Array) -> bool:
    """Whether a voltage (n,) V differs from a smooth one by little, and by white noise."""
    off = voltage - smooth
    deviation = robust_deviation(off)
    mean = np.convolve(off, np.full(GROUP, 1.0 / GROUP), mode="valid")
    small = deviation <= SMALL * float(np.max(np.abs(voltage)))
    white = abs(float(off[1:] @ off[:-1])) <= WAVE_CORRELATION * float(off @ off)
    return small and white and float(np.max(np.abs(mean))) * GROUP**0.5 <= SURE_DEVIATIONS * deviation


def _voltage_before(voltage: Array, width: int) -> Array:
    """(width,) that continue the voltage before its first sample: turned about the end of a line through its first."""
    place = np.arange(width)
    end = np.polyfit(place, voltage[:width], 1)[1]
    return np.asarray(2.0 * end - voltage[width:0:-1])


def pieces(voltage: Array) -> list[slice]:
    """The samples between switches of a voltage (n,) V without the shortest; all, where these are most."""
    change = np.diff(voltage)
    jumps = np.abs(change) > max(SMALL * float(np.max(np.abs(voltage))), SURE_DEVIATIONS * robust_deviation(change))
    ends = [0, *(np.nonzero(jumps)[0] + 1).tolist(), len(voltage)]
    found = [slice(first, last) for first, last in pairwise(ends) if last - first >= SHORTEST]
    kept = sum(piece.stop - piece.start for piece in found)
    return found if kept >= len(voltage) / 2 else [slice(0, len(voltage))]
