"""Links whose centre of mass lies beside the line to the next joint: from a robot's file, to files and back."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from robot_forces import farthest_from_mujoco
from synth.errors import UserError
from synth.files.leg_file import read_leg, write_leg
from synth.files.mjcf import mjcf_text
from synth.files.robots.robot_project import robot_leg
from synth.swing.chain import simulate
from synth.swing.leg_model import Joint, Leg, Link

# Places, masses and inertias of HyQ's left front leg, whose knee motor sits beside the thigh:
# https://github.com/Gepetto/example-robot-data, robots/hyq_description/robots/hyq_no_sensors.urdf (commit 014f4c4)
HYQ = """<robot name="hyq">
<link name="hip"/><link name="upper"><inertial><origin xyz="0.15074 -0.02625 0"/><mass value="2.638"/>
<inertia ixx="0.00368" ixy="-0.00302" ixz="0.0001" iyy="0.02719" iyz="2e-05" izz="0.02811"/></inertial></link>
<link name="lower"><inertial><origin xyz="0.1254 4e-05 -0.0001"/><mass value="0.881"/>
<inertia ixx="0.00047" ixy="6e-05" ixz="-1e-05" iyy="0.01256" iyz="0" izz="0.01233"/></inertial></link>
<link name="foot"/>
<joint name="lf_hfe_joint" type="revolute"><origin rpy="3.14159265359 1.57079632679 0"/><parent link="hip"/>
<child link="upper"/><axis xyz="0 0 1"/><limit effort="150" lower="-3" upper="3" velocity="12"/></joint>
<joint name="lf_kfe_joint" type="revolute"><origin xyz="0.35 0 0"/><parent link="upper"/><child link="lower"/>
<axis xyz="0 0 1"/><limit effort="150" lower="-3" upper="3" velocity="12"/></joint>
<joint name="lf_foot_joint" type="fixed"><origin xyz="0.346 0 0"/><parent link="lower"/><child link="foot"/></joint>
</robot>"""
CHAIN = ["lf_hfe_joint", "lf_kfe_joint"]


def hyq(folder: Path) -> tuple[Leg, mujoco.MjModel]:
    (folder / "hyq.urdf").write_text(HYQ)
    picked = robot_leg(folder / "hyq.urdf", CHAIN)
    assert not [said for said in picked.messages if "centre of mass" in said]
    return picked.leg, mujoco.MjModel.from_xml_path(str(folder / "hyq.urdf"))


def on_lines(leg: Leg) -> Leg:
    joints = [replace(joint, link=replace(joint.link, com_across=0.0)) for joint in leg.joints]
    return replace(leg, joints=tuple(joints))


def test_a_real_leg_with_its_motor_beside_the_thigh_has_its_robot_s_inertia_and_weight(tmp_path: Path) -> None:
    """Its thigh's mass was put on the line: the weight's torque was off by up to 8.5 % of the largest."""
    leg, model = hyq(tmp_path)
    assert abs(leg.joints[0].link.com_across) == pytest.approx(0.02625, rel=1e-6)
    assert farthest_from_mujoco(leg, model) < 1e-8
    assert farthest_from_mujoco(on_lines(leg), model) > 0.05


def test_the_side_survives_the_leg_file_and_the_model_for_mujoco(tmp_path: Path) -> None:
    leg, _ = hyq(tmp_path)
    write_leg(leg, tmp_path / "hyq.leg.yaml")
    again = read_leg(tmp_path / "hyq.leg.yaml")
    for joint, back in zip(leg.joints, again.joints, strict=True):
        assert back.link.com_across == pytest.approx(joint.link.com_across, rel=1e-9, abs=1e-12)
    model = mujoco.MjModel.from_xml_string(mjcf_text(again, np.ones(2)))
    as_q = replace(again, joints=tuple(replace(j, zero=0.0, sign=1) for j in again.joints))  # the file's angles
    assert farthest_from_mujoco(as_q, model) < 1e-8


def test_a_last_link_s_side_is_the_same_as_another_zero() -> None:
    """Nothing hangs from its end: a pendulum whose mass lies beside its line is one turned by that angle."""
    away = np.hypot(0.1, 0.03)
    inertia = 2e-3
    beside = Leg("a", (Joint("j", Link(0.2, 0.4, 0.1, inertia, com_across=0.03)),))
    turned = Leg("b", (Joint("j", Link(0.2, 0.4, float(away), inertia)),))
    by, times = np.arctan2(0.03, 0.1), np.linspace(0.0, 2.0, 51)
    one = simulate(beside, [0.7], [0.0], times, tolerance=1e-10)
    other = simulate(turned, [0.7 + by], [0.0], times, tolerance=1e-10)
    np.testing.assert_allclose(one, other - by, atol=1e-8)


def test_a_mass_that_no_link_has_is_refused(tmp_path: Path) -> None:
    """It was taken, and the sums of inertias overflowed."""
    leg, _ = hyq(tmp_path)
    path = tmp_path / "a.leg.yaml"
    write_leg(leg, path)
    path.write_text(path.read_text().replace("mass: 2.638 kg", "mass: 2.638e30 kg"))
    with pytest.raises(UserError, match="it can be at most 1000000 kg"):
        read_leg(path)


@pytest.mark.parametrize(("written", "told"), [("900 m", "from its line"), ("30 kg", "kg")])
def test_an_impossible_side_is_refused(written: str, told: str, tmp_path: Path) -> None:
    leg, _ = hyq(tmp_path)
    path = tmp_path / "a.leg.yaml"
    write_leg(leg, path)
    path.write_text(re.sub(r"com_across: -?26\.\d* mm", f"com_across: {written}", path.read_text()))
    with pytest.raises(UserError, match="com_across") as found:
        read_leg(path)
    assert told in str(found.value)
