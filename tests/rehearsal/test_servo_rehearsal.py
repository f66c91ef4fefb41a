"""Rehearsals of a leg that a servo drives: the generator's servo, a case's files, and a cause that is found again."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo, ServoSignals
from synth.files.gap_project import read_gap_project
from synth.files.leg_file import write_leg
from synth.fit.recordings import recordings
from synth.planting import torque_laws
from synth.planting.model import Law, PlantedServo, Truth
from synth.planting.refusals import NotApplicable
from synth.planting.servo_errors import SERVO_ERRORS
from synth.planting.simulation import release
from synth.rehearsal import sizes
from synth.rehearsal.case_files import write_case
from synth.rehearsal.one_case import diagnose_apart
from synth.rehearsal.outcome import named_causes
from synth.rehearsal.plants import LIBRARY, Field, PlantingTask, cause_places
from synth.rehearsal.users_rig import users_rig
from synth.swing.chain import simulate
from synth.swing.leg_model import Joint, Leg, Link

SERVO = Servo(
    gain=2.5, damping_gain=0.02, dead_band=0.01, duty_limit=0.9, supply=7.4, delay=0.01, current_limit=1.2,
    source_resistance=0.2, motor=GearedMotor(3.4, 0.36, inductance=1e-3, rotor_inertia=1.8e-3),
)  # fmt: skip
ARM = Leg("arm", (Joint("arm", Link(0.12, 0.3, 0.1, 3e-4), zero=0.2, sign=-1, drive=SERVO),))
NOISE = 1e-4  # rad
TIME = np.arange(0.0, 2.0, 0.005)


def written(folder: Path, leg: Leg = ARM) -> Path:
    """A project of three logs: a sine, ramps, steps; commands at half the angles' rate, the supply at their own."""
    folder.mkdir()
    write_leg(leg, folder / "arm.leg.yaml")
    shapes = (
        0.8 * np.sin(2.0 * np.pi * TIME),
        0.5 * np.arcsin(np.sin(4.0 * TIME)),
        0.6 * np.sign(np.sin(5.0 * TIME)) * (TIME > 0.2),
    )
    for number, shape in enumerate(shapes):
        command = shape[::2].repeat(2)[: len(TIME), None]  # of q
        supply = 7.4 - 0.3 * TIME
        signals = ServoSignals(TIME, command, supply[:, None], np.ones_like(command), (0,))
        angle = simulate(leg, [0.0], [0.0], TIME, signals=signals)[:, :1]
        read = leg.to_measured(angle + NOISE * np.random.default_rng(number).standard_normal(angle.shape))
        cells = [f"{value:.9g}" if k % 2 == 0 else "" for k, value in enumerate(leg.to_measured(command)[:, 0])]
        rows = [f"{t:.9g},{a:.9g},{c},{v:.9g}" for t, a, c, v in zip(TIME, read[:, 0], cells, supply, strict=True)]
        head = "time [s],arm [rad],arm command [rad],supply [V]"
        (folder / f"{number}.csv").write_text("\n".join([head, *rows]) + "\n")
    text = "kind: gap\nleg: arm.leg.yaml\ntolerance: {torque_constant: 2 %, resistance: 2 %}\n"
    (folder / "gap.yaml").write_text(text + "trials: [0.csv, 1.csv, {file: 2.csv, held_out: true}]\n")
    return folder / "gap.yaml"


def test_the_generator_s_servo_moves_a_leg_as_the_other_engine_does(tmp_path: Path) -> None:
    """All of dead band, limits, sag, lag and delay in it."""
    project = read_gap_project(written(tmp_path / "mine"))
    rig = users_rig(project)
    for recording, trial, times in zip(recordings(project.leg, project.trials, ()), rig.trials, rig.times, strict=True):
        assert trial.speed is not None
        ours = simulate(project.leg, trial.pose, trial.speed, times, signals=recording.signals)
        theirs = release(Truth(rig.nominal), trial, 1e-4).at(times)
        assert np.degrees(np.sqrt(np.mean((ours[:, :1] - theirs) ** 2))) < 0.005


@pytest.mark.parametrize("period", [0.0, 0.01], ids=["continuous", "in control steps"])
def test_an_integral_is_the_same_in_both_engines(tmp_path: Path, period: float) -> None:
    """It begins with the load, meets its limit, and returns."""
    motor = replace(SERVO.motor, inductance=0.0)
    servo = replace(SERVO, motor=motor, integral_gain=20.0, integral_limit=0.5, control_period=period)
    leg = replace(ARM, joints=(replace(ARM.joints[0], drive=servo),))
    project = read_gap_project(written(tmp_path / "mine", leg))
    rig = users_rig(project)
    for recording, trial, times in zip(recordings(project.leg, project.trials, ()), rig.trials, rig.times, strict=True):
        assert trial.speed is not None
        ours, without = (
            simulate(each, trial.pose, trial.speed, times, tolerance=1e-8, signals=recording.signals)[:, :1]
            for each in (project.leg, ARM)
        )
        theirs = release(Truth(rig.nominal), trial, 2e-5).at(times)  # a step over a bend of the law is of first order
        assert np.degrees(np.sqrt(np.mean((ours - theirs) ** 2))) < 0.005
        assert np.degrees(np.sqrt(np.mean((ours - without) ** 2))) > 1.0


