"""Servos whose integral a fit cannot know."""

from __future__ import annotations

from collections.abc import Iterable

from synth.drives.servo import Servo
from synth.errors import Problem, UserError
from synth.files.trial_list import Trial
from synth.swing.leg_model import Leg


def require_no_integral(leg: Leg, trials: Iterable[Trial], path: str) -> None:
    """Refuse trials in which a servo with an integral acts.

    Its sum at a log's beginning holds the load there, which follows from the springs that are fitted, and where the leg
    moves it is anything; in the fit it would act as a free angle does. With the sum of the leg file's springs a spring
    of 0.8 N m/rad was fitted as 0.3 from a settled start, and a free angle of 6 deg as 51 from mid-motion.

    Raises
    ------
    UserError : naming the first such trial, at ``path``.
    """
    joints = [joint.name for joint in leg.joints if isinstance(joint.drive, Servo) and joint.drive.integral_gain]
    driven = [trial.name for trial in trials if trial.signals is not None]
    if not joints or not driven:
        return
    text = (
        f"the servo of {joints[0]} has an integral_gain and a command in {driven[0]}, which a fit cannot use: the sum "
        "with which a recording begins is not known and acts like a free angle. Fit trials with the drive off, and a "
        "leg file without it; `synth gap` estimates the sum of each trial"
    )
    raise UserError(Problem(text, path, key="trials"))
