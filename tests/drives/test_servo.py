"""A servo-driven joint against closed forms and scipy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo, ServoSignals
from synth.swing.chain import compiled_chain, simulate
from synth.swing.leg_lanes import LegLanes
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

LINK = Link(0.12, 0.49, 0.1, 1e-4)
WEIGHT = 0.49 * 9.81 * 0.1  # N m, of the link held level
MOTOR = GearedMotor(3.5, 0.37 / 200.0, 200.0, 0.9, 4e-8)
SERVO = Servo(
    gain=1.15, damping_gain=0.01, delay=0.004, dead_band=0.01, supply=7.4, current_limit=1.0, source_resistance=0.5,
    motor=MOTOR,
)  # fmt: skip
TIMES = np.linspace(0.0, 2.0, 401)


def leg(servo: Servo, **more: float) -> Leg:
    return Leg("arm", (Joint("arm", LINK, drive=servo, **more),))  # type: ignore[arg-type]


def told(command: np.ndarray, supply: float = 7.4, enabled: np.ndarray | float = 1.0) -> ServoSignals:
    wide = np.ones((len(command), 1))
    return ServoSignals(TIMES, command[:, None], supply * wide, np.reshape(enabled, (-1, 1)) * wide)


def held(servo: Servo, command: float) -> float:
    """Angle at which the servo holds a constant command, from a start near it."""
    damped = Leg("arm", (Joint("arm", LINK, drive=servo, damper=Damper(0.2)),))
    signals = told(np.full(401, command), servo.supply)
    return float(simulate(damped, [command], [0.0], 3.0 * TIMES, signals=signals)[-1, 0])


def test_a_held_joint_sags_in_proportion_to_load_over_gain() -> None:
    """Rest of a proportional controller: gain (command - q) = weight sin q."""
    plain = Servo(gain=20.0)
    q = held(plain, 1.0)
    assert 20.0 * (1.0 - q) == pytest.approx(WEIGHT * np.sin(q), rel=1e-6)


def test_a_motor_sags_by_its_stiffness_and_its_dead_band() -> None:
    """At rest the torque is strength times supply times duty; the dead band adds to the error."""
    servo = replace(SERVO, source_resistance=0.0, delay=0.0, dead_band=0.02)
    q = held(servo, 0.6)
    torque = MOTOR.strength * 7.4 * 1.15 * (0.6 - q - 0.02)
    assert MOTOR.strength == pytest.approx(0.37 * 0.9 / 3.5)
    assert torque == pytest.approx(WEIGHT * np.sin(q), rel=1e-5)


def test_a_current_limit_lets_the_arm_hang_where_it_can_be_held() -> None:
    """What the limit cannot lift hangs at asin(limit / weight), whatever is commanded."""
    servo = replace(SERVO, gain=50.0, current_limit=0.5, source_resistance=0.0)
    limit = 0.5 * MOTOR.torque_a_current
    assert limit < WEIGHT
    arm = Leg("arm", (Joint("arm", LINK, drive=servo, damper=Damper(0.3)),))
    q = simulate(arm, [0.1], [0.0], 4.0 * TIMES, signals=told(np.full(401, 1.5)))[-1, 0]
    assert q == pytest.approx(np.arcsin(limit / WEIGHT), abs=1e-4)


def test_free_speed_of_a_motor_under_a_known_voltage() -> None:
    """Without load a motor turns at voltage over its constant; its time constant is inertia over back-EMF damping."""
    motor = replace(MOTOR, efficiency=1.0)
    servo = Servo(gain=0.0, open_duty=1.0, motor=motor)
    arm = replace(leg(servo), gravity=0.0)
    signals = ServoSignals(TIMES, np.zeros((401, 1)), np.full((401, 1), 3.0), np.ones((401, 1)))
    motion = simulate(arm, [0.0], [0.0], TIMES, signals=signals, rates=True, tolerance=1e-8)
    inertia = LINK.inertia + LINK.mass * LINK.com**2 + motor.reflected_inertia
    expected = 3.0 / 0.37 * (1.0 - np.exp(-TIMES * motor.short_circuit_damping / inertia))
    np.testing.assert_allclose(motion[:, 1], expected, atol=2e-5)


def test_a_sagging_supply_adds_its_resistance_to_the_winding() -> None:
    """Held level by a full duty: the current is that of source and winding in series."""
    motor, share = replace(MOTOR, efficiency=1.0), 0.3
    servo = Servo(gain=1e3, supply=7.4, source_resistance=share * 3.5, motor=motor)
    torque = servo.torque(np.array([1.0]), np.array([0.0]), 7.4)
    assert torque[0] == pytest.approx(0.37 * 7.4 / (3.5 * (1.0 + share)))


def test_a_moving_servo_against_scipy() -> None:
    """Delay, dead band, current limit, sagging supply and a switch, at once."""
    command = 1.2 * np.sin(2.0 * np.pi * 0.7 * TIMES) + 0.3 * np.sin(9.0 * TIMES)
    enabled = np.clip((1.6 - TIMES) / 0.005, 0.0, 1.0)
    signals = told(command, enabled=enabled)
    found = simulate(leg(SERVO, armature=1.8e-3), [0.0], [0.0], TIMES, signals=signals, tolerance=1e-8)[:, 0]
    inertia = LINK.inertia + LINK.mass * LINK.com**2 + 1.8e-3 + MOTOR.reflected_inertia

    def derivative(time: float, x: np.ndarray) -> list[float]:
        wanted, supply, on = signals.at(np.array([time]), np.array([SERVO.delay]))
        torque = SERVO.torque(wanted[0] - x[0], x[1:], supply[0], on[0])[0]
        return [x[1], (torque - WEIGHT * np.sin(x[0])) / inertia]

    expected = solve_ivp(derivative, (0.0, 2.0), [0.0, 0.0], "RK45", TIMES, rtol=1e-8, atol=1e-9, max_step=2.5e-3).y[0]
    np.testing.assert_allclose(found, expected, atol=5e-6)


def test_lanes_may_differ_in_every_number_of_the_servo() -> None:
    """A lane with a later command moves as a leg of that delay does alone."""
    command = 0.8 * np.sin(7.0 * TIMES)
    slow = replace(SERVO, delay=0.03)
    lanes = LegLanes.of(leg(SERVO), 2)
    lanes.servo[:, 0, 1] = slow.numbers
    chain = compiled_chain(1)
    both = chain.run(chain.lanes(lanes), TIMES, 1e-8, signals=told(command))[:, 0]
    alone = [
        simulate(leg(servo), [0.0], [0.0], TIMES, signals=told(command), tolerance=1e-8)[:, 0]
        for servo in (SERVO, slow)
    ]
    np.testing.assert_allclose(both, np.stack(alone, axis=1), atol=2e-6)
    assert np.abs(alone[0] - alone[1]).max() > 0.02


def test_time_counted_in_another_unit_changes_nothing() -> None:
    command = 0.8 * np.sin(7.0 * TIMES)
    arm = Leg("arm", (Joint("arm", LINK, spring=Spring(0.3, 0.1), drive=SERVO),))
    chain = compiled_chain(1)
    lanes = chain.parameters(arm)[:, None]
    usual, slow = (chain.run(lanes, TIMES, 1e-8, signals=told(command), unit=unit) for unit in (1.0, 5.0))
    np.testing.assert_allclose(slow, usual, atol=2e-6)


@pytest.mark.parametrize(("command", "ratio"), [(1.0, 1.0 / (1.0 - 0.2)), (-1.0, 1.0 / (1.0 + 0.2))])
def test_a_lossy_gear_needs_more_torque_to_lift_and_less_to_lower(command: float, ratio: float) -> None:
    """At constant slow speed the drive gives weight / (1 - share) upwards and weight / (1 + share) downwards."""
    servo = Servo(gain=40.0, damping_gain=1.0)
    arm = Leg("arm", (Joint("arm", LINK, drive=servo, effects={"gear_friction": {"share": 0.2}}),))
    start = 0.5 if command > 0.0 else 1.2
    ramp = start + 0.3 * command * TIMES
    found = simulate(arm, [start], [0.3 * command], TIMES, signals=told(ramp, 1.0), tolerance=1e-8, rates=True)
    angle, rate = found[TIMES > 1.0].T
    torque = 40.0 * (ramp[TIMES > 1.0] - angle) - 1.0 * rate
    np.testing.assert_allclose(torque, ratio * WEIGHT * np.sin(angle), rtol=1e-4)
