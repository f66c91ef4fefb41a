"""Each channel by itself: frozen or saturated values, noise, counts, and signs of a filter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from synth.arrays import Array, Mask
from synth.diagnosis.check.finding import Finding
from synth.diagnosis.check.held_channels import held_finding
from synth.fit.filtered_readings import REMEDY, filtered_words
from synth.fit.recordings import Recording
from synth.fit.sensor_noise import AngleSensor
from synth.swing.leg_model import Leg
from synth.units import quantity

LONG_RUN = 10  # consecutive equal readings; a turning point has fewer
# Least speed, relative to the recording's fastest, at which readings must stop or resume for the channel
# to be frozen: friction slows a joint down before it stops.
LEAST_SPEED_SHARE = 0.1
JUMP_CHANGES = 8.0  # usual changes between readings that are missing during the run, or appear as a jump after it
OTHER_MOTION = np.radians(2.0)  # rad, motion of another joint while a channel does not change at all
LEAST_COUNT_SHARE = 0.1  # of the noise; a smaller count is only the file's last digit
# Of the largest motion (RMS): a designed servo without its dry friction was off by 0.23 on real logs of an XL330, and a
# larger accuracy accepts it.
LOOSE_SHARE = 0.25
COARSE_SHARE = 0.02  # of a joint's motion (RMS): a larger count or noise hides effects


@dataclass(frozen=True)
class Channel:
    """One joint's channel over all trials: RMS ``noise`` rad, ``count`` rad (0: not visible), RMS ``motion`` rad.

    ``noise`` is None where no recording shows it apart from the motion.
    """

    joint: str
    noise: float | None
    count: float
    motion: float

    def as_json(self) -> dict[str, Any]:
        """The entry under ``channels``."""
        found = {"noise": self.noise, "count": self.count, "motion": self.motion}
        told = {name: None if value is None else quantity(value, "deg") for name, value in found.items()}
        return {"joint": self.joint} | told


def describe_channels(
    joints: Sequence[str], recordings: Sequence[Recording], sensor: AngleSensor, *, noise_seen: bool = True
) -> tuple[Channel, ...]:
    """Noise, count and motion of every joint's channel; ``noise_seen`` : whether the sensor's was read from them."""
    made = []
    for j, name in enumerate(joints):
        parts = [np.std(r.smoothed.angle[:, j]) for r in recordings if j in r.free]
        motion = float(np.sqrt(np.mean(np.square(parts)))) if parts else 0.0
        noise, step = float(sensor.noise[j]), float(sensor.step[j])
        known = noise if noise_seen or j in sensor.known else None
        made.append(Channel(name, known, step if step > LEAST_COUNT_SHARE * noise else 0.0, motion))
    return tuple(made)


def channel_findings(
    leg: Leg, recordings: Sequence[Recording], sensor: AngleSensor, made: Sequence[Channel]
) -> list[Finding]:
    """Frozen channels in each recording; noise, counts and filters of all."""
    found = [f for recording in recordings for f in _frozen_findings(recording.leg or leg, recording, sensor)]
    for j, channel in enumerate(made):
        each = [held_finding(recording, j, channel.joint) for recording in recordings if j in recording.free]
        held = [finding for finding in each if finding is not None]
        found += held or _coarse_findings(channel)
        if channel.noise is not None:
            found += _filtered_findings(leg.joint_names[j], j, sensor)
    return found


def accuracy_findings(accuracy: float, made: Sequence[Channel]) -> list[Finding]:
    """A doubt on a required ``accuracy``, rad, that accepts nearly every leg, as one in radians for degrees does."""
    motion = max(channel.motion for channel in made)
    if accuracy <= LOOSE_SHARE * motion:
        return []
    text = f"an accuracy of {_degrees_text(accuracy)} is required, {accuracy / motion:.0%} of the motion (RMS "
    text += f"{_degrees_text(motion)}): gaps that most causes make are not judged"
    return [Finding("doubt", text, "state a smaller `accuracy`, or correct its unit")]


def _frozen_findings(leg: Leg, recording: Recording, sensor: AngleSensor) -> list[Finding]:
    """Runs of equal readings that begin or end while the joint moves, and channels that never change.

    ``leg`` : the recording's own, whose zeros and signs give the readings as the file has them.
    """
    found, joints, readings = [], leg.joint_names, leg.to_measured(recording.rotation)
    for j in recording.free:
        value, good = recording.rotation[:, j], recording.counts[:, j]
        if good.sum() > LONG_RUN and np.ptp(value[good]) == 0.0:
            others = [k for k in recording.free if k != j and np.ptp(recording.smoothed.angle[:, k]) > OTHER_MOTION]
            if others:
                text = f"reads {_degrees_text(readings[good, j][0])} from first to last sample while "
                text += f"{joints[others[0]]} moves: its channel is frozen, or the joint was held"
                remedy = "list the joint under `locked` if it was held, else leave the recording out"
                found.append(Finding("fault", text, remedy, recording.name, joints[j]))
            continue
        for first, last in _equal_runs(value, good):
            if _stops_while_moving(recording, j, first, last, max(_usual_change(value), float(sensor.noise[j]))):
                start, end = recording.time[first], recording.time[last]
                text = f"its reading stays at {_degrees_text(readings[first, j])} from {start:.3g} s to {end:.3g} s "
                text += "while the joint moves: the channel is frozen there"
                remedy = "empty these cells (an empty cell is a missing sample), or leave the recording out"
                found.append(Finding("fault", text, remedy, recording.name, joints[j]))
                break
    return found


def _usual_change(value: Array) -> float:
    """Median change between readings that differ: a count, the noise, or the motion."""
    change = np.abs(np.diff(value))
    return float(np.median(change[change > 0.0])) if np.any(change > 0.0) else 0.0


def _equal_runs(value: Array, good: Mask) -> list[tuple[int, int]]:
    """First and last indices of runs of at least ``LONG_RUN`` equal readings."""
    same = np.concatenate([[False], (np.diff(value) == 0.0) & good[1:] & good[:-1], [False]])
    edges = np.flatnonzero(np.diff(same.astype(int)))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a + 1 >= LONG_RUN]


def _stops_while_moving(recording: Recording, j: int, first: int, last: int, step: float) -> bool:
    """Whether the joint was moving at the start of a run, or has moved by its end."""
    time, value = recording.time, recording.rotation[:, j]
    fastest = float(np.percentile(np.abs(recording.smoothed.rate[:, j]), 98))  # not a single outlier
    back = max(first - LONG_RUN, 0)
    before = abs(value[first] - value[back]) / (time[first] - time[back]) if first > back else 0.0
    went = before * (time[min(last, first + 3 * LONG_RUN)] - time[first])  # any swing slows down later
    going = before > LEAST_SPEED_SHARE * fastest and went > JUMP_CHANGES * step and first - back >= LONG_RUN // 2
    jump = abs(value[last + 1] - value[last]) if last + 1 < len(value) else 0.0
    usual = fastest * (time[last] - time[max(last - 1, 0)])
    return bool(going and _keeps_its_pace(value, first)) or bool(jump > JUMP_CHANGES * step and jump > 2.0 * usual)


def _keeps_its_pace(value: Array, first: int) -> bool:
    """Whether readings kept changing at the same pace up to the run, so that the joint did not slow down."""
    near = np.abs(np.diff(value[max(first - LONG_RUN, 0) : first + 1]))
    half = len(near) // 2
    late, early = near[half:], near[:half]
    return half > 1 and float(np.mean(late > 0.0)) > 0.5 and float(late.mean()) > 0.5 * float(early.mean())


def _coarse_findings(channel: Channel) -> list[Finding]:
    noise = channel.noise or 0.0
    if channel.motion <= 0.0 or max(channel.count, noise) < COARSE_SHARE * channel.motion:
        return []
    if channel.count > noise:
        text = f"one count is {_degrees_text(channel.count)}, {channel.count / channel.motion:.0%} of the motion (RMS "
        text += f"{_degrees_text(channel.motion)})"
        remedy = "an encoder with more counts, or larger motion"
    else:
        text = f"the noise, {_degrees_text(noise)} RMS, is {noise / channel.motion:.0%} of the motion (RMS "
        text += f"{_degrees_text(channel.motion)})"
        remedy = "a quieter sensor, or larger motion"
    return [Finding("doubt", text + "; smaller effects are hidden", remedy, joint=channel.joint)]


def _filtered_findings(name: str, j: int, sensor: AngleSensor) -> list[Finding]:
    """Readings that agree far better with their neighbours than with a smooth motion, or noise as behind a filter."""
    words = filtered_words(j, sensor)
    return [Finding("note", words, REMEDY, joint=name)] if words else []


def _degrees_text(angle: float) -> str:
    return f"{np.degrees(angle):.3g} deg"
