"""Dry friction, quadratic damping and cubic springs, found where a linear leg does not explain a motion."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fit.test_driven_start import joint_tests
from robustness.laws import held
from robustness.random_legs import TOLERANCE_OF_LINKS, Case, random_case, with_law
from synth import FitSettings, fit
from synth.commands.answers import fit_text
from synth.files.leg_file import read_leg
from synth.files.static_points_file import StaticPoint
from synth.files.trial_list import Trial, read_trials
from synth.fit.estimate import cut_or_law, fit_leg
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_problem import model_of
from synth.fit.fit_result import FitResult
from synth.fit.joint_laws import LAWS, AnotherLaw
from synth.fit.law_search import LawSearch
from synth.fit.least_squares import FitStart, Stage
from synth.fit.model_error import ModelError
from synth.fit.recordings import recordings
from synth.fit.refinement import refine
from synth.fit.starts import first_locals, weak_form_start
from synth.fit.uncertainty import sample_scatter
from synth.swing.leg_model import Joint, Leg, Link
from synth.validation.thesis_data import read_lab_data

LAB, DOUBLE = (Path(__file__).resolve().parents[3] / "shared" / name for name in ("aarl", "double_pendulum"))
AUTO = LegFitOptions(release="free", laws="auto", tolerance=TOLERANCE_OF_LINKS)
SIZE = {"coulomb_friction": "torque", "quadratic_damping": "coefficient", "hardening_spring": "stiffening"}


def fitted(case: Case, **changes: object) -> FitResult:
    """As ``synth fit`` does, from links that are off by their tolerances."""
    return fit_leg(case.off, recordings(case.off, case.trials), replace(AUTO, **changes))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("effect", "seed"),
    [
        ("coulomb_friction", 980043),
        ("quadratic_damping", 980049),
        ("hardening_spring", 980011),
        *(pytest.param("coulomb_friction", seed, marks=pytest.mark.slow) for seed in (980054, 980056)),
        *(pytest.param("quadratic_damping", seed, marks=pytest.mark.slow) for seed in (980015, 980023)),
        pytest.param("hardening_spring", 980056, marks=pytest.mark.slow),
    ],
)
def test_a_law_is_found_and_the_rates_are_those_of_springs_and_dampers(effect: str, seed: int) -> None:
    case = with_law(random_case(seed), effect)
    result, linear = fitted(case), fitted(case, laws="linear")
    assert result.law["effect"] == effect
    assert result.law["explains"] > 0.8
    for name, size in result.law[SIZE[effect]].items():
        truth = next(joint for joint in case.leg.joints if joint.name == name).effects[effect][SIZE[effect]]
        assert size["value"] == pytest.approx(truth, rel=0.5)
    inside, count = held(result, case)
    assert inside >= 0.6 * count
    truth = np.log(case.leg.spring_rate)
    off = [
        np.abs(np.log([j.spring_rate.value for j in each.joints.values()]) - truth).max() for each in (result, linear)
    ]
    assert off[0] < max(0.5 * off[1], 0.1)
    assert effect in result.leg.joints[0].effects or len(result.law[SIZE[effect]]) < len(case.leg.joints)
    assert any("is part of the fitted leg" in text for text in result.warnings)


def rubbing(friction: float, damping: float, starts: tuple[float, ...]) -> tuple[Leg, list[Trial]]:
    """One joint of 2 N m/rad without gravity, let go at ``starts`` deg; half-swings in closed form until it sticks."""
    inertia, stiffness, time = 8.76e-3, 2.0, np.arange(0.0, 3.0, 0.005)
    decay = 0.5 * damping / inertia
    frequency = np.sqrt(stiffness / inertia - decay**2)
    half, shift = np.pi / frequency, friction / stiffness
    generator, trials = np.random.default_rng(100), []
    for number, start in enumerate(starts):
        angle, at, begun = np.zeros(len(time)), math.radians(start), 0.0
        while abs(at) > shift:
            since, about = time - begun, math.copysign(shift, at)
            wave = np.cos(frequency * since) + decay / frequency * np.sin(frequency * since)
            angle = np.where(since >= 0.0, about + (at - about) * np.exp(-decay * since) * wave, angle)
            at, begun = about - (at - about) * math.exp(-decay * half), begun + half
        angle = np.where(time >= begun, at, angle)
        noisy = angle + math.radians(30.0) + math.radians(0.05) * generator.normal(size=len(time))
        trials.append(Trial(f"t{number}", time, noisy[:, None]))
    link = Link(0.3, 0.4, 0.12, inertia - 0.4 * 0.12**2)
    return Leg("leg", (Joint("knee", link),), gravity=0.0), trials


@pytest.mark.parametrize(
    ("friction", "damping", "starts"),
    [
        (0.2, 0.03, (20, -35, 50, -15, 30)),
        pytest.param(0.08, 0.005, (20, -35, 50, -15, 30), marks=pytest.mark.slow),
        (0.08, 0.03, (20, -35, 50)),
    ],
)
def test_strong_friction_of_a_joint_is_no_hand(friction: float, damping: float, starts: tuple[float, ...]) -> None:
    """From the fit without it, steps towards the friction ended far off, and the start was cut or its rates wrong."""
    leg, trials = rubbing(friction, damping, starts)
    result = fit_leg(leg, recordings(leg, trials), replace(AUTO, tolerance=None))
    assert result.cut == 0.0
    assert result.law["torque"]["knee"]["value"] == pytest.approx(friction, rel=0.01)
    knee = result.joints["knee"]
    assert knee.damper_rate is not None
    assert knee.spring_rate.value == pytest.approx(2.0, rel=0.005)
    assert knee.damper_rate.value == pytest.approx(damping, rel=0.02)


def bending(cubic: float, starts: tuple[float, ...]) -> tuple[Leg, list[Trial]]:
    """The joint of ``rubbing`` with a torque of ``cubic`` N m/rad^3 beside its spring; integrated by ``scipy``."""
    inertia, stiffness, damping, rest, time = 8.76e-3, 2.0, 0.05, math.radians(30.0), np.arange(0.0, 1.5, 0.005)
    generator, trials = np.random.default_rng(100), []

    def slope(_: float, state: np.ndarray) -> list[float]:
        turned, rate = state
        return [rate, -(stiffness * turned + cubic * turned**3 + damping * rate) / inertia]

    for number, start in enumerate(starts):
        found = solve_ivp(slope, (0.0, time[-1]), [math.radians(start), 0.0], t_eval=time, rtol=1e-9, atol=1e-10)
        noisy = found.y[0] + rest + math.radians(0.05) * generator.normal(size=len(time))
        trials.append(Trial(f"t{number}", time, noisy[:, None]))
    return Leg("leg", (Joint("knee", Link(0.3, 0.4, 0.12, inertia - 0.4 * 0.12**2)),), gravity=0.0), trials


@pytest.mark.parametrize("cubic", [1.0, pytest.param(-1.0, marks=pytest.mark.slow)])
def test_a_spring_that_hardens_or_softens_is_no_hand(cubic: float) -> None:
    """An external torque at first was asserted of five such legs of five, and the rate missed its interval."""
    leg, trials = bending(cubic, (20, -35, 12))
    result = fit_leg(leg, recordings(leg, trials), replace(AUTO, tolerance=None))
    assert result.cut == 0.0
    size, rate = result.law["stiffening"]["knee"], result.joints["knee"].spring_rate
    low, high = size["interval90"]
    assert low < cubic < high
    assert high - low < 0.2
    assert rate.low is not None
    assert rate.high is not None
    assert rate.low < 2.0 < rate.high
    assert result.leg.joints[0].effects["hardening_spring"]["stiffening"] == pytest.approx(size["value"])
    assert "grows with the cube of deflection" in result.warnings[0]


def test_a_static_point_far_out_agrees_with_a_spring_that_hardens() -> None:
    """Only the spring's rate was compared with it: 20 % of its torque were missing."""
    leg, trials = bending(1.0, (20, -35, 12))
    turned = math.radians(40.0)
    point = StaticPoint("far", np.array([turned + math.radians(30.0)]), np.array([2.0 * turned + turned**3]), (0,),
                        torque_error=0.005, angle_error=math.radians(0.1))  # fmt: skip
    result = fit_leg(leg, recordings(leg, trials), replace(AUTO, tolerance=None, static=(point,)))
    (judged,) = result.static
    assert result.law["effect"] == "hardening_spring"
    assert not judged.left_out
    assert abs(judged.deviations) < 2.0
    assert judged.fitted == pytest.approx(2.0 * turned + turned**3, rel=0.01)


