"""Actuators of an MJCF in: their armature and damping move the joint that nothing drives."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from robot_forces import farthest_from_mujoco
from synth.files.joint_curves import damper_torque
from synth.files.robots.robot_project import robot_leg

ROBOT = """<mujoco><worldbody><body><joint name="h" axis="0 1 0" damping=".5" armature=".002" {spring}/>
<geom type="capsule" fromto="0 0 0 0 0 -.3" size=".02"/><body pos="0 0 -.3"><joint name="k" axis="0 -1 0"/>
<geom type="capsule" fromto="0 0 0 .05 0 -.25" size=".02"/></body></body></worldbody>
<tendon><fixed name="one"><joint joint="h" coef="2"/></fixed>
<fixed name="both"><joint joint="h" coef="2"/><joint joint="k" coef="2"/></fixed></tendon>
<actuator>{actuator}</actuator></mujoco>"""
KEPT = "armature and damping of the actuator {} are kept as its joint's, through the gear"


pytestmark = pytest.mark.skipif(
    not hasattr(mujoco.MjModel, "actuator_armature"), reason="this version of MuJoCo has no armature of actuators"
)


@pytest.mark.parametrize(
    "actuator",
    [
        '<motor name="m" joint="h" gear="-5" armature="1e-3" damping=".01"/>',
        '<motor name="m" jointinparent="h" gear="5" armature="1e-3" damping=".01 .02 0"/>',
        '<motor name="m" tendon="one" gear="3" armature="1e-3" damping=".01"/>',
        '<position name="m" joint="h" kp="3" armature=".004"/>',
        '<motor name="m" joint="h" gear="5" armature="1e-3"/><motor joint="h" gear="2"/>',
    ],
)
def test_armature_and_damping_of_an_actuator_move_its_joint(actuator: str, tmp_path: Path) -> None:
    """They were left out with the actuator: half of a joint's inertia with a gear of 5."""
    text = ROBOT.format(actuator=actuator, spring="")
    (tmp_path / "a.xml").write_text(text)
    picked = robot_leg(tmp_path / "a.xml", ["h", "k"])
    model = mujoco.MjModel.from_xml_string(text)
    assert farthest_from_mujoco(picked.leg, model) < 1e-9
    assert KEPT.format("m") in picked.messages
    data = mujoco.MjData(model)
    data.qvel[0] = 2.0
    mujoco.mj_forward(model, data)
    ours = damper_torque(picked.leg.joints[0], np.array([2.0]))
    np.testing.assert_allclose(ours, -data.qfrc_passive[:1], rtol=1e-9)


def test_an_actuator_on_two_joints_is_left_out_with_its_armature(tmp_path: Path) -> None:
    actuator = '<motor name="m" tendon="both" armature="1e-3"/>'
    (tmp_path / "a.xml").write_text(ROBOT.format(actuator=actuator, spring=""))
    picked = robot_leg(tmp_path / "a.xml", ["h", "k"])
    assert "armature and damping of the actuator m are left out: it does not act on one hinge alone" in picked.messages
    assert picked.leg.joints[0].armature == pytest.approx(0.002)


def test_a_spring_that_yields_is_said_to_be_elastic_here(tmp_path: Path) -> None:
    (tmp_path / "a.xml").write_text(ROBOT.format(actuator="", spring='stiffness="2" springyield=".1"'))
    picked = robot_leg(tmp_path / "a.xml", ["h", "k"])
    assert "h: its spring's yield is left out: a leg's spring is elastic" in picked.messages
