"""The fit on simulated legs: lost samples, shifting free angles, curves, scaling, what is not separable."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import chi2

from fit.simulated_legs import (
    DAMPER,
    FREE_ANGLE,
    NAMES,
    RELEASES,
    SPRING,
    Rig,
    bare,
    errors,
    fitted,
    recorded,
    release,
    releases,
    robot,
)
from synth.estimation.intervals import Estimate
from synth.files.trial_list import Trial
from synth.fit import ridge
from synth.fit.estimate import fit_leg
from synth.fit.fit_problem import model_of, unknowns_of
from synth.fit.fit_result import FitResult
from synth.fit.free_angle import heterogeneity
from synth.fit.known import Known
from synth.fit.ridge import RIDGE, loose_joints
from synth.fit.uncertainty import MASS_SCALE, mass_scale_sentence, not_separable, root_mean_square
from synth.fit.unseen_score import score
from synth.remarks import joint_of, kind_of
from synth.swing.chain import Conditions
from synth.swing.leg_model import Damper, DamperCurve, Leg

LEG = robot()
TRIALS = releases(LEG, 3)
WITHIN = 3.5  # standard deviations that nine estimates of one fit stay within but once in 250 times


def lose_one_sample(angles: np.ndarray, generator: np.random.Generator) -> None:
    angles[100, 1] = np.nan


def spike_one_sample(angles: np.ndarray, generator: np.random.Generator) -> None:
    angles[100, 1] += 1.0


def five_per_cent_nan(angles: np.ndarray, generator: np.random.Generator) -> None:
    angles[generator.random(angles.shape) < 0.05] = np.nan


def five_per_cent_spikes(angles: np.ndarray, generator: np.random.Generator) -> None:
    for joint in range(3):
        numbers = generator.choice(np.arange(2, 498, 4), 25, replace=False) + generator.integers(0, 2, 25)
        angles[numbers, joint] += generator.uniform(0.1, 2.0, 25) * generator.choice([-1, 1], 25)


@pytest.mark.parametrize(
    ("spoil", "n_lost"),
    [(lose_one_sample, 1), (spike_one_sample, 1), (five_per_cent_nan, 526), (five_per_cent_spikes, 525)],
)
def test_lost_samples_do_not_bias_the_estimates(
    spoil: Callable[[np.ndarray, np.random.Generator], None], n_lost: int
) -> None:
    generator, trials = np.random.default_rng(0), []
    for i, trial in enumerate(TRIALS):
        angles = trial.angles.copy()
        if i == 0 or n_lost > 1:
            spoil(angles, generator)
        trials.append(replace(trial, angles=angles))
    result = fitted(LEG, trials)
    assert np.abs(errors(result, LEG).scores).max() < WITHIN
    assert result.lost_samples == pytest.approx(n_lost, rel=0.15)


def test_missing_rows_do_not_bias_the_estimates() -> None:
    generator, trials = np.random.default_rng(0), []
    for trial in TRIALS:
        keep = generator.random(len(trial.time)) > 0.05
        trials.append(replace(trial, time=trial.time[keep], angles=trial.angles[keep]))
    assert np.abs(errors(fitted(LEG, trials), LEG).scores).max() < WITHIN


def shifted_releases(seed: int, spread: float) -> tuple[list[Trial], np.ndarray]:
    """Seven releases whose free angles shift by ``spread`` deg SD; the shifts (7, 3) deg."""
    generator = np.random.default_rng(seed)
    shifts = generator.normal(0, spread, (7, 3))
    legs = [robot(free_angle=FREE_ANGLE + shift) for shift in shifts]
    aways = np.array(RELEASES) - shifts
    return [release(g, a, generator, name=str(i)) for i, (g, a) in enumerate(zip(legs, aways, strict=True))], shifts


def test_shifting_free_angles_are_estimated_per_trial() -> None:
    trials, shifts = shifted_releases(1, 2.0)
    result = fitted(LEG, trials)
    assert result.free_angle == "per_trial"
    assert "shifts from trial to trial" in result.free_angle_why
    found = np.degrees([trial.free_angle for trial in result.trials]) - FREE_ANGLE
    np.testing.assert_allclose(found, shifts, atol=0.05)
    for j, name in enumerate(NAMES):
        joint = result.joints[name]
        assert np.degrees(joint.free_angle_spread.value) == pytest.approx(shifts[:, j].std(ddof=1), rel=0.02)
        # the interval of a standard deviation: (n - 1) s^2 / chi-squared, where the shifts have hardly an error
        low, high = joint.free_angle_spread.value * np.sqrt(6 / chi2.ppf([0.95, 0.05], 6))
        assert (joint.free_angle_spread.low, joint.free_angle_spread.high) == pytest.approx((low, high), rel=0.01)
    assert np.abs(errors(result, LEG).scores).max() < WITHIN
    common = next(variant for variant in result.variants if variant.free_angle == "common")
    # what one free angle for all costs: k moves far beyond its interval
    assert abs(common.spring_rate["hip"].value / SPRING[0] - 1) > 0.05
    assert common.rms["hip"] > 4 * result.rms["hip"]
    assert fitted(LEG, trials, free_angle="common").free_angle == "common"


def test_a_common_free_angle_is_chosen_without_shifts() -> None:
    result = fitted(LEG, TRIALS)
    assert result.free_angle == "common"
    assert {variant.free_angle for variant in result.variants} == {"common", "per_trial"}
    assert all(joint.free_angle_spread.value == 0.0 for joint in result.joints.values())


def test_heterogeneity_equals_the_textbook_formula() -> None:
    """DerSimonian & Laird by hand: equal variances v, where Q = sum (x - mean)^2 / v and tau^2 = s^2 - v."""
    shift = np.radians([[-1.0], [0.5], [2.0], [-1.5], [0.0]])
    variance = np.full((5, 1), np.radians(0.4) ** 2)
    wide = np.radians(10.0)
    shrunk = shift * (1 - variance / wide**2)  # as estimated under the wide spread
    found = heterogeneity(shrunk, 1 / (1 / variance + 1 / wide**2))
    assert found.spread[0] == pytest.approx(np.sqrt(shift.var(ddof=1) - variance[0, 0]), rel=1e-4)
    q = float(((shift - shift.mean()) ** 2).sum() / variance[0, 0])
    assert found.probability[0] == pytest.approx((1 + q / 2) * np.exp(-q / 2), rel=1e-2)  # of four degrees of freedom


@pytest.mark.parametrize(("spread", "error"), [(1.0, 0.1), (1.0, 1.0), (0.3, 1.0), (0.0, 1.0)])
def test_nine_in_ten_intervals_of_the_spread_hold_whatever_the_error_of_a_shift(spread: float, error: float) -> None:
    """Nine trials; without the errors 63 % held where they are as large as the spread, and 22 % of 0.3 deg."""
    generator, count = np.random.default_rng(4), 600
    variance = np.full((9, count), np.radians(error) ** 2)
    shift = np.radians(generator.normal(0.0, spread, (9, count)) + generator.normal(0.0, error, (9, count)))
    low, high = np.degrees(heterogeneity(shift, variance).ends)
    assert np.mean((low <= spread) & (spread <= high)) == pytest.approx(0.95 if spread == 0.0 else 0.9, abs=0.03)


def test_a_trial_in_which_a_joint_is_locked_does_not_count_for_its_spread() -> None:
    variance = np.full((12, 1), np.radians(0.01) ** 2)
    variance[3:] = np.nan
    shift = np.radians([[2.0], [-1.5], [-0.5], *([[0.0]] * 9)])
    low, high = heterogeneity(shift, variance).ends[:, 0]
    of_three = float(np.std(shift[:3], ddof=1)) * np.sqrt(2 / chi2.ppf([0.95, 0.05], 2))
    assert (low, high) == pytest.approx(tuple(of_three), rel=0.01)


def test_false_positive_rate_of_the_shift_test_is_one_per_cent() -> None:
    generator = np.random.default_rng(9)
    variance = np.full((7, 3), np.radians(0.05) ** 2)
    called = sum(
        bool((heterogeneity(generator.normal(0, np.radians(0.05), (7, 3)), variance).probability < 0.01 / 3).any())
        for _ in range(3000)
    )
    assert 10 < called < 55


def test_initial_rates_of_moving_starts_are_estimated() -> None:
    generator = np.random.default_rng(5)
    rates = generator.uniform(-1, 1, (7, 3)) * [1, 4, 8]
    trials = [
        release(LEG, a, generator, rate=r, name=str(i)) for i, (a, r) in enumerate(zip(RELEASES, rates, strict=True))
    ]
    result = fitted(LEG, trials)
    assert np.abs(errors(result, LEG).scores).max() < WITHIN
    found = np.array([trial.rate for trial in result.trials])
    # four standard deviations of what 0.1 deg tells of rates that die within few samples
    assert np.all(np.abs(found - rates).max(axis=0) < [0.35, 0.8, 1.1])


@pytest.mark.parametrize("factor", [0.5, 3.0])
def test_without_gravity_slower_time_scales_damper_and_spring_rates(factor: float) -> None:
    # I q'' + b q' + k q = 0 (velocity terms too) in time s t: b / s and k / s^2
    leg = robot(gravity=0.0)
    recordings = recorded(leg, releases(leg, 2))
    first = fit_leg(bare(leg), recordings)
    slow = fit_leg(bare(leg), [recording.stretched(factor) for recording in recordings])
    for name in NAMES:
        one, other = first.joints[name], slow.joints[name]
        assert other.spring_rate.value == pytest.approx(one.spring_rate.value / factor**2, rel=1e-3)
        assert other.damper_rate.value == pytest.approx(one.damper_rate.value / factor, rel=1e-3)  # type: ignore[union-attr]
        assert other.free_angle.value == pytest.approx(one.free_angle.value, abs=1e-5)


SPRING_OF_OVERDAMPED = 100.0
OVERDAMPED = robot([SPRING_OF_OVERDAMPED, *SPRING[1:]], [15.0, *DAMPER[1:]], gravity=0.0)


def test_an_overdamped_joint_is_reported_as_b_over_k_only() -> None:
    result = fitted(OVERDAMPED, releases(OVERDAMPED, 1, Rig(noise=0.5), 3))
    said = next(text for text in result.not_separable if text.startswith("hip: not separable: spring rate and damper"))
    assert "b/k = 0.15 s" in said
    assert "static torque-angle point" in said
    missed = errors(result, OVERDAMPED)
    assert missed.spring_sd[0] > 0.12
    assert abs(missed.spring[0]) < WITHIN * missed.spring_sd[0]
    assert missed.damper[0] - missed.spring[0] == pytest.approx(0.0, abs=0.03)
    assert not any("softest" in text for text in result.not_separable)
    (family,) = result.families
    rates = [member.spring_rate for member in family.members]
    assert family.joint == "hip"
    assert rates == sorted(rates)
    assert rates[0] < SPRING_OF_OVERDAMPED < rates[-1]
    for member in family.members:  # all of one quotient, and nobody sees the difference in half a degree of noise
        assert member.damper_rate / member.spring_rate == pytest.approx(0.15, rel=0.03)
        assert member.difference < np.radians(0.05)
    assert family.sentence in result.not_separable
    assert {joint_of(text) for text in result.not_separable} == {"hip", None}
    assert [joint_of(text) for text in result.not_separable if kind_of(text) == MASS_SCALE] == [None]


def friction_at_the_ankle(rotation: np.ndarray, rate: np.ndarray) -> np.ndarray:
    return np.array([0.0, 0.0, -0.05 * rate[2] / np.hypot(rate[2], 0.02)])


def test_a_joint_that_is_not_separable_is_on_a_ridge(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rates known to 0.115 and 0.13 and their quotient to 0.016: the sentence and the move follow one rule."""
    model = model_of(bare(LEG), recordings=recorded(LEG, TRIALS[:1]))
    unknowns = unknowns_of(model)
    k, b = unknowns.rate_at(1), unknowns.damper_at(1)
    cov = 1e-6 * np.eye(len(unknowns.names))
    cov[np.ix_([k, b], [k, b])] = [[0.115**2, 0.115 * 0.13 * 0.9995], [0.115 * 0.13 * 0.9995, 0.13**2]]
    values = np.zeros(len(cov))
    kinds = ("spring_rate", "free_angle", "damper_rate")
    estimates = {f"{kind} {name}": Estimate(1.0, "s", 0.5, 2.0) for kind in kinds for name in LEG.joint_names}
    known = Known(cov, cov, values, (-values, values), estimates, np.zeros((4, 3)))
    assert any("not separable" in text for text in not_separable(unknowns, known))
    monkeypatch.setattr(ridge, "covariance", lambda *_, **__: cov)
    assert loose_joints(model, SimpleNamespace()) == [1]  # type: ignore[arg-type]


