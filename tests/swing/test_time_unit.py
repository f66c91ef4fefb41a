"""A chain integrated in another unit of time moves the same, whatever effects it has."""

from __future__ import annotations

import numpy as np
import pytest

from fit.simulated_legs import robot
from swing.effects.test_mirror import GIVEN, TORQUES
from synth.swing.chain import compiled_chain
from synth.swing.effects import Effect
from synth.swing.leg_lanes import LegLanes
from synth.swing.leg_model import Damper, DamperCurve
from synth.swing.time_unit import USUAL_PACE, time_exponent, time_unit

TIMES = np.linspace(0.0, 0.8, 81)


@pytest.mark.parametrize("effect", TORQUES, ids=lambda effect: effect.name)
@pytest.mark.parametrize("unit", [0.2, 3.0])
def test_every_effect_is_independent_of_the_unit_of_time(effect: Effect, unit: float) -> None:
    made = robot(damper=[0.3, 0.02, 0.01]).with_joints(knee={"effects": {effect.name: GIVEN[effect.name]}})
    curve = DamperCurve((0.5, 2.0), (0.006, 0.015))
    made = made.with_joints(ankle={"damper": Damper(curve=curve)})
    legs = LegLanes.of(made)
    legs.drive[:, 0] = np.array([0.1, 0.02, 0.03])[:, None]
    chain = compiled_chain(3)
    lanes = chain.lanes(legs)
    lanes[chain.layout.rows("rotation")] = np.array([[0.5], [-1.3], [0.9]])
    lanes[chain.layout.rows("rate")] = np.array([[1.0], [-2.0], [3.0]])
    known = (TIMES, np.stack([0.5 * np.sin(9.0 * TIMES), 0.0 * TIMES, 0.0 * TIMES], axis=1))
    usual, other = (chain.run(lanes, TIMES, 1e-9, rates=True, known_torque=known, unit=one) for one in (1.0, unit))
    # bristles' micro-damping is a millisecond of either unit: 1e-3 rad where they hold, nothing else is in seconds
    close = 2e-3 if effect.bristle else 1e-5
    np.testing.assert_allclose(other[:, :3], usual[:, :3], atol=close)
    assert np.abs(other[:, 3:] - usual[:, 3:]).max() < 200.0 * close


@pytest.mark.parametrize(
    ("unit", "power"),
    [("N*m", -2), ("N*m*s/rad", -1), ("N*m*s^2/rad^2", 0), ("s/rad", 1), ("1/rad", 0), ("kg*m^2", 0), ("rad/s", -1)],
)
def test_the_power_of_time_in_a_unit(unit: str, power: int) -> None:
    assert time_exponent(unit) == power


def test_the_time_unit_of_a_limb_at_two_hertz_is_a_second() -> None:
    assert time_unit(2.0 * np.arcsin(0.25) / (4.0 * np.pi)) == pytest.approx(1.0, abs=0.01)
    assert time_unit(USUAL_PACE / 35.0) == pytest.approx(1.0 / 35.0)
    assert time_unit(0.0) == 1.0
