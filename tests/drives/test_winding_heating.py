"""A warming winding against its closed form and scipy, and its identification from long logs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from synth.arrays import Array
from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo, ServoSignals
from synth.swing.chain import simulate
from synth.swing.leg_model import Joint, Leg, Link

LINK = Link(0.12, 0.49, 0.1, 1e-4)
WEIGHT = 0.49 * 9.81 * 0.1  # N m, of the link held level
MOTOR = GearedMotor(3.5, 0.37 / 200.0, 200.0, 0.9, 4e-8)
SERVO = Servo(gain=1.15, supply=7.4, motor=MOTOR)
HEAT = {"rise": 0.4, "reference": 0.3, "time": 12.0}
TIMES = np.arange(0.0, 60.0, 0.02)


def leg(**effects: dict[str, float]) -> Leg:
    return Leg("arm", (Joint("arm", LINK, drive=SERVO, effects=effects),))


def signals(command: Array) -> ServoSignals:
    wide = np.ones((len(TIMES), 1))
    return ServoSignals(TIMES, command[:, None], 7.4 * wide, wide)


def test_a_held_load_lets_the_joint_sag_as_the_winding_warms() -> None:
    """In the end the growth z of the resistance solves z (1 + z) = rise (T / reference)^2, T of a cold winding."""
    command = np.full(len(TIMES), 1.2)
    found = simulate(leg(winding_heating=HEAT), [1.0], [0.0], TIMES, signals=signals(command))[:, 0]
    q = found[-1]
    load = WEIGHT * np.sin(q)
    cold = MOTOR.strength * 7.4 * SERVO.gain * (1.2 - q)  # torque of the same duty from a cold winding
    growth = cold / load - 1.0
    assert growth == pytest.approx(HEAT["rise"] * (cold / HEAT["reference"]) ** 2 / (1.0 + growth), rel=0.02)
    assert growth > 0.3
    assert found[100] - q > 0.05


@pytest.mark.parametrize("ohms", [0.0, 2.0])
def test_a_moving_joint_against_scipy(ohms: float) -> None:
    """The winding warms, its source does not: R (1 + z) + d^2 times the source's resistance."""
    command = 0.7 + 0.4 * np.sin(2.0 * TIMES)
    made = leg(winding_heating=HEAT).with_joints(arm={"drive": replace(SERVO, source_resistance=ohms)})
    found = simulate(made, [0.5], [0.0], TIMES[:1001], signals=signals(command), tolerance=1e-9)
    inertia = LINK.inertia + LINK.mass * LINK.com**2 + MOTOR.reflected_inertia

    def slope(t: float, x: Array) -> list[float]:
        error = float(np.interp(t, TIMES, command)) - x[0]
        duty = min(max(SERVO.gain * error, -1.0), 1.0)
        warm = replace(MOTOR, resistance=MOTOR.resistance * (1.0 + x[2]) + ohms * duty**2)
        drive = float(replace(SERVO, motor=warm).torque(np.array(error), np.array(x[1]), 7.4))
        heat = HEAT["rise"] * (drive / HEAT["reference"]) ** 2 * (1.0 + x[2])
        return [x[1], (drive - WEIGHT * np.sin(x[0])) / inertia, (heat - x[2]) / HEAT["time"]]

    told = solve_ivp(slope, (0.0, 20.0), [0.5, 0.0, 0.0], "RK45", TIMES[:1001], rtol=1e-7, atol=1e-9, max_step=0.02)
    np.testing.assert_allclose(found[:, 0], told.y[0], atol=2e-5)
    without = simulate(leg(), [0.5], [0.0], TIMES[:1001], signals=signals(command))[:, 0]
    assert np.abs(found[:, 0] - without).max() > 0.04


def test_a_limited_current_is_held_until_the_warm_winding_no_longer_reaches_it() -> None:
    """Pressed against its limit with twice the voltage that the cold winding needs: a growth of 0.4 takes nothing."""
    servo = replace(SERVO, current_limit=0.45 * 7.4 * SERVO.gain * 1.0 / MOTOR.resistance)
    limit = servo.numbers[7]
    assert 0.2 < limit < WEIGHT  # it cannot lift the link level
    heat = {"rise": 0.4, "reference": limit, "time": 12.0}
    command = np.full(len(TIMES), 1.8)
    start = [float(np.arcsin(limit / WEIGHT))]  # at rest on its limit
    cool, warm = (
        simulate(
            Leg("arm", (Joint("arm", LINK, drive=servo, effects=effects),)),
            start, [0.0], TIMES, signals=signals(command),
        )[:, 0]
        for effects in ({}, {"winding_heating": heat})
    )  # fmt: skip
    reached = float(SERVO.torque(np.array(1.8 - start[0]), np.array(0.0), 7.4))
    assert reached > 1.5 * limit
    np.testing.assert_allclose(warm, cool, atol=1e-4)
    weak = simulate(
        Leg("arm", (Joint("arm", LINK, drive=servo, effects={"winding_heating": {**heat, "rise": 1.2}}),)),
        start, [0.0], TIMES, signals=signals(command),
    )[:, 0]  # fmt: skip
    assert weak[-1] < cool[-1] - 0.05
