"""Characteristics of a release: rise time, damping ratio, damped frequency, overshoot, settling time."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array, zero_crossings
from synth.motion.rest import rest_of, vertex

SETTLE_BAND = 0.1  # of the amplitude: 2 or 5 % would lie in the noise and dry friction of small limbs
LEAST_PEAK = 0.02  # of the amplitude: a smaller peak is no swing of the joint itself, however little noise there is
STARTS_AT_REST = "starts at rest"
CUT = "its start is cut off: no rise time, overshoot and settling time"
# times as far. One that swings farther was hardly away from rest: shares of its amplitude mean little.
FARTHEST_SWING = 4.0
NEAR_REST = (
    "it starts near rest and swings much farther: rise time, overshoot and settling time are those of a small step"
)


@dataclass(frozen=True)
class Characteristics:
    """One joint's response in one trial; None for characteristics that the motion does not show, see ``validity``.

    ``rise_time`` s, 10-90 % of the way from start to rest; ``damping_ratio`` by the logarithmic decrement;
    ``damped_frequency`` rad/s; ``overshoot`` share of the amplitude; ``settling_time`` s, until the angle stays within
    10 % of it. ``validity``: ``valid``, or why the damping ratio is missing or doubtful, or how rest was found.
    """

    amplitude: float  # rad, start to rest, of a cut motion its largest deflection; nan if rest is unknown
    rise_time: float | None
    damping_ratio: float | None
    damped_frequency: float | None
    overshoot: float | None
    settling_time: float | None
    validity: str

    @property
    def starts_near_rest(self) -> bool:
        """Whether the motion swings so much farther than it starts away that a share of that means little."""
        return self.validity.endswith(NEAR_REST)

    def without_step(self) -> Characteristics:
        """The same without what is a share of the amplitude."""
        return replace(self, rise_time=None, overshoot=None, settling_time=None)


def characteristics(
    time: Array,
    angle: Array,
    noise: float = 0.0,
    *,
    rest: float | None = None,
    equilibrium: float | None = None,
    cut: bool = False,
    most_peaks: int | None = None,
) -> Characteristics:
    """Response characteristics of one joint, from a smooth curve (fitted or smoothed), time (n,) s and angle (n,) rad.

    Rest is ``rest`` rad, by default found from the curve, with a fitted leg's ``equilibrium`` rad where it ends in
    motion (see ``rest_of``); without a rest only the damped frequency is given. ``cut``: the curve begins within the
    motion, so that it has no rise time, overshoot and settling time. Of one whose rest is found and which swings far
    beyond its amplitude (``FARTHEST_SWING``) the validity says that these mean little (``without_step``). Peaks are
    alternate extremes about rest larger than three times ``noise`` (rad), the first ``most_peaks`` of them. The
    logarithmic decrement over m half cycles, ``delta = ln|x_0/x_m| * 2/m``, gives ``zeta = delta / sqrt(4 pi^2 +
    delta^2)`` (Inman, *Engineering Vibration*, 4th ed., eq. 1.88); it holds for one decaying mode, so it is marked
    doubtful if successive half cycles disagree by more than a factor of two.
    """
    how, why = "", CUT if cut else ""
    if rest is None:
        found = rest_of(time, angle, noise, equilibrium)
        rest, how = found.angle, found.why
        if rest is None:
            half_cycles, seen = len(found.turns) - 1, found.turns
            turning = float(np.pi * half_cycles / (seen[-1] - seen[0])) if half_cycles > 0 else None
            return Characteristics(float("nan"), None, None, turning, None, None, how)
        if not why and np.abs(angle - rest).max() > FARTHEST_SWING * abs(float(angle[0]) - rest):
            why = NEAR_REST
    away = angle - rest
    amplitude = float(away[np.argmax(np.abs(away))]) if cut else float(away[0])
    made = _about_rest(time, away, amplitude, noise, how, most_peaks)
    if not why or (why == NEAR_REST and made.validity == STARTS_AT_REST):
        return made
    made = replace(made, validity=f"{made.validity}; {why}")
    return made.without_step() if cut else made


def _about_rest(
    time: Array, away: Array, amplitude: float, noise: float, how: str, most_peaks: int | None
) -> Characteristics:
    """Characteristics of the deflections (n,) rad from rest; ``how`` rest was found, for the validity."""
    if abs(amplitude) < max(3 * noise, 1e-6):  # rad: a microradian is no motion
        return Characteristics(amplitude, None, None, None, None, None, STARTS_AT_REST)
    level = away / amplitude
    rise = _rise_time(time, level)
    outside = np.flatnonzero(np.abs(level) > SETTLE_BAND)
    settled = outside[-1] + 1 < len(time) * 0.9  # not seen to settle if outside until the last tenth
    settling = float(time[outside[-1] + 1] - time[0]) if settled else None
    overshoot = float(max(0.0, -level.min()))
    times, peaks = (each[:most_peaks] for each in _peaks(time, level, max(3 * noise / abs(amplitude), LEAST_PEAK)))
    if len(peaks) < 2:
        few = "fewer than two swings past rest"
        return Characteristics(amplitude, rise, None, None, overshoot, settling, f"{few}; {how}" if how else few)
    logs = np.log(np.abs(peaks))
    decrement = 2.0 * float(logs[0] - logs[-1]) / (len(peaks) - 1)
    frequency = float(np.pi * (len(peaks) - 1) / (times[-1] - times[0]))
    ratio: float | None = float(decrement / np.hypot(2 * np.pi, decrement))
    steps = -np.diff(logs)
    steady = steps.min() > 0 and steps.max() <= 2.0 * steps.min()
    validity = "valid" if steady else "doubtful: successive swings do not decay at one rate"
    if len(peaks) == 2:
        validity = "valid, from one half cycle"
    if decrement <= 0:
        ratio, validity = None, "the swings grow"
    validity = f"{validity}; {how}" if how else validity
    return Characteristics(amplitude, rise, ratio, frequency, overshoot, settling, validity)


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
    crossings = zero_crossings(level)[:, 1]
    times, heights = [], []
    ends = [*crossings[1:], len(level)] if len(crossings) else []  # rounded to counts, a curve may only touch it
    for first, last in zip(crossings, ends, strict=True):
        segment = level[first:last]
        k = int(np.argmax(np.abs(segment)))
        inner = 0 < k < len(segment) - 1
        if np.abs(segment[k]) < least or not inner:
            break
        at, height = vertex(time, level, int(first + k))
        times.append(at)
        heights.append(height)
    return np.array(times), np.array(heights)
