"""Springs tuned to dampers, the lanes of many legs side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from synth.arrays import Array
from synth.design import spring_tuning
from synth.design.response import WantedRelease, WantedResponse
from synth.design.spring_tuning import tuned_legs
from synth.parts.damper_law import power_law_curve
from synth.swing.chain import Chain, Conditions
from synth.swing.lane_groups import LaneGroups
from synth.swing.lane_layout import LANES
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

LEG = Leg(
    "two links",
    (
        Joint("hip", Link(0.22, 0.22, 0.08, 1.1e-3), np.pi / 2, 1, None, Spring(20.0, 1.8), Damper(1.0)),
        Joint("knee", Link(0.22, 0.2, 0.075, 1.1e-3), np.pi, -1, None, Spring(1.7, 2.0), Damper(0.1)),
    ),
)
TIME = np.linspace(0.0, 1.0, 101)
FACTORS = (0.5, 0.7, 0.9, 1.3, 1.8, 2.4, 3.1)
# Relative, of rates tuned beside other legs and alone: a step in log rate is within 1e-3, and there are some of them.
AS_ALONE = 3e-3


@pytest.fixture(scope="module")
def wanted() -> WantedResponse:
    releases = [
        WantedRelease("a", TIME, np.array([0.1, 1.4]), np.zeros(2), Conditions()),
        WantedRelease("b", TIME, np.array([0.5, 0.9]), np.array([0.0, -2.0]), Conditions()),
    ]
    return WantedResponse.of(LEG, releases)


def with_curve(factor: float) -> Leg:
    """The leg with a concave damper at its knee, whose torque at 1 rad/s is this factor of the wanted one's."""
    return LEG.with_joints(knee={"damper": Damper(curve=power_law_curve(0.1 * factor, 1.0, 0.5))})


def rates(legs: Sequence[Leg]) -> Array:
    """(n_leg, n) N m/rad."""
    return np.array([leg.spring_rate for leg in legs])


def test_tuning_recovers_the_original_springs(wanted: WantedResponse) -> None:
    off = LEG.with_joints(hip={"spring": Spring(31.0, 1.7)}, knee={"spring": Spring(1.2, 2.1)})
    [tuned] = tuned_legs(wanted, [off], [(0, 1)])
    assert wanted.overall([tuned])[0] < 0.05 * wanted.overall([off])[0]
    for joint, true in zip(tuned.joints, LEG.joints, strict=True):
        assert joint.spring is not None
        assert true.spring is not None
        assert joint.spring.rate == pytest.approx(true.spring.rate, rel=0.02)


def test_legs_tuned_side_by_side_are_as_alone(wanted: WantedResponse) -> None:
    """Also beside legs of other joints, whose searches end earlier or later."""
    legs, joints = [with_curve(factor) for factor in FACTORS], [(1,), (0, 1), (1,), (0,), (0, 1), (1,), (1,)]
    together = tuned_legs(wanted, legs, joints)
    alone = [tuned_legs(wanted, [leg], [own])[0] for leg, own in zip(legs, joints, strict=True)]
    assert rates(together) == pytest.approx(rates(alone), rel=AS_ALONE)
    moved = np.abs(np.log(rates(together) / LEG.spring_rate))
    assert moved.max() > 0.05  # the springs were changed
    for leg, own, before in zip(together, joints, legs, strict=True):
        kept = [j for j in range(2) if j not in own]
        assert [leg.joints[j] for j in kept] == [before.joints[j] for j in kept]


def test_the_springs_have_the_least_squares(wanted: WantedResponse) -> None:
    """Whatever rate is tried about the tuned one, its free angle kept: no smaller error, but for 2 % of its square."""
    [tuned] = tuned_legs(wanted, [with_curve(2.4)], [(1,)])
    spring = tuned.joints[1].spring
    assert spring is not None
    tried = [tuned.with_joints(knee={"spring": replace(spring, rate=spring.rate * f)}) for f in (0.9, 0.97, 1.03, 1.1)]
    errors = wanted.overall([tuned, *tried])
    assert errors[0] ** 2 < 1.02 * errors[1:].min() ** 2


def test_lanes_of_several_legs_fill_a_group(wanted: WantedResponse, monkeypatch: pytest.MonkeyPatch) -> None:
    """A leg with one joint to tune has three lanes: five of them are moved at once, not one after the other."""
    widths: list[list[int]] = []
    run = Chain.run

    def counted(self: Chain, lanes: Array | LaneGroups, *rest: Any, **named: Any) -> Array:
        assert isinstance(lanes, LaneGroups)
        widths.append(list(lanes.widths))
        return run(self, lanes, *rest, **named)

    monkeypatch.setattr(Chain, "run", counted)
    tuned_legs(wanted, [with_curve(factor) for factor in FACTORS], [(1,)] * len(FACTORS))
    assert widths[:2] == [[15, 6]] * 2  # two releases, seven legs
    assert max(width for each in widths for width in each) <= LANES


def test_a_leg_that_diverges_leaves_those_beside_it(wanted: WantedResponse) -> None:
    """Linear dampers share the steps of a group, which a far too strong one ends for all."""
    soft = LEG.with_joints(knee={"spring": Spring(1.2, 2.1)})
    stiff = LEG.with_joints(knee={"damper": Damper(1e7)})
    found = tuned_legs(wanted, [soft, stiff, soft], [(1,), (1,), (1,)])
    [alone] = tuned_legs(wanted, [soft], [(1,)])
    assert rates([found[0], found[2]]) == pytest.approx(rates([alone, alone]), rel=AS_ALONE)
    assert rates([alone])[0, 1] == pytest.approx(1.7, rel=0.02)


def test_a_leg_of_more_lanes_than_a_group_has_its_own() -> None:
    """Nine joints have 18 unknowns and 20 lanes, of which the first and the seventeenth are nominal."""
    assert spring_tuning._shares([3, 3, 20, 14, 3, 13]) == [[0, 1], [2], [3], [4, 5]]


@pytest.mark.parametrize("size", [np.inf, np.nan, 1e200])
def test_tuning_without_a_finite_step_keeps_the_springs(
    wanted: WantedResponse, monkeypatch: pytest.MonkeyPatch, size: float
) -> None:
    """Derivatives of a leg that turns over ever faster: their squares are no numbers, and no equations are solved."""
    linearised = spring_tuning._linearised

    def diverged(*given: Any) -> list[tuple[Array, Array]]:
        answers = linearised(*given)
        for _, jacobian in answers:
            jacobian[:, -1] = size
        return answers

    monkeypatch.setattr(spring_tuning, "_linearised", diverged)
    softer = LEG.with_joints(knee={"spring": Spring(1.2, 2.0)})
    assert tuned_legs(wanted, [softer], [[1]]) == [softer]
