"""Trials whose joints are read a moment apart, as two publishers of one robot log them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from synth.arrays import Array
from synth.diagnosis.angle_trials import angle_trial
from synth.diagnosis.check.clocks import clock_findings, describe_sampling
from synth.errors import UserError
from synth.files.recordings_together import check_together
from synth.files.trial_list import Trial
from synth.fit.estimate import fit_leg
from synth.fit.recordings import recordings
from synth.fit.sensor_noise import estimate_sensor
from synth.fit.uncertainty import sample_scatter
from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

NOISE = np.radians(0.05)
LEG = Leg(
    "two",
    (
        Joint("hip", Link(0.25, 0.6, 0.11, 4e-3), 0.4, 1, None, Spring(6.0, 0.5), Damper(0.08)),
        Joint("knee", Link(0.22, 0.35, 0.09, 2e-3), 2.0, -1, None, Spring(1.5, 1.8), Damper(0.015)),
    ),
)


def trial(apart: float, step: float = 0.005, seed: int = 1, seconds: float = 1.5) -> Trial:
    """A release: the knee is read ``apart`` s after the hip; 0: with it."""
    frames = np.arange(0.0, seconds, step)
    time = np.sort(np.r_[frames, frames + apart]) if apart else frames
    turn = np.random.default_rng(seed)
    rotation = simulate(LEG, LEG.rest + np.array([0.5, 0.7]) * turn.choice([-1.0, 1.0], 2), [0.0, 0.0], time)
    angles: Array = LEG.to_measured(rotation) + turn.normal(0.0, NOISE, rotation.shape)
    if apart:
        angles[1::2, 0] = angles[::2, 1] = np.nan
    return Trial(f"{seed}.csv", time, angles)


@pytest.mark.parametrize("apart", [1e-5, 1e-4])
def test_step_grid_and_noise_are_those_of_a_joints_own_samples(apart: float) -> None:
    (found,) = recordings(LEG, [trial(apart)])
    assert found.step == pytest.approx(0.005)
    assert len(found.smoothed.time) == 300
    assert found.n_lost == 0
    np.testing.assert_allclose(found.smoothed.noise, NOISE, rtol=0.3)
    np.testing.assert_allclose(estimate_sensor([found]).noise, NOISE, rtol=0.2)
    sampling = describe_sampling(LEG, found)
    assert sampling.step == pytest.approx(0.005)
    assert not clock_findings(LEG, [found], [sampling])


def test_a_joint_without_a_sample_has_no_scatter_and_no_warning() -> None:
    """Warnings of numpy reached the screen: Mean of empty slice."""
    plain = trial(0.0)
    held = np.column_stack([np.full(len(plain.time), plain.angles[0, 0]), plain.angles[:, 1]])
    scatter = sample_scatter(recordings(LEG, [replace(plain, angles=held, locked=("hip",))], ["knee"]))
    assert np.isnan(scatter[0])
    assert scatter[1] == pytest.approx(NOISE, rel=0.2)


@pytest.mark.parametrize("samples", [300, 150, 75])
def test_a_thinned_recording_keeps_samples_of_every_joint(samples: int) -> None:
    """Of every second row one joint had none: its rest was then the mean of nothing."""
    (found,) = recordings(LEG, [trial(1e-4)])
    thin = found.thinned(samples)
    np.testing.assert_array_equal(thin.counts.sum(axis=0), samples)


def test_many_samples_are_averaged_joint_by_joint() -> None:
    """All were taken for lost, as no group of rows has more than half of one joint."""
    (found,) = recordings(LEG, [trial(2e-5, step=1e-4)])
    assert found.averaged[0] == found.averaged[1] > 1
    assert found.moments.sum() == found.counts.sum() == len(found.time)
    assert f"groups of {found.averaged[0]} are averaged" in found.thinning
    np.testing.assert_allclose(found.smoothed.noise, NOISE / np.sqrt(found.averaged), rtol=0.3)


def test_a_fit_sees_no_external_torque_and_finds_the_springs() -> None:
    """150 ms were cut for a torque "at first" that the wrong start made, and it took sixty times as long."""
    found = fit_leg(LEG, recordings(LEG, [trial(1e-4, seed=seed) for seed in (1, 2)]))
    assert not found.cut
    assert not any("torque" in str(warning) for warning in found.warnings)
    for joint, name in zip(LEG.joints, LEG.joint_names, strict=True):
        assert joint.spring is not None
        assert found.joints[name].spring_rate.value == pytest.approx(joint.spring.rate, rel=0.03)


def test_a_recording_of_two_publishers_fits_others_of_one() -> None:
    """The rows are 10 us apart, 500 times as close as the others', whose time would be in another unit."""
    made = [trial(1e-5), trial(0.0, seed=2), trial(0.0, seed=3)]
    times, angles = [each.time for each in made], [each.angles for each in made]
    assert not check_together([each.name for each in made], times, angles, LEG.joint_names)
    with pytest.raises(UserError, match="samples"):
        recordings(LEG, [Trial("short.csv", made[0].time[:10], made[0].angles[:10])])


def test_the_trial_of_a_diagnosis_keeps_samples_of_every_joint() -> None:
    """Of every second row the knee had none: its latency had no response, and a check divided by 0."""
    (found,) = recordings(LEG, [trial(1e-4)])
    thin = angle_trial(found, held_out=False).thinner(75)
    np.testing.assert_array_equal(thin.counted, 75)
    assert len(thin.time) == 150
    np.testing.assert_array_equal(thin.piece(0, 75).thinner(19).counted, 19)
