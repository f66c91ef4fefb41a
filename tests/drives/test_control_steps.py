"""Servos that look at their command and angle at control steps, and hold a stepped duty between."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from synth.arrays import Array
from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo, ServoSignals
from synth.files.leg_file import write_leg
from synth.files.recording import read_recording
from synth.swing.chain import compiled_chain, simulate
from synth.swing.leg_lanes import LegLanes
from synth.swing.leg_model import Joint, Leg, Link

LINK = Link(0.12, 0.49, 0.1, 1e-4)
MOTOR = GearedMotor(3.5, 0.37 / 200.0, 200.0, 0.9, 4e-8)
STEPPED = Servo(
    1.15, 0.01, 0.016, 0.01, current_limit=1.0, supply=7.4, source_resistance=0.5, motor=MOTOR,
    control_period=8e-3, duty_steps=40.0,
)  # fmt: skip
TIMES = np.linspace(0.0, 2.0, 401)
COMMAND = 0.8 * np.sin(2.0 * np.pi * 0.7 * TIMES) + 0.2 * np.sin(9.0 * TIMES)


def leg(servo: Servo, gravity: float = 9.81) -> Leg:
    return Leg("arm", (Joint("arm", LINK, drive=servo),), gravity=gravity)


def told(command: Array = COMMAND, supply: float = 7.4) -> ServoSignals:
    wide = np.ones((len(command), 1))
    return ServoSignals(TIMES, command[:, None], supply * wide, wide, (0,))


def inertia(servo: Servo) -> float:
    return LINK.inertia + LINK.mass * LINK.com**2 + (0.0 if servo.motor is None else servo.motor.reflected_inertia)


def stepped(servo: Servo) -> Array:
    """(m,) rad: from one control step to the next with scipy, a constant duty in each; nothing is shared but data."""
    motor, period = servo.motor, servo.control_period
    assert motor is not None
    x, found = np.zeros(2), [0.0]
    for k in range(math.ceil(TIMES[-1] / period)):
        sample = max(math.floor((k * period - servo.delay) / 0.005 + 1e-6), 0)
        error = COMMAND[sample] - x[0]
        error -= min(max(error, -servo.dead_band), servo.dead_band)
        duty = min(max(servo.gain * error - servo.damping_gain * x[1], -1.0), 1.0)
        duty = math.floor(duty * servo.duty_steps + 0.5) / servo.duty_steps if servo.duty_steps else duty

        def slope(_: float, x: Array, duty: float = duty) -> list[float]:
            ohms = motor.resistance + servo.source_resistance * duty**2
            current = (duty * servo.supply - motor.torque_constant * motor.gear_ratio * x[1]) / ohms
            current = min(max(current, -servo.current_limit), servo.current_limit)
            torque = current * motor.torque_constant * motor.gear_ratio * motor.efficiency
            return [x[1], (torque - LINK.mass * 9.81 * LINK.com * math.sin(x[0])) / inertia(servo)]

        end = min((k + 1) * period, TIMES[-1])
        first, last = np.searchsorted(TIMES, [k * period + 1e-9, end + 1e-9])
        seen = TIMES[first:last]
        part = solve_ivp(
            slope, (k * period, end), x, "DOP853", rtol=1e-11, atol=1e-13, max_step=1e-3, dense_output=True
        )
        found += part.sol(seen)[0].tolist() if len(seen) else []
        x = part.y[:, -1]
    return np.array(found)


@pytest.mark.parametrize(
    "servo",
    [
        replace(STEPPED, duty_steps=0.0, source_resistance=0.0),
        STEPPED,
        replace(STEPPED, control_period=3e-3, delay=0.006),
    ],
    ids=["held", "in steps", "period no multiple of the samples'"],
)
def test_each_duty_is_held_against_scipy(servo: Servo) -> None:
    found = simulate(leg(servo), [0.0], [0.0], TIMES, signals=told(), tolerance=1e-9)[:, 0]
    np.testing.assert_allclose(found, stepped(servo), atol=1e-6)
    looking = simulate(leg(replace(servo, control_period=0.0, duty_steps=0.0)), [0.0], [0.0], TIMES, signals=told())
    assert np.abs(found - looking[:, 0]).max() > 0.002


def test_a_held_torque_gives_the_discrete_closed_form() -> None:
    """Without gravity the state after each period is a linear map of the one before: no integration error."""
    period, servo = 0.02, Servo(1.2, 0.12, control_period=0.02)
    found = simulate(
        leg(servo, 0.0), [0.0], [0.0], TIMES, signals=told(np.full(401, 0.5), 1.0), rates=True, tolerance=1e-9
    )
    x, mass = np.zeros(2), inertia(servo)
    for k in range(0, 401, 4):
        np.testing.assert_allclose(found[k], x, atol=1e-8)
        acceleration = (1.2 * (0.5 - x[0]) - 0.12 * x[1]) / mass
        x = np.array([x[0] + period * x[1] + 0.5 * period**2 * acceleration, x[1] + period * acceleration])


def test_short_periods_tend_to_a_servo_that_looks_all_the_time() -> None:
    """The difference falls with the period, as a delay of half of it does."""
    servo = replace(STEPPED, duty_steps=0.0, delay=0.0, dead_band=0.0)
    smooth = ServoSignals(np.arange(0.0, 2.0, 1e-4), np.sin(5.0 * np.arange(0.0, 2.0, 1e-4))[:, None], *(
        [np.full((20000, 1), 7.4), np.ones((20000, 1))]
    ))  # fmt: skip
    base, *other = (
        simulate(leg(replace(servo, control_period=p)), [0.0], [0.0], TIMES[:-1], signals=smooth)[:, 0]
        for p in (0.0, 4e-3, 1e-3)
    )
    far, near = (np.abs(each - base).max() for each in other)
    assert 3.0 < far / near < 5.0


def test_lanes_share_their_control_steps_but_not_their_delays() -> None:
    """A motion is continuous in the delay, of which a fraction of a period is linear between two looks."""
    chain, lanes = compiled_chain(1), LegLanes.of(leg(STEPPED), 3)
    for lane, delay in enumerate((0.016, 0.0161, 0.02)):
        lanes.servo[:, 0, lane] = replace(STEPPED, delay=delay, duty_steps=0.0).numbers
    motion = chain.run(chain.lanes(lanes), TIMES, 1e-8, signals=told())[:, 0]
    alone = simulate(leg(replace(STEPPED, duty_steps=0.0)), [0.0], [0.0], TIMES, signals=told(), tolerance=1e-8)
    np.testing.assert_allclose(motion[:, 0], alone[:, 0], atol=2e-6)
    ratio = np.abs(motion[:, 1] - motion[:, 0]).max() / np.abs(motion[:, 2] - motion[:, 0]).max()
    assert ratio == pytest.approx(0.1 / 4.0, rel=0.1)


def test_a_winding_with_inductance_takes_up_each_duty_later() -> None:
    """Inductance over resistance after the look: against the current integrated from look to look."""
    lag = 5e-4
    servo = replace(STEPPED, motor=replace(MOTOR, inductance=lag * 3.5), duty_steps=0.0, source_resistance=0.0)
    servo = replace(servo, current_limit=np.inf, dead_band=0.0)
    found = simulate(leg(servo), [0.0], [0.0], TIMES, signals=told(), tolerance=1e-8)[:, 0]
    q = w = torque = duty = 0.0
    expected, step, mass = [], 1e-5, inertia(replace(servo, motor=MOTOR))
    for k in range(200001):
        if k % 500 == 0:
            expected.append(q)
        if k % 800 == 0:
            sample = max((k - 1600) // 500, 0)
            duty = min(max(servo.gain * (COMMAND[sample] - q) - servo.damping_gain * w, -1.0), 1.0)
        torque += step / lag * (MOTOR.strength * duty * 7.4 - MOTOR.short_circuit_damping * w - torque)
        w += step * (torque - LINK.mass * 9.81 * LINK.com * math.sin(q)) / mass
        q += step * w
    assert np.degrees(np.sqrt(np.mean((found - np.array(expected)) ** 2))) < 0.02


def test_the_unit_of_time_changes_nothing() -> None:
    chain = compiled_chain(1)
    lanes = chain.parameters(leg(STEPPED))[:, None]
    usual, slow = (chain.run(lanes, TIMES, 1e-9, signals=told(), unit=unit) for unit in (1.0, 5.0))
    np.testing.assert_allclose(slow, usual, atol=2e-6)


def test_a_recorded_command_is_read_as_the_controller_reads_it(tmp_path: Path) -> None:
    """No half sample later, as the straight lines of a servo that looks all the time are."""
    table = np.column_stack([TIMES, np.zeros(401), np.degrees(COMMAND)])
    np.savetxt(tmp_path / "log.csv", table, "%.9g", ",", header="time [s],arm [deg],arm command [deg]", comments="")
    write_leg(leg(STEPPED), tmp_path / "arm.leg.yaml")
    signals = read_recording(tmp_path / "log.csv", leg(STEPPED)).signals
    assert signals is not None
    found = simulate(leg(STEPPED), [0.0], [0.0], TIMES, signals=signals, tolerance=1e-9)[:, 0]
    np.testing.assert_allclose(found, stepped(STEPPED), atol=2e-6)
