"""The weak form: exact to its discretisation error; gaps, damper curves and known torques."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fit.simulated_legs import DAMPER, RELEASES, SPRING, Rig, bare, recorded, release, releases, robot
from peers.mujoco_leg import simulate_states
from synth.files.trial_list import Trial
from synth.fit.recordings import Recording
from synth.fit.weak_form import LinearEstimate, weak_form
from synth.motion.smoothing import Smoothed
from synth.swing import mechanics
from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, DamperCurve, Leg

REST = np.array([j.sign * (j.spring.free_angle - j.zero) for j in robot().joints if j.spring])
SILENT = Rig(noise=0.0, counts=0)


def misses(found: LinearEstimate, spring: np.ndarray = SPRING, damper: np.ndarray = DAMPER) -> np.ndarray:
    """Largest relative error of rates and error of rests, rad."""
    errors = [found.spring_rate / spring - 1, found.damper_rate / damper - 1, found.rest - REST]
    return np.array([np.abs(error).max() for error in errors])


def exact(leg: Leg, rate: float, duration: float = 1.0) -> list[Recording]:
    """Releases with exact angles and rates in place of smoothed ones."""
    rig = Rig(noise=0.0, counts=0, rate=rate, duration=duration)
    made = []
    for recording, away in zip(recorded(leg, releases(leg, 0, rig, 3)), RELEASES, strict=False):
        start = REST + leg.sign * np.radians(away)
        rotation, speed = simulate_states(leg, start, np.zeros(3), recording.time, step=2e-4)
        still = np.zeros(len(recording.time), dtype=bool)
        made.append(replace(recording, smoothed=Smoothed(recording.time, rotation, speed, np.zeros(3), still)))
    return made


def test_with_exact_angles_and_rates_only_quadrature_error_remains() -> None:
    # bump and slope vanish at the ends, so the trapezoid rule gains at least its second order
    leg = robot()
    coarse, fine = (misses(weak_form(bare(leg), exact(leg, rate))) for rate in (250.0, 500.0))
    assert np.all(fine < coarse / 4)
    assert fine.max() < 1e-5


@pytest.mark.parametrize("per_trial", [False, True])
@pytest.mark.parametrize("window", [0.05, 0.1, 0.2])
def test_noise_free_recordings_recover_the_leg_to_a_thousandth(per_trial: bool, window: float) -> None:
    # what is left is the smoothing: cubics over 30 ms of a motion with a 290 1/s mode in it
    leg = robot()
    found = weak_form(bare(leg), recorded(leg, releases(leg, 0, SILENT)), window=window, per_trial_rest=per_trial)
    assert misses(found).max() < 1.5e-3
    np.testing.assert_allclose(found.rest_by_trial, np.tile(REST, (7, 1)), atol=1e-3)


def test_momentum_and_force_are_lagranges() -> None:
    """Of absolute angles phi: sum A_ij cos(phi_i - phi_j) w_j, and its force, summed over the links outboard."""
    random = np.random.default_rng(1)
    known = replace(mechanics.coefficients(robot(), 0.05), armature=np.array([1e-3, 2e-3, 3e-3]))
    angle, rate = random.normal(size=(2, 40, 3)) * np.array([1.0, 9.0])[:, None, None]
    phi, omega = mechanics.absolute(angle, 0.1), np.cumsum(rate, axis=1)
    apart = phi[:, :, None] - phi[:, None, :]
    momentum = np.einsum("ij,tij,tj->ti", known.inertia, np.cos(apart), omega)
    force = -np.einsum("ij,tij,tj,ti->ti", known.inertia, np.sin(apart), omega, omega) - known.gravity * np.sin(phi)
    expected = [np.cumsum(each[:, ::-1], axis=1)[:, ::-1] for each in (momentum, force)]
    expected[0] = expected[0] + known.armature * rate
    for ours, reference in zip(mechanics.momentum_and_force(known, angle, rate, 0.1), expected, strict=True):
        np.testing.assert_allclose(ours, reference, rtol=1e-12, atol=1e-14)


def test_noisy_recordings_recover_the_leg_to_five_per_cent() -> None:
    leg = robot()
    found = misses(weak_form(bare(leg), recorded(leg, releases(leg, 1))))
    assert found[:2].max() < 0.05
    assert found[2] < np.radians(0.2)


def test_a_known_damper_curve_replaces_the_damper_rate() -> None:
    speed = (0.05, 0.1, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0)
    curve = DamperCurve(speed, tuple(0.12 * s**0.45 for s in speed))
    leg = robot().with_joints(knee={"damper": Damper(curve=curve)})
    rig = Rig(noise=0.0, counts=0, step=2e-4)
    found = weak_form(bare(leg), recorded(leg, releases(leg, 0, rig)), [None, curve, None])
    np.testing.assert_allclose(found.spring_rate, SPRING, rtol=5e-3)
    assert found.damper_rate[1] == 0.0


def test_a_known_torque_is_included() -> None:
    leg, times = robot(), SILENT.times
    torque = 0.3 * np.sin(9 * times)[:, None] * np.array([4.0, 1.0, 0.3])
    trials = []
    for i, away in enumerate(RELEASES[:3]):
        start = REST + leg.sign * np.radians(away)
        rotation = simulate(leg, start, np.zeros(3), times, tolerance=1e-9, known_torque=(times, torque))
        trials.append(Trial(f"{i}", times, leg.to_measured(rotation), torques=leg.sign * torque))
    assert misses(weak_form(bare(leg), recorded(leg, trials))).max() < 2e-3
    untold = [replace(trial, torques=None) for trial in trials]
    assert misses(weak_form(bare(leg), recorded(leg, untold))).max() > 0.02


@pytest.mark.parametrize(
    ("own_tilt", "tilt", "tip_mass"),
    [(0.4, 0.0, 0.0), (0.0, -0.5, 0.0), (0.3, 0.2, 0.0), (0.0, 0.0, 0.25), (0.3, -0.6, 0.1)],
)
def test_a_tilted_base_and_a_tip_mass_are_included(own_tilt: float, tilt: float, tip_mass: float) -> None:
    """MuJoCo tilts its first body and has the mass in its last link; without them the estimate is far off."""
    leg = replace(robot(), tilt=own_tilt)
    generator = np.random.default_rng(0)
    trials = [release(leg, away, generator, SILENT, tilt=tilt, tip_mass=tip_mass) for away in RELEASES[:4]]
    assert misses(weak_form(bare(leg), recorded(leg, trials))).max() < 2.5e-3
    forgotten = [replace(trial, tilt=0.0, tip_mass=0.0) for trial in trials]
    assert misses(weak_form(bare(replace(leg, tilt=0.0)), recorded(replace(leg, tilt=0.0), forgotten))).max() > 0.05


def test_a_gap_in_the_recording_is_skipped_not_interpolated() -> None:
    leg = robot()
    trials = releases(leg, 0, SILENT)
    holed = []
    for trial in trials:
        angles = trial.angles.copy()
        angles[60:110] = np.nan  # 0.1 s of the fastest motion
        holed.append(replace(trial, angles=angles))
    recordings = recorded(leg, holed)
    assert misses(weak_form(bare(leg), recordings)).max() < 5e-3
    unmarked = [replace(r, smoothed=replace(r.smoothed, gap=np.zeros_like(r.smoothed.gap))) for r in recordings]
    assert misses(weak_form(bare(leg), unmarked)).max() > 0.02


def test_a_joint_whose_angle_is_constant_raises_no_numerical_warning() -> None:
    """Projected onto its rest angle nothing but rounding remains of its column, of either sign."""
    leg = robot()
    (one,) = recorded(leg, releases(leg, 1, SILENT, 1))
    for angle in np.linspace(0.1, 2.0, 20):
        still = replace(one.smoothed, angle=one.smoothed.angle.copy(), rate=one.smoothed.rate.copy())
        still.angle[:, 2], still.rate[:, 2] = angle, 0.0
        found = weak_form(leg, [replace(one, smoothed=still)])
        assert np.isfinite(found.spring_rate[:2]).all()


def test_a_joint_that_is_locked_everywhere_is_nan() -> None:
    leg = robot()
    recordings = recorded(leg, releases(leg, 0, SILENT, 2))
    held = [replace(r, conditions=replace(r.conditions, locked=(1,))) for r in recordings]
    found = weak_form(bare(leg), held)
    assert np.isnan([found.spring_rate[1], found.damper_rate[1], found.rest[1]]).all()
    assert np.isfinite(found.spring_rate[[0, 2]]).all()
