"""Whole turns of a command whose joint turned past the end of its angle's range.

The angle's column is unwrapped, and shifted to the leg file's convention. Its command either counts on, and then is
shifted as a whole; or it wraps as the angle did, and then each command has the turn to which the joint goes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array

TURN = 360.0  # deg, the unit of commands in a trial
STEP = 90.0  # deg; a longer change of a command, whole turns aside, begins a new one
REACHED_WITHIN = 90.0  # deg from the command: the joint went there, and to no other turn of it
TIMES_SHOWN = 4  # times in a note


@dataclass(frozen=True, eq=False)
class TurnedAngle:
    """A joint's angle whose whole turns were changed: ``raw`` and ``cleaned`` (n,) deg at ``time`` (n,) s, known."""

    time: Array
    raw: Array
    cleaned: Array


def same_turn(name: str, time: Array, value: Array, joint: TurnedAngle, notes: list[str]) -> Array:
    """The command (m,) deg in the turns of the cleaned angle; notes tell what was changed.

    Parameters
    ----------
    name : of the command, in notes.
    time, value : (m,) s and deg in the measured sense, nan where missing; a command holds until the next.
    """
    known = np.flatnonzero(np.isfinite(value))
    if not len(known):
        return value
    given, start = value[known], time[known]
    result = value.copy()
    whole = given + TURN * float(np.round(np.median(np.interp(start, joint.time, joint.cleaned) - given) / TURN))
    wrapped = _as_wrapped(given, start, joint)
    if wrapped is not None:
        turns, ends, away = wrapped
        near = np.abs(np.interp(start, joint.time, joint.cleaned) - turns) < REACHED_WITHIN
        if (near & (np.abs(turns - whole) > TURN / 2)).any():  # the joint shows that a shift as a whole is wrong
            result[known] = turns
            moved = np.flatnonzero(np.abs(np.diff(turns - given, prepend=0.0)) > 1.0)
            notes.append(f"{name}: wraps with the angle; unwrapped at {_times(start[moved])}")
            doubtful = np.flatnonzero(np.abs(away) >= REACHED_WITHIN)
            if len(doubtful):
                begins = np.concatenate([[0], ends[:-1] + 1])[doubtful]
                notes.append(
                    f"{name}: its turn is not certain from {_times(start[begins])}: the joint did not get there"
                )
            return result
    result[known] = whole
    shift = float(whole[0] - given[0])
    if shift:
        notes.append(f"{name}: shifted by {shift:+.0f} deg with the angle")
    return result


def _as_wrapped(given: Array, start: Array, joint: TurnedAngle) -> tuple[Array, NDArray[np.intp], Array] | None:
    """The commands (m,) in the turns to which the joint goes; the last of each; the joint's angle less these.

    None if the angle's column does not wrap, or the command leaves the range in which it does.
    """
    step = np.diff(joint.raw)
    jumps = np.flatnonzero(np.abs(step - np.diff(joint.cleaned)) > 1.0)
    if not len(jumps):
        return None
    middle = float(np.median((joint.raw[jumps] + joint.raw[jumps + 1]) / 2.0))
    ordinary = float(np.abs(np.diff(joint.cleaned))[jumps].max())  # the range is known to a step over its end
    if (np.abs(given - middle) > TURN / 2 + ordinary).any():
        return None
    smooth = np.unwrap(given, period=TURN)
    ends = np.append(np.flatnonzero(np.abs(np.diff(smooth)) > STEP), len(given) - 1)
    until = np.append(start[ends[:-1] + 1], joint.time[-1])
    reached = np.interp(until, joint.time, joint.cleaned)
    turns = TURN * np.round((reached - smooth[ends]) / TURN)
    count = np.diff(np.concatenate([[-1], ends]))
    return smooth + np.repeat(turns, count), ends, reached - smooth[ends] - turns


def _times(times: Array) -> str:
    shown = ", ".join(f"{time:.3f}" for time in times[:TIMES_SHOWN])
    return f"{shown}{' and later' if len(times) > TIMES_SHOWN else ''} s"
