"""The ranges of deflection, speed and load in the trials, joint by joint."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from synth.diagnosis.check.finding import Finding
from synth.diagnosis.plants.swinging_chain.leg_torques import bearing_forces
from synth.drives.servo import TorqueDrive
from synth.fit.recordings import Recording
from synth.swing.leg_model import Leg
from synth.units import quantity, significant

if TYPE_CHECKING:
    from synth.files.trial_list import Trial

# Ratio of greatest to least below which a quantity counts as constant: effects that depend on it and effects that do
# not then differ by no more than tolerances do.
CONSTANT_RATIO = 1.5
ONE_SIDED_SHARE = 0.1  # share of the range beyond the free angle for a joint to count as moving on both sides
MOVING_SHARE = 0.1  # of the top speed, at the end of a recording
END_SHARE = 0.1  # of a recording, its end
LOAD_PERCENTILES = (5.0, 95.0)  # percentiles of a load's range: the extremes are noise


@dataclass(frozen=True)
class Coverage:
    """Ranges of one joint over the trials in which it is free.

    ``deflection`` rad, range from the spring's free angle (without a spring: from the middle);
    ``speeds`` rad/s, top speed of the slowest and of the fastest trial; ``load`` N of the bearing, 5 to 95 %;
    ``sides`` : trials that begin below and above the joint's final angle.
    """

    joint: str
    deflection: tuple[float, float]
    speeds: tuple[float, float]
    load: tuple[float, float]
    sides: tuple[int, int]

    def as_json(self) -> dict[str, Any]:
        """The entry under ``coverage``."""
        return {
            "joint": self.joint,
            "deflection": [quantity(value, "deg") for value in self.deflection],
            "greatest_speed": [quantity(value, "deg/s") for value in self.speeds],
            "bearing_force": [quantity(value, "N") for value in self.load],
            "released_below": self.sides[0],
            "released_above": self.sides[1],
        }


def describe_coverage(leg: Leg, recordings: Sequence[Recording]) -> tuple[Coverage, ...]:
    """Coverage of each joint that is free in some trial."""
    loads = [bearing_forces(r.leg or leg, r.smoothed, r.conditions) for r in recordings]
    made = []
    for j, joint in enumerate(leg.joints):
        free = [(r, load[:, j]) for r, load in zip(recordings, loads, strict=True) if j in r.free]
        if not free:
            continue
        angle = np.concatenate([r.smoothed.angle[:, j] for r, _ in free])
        sprung = joint.spring is not None and joint.spring.rate > 0.0
        zero = joint.rest if sprung else 0.5 * float(angle.min() + angle.max())
        # 98 %: not a single outlier.
        fastest = [float(np.percentile(np.abs(r.smoothed.rate[:, j]), 98)) for r, _ in free]
        force = np.concatenate([load for _, load in free])
        low, high = np.percentile(force, LOAD_PERCENTILES)
        starts = np.array([r.smoothed.angle[0, j] - r.smoothed.angle[-1, j] for r, _ in free])
        sides = (int(np.sum(starts < 0.0)), int(np.sum(starts > 0.0)))
        made.append(
            Coverage(
                joint.name,
                (float(angle.min() - zero), float(angle.max() - zero)),
                (min(fastest), max(fastest)),
                (float(low), float(high)),
                sides,
            )
        )
    return tuple(made)


def coverage_findings(leg: Leg, recordings: Sequence[Recording], made: Sequence[Coverage]) -> list[Finding]:
    """Effects that the ranges cannot separate, and the trial that would."""
    found = []
    for one in made:
        joint = leg.joints[leg.joint_names.index(one.joint)]
        if joint.spring is not None and joint.spring.rate > 0.0:
            found += _one_sided_findings(one)
        found += _load_findings(one) + _speed_findings(one)
    found += _cut_short_findings(recordings)
    return found


def _one_sided_findings(one: Coverage) -> list[Finding]:
    low, high = one.deflection
    room = ONE_SIDED_SHARE * (high - low)
    if low < -room and high > room:
        return []
    text = f"stays on one side of its spring's free angle ({np.degrees(low):.3g} to {np.degrees(high):.3g} deg from "
    text += "it): a one-sided spring and a spring of another rate look alike"
    return [
        Finding(
            "note", text, "a trial that swings through the free angle, by a tilt or from the other side", "", one.joint
        )
    ]


def _load_findings(one: Coverage) -> list[Finding]:
    low, high = one.load
    if high <= 0.0 or high > CONSTANT_RATIO * low:
        return []
    text = f"its bearing carries {low:.3g} to {high:.3g} N throughout: load-dependent and constant "
    text += "friction look alike"
    return [Finding("note", text, "trials with a tip mass, or faster ones", "", one.joint)]


def _speed_findings(one: Coverage) -> list[Finding]:
    low, high = one.speeds
    if high > CONSTANT_RATIO * low:
        return []
    speeds = " to ".join(significant(np.degrees(each), 3) for each in (low, high))
    text = f"all trials reach about the same speed ({speeds} deg/s): another "
    text += "damper rate and a nonlinear damper are hard to distinguish"
    return [Finding("note", text, "one motion a third as large, and one as large as the joint allows", "", one.joint)]


def _cut_short_findings(recordings: Sequence[Recording]) -> list[Finding]:
    """Free recordings that end before the leg comes to rest."""
    moving = []
    for recording in recordings:
        if recording.driven or not recording.free:
            continue
        rate = np.abs(recording.smoothed.rate[:, recording.free])
        last = max(int(END_SHARE * len(rate)), 1)
        if rate[-last:].max() > MOVING_SHARE * rate.max():
            moving.append(recording.name)
    if not moving:
        return []
    more = f" and {len(moving) - 1} more" if len(moving) > 1 else ""
    text = "ends while the leg still moves: its rest position distinguishes dry friction from a shifted spring"
    return [Finding("note", text, "record until the leg is at rest", moving[0] + more)]


def torque_findings(leg: Leg, trials: Sequence[Trial]) -> list[Finding]:
    """Trials in which no torque acts on a joint that a known one drives in others: its column may have been forgotten.

    Only joints of which nothing but the column says that they are driven; of those with a ``drive`` the warnings tell.
    """
    found = []
    for j, joint in enumerate(leg.joints):
        driven = [trial.torques is not None and bool(np.any(trial.torques[:, j] != 0.0)) for trial in trials]
        if isinstance(joint.drive, TorqueDrive) or not any(driven):
            continue
        free = [t.name for t, acts in zip(trials, driven, strict=True) if not acts and joint.name not in t.locked]
        text = f"no torque acts on {joint.name} here, as it does in other recordings: taken as free"
        found += [Finding("note", text, recording=name, joint=joint.name) for name in free]
    return found
