"""Errors within tolerances in the diagnosis's columns, and in the leg that it writes, are the same leg."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest

from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo, TorqueDrive
from synth.files.tolerance import Tolerance
from synth.swing.lane_layout import SERVO
from synth.swing.leg_lanes import LegLanes
from synth.swing.leg_model import MOST_LAGGED, Damper, Joint, Leg, Link, Spring
from synth.swing.tolerances import QUANTITIES, Tolerances

MOTOR = GearedMotor(2.0, 0.02, gear_ratio=50.0, efficiency=0.8, rotor_inertia=2e-6, inductance=2e-3)
BARE = replace(MOTOR, rotor_inertia=0.0)  # its lag takes more than the rotor has
POSITION = Servo(5.0, 0.05, delay=0.01, current_limit=3.0, supply=12.0, source_resistance=0.3, motor=MOTOR)
DRIVES = {
    "position": POSITION,
    "no inductance": replace(POSITION, motor=replace(MOTOR, inductance=0.0)),
    "no rotor": replace(POSITION, motor=BARE),
    "control steps": replace(POSITION, control_period=2e-3, duty_steps=255.0),
    "limits": replace(POSITION, torque_limit=1.5, dead_band=0.01, command_rate_limit=3.0, duty_limit=0.8),
    "back-EMF by itself": replace(POSITION, motor=replace(MOTOR, back_emf_constant=0.024)),
    "voltage": Servo(0.0, open_duty=1.0, current_limit=2.0, motor=MOTOR),
    "without a motor": Servo(5.0, 0.1, delay=0.01, torque_limit=2.0),
    "current": TorqueDrive(MOTOR),
    "none": None,
}
LINK = Link(0.2, 0.7, 0.09, 3.5e-3)
MOTOR_EFFECTS = {
    "torque_constant": {"share": 0.2},
    "winding_resistance": {"share": -0.2},
    "voltage_sag": {"share": 0.1},
    "servo_gain": {"share": 0.3},
}


def leg(drive: Servo | TorqueDrive | None, **effects: dict[str, float]) -> Leg:
    hip = Joint("hip", LINK, sign=-1, spring=Spring(4.0, 0.1), damper=Damper(0.01), armature=1e-4, drive=drive)
    knee = Joint("knee", replace(LINK, mass=0.3), spring=Spring(2.0, 0.3), damper=Damper(0.02), drive=drive)
    return Leg("leg", (replace(hip, effects=effects), knee))


def in_columns(tolerances: Tolerances, nominal: Leg, x: np.ndarray) -> LegLanes:
    lanes = LegLanes.of(nominal)
    tolerances.apply(lanes, x[:, None])
    return lanes


def assert_same(one: LegLanes, other: LegLanes) -> None:
    names = [item.name for item in fields(LegLanes) if isinstance(getattr(one, item.name), np.ndarray)]
    for name in (*names, "own_inertia"):
        np.testing.assert_allclose(getattr(one, name), getattr(other, name), rtol=1e-12, atol=1e-15, err_msg=name)
    np.testing.assert_allclose(one.servo_numbers(), other.servo_numbers(), rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("kind", DRIVES)
@pytest.mark.parametrize("together", [False, True])
def test_columns_and_the_written_leg_are_the_same(kind: str, together: bool) -> None:
    """Each quantity of each joint alone, and all of them."""
    by_current = (0, 1) if kind == "current" else ()
    nominal = leg(DRIVES[kind])
    tolerances = Tolerances.of(nominal, Tolerance(), by_current)
    all_of_them = np.linspace(-2.0, 1.5, tolerances.size)
    for x in [all_of_them] if together else all_of_them * np.eye(tolerances.size):
        assert_same(in_columns(tolerances, nominal, x), LegLanes.of(tolerances.leg(nominal, x)))


@pytest.mark.parametrize("name", [*MOTOR_EFFECTS, "torque_gain"])
def test_so_they_are_beside_an_effect_of_the_drive(name: str) -> None:
    by_current = (0, 1) if name == "torque_gain" else ()
    drive = DRIVES["current"] if by_current else POSITION
    tolerances = Tolerances(np.full((len(QUANTITIES), 2), 0.1), by_current)
    for x in (np.zeros(tolerances.size), np.linspace(1.5, -2.0, tolerances.size)):
        nominal = leg(drive, **{name: MOTOR_EFFECTS.get(name, {"share": 0.25})})
        assert_same(in_columns(tolerances, nominal, x), LegLanes.of(tolerances.leg(nominal, x)))


def test_a_measured_back_emf_constant_keeps_its_value() -> None:
    """The braking is N^2 eta kt ke / R: with kt once and not squared if ke was measured by itself."""
    motor = replace(MOTOR, back_emf_constant=0.024)
    tolerances, x = Tolerances(np.full((len(QUANTITIES), 2), 0.1)), np.zeros((len(QUANTITIES), 2))
    x[QUANTITIES.index("torque_constant")] = 1.0
    found = in_columns(tolerances, leg(replace(POSITION, motor=motor)), x.ravel())
    braking = 50.0**2 * 0.8 * 0.02 * np.exp(0.1) * 0.024 / 2.0
    assert found.servo[SERVO.index("servo_back_emf")] == pytest.approx(np.full((2, 1), braking))


def test_the_winding_s_lag_follows_its_resistance_and_the_braking_both_constants() -> None:
    """L / R; of the torque -b w(t - L/R), b = (K N)^2 / R, b L / R counts as an inertia less (efficiency 1)."""
    motor = replace(MOTOR, efficiency=1.0)
    tolerances, x = Tolerances(np.full((len(QUANTITIES), 2), 0.1)), np.zeros((len(QUANTITIES), 2))
    x[QUANTITIES.index("torque_constant")], x[QUANTITIES.index("resistance")] = 0.5, 1.0
    found = in_columns(tolerances, leg(replace(POSITION, motor=motor)), x.ravel())
    constant, resistance = 0.02 * np.exp(0.05), 2.0 * np.exp(0.1)
    lag = 2e-3 / resistance
    numbers = dict(zip(SERVO, found.servo_numbers()[:, 1, 0], strict=True))
    assert numbers["servo_delay"] == pytest.approx(0.01 + lag)
    assert numbers["servo_phase"] == pytest.approx(lag)
    assert numbers["servo_damping_gain"] == pytest.approx(0.05 - lag * 5.0)
    expected = 2e-6 * 50.0**2 - lag * (constant * 50.0) ** 2 / resistance
    assert found.own_inertia[1, 0] == pytest.approx(expected)
    assert found.own_inertia[0, 0] == pytest.approx(1e-4 + expected)


@pytest.mark.parametrize(("name", "share"), [("torque_constant", 0.2), ("winding_resistance", 0.3)])
def test_a_cause_acts_as_the_leg_file_with_that_number(name: str, share: float) -> None:
    drive = POSITION
    constant, resistance = MOTOR.torque_constant, MOTOR.resistance
    if name == "torque_constant":
        constant *= 1.0 + share
    else:
        resistance *= 1.0 + share
    stated = replace(drive, motor=replace(MOTOR, torque_constant=constant, resistance=resistance))
    cause = LegLanes.of(leg(drive, **{name: {"share": share}}))
    truth = LegLanes.of(leg(stated))
    np.testing.assert_allclose(cause.servo_numbers()[:, 0], truth.servo_numbers()[:, 0], rtol=1e-12)
    np.testing.assert_allclose(cause.own_inertia[0], truth.own_inertia[0], rtol=1e-12)


def test_a_known_current_has_no_lag() -> None:
    """Its torque is that of the current, which the winding has already delayed."""
    joint = Joint("hip", LINK, drive=TorqueDrive(MOTOR))
    assert joint.with_rotor == pytest.approx(2e-6 * 50.0**2)


def test_a_lag_takes_at_most_half_of_the_link_in_columns_too() -> None:
    heavy = replace(BARE, torque_constant=0.2)
    joint = Joint("hip", LINK, drive=replace(POSITION, motor=heavy))
    found = LegLanes.of(Leg("leg", (joint,))).own_inertia[0, 0]
    assert found == pytest.approx(joint.with_rotor) == pytest.approx(-MOST_LAGGED * (3.5e-3 + 0.7 * 0.09**2))