def test_a_search_weighs_every_trial_by_its_own_noise() -> None:
    """With ``weight: amplitude`` trials have different ones: all were weighed by the first, unlike in the refits."""
    leg, trials = rubbing(0.08, 0.03, (20, -35, 50))
    made, options = recordings(leg, trials), replace(AUTO, weight="amplitude", tolerance=None)
    model = model_of(leg, recordings=made)
    start = FitStart(weak_form_start(model, made, options).values, first_locals(made))
    stage = refine(model, made, start, options.weight, np.zeros(1), rounds=1)
    assert np.ptp(stage.weights.noise) > 0.1 * stage.weights.noise.mean()
    search = LawSearch(LAWS[0], leg, made, options, stage, sample_scatter(made))
    point = search.point(np.zeros(1))
    assert point is not None
    off = [
        (prediction - one.rotation) / noise
        for prediction, one, noise in zip(point.solution.predictions, made, stage.weights.noise, strict=True)
    ]
    np.testing.assert_allclose(point.residual, np.concatenate(off).ravel())
    swapped = LawSearch(LAWS[0], leg, made[::-1], options, backwards(stage), sample_scatter(made))
    np.testing.assert_allclose(swapped.expected, search.expected)


def backwards(stage: Stage) -> Stage:
    """The stage with its trials in the opposite order."""
    solution = replace(stage.solution, locals=stage.solution.locals[::-1])
    return Stage(solution, replace(stage.weights, noise=stage.weights.noise[::-1]))


