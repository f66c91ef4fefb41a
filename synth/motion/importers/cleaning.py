"""Common faults of angles: jumps by whole turns, gaps, lost frames; repaired if possible, and reported."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array, Mask
from synth.errors import Problem, UserError
from synth.files.turns import TURN, Unwrapped, continued, unwrapped, usual_angle, widest
from synth.motion.filled_gaps import filled_gaps
from synth.motion.smoothing import lost_samples
from synth.sampling import densest_clock, own_moments
from synth.swing.leg_model import Joint, Leg

OUTSIDE = np.radians(5.0)  # beyond a joint's range, smallest reported value
MOST_OUTSIDE = 0.5  # share of samples outside the range, above which the reading is another turn's
# A lost frame makes a step of a whole number of usual ones to this share of one; by chance a share 2 WHOLE does.
WHOLE, MOSTLY_WHOLE = 0.15, 0.65
UNEVEN = 1.5  # median steps: a longer one is a gap in the recording
SHORTEST = 12  # samples needed by a fit


@dataclass(frozen=True, eq=False)
class CleanedAngles:
    """Measured angles (n, n_joint) rad, nan where missing, what was found, and the whole turns of each joint."""

    angles: Array
    notes: tuple[str, ...]
    turns: tuple[JointTurns, ...]


@dataclass(frozen=True)
class JointTurns:
    """One joint's angles without jumps, before they were shifted: median, least and largest, rad.

    ``free`` : their whole turns are arbitrary, as of directions and wrapped readings; ``inside`` : most lie inside the
    joint's stated range; ``shift`` : whole turns by which they were shifted.
    """

    middle: float
    low: float
    high: float
    free: bool
    inside: bool
    shift: int = 0

    @property
    def settled(self) -> bool:
        """Whether the file counts the turns, and as the leg file does."""
        return self.inside and not self.free


def clean_angles(
    time: Array,
    angles: Array,
    leg: Leg,
    name: str,
    *,
    arbitrary_turns: Collection[str] = (),
    turns: Sequence[int] | None = None,
) -> CleanedAngles:
    """Continue over jumps by whole turns, and shift by whole turns to the leg file's convention.

    Parameters
    ----------
    time : (n,) s.
    angles : (n, n_joint) rad, measured angles.
    arbitrary_turns : joints whose angles come from directions: their whole turns are meaningless and not reported.
    turns : whole turns to shift each joint by; None: as this recording alone would have them.

    Raises
    ------
    UserError : time that does not increase, or a joint with too few samples.
    """
    notes = _check_clock(time, np.isfinite(angles), leg.joint_names, name)
    result = angles.copy()
    found: list[JointTurns] = []
    for j, joint in enumerate(leg.joints):
        known, arbitrary = np.isfinite(angles[:, j]), joint.name in arbitrary_turns
        if known.sum() < SHORTEST:
            text = f"{known.sum()} of {len(time)} samples remain for the {joint.name}; at least {SHORTEST} are needed"
            raise UserError(Problem(text, name))
        whole = Unwrapped(continued(angles[:, j]), 0, None) if arbitrary else unwrapped(angles[:, j])
        found.append(_turns_of(whole.angle[known], joint, free=arbitrary or whole.jumps > 0))
        shift = common_turns(joint, found[-1:])[0] if turns is None else turns[j]
        found[-1] = replace(found[-1], shift=shift)
        result[:, j] = whole.angle + shift * TURN
        if whole.jumps:
            notes.append(f"{joint.name}: {whole.jumps} jumps by a whole turn removed")
        if shift and not arbitrary:
            notes.append(f"{joint.name}: shifted by {shift * 360:+d} deg to the leg file's convention")
    return CleanedAngles(result, tuple(notes), tuple(found))


def _turns_of(known: Array, joint: Joint, *, free: bool) -> JointTurns:
    """What decides on the whole turns of one joint's angles (m,) rad."""
    inside = joint.range is not None and _share_outside(known, joint.range) <= MOST_OUTSIDE
    return JointTurns(float(np.median(known)), float(known.min()), float(known.max()), free, inside)


def common_turns(joint: Joint, found: Sequence[JointTurns]) -> list[int]:
    """Whole turns that bring recordings of one joint together, in the leg file's convention.

    Readings inside the joint's stated range stay as they are. All others go to the turn nearest to these; where there
    are none, to that of the first, which lies inside or goes to the turn nearest to the joint's usual angle. A shift
    that the reader of trials would refuse is none: its message then tells the angles of the file.
    """
    settled = [each.middle for each in found if each.settled]
    inside = [each.middle for each in found if each.inside]
    alone = found[0].middle + TURN * round((usual_angle(joint) - found[0].middle) / TURN)
    first = float(np.median(settled)) if settled else [*inside, alone][0]
    turns = [0 if each.settled else round((first - each.middle) / TURN) for each in found]
    limit = widest(joint)
    return [
        0 if max(abs(each.low + k * TURN), abs(each.high + k * TURN)) > limit else k
        for each, k in zip(found, turns, strict=True)
    ]


def remarks(time: Array, angles: Array, leg: Leg) -> list[str]:
    """Faults of a trial (n,) s, (n, n_joint) rad: missing samples, spikes, angles outside the joints' ranges."""
    return _gap_notes(time, angles, leg) + _range_notes(angles, leg)


