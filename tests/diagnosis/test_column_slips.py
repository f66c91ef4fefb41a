"""Slips of the user that no unit shows: absolute angles, another zero, one column inverted in all recordings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.simulated_releases import AWAY, TWO, off, recorded
from diagnosis.simulated_servos import ARM, driven
from diagnosis.test_inverted_inputs import HANGING, found, pushed
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose
from synth.files.gap_project import Tolerance
from synth.files.trial_list import Trial
from synth.swing.chain import simulate
from synth.swing.leg_model import Joint, Leg, Link

RIGHT_ANGLE = float(np.radians(90.0))
# Two links without springs or dampers, as of a double pendulum: a mirror shows the same leg.
DOUBLE = Leg("double", (Joint("upper", Link(0.17, 0.09, 0.11, 4.4e-4)), Joint("lower", Link(0.17, 0.14, 0.12, 1.3e-3))))
THREE = replace(TWO, joints=(*TWO.joints, replace(TWO.joints[1], name="ankle", zero=0.0, sign=1, spring=None)))


def released() -> list[Trial]:
    """Four releases of the double pendulum from rest."""
    time, noise = np.arange(0.0, 3.0, 0.01), np.random.default_rng(3)
    made = []
    for k, start in enumerate(0.8 * AWAY):
        motion = simulate(DOUBLE, start, [0.0, 0.0], time)
        made.append(Trial(f"{k}.csv", time, motion + np.radians(0.02) * noise.standard_normal(motion.shape)))
    return made


def absolute(leg: Leg, trials: list[Trial], joints: tuple[int, ...]) -> list[Trial]:
    """As a camera or inertial sensors tell these links: against the direction in which the leg hangs straight down."""
    made = []
    for trial in trials:
        rotation = leg.to_rotation(trial.angles)
        told = np.where(np.isin(np.arange(rotation.shape[1]), joints), np.cumsum(rotation, axis=1), rotation)
        made.append(replace(trial, angles=leg.to_measured(told)))
    return made


def test_an_absolute_angle_is_named_and_no_exchanged_columns() -> None:
    """Of a real double pendulum's small swings the columns were called exchanged, of its large ones nothing."""
    trials = recorded(TWO, held_out=0)
    assert found(TWO, trials) == []
    (finding,) = found(TWO, absolute(TWO, trials, (1,)))
    assert finding.text.startswith("knee looks measured from a fixed direction, as absolute angles: ")
    # the hip's angle grows counter-clockwise from 0.4 rad, the knee's clockwise
    assert finding.remedy == "take the angle from the link before it: knee = knee + (hip - 22.92 deg)"
    assert finding.recording == "0.csv, 3.csv, 2.csv and 1 more"


@pytest.mark.parametrize(
    ("joints", "words"),
    [((1, 2), "knee = knee + (hip - 22.92 deg); ankle = ankle + (knee - 114.6 deg)"),
     ((2,), "ankle = ankle - (hip - 22.92 deg) + (knee - 114.6 deg)")],
)  # fmt: skip
def test_of_three_links_all_may_be_absolute_or_one(joints: tuple[int, ...], words: str) -> None:
    spring = replace(TWO.joints[0].spring, rate=0.4, free_angle=0.1) if TWO.joints[0].spring else None
    leg = THREE.with_joints(ankle={"spring": spring})
    trials = recorded(leg, np.column_stack([AWAY, 0.9 * AWAY[:, 0]]), held_out=0)
    (finding,) = found(leg, absolute(leg, trials, joints))
    assert finding.remedy.endswith(words)


def test_one_inverted_column_is_one_finding_in_all_recordings() -> None:
    """Of two links that hang freely either may be turned. Three recordings blamed the one, the fourth the other."""
    trials = released()
    turned = [replace(trial, angles=trial.angles * np.array([1.0, -1.0])) for trial in trials]
    assert found(DOUBLE, trials) == []
    (finding,) = found(DOUBLE, turned)
    assert finding.text.startswith("upper or lower looks inverted: ")
    assert finding.remedy == "turn the `sign` of one of the two in the leg file, or its column"
    assert finding.recording.endswith("and 1 more")


@pytest.mark.parametrize("turn", [180.0, 90.0, -90.0])
def test_a_zero_elsewhere_is_named(turn: float) -> None:
    """A real pendulum that reads 0 upright had "another spring, free angle 180 deg", 93 %; the check was silent."""
    right = HANGING.with_joints(knee={"zero": 0.0, "sign": 1})
    trials = pushed(right)
    assert found(right, trials) == []
    shifted = [replace(trial, angles=trial.angles + np.radians(turn)) for trial in trials]
    (finding,) = found(right, shifted)
    assert finding.text.startswith(f"knee: zero: 0 deg is stated and zero: {turn:g} deg fits: ")
    assert "the reading where the link points straight down" in finding.remedy


def test_the_interior_angle_of_a_knee_is_named() -> None:
    """180 deg where it is straight, less when bent: zero and sign are wrong, and the spring stays where it is."""
    right = TWO.with_joints(knee={"zero": np.pi, "sign": -1})
    wrong = right.with_joints(knee={"zero": 0.0, "sign": 1})
    assert found(right, recorded(right, held_out=0)) == []
    (finding,) = found(wrong, recorded(right, held_out=0))
    assert finding.text.startswith("knee: zero: 0 deg, sign: +1 is stated and zero: 180 deg, sign: -1 fits: ")
    assert "along the link before it" in finding.remedy