def test_the_softest_point_of_a_ridge_is_taken_only_with_model_error() -> None:
    generator = np.random.default_rng(1)
    trials = [
        release(OVERDAMPED, RELEASES[i], generator, Rig(noise=0.3), name=str(i), extra_torque=friction_at_the_ankle)
        for i in range(3)
    ]
    result = fitted(OVERDAMPED, trials, free_angle="common")
    assert any(text.startswith("ankle: the residual is") for text in result.warnings)
    said = next(text for text in result.not_separable if text.startswith("hip: of equally good springs and dampers"))
    assert (joint_of(said), kind_of(said)) == ("hip", RIDGE)
    for text in (*result.warnings, *result.not_separable):  # stated, not to be read out of the sentence
        assert joint_of(text) == next((name for name in result.joints if text.startswith(f"{name}:")), None)
    found = result.joints["hip"]
    assert found.spring_rate.value < 70.0
    assert found.damper_rate is not None
    assert found.damper_rate.value / found.spring_rate.value == pytest.approx(0.15, rel=0.1)
    # the interval reaches to where the least residual was, and beyond: the trials do not choose between the two
    least = float(re.search(r"the least residual would be at ([\d.]+)", said)[1])  # type: ignore[index]
    assert found.spring_rate.low is not None
    assert found.spring_rate.high is not None
    assert found.spring_rate.low < found.spring_rate.value < least < found.spring_rate.high
    # the family goes on to both sides of the softest that is given
    family = next(family for family in result.families if family.joint == "hip")
    rates = [member.spring_rate for member in family.members]
    assert rates[0] < found.spring_rate.value < least < rates[-1]
    assert any(member.difference == 0.0 for member in family.members)


