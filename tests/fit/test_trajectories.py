"""Predicted trajectories and their Jacobian in lanes, against finite differences of single accurate simulations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fit.simulated_legs import DAMPER, SPRING, Rig, bare, recorded, release, releases, robot
from synth.fit.least_squares import FitStart, Weights, solve
from synth.fit.recordings import Recording
from synth.fit.trajectories import Local, TrajectoryModel
from synth.fit.uncertainty import covariance
from synth.fit.unknowns import SpringsAndDampers, unknowns_of_leg
from synth.motion.smoothing import initial_state
from synth.swing.chain import compiled_chain, simulate
from synth.swing.leg_model import Leg

CHAIN = compiled_chain(3)


def model_of(leg: Leg, **options: float) -> tuple[TrajectoryModel, np.ndarray]:
    """A model of the leg and the unknowns' true values."""
    empty = bare(leg)
    unknowns = unknowns_of_leg(CHAIN, empty)
    rest = np.array([j.sign * (j.spring.free_angle - j.zero) for j in leg.joints if j.spring])
    rate = np.array([j.spring.rate for j in leg.joints if j.spring])
    damping = np.array([j.damper.rate for j in leg.joints if j.damper])
    return TrajectoryModel(CHAIN, empty, unknowns, **options), unknowns.pack(rate, rest, damping)


def local_of(recording: Recording, shift: float = 0.0) -> Local:
    rotation, rate = initial_state(recording.smoothed)
    return Local(rotation, rate, np.full(3, shift))


@pytest.mark.parametrize("locked", [(), ("knee",)])
def test_prediction_and_jacobian_equal_single_simulations(locked: tuple[str, ...]) -> None:
    leg = robot()
    trial = release(leg, (9, -17, -24), np.random.default_rng(1), locked=locked, tip_mass=0.05, tilt=0.1)
    recording = recorded(leg, [trial, releases(leg, 0)[0]])[0]
    model, values = model_of(leg)
    local = local_of(recording, 0.02)

    def alone(values: np.ndarray, local: Local) -> np.ndarray:
        k, rest, b = np.split(model.unknowns.natural(values), 3)  # type: ignore[attr-defined]
        angle = leg.zero + leg.sign * (rest + local.shift)
        made = robot(k, b, np.degrees(angle))
        return simulate(made, local.rotation, local.rate, recording.time, recording.conditions, tolerance=1e-12)

    found = model.evaluate(recording, values, local)
    np.testing.assert_allclose(found.prediction, alone(values, local), atol=1e-6)
    assert found.common is not None
    assert found.local is not None
    for k in range(9):
        move = 1e-5 * np.eye(9)[k]
        slope = (alone(values + move, local) - alone(values - move, local)) / 2e-5
        np.testing.assert_allclose(found.common[:, :, k], slope, atol=2e-5)
    free = recording.free
    assert found.local.shape[2] == 3 * len(free)
    for k in range(3 * len(free)):
        step = 1e-5 * np.eye(3 * len(free))[k]
        up, down = (alone(values, model.step_local(recording, local, s)) for s in (step, -step))
        np.testing.assert_allclose(found.local[:, :, k], (up - down) / 2e-5, atol=2e-5)


@pytest.mark.parametrize("locked", [(), ("knee",)])
def test_lanes_after_a_small_step_equal_its_simulation(locked: tuple[str, ...]) -> None:
    leg = robot()
    recording = recorded(
        leg, [release(leg, (9, -17, -24), np.random.default_rng(1), locked=locked), *releases(leg, 0)]
    )[0]
    model, values = model_of(leg)
    local, free = local_of(recording, 0.02), len(recording.free)
    size = 1e-3  # a third of a deviation of the thesis' fits; what is left is of its square
    common, own = size * np.cos(np.arange(9)), size * np.sin(np.arange(3 * free))
    moved = model.sensitivity(recording, values, local).after(np.concatenate([common, own]))
    there = model.sensitivity(recording, values + common, model.step_local(recording, local, own))
    np.testing.assert_allclose(moved.prediction, there.prediction, atol=30 * size**2)
    assert (
        np.abs(moved.prediction - there.prediction).max() < 0.02 * np.abs(moved.prediction - moved.out[:, :, 0]).max()
    )
    twice = moved.after(-np.concatenate([common, own]))
    np.testing.assert_allclose(twice.prediction, twice.out[:, :, 0], atol=1e-12)
    np.testing.assert_array_equal(twice.differences(), moved.differences())


