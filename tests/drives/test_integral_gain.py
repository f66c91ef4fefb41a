"""Servos with an integral gain: against closed forms and scipy."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from synth.arrays import Array
from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo, ServoSignals, integral_along
from synth.files.drive_terms import drive_terms
from synth.swing.chain import compiled_chain, simulate
from synth.swing.integral_starts import held_integrals
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring, Tip

LINK = Link(0.12, 0.49, 0.1, 1e-4)
INERTIA = LINK.inertia + LINK.mass * LINK.com**2
WEIGHT = 0.49 * 9.81 * 0.1  # N m, of the link held level
MOTOR = GearedMotor(3.5, 0.37 / 200.0, 200.0, 0.9, 4e-8)
TORQUE = Servo(20.0, 0.6, dead_band=0.004, torque_limit=3.0, integral_gain=60.0, integral_limit=0.4)
DUTY = Servo(
    1.15, 0.02, 0.01, supply=7.4, source_resistance=0.5, duty_limit=0.9, motor=MOTOR, integral_gain=6.0,
    integral_limit=0.4,
)  # fmt: skip
TIMES = np.linspace(0.0, 2.0, 401)
COMMAND = np.where(TIMES < 0.1, 0.3, np.where(TIMES < 0.9, 1.2, 0.5 + 0.3 * np.sin(9.0 * TIMES)))


def leg(servo: Servo, gravity: float = 9.81) -> Leg:
    joint = Joint("arm", LINK, spring=Spring(0.3, 0.1), damper=Damper(0.02), drive=servo)
    return Leg("arm", (joint,), gravity=gravity)


def told(servo: Servo, command: Array = COMMAND, enabled: Array | float = 1.0) -> ServoSignals:
    wide = np.ones((len(command), 1))
    supply = 1.0 if servo.motor is None else servo.supply
    return ServoSignals(TIMES, command[:, None], supply * wide, np.reshape(enabled, (-1, 1)) * wide, (0,))


def expected(servo: Servo, start: float, enabled: Array) -> Array:
    """(m,) rad: from command to command, or from look to look, with scipy; the law is written out once more."""
    motor, period = servo.motor, servo.control_period
    volts = 1.0 if motor is None else servo.supply
    strength = 1.0 if motor is None else motor.torque_a_current / motor.resistance
    braking = 0.0 if motor is None else strength * motor.induced * motor.gear_ratio
    sag = 0.0 if motor is None else servo.source_resistance / motor.resistance
    whole = servo.torque_limit if motor is None else servo.duty_limit
    most = min(servo.integral_limit, whole)
    rotor = 0.0 if motor is None else motor.rotor_inertia * motor.gear_ratio**2

    def beyond(command: float, angle: float) -> float:
        error = command - angle
        return math.copysign(max(abs(error) - servo.dead_band, 0.0), error)

    def duty(command: float, x: Array, integral: float) -> float:
        wanted = servo.gain * beyond(command, x[0]) - servo.damping_gain * x[1] + integral
        return min(max(wanted, -whole), whole)

    load = WEIGHT * math.sin(start) + 0.3 * (start - 0.1)
    holding = load / (strength * volts)
    for _ in range(50):
        holding = load * (1.0 + sag * holding**2) / (strength * volts)
    x, found, held = np.array([start, 0.0, min(max(holding, -most), most)]), [start], 0.0
    edges = np.arange(0.0, TIMES[-1] + 1e-9, period or 0.005)
    for k, (begin, end) in enumerate(pairwise(edges.tolist())):
        sample = max(math.floor((begin - servo.delay) / 0.005 + 1e-6), 0)
        command = float(COMMAND[sample])
        at_look = float(np.interp(begin, TIMES, enabled))
        if period:
            if k:
                x[2] = min(max(x[2] + at_look * period * servo.integral_gain * beyond(command, x[0]), -most), most)
            held = duty(command, x, x[2])

        def slope(time: float, x: Array, command: float = command, held: float = held) -> list[float]:
            on = float(np.interp(time, TIMES, enabled))
            change = 0.0 if period else servo.integral_gain * beyond(command, x[0])
            change = 0.0 if abs(x[2]) >= most and change * x[2] > 0.0 else change
            d = held if period else duty(command, x, x[2])
            torque = (strength * d * volts - braking * x[1]) / (1.0 + sag * d * d)
            rest = WEIGHT * math.sin(x[0]) + 0.3 * (x[0] - 0.1) + 0.02 * x[1]
            return [x[1], (on * torque - rest) / (INERTIA + rotor), on * change]

        seen = np.array([t for t in TIMES if begin + 1e-9 < t <= end + 1e-9])
        part = solve_ivp(slope, (begin, end), x, "RK45", rtol=1e-9, atol=1e-11, dense_output=True, max_step=1e-3)
        found += part.sol(np.minimum(seen, end))[0].tolist() if len(seen) else []
        x = part.y[:, -1]
    return np.array(found)


@pytest.mark.parametrize("servo", [TORQUE, DUTY], ids=["torque", "duty"])
def test_an_integral_removes_the_sag_under_load(servo: Servo) -> None:
    """At rest the error is zero where the integral can carry the load, however small the gain; without it, it sags."""
    held, sagging = (
        simulate(leg(each), [0.3], [0.0], 3.0 * TIMES, signals=told(each, np.full(401, 0.8)))[-1, 0]
        for each in (
            replace(servo, integral_limit=np.inf, dead_band=0.0),
            replace(servo, integral_gain=0.0, dead_band=0.0),
        )
    )
    assert held == pytest.approx(0.8, abs=1e-5)
    assert sagging < 0.8 - 0.02


def test_an_integral_carries_load_up_to_its_limit() -> None:
    """What its limit leaves of the load sags by the gain: gain (command - q) + limit = load(q)."""
    servo = replace(TORQUE, dead_band=0.0)
    q = simulate(leg(servo), [0.3], [0.0], 3.0 * TIMES, signals=told(servo, np.full(401, 1.2)))[-1, 0]
    assert 20.0 * (1.2 - q) + 0.4 == pytest.approx(WEIGHT * math.sin(q) + 0.3 * (q - 0.1), abs=1e-5)


@pytest.mark.parametrize("servo", [TORQUE, DUTY], ids=["torque", "duty"])
def test_a_joint_that_a_servo_has_held_stays(servo: Servo) -> None:
    """The integral begins with the whole load that gravity and spring have at the first angle."""
    still = simulate(leg(servo), [0.3], [0.0], TIMES, signals=told(servo, np.full(401, 0.3)), tolerance=1e-9)
    np.testing.assert_allclose(still, 0.3, atol=1e-7)


@pytest.mark.parametrize(
    "servo",
    [
        TORQUE,
        DUTY,
        replace(TORQUE, control_period=0.01),
        replace(DUTY, control_period=0.01),
        replace(TORQUE, integral_limit=math.inf, torque_limit=0.9),
        replace(DUTY, integral_limit=math.inf, duty_limit=0.5),
    ],
    ids=["torque", "duty", "torque in steps", "duty in steps", "limit of the torque", "limit of the duty"],
)
def test_steps_with_windup_against_scipy(servo: Servo) -> None:
    """Large steps drive the integral to its limit and back; it waits while the drive is off."""
    enabled = np.clip(np.abs(TIMES - 1.6) / 0.02 - 2.0, 0.0, 1.0)
    signals = told(servo, enabled=enabled)
    found = simulate(leg(servo), [0.3], [0.0], TIMES, signals=signals, tolerance=1e-9)[:, 0]
    np.testing.assert_allclose(found, expected(servo, 0.3, enabled), atol=5e-6)
    without = simulate(leg(replace(servo, integral_gain=0.0)), [0.3], [0.0], TIMES, signals=signals)[:, 0]
    assert np.abs(found - without).max() > 0.02


@pytest.mark.parametrize("servo", [TORQUE, DUTY], ids=["torque", "duty"])
def test_torques_along_a_motion_have_the_integral(servo: Servo) -> None:
    """As a recording's are found without a simulation: inertia times acceleration and the load are their sum."""
    plain = replace(servo, delay=0.0)
    command = 0.5 + 0.4 * np.sin(4.0 * TIMES)
    signals = replace(told(plain, command), held=())
    angle, rate = simulate(leg(plain), [0.5], [0.0], TIMES, signals=signals, rates=True, tolerance=1e-9).T
    supply = signals.supply[:, 0]
    start = held_integrals(leg(plain), Tip(), 0.0, angle[:1], supply[:1])[0]
    error = command - angle
    integral = integral_along(TIMES, error, np.ones(401), np.array(plain.numbers), start)
    driven = plain.torque(error, rate, supply, 1.0, integral)
    rotor = 0.0 if plain.motor is None else plain.motor.reflected_inertia
    needed = (INERTIA + rotor) * np.gradient(rate, TIMES) + WEIGHT * np.sin(angle) + 0.3 * (angle - 0.1) + 0.02 * rate
    np.testing.assert_allclose(driven[5:-5], needed[5:-5], atol=0.02)
    assert np.abs(plain.torque(error, rate, supply) - needed).max() > 0.1


def test_what_simulators_lack_is_said() -> None:
    terms = drive_terms(leg(TORQUE))[0]
    assert terms is not None
    assert any("integral" in each for each in terms.lost)
    without = drive_terms(leg(replace(TORQUE, integral_gain=0.0)))[0]
    assert without is not None
    assert not any("integral" in each for each in without.lost)


def test_the_unit_of_time_changes_nothing() -> None:
    chain = compiled_chain(1)
    lanes = chain.parameters(leg(DUTY))[:, None]
    lanes[chain.layout.rows("rotation")] = 0.3
    usual, slow = (chain.run(lanes, TIMES, 1e-9, signals=told(DUTY), unit=unit) for unit in (1.0, 5.0))
    np.testing.assert_allclose(slow, usual, atol=2e-6)