def test_mass_scale_is_reported_open_unless_a_known_tip_mass_fixes_it() -> None:
    generator = np.random.default_rng(2)
    (said,) = (text for text in fitted(LEG, TRIALS[:2]).not_separable if "mass scale" in text)
    assert kind_of(said) == MASS_SCALE
    loaded = [*TRIALS[:2], release(LEG, RELEASES[2], generator, tip_mass=0.1)]
    result = fitted(LEG, loaded)
    assert not any("mass scale" in text for text in result.not_separable)
    assert np.abs(errors(result, LEG).scores).max() < WITHIN


def leg_with_curved_dampers() -> tuple[Leg, dict[str, DamperCurve]]:
    speed = (0.05, 0.1, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0)
    curves = {
        name: DamperCurve(speed, tuple(torque * s**0.45 for s in speed))
        for name, torque in zip(NAMES, (1.2, 0.12, 0.03), strict=True)
    }
    return LEG.with_joints(**{name: {"damper": Damper(curve=curve)} for name, curve in curves.items()}), curves


def test_a_known_damper_curve_fixes_the_mass_scale() -> None:
    """Its torque does not grow with the masses, so the rates are not proportional to them."""
    curve = DamperCurve((1.0, 5.0), (0.03, 0.08))
    leg = LEG.with_joints(hip={"damper": Damper(curve=curve)})
    made = [
        replace(recorded(LEG, [trial])[0], conditions=Conditions(locked))
        for trial, locked in zip(TRIALS[:2], ((), (0,)), strict=True)
    ]
    assert mass_scale_sentence(leg, made) is None
    assert mass_scale_sentence(leg, made[1:]) is not None  # the hip is locked
    assert mass_scale_sentence(LEG, made) is not None


