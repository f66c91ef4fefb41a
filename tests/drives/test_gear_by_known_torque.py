"""Friction of a gear by the torque of a motor whose current is recorded, against scipy."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from synth.swing.chain import simulate
from synth.swing.leg_model import Joint, Leg, Link

LINK = Link(0.2, 0.4, 0.12, 2e-3)
TIMES = np.linspace(0.0, 1.5, 151)
MOMENTS = np.linspace(0.0, 1.5, 301)
TORQUE = 0.5 * np.sin(6.0 * MOMENTS) + 0.3 * np.sin(17.0 * MOMENTS)
SHARE, DRY = 0.2, 0.01


def by_scipy(factor: float) -> np.ndarray:
    about = LINK.inertia + LINK.mass * LINK.com**2

    def slope(t: float, x: np.ndarray) -> list[float]:
        driven = factor * float(np.interp(t, MOMENTS, TORQUE))
        friction = (DRY + SHARE * abs(driven)) * math.tanh(x[1] / 1e-3)
        return [x[1], (driven - friction - LINK.mass * 9.81 * LINK.com * math.sin(x[0])) / about]

    solved = solve_ivp(slope, (0.0, TIMES[-1]), [0.4, 0.0], "LSODA", TIMES, rtol=1e-8, atol=1e-10, max_step=2e-3)
    return np.asarray(solved.y[0])


@pytest.mark.parametrize("gain", [0.0, 0.15])
def test_a_known_torque_loads_the_gear(gain: float) -> None:
    """The share was left out where the torque is recorded; what the torque is off by is a load of the gear too."""
    effects = {"gear_friction": {"share": SHARE, "torque": DRY}}
    if gain:
        effects["torque_gain"] = {"share": gain}
    leg = Leg("arm", (Joint("arm", LINK, effects=effects),))
    plain = Leg("arm", (Joint("arm", LINK, effects={"gear_friction": {"share": 0.0, "torque": DRY}}),))
    expected = by_scipy(1.0 + gain)
    ours, without = (
        simulate(each, [0.4], [0.0], TIMES, known_torque=(MOMENTS, TORQUE[:, None]))[:, 0] for each in (leg, plain)
    )
    assert np.sqrt(np.mean((ours - expected) ** 2)) < 0.01 * np.sqrt(np.mean((without - expected) ** 2))
