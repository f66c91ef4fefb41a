"""Table 2 on releases that took no part: what the seven tell of the animal's others, beside what bounds any such leg.

Two bounds. Repeats of one muscle, recorded alike, differ by so much that nothing which is the same for all of them can
come nearer. And a leg of constant springs and dampers, fitted to the very release that it is judged by, misses by so
much that no other such leg can be expected to do better.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from synth.errors import UserError
from synth.fit.estimate import fit_leg
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_result import FitResult
from synth.fit.free_angle import WIDE
from synth.fit.free_motion_start import cut_of, later, look
from synth.fit.recordings import Recording
from synth.fit.still_start import from_release
from synth.fit.unseen_score import score
from synth.motion.characteristics import Characteristics, characteristics
from synth.validation.comparison_table import ComparisonRow, ComparisonTable
from synth.validation.explanations import median_text
from synth.validation.thesis_data import JOINTS, SEVEN, LabData

# What is judged, as in Table 2: its name here, the joint and the characteristic.
JUDGED = (
    ("frequency", "knee", "damped_frequency"),
    ("damping ratio", "knee", "damping_ratio"),
    ("rise time", "hip", "rise_time"),
)
OPTIONS = LegFitOptions(free_angle="per_trial")
RISEN = 0.1  # of the way to rest that is left when a rise counts as over
FEWEST = 5  # unseen releases, below which medians say nothing

Errors = dict[str, list[float]]


@dataclass(frozen=True)
class _Releases:
    """The seven and the others from one moment on."""

    seven: list[Recording]
    others: list[Recording]


def unseen_table(data: LabData) -> ComparisonTable | None:
    """Median errors of the unseen releases' characteristics; None where there are too few."""
    begun = from_release(data.rat, data.trials(data.rat, ["rat/releases/*.csv"]))
    first = _parted(begun.recordings)
    if len(first.others) < FEWEST or len(first.seven) < len(SEVEN):
        return None
    seen = look(data.rat, first.seven)
    start = cut_of(seen) if seen.known else 0.0
    both = later(begun.recordings, start) if start else begun.recordings
    free = _parted(both or begun.recordings)
    columns = {
        "the seven, from the first sample": _errors(fit_leg(data.rat, first.seven, OPTIONS), first.others),
        "the seven, after the muscles": _errors(fit_leg(data.rat, free.seven, OPTIONS), free.others),
        "each its own leg, after the muscles": _own(data, free.others),
        "median of its repeats, recorded": _repeats(free),
    }
    rows = tuple(
        ComparisonRow(name, tuple(median_text(errors[name]) for errors in columns.values())) for name, _, _ in JUDGED
    )
    return ComparisonTable(
        "Unseen releases",
        "The rat's other releases: errors of the characteristics, medians",
        ("", *columns),
        rows,
        f"{len(first.others)} releases that took no part. Fitted to the thesis' seven; of each other the initial "
        "state and its free angles are estimated. After the muscles: from "
        f"{1e3 * start:.0f} ms after the first sample on.",
        (*begun.said, *_said(columns, first, start)),
    )


def _parted(recordings: Sequence[Recording]) -> _Releases:
    used = [Path(recording.name).stem in SEVEN for recording in recordings]
    both = list(zip(recordings, used, strict=True))
    return _Releases([r for r, seven in both if seven], [r for r, seven in both if not seven])


def _errors(fit: FitResult, recordings: Sequence[Recording]) -> Errors:
    """Relative errors of each characteristic, where recording and prediction both show it."""
    found: Errors = {name: [] for name, _, _ in JUDGED}
    scored = score(fit, recordings, spread=np.full(len(JOINTS), WIDE))
    for recording, prediction in zip(recordings, scored.predictions, strict=True):
        for name, joint, term in JUDGED:
            j = JOINTS.index(joint)
            theirs, ours = _of(recording, j), characteristics(recording.time, prediction[:, j], _noise(recording, j))
            value, guess = getattr(theirs, term), getattr(ours, term)
            if value is not None and guess is not None:
                found[name].append(abs(guess / value - 1.0))
    return found


def _own(data: LabData, recordings: Sequence[Recording]) -> Errors:
    found: Errors = {name: [] for name, _, _ in JUDGED}
    for recording in recordings:
        try:
            errors = _errors(fit_leg(data.rat, [recording]), [recording])
        except UserError:
            continue  # no leg at all follows this one
        for name in found:
            found[name] += errors[name]
    return found


def _repeats(releases: _Releases) -> Errors:
    """Each release judged by the median of its muscle's other repeats, as recorded: no model."""
    found: Errors = {name: [] for name, _, _ in JUDGED}
    everything = [*releases.seven, *releases.others]
    for recording in releases.others:
        muscle = _muscle(recording)
        repeats = [other for other in everything if other is not recording and _muscle(other) == muscle]
        for name, joint, term in JUDGED:
            j = JOINTS.index(joint)
            value = getattr(_of(recording, j), term)
            others = [each for each in (getattr(_of(repeat, j), term) for repeat in repeats) if each is not None]
            if value is not None and others:
                found[name].append(abs(float(np.median(others)) / value - 1.0))
    return found


def _said(columns: dict[str, Errors], first: _Releases, start: float) -> list[str]:
    whole, free, own, repeats = columns.values()
    said = []
    for name in ("frequency", "damping ratio"):
        theirs, bound, scatter = (float(np.median(errors[name])) for errors in (free, own, repeats))
        within = "within 1.2 times" if theirs <= 1.2 * bound else f"{theirs / bound:.1f} times"
        said.append(
            f"{name}: the seven's leg misses by {100 * theirs:.0f} %, {within} the {100 * bound:.0f} % by which a leg "
            f"fitted to the release itself does; its repeats scatter by {100 * scatter:.0f} %: what is left is the law "
            "of the springs and dampers, not the animal's variation."
        )
    ends = [_risen(recording) for recording in (*first.seven, *first.others)]
    inside = sum(end is not None and end <= start for end in ends)
    said.append(
        f"rise time: {inside} of {len(ends)} hips have {100 * (1 - RISEN):.0f} % of their way behind them by "
        f"{1e3 * start:.0f} ms, while muscles act: the recorded rise is how a muscle lets go, which no passive leg "
        f"tells, and what is left after it is too small to have one. From the first sample on the error is "
        f"{median_text(whole['rise time'])}."
    )
    return said


def _risen(recording: Recording) -> float | None:
    """When the hip has less than ``RISEN`` of its way to rest left, s."""
    angle = recording.smoothed.angle[:, JOINTS.index("hip")]
    away = angle - float(np.mean(angle[-max(2, len(angle) // 10) :]))
    near = np.flatnonzero(np.abs(away) <= RISEN * abs(away[0]))
    return float(recording.smoothed.time[near[0]]) if len(near) else None


def _of(recording: Recording, joint: int) -> Characteristics:
    smoothed = recording.smoothed
    return characteristics(smoothed.time, smoothed.angle[:, joint], _noise(recording, joint))


def _noise(recording: Recording, joint: int) -> float:
    return float(recording.smoothed.noise[joint])


def _muscle(recording: Recording) -> str:
    return Path(recording.name).stem.rsplit("_", 1)[0]