def test_springs_are_estimated_with_known_damper_curves() -> None:
    leg, curves = leg_with_curved_dampers()
    trials = releases(leg, 4, Rig(step=2e-4))
    result = fitted(leg, trials, curves=curves)
    for j, name in enumerate(NAMES):
        joint = result.joints[name]
        assert joint.spring_rate.value == pytest.approx(SPRING[j], rel=0.01)
        assert (
            joint.spring_rate.low < SPRING[j] < joint.spring_rate.high
            or abs(SPRING[j] / joint.spring_rate.value - 1) < 2e-3
        )  # type: ignore[operator]
        assert np.degrees(joint.free_angle.value) == pytest.approx(FREE_ANGLE[j], abs=0.2)
        assert (joint.damper_rate, joint.damper) == (None, "curve")
        assert result.leg.joints[j].damper == Damper(curve=curves[name])
    assert not result.warnings
    linear = fitted(leg, trials)
    assert any(text.startswith("knee: the residual is") for text in linear.warnings)


def test_held_out_trials_are_scored_with_the_leg_held_fixed() -> None:
    result = fitted(LEG, TRIALS)
    generator = np.random.default_rng(0)
    held = recorded(LEG, [release(LEG, (-12, 26, -20), generator), release(LEG, (10, 30, 15), generator)])
    scored = score(result, held)
    np.testing.assert_allclose(np.degrees(root_mean_square(held, scored.predictions)), 0.1, rtol=0.08)
    np.testing.assert_allclose([local.shift for local in scored.locals], 0.0, atol=1e-9)
    stiff = replace(result, leg=robot(1.3 * SPRING))
    worse = np.degrees(root_mean_square(held, score(stiff, held).predictions))
    assert worse.min() > 0.2


