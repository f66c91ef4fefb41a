"""The response of the whole leg as the measure of a choice."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

from synth.design.response import WantedRelease, WantedResponse
from synth.swing.chain import Conditions
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring
from synth.swing.mechanics import rest_pose

LEG = Leg(
    "two links",
    (
        Joint("hip", Link(0.22, 0.22, 0.08, 1.1e-3), np.pi / 2, 1, None, Spring(20.0, 1.8), Damper(1.0)),
        Joint("knee", Link(0.22, 0.2, 0.075, 1.1e-3), np.pi, -1, None, Spring(1.7, 2.0), Damper(0.1)),
    ),
)
TIME = np.linspace(0.0, 1.0, 101)


@pytest.fixture(scope="module")
def wanted() -> WantedResponse:
    releases = [
        WantedRelease("a", TIME, np.array([0.1, 1.4]), np.zeros(2), Conditions()),
        WantedRelease("b", TIME, np.array([0.5, 0.9]), np.array([0.0, -2.0]), Conditions()),
    ]
    return WantedResponse.of(LEG, releases)


def test_the_wanted_leg_has_no_error(wanted: WantedResponse) -> None:
    assert wanted.errors([LEG]).max() < 1e-12


def test_errors_are_the_root_mean_square_of_the_difference(wanted: WantedResponse) -> None:
    other = LEG.with_joints(knee={"spring": Spring(2.5, 2.0)})
    motions = [motion[:, :, 0] for motion in wanted.simulate([other])]
    difference = np.concatenate([m - w for m, w in zip(motions, wanted.motions, strict=True)])
    assert wanted.errors([other])[0] == pytest.approx(np.sqrt(np.mean(difference**2, axis=0)), rel=1e-9)


def test_a_locked_joint_has_no_error() -> None:
    release = WantedRelease("a", TIME, np.array([0.1, 1.4]), np.zeros(2), Conditions(locked=(1,)))
    wanted = WantedResponse.of(LEG, [release])
    other = LEG.with_joints(knee={"spring": Spring(9.0, 2.0)})
    assert wanted.errors([other])[0] == pytest.approx([0.0, 0.0], abs=1e-12)


def test_at_rest_like_wanted_keeps_the_rest_pose(wanted: WantedResponse) -> None:
    other = LEG.with_joints(hip={"spring": Spring(6.0, 0.0)}, knee={"spring": Spring(4.0, 0.0)})
    moved = wanted.at_rest_like_wanted(other)
    assert rest_pose(moved) == pytest.approx(rest_pose(LEG), abs=1e-9)


def test_a_response_survives_pickling(wanted: WantedResponse) -> None:
    """Also after it was simulated, when its chain holds machine code."""
    wanted.errors([LEG])
    again = pickle.loads(pickle.dumps(wanted))
    assert again.errors([LEG]).tolist() == wanted.errors([LEG]).tolist()


def test_a_leg_that_cannot_be_simulated_gets_the_largest_error(wanted: WantedResponse) -> None:
    stiff = replace(LEG, joints=(LEG.joints[0], replace(LEG.joints[1], damper=Damper(1e7))))
    assert wanted.errors([stiff]).max() == pytest.approx(np.pi)
