"""A leg held still by a known torque: read from a project, used in the fit, and what it makes separable."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fit.simulated_legs import DAMPER, RELEASES, SPRING, Rig, bare, errors, fitted, release, releases, robot
from robustness.random_legs import TOLERANCE_OF_LINKS
from synth.errors import Problem
from synth.files.static_points_file import StaticPoint, read_static_points
from synth.files.yaml_lines import load
from synth.fit.estimate import fit_leg
from synth.fit.fit_options import LegFitOptions
from synth.fit.recordings import Recording, recordings
from synth.fit.ridge import POINTS_COST
from synth.fit.static_points import balances
from synth.remarks import Remark
from synth.swing.leg_model import Leg
from synth.swing.mechanics import coefficients, rest_pose, static_torque

# The hip of the built leg: so damped that a release shows b/k = 0.15 s and hardly k.
OVERDAMPED = robot([80.0, *SPRING[1:]], [12.0, *DAMPER[1:]])
POSE = np.array([118.0, 112.0, 141.0])  # deg


def held(leg: Leg, pose: np.ndarray, joint: int, **errors: float) -> StaticPoint:
    """The point that a perfect measurement of this leg would give: the torque at one joint, in the measured sense."""
    rotation = leg.to_rotation(np.radians(pose))
    spring = leg.joints[joint].spring
    assert spring is not None
    stretched = spring.rate * (np.radians(pose[joint]) - spring.free_angle)
    torques = np.zeros(3)
    torques[joint] = stretched + leg.sign[joint] * static_torque(coefficients(leg), rotation, leg.tilt)[joint]
    return StaticPoint("static[1]", np.radians(pose), torques, (joint,), **errors)  # type: ignore[arg-type]


def test_one_point_separates_the_overdamped_hips_spring_from_its_damper() -> None:
    """The named case: releases fix b/k alone; one torque-angle point, and k is known to what the point allows."""
    trials = releases(OVERDAMPED, 1, Rig(noise=0.5), 3)
    alone = fitted(OVERDAMPED, trials)
    assert any(text.startswith("hip: not separable: spring rate and damper rate") for text in alone.not_separable)
    with_point = fitted(OVERDAMPED, trials, static=(held(OVERDAMPED, POSE, 0),))
    assert not any(text.startswith("hip: not separable") for text in with_point.not_separable)
    assert "hip" in [family.joint for family in alone.families]
    assert "hip" not in [family.joint for family in with_point.families]
    before, after = errors(alone, OVERDAMPED), errors(with_point, OVERDAMPED)
    assert before.spring_sd[0] > 0.12
    # 2 % of the torque and 0.5 deg of the 13 deg that the spring is turned: 4.3 % together
    assert 0.03 < after.spring_sd[0] < 0.05
    assert abs(after.spring[0]) < 2.5 * after.spring_sd[0]
    assert abs(after.damper[0]) < 2.5 * after.damper_sd[0]
    assert after.damper_sd[0] < 0.06


def friction_at_the_ankle(rotation: np.ndarray, rate: np.ndarray) -> np.ndarray:
    return np.array([0.0, 0.0, -0.05 * rate[2] / np.hypot(rate[2], 0.02)])


def test_every_member_of_a_ridge_family_keeps_to_an_inaccurate_static_point() -> None:
    """The model lacks the ankle's friction, so that only the RMS limits the family; the point is known to 8 N m."""
    generator, options = np.random.default_rng(1), {"rig": Rig(noise=0.3), "extra_torque": friction_at_the_ankle}
    trials = [release(OVERDAMPED, RELEASES[i], generator, name=str(i), **options) for i in range(3)]  # type: ignore[arg-type]
    point = held(OVERDAMPED, POSE, 0, torque_error=8.0)
    result = fitted(OVERDAMPED, trials, free_angle="common", static=(point,))
    (balance,), joint = balances(bare(OVERDAMPED), (point,)), OVERDAMPED.joints[0]

    def cost(rate: float, free_angle: float) -> float:
        return 0.5 * balance.residual(np.log(rate), joint.sign * (free_angle - joint.zero)) ** 2

    reported = cost(result.joints["hip"].spring_rate.value, result.joints["hip"].free_angle.value)
    family = next(family for family in result.families if family.joint == "hip")
    assert len(family.members) > 2
    assert not family.open_end
    assert max(cost(each.spring_rate, each.free_angle) for each in family.members) <= reported + POINTS_COST + 1e-9


