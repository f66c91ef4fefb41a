"""Numbers of a leg file, and columns, that are off by a slip of the unit: named with what fits instead."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from diagnosis.simulated_releases import AWAY, HANGING, TWO, off, recorded, with_effects
from diagnosis.simulated_servos import ARM, driven
from diagnosis.test_inverted_inputs import pushed
from synth.diagnosis.check import run
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose, scene_of
from synth.diagnosis.plants.swinging_chain.far_numbers import FarNumbers, far_numbers
from synth.drives.servo import Servo
from synth.files.gap_project import GapProject, Tolerance
from synth.files.trial_list import Trial
from synth.swing.leg_model import Damper, Joint, Leg, Spring

A_TURN = 180.0 / np.pi
SERVO = ARM.joints[0].drive
assert isinstance(SERVO, Servo)
GAINS = replace(SERVO, gain=5.0, damping_gain=0.05)
HELD = ARM.with_joints(knee={"drive": GAINS})
PULLED = HANGING.with_joints(knee={"spring": None})


def found(leg: Leg, trials: Sequence[Trial]) -> FarNumbers:
    scene, _ = scene_of(leg, trials, Tolerance(), 0)
    return far_numbers(leg, scene.bench, scene.given)


def other_servo(**numbers: float) -> Leg:
    return ARM.with_joints(knee={"drive": replace(GAINS, **numbers)})


@pytest.mark.parametrize(
    ("leg", "words"),
    [
        (other_servo(gain=5.0 * A_TURN), "servo gain of knee: 286 1/rad is stated and 5 1/rad fits, 57 times less"),
        (other_servo(gain=5.0 / A_TURN), "5 1/rad fits, 57 times more (a value per degree written as per radian?)"),
        (
            other_servo(gain=5.0 / A_TURN, damping_gain=0.05 / A_TURN),
            "servo gain and damping gain of knee: 57 times more than stated fits",
        ),
        (other_servo(delay=0.3), "delay of knee: 300 ms is stated and 0.3 ms fits, 1000 times less (milliseconds"),
        (other_servo(current_limit=0.0015), "current limit of knee: 0.0015 A is stated and 1.5 A fits, 1000 times"),
    ],
)
def test_a_servo_s_number_in_another_unit(leg: Leg, words: str) -> None:
    """Each was a verdict `unknown` without a word on the unit: no cause is searched so far away."""
    assert words in found(leg, driven(HELD, 3)).text


def scaled(leg: Leg, change: Callable[[Joint], Joint]) -> Leg:
    return replace(leg, joints=tuple(change(joint) for joint in leg.joints))


def softer(joint: Joint) -> Joint:
    assert joint.spring is not None
    return replace(joint, spring=Spring(joint.spring.rate / A_TURN, joint.spring.free_angle))


def damped(joint: Joint) -> Joint:
    assert joint.damper is not None
    assert joint.damper.rate is not None
    return replace(joint, damper=Damper(joint.damper.rate * A_TURN))


def lighter(joint: Joint) -> Joint:
    return replace(joint, link=replace(joint.link, mass=joint.link.mass / 10.0))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (softer, "spring rate of hip and knee: 57 times more than stated fits (a value per degree"),
        (damped, "damper rate of hip and knee: 57 times less than stated fits (a value per radian"),
        (lighter, "link mass of hip and knee: 10 times more than stated fits"),
    ],
)
def test_all_joints_in_another_unit(change: Callable[[Joint], Joint], words: str) -> None:
    """Masses a tenth of the true ones were named as a link whose centre of mass lies elsewhere, at 78 %."""
    assert words in found(scaled(TWO, change), recorded(off(TWO, 5), seed=1)).text


def test_columns_in_another_unit() -> None:
    trials = pushed(PULLED)
    weak = [replace(trial, torques=trial.torques / 100.0) for trial in trials if trial.torques is not None]
    assert "knee: 100 times more than recorded fits" in found(PULLED, weak).text
    fast = [
        replace(trial, time=trial.time / 1e3, signals=trial.signals and replace(trial.signals, time=trial.time / 1e3))
        for trial in driven(HELD, 3)
    ]
    assert found(HELD, fast).text.startswith("time columns: 1000 times more than recorded fits (another unit")


def test_a_true_cause_is_no_slip() -> None:
    """Friction, and numbers off by their tolerances or by half: nothing is told."""
    built = with_effects(off(TWO, 3), {"knee": {"coulomb_friction": {"torque": 0.15}}})
    assert found(TWO, recorded(built, seed=1)).text == ""
    assert found(TWO, recorded(scaled(TWO, lambda joint: replace(joint, spring=Spring(3.0, 1.0))), seed=1)).text == ""
    assert found(other_servo(gain=10.0), driven(HELD, 3)).text == ""


def test_a_forgotten_spring_is_no_slip() -> None:
    """A tenth of the masses stood for it, as seven other numbers did, and left as much as the motion."""
    forgotten = TWO.with_joints(knee={"spring": Spring(0.0, TWO.joints[1].zero)})
    for share in (0.1, 0.2):
        assert found(forgotten, recorded(off(TWO, 3), away=share * AWAY, seed=1, noise=0.0005)).text == ""


def test_the_check_calls_it_a_fault_and_a_damper_a_doubt(tmp_path: Path) -> None:
    trials = recorded(off(TWO, 5), seed=1)
    for change, level in ((softer, "fault"), (damped, "doubt")):
        leg = scaled(TWO, change)
        told = run.check(GapProject(tmp_path / "gap.yaml", "gap", leg, tuple(trials), Tolerance(), 0, (), ()))
        assert [each.level for each in told.findings if "57 times" in each.text] == [level]


@pytest.mark.slow  # a whole diagnosis of two joints
def test_the_diagnosis_begins_with_it_and_names_no_cause_in_its_place() -> None:
    result = diagnose(scaled(TWO, lighter), recorded(off(TWO, 5), seed=1), Tolerance())
    assert result.verdict == "unknown"
    assert result.sentence.startswith("A number is far off: link mass of hip and knee: 10 times more")
    assert result.warnings[0].startswith("link mass of hip and knee")
    assert result.next_experiment is not None
    assert result.next_experiment.why.startswith("Correct the number that is far off first, and run again. ")
