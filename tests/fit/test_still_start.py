"""Recordings that begin before the release are cut to it or left out; free motion is kept."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fit.simulated_legs import bare, robot
from motion.driven_releases import free_motion
from robustness.random_legs import random_case
from synth.files.trial_list import Trial
from synth.fit.estimate import fit_leg
from synth.fit.recordings import Recording, recordings
from synth.fit.still_start import from_release
from synth.swing.leg_model import Leg
from synth.swing.mechanics import outboard_inertia, rest_pose

Array = NDArray[np.float64]
RELEASED = 0.24  # s


def overdamped() -> Leg:
    """The robot's links, the hip with twice its critical damping."""
    inertia = outboard_inertia(robot())
    rate = inertia * (2 * np.pi * np.array([1.5, 2.2, 3.0])) ** 2
    return robot(rate, 2 * np.array([2.0, 0.4, 0.3]) * np.sqrt(rate * inertia))


def held_then_released(leg: Leg, seed: int) -> Trial:
    """At 250 Hz with 0.35 deg of noise, as a video of 0.6 px shows it."""
    start = rest_pose(leg) + np.radians([20.0, -25.0, 15.0])
    time = np.arange(0, 1.6, 1 / 250)
    rotation = np.tile(start, (len(time), 1))
    after = time > RELEASED
    rotation[after] = free_motion(leg, start, time[after] - RELEASED, 0.0)
    noise = np.random.default_rng(seed).normal(0.0, np.radians(0.35), rotation.shape)
    return Trial("held.csv", time, leg.to_measured(rotation) + noise)


def made(trials: list[Trial]) -> list[Recording]:
    return recordings(bare(robot()), trials)


def test_a_start_at_rest_is_cut_and_the_interval_contains_the_truth() -> None:
    leg, held = overdamped(), 0
    for seed in range(3):
        begun = from_release(bare(leg), made([held_then_released(leg, seed)]))
        assert "is at rest at first" in begun.messages[0]
        length = 1.6 - float(begun.recordings[0].time[-1])
        assert RELEASED - 0.004 < length < RELEASED + 0.02
        fitted = fit_leg(bare(leg), begun.recordings)
        for joint, truth in zip(fitted.joints.values(), leg.spring_rate, strict=True):
            low, high = joint.spring_rate.low, joint.spring_rate.high
            assert low is not None
            assert high is not None
            held += low <= truth <= high
    assert held >= 7  # of nine 90 % intervals; fewer one time in twenty


def test_a_recording_too_short_after_release_is_dropped_unless_it_is_the_only_one() -> None:
    leg = overdamped()
    whole = held_then_released(leg, 0)
    short = replace(whole, name="short.csv", time=whole.time[:88], angles=whole.angles[:88])
    begun = from_release(bare(leg), made([whole, short]))
    assert [recording.name for recording in begun.recordings] == ["held.csv"]
    assert "short.csv" in begun.messages[1]
    assert "is left out" in begun.messages[1]
    alone = from_release(bare(leg), made([short]))
    assert len(alone.recordings) == 1
    assert "no other remains" in alone.messages[0]


def test_free_motion_is_not_cut() -> None:
    """Swings that die down and rise again, beats among them: none lies still at first."""
    for seed in (20, 65, 83, 121):
        case = random_case(seed)
        free = recordings(case.bare, case.trials)
        begun = from_release(case.bare, free)
        assert begun.messages == ()
        assert begun.recordings == free


def series(rate: float, length: float, turned: float, seed: int) -> list[Recording]:
    """Four releases held for 0.15 s, ``length`` s at ``rate`` Hz, of ``turned`` deg, noise of 0.35 deg that lasts."""
    leg = overdamped()
    generator, trials = np.random.default_rng(seed), []
    for number in range(4):
        start = rest_pose(leg) + np.radians(turned * generator.uniform(0.7, 1.3, 3)) * generator.choice((-1.0, 1.0), 3)
        time = np.arange(0.0, length, 1.0 / rate)
        rotation, after = np.tile(start, (len(time), 1)), time > 0.15
        rotation[after] = free_motion(leg, start, time[after] - 0.15, 0.0)
        noise = generator.normal(0.0, np.radians(0.35), rotation.shape)
        noise[1:] *= np.sqrt(1.0 - 0.3**2)
        for i in range(1, len(noise)):
            noise[i] += 0.3 * noise[i - 1]
        trials.append(Trial(f"t{number}.csv", time, leg.to_measured(rotation) + noise))
    return made(trials)


def test_of_a_series_that_begins_at_rest_no_recording_keeps_its_rest() -> None:
    """One whose break is not certain by itself was kept with it, beside others that were cut."""
    releases = series(100.0, 1.0, 11.0, 10)
    begun = from_release(bare(overdamped()), releases)
    assert [recording.time[-1] < 0.87 for recording in begun.recordings] == [True] * 4
    assert len(begun.messages) == 4


def test_a_low_rate_is_no_reason_to_leave_a_release_out() -> None:
    """With fewer than 30 samples after it the recordings that were sure went, and one with its rest stayed."""
    releases = series(50.0, 0.7, 35.0, 8)
    begun = from_release(bare(overdamped()), releases)
    assert len(begun.recordings) == 4
    assert all(len(recording.time) < 30 for recording in begun.recordings)
