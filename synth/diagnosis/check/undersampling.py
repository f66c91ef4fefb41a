"""Whether a recording has too few samples for its motion, by its readings and by the designed leg.

A swing that is sampled less than twice in its period looks like a slower one, and its readings alone do not show how
fast it was. So a recording's own frequency is believed only where two witnesses do not contradict it: the swings of
the designed leg, and how its readings jump from one to the next beside the motion, by their sixth differences.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isnan, pi, sin
from typing import Literal

import numpy as np

from synth.arrays import Array, finite_median
from synth.fit.recordings import Recording
from synth.fit.sensor_noise import DIFFERENCE_ORDER
from synth.noise import difference_scale, unit_differences
from synth.swing.leg_model import Leg
from synth.swing.mechanics import coefficients, outboard_inertia

# Samples per period of the fastest swing. A sinusoid sampled at 10 per period and interpolated by cubics is off by 1 %
# of its amplitude at the turns; at 4 a turn is not resolved.
ENOUGH_SAMPLES, LEAST_SAMPLES = 10.0, 4.0
FREQUENCY_MARGIN = 2.0  # times a designed frequency: a stiffness or an inertia that is off by four
RECORDING_PARTS, LEAST_DIFFERENCES = 4, 4  # part of a recording in which it moves most, and its least differences
MOVING_SHARE = 0.2  # of the motion of the joint that moves most, below which a joint's noise is no motion
# Where readings jump less in some part than this share of where they move, they jump with the motion: noise is the same
# everywhere, so that its share is near 1 (less for the scatter of few differences); a swing that decays falls further.
FALL_SHARE = 1.0 / 3.0

FrequencyDoubt = Literal["", "slow", "jumps", "unclear", "doubtful"]


def roughness_of(samples: float) -> float:
    """Sixth differences over a sinusoid of so many samples a period, scaled to white noise's own deviation."""
    return float((2.0 * sin(pi / samples)) ** DIFFERENCE_ORDER / difference_scale(DIFFERENCE_ORDER))


# A sinusoid at ``LEAST_SAMPLES``: 0.26. A fast swing beside a slow one, or one that decays, shows less: as one of six
# samples.
ROUGHNESS_OF_SIX, ROUGHNESS_OF_LEAST = roughness_of(6.0), roughness_of(LEAST_SAMPLES)


@dataclass(frozen=True)
class ReadingJumps:
    """Of the roughest moving joint: sixth differences over its motion; ``falls`` : whether they end with it.

    ``roughness`` is nan for a recording that is too short for differences.
    """

    roughness: float
    falls: bool


def reading_jumps(recording: Recording) -> ReadingJumps:
    """How readings jump from one to the next in the quarter of a recording in which each joint moves most."""
    found: list[tuple[float, float, bool]] = []
    for j in recording.free:
        time, value, counts = recording.channel(j)
        if len(value) < DIFFERENCE_ORDER + 2 * LEAST_DIFFERENCES:
            continue
        good = np.lib.stride_tricks.sliding_window_view(counts, DIFFERENCE_ORDER + 1).all(axis=1)
        jump = np.where(good, np.abs(unit_differences(time, value, DIFFERENCE_ORDER)), np.nan)
        width = max(len(jump) // RECORDING_PARTS, LEAST_DIFFERENCES)
        motion = np.lib.stride_tricks.sliding_window_view(value, width + DIFFERENCE_ORDER).std(axis=1)
        # The median: of a sinusoid it is the RMS, and a single outlier does not count.
        jumped = np.array([finite_median(jump[k : k + width]) for k in range(len(motion))])
        most = int(np.argmax(motion))
        if motion[most] > 0.0 and np.isfinite(jumped[most]):
            falls = bool(np.nanmin(jumped) < FALL_SHARE * jumped[most])
            found.append((float(motion[most]), float(jumped[most] / motion[most]), falls))
    moving = [each for each in found if each[0] >= MOVING_SHARE * max(each[0] for each in found)]
    if not moving:
        return ReadingJumps(np.nan, False)
    _, roughness, falls = max(moving, key=lambda each: each[1])
    return ReadingJumps(roughness, falls)


def designed_swings(leg: Leg, recording: Recording) -> tuple[float, float] | None:
    """Slowest and fastest swing (Hz) of a free joint alone, as designed; None if driven, or none swings."""
    if recording.driven:
        return None
    leg, tip = recording.leg or leg, recording.conditions.tip
    inertia, stiffness = outboard_inertia(leg, tip), hanging_stiffness(leg, recording.conditions.tip_mass)
    rates = [joint.damper.rate if joint.damper and joint.damper.rate else 0.0 for joint in leg.joints]
    swinging = [j for j in recording.free if rates[j] ** 2 < 4.0 * stiffness[j] * inertia[j]]
    if not swinging:
        return None
    swing = np.sqrt(stiffness[swinging] / inertia[swinging]) / (2.0 * pi)
    return float(swing.min()), float(swing.max())


def hanging_stiffness(leg: Leg, tip_mass: float = 0.0) -> Array:
    """(n,) N m/rad, of each joint's spring and of gravity on the straight hanging leg."""
    hanging = np.abs(np.cumsum(coefficients(leg, tip_mass).gravity[::-1])[::-1])
    return np.asarray(leg.spring_rate + hanging)


def doubt_of_frequency(
    rate: float, frequency: float, designed: Sequence[float] | None, seen: ReadingJumps
) -> FrequencyDoubt:
    """What speaks against a recording's own ``frequency`` (Hz) at a sampling ``rate`` (Hz); "" if nothing does.

    ``slow`` : sampled too slowly even for a leg whose slowest swing is ``FREQUENCY_MARGIN`` times slower than designed,
    or for the designed one and too short to show more. ``jumps`` : its readings jump with the motion, and the designed
    leg may swing that fast. ``unclear`` : they jump, and there is no designed frequency. ``doubtful`` : the designed
    leg's fastest swing, if there, is badly sampled, and its readings do not show a slower one: of few samples a period
    the frequency comes out up to a third too low.
    """
    if designed is None:
        return "unclear" if seen.roughness >= ROUGHNESS_OF_LEAST else ""
    slowest, fastest = designed
    if rate < LEAST_SAMPLES * slowest / FREQUENCY_MARGIN or (isnan(seen.roughness) and rate < LEAST_SAMPLES * fastest):
        return "slow"
    if rate < LEAST_SAMPLES * fastest and seen.roughness >= ROUGHNESS_OF_SIX:
        return "jumps"
    if rate < FREQUENCY_MARGIN * LEAST_SAMPLES * fastest and seen.roughness >= ROUGHNESS_OF_LEAST and seen.falls:
        return "jumps"
    if rate >= ENOUGH_SAMPLES * fastest:
        return ""
    near = fastest / FREQUENCY_MARGIN <= frequency < fastest
    return "doubtful" if near or seen.roughness >= ROUGHNESS_OF_SIX or rate < LEAST_SAMPLES * fastest else ""
