"""Intervals include the tolerances of the leg file's links: against a closed form and against refits."""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np
import pytest

from fit.simulated_legs import Rig, bare, recorded, release, releases, robot
from synth.estimation.intervals import NORMAL90
from synth.files.static_points_file import StaticPoint
from synth.files.tolerance import Tolerance
from synth.fit import report_fit
from synth.fit.draws import draws
from synth.fit.estimate import fit_leg
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_problem import model_of
from synth.fit.fit_result import FitResult
from synth.fit.least_squares import FitStart, Stage, Weights, solve
from synth.fit.link_errors import LinkErrors, link_errors
from synth.fit.model_error import ModelError
from synth.fit.random_streams import Stream
from synth.fit.recordings import recordings
from synth.fit.starts import first_locals
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring
from synth.swing.tolerances import LINK_QUANTITIES, QUANTITIES, Tolerances

EXACT = Tolerance(length=0.0, mass=0.0, com=0.0, inertia=0.0)
MOVED = 0.01


def estimates(result: FitResult) -> np.ndarray:
    """Log spring rates, free angles rad in q's sense, log damper rates."""
    joints = list(result.joints.values())
    dampers = [joint.damper_rate.value for joint in joints if joint.damper_rate is not None]
    angles = result.leg.sign * np.array([joint.free_angle.value for joint in joints])
    return np.concatenate([np.log([joint.spring_rate.value for joint in joints]), angles, np.log(dampers)])


def sensitivity(leg: Leg, result: FitResult, trials: list, static: tuple[StaticPoint, ...] = ()) -> LinkErrors:
    """For a unit of each logarithm, at the fitted leg."""
    made = recordings(leg, trials)
    model = model_of(leg, static=static)
    values = estimates(result)
    n = len(leg.joints)
    values[n : 2 * n] = leg.to_rotation(np.array([joint.free_angle.value for joint in result.joints.values()]))
    weights = Weights(np.tile([result.clipped_rms[name] for name in leg.joint_names], (len(made), 1)), np.zeros(n))
    solution = solve(model, made, FitStart(values, first_locals(made)), weights)
    found = link_errors(model, made, Stage(solution, weights), np.ones((4, n)), static)
    assert found is not None
    return found


def test_link_sensitivity_of_a_pendulum_equals_the_closed_form() -> None:
    """(I + m c^2) q'' + b q' + (k + m g c) q = 0: the trials fix b and k + m g c over the inertia about the joint."""
    mass, com, inertia, rate = 0.5, 0.1, 2e-3, 1.2
    link = Link(0.2, mass, com, inertia)
    joint = Joint("hip", link, radians(90), 1, spring=Spring(rate, radians(90)), damper=Damper(0.01))
    leg = Leg("pendulum", (joint,))
    generator = np.random.default_rng(3)
    trials = [release(leg, [a], generator, Rig(noise=0.002, duration=2.0)) for a in (2.0, -3.0)]
    given = bare(leg)
    found = sensitivity(given, fit_leg(given, recordings(given, trials), LegFitOptions(free_angle="common")), trials)
    about = inertia + mass * com**2
    stiff, weight = rate + mass * 9.81 * com, mass * 9.81 * com
    expected = {
        "length": (0.0, 0.0),
        "mass": ((mass * com**2 / about * stiff - weight) / rate, mass * com**2 / about),
        "com": ((2 * mass * com**2 / about * stiff - weight) / rate, 2 * mass * com**2 / about),
        "inertia": (inertia / about * stiff / rate, inertia / about),
    }
    assert [quantity for _, quantity in found.names] == list(LINK_QUANTITIES)
    for column, (_, quantity) in enumerate(found.names):
        moved = found.considered.sensitivity[[0, 2], column]
        assert moved == pytest.approx(expected[quantity], abs=0.015)


