"""What is told of a wrong number counts from the design's, whatever of it a fit gives to the number's own tolerance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.simulated_releases import TWO
from diagnosis.simulated_servos import ARM
from synth.diagnosis.plants.swinging_chain.stated_numbers import NUMBERS_CHANGED, against_design
from synth.drives.servo import Servo
from synth.files.gap_project import Tolerance
from synth.swing.effects import effect_named, registered
from synth.swing.lane_layout import SERVO
from synth.swing.leg_lanes import LegLanes
from synth.swing.tolerances import QUANTITIES, Tolerances

BOTH = TWO.with_joints(knee={"drive": ARM.joints[0].drive})
WIDE = Tolerances.of(BOTH, Tolerance(mass=0.1, com=0.1, inertia=0.1, spring=0.1, damper=0.1, free_angle=0.2))
GIVEN = {"share": -0.3, "com": 0.2, "inertia": -0.4, "shift": 0.3}
RATES = {"spring_rate": 0.5, "viscous_damping": -0.006}
CASES = [(effect, *pair) for effect, pairs in NUMBERS_CHANGED.items() for pair in pairs]


def numbers(legs: LegLanes) -> dict[str, float]:
    """Each quantity of the second joint; a motor's by what it makes of the servo."""
    found = {name: float(getattr(legs, name)[1, 0]) for name in QUANTITIES if hasattr(legs, name)}
    strength, back = (float(legs.servo[SERVO.index(name), 1, 0]) for name in ("servo_strength", "servo_back_emf"))
    found["torque_constant"], found["resistance"] = back / strength, strength**2 / back
    return found


def number_after(effect: str, values: dict[str, float], x: np.ndarray, quantity: str) -> float:
    legs = LegLanes.of(BOTH)
    WIDE.apply(legs, x[:, None])
    known = effect_named(effect)
    given = [np.array([values.get(p.name, p.default or 0.0)]) for p in known.parameters]
    known.function()(legs, 1, BOTH.joints[1].sign, *given)
    return numbers(legs)[quantity]


@pytest.mark.parametrize(("effect", "parameter", "quantity"), CASES)
def test_tolerance_and_effect_together_are_told_as_one_deviation_from_the_design(
    effect: str, parameter: str, quantity: str
) -> None:
    """A leg without the tolerance, but with the effect as told, is the leg with both."""
    x = np.random.default_rng(3).standard_normal(WIDE.size)
    own = {p.name for p in effect_named(effect).parameters}
    values = {name: value for name, value in GIVEN.items() if name in own}
    values |= {"rate": RATES[effect], "free_angle": 0.1} if effect in RATES else {}
    values = {name: value for name, value in values.items() if name in own}
    told = against_design((effect, "knee"), values, BOTH, WIDE, x)
    assert told[parameter] != values[parameter]
    both = number_after(effect, values, x, quantity)
    alone = number_after(effect, told, np.zeros(WIDE.size), quantity)
    if quantity in ("torque_constant", "resistance"):  # a resistance moves both ratios with the other's tolerance
        other = x.copy()
        other[[k for k, name in enumerate(np.repeat(QUANTITIES, 2)) if name != quantity]] = 0.0
        both = number_after(effect, values, other, quantity)
    assert alone == pytest.approx(both, rel=1e-12)


def test_every_effect_that_changes_a_number_with_a_tolerance_is_known() -> None:
    """Each effect alone on the leg: what it changes of the numbers that have a tolerance."""
    nominal = numbers(LegLanes.of(BOTH))
    for effect in registered():
        if effect.way not in ("leg", "drive") or effect.where != "joint":
            continue
        legs = LegLanes.of(BOTH)
        effect.function()(legs, 1, 1, *(np.array([0.01]) for _ in effect.parameters))
        changed = {name for name, value in numbers(legs).items() if value != pytest.approx(nominal[name], rel=1e-9)}
        known = {quantity for _, quantity in NUMBERS_CHANGED.get(effect.name, ())}
        beside = {"link_mass": {"inertia"}}.get(effect.name, set())  # in proportion to the mass that is told
        assert changed - known - beside - {"torque_constant", "resistance"} == set(), effect.name
        if effect.name in ("motor_constant", "winding_resistance"):
            assert known <= changed


def test_a_motor_s_place_without_a_motor_is_left_as_it_is() -> None:
    bare = replace(BOTH, joints=(BOTH.joints[0], replace(BOTH.joints[1], drive=Servo(1.0))))
    width = Tolerances.of(bare, Tolerance())
    told = against_design(("motor_constant", "knee"), {"share": 0.2}, bare, width, np.ones(width.size))
    assert told == {"share": 0.2}
