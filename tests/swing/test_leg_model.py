"""The sense of measured angles."""

from __future__ import annotations

import numpy as np

from synth.swing.leg_model import Joint, Leg, Link

LEG = Leg("two", (Joint("hip", Link(0.2, 0.3, 0.1, 1e-3), zero=0.5), Joint("knee", Link(0.2, 0.3, 0.1, 1e-3), 2.0, -1)))


def test_a_measured_angle_is_zero_plus_sign_times_the_rotation() -> None:
    np.testing.assert_allclose(LEG.to_measured(np.array([0.3, 0.3])), [0.8, 1.7])
    np.testing.assert_allclose(LEG.to_rotation(np.array([0.8, 1.7])), [0.3, 0.3])
