"""What is told of a wrong number counts from the design's, whatever of it a fit gives to the number's own tolerance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.simulated_releases import TWO
from diagnosis.simulated_servos import ARM
from synth.diagnosis.angle_search import AngleExplorer
from synth.diagnosis.odds import CALIBRATED
from synth.diagnosis.plants.swinging_chain.chain_candidates import candidates, natural_sizes_of
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import scene_of
from synth.diagnosis.plants.swinging_chain.stated_numbers import NUMBERS_CHANGED, against_design
from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo, TorqueDrive
from synth.files.gap_project import Tolerance
from synth.files.trial_list import Trial
from synth.swing.chain import simulate
from synth.swing.effects import effect_named, registered
from synth.swing.lane_layout import DRIVE, SERVO
from synth.swing.leg_lanes import LegLanes
from synth.swing.tolerances import QUANTITIES, Tolerances

BOTH = TWO.with_joints(knee={"drive": ARM.joints[0].drive})
WIDE = Tolerances.of(BOTH, Tolerance(mass=0.1, com=0.1, inertia=0.1, spring=0.1, damper=0.1, free_angle=0.2))
GIVEN = {"share": -0.3, "com": 0.2, "inertia": -0.4, "shift": 0.3}
RATES = {"spring_rate": 0.5, "viscous_damping": -0.006}
CASES = [(effect, *pair) for effect, pairs in NUMBERS_CHANGED.items() if effect != "torque_gain" for pair in pairs]
MOTOR = GearedMotor(np.inf, 0.02, 40.0, 1.0, 0.0)
BY_CURRENT = TWO.with_joints(knee={"drive": TorqueDrive(MOTOR)})


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
        if effect.name in ("torque_constant", "winding_resistance"):
            assert known <= changed


def test_a_motor_s_place_without_a_motor_is_left_as_it_is() -> None:
    bare = replace(BOTH, joints=(BOTH.joints[0], replace(BOTH.joints[1], drive=Servo(1.0))))
    width = Tolerances.of(bare, Tolerance())
    told = against_design(("torque_constant", "knee"), {"share": 0.2}, bare, width, np.ones(width.size))
    assert told == {"share": 0.2}


def current_driven(constant: float, *, by_current: bool = True) -> list[Trial]:
    """Releases with a torque on the knee, told by the nominal constant, that is ``constant`` times as large."""
    trials, time = [], np.arange(0.0, 1.5, 0.01)
    for k in range(2):
        torque = np.zeros((len(time), 2))
        torque[:, 1] = 0.3 * np.sin((5.0 + 2.0 * k) * time)
        known = (time, constant * TWO.sign * torque)
        motion = simulate(TWO, TWO.rest + np.array([0.3, -0.2]), np.zeros(2), time, known_torque=known)
        noise = np.radians(0.03) * np.random.default_rng(k).standard_normal(motion.shape)
        names = ("knee",) if by_current else ()
        trials.append(Trial(f"{k}.csv", time, TWO.to_measured(motion) + noise, torques=torque, by_current=names))
    return trials


def test_the_constant_of_a_motor_whose_current_is_recorded_moves_within_its_tolerance() -> None:
    """A constant 7 % lower, known to 10 %: the nominal leg follows; without a tolerance it leaves 1.8 noise floors."""
    scene, _ = scene_of(BY_CURRENT, current_driven(0.93), Tolerance(), 0)
    assert scene.tolerances.by_current == (1,)
    every = candidates(BY_CURRENT, scene.given, natural_sizes_of(BY_CURRENT, scene.given))
    explorer = AngleExplorer(scene.bench, every, CALIBRATED)
    none = explorer.none()
    assert explorer.ratio(none) < 1.1
    moved = scene.tolerances.leg(BY_CURRENT, none.unknowns)
    assert moved.joints[1].effects["torque_gain"]["share"] == pytest.approx(-0.07, abs=0.01)
    told = against_design(("torque_gain", "knee"), {"share": 0.0}, BY_CURRENT, scene.tolerances, none.unknowns)
    assert told["share"] == pytest.approx(moved.joints[1].effects["torque_gain"]["share"])
    lanes = LegLanes.of(BY_CURRENT)
    scene.tolerances.apply(lanes, none.unknowns[:, None])
    np.testing.assert_allclose(lanes.drive, LegLanes.of(moved).drive)


def test_a_measured_torque_is_not_scaled_by_a_motor_s_tolerance() -> None:
    scene, _ = scene_of(BY_CURRENT, current_driven(1.0, by_current=False), Tolerance(), 0)
    assert scene.tolerances.by_current == ()
    assert not scene.tolerances.width[QUANTITIES.index("torque_constant")].any()


def test_gain_and_tolerance_of_a_torque_multiply() -> None:
    lanes = LegLanes.of(BY_CURRENT)
    width = np.zeros((len(QUANTITIES), 2))
    width[QUANTITIES.index("torque_constant"), 1] = 0.1
    x = np.full(width.size, 1.5)
    tolerances = Tolerances(width, (1,))
    tolerances.apply(lanes, x[:, None])
    effect_named("torque_gain").function()(lanes, 1, -1, np.array([0.2]))
    told = against_design(("torque_gain", "knee"), {"share": 0.2}, BY_CURRENT, tolerances, x)
    assert lanes.drive[DRIVE.index("torque_gain"), 1, 0] == pytest.approx(told["share"])
