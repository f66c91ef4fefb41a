"""Causes of a drive are told in the numbers of its leg file."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.simulated_releases import TWO
from synth.diagnosis.diagnosis_result import Cause
from synth.diagnosis.plants.swinging_chain.drive_numbers import drive_number, with_drive_numbers
from synth.diagnosis.plants.swinging_chain.tolerance_words import cause_words
from synth.diagnosis.remainder import Remainder
from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo, TorqueDrive
from synth.estimation.intervals import Estimate
from synth.files.gap_project import Tolerance
from synth.reports.parameter_rows import parameter_rows
from synth.reports.sections.gap_next import without_trial
from synth.swing.leg_model import Leg
from synth.swing.tolerances import Tolerances

MOTOR = GearedMotor(resistance=3.4, torque_constant=0.6)
SERVO = Servo(3.0, delay=0.005, current_limit=1.5, supply=12.0, motor=MOTOR)
BARE = replace(SERVO, delay=0.0, current_limit=np.inf)


def driven(drive: Servo | TorqueDrive) -> Leg:
    return replace(TWO, joints=(TWO.joints[0], replace(TWO.joints[1], drive=drive)))


def cause(effect: str, parameter: str, value: float, half: float, unit: str) -> Cause:
    return Cause(effect, "knee", {parameter: Estimate(value, unit, value - half, value + half)})


DELAY = cause("command_delay", "delay", 0.00999, 0.00016, "s")
LATE = cause("latency", "delay", 0.01, 0.00016, "s")
LIMIT = cause("current_limit", "torque", 0.449, 0.004, "N*m")
SAG = cause("voltage_sag", "share", 0.401, 0.011, "1")


@pytest.mark.parametrize(
    ("found", "drive", "words"),
    [
        (DELAY, SERVO, "(delay 15 ms for 5 ms stated)"),
        (DELAY, BARE, "(delay 10 ms)"),
        (LATE, SERVO, "(delay 10 ms)"),
        (LIMIT, SERVO, "(limit 0.748 A for 1.5 A stated)"),
        (LIMIT, BARE, "(limit 0.748 A)"),
        (LIMIT, replace(BARE, torque_limit=0.9), "(torque 0.449 N·m for 0.9 N·m stated)"),
        (SAG, SERVO, "(source 1.36 ohm)"),
        (SAG, replace(SERVO, source_resistance=0.5), "(source 1.86 ohm for 0.5 ohm stated)"),
        (cause("servo_gain", "share", -0.3, 0.0025, "1"), SERVO, "(change -30 %)"),
    ],
)
def test_a_cause_of_a_drive_is_told_in_the_numbers_of_its_file(
    found: Cause, drive: Servo | TorqueDrive, words: str
) -> None:
    leg = driven(drive)
    assert cause_words(found, leg, Tolerances.of(leg, Tolerance())).endswith(words)


@pytest.mark.parametrize(
    ("found", "drive", "becomes"),
    [
        (DELAY, SERVO, "gives 14.99 ms for 5.00 ms stated"),
        (SAG, SERVO, "gives 1.363 ohm"),
        (cause("servo_gain", "share", -0.3, 0.0, "1"), SERVO, "gives 2.1 1/rad for 3.00 1/rad stated"),
        (cause("winding_resistance", "share", 0.5, 0.0, "1"), SERVO, "gives 5.1 ohm for 3.40 ohm stated"),
        (cause("torque_gain", "share", 0.3, 0.0, "1"), TorqueDrive(MOTOR), "gives 0.78 N·m/A for 0.600 N·m/A stated"),
        (cause("torque_gain", "share", 0.3, 0.0, "1"), SERVO, ""),
        (LATE, SERVO, ""),
    ],
)
def test_the_page_shows_what_the_number_becomes(found: Cause, drive: Servo | TorqueDrive, becomes: str) -> None:
    entry = with_drive_numbers(found.as_json(), found, driven(drive))
    assert parameter_rows(entry, {})[0]["becomes"].replace("\u00a0", " ").replace("Ω", "ohm") == becomes


def test_a_joint_without_the_drive_has_no_such_number() -> None:
    assert drive_number(DELAY, TWO) is None
    assert drive_number(replace(DELAY, joint="base"), TWO) is None


def test_the_remainder_of_a_driven_leg_has_no_phase_of_a_release() -> None:
    left = Remainder(Estimate(0.01, "deg"), 0.1, 6.0, {"knee": 1.0}, {"release": 0.1, "swing": 0.9})
    assert left.place() == "while it swings"
    assert left.place(released=False) == ""


@pytest.mark.parametrize(
    ("effects", "example"),
    [
        (("command_delay", "latency"), ", the time from a command to the current that it draws for example."),
        (("spring_rate", "link_mass"), ", a spring on a bench for example."),
        (("base_tilt", "gravity"), " by itself."),
    ],
)
def test_the_advice_for_a_tie_names_what_is_blamed(effects: tuple[str, str], example: str) -> None:
    first, second = ({"effect": name, "joint": "knee"} for name in effects)
    document = {"verdict": "tie", "explanation": [first], "tied": [[second]]}
    assert example in without_trial(document, "Nothing")
