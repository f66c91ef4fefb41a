"""The rest pose to which a leg's motion leads, of several that a weak spring leaves it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from synth.design.settled_pose import settled_pose
from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring
from synth.swing.mechanics import rest_pose

MASS, COM, RATE, FREE = 0.2, 0.1, 0.01, np.radians(518.0)  # kg, m, N m/rad; the spring is unloaded 1.4 turns away
PENDULUM = Leg(
    "a",
    (Joint("hip", Link(0.2, MASS, COM, 0.001), spring=Spring(RATE, float(FREE)), damper=Damper(0.02)),),
)


def test_of_several_equilibria_it_is_the_one_that_the_motion_ends_in() -> None:
    def torque(angle: float) -> float:
        return RATE * (angle - FREE) + MASS * PENDULUM.gravity * COM * np.sin(angle)

    expected = brentq(torque, 0.0, 1.2)
    assert abs(rest_pose(PENDULUM)[0] - expected) > 4.0  # from the free angle
    motion = simulate(PENDULUM, [0.0], [0.0], np.linspace(0.0, 3.0, 301))
    assert motion[-1, 0] == pytest.approx(expected, abs=1e-3)
    assert settled_pose(PENDULUM, [motion], [[]])[0] == pytest.approx(expected, abs=1e-9)


def test_a_trial_in_which_a_joint_is_locked_tells_nothing_of_its_rest() -> None:
    expected = settled_pose(PENDULUM, [np.full((10, 1), 0.4)], [[]])
    held = np.full((10, 1), FREE)
    assert settled_pose(PENDULUM, [held, np.full((10, 1), 0.4)], [[0], []]) == pytest.approx(expected)
    assert settled_pose(PENDULUM, [held], [[0]]) == pytest.approx(rest_pose(PENDULUM))


def test_motions_that_diverge_are_left_out() -> None:
    assert settled_pose(PENDULUM, [np.full((10, 1), np.nan)], [[]]) == pytest.approx(rest_pose(PENDULUM))