def test_each_of_two_servos_has_its_own_numbers(tmp_path: Path) -> None:
    """The second one read beyond its table once, and turned as it liked."""
    other = replace(SERVO, gain=4.0, motor=replace(SERVO.motor, resistance=5.0))
    links = Link(0.12, 0.3, 0.1, 3e-4), Link(0.1, 0.1, 0.05, 1e-4)
    leg = Leg("two", (Joint("hip", links[0], drive=SERVO), Joint("knee", links[1], drive=other)))
    command = np.stack([0.6 * np.sin(5.0 * TIME), 0.5 * np.sign(np.sin(7.0 * TIME))], axis=1)
    angle = simulate(
        leg,
        [0.0, 0.0],
        [0.0, 0.0],
        TIME,
        signals=ServoSignals(TIME, command, 7.4 + 0 * command, 1 + 0 * command, (0, 1)),
    )
    write_leg(leg, tmp_path / "two.leg.yaml")
    table = np.column_stack([TIME, angle, command])
    head = "time [s],hip [rad],knee [rad],hip command [rad],knee command [rad]"
    np.savetxt(tmp_path / "0.csv", table, "%.9g", ",", header=head, comments="")
    (tmp_path / "gap.yaml").write_text("kind: gap\nleg: two.leg.yaml\ntrials: [0.csv]\n")
    rig = users_rig(read_gap_project(tmp_path / "gap.yaml"))
    found = release(Truth(rig.nominal), rig.trials[0]._replace(pose=np.zeros(2), speed=np.zeros(2)), 1e-4).at(TIME)
    assert np.degrees(np.sqrt(np.mean((found - angle) ** 2))) < 0.01


def test_the_leads_of_one_of_two_servos_of_a_supply_are_planted() -> None:
    """Both hang on 7.4 V; it was refused for them."""
    servos = tuple(PlantedServo(j, 2.0, 0.0, 0.0, 1.0, 0.0, 0.1, 0.05, 9.0, 0.0, 0.0) for j in range(2))
    setup = SimpleNamespace(true=SimpleNamespace(servos=servos, n=2), trials=[SimpleNamespace(inputs=None)])
    form = SERVO_ERRORS["voltage_sag"](np.random.default_rng(0), setup, SimpleNamespace(), 1)  # type: ignore[arg-type]
    assert form.build(0.4)[0].servo_errors == ((1, "sag", 0.4),)


CAUSES = {
    "command_rate_limit": ({"rate": 2.5}, {"servo_errors": ((0, "command_rate", 2.5),)}),
    "voltage_sag": ({"share": 0.4}, {"servo_errors": ((0, "sag", 0.4),)}),
    "gear_friction": (
        {"torque": 0.0, "share": 0.15, "backdriven": 0.0, "fall": 0.0, "speed": 1.0, "presliding": 1e-4},
        {"laws": (Law(torque_laws.GEAR, 0, (0.15, 0.0)),)},
    ),
    "winding_heating": (
        {"rise": 0.8, "reference": 0.2, "time": 1.5},
        {"servo_errors": ((0, "rise", 0.8), (0, "reference", 0.2), (0, "warming", 1.5))},
    ),
}


@pytest.mark.parametrize("name", CAUSES)
def test_planted_causes_move_a_leg_as_the_effects_of_the_other_engine_do(name: str, tmp_path: Path) -> None:
    """A source's resistance, friction of a gear by its torque, a winding that warms: forms of two engines."""
    ours, theirs = CAUSES[name]
    project = read_gap_project(written(tmp_path / "mine"))
    rig = users_rig(project)
    effective = ARM.with_joints(arm={"effects": {name: ours}})
    for recording, trial, times in zip(recordings(project.leg, project.trials, ()), rig.trials, rig.times, strict=True):
        assert trial.speed is not None
        found = simulate(effective, trial.pose, trial.speed, times, signals=recording.signals)[:, :1]
        plain = simulate(ARM, trial.pose, trial.speed, times, signals=recording.signals)[:, :1]
        planted = release(Truth(rig.nominal, **theirs), trial, 1e-4).at(times)
        apart = float(np.sqrt(np.mean((found - planted) ** 2)))
        assert apart < 0.03 * float(np.sqrt(np.mean((found - plain) ** 2)))


