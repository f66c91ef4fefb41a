"""A joint that creeps where dry friction would hold it: friction as a smoothed sign, which no bristle imitates."""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import solve_ivp

from diagnosis.simulated_releases import NOISE, TIME, TWO, causes, off
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose
from synth.files.tolerance import Tolerance
from synth.files.trial_list import Trial
from synth.swing.leg_model import Leg
from synth.swing.mechanics import coefficients

ONE = Leg("pendulum", TWO.joints[1:])
TORQUE, SPEED = 0.06, 0.02  # N m; rad/s of the tanh, as grease has it
AWAY = (0.6, 0.7, -0.6, -0.8, 0.4)


def creeping(leg: Leg, seed: int) -> list[Trial]:
    """Releases of one link with the friction TORQUE tanh(w / SPEED), by scipy."""
    (joint,), found = leg.joints, coefficients(leg)
    assert joint.spring is not None
    assert joint.damper is not None
    rate, rest, drag = joint.spring.rate, float(leg.rest[0]), joint.damper.rate
    generator = np.random.default_rng(seed)

    def derivative(_: float, state: np.ndarray) -> list[float]:
        q, w = state
        weight = float(found.gravity[0]) * math.sin(q + leg.tilt)
        torque = -rate * (q - rest) - drag * w - TORQUE * math.tanh(w / SPEED) - weight
        return [w, torque / float(found.inertia[0, 0])]

    trials = []
    for index, by in enumerate(AWAY):
        solved = solve_ivp(derivative, (0, TIME[-1]), [rest + by, 0.0], "LSODA", TIME, rtol=1e-9, atol=1e-10)
        angles = leg.to_measured(solved.y[0][:, None]) + 0.1 * NOISE * generator.standard_normal((len(TIME), 1))
        trials.append(Trial(f"{index}.csv", TIME, angles, held_out=index >= 3))
    return trials


def test_friction_that_creeps_is_found_alone_down_to_the_noise() -> None:
    result = diagnose(ONE, creeping(off(ONE, 4), 2), Tolerance())
    assert result.verdict == "effect"
    assert causes(result) == [("coulomb_friction", "knee")]
    (cause,) = result.explanation
    assert abs(cause.parameters["torque"].value / TORQUE - 1.0) < 0.05
    # the cubic that the bristle slides by is nearest to tanh at 1.5 times its speed
    assert SPEED < cause.parameters["creep"].value < 2.0 * SPEED
    assert result.after.value < 1.6 * result.noise_floor.value  # nothing else is left of 260 floors
