"""Recordings behind a low-pass filter: what it smears is not fitted, what it bends is in the intervals.

Of a free linear swing a filter only scales each exponential, so that rates and free angles follow from filtered
readings as from others. It does not where its response still reaches over the release or the end, which are corners;
and of a swing that is not linear it scales the harmonics differently. The first is left out, as far as the filter
reaches. The second is what the filter makes of the fitted motion: by how much that moves the estimates is an error of
theirs of one standard deviation.

The filter's kind shows in what a fit to later samples leaves: without the motion the noise is seen at all frequencies.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from synth.arrays import Array
from synth.fit.filtered_readings import filtered_words
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_problem import model_of
from synth.fit.following import follow_changes
from synth.fit.free_angle import WIDE
from synth.fit.later_samples import LEAST_SHARE, comparison_begin, recordings_from
from synth.fit.least_squares import FitStart, Stage
from synth.fit.noise_spectrum import even_stretches, filter_of_noise
from synth.fit.recordings import Recording
from synth.fit.refinement import refine
from synth.fit.sensor_noise import DIFFERENCE_ORDER, DOUBTFUL_RATIO, estimate_sensor
from synth.fit.starts import first_locals, weak_form_start
from synth.fit.trajectories import TrajectoryModel
from synth.fit.uncertainty import residuals
from synth.motion.low_pass import LowPass, SeenFilter
from synth.noise import EVEN, unit_differences
from synth.swing.leg_model import Leg

LOOKED_AT = 3  # recordings whose noise is compared first: enough to tell, and a hundredth of a fit's time
ALIKE_STEPS = 0.05  # of the usual sample step: those of recordings that a filter has read alike differ by less
# Times the reach of the filter that the readings show by themselves, which near the motion's frequencies comes out down
# to half of the true one. What a fit leaves of readings with hardly any noise is the model's error, and seems filtered
# by a far slower one.
MOST_REACH = 3.0
# Times each other, reaches of the joints' filters: one filter that all readings went through is found within a tenth at
# each. On a real double pendulum whose readings were filtered at 12 Hz the model's error gave 3 and 13 Hz.
MOST_APART = 1.5


def seen_filter(leg: Leg, recordings: Sequence[Recording], options: LegFitOptions) -> SeenFilter | None:
    """The filter of the readings; None if they show none."""
    if not _may_be_filtered(recordings):
        return None
    sensor = estimate_sensor(recordings)
    seen = [j for j in range(len(leg.joints)) if filtered_words(j, sensor)]
    if not seen:
        return None
    found = SeenFilter(tuple(leg.joint_names[j] for j in seen))
    usual = float(np.median([recording.step for recording in recordings]))
    alike = [recording for recording in recordings if abs(recording.step - usual) <= ALIKE_STEPS * usual]
    if any(recording.driven for recording in recordings):
        return found  # what a filter makes of a driven motion depends on the inputs too
    left = _left_by_fit(leg, alike, options)
    which = [
        filter_of_noise([part for each in left for part in even_stretches(each, j)], float(sensor.step[j]))
        for j in seen
    ]
    known = [one for one in which if one is not None]
    shown = max((one.reach for one in sensor.filters if one is not None), default=0.0)
    slowest = max(known, key=lambda one: one.reach, default=None)
    if slowest is None or slowest.reach > MOST_REACH * shown:
        return found
    if slowest.reach > MOST_APART * min(one.reach for one in known):
        return found
    return replace(found, filter=slowest, step=usual)


def _may_be_filtered(recordings: Sequence[Recording]) -> bool:
    """Whether neighbouring readings scatter less than readings about a smooth motion: a fast test."""
    for recording in recordings[:LOOKED_AT]:
        for j in recording.free:
            time, value, good = recording.channel(j)
            differences = unit_differences(time[good], value[good], DIFFERENCE_ORDER)
            if recording.smoothed.noise[j] >= DOUBTFUL_RATIO * np.sqrt(np.mean(differences**2)):
                return True
    return False


def _left_by_fit(leg: Leg, recordings: Sequence[Recording], options: LegFitOptions) -> list[Recording]:
    """What a fit to later samples leaves of them, as recordings; none if it diverges."""
    some = recordings_from(recordings, comparison_begin(recordings)) or list(recordings)
    model = model_of(leg, options.curves, recordings=some, prior=options.prior, static=options.static)
    guess, spread = weak_form_start(model, some, options), np.zeros(len(leg.joints))
    locals_ = first_locals(some)
    if len(some) > 1 and options.free_angle != "common":
        locals_ = [replace(local, shift=shift) for local, shift in zip(locals_, guess.shifts, strict=True)]
        spread += WIDE
    stage = refine(model, some, FitStart(guess.values, locals_), options.weight, spread, rounds=2)
    if not np.isfinite(stage.solution.cost):
        return []
    pairs = zip(some, stage.solution.predictions, strict=True)
    return [replace(each, rotation=np.nan_to_num(residuals(each, motion))) for each, motion in pairs]


def clear_of(recordings: Sequence[Recording], seen: SeenFilter) -> tuple[list[Recording], float]:
    """The recordings without what the filter smears of their ends, and how much that is at each, s.

    As they are, and 0, where its kind is not known or too little would remain.
    """
    whole = [replace(recording, behind=seen) for recording in recordings]
    cut = None if seen.filter is None else recordings_from(whole, seen.reach)
    if cut is None:
        return whole, 0.0
    left = [float(recording.time[-1]) - seen.reach for recording in cut]
    if any(end < LEAST_SHARE * recording.time[-1] for end, recording in zip(left, recordings, strict=True)):
        return whole, 0.0
    # From its first sample once more, so that it is smoothed as a recording of its own.
    inside = (recording.between(0.0, end).later(0) for recording, end in zip(cut, left, strict=True))
    return [replace(one, name=recording.name) for one, recording in zip(inside, recordings, strict=True)], seen.reach


def bent_by_filter(model: TrajectoryModel, recordings: Sequence[Recording], stage: Stage) -> Array:
    """(p,) change of the common unknowns by what their filter makes of the fitted motions, if it is known.

    Of a linear swing it only scales the modes, alike at all joints, which the initial states take up.
    """
    none = np.zeros(len(stage.solution.values))
    if not recordings or any(recording.behind is None or recording.behind.filter is None for recording in recordings):
        return none

    def change(trial: int) -> Array:
        return _bent(model, recordings[trial], stage, trial)[:, :, None]

    followed = follow_changes(model, recordings, stage, change, lambda recording: np.zeros(len(recording.time), bool))
    moved = followed.considered.sensitivity[:, 0]
    return np.asarray(moved if np.isfinite(moved).all() else none)


def _bent(model: TrajectoryModel, recording: Recording, stage: Stage, trial: int) -> Array:
    """(m, n) rad by which the filter changes the fitted motion of a trial; 0 where that is not known.

    The motion is continued beyond both ends as far as the filter reaches: it runs over free motion only.
    """
    seen, motion, steps = recording.behind, stage.solution.predictions[trial], np.diff(recording.time)
    none = np.zeros_like(motion)
    assert seen is not None
    assert seen.filter is not None
    plain = not model.leg.effects and all(not joint.effects for joint in model.leg.joints)
    curved = any(joint.damper is not None and joint.damper.curve is not None for joint in model.leg.joints)
    if not plain or curved or np.ptp(steps) > EVEN * np.median(steps):
        return none
    values, local, step = stage.solution.values, stage.solution.locals[trial], float(np.median(steps))
    beyond = np.asarray(step * np.arange(round(seen.filter.reach) + 1), dtype=float)
    before = model.before(recording, values, local, beyond)[:0:-1]
    later = replace(recording, time=np.r_[recording.time, recording.time[-1] + beyond[1:]])
    start = np.concatenate([local.rotation, local.rate])[:, None]
    whole = np.vstack([before, model.run(later, values[:, None], start, local.shift[:, None])[:, :, 0]])
    if not np.isfinite(whole).all():
        return none
    inside = slice(len(before), len(before) + len(motion))
    return np.asarray(filtered(whole, seen.filter)[inside] - whole[inside])


def filtered(motion: Array, which: LowPass) -> Array:
    """(m, n) a motion at even times behind a filter without delay; its ends are continued by reflection."""
    reach = min(round(which.reach), len(motion) - 1)
    longer = np.pad(motion, ((reach, reach), (0, 0)), mode="reflect", reflect_type="odd")
    # From one end to the other of the period that Fourier's series needs, along a line.
    line = np.linspace(0.0, 1.0, len(longer), endpoint=False)[:, None] * (longer[-1] - longer[0])
    gain = which.response(np.arange(len(longer) // 2 + 1) / len(longer))[:, None]
    smooth = np.fft.irfft(gain * np.fft.rfft(longer - line, axis=0), len(longer), axis=0)
    return np.asarray((smooth + line)[reach : len(longer) - reach])
