"""Impossible or implausible input, each reported in a sentence with what to check.

A fit follows its input. A link's inertia in other units, a frozen channel, a clock in milliseconds or a
joint's wrong sign all give springs, and some fit well. The leg's parameters are therefore compared with those of
rigid links, the recordings with limbs of this size, and if the fit is poor, some samples are fitted with each joint's
sign or zero changed, and all of them with the most hopeful changes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array
from synth.drives.servo import Servo
from synth.fit.estimate import least_residuals
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_problem import model_of
from synth.fit.fit_result import FitResult
from synth.fit.later_samples import recordings_from
from synth.fit.least_squares import FitStart
from synth.fit.leg_plausibility import leg_doubts
from synth.fit.recordings import Recording
from synth.fit.refinement import refine
from synth.fit.starts import first_locals, weak_form_start
from synth.fit.uncertainty import root_mean_square, sample_scatter
from synth.motion.limb_pace import pace_doubt
from synth.remarks import decisive
from synth.swing.leg_model import Joint, Leg

POOR_SHARE = 0.12  # of a joint's RMS deviation from its rest: larger than the residual of a correct leg
SCATTER_ALONE = 5.0  # times the samples' scatter, below which nothing remains to explain
UNEXPLAINED = 1.5  # times the samples' scatter, above which a fit with a rate at a bound of the search is poor too
FITTING_SHARE = 0.4  # of the poor fit's residual above the noise, that a changed sign or zero must reach to be named
# The same of a rough fit, to be refined: rough ones are within a third of their refined residual, or far off
HOPEFUL_SHARE = 0.8
TRIED, SAMPLES = 2, 100  # trials, and samples of each, for testing signs and zeros
CONFIRMED = 3  # of what these suggest, signs and zeros with which all trials are fitted: one joint's right and the next
FROZEN_SAMPLES, FROZEN_SHARE = 8, 0.1  # equal readings, and share of the recording, from which a channel may be frozen
ABRUPT_RATE = 0.3  # of the joint's largest rate, with which a frozen channel stops or starts
COMMON = LegFitOptions(free_angle="common")
LEAP_RATIO = 1.5  # times any other change between samples: size of the jump after a frozen channel
ZEROS = (np.pi, 0.5 * np.pi, -0.5 * np.pi)  # rad, usual offsets of the zero between conventions


def doubts(leg: Leg, recordings: Sequence[Recording], result: FitResult) -> tuple[str, ...]:
    """All warnings about a fit's input."""
    messages = [*leg_doubts(leg), *recording_doubts(leg, recordings), *convention_doubts(leg, recordings, result)]
    return tuple(messages)


def recording_doubts(leg: Leg, recordings: Sequence[Recording]) -> list[str]:
    """Sentences on frozen channels, and on motion far too slow or fast for a limb of this size."""
    messages = []
    for recording in recordings:
        for j in recording.free:
            text = _frozen(recording, j)
            if text:
                messages.append(decisive(f"{recording.name}: {leg.joints[j].name} {text}"))
    pace = float(np.median([recording.smoothed.pace for recording in recordings])) if recordings else np.nan
    return [*messages, *(decisive(text) for text in [pace_doubt(leg, pace)] if text)]


