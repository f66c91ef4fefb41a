"""Effects of one drive together: their order in the file changes nothing, and a limit in N m is what it says."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo
from synth.swing.effects import effect_named, registered
from synth.swing.lane_layout import SERVO
from synth.swing.leg_lanes import LegLanes
from synth.swing.leg_model import Joint, Leg, Link
from synth.swing.tolerances import QUANTITIES, Tolerances

MOTOR = GearedMotor(5.0, 0.3 / 150.0, 150.0, 0.8, 4e-8)
KNEE = Servo(3.0, 0.02, supply=7.4, source_resistance=0.5, current_limit=0.3, torque_limit=0.09, motor=MOTOR)
OF_DRIVES = [effect for effect in registered() if effect.way == "drive" and effect.where == "joint"]
SIZES = {"N*m": 0.06, "s": 0.02, "rad": 0.03, "rad/s": 2.0, "1": 0.4}


def leg(effects: dict[str, dict[str, float]], drive: Servo = KNEE) -> Leg:
    return Leg("leg", (Joint("knee", Link(0.1, 0.2, 0.08, 2e-4), drive=drive, effects=effects),))


def number(legs: LegLanes, name: str) -> float:
    return float(legs.servo_numbers()[SERVO.index(name), 0, 0])


@pytest.mark.parametrize("pair", [*combinations([effect.name for effect in OF_DRIVES], 2)], ids=" ".join)
def test_the_order_of_two_effects_does_not_matter(pair: tuple[str, str]) -> None:
    given = {name: {p.name: SIZES[p.unit] for p in effect_named(name).parameters} for name in pair}
    one, other = (LegLanes.of(leg({name: given[name] for name in order})) for order in (pair, pair[::-1]))
    np.testing.assert_allclose(one.servo_numbers(), other.servo_numbers(), rtol=1e-12)
    np.testing.assert_allclose(one.drive, other.drive, rtol=1e-12)


@pytest.mark.parametrize("share", [0.3, -0.5])
def test_a_limit_in_newton_metres_stays_beside_another_motor_constant(share: float) -> None:
    """That of the effect, and the drive's own; a limit of the current follows the constant."""
    stronger, limit = {"torque_constant": {"share": share}}, {"current_limit": {"torque": 0.03}}
    assert number(LegLanes.of(leg({**limit, **stronger})), "servo_torque_limit") == pytest.approx(0.03)
    by_torque = replace(KNEE, current_limit=np.inf)
    assert number(LegLanes.of(leg(stronger, by_torque)), "servo_torque_limit") == pytest.approx(0.09)
    by_current = replace(KNEE, torque_limit=np.inf)
    amperes = 0.3 * MOTOR.torque_a_current * (1.0 + share)
    assert number(LegLanes.of(leg(stronger, by_current)), "servo_torque_limit") == pytest.approx(amperes)


def test_a_source_s_share_is_of_the_winding_s_stated_resistance() -> None:
    """2 ohm beside the stated 0.5, at a winding of 7 ohm instead of 5."""
    found = LegLanes.of(leg({"winding_resistance": {"share": 0.4}, "voltage_sag": {"share": 0.4}}))
    assert number(found, "servo_sag") == pytest.approx(2.5 / 7.0)


def test_a_tolerance_of_the_motor_constant_leaves_a_limit_in_newton_metres() -> None:
    """As the leg with that constant has it: lanes and leg were apart."""
    width = np.zeros((len(QUANTITIES), 1))
    width[QUANTITIES.index("torque_constant")] = 0.1
    tolerances, x = Tolerances(width), np.zeros(len(QUANTITIES))
    x[QUANTITIES.index("torque_constant")] = 1.5
    drive = replace(KNEE, current_limit=np.inf)
    lanes = LegLanes.of(leg({}, drive))
    tolerances.apply(lanes, x[:, None])
    np.testing.assert_allclose(lanes.servo_numbers(), LegLanes.of(tolerances.leg(leg({}, drive), x)).servo_numbers())
