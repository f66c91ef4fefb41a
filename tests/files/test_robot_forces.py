"""Forces on a robot's leg from outside, in MJCF: compensated weight and contacts."""

from __future__ import annotations

import math
from pathlib import Path

import mujoco
import numpy as np
import pytest

from synth.cli import main
from synth.errors import UserError
from synth.files.robots.robot_project import robot_leg
from synth.swing.chain import simulate

ROBOT = """<mujoco model="arm"><compiler angle="radian"/><option integrator="RK4" timestep="1e-4">{flag}</option>
<worldbody><geom name="floor" type="plane" size="2 2 .1"/>
 <body name="upper" pos="0 0 1" gravcomp="{upper}"><joint name="shoulder" axis="0 1 0" damping=".05"/>
  <geom type="capsule" fromto="0 0 0 0 0 -.2" size=".02" mass=".5" {shape}/>
  <body name="lower" pos="0 0 -.2" gravcomp="{lower}"><joint name="elbow" axis="0 1 0" damping=".02" stiffness=".3"/>
   <geom type="capsule" fromto="0 0 0 0 0 -.2" size=".02" mass=".3" {shape}/>
   <body name="hand" pos="0 0 -.2" gravcomp="{lower}"><geom type="sphere" size=".03" mass=".1" {shape}/></body>
  </body></body></worldbody>{more}</mujoco>"""
PLAIN = {"flag": "", "upper": "0", "lower": "0", "shape": "", "more": ""}
NO_CONTACT = '<flag contact="disable"/>'
CHAIN = ("shoulder", "elbow")


def written(path: Path, **words: str) -> tuple[Path, str]:
    text = ROBOT.format(**PLAIN | words)
    path.write_text(text)
    return path, text


@pytest.mark.parametrize("share", ["1", "0.4"])
def test_compensated_weight_moves_the_leg_as_mujoco(tmp_path: Path, share: str) -> None:
    path, text = written(tmp_path / "a.xml", upper=share, lower=share, flag=NO_CONTACT)
    picked = robot_leg(path, CHAIN)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qpos[:] = 0.9, -0.5
    mujoco.mj_step(model, data, nstep=4000)
    start = np.array(
        [joint.sign * (value - joint.zero) for joint, value in zip(picked.leg.joints, (0.9, -0.5), strict=True)]
    )
    moved = simulate(picked.leg, start, np.zeros(2), np.array([0.0, 0.4]), tolerance=1e-9)[-1]
    np.testing.assert_allclose(picked.leg.to_measured(moved), data.qpos, atol=1e-5)
    expected = (
        f"gravcomp compensates {share} of the weight: the leg's gravity is the rest; that of a trial's tip mass would"
    )
    assert [message for message in picked.messages if message.startswith(expected)]


@pytest.mark.parametrize(("upper", "lower"), [("1", "0"), ("0.5", "0.4"), ("1.2", "1.2")])
def test_weight_compensated_unequally_is_refused(tmp_path: Path, upper: str, lower: str) -> None:
    path, _ = written(tmp_path / "a.xml", upper=upper, lower=lower)
    with pytest.raises(
        UserError, match=rf"a.xml: gravcomp of the chain's bodies is upper {upper}, lower {lower}, hand "
    ):
        robot_leg(path, CHAIN)


def test_gravity_that_a_flag_switches_off_is_none(tmp_path: Path) -> None:
    path, _ = written(tmp_path / "a.xml", flag='<flag gravity="disable" spring="disable"/>', upper="1")
    picked = robot_leg(path, CHAIN)
    assert math.isclose(picked.leg.gravity, 0.0, abs_tol=0.0)
    assert "a flag of the file switches its springs off; the leg has them" in picked.messages


def test_contacts_of_the_links_are_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The hand is one link with the lower arm, whose contact with the upper one MuJoCo leaves out."""
    path, _ = written(tmp_path / "a.xml")
    floor = "contacts of the links with what is fixed in the world are left out: upper and floor, lower and floor, hand"
    assert main(["init", "fit", str(tmp_path / "leg"), "--from", str(path), "--chain", ",".join(CHAIN)]) == 0
    capsys.readouterr()
    readme = (tmp_path / "leg" / "README.md").read_text()
    assert f"- {floor} and floor\n" in readme
    assert "- nothing" not in readme


@pytest.mark.parametrize(
    "words",
    [
        {"flag": NO_CONTACT},
        {"shape": 'contype="0" conaffinity="0"'},
        {"shape": 'contype="2" conaffinity="2"', "more": ""},
    ],
)
def test_shapes_that_cannot_collide_are_not_named(tmp_path: Path, words: dict[str, str]) -> None:
    path, _ = written(tmp_path / "a.xml", **words)
    assert not robot_leg(path, CHAIN).messages


def test_contacts_among_the_links_follow_mujoco_s_rules(tmp_path: Path) -> None:
    """A hand on a joint of its own meets the upper arm, unless that pair is excluded; a listed pair meets always."""
    words = {"shape": 'contype="2" conaffinity="2"'}
    text = ROBOT.format(**PLAIN | words).replace(
        '<geom type="sphere"', '<joint name="wrist" axis="0 1 0"/><geom name="ball" pos="0 0 -.05" type="sphere"'
    )
    among = "contacts of the links with one another and with other parts are left out: "
    path = tmp_path / "a.xml"
    path.write_text(text)
    chain = (*CHAIN, "wrist")
    assert robot_leg(path, chain).messages == (f"{among}upper and hand",)
    path.write_text(text.replace("</mujoco>", '<contact><exclude body1="hand" body2="upper"/></contact></mujoco>'))
    assert robot_leg(path, chain).messages == ()
    path.write_text(text.replace("</mujoco>", '<contact><pair geom1="floor" geom2="ball"/></contact></mujoco>'))
    assert "fixed in the world are left out: hand and floor" in robot_leg(path, chain).messages[0]
