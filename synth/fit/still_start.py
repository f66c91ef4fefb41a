"""Recordings that begin before the release: held or at rest at first, they are cut to it, or left out.

A limb that lies still and then moves without a torque of its own was let go, or driven: neither is free motion from the
first sample on. One such recording among thirty halved a knee's fitted stiffness.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.fit.recordings import Recording
from synth.motion.release import Release, find_release
from synth.swing.leg_model import Leg

LEAST_SAMPLES = 30  # that a cut leaves: fewer tell a leg's rates from nothing
STILL, FIRST = (
    0.2,
    0.05,
)  # of a joint's range, and s: what moves farther at once does not lie still and is not looked at


@dataclass(frozen=True)
class Begun:
    """``recordings`` from their release on, without those that hold too little after it, and ``said`` what was done."""

    recordings: list[Recording]
    said: tuple[str, ...] = ()


def from_release(leg: Leg, recordings: Sequence[Recording]) -> Begun:
    """Cut each recording that plainly begins at rest to the latest time of its release.

    One that a known torque drives may begin at rest and is let be. Where none would be left, none is cut, and the
    sentences say so.
    """
    kept: list[Recording] = []
    said: list[str] = []
    for recording in recordings:
        found = release_in(leg, recording) if _may_lie_still(recording) else None
        if found is None or not found.still_first or found.released_by is None:
            kept.append(recording)
            continue
        first = int(np.searchsorted(recording.time, found.released_by))
        left = len(recording.time) - first
        text = f"{recording.name}: the limb lies still at first and is {found.sentence.split(';')[0]}"
        if left >= LEAST_SAMPLES:
            kept.append(recording.later(first))
            said.append(f"{text}; fitted from {recording.time[first]:.3f} s after its first sample on")
        else:
            said.append(f"{text}; only {left} samples come after that, so it is left out. Is its window a release's?")
    if not kept:
        return Begun(list(recordings), tuple(f"{text} (used all the same: no other is left)" for text in said))
    return Begun(kept, tuple(said))


def release_in(leg: Leg, recording: Recording) -> Release | None:
    """What ``find_release`` finds in a recording; None where a known torque drives it, or it is too short to tell."""
    if recording.driven:
        return None
    conditions = recording.conditions
    tilted = replace(leg, tilt=leg.tilt + conditions.tilt)
    held = np.isin(np.arange(len(leg.joints)), conditions.locked)
    angles = leg.to_measured(np.where(recording.counts | held, recording.rotation, np.nan))
    try:
        return find_release(recording.time, angles, tilted, locked=conditions.locked, tip_mass=conditions.tip_mass)
    except ValueError:
        return None


def _may_lie_still(recording: Recording) -> bool:
    """Whether no joint moves far at first: a cheap look, so that most recordings need no closer one."""
    angle = recording.smoothed.angle[:, recording.free]
    early = recording.smoothed.time - recording.smoothed.time[0] <= FIRST
    return bool(np.all(np.ptp(angle[early], axis=0) <= STILL * np.ptp(angle, axis=0)))
