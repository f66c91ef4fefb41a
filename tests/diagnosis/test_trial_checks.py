"""Checks of trials: those without information are refused, those with little give a warning."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fit.simulated_legs import FREE_ANGLE, NAMES, robot
from synth.arrays import Array
from synth.diagnosis.plants.swinging_chain.trial_checks import check_trials
from synth.errors import UserError
from synth.files.trial_list import Trial
from synth.remarks import severity_of
from synth.swing.leg_model import Damper, DamperCurve

TIME = np.arange(200) * 0.005
LEG = robot()


def trial(name: str, amplitude: float, noise: float = 0.05, seed: int = 0) -> Trial:
    """A decaying swing of every joint, amplitude and noise in deg."""
    generator = np.random.default_rng(seed)
    swing = amplitude * np.exp(-3.0 * TIME) * np.cos(20.0 * TIME)
    angles = FREE_ANGLE + swing[:, None] + generator.normal(0.0, noise, (len(TIME), 3))
    return Trial(name, TIME, np.radians(angles))


def with_angles(original: Trial, joint: int, angles: Array) -> Trial:
    changed = original.angles.copy()
    changed[:, joint] = angles
    return replace(original, angles=changed)


def test_good_trials_give_no_warning() -> None:
    assert check_trials(LEG, [trial("a.csv", 20.0), trial("b.csv", 15.0, seed=1)]) == ()


def test_each_trial_that_never_moves_is_refused() -> None:
    with pytest.raises(UserError) as caught:
        check_trials(LEG, [trial("a.csv", 0.0), trial("b.csv", 0.1)])
    assert [problem.file for problem in caught.value.problems] == ["a.csv", "b.csv"]
    assert all("does not move" in problem.text for problem in caught.value.problems)


def test_noise_larger_than_the_motion_is_refused_with_both_numbers() -> None:
    with pytest.raises(UserError) as caught:
        check_trials(LEG, [trial("a.csv", 3.0, noise=4.0)])
    (problem,) = caught.value.problems
    assert "is larger than its motion" in problem.text
    noise = float(problem.text.split("its noise, ")[1].split(" deg")[0])
    assert noise == pytest.approx(4.0, rel=0.2)


def test_motion_in_a_held_out_trial_only_is_refused() -> None:
    with pytest.raises(UserError, match="does not move"):
        check_trials(LEG, [trial("a.csv", 0.0), replace(trial("b.csv", 20.0), held_out=True)])


def test_one_trial_at_rest_gives_a_warning() -> None:
    said = check_trials(LEG, [trial("a.csv", 20.0), trial("b.csv", 20.0, seed=1), trial("rest.csv", 0.0)])
    assert len(said) == 1
    assert said[0].startswith("rest.csv: no joint moves above its noise")


def test_a_joint_that_never_moves_gives_a_warning() -> None:
    still = np.radians(105.0 + np.random.default_rng(3).normal(0.0, 0.05, len(TIME)))
    said = check_trials(LEG, [with_angles(trial(f"{k}.csv", 20.0, seed=k), 0, still) for k in range(2)])
    assert len(said) == 1
    assert said[0].startswith("hip: never moves above its noise")


def test_a_joint_that_is_always_locked_gives_a_warning() -> None:
    held = [with_angles(trial(f"{k}.csv", 20.0, seed=k), 2, np.full(len(TIME), 2.4)) for k in range(2)]
    said = check_trials(LEG, [replace(one, locked=("ankle",)) for one in held])
    assert said == (f"{NAMES[2]}: locked in every training trial; its own spring, damper and friction are not seen",)


def test_a_locked_joint_that_moves_gives_a_warning() -> None:
    loose = replace(trial("a.csv", 20.0), locked=("hip",))
    held = replace(with_angles(trial("b.csv", 20.0, seed=1), 0, np.full(len(TIME), np.radians(100.0))), locked=("hip",))
    said = check_trials(LEG, [loose, held, trial("c.csv", 20.0, seed=2)])
    assert len(said) == 1
    assert said[0].startswith("a.csv: hip is listed as locked but moves by ")


def test_copies_count_as_one_trial() -> None:
    (said,) = check_trials(LEG, [trial("a.csv", 20.0), trial("b.csv", 20.0)])
    assert "only one training trial" in said


@pytest.mark.parametrize(("held_out", "words"), [(0, "on the trial itself"), (2, "on the held-out trials")])
def test_a_single_trial_is_accepted_with_a_warning(held_out: int, words: str) -> None:
    others = [replace(trial(f"check_{k}.csv", 20.0, seed=k + 1), held_out=True) for k in range(held_out)]
    (said,) = check_trials(LEG, [trial("a.csv", 20.0), *others])
    assert "only one training trial" in said
    assert words in said
    assert severity_of(said) == "decide"  # among the first warnings of the page


def test_a_known_torque_is_applied_and_noted() -> None:
    torques = np.zeros((len(TIME), 3))
    torques[:, 1] = 0.01
    driven = replace(trial("a.csv", 20.0), torques=torques)
    (said,) = check_trials(LEG, [driven, trial("b.csv", 20.0, seed=1)])
    assert said.startswith("a.csv: the torque columns of knee are applied as known torques")
    (said,) = check_trials(LEG, [replace(driven, torques=0.0 * torques), trial("b.csv", 20.0, seed=1)])
    assert "are all zero" in said


def test_a_recorded_current_has_its_motor_and_is_no_doubt() -> None:
    """Its constant, gear and rotor were used, and "torque columns" were "without a motor model"."""
    torques = np.zeros((len(TIME), 3))
    torques[:, 1] = 0.01
    by_current = replace(trial("a.csv", 20.0), torques=torques, by_current=("knee",))
    other = trial("b.csv", 20.0, seed=1)
    assert check_trials(LEG, [by_current, other]) == ()
    torques[:, 0] = 0.02  # a column beside it
    (said,) = check_trials(LEG, [by_current, other])
    assert said.startswith("a.csv: the torque columns of hip are applied as known torques")
    (said,) = check_trials(LEG, [replace(by_current, torques=0.0 * torques), other])
    assert "current columns are all zero" in said


def test_missing_samples_and_encoder_counts_are_not_taken_for_noise() -> None:
    count = 360.0 / 1024
    coarse = trial("a.csv", 20.0, noise=0.0)
    read = np.radians(count * np.round(np.degrees(coarse.angles) / count))
    read[40:45, 1] = np.nan
    assert check_trials(LEG, [replace(coarse, angles=read), trial("b.csv", 20.0, seed=1)]) == ()


@pytest.mark.parametrize(("torque", "beyond"), [((0.02, 0.03), "goes on"), ((0.03, 0.02), "keeps")])
def test_a_damper_turned_faster_than_its_curve_is_told(torque: tuple[float, float], beyond: str) -> None:
    """The swing A exp(-3 t) cos(20 t) is fastest near its first zero: at about 20 A exp(-0.2)."""
    swings = [trial("a.csv", 20.0), trial("b.csv", 15.0, seed=1)]

    def said(fastest: float) -> tuple[str, ...]:
        curve = DamperCurve((0.5 * fastest, fastest), torque)
        joints = (LEG.joints[0], replace(LEG.joints[1], damper=Damper(curve=curve)), LEG.joints[2])
        return check_trials(replace(LEG, joints=joints), swings)

    (text,) = said(np.radians(200.0))
    assert text.startswith("knee: a.csv turns the damper at up to 3")
    assert "ends at 200," in text
    assert beyond in text
    assert said(np.radians(400.0)) == ()


def test_stated_effects_are_told_as_part_of_the_designed_leg() -> None:
    """Counts alone are found from the readings."""
    stated = {"gear_play": {"play": 0.02}, "encoder_offset": {"offset": 0.01}, "coulomb_friction": {"torque": 0.1}}
    stated["encoder_quantisation"] = {"step": 0.01}
    leg = replace(LEG.with_joints(knee={"effects": stated}), effects={"base_compliance": {"stiffness": 400.0}})
    simulated, counts = check_trials(leg, [trial("a.csv", 20.0), trial("b.csv", 15.0, seed=1)])
    assert simulated == (
        "part of the designed leg, as its file states: gear_play (knee), encoder_offset (knee), "
        "coulomb_friction (knee), base_compliance (base)"
    )
    assert counts.startswith("knee: encoder_quantisation is stated in the leg file, but not simulated: ")


def test_a_stated_effect_of_a_torque_that_no_trial_has_is_no_part_of_the_leg() -> None:
    """It was told as such, and the answer was that without it."""
    stated = {"torque_gain": {"share": 0.5}, "gear_friction": {"share": 0.1}, "coulomb_friction": {"torque": 0.1}}
    leg = LEG.with_joints(knee={"effects": stated})
    trials = [trial("a.csv", 20.0), trial("b.csv", 15.0, seed=1)]
    gain, friction, simulated = check_trials(leg, trials)
    assert gain == (
        "knee: torque_gain, which the leg file states, acts in no trial: it needs a known torque; no trial has a "
        'column "knee torque [N*m]" beyond 0 with the joint free'
    )
    assert friction.startswith("knee: gear_friction, which the leg file states, acts in no trial: it needs a servo, ")
    assert simulated == "part of the designed leg, as its file states: coulomb_friction (knee)"
    torques = np.zeros((len(TIME), 3))
    torques[:, 1] = 0.01
    told = check_trials(leg, [replace(trials[0], torques=torques), trials[1]])
    assert told[-1].endswith(": torque_gain (knee), gear_friction (knee), coulomb_friction (knee)")
    own = [replace(each, leg=leg, leg_file="own.leg.yaml") for each in trials]
    assert "which own.leg.yaml states, acts in no trial" in check_trials(LEG, own)[0]