def _check_clock(time: Array, known: Mask, joints: Sequence[str], name: str) -> list[str]:
    """Refuse a clock that stops or runs backwards; report lost frames, and joints with moments of their own."""
    if len(time) < SHORTEST:
        raise UserError(Problem(f"has {len(time)} samples; at least {SHORTEST} are needed", name))
    if not np.isfinite(time).all():
        row = int(np.argmin(np.isfinite(time)))
        text = f"sample {row + 1} has no time: write it, or remove that row"
        raise UserError(Problem(text, name))
    step = np.diff(time)
    if (step <= 0).any():
        row = int(np.argmax(step <= 0))
        what = "repeats" if step[row] == 0 else "runs backwards"
        text = f"time {what} at sample {row + 2}: {time[row]:g} s, then {time[row + 1]:g} s"
        raise UserError(Problem(text, name))
    own = own_moments(time, known)
    clock = densest_clock(time, own)
    apart = ", ".join(f"{joint} {count}" for joint, count in zip(joints, own.sum(axis=0).tolist(), strict=True))
    sampled = own.any(axis=1)
    if not own[sampled].all():
        return [f"its joints are sampled at different moments ({apart}): each has its own clock", *_lost_frames(clock)]
    others = int((~sampled).sum())
    notes = [f"{others} of its rows are moments of other columns, without a sample of a joint"] if others else []
    return notes + _lost_frames(clock)


def _lost_frames(time: Array) -> list[str]:
    """The message on gaps of a clock (n,) s; none without gaps."""
    step = np.diff(time)
    middle = float(np.median(step))
    holes = step > UNEVEN * middle
    if holes.any():
        where = time[int(np.argmax(holes))]
        frames = step[holes] / middle
        whole = np.abs(frames - np.round(frames)) < WHOLE
        if np.mean(whole) < MOSTLY_WHOLE:
            text = f"its clock is uneven: steps of {1e3 * step.min():.3g} to {1e3 * step.max():.3g} ms, usually "
            return [f"{text}{1e3 * middle:.3g} ms; {int(holes.sum())} are long, the first after {where:.3f} s"]
        lost = int(np.round(frames - 1).sum())
        if lost == 1:
            return [f"1 frame is lost in the clock, after {where:.3f} s"]
        gaps = "1 gap of the clock," if holes.sum() == 1 else f"{int(holes.sum())} gaps of the clock, the first"
        return [f"{lost} frames are lost in {gaps} after {where:.3f} s"]
    return []


def _gap_notes(time: Array, angles: Array, leg: Leg) -> list[str]:
    """Missing samples by joint, with the longest gap, gaps that a program filled, and outliers."""
    notes = []
    spikes = lost_samples(time, angles) & np.isfinite(angles)
    own = own_moments(time, np.isfinite(angles))
    for j, name in enumerate(leg.joint_names):
        missing = own[:, j] & ~np.isfinite(angles[:, j])
        if missing.any():
            known = time[np.isfinite(angles[:, j])]
            text = f"{name}: {int(missing.sum())} of {int(own[:, j].sum())} samples are missing and not filled"
            inside = missing & (time > known.min(initial=np.inf)) & (time < known.max(initial=-np.inf))
            if inside.any():
                inner = np.diff(known)
                at = int(np.argmax(inner))
                text += f"; the longest gap is {inner[at] * 1e3:.0f} ms, from {known[at]:.3f} s on"
            notes.append(text)
        good = np.isfinite(angles[:, j])
        filled = np.zeros(len(time), dtype=bool)
        filled[good] = filled_gaps(time[good], angles[good, j])
        if filled.any():
            text = f"{name}: {int(filled.sum())} samples lie on straight lines or cubics (first at "
            text += f"{time[int(np.argmax(filled))]:.3f} s), as where a program fills gaps"
            notes.append(f"{text}; they are kept, but a fit ignores them")
            spikes[filled, j] = False
        if spikes[:, j].any():
            at = int(np.argmax(spikes[:, j]))
            count = int(spikes[:, j].sum())
            if count == 1:
                notes.append(f"{name}: 1 sample is an outlier (at {time[at]:.3f} s); it is kept, but a fit ignores it")
                continue
            text = f"{name}: {count} samples are outliers (first at {time[at]:.3f} s)"
            notes.append(f"{text}; they are kept, but a fit ignores them")
    return notes


def _range_notes(angles: Array, leg: Leg) -> list[str]:
    """Joints outside their range, and whether the other sign would bring them inside."""
    notes = []
    for j, joint in enumerate(leg.joints):
        if joint.range is None:
            continue
        known = angles[np.isfinite(angles[:, j]), j]
        outside = _share_outside(known, joint.range) if len(known) else 0.0
        if not outside:
            continue
        low, high = np.degrees(joint.range)
        text = f"{joint.name}: {outside:.0%} of the samples lie outside its range [{low:g}, {high:g}] deg"
        mirrored = 2.0 * joint.zero - known
        mirrored += TURN * np.round((usual_angle(joint) - float(np.median(mirrored))) / TURN)
        # Most samples outside, and nearly all inside with the other sign.
        if outside > 0.5 and _share_outside(mirrored, joint.range) < 0.1:
            text += "; with the other sign they would be inside: is the sign (or the camera's side) wrong?"
        notes.append(text)
    return notes


def _share_outside(angle: Array, span: tuple[float, float]) -> float:
    return float(np.mean((angle < span[0] - OUTSIDE) | (angle > span[1] + OUTSIDE)))
