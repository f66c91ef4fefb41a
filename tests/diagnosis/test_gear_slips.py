"""Columns of the motor's side of a stated gear: off by its ratio."""

from __future__ import annotations

from dataclasses import replace

import pytest

from diagnosis.simulated_servos import ARM, MOTOR, driven
from diagnosis.test_column_slips import with_signals
from diagnosis.test_inverted_inputs import found
from diagnosis.test_lag_slips import SPRUNG, pushed
from synth.drives.servo import TorqueDrive
from synth.files.trial_list import Trial

GEARED = ARM.with_joints(knee={"drive": replace(ARM.joints[0].drive, motor=replace(MOTOR, gear_ratio=6.0))})
SIDE = "recorded on the motor's side of the gear, of ratio 6: "


def on_the_motor(trial: Trial, angle: bool, command: bool) -> Trial:
    assert trial.signals is not None
    made = with_signals(trial, command=trial.signals.command * 6.0) if command else trial
    return replace(made, angles=made.angles * 6.0) if angle else made


@pytest.mark.parametrize(
    ("angle", "command", "words"),
    [(True, False, "the column knee looks "), (False, True, "the column knee command looks "),
     (True, True, "the columns knee and knee command look ")],
)  # fmt: skip
def test_angles_and_commands_of_the_rotor_are_named(angle: bool, command: bool, words: str) -> None:
    """Only the other unit of an angle and powers of ten were tried."""
    trials = driven(GEARED, 3)
    assert found(GEARED, trials) == []
    (finding,) = found(GEARED, [on_the_motor(trial, angle, command) for trial in trials])
    assert finding.text.startswith(words + SIDE)
    assert "by 6" in finding.remedy


def test_a_torque_of_the_rotor_is_named() -> None:
    leg = SPRUNG.with_joints(knee={"drive": TorqueDrive(motor=replace(MOTOR, gear_ratio=6.0))})
    trials = pushed(leg, (0.0, 0.0))
    assert found(leg, trials) == []
    rotors = [replace(trial, torques=trial.torques / 6.0) for trial in trials if trial.torques is not None]
    (finding,) = found(leg, rotors)
    assert finding.text.startswith("the column knee torque looks " + SIDE)
    assert finding.remedy == "multiply knee torque by 6"
