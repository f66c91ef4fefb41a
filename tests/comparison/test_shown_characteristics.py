"""Rise time, overshoot and the like of compared sides: one rule for recordings and simulated legs."""

from __future__ import annotations

from math import radians
from typing import Any

import numpy as np
import pytest

from synth.arrays import Array
from synth.comparison.compare_sides import Comparison, compare, warnings
from synth.comparison.recorded_sides import standard_release
from synth.comparison.side import MODEL, RECORDED, ComparedMotion, Side, joints_of
from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring
from synth.swing.mechanics import rest_pose


def two_links() -> Leg:
    link = Link(0.2, 0.3, 0.1, 1e-3)
    joints = tuple(Joint(name, link, spring=Spring(2.0, 0.0), damper=Damper(0.03)) for name in ("hip", "knee"))
    return Leg("two links", joints)


def released(leg: Leg, name: str, away: tuple[float, float], noise: float = 0.1) -> ComparedMotion:
    """A release from ``away`` deg off rest, whose samples scatter by ``noise`` deg."""
    start = rest_pose(leg) + np.radians(away)
    release = standard_release(leg, start - radians(20), 2.0)
    rotation: Array = simulate(leg, release.start, release.rate, release.time, release.conditions)
    scatter = np.random.default_rng(1).normal(0.0, radians(noise), rotation.shape)
    return ComparedMotion(name, release.time, rotation + scatter, release.start, release.rate)


def recorded(leg: Leg, *motions: ComparedMotion, name: str = "recorded") -> Side:
    return Side(name, name, RECORDED, leg, {}, motions)


def model(leg: Leg, name: str = "model") -> Side:
    return Side(name, name, MODEL, leg, joints_of(leg))


def shown(found: Comparison) -> list[dict[str, dict[str, Any]]]:
    """Of each side: joint -> characteristic -> value, least, most, motions, as compare.json has them."""
    return [side["characteristics"] for side in found.as_json()["sides"]]


def test_a_joint_that_starts_at_rest_is_out_for_the_model_too() -> None:
    """The knee's swing moves the hip by some hundred times the 0.1 deg from which it starts."""
    leg = two_links()
    sides = [recorded(leg, released(leg, "all", (20.0, 20.0)), released(leg, "knee", (0.1, 20.0))), model(leg)]
    seen, simulated = shown(compare(sides))
    for joint, releases in (("hip", 1), ("knee", 2)):
        for key, spread in seen[joint].items():
            assert spread["motions"] <= releases
            assert simulated[joint][key]["motions"] == spread["motions"]
            assert simulated[joint][key]["value"] == pytest.approx(spread["value"], rel=0.05, abs=0.02)
    assert "overshoot" in seen["hip"]
    assert {spread["motions"] for spread in simulated["hip"].values()} == {1}


def test_without_a_recording_rest_is_a_share_of_the_largest_deflection() -> None:
    leg = two_links()
    for hip, counts in ((0.1, False), (1.0, True)):
        start = released(leg, "start", (hip, 20.0), 0.0)
        found = compare([model(leg, "a"), model(leg, "b")], starts=[start])
        assert [bool(joints["hip"]) for joints in shown(found)] == [counts, counts]
        assert "overshoot" in shown(found)[0]["knee"]


def test_a_release_that_one_side_lacks_counts_for_none() -> None:
    leg = two_links()
    both, one = released(leg, "both", (20.0, 20.0)), released(leg, "one", (-20.0, 20.0))
    sides = [recorded(leg, both, one), recorded(leg, both, name="fewer"), model(leg)]
    for joints in shown(compare(sides)):
        assert {spread["motions"] for joint in joints.values() for spread in joint.values()} == {1}


def test_a_side_with_no_common_release_shows_its_own_and_says_so() -> None:
    leg = two_links()
    apart = recorded(leg, released(leg, "elsewhere", (60.0, 60.0)), name="apart")
    found = compare([recorded(leg, released(leg, "here", (20.0, 20.0))), model(leg), apart])
    assert all(joints["knee"]["overshoot"]["motions"] == 1 for joints in shown(found))
    assert any("apart shares no release with the other sides" in text for text in warnings(found))
