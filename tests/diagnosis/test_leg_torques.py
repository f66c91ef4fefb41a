"""What a leg's own effects and drives do along a recording is no torque that it lacks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.simulated_releases import NOISE, TWO, recorded, shifted, with_effects
from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial, angle_trial
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.plant import StagePredictions
from synth.diagnosis.plants.swinging_chain.chain_figures import trial_gaps
from synth.diagnosis.plants.swinging_chain.chain_where import locate_gap, missing_torque
from synth.diagnosis.plants.swinging_chain.leg_torques import bearing_forces, driving_torques
from synth.diagnosis.prediction_error import PredictionErrors
from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo, ServoSignals
from synth.files.trial_list import Trial
from synth.fit.recordings import recordings
from synth.swing.chain import Conditions, simulate
from synth.swing.leg_model import Joint, Leg, Link

FINE = np.arange(1201) * 1e-3
STATED = {
    "coulomb_friction": {"torque": 0.05},
    "load_friction": {"radius": 0.01},
    "hardening_spring": {"stiffening": 0.2, "reach": 1.0},
    "quadratic_damping": {"coefficient": 0.02},
    "spring_hysteresis": {"stiffness": 0.4, "slip": 0.1},
}


def trial_of(leg: Leg, trial: Trial) -> AngleTrial:
    return angle_trial(recordings(leg, [trial], ())[0], held_out=False)


def moving(trial: AngleTrial, lacking: Array, time: Array, joint: int) -> Array:
    """Missing torque of a joint where it moves: at a turn a window averages over the change of sign."""
    smoothed = trial.recording.smoothed
    rate = np.interp(time, smoothed.time, smoothed.rate[:, joint])
    return np.asarray(lacking[np.abs(rate) > 0.5, joint])


@pytest.mark.parametrize("effect", list(STATED))
def test_an_effect_in_the_leg_file_is_not_missing(effect: str) -> None:
    """Recordings of the very leg: the torque without its effect is missing, with it next to none."""
    built = with_effects(TWO, {"knee": {effect: STATED[effect]}})
    trial = trial_of(TWO, recorded(built, noise=0.0, time=FINE, held_out=0)[0])
    without, found = missing_torque(TWO, trial), missing_torque(built, trial)
    before, after = (np.abs(moving(trial, each.torque, each.time, 1)) for each in (without, found))
    assert np.median(after) < 0.1 * np.median(before)


def test_the_bearing_force_of_a_leg_at_rest_is_the_outboard_weight() -> None:
    trial = trial_of(TWO, recorded(TWO, noise=0.0, time=FINE, held_out=0)[0])
    smoothed = trial.recording.smoothed
    still = replace(smoothed, rate=np.zeros_like(smoothed.rate))
    found = bearing_forces(TWO, still, Conditions(tip_mass=0.2))
    assert found == pytest.approx(np.tile([9.81 * (0.6 + 0.35 + 0.2), 9.81 * (0.35 + 0.2)], (len(found), 1)))


def test_noise_hardly_changes_the_bearing_force() -> None:
    """By differences from sample to sample 0.1 deg at 1 kHz made the knee's greatest force a quarter larger."""
    force = []
    for noise in (0.0, NOISE):
        smoothed = trial_of(TWO, recorded(TWO, noise=noise, time=FINE, held_out=0)[0]).recording.smoothed
        force.append(np.percentile(bearing_forces(TWO, smoothed, Conditions()), 95.0, axis=0))
    assert force[1] == pytest.approx(force[0], rel=0.08)


def test_a_stated_warming_of_a_winding_is_in_the_torque_that_acts() -> None:
    """A motor that holds a link against gravity: in the end the drive's torque is that of the warm winding."""
    heat = {"rise": 0.5, "reference": 0.3, "time": 5.0}
    servo = Servo(gain=1.15, supply=7.4, motor=GearedMotor(3.5, 0.37, rotor_inertia=1.6e-3), source_resistance=1.0)
    leg = Leg("arm", (Joint("arm", Link(0.12, 0.49, 0.1, 1e-4), drive=servo, effects={"winding_heating": heat}),))
    time = np.arange(0.0, 30.0, 0.02)
    ones = np.ones((len(time), 1))
    signals = ServoSignals(time, (0.9 + 0.2 * np.sin(3.0 * time))[:, None], 7.4 * ones, ones)
    angle = simulate(leg, [0.5], [0.0], time, signals=signals)
    recording = recordings(leg, [Trial("1.csv", time, angle, signals=signals)], ())[0]
    weight = 0.49 * 9.81 * 0.1 * np.sin(recording.smoothed.angle[:, 0])
    away = [float(np.mean((driving_torques(each, recording)[:, 0] - weight)[-700:])) for each in (leg, cold(leg))]  # type: ignore[index]
    assert abs(away[0]) < 0.02 * np.mean(weight)
    assert away[1] > 0.2 * np.mean(weight)


def cold(leg: Leg) -> Leg:
    return leg.with_joints(arm={"effects": {}})


def test_a_stated_error_of_a_known_torque_is_in_the_torque_that_acts() -> None:
    """(1 + gain) times the column, and the offset, late by the delay."""
    stated = {"torque_gain": {"share": 0.2}, "torque_offset": {"offset": 0.03}, "torque_delay": {"delay": 0.05}}
    built = with_effects(TWO, {"knee": stated})
    column = np.stack([np.zeros_like(FINE), 0.3 * np.sin(9.0 * FINE)], axis=1)
    motion = simulate(built, TWO.rest, [0.0, 0.0], FINE, known_torque=(FINE, column))
    trial = trial_of(TWO, Trial("1.csv", FINE, TWO.to_measured(motion), torques=TWO.sign * column))
    driven = driving_torques(built, trial.recording)
    assert driven is not None
    time = trial.recording.smoothed.time
    late = time > 0.06
    expected = 1.2 * 0.3 * np.sin(9.0 * (time - 0.05)) + TWO.sign[1] * 0.03
    assert driven[late, 1] == pytest.approx(expected[late], abs=1e-3)
    lacking = missing_torque(built, trial)
    assert np.median(np.abs(lacking.torque[:, 1])) < 0.1 * np.median(np.abs(missing_torque(TWO, trial).torque[:, 1]))


def test_a_trial_with_its_own_leg_is_deflected_from_that_leg() -> None:
    """Its spring is unloaded half a radian away: at rest near there it is neither deflected nor loaded."""
    other = shifted(TWO, "knee", 0.5)
    (trial,) = recorded(other, noise=NOISE, held_out=0)[:1]
    prepared = trial_of(TWO, replace(trial, leg=other))
    alone = trial_of(other, trial)
    lacking = [missing_torque(TWO, prepared)]
    predictions, noise = [prepared.measured + 0.01], np.full(2, NOISE)
    ours = locate_gap(TWO, [prepared], predictions, noise, lacking, {})
    theirs = locate_gap(other, [alone], predictions, noise, [missing_torque(other, alone)], {})
    assert ours.position == pytest.approx(theirs.position)
    assert ours.load == pytest.approx(theirs.load)
    predicted = (prepared.measured,)
    errors = PredictionErrors({}, np.zeros((1, 4)), np.zeros((1, 4)), 0)
    fit = EvaluatedHypothesis((), np.zeros(0), ())
    stages = StagePredictions((fit, fit, fit), predicted, predicted, predicted, {}, errors)
    (shown,) = trial_gaps(TWO, [prepared], stages, lacking, held_out=False, noise=noise)
    (expected,) = trial_gaps(other, [alone], stages, lacking, held_out=False, noise=noise)
    assert shown.deflection == pytest.approx(expected.deflection)
