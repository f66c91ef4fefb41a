"""A trial's channels beside its angles, on the clock of its recording.

A recording counts its time from its first angle, which in a thinned one is the middle of the first group of samples.
``counted_from`` moves the clock of a whole trial, so that no channel can be left on another one: half a group early, a
recorded velocity made a weak-form damper rate 40 to 60 % too low.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from synth.arrays import Array, Mask
from synth.drives.servo import ServoSignals
from synth.errors import Problem, UserError
from synth.motion.smoothing import Smoothed
from synth.motion.velocity import unlike, with_velocities
from synth.swing.known_torque import with_least_spacing
from synth.swing.leg_model import Leg
from synth.swing.time_unit import time_unit

if TYPE_CHECKING:
    from synth.files.trial_list import Trial


def rows_read(trial: Trial) -> Mask:
    """(m,) rows that are samples of the motion, not only of a known torque or a command with clocks of their own.

    Every second row may be a command alone: differences of angles over it would show no noise, and thinning by every
    second row no angle.
    """
    if trial.torques is None and trial.signals is None:
        return np.ones(len(trial.time), dtype=bool)
    return np.asarray(np.isfinite(trial.angles).any(axis=1))


def counted_from(trial: Trial, origin: float) -> Trial:
    """The trial with the time of all its channels counted from ``origin``, s on its present clock."""
    signals = None if trial.signals is None else trial.signals.later(origin)
    return replace(trial, time=trial.time - origin, signals=signals)


def with_recorded_rates(leg: Leg, trial: Trial, smoothed: Smoothed) -> Smoothed:
    """The smoothed motion with recorded velocities if available, which must match the angles.

    ``trial`` : on the clock of ``smoothed``, see ``counted_from``.

    Raises
    ------
    UserError : a velocity column is not the slope of its joint's angle.
    """
    if trial.velocities is None:
        return smoothed
    read = rows_read(trial)
    time, velocities = trial.time[read], leg.sign * trial.velocities[read]
    problems = []
    for j, name in enumerate(leg.joint_names):
        wrong = unlike(smoothed, time, velocities[:, j], j) if name not in trial.locked else ""
        if wrong:
            stop = "" if wrong.endswith("?") else "."
            text = f"{wrong}{stop} Correct the column, or leave it out: the angles suffice"
            problems.append(Problem(text, file=trial.name, key=f"{name} velocity"))
    if problems:
        raise UserError(problems)
    return with_velocities(smoothed, time, velocities)


def known_torque(leg: Leg, trial: Trial, end: float, pace: float) -> tuple[Array, Array] | None:
    """Times (m,) s and torques on q (m, n) N m up to ``end`` s of a motion of ``pace`` s; None if none is known."""
    if trial.torques is None:
        return None
    return with_least_spacing(trial.time, np.ascontiguousarray(leg.sign * trial.torques), end, time_unit(pace))


def servo_signals(leg: Leg, trial: Trial) -> ServoSignals | None:
    """Inputs of the servos, commands on q; None without any."""
    given = trial.signals
    return None if given is None else replace(given, command=leg.to_rotation(given.command))
