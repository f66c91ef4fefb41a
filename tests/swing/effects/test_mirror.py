"""A leg seen in a mirror: every torque effect, in joints measured the other way round, gives the same angles."""

from __future__ import annotations

import numpy as np
import pytest

from fit.simulated_legs import robot
from synth.swing.chain import simulate
from synth.swing.effects import Effect, registered
from synth.swing.leg_model import Leg

# what each effect is given, in measured angle where that matters; ends of travel lie within the motion
GIVEN: dict[str, dict[str, float]] = {
    "backlash": {"gap": 0.1},
    "coulomb_friction": {"torque": 0.05},
    "gear_friction": {"torque": 0.05, "share": 0.1},
    "hardening_spring": {"stiffening": 2.0, "softening": 0.8},
    "joint_stop": {"upper": 1.95, "lower": 1.6, "stiffness": 20.0, "damping": 0.5},
    "load_friction": {"radius": 0.02, "share": 0.1},
    "one_sided_spring": {"loss_above": 0.7, "loss_below": -0.2, "shift": 0.05, "width": 0.01},
    "quadratic_damping": {"coefficient": 0.02},
    "shear_thinning_damping": {"loss": 0.8, "speed": 0.3},
    "spring_hysteresis": {"stiffness": 0.8, "slip": 0.1, "settled": 0.3},
    "stribeck_friction": {"torque": 0.06, "fall": 0.5, "speed": 0.5},
}
TORQUES = [effect for effect in registered() if effect.way == "torque" and effect.module.startswith("synth.")]
TORQUES = [effect for effect in TORQUES if effect.name != "winding_heating"]  # of a drive, which these legs have not


def legs(effect: Effect | None) -> tuple[Leg, Leg]:
    """The robot, whose ankle is measured clockwise, with the effect at knee and ankle; and its mirror image."""
    held = {} if effect is None else {effect.name: GIVEN[effect.name]}
    base = robot(damper=[0.3, 0.02, 0.01])
    right = base.with_joints(knee={"effects": held}, ankle={"effects": held})
    right = Leg("right", right.joints, right.gravity, tilt=0.2)
    mirrored = {joint.name: {"sign": -joint.sign} for joint in right.joints}
    return right, Leg("left", right.with_joints(**mirrored).joints, right.gravity, tilt=-0.2)


@pytest.mark.parametrize("effect", TORQUES, ids=lambda effect: effect.name)
def test_the_mirrored_leg_gives_the_same_readings(effect: Effect) -> None:
    right, left = legs(effect)
    release = np.radians([100.0, 130.0, 100.0])
    turning, times = np.array([1.0, -2.0, 3.0]), np.linspace(0, 1, 101)
    reading = [
        leg.to_measured(simulate(leg, leg.to_rotation(release), leg.sign * turning, times, tolerance=1e-8))
        for leg in (right, left)
    ]
    np.testing.assert_allclose(reading[0], reading[1], atol=1e-7)
    without = right.to_measured(
        simulate(legs(None)[0], right.to_rotation(release), right.sign * turning, times, tolerance=1e-8)
    )
    assert np.abs(reading[0] - without).max() > 0.01  # the effect is on
