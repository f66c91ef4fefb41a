"""One motor in both plants: at steady current a servo's torque at full duty is the jumping leg's line."""

from __future__ import annotations

import numpy as np
import pytest

from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo
from synth.hopper.motors import motor_of
from synth.jump.hopper_leg import Contact, HopperLeg, Motor
from synth.jump.jump_models import MODELS, columns
from synth.parts.catalogs import Catalogue


@pytest.fixture(scope="module")
def motor() -> Motor:
    return motor_of(Catalogue.load().find_motor("N20 HP 6V 150:1"))


def test_a_catalogues_motor_in_a_servo_has_the_jumping_legs_line(motor: Motor) -> None:
    """Model B's winding at steady current, with its supply's resistance, which one motor's servo sees once."""
    servo = Servo(gain=100.0, supply=motor.voltage, motor=motor, source_resistance=2.0)
    jumps = columns(HopperLeg(), motor, Contact(), MODELS["B"], np.array([0.12]))
    jumps.supply_resistance += 1.0  # both motors' current flows through it
    z, row = jumps.workspace()[:, 0], jumps.layout.row
    for rate in (0.0, 5.0, -3.0):
        current = (z[row("voltage")] - z[row("back_emf")] * rate) / z[row("resistance")]
        assert servo.torque(np.array(1.0), np.array(rate), motor.voltage) == pytest.approx(
            z[row("torque_constant")] * current, rel=1e-12
        )


def test_the_loss_of_a_gear_is_the_same_told_either_way(motor: Motor) -> None:
    """As efficiency beside the back-EMF constant, or within the torque constant."""
    other = GearedMotor(
        motor.resistance, motor.back_emf_constant, motor.gear_ratio, motor.torque_constant / motor.back_emf_constant
    )
    assert other.strength == pytest.approx(motor.strength, rel=1e-12)
    assert other.short_circuit_damping == pytest.approx(motor.short_circuit_damping, rel=1e-12)
    assert other.driving_efficiency == pytest.approx(motor.driving_efficiency, rel=1e-12)
    assert other.back_efficiency == pytest.approx(motor.back_efficiency, rel=1e-12)


@pytest.mark.parametrize(("share", "back"), [(0.0, 0.1), (1e-9, 0.1), (0.5, 0.1), (0.6, 1.0 / 3.0), (1.0, 1.0)])
def test_a_gear_that_locks_is_finite_down_to_no_torque_at_all(share: float, back: float) -> None:
    motor = GearedMotor(4.0, 0.01 * share, 50.0, back_emf_constant=0.01)
    assert motor.back_efficiency == pytest.approx(back)
