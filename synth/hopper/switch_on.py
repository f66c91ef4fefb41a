"""When the motors of a recorded jump are switched on, on the recording's own clock.

From the winding's current, which jumps within a millisecond, else from the ground force, else from the angle: the last
sample at rest before the push. The push is where the signal first passes a level that rest does not reach. From the
angle alone the onset is where the root of the angle that the leg has opened by, fitted by a line, is zero: under a
constant torque that angle grows with time squared.

A clock that begins at the switch-on is not changed: an onset within ``LATE`` after time 0 may be the winding's or the
gear's, which a diagnosis looks for.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.hopper_recordings import HopperRecording
from synth.files.log_clock import begins_at
from synth.noise import difference_scale, robust_deviation

PUSHED = 1.2  # weights of ground force that only a push gives: a leg at rest has one
DRAWN, TURNED = 0.5, 0.5  # of the largest current and of the angle that the leg opens by: in the push for certain
RISEN = {"current": 0.05, "ground force": 0.1}  # of the largest current and of the weight: no longer at rest
# A tenth of the opening takes 0.43 to 0.46 of the time of half of it from rest (four designs), 0.2 at a constant speed.
EARLY = (0.1, 0.35)
BEGUN = {"current": 0.2, "ground force": 1.5}  # likewise, beyond which a first sample is in the push, not at rest
OPENING = (0.03, 0.3)  # of the angle that the leg opens by, between which its root is a line (16 motors and lengths)
ANGLE_ERROR = 2e-3  # s, of an onset from an angle; 2.5 ms at worst with 0.1 deg of noise at 1 kHz (the same 16)
LATE = 3e-3  # s after time 0, within which the clock counts as the switch-on's; ten times the winding's time constant
LATE_ANGLE = 5e-3  # s, likewise, of an onset from an angle


@dataclass(frozen=True)
class SwitchOn:
    """The switch-on: ``time`` s on the recording's clock, 0 where that clock holds; ``deviation`` s, how far it is off.

    ``source`` : the column that shows it; empty where the clock holds; ``begins`` s, the file's own time at time 0.
    """

    time: float
    deviation: float
    source: str
    begins: float = 0.0

    def sentence(self, name: str) -> str:
        """Where the switch-on was found, for the user; empty where the clock holds."""
        if not self.source:
            return ""
        whence = f" ({begins_at(self.begins)})" if self.begins else ""
        return (
            f"{name}: its time does not begin when the motors are switched on; the {self.source} shows that at "
            f"{self.time:.4g} s{whence}, and time is counted from there"
        )


def from_switch_on(jump: HopperRecording, weight: float) -> tuple[HopperRecording, SwitchOn]:
    """The recording with time counted from the switch-on and without the rest before, and the switch-on.

    Parameters
    ----------
    jump : with ``time`` and ``upper link``, and where recorded ``ground force`` and ``current``; at rest before the
        push.
    weight : N, of the leg.

    Raises
    ------
    UserError : time does not begin at the switch-on, and the recording begins in the push.
    """
    time = jump["time"]
    found = _from_angle(jump) if _first_sharp(jump, weight) is None else _from_sharp(jump, weight)
    step = float(np.median(np.diff(time)))
    begin = found.time if found.source else 0.0
    kept = time >= begin - 0.5 * step
    return HopperRecording(jump.name, {name: values[kept] - (begin if name == "time" else 0.0)
                                       for name, values in jump.columns.items()}, jump.length), found  # fmt: skip


def _first_sharp(jump: HopperRecording, weight: float) -> str | None:
    """The column with a sharp onset: current before force, if the push shows in it."""
    if "current" in jump.columns and float(np.ptp(jump["current"])) > 0.0:
        return "current"
    return "ground force" if "ground force" in jump.columns and jump["ground force"].max() > PUSHED * weight else None


def push_level(force: Array, weight: float) -> float:
    """Ground force that only the push and a landing reach, N: over the weight and its noise, below half the peak."""
    return min(max(PUSHED * weight, weight + 5.0 * noise_of(force)), 0.5 * (weight + float(force.max())))


def push_begins(force: Array, weight: float) -> int:
    """First sample of the push: above ``push_level`` in two samples running, which noise is not."""
    return _first_above(force, push_level(force, weight))


def _first_above(values: Array, level: float) -> int:
    """First of two samples running above a level; if there are none, the first one above it."""
    above = values > level
    twice = above[:-1] & above[1:]
    return int(np.argmax(twice if twice.any() else above))


def noise_of(values: Array) -> float:
    """Standard deviation of the white noise of a column (n,), in its unit; 0 for one that is too short to show it.

    Of third differences about their median, which on a curve with few samples is not zero.
    """
    third = np.diff(values, 3)
    return robust_deviation(third - np.median(third)) / difference_scale(3) if len(third) > 8 else 0.0


def _from_sharp(jump: HopperRecording, weight: float) -> SwitchOn:
    """From the current or the force: the last sample at rest."""
    source = _first_sharp(jump, weight)
    assert source is not None
    time, values = jump["time"], jump[source]
    if source == "current":
        scale = float(values.max())
        within = _first_above(values, DRAWN * scale)
    else:
        scale, within = weight, push_begins(values, weight)
    level = float(np.median(values[: max(1, within // 2)]))
    noise = noise_of(values[: within // 2])
    moved = np.abs(values[:within] - level) > max(5.0 * noise, RISEN[source] * scale)
    still = np.flatnonzero(~moved)
    last = int(still[-1]) if len(still) else 0
    step = float(np.median(np.diff(time)))
    if not jump.begins and -step <= time[last] <= max(LATE, step):
        return SwitchOn(0.0, 0.0, "")
    _refuse_begun(jump, begun=level > BEGUN[source] * scale, source=source)
    # It lies between the last sample at rest and the next: uniform, root mean square about the former.
    return SwitchOn(float(time[last]), float(time[last + 1] - time[last]) / np.sqrt(3.0), source, jump.begins)


def _from_angle(jump: HopperRecording) -> SwitchOn:
    """From the upper link alone, which opens: its angle falls."""
    time, angle = jump["time"], jump["upper link"]
    begun = not jump.begins and -float(np.median(np.diff(time))) <= time[0] <= LATE_ANGLE
    half = int(np.argmax(angle[0] - angle > TURNED * float(angle[0] - angle.min())))
    # A quarter of that time: the leg has opened by a thirtieth.
    level = float(np.median(angle[: max(1, half // 4)]))
    opened = level - angle
    if opened.max() <= 0.0:
        return SwitchOn(0.0, 0.0, "")
    least, most = (share * float(opened.max()) for share in OPENING)
    first = int(np.argmax(opened > TURNED * opened.max()))
    at_rest = np.flatnonzero(opened[:first] < least)
    used = np.arange(int(at_rest[-1]) + 1 if len(at_rest) else 0, first)
    used = used[(opened[used] > least) & (opened[used] < most)]
    if len(used) < 3 and begun:
        return SwitchOn(0.0, 0.0, "")
    _refuse_begun(jump, begun=len(used) < 3, source="upper link")
    slope, offset = np.polyfit(time[used] - time[used[0]], np.sqrt(opened[used]), 1)
    onset = float(time[used[0]] - offset / slope)
    if (not jump.begins and abs(onset) <= LATE_ANGLE) or (begun and onset < time[0]):
        return SwitchOn(0.0, 0.0, "")
    tenth = time[int(np.argmax(opened > EARLY[0] * opened.max()))] - time[0]
    _refuse_begun(jump, begun=tenth < EARLY[1] * (time[first] - time[0]), source="upper link")
    return SwitchOn(max(onset, float(time[0])), ANGLE_ERROR, "upper link", jump.begins)


def _refuse_begun(jump: HopperRecording, *, begun: bool, source: str) -> None:
    if begun:
        begin = jump.begins + float(jump["time"][0])
        text = f"begins at {begin:.{16 if jump.begins else 4}g} s, in the push: neither its clock nor a rest before it "
        text += "shows when the motors are switched on. Let time 0 be the switch-on, or record a few samples at "
        text += "rest before it"
        raise UserError(Problem(text, jump.name, key=source))
