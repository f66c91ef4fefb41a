"""Slips of a servo's columns: commands counted from elsewhere, exchanged with the angles, an inverted switch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from synth.drives.servo import Servo
from synth.swing.leg_model import Leg

if TYPE_CHECKING:
    from synth.files.trial_list import Trial

# rad: a horn two of its 25 teeth off is 29 deg; such a shift is a cause, ``encoder_offset``, and no slip of the files.
LEAST_SHIFT = float(np.radians(30.0))


@dataclass(frozen=True)
class InputChange:
    """The columns of a joint that a servo drives, changed in one ``way``; see ``column_changes.Change``."""

    joint: int
    way: Literal["counted", "exchanged", "switch"]
    text: str
    remedy: str
    either: tuple[str, str] | None = None
    scale: float = 1.0
    must_follow: bool = True

    def of_leg(self, leg: Leg) -> Leg:
        """The leg file is not concerned."""
        return leg

    def of(self, leg: Leg, trial: Trial) -> Trial:
        """With the columns changed; the same trial where it has no such columns."""
        signals, j = trial.signals, self.joint
        if signals is None or leg.joint_names[j] in trial.drive_off:
            return trial
        if self.way == "switch":
            enabled = signals.enabled.copy()
            enabled[:, j] = 1.0 - enabled[:, j]
            return replace(trial, signals=replace(signals, enabled=enabled))
        command, angles = signals.command.copy(), trial.angles.copy()
        if self.way == "counted":
            command[:, j] += _shift(trial, j)
            return replace(trial, signals=replace(signals, command=command))
        read = np.isfinite(angles[:, j])
        command[:, j] = np.interp(signals.time, trial.time[read], angles[read, j])
        angles[read, j] = np.interp(trial.time[read], signals.time, signals.command[:, j])
        return replace(trial, angles=angles, velocities=None, signals=replace(signals, command=command))


def _shift(trial: Trial, j: int) -> float:
    """Rad by which the angles lie above the commands while the drive is on, the median; 0 of one that is small."""
    signals = trial.signals
    if signals is None:
        return 0.0
    on = np.interp(trial.time, signals.time, signals.enabled[:, j]) > 0.5  # between off, 0, and on, 1
    away = trial.angles[:, j] - np.interp(trial.time, signals.time, signals.command[:, j])
    away = away[on & np.isfinite(away)]
    shift = float(np.median(away)) if len(away) else 0.0
    return shift if abs(shift) > LEAST_SHIFT else 0.0


def input_changes(leg: Leg, trials: Sequence[Trial]) -> list[InputChange]:
    """Of each joint that a servo drives in some trial."""
    made = []
    for j, joint in enumerate(leg.joints):
        given = [trial for trial in trials if trial.signals is not None and joint.name not in trial.drive_off]
        if not isinstance(joint.drive, Servo) or not given:
            continue
        name, command = joint.name, f"{joint.name} command"
        shifts = [shift for shift in (_shift(trial, j) for trial in given) if shift]
        if not joint.drive.open_duty and shifts:
            by = f"{abs(np.degrees(np.median(shifts))):.0f} deg {'above' if np.median(shifts) > 0.0 else 'below'}"
            text = f"the column {command} is counted from elsewhere: {name} lies {by} it in the middle"
            made.append(InputChange(j, "counted", text, f"count both from one zero, in {command} or in {name}"))
        if not joint.drive.open_duty:
            text = f"the columns {name} and {command} look exchanged"
            made.append(InputChange(j, "exchanged", text, "exchange the two names in its header"))
        if any(trial.signals is not None and (trial.signals.enabled[:, j] < 1.0).any() for trial in given):
            text = f"the column {name} enabled looks inverted"
            made.append(InputChange(j, "switch", text, "write 1 where the drive is on, 0 where it is off"))
    return made
