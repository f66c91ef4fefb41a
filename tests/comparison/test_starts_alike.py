"""Recordings are compared where they start alike: in angle and in speed."""

from __future__ import annotations

from math import radians
from pathlib import Path

import numpy as np
import pytest

from synth.commands.compare import compare_text
from synth.comparison.compare_sides import Comparison, compare, warnings
from synth.comparison.side import MODEL, RECORDED, ComparedMotion, Side, joints_of
from synth.reports.openings.comparison_opening import comparison_opening
from synth.reports.reading import Result
from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

TIMES = np.arange(0.0, 4.0, 0.005)
LEG = Leg("pendulum", (Joint("knee", Link(0.3, 1.0, 0.2, 0.01), damper=Damper(0.005)),))


def motion(name: str, angle: float, rate: float, noise: float = 0.0) -> ComparedMotion:
    """A free swing from ``angle`` deg at ``rate`` rad/s, its samples scattered by ``noise`` deg.

    The stated rate is zero, as of a recording of which nothing more is known: the samples tell.
    """
    start = np.array([radians(angle)])
    moved = simulate(LEG, start, np.array([rate]), TIMES)
    moved = moved + np.random.default_rng(len(name)).normal(0.0, radians(noise), moved.shape)
    return ComparedMotion(name, TIMES, moved, moved[0].copy(), np.zeros(1))


def side(name: str, *motions: ComparedMotion) -> Side:
    return Side(name, name, RECORDED, LEG, {}, motions)


def opening(found: Comparison) -> tuple[str, str]:
    """Headline and the line below it."""
    page = comparison_opening(Result(Path(), "compare.json", found.as_json()))
    return page.verdict, page.trust


def test_swings_in_opposite_phase_from_one_angle_are_not_compared() -> None:
    """One angle, opposite speeds: 14.5 deg apart at best, and it was called the same start."""
    found = compare([side("A", motion("a", 1.0, 1.2)), side("B", motion("b", 1.0, -1.2))])
    assert found.differences[0].starts == 0
    assert not np.isfinite(found.differences[0].overall)
    assert "the nearest recording, b, starts at another speed" in found.overlays[0].why[1]
    assert "share none of one start; 1 is left out" in warnings(found)[0]
    assert opening(found)[0] == "A and B share no start: only figures are compared."
    assert "no common start" in compare_text(found.as_json())


@pytest.mark.parametrize("rate", [0.2, 0.05])
def test_small_swings_in_opposite_phase_are_not_compared_either(rate: float) -> None:
    """Of 2 and of 0.5 deg: all starts lie within 10 deg of one another there."""
    found = compare([side("A", motion("a", 0.0, rate)), side("B", motion("b", 0.0, -rate))])
    assert found.differences[0].starts == 0


def test_of_two_recordings_from_one_angle_that_at_the_same_speed_is_taken() -> None:
    other = side("B", motion("backwards", 5.0, -1.0), motion("forwards", 5.5, 1.0))
    found = compare([side("A", motion("a", 5.0, 1.0)), other])
    seen = found.overlays[0].motions[1]
    assert seen is not None
    assert seen.recording == "forwards"
    assert np.degrees(found.differences[0].overall) < 0.5


@pytest.mark.parametrize("noise", [0.1, 0.5])
def test_noise_alone_makes_no_other_speed(noise: float) -> None:
    """At 200 Hz 0.5 deg of noise is 140 deg/s from sample to sample."""
    found = compare([side("A", motion("a", 10.0, 1.0, noise)), side("B", motion("b", 10.0, 1.0, noise))])
    assert found.differences[0].starts == 1


def test_releases_of_unlike_legs_from_one_pose_start_alike() -> None:
    """A parabola over the swing of a stiff, overdamped joint gave 2700 deg/s to a release from rest."""
    links = [
        ("hip", Link(0.2, 0.22, 0.11, 2e-3)),
        ("knee", Link(0.2, 0.2, 0.1, 1.5e-3)),
        ("foot", Link(0.15, 0.08, 0.06, 3e-4)),
    ]
    rates, dampers, start = (23.7, 6.0, 2.5), (0.55, 0.12, 0.03), np.radians([-15.0, 40.0, 30.0])
    sides = []
    for name, stiffer, slower in (("A", 1.0, 1.0), ("B", 1.0, 4.0), ("C", 2.5, 1.0)):
        leg = Leg(name, tuple(
            Joint(joint, link, spring=Spring(stiffer * k, 0.0), damper=Damper(slower * b))
            for (joint, link), k, b in zip(links, rates, dampers, strict=True)
        ))  # fmt: skip
        moved = simulate(leg, start, np.zeros(3), TIMES[:400])
        moved = moved + np.random.default_rng(3).normal(0.0, radians(0.05), moved.shape)
        sides.append(
            Side(
                name,
                name,
                RECORDED,
                leg,
                {},
                (ComparedMotion(f"{name}.csv", TIMES[:400], moved, moved[0].copy(), np.zeros(3)),),
            )
        )
    found = compare(sides)
    assert [difference.starts for difference in found.differences] == [1, 1, 1]
    aways = [motion.away for motion in found.overlays[0].motions if motion is not None and motion.away is not None]
    assert max((away.distance for away in aways), default=0.0) < radians(1.0)
    assert not [text for text in warnings(found) if "common start" in text]


def test_a_recording_at_half_the_pace_starts_alike_when_slowed_down() -> None:
    fast = motion("fast", 5.0, 1.0)
    slow = ComparedMotion("slow", fast.time * 2, fast.rotation, fast.start, fast.rate)
    apart = [side("A", fast), side("B", slow)]
    assert compare(apart, stretch={"A": 2.0}).differences[0].overall < 1e-9


def test_only_starts_that_both_have_are_counted() -> None:
    sides = [side("A", motion("a", 10.0, 0.0), motion("b", -30.0, 0.0)), side("B", motion("c", 10.4, 0.0))]
    found = compare(sides)
    headline, below = opening(found)
    assert headline.startswith("From the same start B moves")
    assert below.startswith("Over 1 of 2 starts (the recorded starts of A)")
    with_leg = compare([*sides, Side("leg", "leg", MODEL, LEG, joints_of(LEG))])
    assert opening(with_leg)[1].startswith("Over 1 to 2 of 2 starts")


def test_a_start_that_is_only_nearly_the_same_is_called_so() -> None:
    found = compare([side("A", motion("a", 10.0, 0.0)), side("B", motion("b", 12.0, 0.0))])
    assert opening(found)[0].startswith("From nearly the same start B moves")
    assert "start up to 2.0 deg from the common start" in warnings(found)[0]
