"""The thesis' methods for springs and dampers: costs, simplex, swarm, and their options in a project."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
import pytest

from fit.simulated_legs import DAMPER, FREE_ANGLE, SPRING, Rig, bare, errors, recorded, release, releases, robot
from synth.errors import UserError
from synth.files.project_options import FitOptions as Choice
from synth.fit.costs import Cost, emphasise_transient, summed_differences
from synth.fit.fit_options import LegFitOptions
from synth.fit.methods import _assemble_result, fit_by, require_method, search_of
from synth.fit.rate_search import Bounds, order_of
from synth.fit.recordings import recordings
from synth.fit.simplex import simplex
from synth.fit.swarm import INERTIA, ITERATIONS, OWN, PARTICLES, SOCIAL, swarm
from synth.motion.characteristics import Characteristics, characteristics
from synth.swing.leg_model import Leg

LEG = robot()
RECORDINGS = recorded(LEG, releases(LEG, 4, Rig(noise=0.05, rate=250.0), 3))
TRUTH = np.array([SPRING, DAMPER])


def rosenbrock(points: np.ndarray) -> np.ndarray:
    return np.asarray(100 * (points[1] - points[0] ** 2) ** 2 + (1 - points[0]) ** 2)


def test_the_simplex_finds_rosenbrocks_valley_and_stays_within_bounds() -> None:
    found = simplex(rosenbrock, np.array([-1.2, 1.0]), np.array([-3.0, -3.0]), np.array([3.0, 3.0]))
    assert found.point == pytest.approx([1.0, 1.0], abs=1e-3)
    assert found.iterations < 150  # Nelder and Mead's own took some 80 to 100
    held = simplex(rosenbrock, np.array([-1.2, 1.0]), np.array([-3.0, -3.0]), np.array([0.5, 3.0]))
    assert held.point == pytest.approx([0.5, 0.25], abs=1e-3)  # the least of the valley on the edge


def test_the_swarm_has_the_published_coefficients_and_is_seeded() -> None:
    assert (PARTICLES, ITERATIONS, INERTIA, OWN, SOCIAL) == (20, 100, 0.8, 0.1, 0.1)
    low, high = np.zeros(2), np.full(2, 4.0)
    widths: list[int] = []

    def cost(points: np.ndarray) -> np.ndarray:
        widths.append(points.shape[1])
        assert np.all((points >= 0.0) & (points <= 4.0))
        return rosenbrock(points)

    first = swarm(cost, np.array([3.0, 3.0]), low, high, seed=5)
    assert set(widths) == {20}
    assert len(widths) == 101
    assert first.cost <= float(rosenbrock(np.array([[3.0], [3.0]]))[0])
    again, other = (swarm(rosenbrock, np.array([3.0, 3.0]), low, high, seed=seed) for seed in (5, 6))
    assert np.array_equal(first.point, again.point)
    assert not np.array_equal(first.point, other.point)
    rounded = swarm(rosenbrock, np.array([3.0, 3.0]), low, high, seed=5, decimals=1)
    assert rounded.point * 10 == pytest.approx(np.round(rounded.point * 10))


def test_costs_are_minimal_at_the_truth_and_rise_at_the_changed_joint() -> None:
    for name in ("trajectory", "transient", "characteristics"):
        search = search_of(bare(LEG), RECORDINGS, Cost(name, tuple(RECORDINGS), "equal"))
        rates = np.repeat(TRUTH[:, :, None], 4, axis=2)
        for j in range(3):
            rates[0, j, j + 1] *= 1.5
        costs = search.by_joint(rates)
        assert costs.sum(axis=1).argmin() == 0, name
        for j in range(3):
            assert costs[j + 1, j] > costs[0, j], (name, j)


def test_the_transient_cost_weighs_the_first_swing_tenfold() -> None:
    (thin, *_), (full, *_) = emphasise_transient(RECORDINGS), RECORDINGS
    early = full.time <= 0.2
    assert np.array_equal(thin.counts[early], full.counts[early])
    assert thin.counts[~early].sum() == pytest.approx(0.1 * full.counts[~early].sum(), rel=0.02)


def test_a_characteristic_of_only_one_curve_costs_one() -> None:
    time = np.linspace(0, 2, 400)
    ringing = characteristics(time, np.exp(-2 * time) * np.cos(12 * time))
    creeping = characteristics(time, np.exp(-5 * time))
    assert ringing.damping_ratio is not None
    assert creeping.damping_ratio is None
    assert summed_differences(ringing, ringing) == 0.0
    assert ringing.rise_time is not None
    assert creeping.rise_time is not None
    assert summed_differences(ringing, creeping) == pytest.approx(
        2.0 + abs(creeping.rise_time / ringing.rise_time - 1.0)
    )
    slower = Characteristics(1.0, 2 * ringing.rise_time, ringing.damping_ratio, None, None, None, "valid")
    assert summed_differences(ringing, slower, ("rise_time", "damping_ratio")) == pytest.approx(1.0)


def test_piecewise_search_changes_one_joint_at_a_time_knee_hip_ankle() -> None:
    assert order_of(3) == (1, 0, 2)
    assert (order_of(1), order_of(2)) == ((0,), (1, 0))
    search = search_of(bare(LEG), RECORDINGS, Cost("trajectory", tuple(RECORDINGS)))
    start = TRUTH * np.array([[1.3, 0.8, 1.2], [0.8, 1.3, 0.9]])
    rates, stages = search.piecewise(start, Bounds.around(start), order=(1,))
    assert len(stages) == 1
    assert np.array_equal(rates[:, [0, 2]], start[:, [0, 2]])
    assert not np.any(rates[:, 1] == start[:, 1])


@pytest.mark.parametrize(("method", "cost"), [("piecewise", "trajectory"), ("swarm", "transient")])
def test_thesis_methods_approach_the_truth_and_report_least_squares_too(method: str, cost: str) -> None:
    options = LegFitOptions(free_angle="per_trial")
    result = fit_by(bare(LEG), RECORDINGS, options, Choice(method=method, cost=cost))  # type: ignore[arg-type]
    missed = errors(result, LEG)
    assert np.abs(np.r_[missed.spring, missed.damper]).max() < 0.25
    assert np.degrees(np.abs(missed.angle)).max() < 2.0
    assert (result.method, result.cost) == (method, cost)
    assert result.as_json()["cost"] == cost
    assert any("least squares on the same recordings" in text for text in result.warnings)
    assert any(text.startswith("hip: compared with least squares k ") for text in result.warnings)


def shifted(leg: Leg, angle: float) -> Leg:
    """With all free angles turned, rad."""
    springs = {joint.name: joint.spring for joint in leg.joints if joint.spring is not None}
    changes = {
        name: {"spring": replace(spring, free_angle=spring.free_angle + angle)} for name, spring in springs.items()
    }
    return leg.with_joints(**changes)


@pytest.mark.parametrize("spread", [0.0, 3.0])
def test_a_search_beside_the_optimum_invents_no_spread(spread: float) -> None:
    """Trials that end in motion: the poses of their ends were the spread, by which a held-out trial fitted itself."""
    rig = Rig(noise=0.05, rate=250.0, duration=0.6)
    trials = [
        releases(shifted(LEG, float(np.radians(spread * way))), number, rig, 1, number)[0]
        for number, way in enumerate((-1.0, 1.0, -1.0, 1.0))
    ]
    some = recorded(LEG, trials)
    search = search_of(bare(LEG), some, Cost("trajectory", tuple(some), "equal"))
    found = _assemble_result(search, TRUTH * 1.15, LegFitOptions(free_angle="per_trial"), len(some))
    for joint in found.joints.values():
        seen = np.degrees(joint.free_angle_spread.value)
        assert seen < 0.1 if spread == 0.0 else 1.0 < seen < 7.0


def test_least_squares_by_the_transient_reports_residuals_over_all_samples() -> None:
    found = fit_by(bare(LEG), RECORDINGS, LegFitOptions(), Choice(cost="transient"))
    assert found.cost == "transient"
    assert np.abs(errors(found, LEG).spring).max() < 0.02
    assert np.isfinite(found.trials[0].measured).all()
    # 0.05 deg of noise and the rounding to 8192 counts
    assert np.degrees(list(found.rms.values())) == pytest.approx(0.0516, rel=0.1)


def test_a_locked_joint_is_left_out_of_every_cost() -> None:
    generator = np.random.default_rng(8)
    trials = [
        release(LEG, (0, 25, 18), generator, Rig(rate=250.0), name="held", locked=("hip",)),
        release(LEG, (12, -22, 18), generator, Rig(rate=250.0), name="free"),
    ]
    recordings = recorded(LEG, trials)
    for name in ("trajectory", "characteristics"):
        search = search_of(bare(LEG), recordings, Cost(name, tuple(recordings), "equal"))
        assert np.all(np.isfinite(search.by_joint(TRUTH[:, :, None])))
        held = search_of(bare(LEG), recordings[:1], Cost(name, tuple(recordings[:1]), "equal"))
        assert held.by_joint(TRUTH[:, :, None])[0, 0] == 0.0


def test_rest_angles_hold_the_final_pose_of_each_trial() -> None:
    leg = robot(SPRING * 3, DAMPER)  # has come to rest within the second
    recordings = recorded(leg, releases(leg, 2, Rig(noise=0.0, counts=0), 2))
    search = search_of(bare(leg), recordings, Cost("trajectory", tuple(recordings)))
    rests = search.rests(3 * SPRING[:, None])[:, :, 0]
    assert np.degrees(leg.to_measured(rests)) == pytest.approx(np.tile(FREE_ANGLE, (2, 1)), abs=0.6)


@pytest.mark.parametrize("mode", ["common", "per_trial"])
def test_a_locked_joint_tells_nothing_of_its_free_angle(mode: Literal["common", "per_trial"]) -> None:
    leg = robot(SPRING * 3, DAMPER)
    generator, rig = np.random.default_rng(4), Rig(noise=0.0, counts=0)
    aways = ((40, 25, 18), (12, -22, 18), (43, -24, 21))  # deg; the hip is clamped far from its rest in two of three
    trials = [
        release(leg, away, generator, rig, name=f"release {k}", locked=("hip",) if k != 1 else ())
        for k, away in enumerate(aways)
    ]
    recordings = recorded(leg, trials)
    search = search_of(bare(leg), recordings, Cost("trajectory", tuple(recordings)), common=mode == "common")
    middle, own = search.locals(3 * SPRING)
    assert np.degrees(leg.to_measured(middle)) == pytest.approx(FREE_ANGLE, abs=0.6)  # 40 deg off
    assert own[0].shift[0] == own[2].shift[0] == 0.0
    found = fit_by(bare(leg), recordings, LegFitOptions(free_angle=mode), Choice(method="piecewise"))
    assert np.degrees(found.joints["hip"].free_angle.value) == pytest.approx(FREE_ANGLE[0], abs=0.6)
    assert found.joints["hip"].spring_rate.value == pytest.approx(3 * SPRING[0], rel=0.05)


def test_rest_angles_allow_for_a_known_torque() -> None:
    leg, torque = robot(SPRING * 3, DAMPER), np.array([0.0, 0.3, 0.0])  # N m, turns the knee by some 4 deg

    def constant(rotation: np.ndarray, rate: np.ndarray) -> np.ndarray:
        return torque

    trial = release(leg, (12, -22, 18), np.random.default_rng(4), Rig(noise=0.0, counts=0), extra_torque=constant)
    (recording,) = recorded(leg, [trial])
    driven = replace(recording, known_torque=(np.array([0.0, 1.0]), np.array([torque, torque])))
    search = search_of(bare(leg), [driven], Cost("trajectory", (driven,)))
    rests = search.rests(3 * SPRING[:, None])[0, :, 0]
    assert np.degrees(leg.to_measured(rests)) == pytest.approx(FREE_ANGLE, abs=0.6)


@pytest.mark.parametrize(
    ("choice", "beside", "said", "key"),
    [
        (Choice(cost="characteristics"), {}, "are discontinuous", "fit.cost"),
        (Choice(method="swarm"), {"static": True}, "would ignore it", "static"),
        (Choice(method="piecewise"), {"prior": True}, "would ignore it", "prior"),
        (Choice(method="swarm", intervals="bootstrap"), {}, "not swarm", "fit.intervals"),
    ],
)
def test_conflicting_options_are_refused(choice: Choice, beside: dict[str, bool], said: str, key: str) -> None:
    with pytest.raises(UserError) as raised:
        require_method(choice, "fit.yaml", **beside)
    (problem,) = raised.value.problems
    assert said in problem.text
    assert problem.key == key


def test_every_other_combination_is_allowed() -> None:
    for method in ("least_squares", "piecewise", "swarm"):
        for cost in ("trajectory", "transient", "characteristics"):
            if (method, cost) != ("least_squares", "characteristics"):
                require_method(Choice(method=method, cost=cost), "fit.yaml")  # type: ignore[arg-type]


@pytest.mark.parametrize("method", ["piecewise", "swarm"])
def test_a_joint_locked_in_every_trial_is_left_out(method: Literal["piecewise", "swarm"]) -> None:
    """Its rate of 0 was divided by, after the whole search."""
    generator, rig = np.random.default_rng(4), Rig(noise=0.05, rate=250.0)
    held = [release(LEG, (0.0, *away), generator, rig, locked=("hip",)) for away in ((20.0, -15.0), (-10.0, 20.0))]
    read = recordings(bare(LEG), held, sought=("knee", "ankle"))
    result = fit_by(bare(LEG), read, LegFitOptions(release="recorded"), Choice(method=method, cost="trajectory"))
    assert not result.joints["hip"].estimated
    for j, name in enumerate(LEG.joint_names[1:], start=1):
        assert result.joints[name].spring_rate.value == pytest.approx(SPRING[j], rel=0.05)
    compared = [text for text in result.warnings if "compared with least squares" in text]
    assert not any("hip" in text for text in compared)
    assert len(compared) == len(LEG.joints) - 1
