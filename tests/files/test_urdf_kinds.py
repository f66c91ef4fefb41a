"""URDF files of many kinds: the leg has the inertias and gravity torques that MuJoCo reads from the same file."""

from __future__ import annotations

import math
from pathlib import Path

import mujoco
import pytest

from robot_forces import farthest_from_mujoco
from synth.errors import UserError
from synth.files.robots.planar_chain import PickedLeg
from synth.files.robots.robot_project import robot_leg

LINK = """<link name="{}"><inertial><origin xyz="{}" rpy=".1 .2 .3"/><mass value=".5"/><inertia ixx="2e-3" ixy="1e-5"
 ixz="2e-5" iyy="2.5e-3" iyz="-1e-5" izz="1e-3"/></inertial></link>"""
JOINT = """<joint name="{}" type="{}"><parent link="{}"/><child link="{}"/><origin xyz="{}" {}/><axis xyz="{}"/>
 <limit lower="-2" upper="2" effort="1" velocity="1"/></joint>"""
KNEE = JOINT.format("k", "revolute", "thigh", "shin", "0 0 -.25", 'rpy="0 .3 0"', "0 -1 0")
LEG = (
    LINK.format("base", "0 0 0") + LINK.format("thigh", "0 .01 -.1") + LINK.format("shin", "0 0 -.1")
    + JOINT.format("h", "continuous", "base", "thigh", ".1 .02 .5", "", "0 1 0") + KNEE
)  # fmt: skip
FLOATING = '<link name="world"/>' + JOINT.format("f", "floating", "world", "base", "0 0 1", 'rpy="{}"', "1 0 0")
RAIL = LINK.format("foot", "0 0 -.03") + JOINT.format("r", "prismatic", "shin", "foot", "0 0 -.2", "", "0 0 -1")
QUATERNION = f'quat_xyzw="0 {2.0 * math.sin(0.15)!r} 0 {2.0 * math.cos(0.15)!r}"'  # of any length
DRAKE = 'xmlns="http://drake.mit.edu" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"'
PLAIN = '<mujoco><compiler fusestatic="false" balanceinertia="false"/></mujoco>'


def written(folder: Path, content: str, head: str = "") -> Path:
    (folder / "r.urdf").write_text(f'<robot name="r" {head}>{PLAIN}{content}</robot>')
    return folder / "r.urdf"


def picked(folder: Path, content: str, head: str = "", model: str | None = None) -> PickedLeg:
    """The leg, compared with what MuJoCo reads; ``model`` : the same robot where MuJoCo does not know its notation."""
    found = robot_leg(written(folder, content, head), ["h", "k"], tip=0.2)
    theirs = mujoco.MjModel.from_xml_string(f'<robot name="r">{PLAIN}{model or content}</robot>')
    assert farthest_from_mujoco(found.leg, theirs) < 1e-9
    return found


@pytest.mark.parametrize("rpy", ["0 0 0", "0 .2 0", "0 0 .7", "0 0 3.14159265358979"])
def test_a_floating_base_is_held_where_the_file_has_it(rpy: str, tmp_path: Path) -> None:
    found = picked(tmp_path, LEG + FLOATING.format(rpy))
    assert "the body is held: f above the chain cannot move" in found.messages
    assert found.leg.tilt == pytest.approx(-0.2 if rpy == "0 .2 0" else 0.0, abs=1e-9)


def test_a_slide_below_the_chain_is_locked_and_lumped(tmp_path: Path) -> None:
    assert "r is locked where it stands, and its bodies are lumped" in picked(tmp_path, LEG + RAIL).messages


def test_a_fixed_joint_needs_no_axis(tmp_path: Path) -> None:
    """CAD exporters write one of length 0 there, as in the files of Go2, SO-101 and iCub; that was refused."""
    foot = LINK.format("foot", "0 0 -.03") + JOINT.format("r", "fixed", "shin", "foot", "0 0 -.2", "", "0 0 0")
    picked(tmp_path, LEG + foot)


def test_a_hinge_needs_an_axis(tmp_path: Path) -> None:
    axis = '<axis xyz="0 1 0"/>'
    assert LEG.count(axis) == 1
    with pytest.raises(UserError, match='joint h: is continuous and has axis xyz="0 0 0"; write the direction'):
        robot_leg(written(tmp_path, LEG.replace(axis, '<axis xyz="0 0 0"/>')), ["h", "k"], tip=0.2)


@pytest.mark.parametrize(("ends", "out"), [("-2.7 -.9", ", out of its range -154.7 to -51.57 deg"), ("0 2", "")])
def test_a_joint_locked_out_of_its_range_is_told(ends: str, out: str, tmp_path: Path) -> None:
    """A quadruped's knee does not reach 0, where a leg of the hip alone locks it."""
    lower, upper = ends.split()
    knee = KNEE.replace('lower="-2" upper="2"', f'lower="{lower}" upper="{upper}"')
    found = robot_leg(written(tmp_path, LEG.replace(KNEE, knee)), ["h"], tip=0.2)
    assert f"k is locked at 0 deg{out}, and its bodies are lumped" in found.messages


def test_a_turn_may_be_a_quaternion(tmp_path: Path) -> None:
    """URDF 1.1's; it was passed over, and the link stood as if not turned."""
    turned = LEG.replace('rpy="0 .3 0"', QUATERNION)
    assert turned != LEG
    picked(tmp_path, turned, 'version="1.1"', LEG)


@pytest.mark.parametrize(
    ("new", "words"),
    [
        (f'rpy="0 .3 0" {QUATERNION}', "joint k: has an origin with both rpy and quat_xyzw"),
        ('quat_xyzw="0 0 0 0"', 'joint k: quat_xyzw="0 0 0 0" is no rotation'),
        ('quat_xyzw="0 0 1"', 'joint k: quat_xyzw="0 0 1" is not 4 finite numbers'),
    ],
)
def test_mistakes_of_a_quaternion(new: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(UserError, match=words):
        robot_leg(written(tmp_path, LEG.replace('rpy="0 .3 0"', new)), ["h", "k"])


def test_drake_s_files_are_read(tmp_path: Path) -> None:
    """Their namespace was taken for another root than <robot>."""
    picked(tmp_path, LEG, DRAKE)


def test_links_without_any_joint_are_told(tmp_path: Path) -> None:
    (said,) = [text for text in picked(tmp_path, LEG + LINK.format("lost", "0 0 0")).messages if "no joint" in text]
    assert said.startswith("base, lost hang by no joint")


def test_a_loop_is_refused(tmp_path: Path) -> None:
    """A four-bar linkage: a URDF is a tree."""
    crank = LINK.format("crank", "0 0 -.1") + JOINT.format("c", "revolute", "base", "crank", ".2 0 .5", "", "0 1 0")
    closing = JOINT.format("z", "revolute", "crank", "shin", "0 0 -.2", "", "0 1 0")
    with pytest.raises(UserError, match='joint z: "shin" hangs by two joints; a URDF is a tree'):
        robot_leg(written(tmp_path, LEG + crank + closing), ["h", "k"])