def test_static_balance_includes_weight_tip_mass_and_measured_sense() -> None:
    leg = robot()
    pose = leg.to_measured(rest_pose(leg, tip_mass=0.2))
    resting = StaticPoint("hung", pose, np.zeros(3), (0, 1, 2), tip_mass=0.2)
    rest = np.array([j.sign * (j.spring.free_angle - j.zero) for j in leg.joints if j.spring])
    for point in balances(leg, [resting, held(leg, POSE, 2)]):
        residual = point.residual(float(np.log(SPRING[point.joint])), float(rest[point.joint]))
        assert residual == pytest.approx(0.0, abs=1e-8)
    carried = StaticPoint("bench", np.radians([np.nan, np.nan, 149.0]), np.array([0, 0, 0.1]), (2,), supported=True)
    (point,) = balances(leg, [carried])
    # the ankle's measured angle grows clockwise: the same torque, seen in q, has the other sign
    assert point.torque == pytest.approx(-0.1)
    assert point.residual(np.log(0.1 / np.radians(10.0)), float(rest[2])) == pytest.approx(0.0, abs=1e-9)


def test_a_wrong_static_torque_shows_in_its_residual() -> None:
    leg, point = robot(), held(robot(), POSE, 1)
    trials = releases(leg, 3, Rig(noise=0.1), 3)
    twice = StaticPoint("twice", point.angles, point.torques * 2, (1,))
    good, bad = (fitted(leg, trials, static=(p,)) for p in (point, twice))
    assert max(abs(item.deviations) for item in good.static) < 2.0
    assert max(abs(item.deviations) for item in bad.static) > 5.0
    assert any("static point twice" in text and "knee" in text for text in bad.warnings)
    assert not any("static point" in text for text in good.warnings)


def swinging(leg: Leg) -> list[Recording]:
    """Releases with 0.05 deg of noise, which a leg of springs and linear dampers fits to the noise."""
    return recordings(bare(leg), releases(leg, 3, Rig(noise=0.05), 2))


SWINGS = robot([12.0, 3.1, 0.6], [0.25, 0.05, 0.006])
SHARP = {"torque_error": 0.02, "angle_error": math.radians(0.1), "supported": True}
AUTO = LegFitOptions(release="free", laws="auto", tolerance=TOLERANCE_OF_LINKS)


def spring_alone(leg: Leg, pose: np.ndarray, joint: int, factor: float = 1.0, **errors: object) -> StaticPoint:
    """As ``held``, of the supported leg: the spring alone, its torque times a factor."""
    spring, torques = leg.joints[joint].spring, np.zeros(3)
    assert spring is not None
    torques[joint] = factor * spring.rate * (np.radians(pose[joint]) - spring.free_angle)
    return StaticPoint("static[1]", np.radians(pose), torques, (joint,), **errors)  # type: ignore[arg-type]


@pytest.mark.parametrize(("joint", "errors"), [(0, SHARP), (2, {**SHARP, "torque_error": 0.002})])
def test_a_point_of_the_wrong_sign_is_left_out_and_the_recordings_fit_is_kept(
    joint: int, errors: dict[str, object]
) -> None:
    """One number with a small error took the leg to 21 deg RMS, and a hand and another law were blamed."""
    made, linear = swinging(SWINGS), replace(AUTO, laws="linear")
    alone = fit_leg(bare(SWINGS), made, linear)
    pose = np.array([125.0, 118.0, 150.0])
    wrong = fit_leg(bare(SWINGS), made, replace(AUTO, static=(spring_alone(SWINGS, pose, joint, -1.0, **errors),)))
    for name, found in wrong.joints.items():
        assert found.spring_rate.value == pytest.approx(alone.joints[name].spring_rate.value, rel=1e-6)
        assert found.spring_rate.high == pytest.approx(alone.joints[name].spring_rate.high, rel=1e-6)
    assert wrong.rms == pytest.approx(alone.rms, rel=1e-6)
    assert (wrong.cut, wrong.law) == (0.0, {})
    first, *others = wrong.warnings
    assert (
        f"static point static[1], {SWINGS.joint_names[joint]}: it contradicts the recordings and is left out" in first
    )
    assert "With the torque's sign turned it agrees" in first
    assert isinstance(first, Remark)
    assert first.severity == "decide"
    assert others == list(alone.warnings)
    (point,) = wrong.as_json()["static"]
    assert point["left_out"] is True
    right = fit_leg(bare(SWINGS), made, replace(linear, static=(spring_alone(SWINGS, pose, joint, **errors),)))
    assert "left_out" not in right.as_json()["static"][0]
    assert right.warnings == alone.warnings


