"""The check of causes whose strength has no zero: a drive's limits of current and of its command's rate."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from diagnosis.simulated_servos import ARM, MOTOR, driven
from diagnosis.test_gap_check import project, showing, sine
from synth.commands.gap_check import _size, check_text
from synth.diagnosis.check import run
from synth.diagnosis.check.check_result import Check
from synth.diagnosis.check.level_sizes import Level
from synth.drives.servo import Servo
from synth.reports.openings.check_opening import ASKED, ASKED_OF_DRIVE, cause_size, check_opening
from synth.reports.reading import Result
from synth.swing.chain import simulate
from synth.swing.effects import registered
from synth.swing.leg_model import Leg

KNEE = "knee"
OFFSET = ("encoder_offset", KNEE)


def limited(torque: float) -> Leg:
    """The arm with a limit of its drive's torque, N m."""
    (joint,) = ARM.joints
    assert isinstance(joint.drive, Servo)
    return ARM.with_joints(knee={"drive": replace(joint.drive, current_limit=torque / MOTOR.torque_a_current)})


FREE = limited(np.inf)  # the drive gives what it can


def moved_by(torque: float) -> float:
    """Rad, RMS change of the arm's motion by a limit of its drive's torque."""
    found = []
    for trial in driven(FREE, 4):
        motions = [simulate(leg, trial.angles[0], np.zeros(1), trial.time, signals=trial.signals)
                   for leg in (FREE, limited(torque))]  # fmt: skip
        found.append(motions[1] - motions[0])
    return float(np.sqrt(np.mean(np.square(found))))


@pytest.fixture(scope="module")
def checked() -> Check:
    return run.check(project(FREE, driven(FREE, 4)))


def test_a_current_limit_is_visible_where_it_moves_the_joint(checked: Check) -> None:
    """It was visible at no size at all ({}), which counted as shown."""
    shown = showing(checked, "current_limit", KNEE)
    assert shown.limit
    assert shown.visible_from is not None
    least = shown.visible_from["torque"].value
    assert moved_by(1.3 * least) < np.radians(0.5) < moved_by(0.6 * least)
    told = shown.as_json()
    assert told["limit"] is True
    assert _size(told).startswith("at most 0.")
    assert cause_size(told).startswith("at most 0.")


@pytest.mark.parametrize("effect", ["current_limit", "command_rate_limit"])
def test_a_limit_is_no_offset_of_the_reading(checked: Check, effect: str) -> None:
    """The response of a current limit that was never reached was at an angle of 0 deg to an offset's.

    An offset that the servo controls moves the link, and what its weight asks of the motor: 36 and 43 deg.
    """
    assert sine(checked, (effect, KNEE), OFFSET) > 0.5
    shown = showing(checked, effect, KNEE)
    assert shown.visible_from is not None
    (least,) = shown.visible_from.values()
    assert shown.rivals
    for rival in shown.rivals:
        assert rival.sine > 0.05
        if rival.parts_from is not None:
            (parts,) = rival.parts_from.values()
            assert parts.value < least.value


def test_the_screen_shows_the_causes_of_a_drive_where_there_is_one(checked: Check) -> None:
    """A servo's rig showed friction, play, latency and link mass alone."""
    rows = {line.split("  ")[0]: line for line in check_text(checked.as_json()).splitlines()}
    for name in ("servo gain", "command delay", "torque constant", "current limit", "gear friction", "voltage sag"):
        assert re.search(r" [\d.]+ (%|ms|N\*m)$", rows[name]), name
    assert not [name for name in rows if name.startswith("torque ") and name != "torque constant"]
    free = [each for each in checked.as_json()["causes"] if each["effect"] in ("coulomb_friction", "link_mass")]
    text = check_text({**checked.as_json(), "causes": free, "not_told_apart": []})
    assert not any(name in text for name in ("servo", "command", "limit"))


def test_a_cause_without_any_visible_value_does_not_count(checked: Check) -> None:
    count = sum(bool(each.visible_from) for each in checked.showings)
    assert f"show {count} of" in checked.sentence
    empty = replace(checked, showings=(replace(checked.showings[0], visible_from={}), *checked.showings[1:]))
    assert f"show {count - bool(checked.showings[0].visible_from)} of" in empty.sentence


def test_values_between_rungs_are_interpolated_from_the_weakest_one() -> None:
    """A limit: the lower the stronger; above 0.9 it does nothing."""
    points = np.array([[-1.0], [2.0], [0.0], [1.0]])
    signals = np.array([9.0, 0.0, 5.0, 1.0])
    level = Level.of(points, signals, 0)
    assert level is not None
    assert level.falls
    for wanted, point in ((3.0, 0.5), (5.0, 0.0), (7.0, -0.5)):
        found = level.at_signal(wanted)
        assert found is not None
        assert found[0] == pytest.approx(point)
    assert level.at_signal(10.0) is None
    assert level.rung_with_signal(3.0)[0] == 0.0
    assert level.rung_with_signal(10.0)[0] == -1.0
    assert [round(float(point[0]), 3) for point in level.between(3.0)] == [
        0.875,
        0.75,
        0.625,
        0.5,
        0.375,
        0.25,
        0.125,
    ]


def test_the_opening_of_a_driven_rigs_check_shows_causes_of_the_drive() -> None:
    names = ("coulomb_friction", "gear_play", "servo_gain", "command_delay", "link_mass")
    causes = [{"effect": name, "joint": "arm", "visible_from": {"x": {"value": 0.1, "unit": "1"}}} for name in names]
    opening = check_opening(Result(Path(), "check.json", {"causes": causes}))
    assert opening.figures is not None
    shown = [row[0].text for row in opening.figures.rows]
    assert shown == ["coulomb friction", "gear play", "servo gain", "command delay"]
    assert {*ASKED, *ASKED_OF_DRIVE} <= {effect.name for effect in registered()}