# Each leg and each time of the hand once; the other pairs with ``make test-slow``.
@pytest.mark.parametrize(
    ("seed", "driven"),
    [
        (980043, 0.15),
        (980033, 0.25),
        (980054, 0.15),
        pytest.param(980043, 0.25, marks=pytest.mark.slow),
        pytest.param(980033, 0.15, marks=pytest.mark.slow),
        pytest.param(980054, 0.25, marks=pytest.mark.slow),
    ],
)
def test_a_hand_is_no_law(seed: int, driven: float) -> None:
    case = random_case(seed, replace(random_case(seed).recorder, driven=driven))
    result = fitted(case)
    assert result.law == {}
    assert result.cut > 0.1


def test_a_law_that_leaves_no_more_than_a_cut_is_said_beside_it() -> None:
    """Of 12 legs that rub one is cut, and this is said there; of 12 that a hand drives it is said at none."""
    case = random_case(980043, replace(random_case(980043).recorder, driven=0.15))
    cut, dry = fitted(case), LAWS[0]
    none = ModelError(np.zeros((3, 0)), "")
    rms = np.array(list(cut.rms.values()))
    law = AnotherLaw(dry, case.off, np.array([0.02]), np.array([0.003]), none, 0.3, np.zeros(3), rms)
    model = model_of(case.off, recordings=recordings(case.off, case.trials))
    told: list[ModelError] = []

    def again(error: ModelError) -> FitResult:
        told.append(error)
        return cut

    assert cut_or_law(model, cut, replace(law, rms=1.2 * rms), again) is cut
    assert cut_or_law(model, cut, None, again) is cut
    assert cut_or_law(model, replace(cut, law={"effect": "coulomb_friction"}), law, again).law
    assert not told
    assert cut_or_law(model, cut, law, again) is cut
    assert "hip 0.02 +- 0.0049 N*m. These recordings do not tell which" in told[0].sentence