def _frozen(recording: Recording, joint: int) -> str:
    """The description of a channel that freezes while the motion continues; empty if none does."""
    counts = recording.counts[:, joint]
    time, value = recording.time[counts], recording.rotation[counts, joint]
    if len(value) < 2 * FROZEN_SAMPLES:
        return ""
    edges = np.flatnonzero(np.diff(value) != 0.0)
    starts, ends = np.r_[0, edges + 1], np.r_[edges, len(value) - 1]
    longest = int(np.argmax(ends - starts))
    first, last = int(starts[longest]), int(ends[longest])
    if last - first + 1 < max(FROZEN_SAMPLES, FROZEN_SHARE * len(value)):
        return ""
    smoothed = recording.smoothed
    others = [j for j in recording.free if j != joint]
    during = (smoothed.time >= time[first]) & (smoothed.time <= time[last])
    moves = any(
        np.abs(smoothed.rate[during, j]).max() > ABRUPT_RATE * np.abs(smoothed.rate[:, j]).max() for j in others
    )
    # A joint that stops on one count slows down before; a frozen channel stops, or starts, at full speed.
    lag = min(max(3, round(smoothed.pace / float(np.median(np.diff(time))))), len(value) // 4)
    change = np.abs(value[lag:] - value[:-lag])
    beside = [change[max(0, first - lag)] if first >= lag else 0.0, change[last] if last + lag < len(value) else 0.0]
    steps = np.abs(np.diff(value))
    leaps = [steps[k] for k in (first - 1, last) if 0 <= k < len(steps)]
    inside = np.isin(np.arange(len(steps)), (first - 1, last))
    leapt = bool(leaps) and max(leaps) > LEAP_RATIO * steps[~inside].max(initial=0.0)
    if not (moves if change.max() == 0.0 else leapt or max(beside) > ABRUPT_RATE * change.max()):
        return ""
    return (
        f"reads the same from {time[first]:.3f} to {time[last]:.3f} s but moves at full speed before or after: a "
        "frozen channel, or a stop? Leave those cells empty if it is frozen; list the joint under `locked` if it was "
        "held"
    )


def convention_doubts(leg: Leg, recordings: Sequence[Recording], result: FitResult) -> list[str]:
    """If the fit is poor: the joint whose changed sign or zero would make it good.

    ``recordings`` : whole, as they were given to the fit; they are cut here where ``result`` begins later.
    """
    recordings = recordings_from(recordings, result.cut) or recordings if result.cut else recordings
    left = np.array([result.averaged_rms[name] for name in leg.joint_names])
    scatter = sample_scatter(recordings)
    poor = (left > POOR_SHARE * _motion(recordings)) & (left > SCATTER_ALONE * scatter)
    # A wrong sign need not leave much: an absurdly strong damper may hide it.
    if result.at_bound:
        poor |= left > UNEXPLAINED * scatter
    if not np.any(poor):
        return []
    before, floor = _overall(left), _overall(scatter)
    for change in _hopeful_changes(leg, recordings, left):
        turned = [_in_convention(recording, change.joint, change.old, change.new) for recording in recordings]
        # Two trials with one free angle tell little of all, of which each may have its own.
        after = _overall(least_residuals(change.of(leg), turned, result.free_angle))
        if after < _mixed(floor, before, FITTING_SHARE):
            text = (
                f"the fit leaves {np.degrees(before):.2g} deg RMS over all joints; with {change.words} of the "
                f"{change.old.name} a fit of the same trials leaves {np.degrees(after):.2g} deg. Sign or zero of the "
                f"{change.old.name}?"
            )
            return [decisive(text)]
    return []


@dataclass(frozen=True)
class _Change:
    """A joint's other sign or zero; ``left`` rad, of a fit of few samples in it."""

    joint: int
    old: Joint
    new: Joint
    words: str
    left: float = np.inf

    def of(self, leg: Leg) -> Leg:
        """The leg with it."""
        return replace(leg, joints=(*leg.joints[: self.joint], self.new, *leg.joints[self.joint + 1 :]))


def _hopeful_changes(leg: Leg, recordings: Sequence[Recording], left: Array) -> list[_Change]:
    """The changes with which few samples fit far better than ``left`` (n,) rad, at most ``CONFIRMED``, best first."""
    some = [recording.thinned(SAMPLES) for recording in recordings[:TRIED]]
    floor = float(np.sqrt(np.nansum(sample_scatter(some) ** 2)))
    # The fit itself may have failed because of its start: a changed leg is compared with the better of the two.
    before = min(_residual_left(leg, some), float(np.sqrt(np.nansum(left**2))))
    found = []
    for j, joint in enumerate(leg.joints):
        for new, words in _changes(joint):
            change = _Change(j, joint, new, words)
            turned = [_in_convention(recording, j, joint, new) for recording in some]
            after = _residual_left(change.of(leg), turned, _mixed(floor, before, HOPEFUL_SHARE))
            if after < _mixed(floor, before, FITTING_SHARE):
                found.append(replace(change, left=after))
    return sorted(found, key=lambda change: change.left)[:CONFIRMED]


def _mixed(floor: float, before: float, share: float) -> float:
    """The noise and this share of what is left above it, as residuals add: by their squares."""
    return float(np.sqrt(max(0.0, floor**2 + share**2 * (before**2 - floor**2))))


def _overall(rms: Array) -> float:
    """Root mean square over the joints, of theirs (n,); one of nan has no samples."""
    return float(np.sqrt(np.nanmean(rms**2)))


def _changes(joint: Joint) -> list[tuple[Joint, str]]:
    made = [(replace(joint, sign=-joint.sign), f"sign: {-joint.sign:+d}")]
    for shift in ZEROS:
        zero = joint.zero + shift
        made.append((replace(joint, zero=zero), f"zero: {np.degrees(zero):.0f} deg"))
        made.append(
            (replace(joint, zero=zero, sign=-joint.sign), f"zero: {np.degrees(zero):.0f} deg and the other sign")
        )
    return made


def _in_convention(recording: Recording, j: int, old: Joint, new: Joint) -> Recording:
    """The same readings of joint ``j``, and what drives it, in another convention."""
    turn = new.sign * old.sign
    shift = new.sign * (old.zero - new.zero)
    rotation, smoothed = recording.rotation.copy(), recording.smoothed
    angle, rate = smoothed.angle.copy(), smoothed.rate.copy()
    rotation[:, j] = turn * rotation[:, j] + shift
    angle[:, j], rate[:, j] = turn * angle[:, j] + shift, turn * rate[:, j]
    known = recording.known_torque
    if known is not None:
        torque = known[1].copy()
        torque[:, j] *= turn
        known = (known[0], torque)
    signals, own = recording.signals, recording.leg
    if signals is not None:
        command, supply = signals.command.copy(), signals.supply.copy()
        command[:, j] = turn * command[:, j] + shift
        if isinstance(old.drive, Servo) and old.drive.open_duty:
            supply[:, j] *= turn  # a known voltage has a sense; a controller's supply has none
        signals = replace(signals, command=command, supply=supply)
    if own is not None:
        own = own.with_joints(**{own.joints[j].name: {"sign": new.sign, "zero": new.zero}})
    smoothed = replace(smoothed, angle=angle, rate=rate)
    made = replace(recording, rotation=rotation, smoothed=smoothed, known_torque=known, signals=signals, leg=own)
    return replace(made, spread=None)  # no figure is stated of it


def _residual_left(leg: Leg, recordings: Sequence[Recording], hopeful: float = np.inf) -> float:
    """RMS over all joints, rad, after one descent from the weak form's start; infinite if it diverges.

    A rough fit that leaves more than ``hopeful`` rad is not refined.
    """
    model = model_of(leg, recordings=recordings)
    start = FitStart(weak_form_start(model, recordings, COMMON).values, first_locals(recordings))
    for rounds in (0, 1):
        stage = refine(model, recordings, start, "noise", np.zeros(len(leg.joints)), rounds=rounds)
        if not np.isfinite(stage.solution.cost):
            return float("inf")
        found = float(np.sqrt(np.nansum(root_mean_square(recordings, stage.solution.predictions) ** 2)))
        if found > hopeful:
            break
    return found


def _motion(recordings: Sequence[Recording]) -> Array:
    """(n,) rad, RMS deviation of each joint from the end of its recordings."""
    stacked = [np.where(r.counts, r.rotation - r.smoothed.angle[-1], np.nan) for r in recordings]
    square = np.concatenate(stacked) ** 2
    observed = np.isfinite(square).any(axis=0)
    return np.sqrt(
        np.where(observed, np.nansum(square, axis=0) / np.maximum(np.isfinite(square).sum(axis=0), 1), np.inf)
    )
