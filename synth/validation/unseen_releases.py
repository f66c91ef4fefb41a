"""Table 2 on unseen releases: how well a leg fitted to the seven releases predicts the animal's other releases.

Two lower bounds of the error stand beside it. The scatter of a muscle's repeats bounds every prediction that is the
same for all of them. The error of a leg fitted to the very release that it predicts bounds every leg with constant
spring and damper rates.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from synth.arrays import Array
from synth.errors import UserError
from synth.fit.estimate import fit_leg
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_result import FitResult
from synth.fit.free_angle import WIDE
from synth.fit.free_motion_start import cut_of, detect_drive
from synth.fit.later_samples import recordings_from
from synth.fit.recordings import Recording
from synth.fit.still_start import from_release
from synth.fit.unseen_score import score
from synth.motion.characteristics import Characteristics, characteristics
from synth.motion.rest import last_tenth
from synth.validation.comparison_table import ComparisonRow, ComparisonTable
from synth.validation.explanations import median_text
from synth.validation.thesis_data import JOINTS, SEVEN, LabData

# The compared characteristics of Table 2: name in the table, joint, field of ``Characteristics``.
JUDGED_FEATURES = (
    ("frequency", "knee", "damped_frequency"),
    ("damping ratio", "knee", "damping_ratio"),
    ("rise time", "hip", "rise_time"),
)
OPTIONS = LegFitOptions(free_angle="per_trial")
REST_SHARE = 0.1  # share of the way to rest that remains at the end of a rise
LEAST_RELEASES = 5  # unseen releases; medians of fewer are meaningless

FeatureErrors = dict[str, list[float]]


@dataclass(frozen=True)
class _Releases:
    """The seven releases and the others, all cut at the same time."""

    seven: list[Recording]
    others: list[Recording]


def unseen_table(data: LabData) -> ComparisonTable | None:
    """Median errors of the unseen releases' characteristics; None if there are too few releases.

    Raises
    ------
    UserError : a recording cannot be used.
    """
    begun = from_release(data.rat, data.trials(data.rat, ["rat/releases/*.csv"]))
    first = _part_releases(begun.recordings)
    if len(first.others) < LEAST_RELEASES or len(first.seven) < len(SEVEN):
        return None
    drive = detect_drive(data.rat, first.seven)
    start = cut_of(drive) if drive.ends else 0.0
    both = recordings_from(begun.recordings, start) if start else begun.recordings
    free = _part_releases(both or begun.recordings)
    columns = {
        "leg of the seven, from the first sample": _prediction_errors(
            fit_leg(data.rat, first.seven, OPTIONS), first.others
        ),
        "leg of the seven, after muscle activity": _prediction_errors(
            fit_leg(data.rat, free.seven, OPTIONS), free.others
        ),
        "a leg per release, after muscle activity": _errors_of_own_fits(data, free.others),
        "median of its recorded repeats": _errors_of_repeats(free),
    }
    rows = tuple(
        ComparisonRow(name, tuple(median_text(errors[name]) for errors in columns.values()))
        for name, _, _ in JUDGED_FEATURES
    )
    return ComparisonTable(
        "Unseen releases",
        "The rat's other releases: errors of the characteristics, medians",
        ("", *columns),
        rows,
        f"{len(first.others)} unseen releases. The leg is fitted to the thesis' seven; of each unseen release the "
        "initial state and the free angles are estimated. After muscle activity: from "
        f"{1e3 * start:.0f} ms after the first sample on.",
        (*begun.messages, *_explanation_sentences(columns, first, start)),
    )


def _part_releases(recordings: Sequence[Recording]) -> _Releases:
    used = [Path(recording.name).stem in SEVEN for recording in recordings]
    both = list(zip(recordings, used, strict=True))
    return _Releases([r for r, seven in both if seven], [r for r, seven in both if not seven])


def _prediction_errors(fit: FitResult, recordings: Sequence[Recording]) -> FeatureErrors:
    """Relative errors of each characteristic in the releases of which recording and prediction show it."""
    found: FeatureErrors = {name: [] for name, _, _ in JUDGED_FEATURES}
    scored = score(fit, recordings, spread=np.full(len(JOINTS), WIDE))
    for recording, prediction in zip(recordings, scored.predictions, strict=True):
        for name, joint, term in JUDGED_FEATURES:
            j = JOINTS.index(joint)
            theirs, ours = (
                _characteristics_of(recording, j),
                _characteristics_about_end(recording.time, prediction[:, j], _channel_noise(recording, j)),
            )
            value, guess = getattr(theirs, term), getattr(ours, term)
            if value is not None and guess is not None:
                found[name].append(abs(guess / value - 1.0))
    return found


def _errors_of_own_fits(data: LabData, recordings: Sequence[Recording]) -> FeatureErrors:
    found: FeatureErrors = {name: [] for name, _, _ in JUDGED_FEATURES}
    for recording in recordings:
        try:
            errors = _prediction_errors(fit_leg(data.rat, [recording]), [recording])
        except UserError:
            continue  # no leg fits this release
        for name in found:
            found[name] += errors[name]
    return found


def _errors_of_repeats(releases: _Releases) -> FeatureErrors:
    """Errors of a prediction without a model: the median of the other recorded repeats of the same muscle."""
    found: FeatureErrors = {name: [] for name, _, _ in JUDGED_FEATURES}
    everything = [*releases.seven, *releases.others]
    for recording in releases.others:
        muscle = _muscle_name(recording)
        repeats = [other for other in everything if other is not recording and _muscle_name(other) == muscle]
        for name, joint, term in JUDGED_FEATURES:
            j = JOINTS.index(joint)
            value = getattr(_characteristics_of(recording, j), term)
            others = [
                each
                for each in (getattr(_characteristics_of(repeat, j), term) for repeat in repeats)
                if each is not None
            ]
            if value is not None and others:
                found[name].append(abs(float(np.median(others)) / value - 1.0))
    return found


def _explanation_sentences(columns: dict[str, FeatureErrors], first: _Releases, start: float) -> list[str]:
    whole, free, own, repeats = columns.values()
    messages = []
    for name in ("frequency", "damping ratio"):
        theirs, bound, scatter = (float(np.median(errors[name])) for errors in (free, own, repeats))
        # A fifth: below the scatter between releases.
        within = "within 1.2 times" if theirs <= 1.2 * bound else f"{theirs / bound:.1f} times"
        messages.append(
            f"{name}: the error of the leg of the seven is {100 * theirs:.0f} %, {within} the {100 * bound:.0f} % of a "
            f"leg fitted to the release itself; repeats scatter by {100 * scatter:.0f} %. The remaining error comes "
            "from the linear laws of springs and dampers, not from the animal's variation."
        )
    ends = [_rise_end(recording) for recording in (*first.seven, *first.others)]
    inside = sum(end is not None and end <= start for end in ends)
    messages.append(
        f"rise time: {inside} of {len(ends)} hips complete {100 * (1 - REST_SHARE):.0f} % of their motion within "
        f"{1e3 * start:.0f} ms, while muscles are active. The recorded rise is therefore the relaxation of a muscle, "
        "which no passive leg predicts, and the remaining motion is too small for a rise time. From the first sample "
        f"the error is {median_text(whole['rise time'])}."
    )
    return messages


def _rise_end(recording: Recording) -> float | None:
    """First time, s, at which less than ``REST_SHARE`` of the hip's way to rest remains; None if there is none."""
    angle = recording.smoothed.angle[:, JOINTS.index("hip")]
    away = angle - last_tenth(angle)
    near = np.flatnonzero(np.abs(away) <= REST_SHARE * abs(away[0]))
    return float(recording.smoothed.time[near[0]]) if len(near) else None


def _characteristics_of(recording: Recording, joint: int) -> Characteristics:
    smoothed = recording.smoothed
    return _characteristics_about_end(smoothed.time, smoothed.angle[:, joint], _channel_noise(recording, joint))


def _characteristics_about_end(time: Array, angle: Array, noise: float) -> Characteristics:
    """As in the thesis, a release's last samples are its rest; of a prediction the same samples."""
    return characteristics(time, angle, noise, rest=last_tenth(angle))


def _channel_noise(recording: Recording, joint: int) -> float:
    return float(recording.smoothed.noise[joint])


def _muscle_name(recording: Recording) -> str:
    return Path(recording.name).stem.rsplit("_", 1)[0]
