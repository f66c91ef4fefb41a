"""A joint has its own time scale: what is long for a fast ankle is short for a slow hip."""

from __future__ import annotations

import numpy as np
import pytest

from diagnosis.simulated_releases import with_effects
from synth.diagnosis.angle_trials import angle_trial
from synth.diagnosis.plants.swinging_chain.chain_candidates import natural_sizes_of
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose
from synth.files.tolerance import Tolerance
from synth.files.trial_list import Trial
from synth.fit.recordings import recordings
from synth.pace import paces
from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

# A heavy thigh of about 1 Hz, and a light, stiff foot of about 15 Hz.
THIGH = Joint("hip", Link(0.3, 2.0, 0.15, 0.02), spring=Spring(2.0, 0.1), damper=Damper(0.15))
FOOT = Joint("ankle", Link(0.1, 0.05, 0.05, 5e-5), spring=Spring(2.0, -0.2), damper=Damper(1.5e-3))
LEG = Leg("slow and fast", (THIGH, FOOT))
LATE = 0.05  # s: a period of the foot is 0.07 s


def test_a_slow_joint_is_read_late_by_most_of_a_fast_joints_period() -> None:
    time, random, trials = np.linspace(0.0, 2.0, 801), np.random.default_rng(2), []
    late = with_effects(LEG, {"hip": {"latency": {"delay": LATE}}})
    for number, start in enumerate(((0.7, 0.5), (-0.6, 0.4), (0.5, -0.7), (-0.4, -0.6))):
        motion = late.to_measured(simulate(LEG, start, (0.0, 0.0), time, tolerance=1e-8))
        begun = time < LATE
        read = motion.copy()
        read[:, 0] = np.where(begun, motion[0, 0], np.interp(time - LATE, time, motion[:, 0]))
        noisy = read + np.radians(0.02) * random.standard_normal(read.shape)
        trials.append(Trial(f"{number}.csv", time, noisy, held_out=number == 3))
    (given,) = recordings(LEG, trials[:1], ())
    slow, fast = paces(time[1], given.smoothed.angle)
    assert slow > 5.0 * fast
    result = diagnose(LEG, trials, Tolerance())
    assert result.verdict in ("effect", "tie")
    first = result.ranked[0].cause
    assert (first.effect, first.joint) == ("latency", "hip")
    assert abs(first.parameters["delay"].value - LATE) < 0.005


def test_a_recording_that_stands_still_tells_no_pace() -> None:
    """Half a degree of a drive's jitter at 30 Hz, whose pace is a twentieth of the swing's, would bound delays."""
    pendulum = Leg("pendulum", (THIGH,))
    time = np.linspace(0.0, 2.0, 801)
    swung = pendulum.to_measured(simulate(pendulum, (0.7,), (0.0,), time, tolerance=1e-8))
    still = np.radians(0.5) * np.sin(2.0 * np.pi * 30.0 * time)[:, None]
    times = []
    for readings in ((swung,), (swung, still)):
        made = recordings(pendulum, [Trial(f"{n}.csv", time, r) for n, r in enumerate(readings)], ())
        times.append(natural_sizes_of(pendulum, [angle_trial(recording, held_out=False) for recording in made]).time[0])
    assert times[1] == times[0]
    assert times[0] == pytest.approx(1.0 / 8.0, rel=0.3)  # s, from its largest frequency
