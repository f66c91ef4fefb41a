"""Readings that went through a low-pass filter: how it shows, and what the recordings can then not tell.

A filter that runs to and fro over a release from rest rounds off its corner: with a cutoff at four times the motion's
frequency the first samples are off by some 1 % of the amplitude, far above the noise that is left.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synth.fit.recordings import Recording
from synth.fit.sensor_noise import FILTERED_RATIO, AngleSensor
from synth.motion.low_pass import SeenFilter
from synth.remarks import Remark

REMEDY = (
    "use the sensor's raw readings; a filter distorts the first samples after a release, which looks like a missing "
    "effect, and removes the marks of friction and backlash at turning points"
)


def filtered_words(joint: int, sensor: AngleSensor) -> str:
    """How a joint's readings show that they were filtered; empty if they do not."""
    step = sensor.step[joint]
    if joint in sensor.rounding_only:
        digit = f" ({np.degrees(step):.2g} deg)" if step > 0.0 else ""
        return f"the readings show no noise beyond their last digit{digit}: they were low-pass filtered, or simulated"
    if step > 0.5 * sensor.noise[joint]:
        return ""  # rounded readings scatter by their count anyway
    if joint in sensor.by_spectrum and (seen := sensor.filters[joint]) is not None:
        return f"the readings' noise has the spectrum of {seen.words}: they were low-pass filtered"
    if sensor.scatter[joint] >= FILTERED_RATIO:
        text = (
            f"readings scatter {sensor.scatter[joint]:.2g} times more about a smooth motion than from one to the next"
        )
        return f"{text}: they were low-pass filtered or interpolated, or the joint is shaken"
    return ""


def filtered_note(seen: SeenFilter, left_out: float) -> Remark:
    """A remark of a fit; ``left_out`` : s at the start of each recording that the filter smears."""
    text = seen.words
    if left_out:
        fitted = f"only samples from {1e3 * left_out:.0f} ms after each start are fitted"
        text += f". It smears the release: {fitted}. To fit all: release: recorded"
    return Remark(f"{text}", "note", REMEDY)


def likely_filter(recordings: Sequence[Recording]) -> str:
    """A sentence on why the first samples of filtered readings are off; empty of unfiltered ones."""
    seen = next((recording.behind for recording in recordings if recording.behind is not None), None)
    if seen is None:
        return ""
    return f"{seen.words[0].upper()}{seen.words[1:]}: a filter smears a release, which is the likely reason"