@pytest.mark.parametrize("seed", range(4))
def test_on_the_ridge_of_an_overdamped_joint_rates_scale_with_mass_and_inertia(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Both scaled by a factor scale k and b by it, exactly. Information from the step before gave +220 and -128."""
    seen: list[LinkErrors] = []

    def spied(*given: object, **more: object) -> LinkErrors | None:
        found = link_errors(*given, **more)  # type: ignore[arg-type]
        seen.extend([found] if found is not None else [])
        return found

    monkeypatch.setattr(report_fit, "link_errors", spied)
    link = Link(0.2, 0.4, 0.1, 1.5e-3)
    joint = Joint("knee", link, radians(100), -1, spring=Spring(3.0, radians(83)), damper=Damper(1.5))
    generator = np.random.default_rng(seed)
    leg, rig = Leg("slow", (joint,)), Rig(noise=0.1, duration=1.0)
    trials = [release(leg, [away], generator, rig) for away in (-46.0, 29.0, -23.0)]
    fit_leg(bare(leg), recordings(bare(leg), trials), LegFitOptions(tolerance=Tolerance(length=0.0, com=0.0)))
    assert seen
    for found in seen:
        assert [quantity for _, quantity in found.names] == ["mass", "inertia"]
        both = (found.considered.sensitivity / found.deviation).sum(axis=1)
        assert both[[0, 2]] == pytest.approx([1.0, 1.0], abs=0.2)  # less by the weak prior of the rates


def test_first_predictions_move_with_the_links_as_refits_do() -> None:
    leg = robot()
    trials, given = releases(leg, 3)[:2], bare(leg)
    made = recordings(given, trials)
    values, n = estimates(fit_leg(given, made, LegFitOptions(free_angle="common"))), len(leg.joints)
    values[n : 2 * n] = leg.to_rotation(leg.sign * values[n : 2 * n])
    weights = Weights(np.full((len(made), n), 1e-3), np.zeros(n))

    def refitted(given: Leg) -> Stage:
        start = FitStart(values, first_locals(made))
        return Stage(solve(model_of(given), made, start, weights, tolerance=1e-6), weights)

    found = link_errors(model_of(given), made, refitted(given), np.full((4, n), MOVED), until=0.2)
    assert found is not None
    for column in (3, 7, 11):  # mass of hip, com of knee, inertia of ankle
        ends = []
        for sign in (1.0, -1.0):
            x = np.zeros(3 * len(QUANTITIES))
            x[column] = sign * MOVED
            ends.append(refitted(Tolerances(np.ones((len(QUANTITIES), 3))).leg(given, x)).solution.predictions)
        for trial, recording in enumerate(made):
            first = recording.time < 0.2
            moved = (ends[0][trial] - ends[1][trial])[first] / 2
            assert found.first[trial][:, :, column] == pytest.approx(moved, abs=0.1 * np.abs(moved).max() + 1e-7)


def test_link_sensitivity_of_a_leg_equals_refits_with_static_points() -> None:
    leg = robot()
    trials, given = releases(leg, 3)[:3], bare(leg)
    point = StaticPoint("held", np.radians([120.0, 150.0, 120.0]), np.array([2.0, 0.0, 0.0]), (0,), torque_error=0.05)
    options = LegFitOptions(free_angle="common", static=(point,))
    found = sensitivity(given, fit_leg(given, recordings(given, trials), options), trials, (point,))
    for column in (3, 4, 6, 11):  # masses of hip and knee, com of hip, inertia of ankle
        ends = []
        for sign in (1.0, -1.0):
            x = np.zeros(3 * len(QUANTITIES))
            x[column] = sign * MOVED
            other = Tolerances(np.ones((len(QUANTITIES), 3))).leg(given, x)
            ends.append(estimates(fit_leg(other, recordings(other, trials), options)))
        refitted = (ends[0] - ends[1]) / (2 * MOVED)
        moved = found.considered.sensitivity[:, column].copy()
        assert moved == pytest.approx(refitted, abs=0.05 * np.abs(refitted).max() + 0.01)


def test_exact_links_keep_the_intervals_and_uncertain_ones_widen_them() -> None:
    leg = robot()
    trials, given = releases(leg, 3), bare(leg)
    made = recordings(given, trials)
    before, exact, wide = (fit_leg(given, made, LegFitOptions(tolerance=t)) for t in (None, EXACT, Tolerance()))
    assert exact.joints == before.joints
    assert exact.sources == ()
    for name, joint in wide.joints.items():
        own = before.joints[name].spring_rate
        assert joint.spring_rate.value == own.value
        assert np.log(joint.spring_rate.high / joint.spring_rate.low) > 2 * np.log(own.high / own.low)
    for source in wide.sources:
        assert sum(source.shares.values()) == pytest.approx(1.0)
        assert 0.0 < source.shares["trials"] < 1.0
    knee = next(s for s in wide.sources if (s.joint, s.quantity) == ("knee", "spring_rate"))
    assert knee.sentence is not None
    assert "leg file's tolerances" in knee.sentence
    one = fit_leg(given, made, LegFitOptions(tolerance=replace(EXACT, joints={"ankle": {"mass": 0.2}})))
    assert {name for s in one.sources for name in s.shares} == {"trials", "mass of the ankle's link"}


def test_draws_spread_as_the_intervals_do() -> None:
    leg = robot()
    given = bare(leg)
    result = fit_leg(given, recorded(leg, releases(leg, 3)), LegFitOptions(tolerance=Tolerance()))
    for j, joint in enumerate(result.joints.values()):
        drawn = np.log([one.spring_rate[j] for one in result.drawn])
        half = 0.5 * np.log(joint.spring_rate.high / joint.spring_rate.low)
        assert 1.645 * drawn.std() == pytest.approx(half, rel=0.3)  # 64 draws: 9 %


@pytest.mark.parametrize("intervals", ["sensitivities", "bootstrap"])
def test_shares_of_an_interval_tell_the_laws_error_from_the_trials(intervals: str) -> None:
    """The half-width is that of the reported interval, and a law's error of 3 % in every rate is named beside noise."""
    leg = robot()
    made = recorded(leg, releases(leg, 1, Rig(0.3, 0, rate=120.0), 2))
    error = ModelError(np.full((9, 1), 0.03), "another law")
    options = LegFitOptions(free_angle="common", tolerance=Tolerance(), intervals=intervals)
    result = fit_leg(bare(leg), made, options, error=error)
    for source in result.sources:
        joint = result.joints[source.joint]
        estimate = {"spring_rate": joint.spring_rate, "damper_rate": joint.damper_rate}.get(source.quantity)
        assert sum(source.shares.values()) == pytest.approx(1.0)
        if estimate is None:
            continue
        assert estimate.low is not None
        assert estimate.high is not None
        half = 0.5 * np.log(estimate.high / estimate.low)
        assert source.half == pytest.approx(np.expm1(half))
        assert source.shares["the leg's law"] == pytest.approx((0.03 * NORMAL90 / half) ** 2)
        assert 0.0 < source.shares["trials"] < 1.0 - source.shares["the leg's law"]


def test_two_independent_errors_are_drawn_independently() -> None:
    """Of 128 pairs of normal numbers a correlation has a deviation of 0.09."""
    drawn = draws(np.zeros(2), np.eye(2), None, None, seed=3)
    beside = ModelError(np.eye(2), "").added_to(drawn, seed=3) - drawn
    np.testing.assert_allclose(beside.std(), 1.0, atol=0.25)
    assert abs(np.corrcoef(drawn.ravel(), beside.ravel())[0, 1]) < 0.4
    assert len({stream.generator(3).normal() for stream in Stream}) == len(Stream)
