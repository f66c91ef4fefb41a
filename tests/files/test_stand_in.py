"""Friction that MuJoCo's joints lack: what stands for it, and that the stated error is MuJoCo's own."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from synth.arrays import Array
from synth.diagnosis.plants.swinging_chain.plain_drive import drive_error
from synth.diagnosis.plants.swinging_chain.stand_in import stand_in
from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo, ServoSignals
from synth.files.simulator_files import write_simulator_files
from synth.files.trial_list import Trial
from synth.swing.chain import simulate
from synth.swing.leg_model import Joint, Leg, Link

SERVO = Servo(gain=1.2, supply=7.4, motor=GearedMotor(3.4, 0.36, rotor_inertia=1.8e-3))
FRICTION = {"torque": 0.02, "share": 0.3, "backdriven": 0.0, "fall": 0.0, "speed": 1.0, "presliding": 1e-4}
ARM = Leg("arm", (Joint("arm", Link(0.12, 0.3, 0.1, 3e-4), drive=SERVO, effects={"gear_friction": FRICTION}),))
TIMES = np.arange(0.0, 2.0 + 1e-9, 5e-4)
COMMANDS = 0.8 * np.sin(4.0 * TIMES) + 0.2 * np.sin(13.0 * TIMES), 0.6 * np.arcsin(np.sin(5.0 * TIMES))


def signals(command: Array) -> ServoSignals:
    ones = np.ones((len(TIMES), 1))
    return ServoSignals(TIMES, command[:, None], 7.4 * ones, ones)


def trials() -> list[Trial]:
    """What the leg with the friction does, every 5 ms."""
    made = []
    for number, command in enumerate(COMMANDS):
        angle = simulate(ARM, [0.0], [0.0], TIMES, signals=signals(command))[::10]
        made.append(Trial(f"{number}.csv", TIMES[::10], angle, signals=signals(command)))
    return made


def in_mujoco(path: Path, command: Array) -> Array:
    """(m, 1) rad, from rest."""
    model = mujoco.MjModel.from_xml_path(str(path))
    data, found = mujoco.MjData(model), np.empty((len(TIMES), 1))
    for index, time in enumerate(TIMES):
        while data.time < time - 0.5 * model.opt.timestep:
            data.ctrl[:] = np.interp(data.time + 0.5 * model.opt.timestep, TIMES, command)
            mujoco.mj_step(model, data)
        found[index] = data.qpos
    return found


def test_mujoco_moves_as_far_from_the_diagnosed_leg_as_its_file_says(tmp_path: Path) -> None:
    found = stand_in(ARM, trials())
    assert found is not None
    write_simulator_files(ARM, np.full(1, 10.0), tmp_path, found.leg, found.texts)
    text = (tmp_path / "leg.mjcf.xml").read_text()
    assert all(f"<!-- {each} -->" in text for each in found.texts)
    assert "not in this model" not in text
    assert found.texts[0] in (tmp_path / "README.md").read_text()
    left, without = (float(x) for x in re.findall(r"([\d.]+) deg", found.texts[-1]))
    assert left < 0.5 * without
    for leg, stated in ((found.leg, left), (replace(ARM, joints=(replace(ARM.joints[0], effects={}),)), without)):
        write_simulator_files(leg, np.full(1, 10.0), tmp_path / "again")
        apart = [
            in_mujoco(tmp_path / "again" / "leg.mjcf.xml", command)
            - simulate(ARM, [0.0], [0.0], TIMES, signals=signals(command))
            for command in COMMANDS
        ]
        assert np.degrees(np.sqrt(np.mean(np.square(apart)))) == pytest.approx(stated, rel=0.15)


def test_no_other_friction_and_damping_come_nearer() -> None:
    found = stand_in(ARM, trials())
    assert found is not None
    wanted = [trial.angles for trial in trials()]

    def error(leg: Leg) -> float:
        moved = [simulate(leg, [0.0], [0.0], TIMES, signals=signals(command))[::10] for command in COMMANDS]
        return float(np.mean(np.square(np.array(moved) - np.array(wanted))))

    best, (joint,) = error(found.leg), found.leg.joints
    assert joint.damper is not None
    assert joint.damper.rate is not None
    friction = joint.effects["coulomb_friction"]
    for share in (0.8, 1.25):
        other = {"coulomb_friction": {**friction, "torque": share * friction["torque"]}}
        assert error(found.leg.with_joints(arm={"effects": other})) > best
        rate = joint.damper.rate * share if joint.damper.rate > 1e-4 else 1e-3 * share
        assert error(found.leg.with_joints(arm={"damper": replace(joint.damper, rate=rate)})) > best


def test_a_leg_whose_friction_is_constant_needs_none() -> None:
    plain = ARM.with_joints(arm={"effects": {"coulomb_friction": {"torque": 0.05, "presliding": 1e-4}}})
    assert stand_in(plain, trials()) is None


@pytest.mark.parametrize("change", [{"dead_band": 0.02}, {"current_limit": 1.0}, {"source_resistance": 1.5}])
def test_the_error_of_a_drive_that_mujoco_lacks_is_mujocos_own(change: dict[str, float], tmp_path: Path) -> None:
    leg = replace(ARM, joints=(replace(ARM.joints[0], drive=replace(SERVO, **change), effects={}),))
    (text,) = drive_error(leg, trials())
    write_simulator_files(leg, np.full(1, 10.0), tmp_path, driven=(text,))
    assert f"<!-- {text} -->" in (tmp_path / "leg.mjcf.xml").read_text()
    assert text in (tmp_path / "README.md").read_text()
    apart = [
        (in_mujoco(tmp_path / "leg.mjcf.xml", command) - simulate(leg, [0.0], [0.0], TIMES, signals=signals(command)))[
            ::10
        ]
        for command in COMMANDS
    ]
    (stated,) = (float(x) for x in re.findall(r"([\d.]+) deg", text))
    assert stated > 0.05
    assert np.degrees(np.sqrt(np.mean(np.square(apart)))) == pytest.approx(stated, rel=0.1)


def test_a_drive_that_mujoco_has_leaves_nothing_to_state() -> None:
    assert drive_error(replace(ARM, joints=(replace(ARM.joints[0], effects={}),)), trials()) == ()
