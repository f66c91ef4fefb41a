"""A damper in the forms of other engines' joints."""

from __future__ import annotations

import numpy as np
import pytest

from synth.files.joint_curves import linear_damping
from synth.swing.leg_model import Damper, Joint, Link


@pytest.mark.parametrize(("drag", "told"), [(0.0, ""), (0.004, "its torque is 1.4 times the damper's")])
def test_the_loss_of_a_straight_line_is_told_for_fast_and_slow_motion(drag: float, told: str) -> None:
    """0.0601 w + 0.004 w^2 up to 7.94 rad/s was "at most 9 % of its torque" off, and 40 % at rest."""
    effects = {"quadratic_damping": {"coefficient": drag}} if drag else {}
    joint = Joint("hip", Link(0.1, 0.1, 0.05, 1e-4), damper=Damper(0.0601), effects=effects)
    rate, words = linear_damping(joint, 7.94)
    speed = np.linspace(0.0, 7.94, 1000)
    worst = np.abs(rate * speed - 0.0601 * speed - drag * speed**2).max() / (0.0601 * 7.94 + drag * 7.94**2)
    assert words.endswith(told)
    assert (words == "") == (drag == 0.0)
    assert drag == 0.0 or f"off by at most {worst:.0%} of its largest torque up to 75.8 rpm" in words