def test_integration_error_does_not_narrow_intervals_of_an_overdamped_joint() -> None:
    leg = robot([60.0, *SPRING[1:]], [12.0, *DAMPER[1:]])
    recordings = recorded(leg, releases(leg, 3, Rig(noise=0.3), count=4))
    weights = Weights(np.full((4, 3), np.radians(0.3)), np.zeros(3))
    deviations = []
    for options in ({}, {"tolerance": 1e-10}):
        model, values = model_of(leg, **options)
        at_truth = solve(
            model, recordings, FitStart(values, [local_of(r) for r in recordings]), weights, max_iterations=0
        )
        deviations.append(np.sqrt(np.diag(covariance(model, at_truth))))
    np.testing.assert_allclose(deviations[0], deviations[1], rtol=0.02)
    assert deviations[1][0] > 0.05  # the hip's k is hard to tell, which is what went wrong


def test_a_diverging_simulation_gives_nan() -> None:
    leg = robot()
    recording = recorded(leg, releases(leg, 0, count=1))[0]
    model, values = model_of(leg)
    stiff = values.copy()
    stiff[-1] += 12.0
    assert np.isnan(model.evaluate(recording, stiff, local_of(recording)).prediction).any()


def test_packing_round_trips_and_clips_to_the_bounds() -> None:
    unknowns = unknowns_of_leg(CHAIN, bare(robot()))
    assert isinstance(unknowns, SpringsAndDampers)
    rest = np.array([0.2, -1.0, 0.7])
    values = unknowns.pack(SPRING, rest, DAMPER)
    np.testing.assert_allclose(unknowns.natural(values), np.r_[SPRING, rest, DAMPER], rtol=1e-12)
    clipped = unknowns.pack(-SPRING, rest, 1e9 * DAMPER)
    np.testing.assert_array_equal(clipped[:3], unknowns.lower[:3])
    np.testing.assert_array_equal(clipped[6:], unknowns.upper[6:])
    without = replace(unknowns, dampers=(0, 2))
    assert without.names[-2:] == ("damper_rate hip", "damper_rate ankle")
    assert without.rest_index == (3, 4, 5)


def test_columns_equal_single_runs_and_a_diverging_one_leaves_the_others_unchanged() -> None:
    leg = robot()
    recording = recorded(leg, releases(leg, 0)[:1])[0]
    model, values = model_of(leg)
    local, shifts = local_of(recording), np.array([[0.0, 0.02, 0.0]] * 3)
    columns = np.stack([values, values + 0.01, values + 0.1], axis=1)
    together = model.predictions(recording, columns, local, shifts)
    for k in range(3):
        alone = model.predictions(recording, columns[:, k : k + 1], local, shifts[:, k : k + 1])
        np.testing.assert_allclose(together[:, :, k], alone[:, :, 0], atol=1e-6)
    columns[6:, 1] += 14.0  # dampers far too stiff to follow
    spoilt = model.predictions(recording, columns, local, shifts)
    assert np.isnan(spoilt[-1, :, 1]).all()
    np.testing.assert_allclose(spoilt[:, :, [0, 2]], together[:, :, [0, 2]], atol=1e-6)


def test_weights_at_the_same_point_need_no_simulation() -> None:
    leg = robot()
    trials = recorded(leg, releases(leg, 0)[:2])
    model, values = model_of(leg)
    locals_ = [local_of(recording) for recording in trials]
    lanes = [model.sensitivity(r, values, local) for r, local in zip(trials, locals_, strict=True)]
    weights = Weights(np.full((2, 3), 0.1), np.zeros(3))  # so that every residual counts in full
    anew = solve(model, trials, FitStart(values, locals_), weights, max_iterations=0)
    kept = solve(model, trials, FitStart(values, locals_, lanes=lanes), weights, max_iterations=0)
    assert kept.cost == anew.cost
    np.testing.assert_array_equal(kept.information.common, anew.information.common)
    slopes = [model.evaluate(r, values, local).common for r, local in zip(trials, locals_, strict=True)]
    jacobian = np.concatenate([slope.reshape(-1, 9) for slope in slopes if slope is not None]) / 0.1
    expected = jacobian.T @ jacobian + np.diag(model.unknowns.prior[1])
    np.testing.assert_allclose(anew.information.common, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())
