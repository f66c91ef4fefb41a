"""The characteristics of a fit's trials: of driven ones, of ones that end in motion, of ones whose start is cut."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from synth.files.trial_list import Trial
from synth.fit.estimate import fit_leg
from synth.fit.fit_result import DRIVEN, FitResult
from synth.fit.recordings import recordings
from synth.fit.trial_fits import away_from_their_starts
from synth.motion.characteristics import CUT
from synth.motion.rest import FROM_LEG
from synth.swing.chain import Conditions, simulate
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

LINK = Link(0.2, 0.4, 0.1, 1.5e-3)
INERTIA, WEIGHT = 1.5e-3 + 0.4 * 0.1**2, 0.4 * 9.81 * 0.1
RATIO = 0.2  # about the hanging pose, where the spring is free
STIFFNESS = 1.2 + WEIGHT
RATE = 2 * RATIO * float(np.sqrt(STIFFNESS * INERTIA))
PERIOD = 2 * np.pi / (np.sqrt(STIFFNESS / INERTIA) * np.sqrt(1 - RATIO**2))
LEG = Leg("one link", (Joint("knee", LINK, spring=Spring(1.2, 0.0), damper=Damper(RATE)),))


def fitted(
    leg: Leg, starts: list[Any], times: Any, *, first_locked: tuple[str, ...] = (), torque: Any = None
) -> FitResult:
    """``starts`` rad, released at rest, with noise of 0.03 deg; in the first trial some joints are locked."""
    noise, trials = np.random.default_rng(0), []
    for k, start in enumerate(starts):
        locked = () if k else first_locked
        held = tuple(leg.joint_names.index(name) for name in locked)
        q = np.atleast_1d(np.asarray(start, dtype=float))
        moved = simulate(
            leg, q, np.zeros(len(q)), times, Conditions(held), known_torque=None if torque is None else (times, torque)
        )
        seen = leg.to_measured(moved) + np.radians(0.03) * noise.normal(size=moved.shape)
        trials.append(Trial(f"{k}.csv", times, seen, torques=torque, locked=locked))
    return fit_leg(leg, recordings(leg, trials, ()))


def test_a_short_recording_is_measured_about_the_fitted_equilibrium() -> None:
    """1.3 periods: a damping ratio of 0.307 and an overshoot of 0.63 were called valid; 0.2 and 0.527 are true."""
    found = fitted(LEG, [0.15, -0.12, 0.1], np.arange(0.0, 1.3 * PERIOD, 0.002))
    for trial in found.trials:
        seen = trial.characteristics["knee"]
        assert seen.damping_ratio == pytest.approx(RATIO, abs=0.01)
        assert seen.overshoot == pytest.approx(np.exp(-np.pi * RATIO / np.sqrt(1 - RATIO**2)), abs=0.01)
        assert seen.validity.endswith(FROM_LEG)


def test_the_equilibrium_of_a_trial_holds_its_locked_joints() -> None:
    """The knee's rest below a hip held at 40 deg: k (q - free) + m g c sin(0.7 + q) = 0."""
    leg = replace(LEG, joints=(replace(LEG.joints[0], name="hip"), LEG.joints[0]))
    found = fitted(leg, [[0.7, 0.6], [0.7, -0.7], [0.7, 0.3]], np.arange(0.0, 1.5, 0.004), first_locked=("hip",))
    from scipy.optimize import brentq

    rest = brentq(lambda q: 1.2 * q + WEIGHT * np.sin(0.7 + q), -1.0, 1.0)
    assert found.trials[0].motion.equilibrium[0] == pytest.approx(rest, abs=np.radians(0.1))


def test_what_needs_the_start_is_not_measured_after_a_cut() -> None:
    found = replace(fitted(LEG, [0.4, -0.3], np.arange(0.0, 1.5, 0.004)), cut=0.1)
    for trial in found.trials:
        seen = trial.characteristics["knee"]
        assert (seen.rise_time, seen.overshoot, seen.settling_time) == (None,) * 3
        assert seen.damping_ratio is not None
        assert seen.validity.endswith(CUT)
        assert trial.as_json(("knee",))["start_cut"] is True


def test_a_driven_recording_is_no_release() -> None:
    times = np.arange(0.0, 1.5, 0.005)
    found = fitted(LEG, [0.5, -0.4], times, torque=0.3 * np.sin(2 * np.pi * times)[:, None])
    written = found.trials[0].as_json(("knee",))
    assert written["driven_by"] == ["a known torque"]
    assert written["damping_ratio_validity"] == {"knee": DRIVEN}
    assert (written["rise_time"], written["damping_ratio"], written["overshoot"]) == ({}, {}, {})


def test_a_start_away_from_the_samples_is_a_hand_s_only_in_recordings() -> None:
    """Of a wanted motion it was said too, where the chosen damper's curve moved the start."""
    found = fitted(LEG, [0.15, -0.12], np.arange(0.0, 3.0 * PERIOD, 0.002))
    first = found.trials[0]
    moved = replace(first, start=replace(first.start, angle=first.start.angle + 0.1))
    trials = (moved, *found.trials[1:])
    (recorded,) = away_from_their_starts(found.leg, trials)
    assert "in 1 of 2 trials" in recorded
    assert "a hand, a muscle or a latch" in recorded
    (wanted,) = away_from_their_starts(found.leg, trials, follower="the robot's leg")
    assert "muscle" not in wanted
    assert wanted.startswith("release: the robot's leg goes on most alike in 1 of 2 trials if it does not start alike")
