"""Recordings that begin before the release: those at rest at first are cut to it, or left out.

A limb that is at rest and then moves without a torque of its own was released or driven; it is not free motion from
the first sample. One such recording among thirty halved a knee's fitted stiffness.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.fit.recordings import LEAST_SAMPLES as FEWEST_SAMPLES
from synth.fit.recordings import Recording
from synth.motion.release import Release, find_release
from synth.swing.leg_model import Leg

LEAST_SAMPLES = 30  # that a cut leaves: fewer do not determine a leg's rates
# Of the recording's time, that fewer samples must cover at least: a release that was seen to its end at a low rate.
LEAST_SHARE = 0.4
# Of the recordings: where so many probably begin at rest, and one clearly does, so do all that probably do. Of free
# motion a few that probably do by chance; to cut such a one loses the little that it moves in that time.
SERIES_SHARE = 0.5
STILL, FIRST = (
    0.2,
    0.05,
)  # of a joint's range, and s in its unit of time: a joint that moves farther is not at rest, nor checked


@dataclass(frozen=True)
class Begun:
    """``recordings`` from their release, without those with too few samples after it; ``messages`` : what was cut."""

    recordings: list[Recording]
    messages: tuple[str, ...] = ()


def from_release(leg: Leg, recordings: Sequence[Recording]) -> Begun:
    """Cut each recording that clearly begins at rest to the latest time of its release.

    Where most of them probably do, and one clearly, the others are cut too: a series is recorded in one way.
    A recording driven by a known torque may begin at rest and is kept. If none would remain, none is cut, and the
    messages state this.
    """
    releases = [release_in(leg, recording) if _may_lie_still(recording) else None for recording in recordings]
    seen = [found for found in releases if found is not None]
    clear, likely = (sum(each) for each in ([f.still_first for f in seen], [f.maybe_still_first for f in seen]))
    series = clear > 0 and likely >= SERIES_SHARE * len(recordings)
    kept: list[Recording] = []
    messages: list[str] = []
    for recording, found in zip(recordings, releases, strict=True):
        still = found is not None and (found.maybe_still_first if series else found.still_first)
        if found is None or not still or found.released_by is None:
            kept.append(recording)
            continue
        first = int(np.searchsorted(recording.time, found.released_by))
        left = len(recording.time) - first
        text = f"{recording.name}: the limb is at rest at first and is {found.sentence.split(';')[0]}"
        share = (recording.time[-1] - found.released_by) / recording.time[-1]
        if left >= (FEWEST_SAMPLES if share >= LEAST_SHARE else LEAST_SAMPLES):
            kept.append(recording.later(first))
            messages.append(f"{text}; fitted from {recording.time[first]:.3f} s after its first sample")
        else:
            messages.append(
                f"{text}; only {left} samples follow, so it is left out. Does its window contain a release?"
            )
    if not kept:
        return Begun(list(recordings), tuple(f"{text} (used nevertheless: no other remains)" for text in messages))
    return Begun(kept, tuple(messages))


def release_in(leg: Leg, recording: Recording) -> Release | None:
    """The result of ``find_release`` for a recording; None if a known torque drives it, or it is too short."""
    if recording.driven:
        return None
    conditions = recording.conditions
    tilted = replace(leg, tilt=leg.tilt + conditions.tilt)
    held = np.isin(np.arange(len(leg.joints)), conditions.locked)
    angles = leg.to_measured(np.where(recording.counts | held, recording.rotation, np.nan))
    try:
        return find_release(
            recording.time, angles, tilted, locked=conditions.locked, tip_mass=conditions.tip_mass, unit=recording.unit
        )
    except ValueError:
        return None


def _may_lie_still(recording: Recording) -> bool:
    """Whether no joint moves far at first: a fast test that exempts most recordings from a closer one."""
    angle = recording.smoothed.angle[:, recording.free]
    early = recording.smoothed.time - recording.smoothed.time[0] <= FIRST * recording.unit
    return bool(np.all(np.ptp(angle[early], axis=0) <= STILL * np.ptp(angle, axis=0)))
