"""Joints of any speed: insects and cranes, dampers far stronger than their link, and what a bound says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fit.simulated_legs import Array, bare, robot
from synth.files.trial_list import Trial
from synth.fit.estimate import fit_leg
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_problem import box_of, model_of, unknowns_of
from synth.fit.fit_result import FitResult
from synth.fit.recordings import recordings
from synth.fit.report_fit import at_edges
from synth.motion.time_step import stepped_unit
from synth.remarks import joint_of, severity_of
from synth.swing.chain import compiled_chain, simulate
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

LINK = Link(0.3, 0.4, 0.12, 3e-3)
INERTIA = LINK.inertia + LINK.mass * LINK.com**2
NOISE = np.radians(0.05)


def pendulum(spring: float, damper: float, gravity: float = 9.81) -> Leg:
    """One joint, its free angle 30 deg."""
    knee = Joint("knee", LINK, 0.0, 1, None, Spring(spring, np.radians(30.0)), Damper(damper))
    return Leg("pendulum", (knee,), gravity=gravity)


def swings(leg: Leg, times: Array, starts: Array, torque: Array | None = None) -> list[Trial]:
    """Releases from rest ``starts`` (t, n) deg off the free angles, read with noise; ``torque`` (m, n) acts on q."""
    generator, made = np.random.default_rng(1), []
    for start in np.radians(starts):
        known = None if torque is None else (times, torque)
        angle = leg.to_measured(simulate(leg, leg.rest + start, 0.0 * start, times, tolerance=1e-9, known_torque=known))
        made.append(Trial(f"{len(made)}.csv", times, angle + NOISE * generator.standard_normal(angle.shape)))
    return made


def slowed(leg: Leg, trials: list[Trial], factor: float, **options: object) -> FitResult:
    """The fit of the same recordings on a clock ``factor`` times as slow."""
    slow = replace(bare(leg), gravity=leg.gravity / factor**2)
    made = recordings(slow, [replace(trial, time=trial.time * factor) for trial in trials])
    return fit_leg(slow, made, LegFitOptions(**options))  # type: ignore[arg-type]


def assert_alike(one: FitResult, slow: FitResult, factor: float) -> None:
    """Rates and intervals are those of the slower clock, and so is the beginning of free motion."""
    assert slow.cut == pytest.approx(one.cut * factor)
    for name, joint in one.joints.items():
        other = slow.joints[name]
        for end in ("low", "value", "high"):
            wanted = getattr(joint.spring_rate, end) / factor**2
            assert getattr(other.spring_rate, end) == pytest.approx(wanted, rel=1e-4)
            assert getattr(other.damper_rate, end) * factor == pytest.approx(getattr(joint.damper_rate, end), rel=1e-4)
            assert getattr(other.free_angle, end) == pytest.approx(getattr(joint.free_angle, end), abs=1e-6)
    assert len(slow.warnings) == len(one.warnings)


@pytest.mark.parametrize("factor", [0.05, 20.0])
def test_a_leg_on_another_clock_is_fitted_alike(factor: float) -> None:
    leg = robot()
    trials = swings(leg, np.linspace(0.0, 1.0, 251), np.array([[-13, 31, 16], [9, -17, -24], [14, 22, -18]]))
    one = slowed(leg, trials, 1.0)
    assert not one.cut
    assert_alike(one, slowed(leg, trials, factor), factor)


@pytest.mark.parametrize("factor", [0.05, 20.0])
def test_a_hand_on_another_clock_is_cut_alike(factor: float) -> None:
    leg, times = pendulum(2.0, 0.06), np.linspace(0.0, 1.5, 301)
    torque = np.where(times < 0.12, 0.6, 0.0)[:, None]
    trials = swings(leg, times, np.array([[20.0], [-35.0], [50.0]]), torque)
    one = slowed(leg, trials, 1.0, release="free")
    assert one.cut >= 0.1
    assert_alike(one, slowed(leg, trials, factor, release="free"), factor)


@pytest.mark.parametrize("clock", [0.1, 0.02])
def test_a_joint_at_fifty_and_at_two_hundred_and_fifty_hertz(clock: float) -> None:
    """Under the same gravity as at 5 Hz: 30 Hz limited the search, and a hand was named for what it could not fit."""
    leg = pendulum(8.65 / clock**2, 0.22 / clock)
    made = swings(leg, np.arange(0.0, 2.0 * clock, 0.005 * clock), np.array([[20.0], [-35.0], [50.0]]))
    result = fit_leg(bare(leg), recordings(bare(leg), made), LegFitOptions(release="free"))
    joint = result.joints["knee"]
    assert joint.spring_rate.value == pytest.approx(8.65 / clock**2, rel=0.002)
    assert joint.damper_rate.value == pytest.approx(0.22 / clock, rel=0.002)
    assert result.warnings == ()


@pytest.mark.parametrize(("decay", "lasting"), [(1000.0, 0.05), (3000.0, 0.2)])
def test_a_damper_far_stronger_than_its_link(decay: float, lasting: float) -> None:
    """``decay`` 1/s of the rate, ``lasting`` s the time constant of the creeping: 500 1/s limited the search."""
    damper = decay * INERTIA
    leg = pendulum(damper / lasting, damper)
    made = swings(leg, np.arange(0.0, 5.0 * lasting, lasting / 60.0), np.array([[20.0], [-35.0], [50.0]]))
    result = fit_leg(bare(leg), recordings(bare(leg), made), LegFitOptions(release="free"))
    joint = result.joints["knee"]
    for found, true in ((joint.spring_rate, damper / lasting), (joint.damper_rate, damper)):
        assert found.low * 0.8 < true < found.high * 1.25
    assert joint.free_angle.low - 1e-3 < np.radians(30.0) < joint.free_angle.high + 1e-3
    assert joint.damper_rate.value / joint.spring_rate.value == pytest.approx(lasting, rel=0.01)
    assert result.warnings == ()  # nor is its rate, which has decayed at the second sample, a hand's


@pytest.mark.parametrize(("spring", "damper"), [((400.0 * np.pi) ** 2, 20.0), (60_000.0, 3000.0), (15_000.0, 3000.0)])
def test_the_integrator_resolves_fast_and_stiff_joints(spring: float, damper: float) -> None:
    """A swing at 200 Hz, and creeping behind a damper of 3000 1/s, both over the inertia, against the closed form."""
    leg = pendulum(spring * INERTIA, damper * INERTIA, gravity=0.0)
    slow, fast = np.sort_complex(np.roots([1.0, damper, spring]).astype(complex))[::-1]
    times = np.linspace(0.0, min(5.0 / abs(slow.real), 1.0), 400)
    wanted = ((fast * np.exp(slow * times) - slow * np.exp(fast * times)) / (fast - slow)).real
    chain = compiled_chain(1)
    lanes = chain.parameters(leg)[:, None]
    lanes[chain.layout.rows("rotation")] = leg.rest[0] + 1.0
    for unit in (1.0, 0.05):
        found = chain.run(lanes.copy(), times, 1e-7, unit=unit)[:, 0, 0] - leg.rest[0]
        np.testing.assert_allclose(found, wanted, atol=5e-6)


def test_the_search_reaches_far_beyond_the_motion_seen() -> None:
    """A thousand times the pace's own rates to both sides, on every clock, and free angles beyond the turns seen."""
    leg = pendulum(2.0, 0.06)
    for factor in (0.05, 1.0, 20.0):
        on_it = replace(leg, gravity=leg.gravity / factor**2)
        times = np.linspace(0.0, 1.5, 301)
        angles = 31.0 + 0.4 * np.exp(-times) * np.cos(15.0 * times)
        made = recordings(on_it, [Trial("a.csv", times * factor, angles.reshape(-1, 1))])
        unknowns = unknowns_of(model_of(on_it, recordings=made))
        low, high = np.exp(unknowns.lower[[0, 2]]), np.exp(unknowns.upper[[0, 2]])
        assert np.all(low * factor ** np.array([2, 1]) < INERTIA * np.array([15.0**2, 1.0]) * 1e-3)
        assert np.all(high * factor ** np.array([2, 1]) > INERTIA * np.array([15.0**2, 1.0]) * 1e3)
        assert unknowns.lower[1] < 30.0 < 32.0 < unknowns.upper[1]
        assert box_of(made).unit == {0.05: 0.05, 1.0: 1.0, 20.0: 20.0}[factor]


