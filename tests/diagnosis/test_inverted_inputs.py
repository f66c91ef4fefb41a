"""Of a driven joint the angle or its input may be inverted: the joint's `sign` turns both, so it mends neither."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.simulated_releases import ONE
from diagnosis.simulated_servos import ARM, driven
from synth.diagnosis.check.coverage import torque_findings
from synth.diagnosis.check.finding import Finding, finding_of_slip
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import scene_of
from synth.diagnosis.plants.swinging_chain.column_slips import column_slips
from synth.drives.servo import Servo
from synth.files.gap_project import Tolerance
from synth.files.trial_list import Trial
from synth.swing.chain import simulate
from synth.swing.leg_model import Leg

HANGING = ONE.with_joints(knee={"spring": None})  # alike to both sides of straight down
SPRUNG = ONE.with_joints(knee={"spring": replace(ONE.joints[0].spring, free_angle=ONE.joints[0].zero - 0.8)})
TIME = np.arange(0.0, 2.0, 0.01)
INPUT, ANGLE = "the column knee torque looks inverted", "the column knee looks inverted"
EITHER = "the column knee or the column knee torque looks inverted"


def pushed(leg: Leg) -> list[Trial]:
    """Two motions under a known torque, which the files have in the measured sense."""
    trials = []
    for k in range(2):
        torque = 0.35 * np.sin((2.5 + k) * TIME)[:, None]
        motion = simulate(leg, [0.1], [0.0], TIME, known_torque=(TIME, leg.sign * torque))
        noise = np.radians(0.03) * np.random.default_rng(k).standard_normal(motion.shape)
        trials.append(Trial(f"{k}.csv", TIME, leg.to_measured(motion) + noise, torques=torque))
    return trials


def found(leg: Leg, trials: list[Trial]) -> list[Finding]:
    scene, _ = scene_of(leg, trials, Tolerance(), 0)
    return [finding_of_slip(slip) for slip in column_slips(leg, trials, scene.bench)]


def with_torque_inverted(trials: list[Trial]) -> list[Trial]:
    return [replace(trial, torques=-trial.torques) for trial in trials if trial.torques is not None]


def with_angle_inverted(trials: list[Trial], leg: Leg) -> list[Trial]:
    return [replace(trial, angles=2.0 * leg.zero - trial.angles) for trial in trials]


def with_other_sign(leg: Leg) -> Leg:
    return replace(leg, joints=tuple(replace(joint, sign=-joint.sign) for joint in leg.joints))


@pytest.mark.parametrize("leg", [HANGING, with_other_sign(HANGING)])
def test_a_leg_alike_to_both_sides_does_not_tell_which_column_it_is(leg: Leg) -> None:
    """The remedy was to turn `sign`, with which the same fault came again."""
    (finding,) = found(leg, with_torque_inverted(pushed(leg)))
    assert finding.text.startswith(EITHER)
    assert finding.remedy.startswith("turn one of the two")
    assert "would change nothing" in finding.remedy
    assert found(with_other_sign(leg), with_torque_inverted(pushed(leg)))[0].remedy == finding.remedy


def test_a_leg_that_is_not_alike_to_both_sides_tells_which_column_it_is() -> None:
    trials = pushed(SPRUNG)
    assert found(SPRUNG, trials) == []
    (torque,) = found(SPRUNG, with_torque_inverted(trials))
    assert torque.text.startswith(INPUT)
    (angle,) = found(SPRUNG, with_angle_inverted(trials, SPRUNG))
    assert angle.text.startswith(ANGLE)
    (both,) = found(SPRUNG, with_angle_inverted(with_torque_inverted(trials), SPRUNG))
    assert both.remedy == "turn the joint's `sign` in the leg file"
    assert both.text.startswith("knee looks inverted, with knee torque")


def test_an_inverted_command_is_named() -> None:
    turned = []
    for trial in driven(ARM, 2):
        assert trial.signals is not None
        signals = replace(trial.signals, command=2.0 * ARM.zero - trial.signals.command)
        turned.append(replace(trial, signals=signals))
    (finding,) = found(ARM, turned)
    assert finding.text.startswith("the column knee or the column knee command looks inverted")
    assert "knee command about the joint's zero" in finding.remedy


def with_commands(trial: Trial, factor: float) -> Trial:
    assert trial.signals is not None
    return replace(trial, signals=replace(trial.signals, command=factor * trial.signals.command))


def test_a_command_in_the_other_unit_is_named() -> None:
    """The angle alone was blamed, with the advice to write the unit that its header has."""
    assert found(ARM, driven(ARM, 1)) == []
    (limited,) = found(ARM, [with_commands(trial, np.radians(1.0)) for trial in driven(ARM, 1)])
    assert limited.text.startswith("the commands of knee look like radians labelled degrees")
    assert limited.remedy == "correct the unit in the header: knee command [rad]"
    free = ARM.with_joints(knee={"drive": Servo(gain=20.0, damping_gain=0.5)})  # nothing limits it: angles are in ratio
    (either,) = found(free, [with_commands(trial, np.radians(1.0)) for trial in driven(free, 1)])
    assert "degrees labelled radians, or their commands like radians labelled degrees" in either.text
    assert either.remedy.endswith("knee [deg], or else knee command [rad]")


def test_of_a_free_joint_the_sign_is_turned() -> None:
    free = [
        replace(trial, torques=None) for trial in pushed(SPRUNG.with_joints(knee={"spring": SPRUNG.joints[0].spring}))
    ]
    still = [replace(trial, angles=SPRUNG.to_measured(simulate(SPRUNG, [0.6], [0.0], TIME))) for trial in free]
    (finding,) = found(SPRUNG, with_angle_inverted(still, SPRUNG))
    assert finding.remedy == "turn the joint's `sign` in the leg file, or its column"


def test_a_torque_that_some_recordings_have_not_is_noted() -> None:
    """A forgotten column was a free motion without a word."""
    first, second = pushed(SPRUNG)
    assert torque_findings(SPRUNG, [first, second]) == []
    free = replace(second, torques=None)
    (finding,) = torque_findings(SPRUNG, [first, free])
    assert (finding.level, finding.recording, finding.joint) == ("note", "1.csv", "knee")
    assert torque_findings(SPRUNG, [free]) == []
    assert torque_findings(SPRUNG, [first, replace(free, locked=("knee",))]) == []
