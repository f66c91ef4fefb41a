"""Gazebo's elements of a URDF: springs are read, what a leg lacks is named."""

from __future__ import annotations

from pathlib import Path

import pytest

from synth.errors import UserError
from synth.files.robots.planar_chain import PickedLeg
from synth.files.robots.robot_project import robot_leg
from synth.swing.leg_model import Spring

ROBOT = """<robot name="r"><link name="base"/><link name="shin"><inertial><origin xyz="0 0 -.1"/><mass value=".4"/>
    <inertia ixx="1e-3" ixy="0" ixz="0" iyy="1e-3" iyz="0" izz="1e-4"/></inertial></link>
    <joint name="knee" type="revolute"><parent link="base"/><child link="shin"/><axis xyz="0 -1 0"/>
    <limit lower="-1" upper="1"/>{dynamics}</joint>{gazebo}</robot>"""
BOTH = "<springStiffness>3.5</springStiffness><springReference> -0.4 </springReference>"
NONE = "URDF has no springs, and gravity is taken as 9.81 m/s^2 downward"


def picked(folder: Path, gazebo: str, dynamics: str = "") -> PickedLeg:
    """The leg of one joint."""
    (folder / "r.urdf").write_text(ROBOT.format(gazebo=gazebo, dynamics=dynamics))
    return robot_leg(folder / "r.urdf", ["knee"], tip=0.2)


@pytest.mark.parametrize(
    ("gazebo", "spring"),
    [
        (f'<gazebo reference="knee">{BOTH}</gazebo>', Spring(3.5, -0.4)),
        ('<gazebo reference="knee"><springStiffness>3.5</springStiffness></gazebo>', Spring(3.5, 0.0)),
        ('<gazebo reference="knee"><springStiffness value="2"/></gazebo>', Spring(2.0, 0.0)),
        (
            f'<gazebo reference="knee">{BOTH}</gazebo><gazebo reference="knee"><springStiffness>5</springStiffness>'
            "</gazebo>",
            Spring(5.0, -0.4),
        ),
        ('<gazebo reference="knee"><springReference>.3</springReference></gazebo>', None),
        (f'<gazebo reference="shin">{BOTH}</gazebo>', None),
        (f"<gazebo>{BOTH}</gazebo>", None),
    ],
)
def test_gazebo_s_springs_are_read(gazebo: str, spring: Spring | None, tmp_path: Path) -> None:
    """They were dropped, and a note denied that the file has any."""
    found = picked(tmp_path, gazebo)
    assert found.leg.joints[0].spring == spring
    (said,) = [text for text in found.messages if "gravity is taken" in text]
    named = "the springs are Gazebo's springStiffness and springReference of knee, and gravity"
    assert said == NONE if spring is None else said.startswith(named)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("<springStiffness>-3</springStiffness>", "joint knee: has the springStiffness -3; it may not be negative"),
        ("<springStiffness>soft</springStiffness>", 'joint knee: springStiffness="soft" is not 1 finite numbers'),
        (f"{BOTH}<springReference>nan</springReference>", 'joint knee: springReference="nan" is not 1 finite numbers'),
    ],
)
def test_mistakes_of_gazebo_s_springs(words: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(UserError, match=said):
        picked(tmp_path, f'<gazebo reference="knee">{words}</gazebo>')


def test_what_gazebo_adds_beside_springs_is_named(tmp_path: Path) -> None:
    joint = f'<gazebo reference="knee">{BOTH}<implicitSpringDamper>1</implicitSpringDamper><stopKd>1</stopKd></gazebo>'
    link = '<gazebo reference="shin"><kp>1e6</kp><material>Gazebo/Orange</material><turnGravityOff>1</turnGravityOff>'
    said = picked(tmp_path, f"{joint}{link}</gazebo>").messages
    assert "knee: Gazebo's implicitSpringDamper, stopKd left out" in said
    assert "Gazebo's turnGravityOff of shin, kp of shin left out" in said
    assert "knee: Gazebo's" not in " ".join(picked(tmp_path, f'<gazebo reference="knee">{BOTH}</gazebo>').messages)


def test_a_stiffness_of_the_dynamics_is_named(tmp_path: Path) -> None:
    """RaiSim's and Isaac's; URDF knows no such attribute."""
    said = picked(tmp_path, "", '<dynamics damping=".1" friction="0" stiffness="3"/>').messages
    assert "knee: stiffness of its dynamics left out: URDF has damping and friction alone" in said
    assert NONE in said