def test_one_trial_is_fitted_and_reported_without_a_spread() -> None:
    result = fitted(LEG, TRIALS[4:5])
    assert np.abs(errors(result, LEG).scores).max() < WITHIN
    assert (result.free_angle, result.free_angle_why) == ("common", "a single trial shows no spread")


def test_trials_with_locked_joints_tilt_and_load_are_fitted_together() -> None:
    generator = np.random.default_rng(11)
    trials = [
        release(LEG, RELEASES[0], generator, locked=("hip",), name="hip held"),
        release(LEG, RELEASES[1], generator, locked=("knee", "ankle"), name="only the hip"),
        release(LEG, RELEASES[2], generator, tip_mass=0.05, name="loaded"),
        release(LEG, RELEASES[4], generator, tilt=0.3, name="tilted"),
    ]
    result = fitted(LEG, trials)
    assert np.abs(errors(result, LEG).scores).max() < WITHIN
    assert np.isnan(result.trials[0].rms[0])
    assert set(result.trials[1].characteristics) == {"hip"}


def test_the_fit_is_bitwise_repeatable() -> None:
    def numbers(result: FitResult) -> list[float]:
        return [joint.spring_rate.value for joint in result.joints.values()]

    assert numbers(fitted(LEG, TRIALS[:3])) == numbers(fitted(LEG, TRIALS[:3]))