def test_of_several_points_only_the_wrong_ones_balance_is_left_out() -> None:
    made, pose = swinging(SWINGS), np.array([125.0, 118.0, 150.0])
    points = [replace(spring_alone(SWINGS, pose, j, f, **SHARP), name=f"p{j}") for j, f in ((0, 1.0), (1, 1.6))]
    both = replace(points[0], torques=points[0].torques + points[1].torques, balanced=(0, 1))
    result = fit_leg(bare(SWINGS), made, replace(AUTO, laws="linear", static=(both,)))
    assert [(item.balance.joint, item.left_out) for item in result.static] == [(0, False), (1, True)]
    assert "knee: it contradicts the recordings" in result.warnings[0]
    assert "sign" not in result.warnings[0]


def test_points_that_a_ridge_allows_by_themselves_but_not_together_are_left_out() -> None:
    """A hip whose releases tell b/k alone: each point chooses its own place on the ridge."""
    made = recordings(bare(OVERDAMPED), releases(OVERDAMPED, 1, Rig(noise=0.5), 3))
    sharp = {"torque_error": 0.05, "angle_error": math.radians(0.1), "supported": True}
    pair = [
        replace(spring_alone(OVERDAMPED, np.array([hip, 112.0, 141.0]), 0, f, **sharp), name=f"p{hip:.0f}")
        for hip, f in ((118.0, 1.0), (120.0, 1.5))
    ]
    for point in pair:
        (alone,) = fit_leg(bare(OVERDAMPED), made, LegFitOptions(static=(point,))).static
        assert not alone.left_out
    result = fit_leg(bare(OVERDAMPED), made, LegFitOptions(static=tuple(pair)))
    assert all(item.left_out for item in result.static)
    assert "the static points contradict each other" in result.warnings[0]


def test_a_wrong_sign_is_left_out_where_only_a_point_tells_the_spring() -> None:
    made = recordings(bare(OVERDAMPED), releases(OVERDAMPED, 1, Rig(noise=0.5), 3))
    point = spring_alone(OVERDAMPED, POSE, 0, -1.0, **SHARP)
    result = fit_leg(bare(OVERDAMPED), made, LegFitOptions(static=(point,)))
    assert result.static[0].left_out
    assert "With the torque's sign turned it agrees" in result.warnings[0]


GOOD = "  - {angles: {hip: 118 deg, knee: 112 deg, ankle: 141 deg}, torque: {hip: 4 N*m}, torque_error: 0.1 N*m}\n"
BAD = [
    ("  - {angles: {hip: 118 deg}, torque: {hip: 4 N*m}}\n", "the angle of knee and ankle is missing", 2),
    ("  - {angles: {hip: 118 deg, knee: 112, ankle: 141 deg}}\n", "unit", 2),
    ("  - {angles: {hip: 118 deg}, torque: {knee: 4 N*m}, supported: true}\n", "the angle of knee is missing", 2),
    ("  - {angles: {hop: 118 deg}, supported: true}\n", "did you mean hip?", 2),
    ("  - {angles: {hip: 118 deg}, supported: true, tip_mass: 20 g}\n", "have no effect", 2),
    ("  - {angles: {hip: 118 deg}, torque: {hip: 4 N*m}, supported: true, locked: [hip]}\n", "balances any torque", 2),
    ("  - {angles: {hip: 118 deg}, torque: {hip: 4 N}, supported: true}\n", "N*m", 2),
    ("  - {angles: {hip: 118 deg}, suported: true}\n", "did you mean supported?", 2),
    ("  {hip: 118 deg}\n", "a list of points is needed", 1),
]


def read(folder: Path, text: str) -> tuple[tuple[StaticPoint, ...], list[Problem]]:
    file = folder / "fit.yaml"
    file.write_text("static:\n" + text)
    problems: list[Problem] = []
    document = load(file)
    return read_static_points(document.value["static"], bare(robot()), document, ("static",), problems), problems


def test_a_static_point_is_read_in_si(tmp_path: Path) -> None:
    (point,), problems = read(tmp_path, GOOD)
    assert not problems
    assert np.degrees(point.angles) == pytest.approx(POSE)
    assert point.torques == pytest.approx([4.0, 0.0, 0.0])
    assert point.balanced == (0,)
    assert point.torque_error == pytest.approx(0.1)
    assert np.degrees(point.angle_error) == pytest.approx(0.5)


@pytest.mark.parametrize(("text", "said", "line"), BAD)
def test_a_mistake_in_a_static_point_is_named_with_its_line(tmp_path: Path, text: str, said: str, line: int) -> None:
    points, problems = read(tmp_path, text)
    assert not points
    assert len(problems) == 1
    assert said in problems[0].text
    assert problems[0].line == line
