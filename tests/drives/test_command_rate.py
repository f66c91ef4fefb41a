"""A servo that approaches its command at a limited rate, its profile velocity."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from synth.arrays import Array
from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo, ServoSignals
from synth.swing.chain import simulate
from synth.swing.leg_model import Joint, Leg, Link

SERVO = Servo(3.0, 0.01, supply=7.4, motor=GearedMotor(3.5, 0.37 / 200.0, 200.0, 0.9, 4e-8), command_rate_limit=2.0)
TIMES = np.linspace(0.0, 2.0, 401)
STEPS = np.repeat([0.0, 0.7, -0.5, -0.4, 0.9], 81)[:401]
SINES = 0.8 * np.sin(2.0 * np.pi * 0.7 * TIMES) + 0.2 * np.sin(9.0 * TIMES)


def arm(servo: Servo, **effects: dict[str, float]) -> Leg:
    return Leg("arm", (Joint("arm", Link(0.12, 0.49, 0.1, 1e-4), drive=servo, effects=effects),))


def told(time: Array, command: Array, *, held: bool = True) -> ServoSignals:
    wide = np.ones((len(time), 1))
    return ServoSignals(time, command[:, None], 7.4 * wide, wide, (0,) if held else ())


def moved(leg: Leg, signals: ServoSignals, tolerance: float = 1e-9) -> Array:
    """(m,) rad."""
    return simulate(leg, [0.0], [0.0], TIMES, signals=signals, tolerance=tolerance)[:, 0]


def slewed(command: Array, rate: float, late: float = 0.0) -> ServoSignals:
    """The limited command as lines, exactly: a knot where a sample arrives and where it is reached."""
    knots, values, now = [0.0], [command[0]], command[0]
    for k in range(len(TIMES) - 1):
        start, end = TIMES[k] + late, min(TIMES[k + 1] + late, 2.0 + late)
        needed = abs(command[k] - now) / rate
        if 1e-9 < needed < end - start - 1e-9:
            knots, values = [*knots, start + needed], [*values, command[k]]
        now += min(max(command[k] - now, -rate * (end - start)), rate * (end - start))
        knots, values = [*knots, end], [*values, now]
    if late > 0.0:
        knots, values = [knots[0], late, *knots[1:]], [values[0], command[0], *values[1:]]
    return told(np.array(knots), np.array(values), held=False)


@pytest.mark.parametrize(
    ("command", "rate", "late", "allowed"),
    [(STEPS, 2.0, 0.0, 1e-6), (STEPS, 2.0, 0.0123, 1e-6), (SINES, 2.0, 0.0, 2e-5), (SINES, 20.0, 0.0, 2e-5)],
    ids=["steps", "late", "sines", "fast"],
)
def test_a_servo_follows_its_own_slower_command(command: Array, rate: float, late: float, allowed: float) -> None:
    """Against the same engine told the limited command as lines."""
    servo = replace(SERVO, command_rate_limit=rate, delay=late)
    plain = replace(SERVO, command_rate_limit=0.0)
    wanted = moved(arm(replace(plain, linear_commands=True)), slewed(command, rate, late))
    found = moved(arm(servo), told(TIMES, command))
    np.testing.assert_allclose(found, wanted, atol=allowed)
    if rate < 10.0:
        assert float(np.abs(found - moved(arm(replace(plain, delay=late)), told(TIMES, command))).max()) > 0.05


def test_a_servo_with_control_steps_moves_its_command_once_a_step() -> None:
    servo = replace(SERVO, control_period=1e-3)
    plain = replace(SERVO, command_rate_limit=0.0, linear_commands=True)
    wanted = moved(arm(plain), slewed(STEPS, 2.0))
    assert float(np.abs(moved(arm(servo), told(TIMES, STEPS)) - wanted).max()) < 5e-3  # a step is half a step late


def test_the_effect_is_the_number_of_the_drive() -> None:
    stated = moved(arm(SERVO), told(TIMES, STEPS))
    plain = replace(SERVO, command_rate_limit=0.0)
    np.testing.assert_allclose(moved(arm(plain, command_rate_limit={"rate": 2.0}), told(TIMES, STEPS)), stated)
    slower = replace(SERVO, command_rate_limit=5.0)
    np.testing.assert_allclose(moved(arm(slower, command_rate_limit={"rate": 2.0}), told(TIMES, STEPS)), stated)