def test_intervals_hold_for_the_law_too_where_the_recordings_do_not_tell() -> None:
    """Of 40 legs that rub little, recorded by tracked points, 20 are cut: 4 of their 40 damper intervals held it."""
    leg, trials = rubbing(0.01, 0.03, (20, -35, 28))
    generator, noisy = np.random.default_rng(0), []
    for trial in trials:
        lasting = generator.normal(size=300) * np.append(1.0, np.full(299, 0.6))
        for i in range(1, 300):
            lasting[i] += 0.8 * lasting[i - 1]
        angles = trial.angles[:300] + math.radians(0.2) * lasting[:, None]
        noisy.append(replace(trial, time=trial.time[:300], angles=angles))
    result = fit_leg(leg, recordings(leg, noisy), replace(AUTO, tolerance=None))
    assert result.cut > 0.0
    assert "do not tell which, and the intervals include the difference" in result.warnings[1]
    damper = result.joints["knee"].damper_rate
    assert damper is not None
    assert damper.low is not None
    assert damper.low < 0.03 < damper.value


@pytest.mark.slow  # one leg of ``make laws``
def test_a_diverging_neighbour_ends_the_search_and_not_the_fit() -> None:
    """With more friction a joint would stick; the leg was refused as one whose motion diverges."""
    case = random_case(985036, replace(random_case(985036).recorder, driven=0.15))
    assert fitted(case).law == {}


@pytest.mark.parametrize(
    "seed", [980003, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (980014, 980033)), 980043]
)
def test_a_leg_of_springs_and_linear_dampers_has_no_other_law(seed: int) -> None:
    case = random_case(seed, replace(random_case(seed).recorder, driven=0.0))
    assert fitted(case).law == {}


@pytest.mark.skipif(not LAB.is_dir(), reason="the lab's recordings (../shared/aarl) are not here")
def test_the_labs_recordings_have_neither_law() -> None:
    """They lack something, or several things: neither law explains four fifths of what is left."""
    data = read_lab_data(LAB)
    robot = data.trials(data.built, joint_tests())
    for leg, made in ((data.rat, data.releases()), (data.built, robot)):
        assert fit_leg(leg, made, AUTO).law == {}


@pytest.mark.skipif(not DOUBLE.is_dir(), reason="../shared/double_pendulum is not here")
@pytest.mark.parametrize("half", [0, 1])
def test_a_double_pendulums_small_swings_have_neither_law(half: int) -> None:
    leg = read_leg(DOUBLE / "double_pendulum.leg.yaml")
    trials = read_trials([f"trials/val_0{half}.csv", f"trials/val_0{half + 2}.csv"], DOUBLE, leg)
    assert fit_leg(leg, recordings(leg, trials), AUTO).law == {}


def test_a_stated_friction_is_kept_and_none_is_added() -> None:
    case = with_law(random_case(980054), "coulomb_friction")
    found = fitted(case)
    effects = {joint.name: {"effects": joint.effects} for joint in case.leg.joints}
    given = case.off.with_joints(**effects)
    stated = fit_leg(given, recordings(given, case.trials), AUTO)
    assert stated.law == {}
    assert [joint.effects for joint in stated.leg.joints] == [joint.effects for joint in case.leg.joints]
    rates = [[joint.spring_rate.value for joint in each.joints.values()] for each in (found, stated)]
    np.testing.assert_allclose(rates[0], rates[1], rtol=0.05)


def test_the_law_is_in_the_files_and_can_be_switched_off(tmp_path: Path) -> None:
    case = with_law(random_case(980043), "coulomb_friction")
    found = fit(case.off, case.trials, FitSettings(tolerance=TOLERANCE_OF_LINKS))
    found.write(tmp_path)
    document = json.loads((tmp_path / "fit.json").read_text())
    law = found.result.law
    assert document["law"]["effect"] == law["effect"] == "coulomb_friction"
    assert document["law"]["torque"]["hip"]["value"] == pytest.approx(law["torque"]["hip"]["value"], rel=1e-6)
    (written,) = tmp_path.glob("*.leg.yaml")
    torque = read_leg(written).joints[0].effects["coulomb_friction"]["torque"]
    assert torque == pytest.approx(document["law"]["torque"]["hip"]["value"], rel=1e-3)
    assert "coulomb friction: hip 0.000" in fit_text(document)
    assert "with dry friction at the hip the model explains the motion" in (tmp_path / "report.html").read_text()
    assert "law" not in fit(case.off, case.trials, FitSettings(laws="linear")).result.as_json()