def test_a_joint_without_spring_or_damper_is_told_from_none_by_a_sentence() -> None:
    for spring, damper, what in ((1e-9, 0.02, "spring rate"), (2.0, 0.0, "damper rate")):
        leg = pendulum(spring, damper)
        leg = leg.with_joints(knee={"spring": Spring(spring, 0.0)})
        made = swings(leg, np.arange(0.0, 4.0, 0.01), np.array([[20.0], [-35.0], [50.0]]))
        result = fit_leg(bare(leg), recordings(bare(leg), made), LegFitOptions(release="free"))
        assert any(f"do not tell the {what} from none" in text for text in result.not_separable)


def test_limbs_share_the_unit_of_a_second() -> None:
    assert {stepped_unit([pace]) for pace in (0.006, 0.0128, 0.025, 0.04, 0.09)} == {1.0}
    assert stepped_unit([0.0016, 0.0014, 0.02]) == pytest.approx(0.05)
    assert stepped_unit([0.3]) == pytest.approx(20.0)
    assert stepped_unit([]) == 1.0
    # A whole leg of a human, at 0.6 Hz, and twice the fastest limb: no more than half a step off.
    assert stepped_unit([0.134]) == pytest.approx(np.sqrt(20.0))
    assert stepped_unit([0.0027]) == pytest.approx(1.0 / np.sqrt(20.0))


