"""Small legs within tolerance with one added effect: its place and size are found; without one, none is reported."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from diagnosis.simulated_releases import ONE, TWO, best, causes, heavier, off, recorded, shifted, with_effects
from fit.simulated_legs import RELEASES, robot
from synth.diagnosis.angle_search import search
from synth.diagnosis.angle_trials import angle_trial
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.hypotheses import Hypotheses
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose
from synth.diagnosis.plants.swinging_chain.chain_result import GapResult
from synth.diagnosis.plants.swinging_chain.chain_where import missing_torque
from synth.diagnosis.verdict import CALIBRATED
from synth.files.gap_project import Tolerance
from synth.fit.recordings import recordings
from synth.swing.chain import simulate
from synth.swing.leg_model import Leg


def one_of(result: GapResult, effect: str, joint: str) -> bool:
    """Whether a cause is in the explanation or in one that is tied with it."""
    ties = [(cause.effect, cause.joint) for option in result.tied for cause in option]
    return (effect, joint) in [*causes(result), *ties]


def sums_to_one(result: GapResult) -> bool:
    total = sum(entry.probability for entry in result.ranked)
    return total <= 1.0 + 1e-9 and total + result.probability_none + result.probability_unknown <= 1.0 + 1e-9


def size_of(values: Mapping[str, float]) -> float:
    """The first parameter, or for a power law, which may be written at any reach, its torque at half a radian."""
    if "stiffening" in values:
        return values["stiffening"] * (0.5 / values.get("reach", 1.0)) ** values.get("exponent", 3.0)
    return next(iter(values.values()))


TORQUES = [
    ("coulomb_friction", "knee", {"torque": 0.03}),
    pytest.param("coulomb_friction", "hip", {"torque": 0.12}, marks=pytest.mark.slow),
    ("quadratic_damping", "knee", {"coefficient": 0.006}),
    ("hardening_spring", "knee", {"stiffening": 0.8}),
    ("joint_stop", "knee", {"upper": 2.2, "stiffness": 30.0, "damping": 0.05}),
    ("backlash", "knee", {"gap": 0.03}),
    ("latency", "knee", {"delay": 0.02}),
    ("encoder_scale", "knee", {"error": 0.1}),
    ("encoder_offset", "knee", {"offset": 0.06}),
]


@pytest.mark.parametrize(("effect", "joint", "values"), TORQUES, ids=lambda v: v if isinstance(v, str) else "")
def test_one_effect_is_found_at_its_joint_with_its_size(effect: str, joint: str, values: Mapping[str, float]) -> None:
    built = with_effects(off(TWO, 4), {joint: {effect: values}})
    result = diagnose(TWO, recorded(built, seed=2), Tolerance())
    assert result.verdict in ("effect", "tie")
    assert one_of(result, effect, joint)
    assert best(result) == (effect, joint)
    assert result.shrink.value > 0.85
    assert result.after.value < 1.3 * result.noise_floor.value
    assert sums_to_one(result)
    name = next(iter(values))
    found = result.ranked[0].cause.parameters
    assert found[name].low is not None
    assert found[name].high is not None
    reach = max(found[name].high - found[name].value, found[name].value - found[name].low) / found[name].value
    ratio = size_of({key: estimate.value for key, estimate in found.items()}) / size_of(values)
    assert ratio == pytest.approx(1.0, abs=min(2.0 * reach, 0.15))  # three standard deviations and more


def test_a_heavier_link_is_found() -> None:
    result = diagnose(TWO, recorded(heavier(off(TWO, 1), "knee", 0.3), seed=2), Tolerance())
    assert result.verdict in ("effect", "tie")
    assert best(result) in (("link_mass", "knee"), ("link_inertia", "knee"))
    share = next(entry for entry in result.ranked if entry.cause.effect == "link_mass").cause.parameters["share"]
    assert share.value == pytest.approx(0.3, abs=0.1)
    mass = {joint.name: joint.link.mass for joint in result.diagnosed.joints}
    if causes(result)[0][0] == "link_mass":  # a changed number of the leg is in the leg file as that number
        assert mass["knee"] == pytest.approx(1.3 * TWO.joints[1].link.mass, rel=0.1)


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2))])
def test_errors_within_the_tolerances_are_no_cause(seed: int) -> None:
    result = diagnose(TWO, recorded(off(TWO, seed), seed=seed), Tolerance())
    assert result.verdict == "none"
    assert result.explanation == ()
    assert sums_to_one(result)
    assert result.as_designed.value > 2.0 * result.before.value  # they show, and the leg's numbers account for them
    assert result.before.value == pytest.approx(result.noise_floor.value, rel=0.1)
    assert result.diagnosed.joints[0].effects == {}


@pytest.mark.parametrize("leg", [ONE, TWO], ids=["one joint", "two"])
def test_a_leg_as_designed_has_no_missing_effect(leg: Leg) -> None:
    result = diagnose(leg, recorded(leg), Tolerance())
    assert result.verdict == "none"
    assert result.shrink.value == 0.0
    assert result.as_designed.value < 1.1 * result.noise_floor.value


def test_dry_friction_is_not_explained_by_inertia() -> None:
    """With all parameters free, a joint with friction would be assigned four times its inertia."""
    built = with_effects(off(TWO, 6), {"knee": {"coulomb_friction": {"torque": 0.05}}})
    result = diagnose(TWO, recorded(built, seed=5), Tolerance())
    assert best(result)[0] in ("coulomb_friction", "stribeck_friction")
    odds = {entry.cause.effect: entry.probability for entry in result.ranked}
    assert odds.get("link_inertia", 0.0) + odds.get("link_mass", 0.0) < 0.01
    for joint, nominal in zip(result.diagnosed.joints, TWO.joints, strict=True):
        assert joint.link.inertia == pytest.approx(nominal.link.inertia, rel=0.08)
        assert joint.link.mass == pytest.approx(nominal.link.mass, rel=0.04)


def test_the_ankle_is_not_blamed_for_following_the_knee() -> None:
    nominal = robot()
    built = with_effects(off(nominal, 8, 0.5), {"knee": {"coulomb_friction": {"torque": 0.08}}})
    time = np.arange(151) * 0.01
    away = np.radians(np.array(RELEASES[:4], dtype=float)) * nominal.sign
    result = diagnose(nominal, recorded(built, away, time=time, seed=1), Tolerance())
    assert best(result)[1] == "knee"
    assert result.where.joint["knee"] > 0.8
    assert result.where.joint["ankle"] < 0.1
    error = {
        name: np.sqrt(np.mean([(t.before - t.measured)[:, j] ** 2 for t in result.trials]))
        for j, name in enumerate(nominal.joint_names)
    }
    assert error["ankle"] > 1.5 * result.noise["ankle"]  # it does move wrongly


def test_torque_is_missing_only_at_the_joint_with_friction() -> None:
    """Along a motion without noise: the friction against the motion at the knee, next to nothing beside it."""
    nominal = robot()
    built = with_effects(nominal, {"knee": {"coulomb_friction": {"torque": 0.08}}})
    away = np.radians(np.array(RELEASES[:1], dtype=float)) * nominal.sign
    (trial,) = recorded(built, away, noise=0.0, time=np.arange(801) * 1e-3, held_out=0)
    (recording,) = recordings(nominal, [trial], ())
    found = missing_torque(nominal, angle_trial(recording, held_out=False))
    rate = np.stack([np.interp(found.time, recording.smoothed.time, r) for r in recording.smoothed.rate.T], axis=1)
    moving = (np.abs(rate[:, 1]) > 0.5) & (found.time < 0.6)
    against = -found.torque[moving, 1] * np.sign(rate[moving, 1])
    assert np.median(against) == pytest.approx(0.08, rel=0.1)
    for other in (0, 2):
        assert np.median(np.abs(found.torque[moving, other])) < 0.008


def test_two_causes_at_two_joints_are_found() -> None:
    effects = {
        "knee": {"coulomb_friction": {"torque": 0.04}},
        "hip": {"quadratic_damping": {"coefficient": 0.04}},
    }
    result = diagnose(TWO, recorded(with_effects(off(TWO, 4), effects), seed=2), Tolerance())
    assert result.verdict in ("effect", "tie")
    assert one_of(result, "quadratic_damping", "hip")
    assert one_of(result, "coulomb_friction", "knee") or one_of(result, "stribeck_friction", "knee")
    assert result.shrink.value > 0.85
    most = 1.0 - CALIBRATED.doubt_of_several  # both at once: each has all that doubt leaves to several
    assert all(0.9 * most < entry.probability <= most for entry in result.ranked[:2])
    assert {j.name for j in result.diagnosed.joints if j.effects} == {"hip", "knee"}
    assert not [text for text in result.warnings if "depends on" in text]


def test_coarse_counts_are_a_cause() -> None:
    step = np.radians(1.0)
    built = with_effects(off(TWO, 1), {"knee": {"encoder_quantisation": {"step": step}}})
    result = diagnose(TWO, recorded(built, seed=2), Tolerance())
    assert causes(result) == [("encoder_quantisation", "knee")]
    assert result.explanation[0].parameters["step"].value == pytest.approx(step, rel=1e-6)
    assert result.diagnosed.joints[1].effects["encoder_quantisation"]["step"] == pytest.approx(step, rel=1e-6)
    # The sensor's noise turns readings at the edge of a count: no effect is missed for that (1.9 noises once).
    assert result.remainder.times_noise < 0.5
    assert "No effect in the library explains" not in result.sentence


def test_the_diagnosed_leg_moves_as_the_built_one_does() -> None:
    """A release that no trial had: the nominal leg misses it, the diagnosed one does not."""
    built = with_effects(off(TWO, 9), {"knee": {"quadratic_damping": {"coefficient": 0.006}}})
    result = diagnose(TWO, recorded(built, seed=3), Tolerance())
    time, pose = np.arange(151) * 0.01, np.array([-0.3, 0.9])
    true, nominal, found = (simulate(leg, pose, [0.0, 0.0], time) for leg in (built, TWO, result.diagnosed))
    assert np.abs(found - true).max() < np.radians(0.7)
    assert np.abs(nominal - true).max() > np.radians(5.0)


def test_a_shifted_free_angle_is_written_into_the_diagnosed_leg() -> None:
    built = shifted(off(TWO, 1), "hip", 0.15)
    result = diagnose(TWO, recorded(built, seed=2), Tolerance())
    assert one_of(result, "spring_preload", "hip")
    if causes(result) == [("spring_preload", "hip")]:
        spring, true = result.diagnosed.joints[0].spring, built.joints[0].spring
        assert spring is not None
        assert true is not None
        assert spring.free_angle == pytest.approx(true.free_angle, abs=0.02)
        assert result.diagnosed.joints[0].effects == {}


def test_a_rate_error_is_a_cause_only_outside_its_tolerance() -> None:
    """A spring's rate 10 % off: nothing where that may be, something where it is known to half a per cent."""
    spring = ONE.joints[0].spring
    assert spring is not None
    built = ONE.with_joints(knee={"spring": replace(spring, rate=1.1 * spring.rate)})
    trials = recorded(built, seed=4)
    assert diagnose(ONE, trials, replace(Tolerance(), spring=0.1)).verdict == "none"
    assert diagnose(ONE, trials, Tolerance(0.001, 0.002, 0.002, 0.002, 0.005, 0.05, 0.002)).verdict != "none"


def test_a_cause_found_only_in_a_pair_is_ranked(monkeypatch: pytest.MonkeyPatch) -> None:
    effects = {
        "knee": {"coulomb_friction": {"torque": 0.04}},
        "hip": {"quadratic_damping": {"coefficient": 0.04}},
    }

    def without(*given: Any) -> Hypotheses[EvaluatedHypothesis]:
        found = search(*given)
        return replace(found, singles=tuple(s for s in found.singles if s.keys[0] != ("quadratic_damping", "hip")))

    monkeypatch.setattr("synth.diagnosis.plants.swinging_chain.stated_candidates.search", without)
    result = diagnose(TWO, recorded(with_effects(off(TWO, 4), effects), seed=2), Tolerance())
    ranked = [(entry.cause.effect, entry.cause.joint) for entry in result.ranked]
    assert set(causes(result)) <= set(ranked)
    entry = result.ranked[ranked.index(("quadratic_damping", "hip"))]
    assert 0.5 < entry.probability <= 1.0
    assert entry.shrink is None  # it was not fitted alone
    assert "shrink" not in entry.as_json()
