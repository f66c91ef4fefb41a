"""Rehearsals of rigs whose motor's current or voltage was recorded: tolerances, causes and columns are the rig's."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo, ServoSignals, TorqueDrive
from synth.files.gap_project import GapProject, read_gap_project
from synth.files.leg_file import write_leg
from synth.files.tolerance import QUANTITIES
from synth.fit.recordings import recordings
from synth.planting.model import Truth
from synth.planting.simulation import release
from synth.rehearsal.case_files import write_case
from synth.rehearsal.plants import Field, PlantingTask, cause_places
from synth.rehearsal.users_rig import users_rig
from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, Joint, Leg, Link

MOTOR = GearedMotor(1.2, 0.015, 40.0, 0.9, rotor_inertia=1e-6)
NOISE = 1e-4  # rad
TIME = np.arange(0.0, 2.0, 0.01)
LINK = Link(0.3, 0.6, 0.22, 4e-3)


def arm(drive: TorqueDrive | Servo) -> Leg:
    return Leg("arm", (Joint("arm", LINK, zero=0.2, sign=-1, damper=Damper(0.03), drive=drive),))


CURRENT = arm(TorqueDrive(MOTOR))
VOLTAGE = arm(Servo(gain=0.0, open_duty=1.0, motor=MOTOR))


def project(folder: Path, leg: Leg, *, free: bool = False) -> GapProject:
    """Three motions under a current or a voltage, in the measured sense; ``free`` : and one with the drive off."""
    folder.mkdir()
    write_leg(leg, folder / "arm.leg.yaml")
    entries = ["0.csv", "1.csv", "{file: 2.csv, held_out: true}"]
    for number in range(3):
        told = np.sin((2.0 + number) * TIME)[:, None]
        if leg is CURRENT:
            known = (TIME, leg.sign * MOTOR.torque_a_current * told)
            motion, head = simulate(leg, [0.1], [0.0], TIME, known_torque=known), "arm current [A]"
        else:
            told = 3.0 * told
            signals = ServoSignals(TIME, 0.0 * told, leg.sign * told, np.ones_like(told))
            motion, head = simulate(leg, [0.1], [0.0], TIME, signals=signals)[:, :1], "arm voltage [V]"
        _write(folder / f"{number}.csv", leg, motion, head, told[:, 0])
    if free:
        entries.append("{file: 3.csv, drive_off: [arm]}")
        _write(folder / "3.csv", leg, simulate(leg, [0.8], [0.0], TIME), "", None)
    (folder / "gap.yaml").write_text(f"kind: gap\nleg: arm.leg.yaml\ntrials: [{', '.join(entries)}]\n")
    return read_gap_project(folder / "gap.yaml")


def _write(path: Path, leg: Leg, motion: np.ndarray, head: str, told: np.ndarray | None) -> None:
    read = leg.to_measured(motion + NOISE * np.random.default_rng(len(path.name)).standard_normal(motion.shape))
    more = [""] * len(TIME) if told is None else [f",{value:.9g}" for value in told]
    rows = [f"{t:.9g},{a:.9g}{c}" for t, a, c in zip(TIME, read[:, 0], more, strict=True)]
    path.write_text("\n".join([f"time [s],arm [rad]{',' if head else ''}{head}", *rows]) + "\n")


@pytest.mark.parametrize("leg", [CURRENT, VOLTAGE])
def test_the_generator_s_motor_moves_a_leg_as_the_other_engine_does(leg: Leg, tmp_path: Path) -> None:
    found = project(tmp_path / "mine", leg)
    rig = users_rig(found)
    for recording, trial, times in zip(recordings(leg, found.trials, ()), rig.trials, rig.times, strict=True):
        assert trial.speed is not None
        ours = simulate(
            leg, trial.pose, trial.speed, times, signals=recording.signals, known_torque=recording.known_torque
        )
        theirs = release(Truth(rig.nominal), trial, 1e-4).at(times)
        assert np.degrees(np.sqrt(np.mean((ours[:, :1] - theirs) ** 2))) < 0.01


def test_the_constant_of_a_recorded_current_s_motor_is_planted_within_its_tolerance(tmp_path: Path) -> None:
    """Its tolerance was 0: the leg's torque was the designed one in every case."""
    found = project(tmp_path / "mine", CURRENT)
    rig = users_rig(found)
    assert rig.widths[QUANTITIES.index("torque_constant"), 0] == pytest.approx(0.1)
    assert rig.widths[QUANTITIES.index("resistance"), 0] == 0.0
    stronger = rig.nominal.changed("torque_constant", 0, 1.2)
    trial = rig.trials[0]
    assert trial.known is not None
    times = rig.times[0]
    theirs = release(Truth(stronger), trial, 1e-4).at(times)
    ours = simulate(CURRENT, trial.pose, trial.speed, times, known_torque=(trial.known[0], 1.2 * trial.known[1]))
    assert np.degrees(np.sqrt(np.mean((ours[:, :1] - theirs) ** 2))) < 0.01
    assert np.degrees(np.abs(theirs - release(Truth(rig.nominal), trial, 1e-4).at(times)).max()) > 1.0


def test_a_kept_case_has_the_current_and_reads_back(tmp_path: Path) -> None:
    """It had the torque: another rig, whose motor has no tolerance. A drive that was off is off again."""
    found = project(tmp_path / "mine", CURRENT, free=True)
    rig = users_rig(found)
    planted = Field.of(rig, 0, 0).plant(np.random.default_rng(1), PlantingTask("viscous_damping", 0, 2, 0))
    assert "torque_constant" in planted.answer["truth"]["leg"]["arm"]
    (tmp_path / "case").mkdir()
    again = read_gap_project(write_case(found, rig, planted, tmp_path / "case"))
    assert (tmp_path / "case" / "trials" / "001.csv").read_text().startswith("time [s],arm [deg],arm current [A]\n")
    for first, second in zip(found.trials, again.trials, strict=True):
        assert first.by_current == second.by_current
        if first.torques is None:
            assert second.torques is None
        else:
            assert second.torques is not None
            np.testing.assert_allclose(second.torques, first.torques, atol=1e-8)
    assert users_rig(again).widths[QUANTITIES.index("torque_constant"), 0] == pytest.approx(0.1)


def test_causes_of_a_motor_are_planted_where_its_voltage_is_known(tmp_path: Path) -> None:
    """They needed a gain, which nothing has that is not controlled; the diagnosis looks for them."""
    rig = users_rig(project(tmp_path / "mine", VOLTAGE))
    places = {effect for effect, _ in cause_places(rig, 0)}
    assert places >= {"torque_constant", "winding_resistance", "current_limit", "gear_friction"}
    assert not places & {"command_delay", "servo_gain", "dead_band", "command_rate_limit", "voltage_sag"}
    planted = Field.of(rig, 0, 0).plant(np.random.default_rng(1), PlantingTask("winding_resistance", 0, 2, 0))
    assert planted.answer["causes"][0]["effect"] == "winding_resistance"