def test_a_hand_at_a_leg_as_slow_as_a_humans_is_cut() -> None:
    """Its unit was 20 s, for which 2.5 s were too short a recording: the damper was 21 % too weak."""
    link = Link(0.85, 10.0, 0.38, 0.55)
    joint = Joint("hip", link, 0.0, 1, None, Spring(6.0, 0.0), Damper(0.6))
    leg, times = Leg("whole leg", (joint,)), np.arange(0.0, 2.5, 1.0 / 60.0)
    torque = np.where(times < 0.3, 6.0, 0.0)[:, None]
    trials = swings(leg, times, np.array([[-40.0], [-30.0], [-25.0]]), torque)
    result = fit_leg(bare(leg), recordings(bare(leg), trials), LegFitOptions(release="free"))
    assert 0.25 < result.cut < 0.9
    assert result.joints["hip"].damper_rate.value == pytest.approx(0.6, rel=0.03)


@pytest.mark.parametrize(("place", "what"), [(0, "spring rate"), (1, "free angle"), (2, "damper rate")])
def test_an_estimate_at_a_bound_or_near_it_is_said(place: int, what: str) -> None:
    """Within a factor of two: an iteration usually stops just short of the bound."""
    unknowns = unknowns_of(model_of(pendulum(2.0, 0.06)))
    middle = 0.5 * (unknowns.lower + unknowns.upper)
    assert at_edges(unknowns, middle) == {}
    for side, off in ((unknowns.lower, 0.5), (unknowns.upper, -0.5)):
        values = middle.copy()
        values[place] = side[place] + off
        ((name, sentence),) = at_edges(unknowns, values).items()
        assert name == f"{what.replace(' ', '_')} knee"
        assert sentence.startswith(f"knee: the {what} is at a bound of the search")
        assert (joint_of(sentence), severity_of(sentence)) == ("knee", "decide")