@pytest.mark.slow  # like ``test_rehearsal``, on a servo
def test_a_servo_s_cause_is_planted_and_found(tmp_path: Path) -> None:
    project = read_gap_project(written(tmp_path / "mine"))
    rig = users_rig(project)
    assert {("servo_gain", 0), ("gear_friction", 0)} <= set(cause_places(rig, 1))
    assert ("voltage_sag", 0) not in cause_places(rig, 1)  # the supply was recorded, with its sag
    field = Field.of(rig, 3, 0)
    planted = field.plant(np.random.default_rng(1), PlantingTask("command_delay", 0, 3, 0))
    assert planted is not None
    assert planted.answer["causes"][0]["size"] > 0.003  # s
    (tmp_path / "case").mkdir()
    case = write_case(project, rig, planted, tmp_path / "case")
    again = users_rig(read_gap_project(case))
    for first, second in zip(rig.trials, again.trials, strict=True):
        assert first.inputs is not None
        assert second.inputs is not None
        for mine, theirs in zip(first.inputs, second.inputs, strict=True):
            np.testing.assert_allclose(theirs, mine, atol=1e-7)
    document, said = diagnose_apart(case, tmp_path / "out", [])
    assert document is not None, said
    assert ("command_delay", "arm") in named_causes(document)


def test_causes_of_what_a_servo_lacks_are_not_drawn(tmp_path: Path) -> None:
    """Motor constant and spring rate of a torque servo without spring took places of the count, "not as large"."""
    bare = ARM.with_joints(arm={"drive": Servo(8.0, 0.15, torque_limit=1.2)})
    path = written(tmp_path / "bare", bare)
    for file in path.parent.glob("*.csv"):
        rows = [line.rsplit(",", 1)[0] for line in file.read_text().splitlines()]  # a servo without motor has no supply
        file.write_text("\n".join(rows) + "\n")
    path.write_text(path.read_text().replace("tolerance: {torque_constant: 2 %, resistance: 2 %}\n", ""))
    rig = users_rig(read_gap_project(path))
    drawn = {effect for effect, _ in cause_places(rig, 0)}
    assert {"servo_gain", "gear_friction", "coulomb_friction", "viscous_damping", "link_mass", "base_tilt"} <= drawn
    motor = {"torque_constant", "winding_resistance", "current_limit", "voltage_sag", "winding_heating"}
    assert not drawn & (motor | {"spring_rate", "spring_preload", "backlash", "shear_thinning_damping"})
    with pytest.raises(NotApplicable, match="no motor at this joint"):
        Field.of(rig, 1, 0).plant(np.random.default_rng(0), PlantingTask("torque_constant", 0, 1, 0))


TIMINGS: dict[str, dict[str, Any]] = {
    "control steps": {"control_period": 8e-3},
    "a delay of steps and a fraction, few duties": {"control_period": 6e-3, "delay": 0.0147, "duty_steps": 25.0},
    "shorter than the winding's lag": {"control_period": 2e-4},
    "a command's rate, by steps": {"control_period": 7e-3, "command_rate_limit": 2.5},
    "interpolated": {"linear_commands": True},
    "interpolated, by steps": {"linear_commands": True, "control_period": 9e-3, "delay": 0.0},
}


@pytest.mark.parametrize("name", TIMINGS)
def test_looks_and_interpolated_commands_are_those_of_the_other_engine(name: str, tmp_path: Path) -> None:
    leg = ARM.with_joints(arm={"drive": replace(SERVO, **TIMINGS[name])})
    project = read_gap_project(written(tmp_path / "mine", leg))
    rig = users_rig(project)
    for recording, trial, times in zip(recordings(leg, project.trials, ()), rig.trials, rig.times, strict=True):
        assert trial.speed is not None
        ours = simulate(leg, trial.pose, trial.speed, times, signals=recording.signals, tolerance=1e-7)[:, :1]
        assert recording.signals is not None
        held = replace(recording.signals, held=(0,))
        plain = simulate(ARM, trial.pose, trial.speed, times, signals=held)[:, :1]
        theirs = release(Truth(rig.nominal), trial, 1e-4).at(times)
        apart = float(np.degrees(np.sqrt(np.mean((ours - theirs) ** 2))))
        assert apart < 0.005
        assert apart < 0.05 * float(np.degrees(np.sqrt(np.mean((ours - plain) ** 2))))


def test_a_gear_rubs_by_the_torque_that_its_servo_holds(tmp_path: Path) -> None:
    """Between two looks; one law more before the servo's, so that its place counts."""
    ours, theirs = CAUSES["gear_friction"]
    leg = ARM.with_joints(arm={"drive": replace(SERVO, control_period=8e-3)})
    project = read_gap_project(written(tmp_path / "mine", leg))
    rig, effective = users_rig(project), leg.with_joints(arm={"effects": {"gear_friction": ours}})
    laws = (Law(torque_laws.DRAG, 0, (1e-9, 0.0)), *theirs["laws"])
    for recording, trial, times in zip(recordings(leg, project.trials, ()), rig.trials, rig.times, strict=True):
        assert trial.speed is not None
        found, plain = (
            simulate(each, trial.pose, trial.speed, times, signals=recording.signals)[:, :1]
            for each in (effective, leg)
        )
        planted = release(Truth(rig.nominal, laws=laws), trial, 1e-4).at(times)
        assert np.sqrt(np.mean((found - planted) ** 2)) < 0.03 * np.sqrt(np.mean((found - plain) ** 2))


def test_every_cause_has_a_size_in_its_usual_unit() -> None:
    """Without one the table shows how often it is found, but not from which size."""
    assert set(sizes.SIZE_MEANINGS) == set(LIBRARY)