def test_the_zero_of_a_servo_s_angle_and_command_is_named() -> None:
    """Only gravity tells it: the servo follows its command wherever both are counted from."""
    right = ARM.with_joints(knee={"zero": 0.0})
    wrong = right.with_joints(knee={"zero": RIGHT_ANGLE})
    (finding,) = found(wrong, driven(right, 3))
    assert finding.text.startswith("knee: zero: 90 deg is stated and zero: 0 deg fits: ")


def released_of(leg: Leg) -> list[Trial]:
    return recorded(leg, held_out=0, noise=float(np.radians(0.03)))


def test_an_inertia_about_the_joint_is_named() -> None:
    """A CAD program gives both; of a real double pendulum's, the check said nothing."""
    links = [joint.link for joint in TWO.joints]
    about = [replace(link, inertia=link.inertia + link.mass * link.com**2) for link in links]
    wrong = TWO.with_joints(hip={"link": about[0]}, knee={"link": about[1]})
    (finding,) = found(wrong, released_of(TWO))
    assert finding.text.startswith("the inertia of hip and knee looks stated about the joint: ")
    assert "less mass times com squared" in finding.remedy


def test_a_centre_of_mass_from_the_far_end_is_named() -> None:
    """Not one near the middle: a link that is built so is a cause."""
    right = TWO.with_joints(hip={"link": replace(TWO.joints[0].link, com=0.08)})
    wrong = TWO.with_joints(hip={"link": replace(TWO.joints[0].link, com=0.17)})
    (finding,) = found(wrong, released_of(right))
    assert finding.text.startswith("the centre of mass of hip looks stated from the far end: ")
    middle = TWO.with_joints(hip={"link": replace(TWO.joints[0].link, com=0.115)})
    other = TWO.with_joints(hip={"link": replace(TWO.joints[0].link, com=0.135)})
    assert found(middle, released_of(other)) == []


def test_a_centre_of_mass_on_the_wrong_side_of_its_line_is_named() -> None:
    """Of a double pendulum, which hangs elsewhere by twice the angle."""
    sided = [replace(joint, link=replace(joint.link, com_across=0.03)) for joint in DOUBLE.joints]
    true, time = replace(DOUBLE, joints=tuple(sided)), np.arange(0.0, 3.0, 0.01)
    starts = 0.8 * AWAY
    trials = [Trial(f"{k}.csv", time, simulate(true, start, [0.0, 0.0], time)) for k, start in enumerate(starts)]
    assert found(true, trials) == []
    turned = replace(sided[0], link=replace(sided[0].link, com_across=-0.03))
    (finding,) = found(replace(true, joints=(turned, sided[1])), trials)
    assert finding.text.startswith("the centre of mass of upper looks stated on the wrong side of its line: ")
    assert finding.remedy.startswith("change the sign of com_across")


def test_one_recording_alone_is_told_apart_from_the_leg_file() -> None:
    """Turning the leg file's sign would have spoilt the others."""
    trials = released()
    one = replace(trials[2], angles=trials[2].angles * np.array([1.0, -1.0]))
    (finding,) = found(DOUBLE, [*trials[:2], one, trials[3]])
    assert finding.recording == "2.csv"
    assert finding.remedy.endswith("; of these recordings only: others fit as they are")


def with_signals(trial: Trial, **changed: object) -> Trial:
    assert trial.signals is not None
    return replace(trial, signals=replace(trial.signals, **changed))  # type: ignore[arg-type]


def test_a_command_that_is_counted_from_elsewhere_is_named() -> None:
    """A servo's middle is 150 of 300 deg, that of its encoder 0: the check of a real one (XL330) said nothing."""
    middle = float(np.radians(150.0))
    trials = [with_signals(t, command=t.signals.command + middle) for t in driven(ARM, 3) if t.signals is not None]
    (finding,) = found(ARM.with_joints(knee={"range": None}), trials)
    assert finding.text.startswith("the column knee command is counted from elsewhere: knee lies ")
    assert finding.remedy == "count both from one zero, in knee command or in knee"


def test_angle_and_command_exchanged_are_named() -> None:
    trials = []
    for trial in driven(ARM, 3):
        assert trial.signals is not None
        told = np.interp(trial.time, trial.signals.time, trial.signals.command[:, 0])
        command = np.interp(trial.signals.time, trial.time, trial.angles[:, 0])[:, None]
        trials.append(with_signals(replace(trial, angles=told[:, None]), command=command))
    (finding,) = found(ARM, trials)
    assert finding.text.startswith("the columns knee and knee command look exchanged: ")
    assert finding.remedy == "exchange the two names in its header"


def test_an_inverted_switch_is_named() -> None:
    """``torque_disabled`` taken for ``torque_enable``."""
    trials = [with_signals(t, enabled=1.0 - t.signals.enabled) for t in driven(ARM, 3) if t.signals is not None]
    (finding,) = found(ARM, trials)
    assert finding.text.startswith("the column knee enabled looks inverted: ")
    assert found(ARM, driven(ARM, 3)) == []


@pytest.mark.slow  # a whole diagnosis of two joints
def test_the_diagnosis_begins_with_it_and_names_no_cause_in_its_place() -> None:
    """It named a link whose mass lies elsewhere, 97 %, of a real double pendulum with the lower angle absolute."""
    result = diagnose(TWO, absolute(TWO, recorded(off(TWO, 5, 0.3), seed=1), (1,)), Tolerance())
    assert result.verdict == "unknown"
    assert result.sentence.startswith(
        "The files say something else than was recorded: knee looks measured from a fixed "
    )
    assert "knee looks measured from a fixed direction" in result.warnings[0]
    assert result.next_experiment is None or result.next_experiment.why.startswith("Correct the files first")
