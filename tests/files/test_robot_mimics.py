"""Joints of a robot that follow others: locked where these put them, and said to move with them."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from synth.errors import UserError
from synth.files.robots.robot_project import robot_leg
from synth.swing.leg_model import Leg

BODY = '<inertial><origin xyz="{xyz}"/><mass value="{mass}"/><inertia ixx="1e-3" iyy="1e-3" izz="2e-4"/></inertial>'
TOE = '<axis xyz="0 1 0"/><mimic joint="knee" multiplier="-1" offset="0.3"/>'
NAIL = '<axis xyz="0 -1 0"/><mimic joint="toe" multiplier="2" offset="0.1"/>'
# Thigh and shank in the chain; below them a toe that mimics the knee, and a nail that mimics the toe.
URDF = f"""<robot name="r"><link name="base"/>
<link name="thigh">{BODY.format(xyz="0 0 -.1", mass=".5")}</link>
<link name="shank">{BODY.format(xyz="0 0 -.08", mass=".2")}</link>
<link name="toe_link">{BODY.format(xyz=".05 0 0", mass=".1")}</link>
<link name="nail_link">{BODY.format(xyz="0.02 0 -.01", mass=".03")}</link>
<joint name="hip" type="revolute"><parent link="base"/><child link="thigh"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1"/></joint>
<joint name="knee" type="revolute"><origin xyz="0 0 -.2"/><parent link="thigh"/><child link="shank"/>
<axis xyz="0 -1 0"/><limit lower="0" upper="2"/></joint>
<joint name="nail" type="continuous"><origin xyz=".06 0 0"/><parent link="toe_link"/><child link="nail_link"/>
{NAIL}</joint>
<joint name="toe" type="continuous"><origin xyz="0 0 -.2"/><parent link="shank"/><child link="toe_link"/>{TOE}</joint>
</robot>"""
SAID = "; it mimics {} and moves with knee in the robot, which the leg lacks"


def numbers(leg: Leg) -> list[float]:
    """What decides how a leg moves."""
    found = [leg.gravity, leg.tilt]
    for joint in leg.joints:
        found += [joint.zero, joint.sign, joint.link.length, joint.link.mass, joint.link.com, joint.link.inertia]
    return found


def of(folder: Path, text: str, name: str = "a.urdf") -> tuple[Leg, str]:
    (folder / name).write_text(text)
    picked = robot_leg(folder / name, ["hip", "knee"], "xz", tip=0.2)
    return picked.leg, "\n".join(picked.messages)


def test_a_mimic_below_the_chain_is_locked_where_its_law_has_it(tmp_path: Path) -> None:
    """As a robot whose toe and nail are welded at 0.3 and 2 x 0.3 + 0.1 rad, about +y and -y."""
    leg, said = of(tmp_path, URDF)
    welded = URDF.replace(TOE, "").replace(NAIL, "").replace('xyz="0 0 -.2"/><parent link="shank"',
                          'xyz="0 0 -.2" rpy="0 .3 0"/><parent link="shank"').replace(
                          'xyz=".06 0 0"', 'xyz=".06 0 0" rpy="0 -.7 0"')  # fmt: skip
    np.testing.assert_allclose(numbers(leg), numbers(of(tmp_path, welded)[0]), rtol=1e-12, atol=1e-15)
    straight = URDF.replace(TOE, "").replace(NAIL, "")
    assert numbers(leg) != pytest.approx(numbers(of(tmp_path, straight)[0]), rel=1e-2)
    assert (
        "toe is locked at 17.19 deg, and its bodies are lumped"
        + SAID.format("knee (-1 times the reading of knee, plus 17.19 deg)")
        in said
    )
    assert (
        "nail is locked at 40.11 deg, and its bodies are lumped"
        + SAID.format("toe (2 times the reading of toe, plus 5.73 deg)")
        in said
    )


def test_a_mimic_in_the_chain_swings_freely_and_says_so(tmp_path: Path) -> None:
    """Its zero is where its link points along the parent, which the offset does not change."""
    (tmp_path / "a.urdf").write_text(URDF)
    picked = robot_leg(tmp_path / "a.urdf", ["knee", "toe"], "xz", tip=0.2)
    text = "toe: it mimics knee (-1 times the reading of knee, plus 17.19 deg), which is left out"
    assert text in picked.messages
    (tmp_path / "b.urdf").write_text(URDF.replace(TOE, TOE.partition("<mimic")[0]).replace(NAIL, NAIL.replace(
        'multiplier="2" offset="0.1"', 'multiplier="0" offset="0.7"')))  # fmt: skip
    without = robot_leg(tmp_path / "b.urdf", ["knee", "toe"], "xz", tip=0.2).leg
    np.testing.assert_allclose(numbers(picked.leg), numbers(without), rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('joint="knee"', 'joint="kne"', 'joint toe: mimics "kne", which is no joint of the file'),
        ('joint="knee"', 'joint="nail"', "joint nail: mimics itself, by way of other joints"),
        ('offset="0.3"', 'offset="x"', 'joint toe: offset="x" is not 1 finite numbers'),
    ],
)
def test_mistakes_of_a_mimic(old: str, new: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(UserError, match=words):
        of(tmp_path, URDF.replace(old, new))


MJCF = """<mujoco><compiler angle="radian"/><worldbody>
<body><inertial pos="0 0 -.1" mass=".5" diaginertia="1e-3 1e-3 2e-4"/><joint name="hip" axis="0 1 0"/>
<body pos="0 0 -.2"><inertial pos="0 0 -.08" mass=".2" diaginertia="1e-3 1e-3 2e-4"/><joint name="knee" axis="0 -1 0"/>
<body pos="0 0 -.2"{turn}><inertial pos=".05 0 0" mass=".1" diaginertia="1e-3 1e-3 2e-4"/>{toe}</body>
</body></body></worldbody>{tie}</mujoco>"""
TIES = ['joint2="knee" polycoef=".3 -1 0 0 0"', 'polycoef=".3"', 'joint2="knee" polycoef=".3 -1 .5 0 0"']


@pytest.mark.parametrize("tie", TIES)
def test_an_equality_constraint_on_joints_puts_the_locked_one_there(tie: str, tmp_path: Path) -> None:
    tied = MJCF.format(turn="", toe='<joint name="toe" axis="0 1 0" ref=".2"/>',
                       tie=f'<equality><joint joint1="toe" {tie}/></equality>')  # fmt: skip
    leg, said = of(tmp_path, tied, "a.xml")
    welded = MJCF.format(turn=' euler="0 .3 0"', toe="", tie="")  # from its reference pose
    np.testing.assert_allclose(numbers(leg), numbers(of(tmp_path, welded, "b.xml")[0]), rtol=1e-9, atol=1e-12)
    model = mujoco.MjModel.from_xml_string(tied)
    data = mujoco.MjData(model)
    data.joint("toe").qpos[0] = 0.5
    mujoco.mj_forward(model, data)
    assert data.efc_pos[0] == pytest.approx(0.0, abs=1e-12)  # the constraint holds there
    law = {0: "-1 times the reading of knee, plus 28.65 deg", 2: "by a curve"}.get(TIES.index(tie))
    end = SAID.format(f"knee ({law})") if law else ""
    assert f"toe is locked at 28.65 deg, and its bodies are lumped{end}" in said.split("\n")
