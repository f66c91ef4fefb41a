"""Robots in: a planar chain out of MJCF and URDF moves as MuJoCo moves the whole robot with the rest locked."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from fit.simulated_legs import robot
from synth.cli import main
from synth.errors import UserError
from synth.files.gap_project import read_gap_project
from synth.files.joint_curves import damper_torque
from synth.files.leg_file import read_leg
from synth.files.mjcf import mjcf_text
from synth.files.robot_xml import urdf_file
from synth.files.robots.planar_chain import pick_leg
from synth.files.robots.robot_project import read_robot, robot_leg, write_robot_project
from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, DamperCurve, Joint, Leg

FASTEST = np.full(3, 10.0)
# A quadruped's leg: trunk, abduction, thigh with an off-plane motor and a wheel on a joint of its own, calf whose axis
# points the other way, foot. Centres of mass lie on the links' lines but off the plane.
ROBOT = """<mujoco model="quad"><compiler angle="radian" autolimits="true"/>
<option integrator="RK4" timestep="1e-4"><flag contact="disable"/></option>
<worldbody><body name="trunk" pos="0 0 1"><inertial pos="0 0 0" mass="5" diaginertia=".1 .1 .1"/>{free}
 <body name="hip" pos=".2 -.05 0"><inertial pos="0 0 0" mass=".7" diaginertia="1e-3 1e-3 1e-3"/>
  {abduction}
  <body name="thigh" pos="0 -.08 0">
   <inertial pos="0 .02 -.06" mass="1" fullinertia="5e-3 4.6e-3 7e-4 0 0 2e-4"/>
   <joint name="thigh" axis="0 1 0" damping=".05" armature=".01" stiffness="2" springref=".4" range="-.7 4.5"/>
   <geom type="capsule" fromto="0 0 0 0 0 -.2" size=".01" mass="0"/>
   <body name="wheel" pos="0 .03 -.1"><inertial pos="0 0 0" mass=".2" diaginertia="1e-4 1e-4 1e-4"/>{wheel}</body>
   <body name="calf" pos="0 0 -.213">
    <inertial pos="0 .001 -.12" mass=".25" diaginertia="1.5e-3 1.5e-3 4e-5"/>
    <joint name="calf" axis="0 -1 0" damping=".02" armature=".002" ref=".3"/>
    <body name="foot" pos="0 0 -.213"><inertial pos="0 0 0" mass=".06" diaginertia="1e-5 1e-5 1e-5"/>
     <geom type="sphere" size=".02" mass="0"/></body>
 </body></body></body></body></worldbody>{actuator}</mujoco>"""
FREE = {"free": "<freejoint/>", "abduction": '<joint name="abduction" axis="1 0 0"/>',
        "wheel": '<joint name="wheel" axis="0 1 0"/>',
        "actuator": '<actuator><position joint="thigh" kp="50"/></actuator>'}  # fmt: skip
LOCKED = dict.fromkeys(FREE, "")


def written(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


def sizes(joint: Joint) -> tuple[float, float, float, float]:
    """The link's numbers."""
    return joint.link.length, joint.link.mass, joint.link.com, joint.link.inertia


def moved_by_mujoco(text: str, start: dict[str, float], seconds: float) -> list[float]:
    """Readings of the joints after a time at rest from the start, the whole robot simulated."""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    for name, reading in start.items():
        data.joint(name).qpos[0] = reading
    mujoco.mj_step(model, data, nstep=round(seconds / model.opt.timestep))
    return [float(data.joint(name).qpos[0]) for name in start]


def moved_by_us(leg: Leg, start: dict[str, float], seconds: float) -> list[float]:
    first = leg.to_rotation(np.array(list(start.values())))
    ours = simulate(leg, first, [0.0] * len(first), np.array([0.0, seconds]), tolerance=1e-9)[-1]
    return [float(value) for value in leg.to_measured(ours)]


def test_the_picked_leg_moves_as_the_whole_robot_with_the_rest_locked(tmp_path: Path) -> None:
    picked = robot_leg(written(tmp_path / "quad.xml", ROBOT.format(**FREE)), ["thigh", "calf"], "xz")
    start = {"thigh": 0.9, "calf": -0.8}
    theirs = moved_by_mujoco(ROBOT.format(**LOCKED), start, 0.4)
    assert max(abs(a - b) for a, b in zip(theirs, start.values(), strict=True)) > 0.3  # it moves
    np.testing.assert_allclose(moved_by_us(picked.leg, start, 0.4), theirs, atol=2e-6)
    assert [joint.sign for joint in picked.leg.joints] == [-1, 1]  # seen with x to the right, +y turns clockwise
    assert picked.leg.joints[0].link.length == pytest.approx(0.213)
    assert picked.leg.joints[1].link.length == pytest.approx(0.233)  # to the end of the foot, a ball of 20 mm
    assert picked.leg.joints[0].range == (-0.7, 4.5)
    said = " ".join(picked.messages)
    for part in ("wheel is locked", "abduction", "the body is held", "1 actuator left out: "):
        assert part in said


def test_the_plane_may_be_seen_from_the_other_side(tmp_path: Path) -> None:
    """A robot turned by 90 degrees about the vertical is the same leg in the plane yz."""
    turned = ROBOT.format(**LOCKED).replace('pos="0 0 1">', 'pos="0 0 1" euler="0 0 1.5707963267948966">')
    here = robot_leg(written(tmp_path / "a.xml", ROBOT.format(**LOCKED)), ["thigh", "calf"]).leg
    there = robot_leg(written(tmp_path / "b.xml", turned), ["thigh", "calf"]).leg
    for a, b in zip(here.joints, there.joints, strict=True):
        assert (a.name, a.sign) == (b.name, b.sign)
        assert sizes(a) == pytest.approx(sizes(b), rel=1e-9)
    with pytest.raises(UserError, match=r"the axis of thigh is 90\.0 deg off the normal of the plane xz"):
        robot_leg(tmp_path / "b.xml", ["thigh", "calf"], "xz")


@pytest.mark.parametrize(
    ("yaw", "right"), [(45.0, "0.7071, 0.7071"), (-45.0, "0.7071, -0.7071"), (3.0, "0.9986, 0.05234"),
                       (120.0, "-0.5, 0.866"), (200.0, "0.9397, 0.342")]
)  # fmt: skip
def test_a_leg_yawed_about_the_vertical_is_seen_in_its_own_plane(yaw: float, right: str, tmp_path: Path) -> None:
    """It moves as MuJoCo moves the yawed robot, and is the leg that is not yawed, from one side or the other."""
    turned = ROBOT.format(**LOCKED).replace('pos="0 0 1">', f'pos="0 0 1" euler="0 0 {math.radians(yaw)!r}">')
    picked = robot_leg(written(tmp_path / "a.xml", turned), ["thigh", "calf"])
    assert f"seen in their own, to the right is ({right}, 0)" in " ".join(picked.messages)
    start = {"thigh": 0.9, "calf": -0.8}
    np.testing.assert_allclose(moved_by_us(picked.leg, start, 0.4), moved_by_mujoco(turned, start, 0.4), atol=2e-6)
    straight = robot_leg(written(tmp_path / "b.xml", ROBOT.format(**LOCKED)), ["thigh", "calf"]).leg
    for here, there in zip(straight.joints, picked.leg.joints, strict=True):
        assert there.sign * here.sign == (-1 if yaw == 200.0 else 1)
        assert sizes(there) == pytest.approx(sizes(here), rel=1e-9)
    with pytest.raises(UserError, match="at most 5 deg are allowed: choose other joints, or leave --plane out"):
        robot_leg(tmp_path / "a.xml", ["thigh", "calf"], "yz" if abs(yaw) < 45.0 else "xz")


def test_a_yawed_leg_whose_axes_are_not_quite_parallel(tmp_path: Path) -> None:
    """Its plane is that of their mean; of world axes that are near enough the plane stays as given by these."""
    bent = ROBOT.format(**LOCKED).replace('name="calf" axis="0 -1 0"', f'name="calf" axis="{math.sin(0.02)} -1 0"')
    turned = bent.replace('pos="0 0 1">', f'pos="0 0 1" euler="0 0 {math.radians(30.0)!r}">')
    said = " ".join(robot_leg(written(tmp_path / "a.xml", turned), ["thigh", "calf"]).messages)
    assert "the axis of thigh is 0.57 deg off" in said
    assert "the axis of calf is 0.57 deg off" in said
    said = " ".join(robot_leg(written(tmp_path / "b.xml", bent), ["thigh", "calf"]).messages)
    assert "the axis of calf is 1.1 deg off" in said
    assert "seen in their own" not in said


@pytest.mark.parametrize(("angle", "refused"), [(0.07, False), (0.1, True)])
def test_an_axis_more_than_five_degrees_off_the_plane_is_refused(angle: float, refused: bool, tmp_path: Path) -> None:
    axis = f'axis="{math.sin(angle)} {-math.cos(angle)} 0"'
    path = written(
        tmp_path / "a.xml", ROBOT.format(**LOCKED).replace('name="calf" axis="0 -1 0"', f'name="calf" {axis}')
    )
    if refused:
        with pytest.raises(UserError, match=r"the axis of calf is 5\.7 deg off .* at most 5 deg are"):
            robot_leg(path, ["thigh", "calf"], "xz")
    else:
        assert "the axis of calf is 4 deg off" in " ".join(robot_leg(path, ["thigh", "calf"], "xz").messages)


def test_a_centre_of_mass_beside_the_line_stays_there(tmp_path: Path) -> None:
    text = ROBOT.format(**LOCKED).replace('pos="0 .02 -.06" mass="1"', 'pos=".01 .02 -.06" mass="1"')
    picked = robot_leg(written(tmp_path / "a.xml", text), ["thigh", "calf"])
    thigh = picked.leg.joints[0].link
    assert abs(thigh.com_across) == pytest.approx(8.33e-3, abs=1e-5)  # 10 mm of 1 kg, the wheel's 0.2 kg on the line
    start = {"thigh": 0.9, "calf": -0.8}
    np.testing.assert_allclose(moved_by_us(picked.leg, start, 0.4), moved_by_mujoco(text, start, 0.4), atol=2e-6)
    about_joint = 4.6e-3 + 1.0 * (0.06**2 + 0.01**2) + 1e-4 + 0.2 * 0.1**2
    assert thigh.about_joint == pytest.approx(about_joint, rel=1e-9)
    # The last link's line goes through its centre of mass: of it nothing is lost.
    bent = ROBOT.format(**LOCKED).replace('pos="0 .001 -.12" mass=".25"', 'pos=".02 .001 -.12" mass=".25"')
    exact = robot_leg(written(tmp_path / "b.xml", bent), ["thigh", "calf"])
    np.testing.assert_allclose(moved_by_us(exact.leg, start, 0.4), moved_by_mujoco(bent, start, 0.4), atol=2e-6)


def same(a: Joint, b: Joint) -> None:
    """Joints of one physics within 1e-9; ``a`` has zero 0 and sign +1."""
    assert sizes(a) == pytest.approx(sizes(b), rel=1e-9, abs=1e-12)
    assert (b.spring is None) == (a.spring is None)
    if a.spring is not None and b.spring is not None:
        assert (a.spring.rate, a.rest) == pytest.approx((b.spring.rate, b.rest), rel=1e-9)
    assert (a.damper and a.damper.rate) == pytest.approx(b.damper and b.damper.rate, rel=1e-9)
    assert a.armature == pytest.approx(b.armature, rel=1e-9)
    assert (a.ends or ()) == pytest.approx(b.ends or (), rel=1e-9)
    for name, values in b.effects.items():
        assert a.effects[name] == pytest.approx(values, rel=1e-9)


def out_and_in() -> Leg:
    """A leg with everything that MJCF holds exactly."""
    leg = replace(robot(), tilt=0.2, gravity=9.7)
    joints = [replace(joint, armature=2e-5 * (k + 1)) for k, joint in enumerate(leg.joints)]
    joints[1] = replace(joints[1], effects={"coulomb_friction": {"torque": 0.05}}, range=(1.0, 3.0))
    return replace(leg, joints=tuple(joints))


def test_a_leg_written_as_mjcf_is_read_again(tmp_path: Path) -> None:
    leg = out_and_in()
    again = robot_leg(written(tmp_path / "a.mjcf.xml", mjcf_text(leg, FASTEST)), leg.joint_names).leg
    assert (again.name, again.gravity, again.tilt) == (leg.name, pytest.approx(9.7), pytest.approx(0.2, rel=1e-9))
    np.testing.assert_allclose(again.zero, 0.0, atol=1e-9)
    assert again.sign.tolist() == [1.0] * 3
    for a, b in zip(again.joints, leg.joints, strict=True):
        same(a, b)


def test_curves_drag_and_backlash_are_read_again(tmp_path: Path) -> None:
    curve = DamperCurve((0.5, 1.5, 4.0, 9.0), (0.03, 0.06, 0.09, 0.12))
    drag = {"quadratic_damping": {"coefficient": 2e-3}}  # of a joint with backlash on the link, not on the arm
    leg = out_and_in().with_joints(
        hip={"damper": Damper(curve=curve)},
        knee={"damper": Damper(curve=curve), "effects": {"backlash": {"gap": 0.03}, **drag}},
        ankle={"effects": drag},
    )
    picked = robot_leg(written(tmp_path / "a.mjcf.xml", mjcf_text(leg, FASTEST)), leg.joint_names)
    again = picked.leg
    assert picked.messages == ()
    for a, b in zip(again.joints, leg.joints, strict=True):
        assert sizes(a) == pytest.approx(sizes(b), rel=1e-9)
        assert (a.spring and a.spring.rate, a.rest) == pytest.approx((b.spring and b.spring.rate, b.rest), rel=1e-9)
        assert a.effects.keys() == b.effects.keys()
    assert again.joints[1].effects["backlash"]["gap"] == pytest.approx(0.03, rel=1e-9)
    speed = np.linspace(0.0, 20.0, 50)
    for a, b in zip(again.joints, leg.joints, strict=True):  # the arm of the backlash weighs 1 mg
        np.testing.assert_allclose(damper_torque(a, speed), damper_torque(b, speed), rtol=1e-5)
    alone = leg.with_joints(knee={"effects": {}})
    again = robot_leg(written(tmp_path / "b.mjcf.xml", mjcf_text(alone, FASTEST)), leg.joint_names).leg
    for a, b in zip(again.joints, alone.joints, strict=True):
        np.testing.assert_allclose(damper_torque(a, speed), damper_torque(b, speed), rtol=1e-9)


def test_tendons_that_are_no_dampers_are_said_to_be_left_out(tmp_path: Path) -> None:
    """A stiff friction, a coupling of two joints, and a leg's own damper with another moment arm."""
    leg = robot().with_joints(hip={"damper": Damper(curve=DamperCurve((1.0, 4.0), (0.03, 0.06)))})
    text = mjcf_text(leg, FASTEST)
    others = (
        '<fixed name="stiff" frictionloss=".1"><joint joint="hip" coef="1"/></fixed>'
        '<fixed name="coupling" range="-1 1"><joint joint="hip" coef="1"/><joint joint="knee" coef="-1"/></fixed>'
    )
    text = text.replace("</tendon>", others + "</tendon>").replace('joint="hip" coef="1" />', 'joint="hip" coef="2" />')
    picked = robot_leg(written(tmp_path / "a.mjcf.xml", text), leg.joint_names)
    (said,) = [item for item in picked.messages if "tendons" in item]
    assert "3 tendons left out: hip damper 1, stiff, coupling" in said


def test_a_leg_written_as_urdf_is_read_again(tmp_path: Path) -> None:
    leg = out_and_in()
    leg = replace(leg, joints=tuple(replace(joint, armature=0.0) for joint in leg.joints))
    picked = robot_leg(written(tmp_path / "a.urdf", urdf_file(leg, FASTEST).text), leg.joint_names)
    again = picked.leg
    for a, b in zip(again.joints, leg.joints, strict=True):
        same(replace(a, range=None, spring=None), replace(b, range=None, spring=None))
        assert a.spring is not None
        assert b.spring is not None
        assert (a.spring.rate, a.spring.free_angle) == pytest.approx((b.spring.rate, b.rest), rel=1e-9)
    # A URDF turns its base in the first joint's origin: the absolute rotation at a reading is the same.
    turned = again.tilt + again.to_rotation(np.zeros(3))
    np.testing.assert_allclose(turned[0], leg.tilt, atol=1e-9)
    without = replace(leg, joints=tuple(replace(joint, spring=None) for joint in leg.joints))
    bare = robot_leg(written(tmp_path / "b.urdf", urdf_file(without, FASTEST).text), leg.joint_names)
    assert "URDF has no springs" in " ".join(bare.messages)
    assert "URDF has no springs" not in " ".join(picked.messages)


def test_urdf_frames_are_mujoco_s(tmp_path: Path) -> None:
    """A branched URDF with turned frames: bodies and inertia lie where MuJoCo's own reader puts them."""
    text = """<robot name="r"><link name="base"/>
    <link name="a"><inertial><origin xyz=".01 .02 -.1" rpy=".3 -.2 .5"/><mass value=".5"/>
     <inertia ixx="1e-3" iyy="2e-3" izz="1.5e-3" ixy="1e-4" ixz="2e-4" iyz="-1e-4"/></inertial></link>
    <link name="b"><inertial><origin xyz="0 0 -.1"/><mass value=".2"/>
     <inertia ixx="1e-3" iyy="1e-3" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="one" type="revolute"><parent link="base"/><child link="a"/><origin xyz=".1 .2 .3" rpy=".1 .2 .3"/>
     <axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
    <joint name="two" type="continuous"><parent link="a"/><child link="b"/><origin xyz="0 0 -.2" rpy="0 .4 0"/>
     <axis xyz="0 2 0"/></joint></robot>"""
    ours = read_robot(written(tmp_path / "a.urdf", text))
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "a.urdf"))
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    for k, name in enumerate(("one", "two")):
        joint = ours.joint(name)
        np.testing.assert_allclose(joint.axis, data.xaxis[k], atol=1e-12)
        np.testing.assert_allclose(joint.anchor, data.xanchor[k], atol=1e-12)
        body, theirs = ours.bodies[joint.body], model.jnt_bodyid[k]
        np.testing.assert_allclose(body.com, data.xipos[theirs], atol=1e-12)
        turn = data.ximat[theirs].reshape(3, 3)
        np.testing.assert_allclose(body.inertia, turn @ np.diag(model.body_inertia[theirs]) @ turn.T, atol=1e-9)


@pytest.mark.parametrize(
    ("chain", "plane", "words"),
    [
        (["thigh", "cafl"], None, ['"cafl" is no joint of quad', "did you mean calf"]),
        (["calf", "thigh"], None, ["thigh does not hang below calf"]),
        (["abduction", "thigh"], None, ["90.0 deg off"]),
        (["thigh"], "xw", ['"xw" is no plane']),
        (["thigh"], "zx", ["90 deg from up"]),
        ([], None, ["0 joints; a leg has 1 to 6"]),
    ],
)
def test_joints_that_are_not_a_chain_are_refused(
    chain: list[str], plane: str | None, words: list[str], tmp_path: Path
) -> None:
    path = written(tmp_path / "quad.xml", ROBOT.format(**FREE))
    with pytest.raises(UserError) as caught:
        robot_leg(path, chain, plane)
    assert all(word in str(caught.value) for word in words)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<mujoco><worldbody><bdy/></worldbody></mujoco>", "cannot be compiled by MuJoCo"),
        ("<robot name='a'><link name='b'></robot>", "is not XML"),
        ("<!DOCTYPE r [<!ENTITY a 'b'>]><robot name='a'/>", "declares entities"),
        ("<robot name='${x}'><link name='b'/></robot>", "xacro"),
        ("<sdf version='1.9'/>", "convert it to URDF"),
        ("leg: robot", "is neither MJCF"),
        (
            "<robot><link name='a'/><joint name='j' type='hinge'><parent link='a'/><child link='z'/></joint></robot>",
            "no link",
        ),
    ],
)
def test_a_file_that_is_not_a_robot_gives_one_message(text: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(UserError, match=words):
        read_robot(written(tmp_path / "a.xml", text))


SMALL_URDF = """<robot name="r"><link name="a"/><link name="b"><inertial><origin xyz="0 0 -.1"/><mass value=".2"/>
<inertia ixx="1e-3" iyy="1e-3" izz="1e-4"/></inertial></link>
<joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1"/><dynamics damping=".1" friction=".2"/></joint></robot>"""


def test_links_of_a_simulators_extension_are_not_the_robot_s(tmp_path: Path) -> None:
    text = SMALL_URDF.replace("</robot>", '<gazebo><plugin><link name="b"/></plugin></gazebo></robot>')
    robot = read_robot(written(tmp_path / "a.urdf", text))
    assert [body.mass for body in robot.bodies] == [0.0, 0.2]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("</robot>", '<link name="b"/></robot>', "link b: stands twice"),
        (
            "</robot>",
            '<link name="c"/><joint name="j" type="fixed"><parent link="b"/><child link="c"/></joint></robot>',
            "joint j: stands twice",
        ),
        ('ixx="1e-3" iyy="1e-3"', 'ixx="-1e-3" iyy="-1e-3"', "link b: has the principal moments of inertia -0.001, -0"),
        ('damping=".1"', 'damping="-.1"', "joint j: has the damping -0.1 and the friction 0.2; neither"),
        ('friction=".2"', 'friction="-.2"', "joint j: has the damping 0.1 and the friction -0.2; neither"),
        ('lower="-1"', 'lower="2"', "joint j: has the limits 2 and 1; the lower one comes first"),
    ],
)
def test_mistakes_of_a_urdf(old: str, new: str, words: str, tmp_path: Path) -> None:
    assert old in SMALL_URDF
    with pytest.raises(UserError, match=words):
        robot_leg(written(tmp_path / "a.urdf", SMALL_URDF.replace(old, new)), ["j"], tip=0.2)


@pytest.mark.parametrize(
    ("limits", "told"),
    [((0.0, 150.0), "write 0 and 2.618 there"), ((-90.0, 10.0), "write -1.571 and 0.1745"), ((-12.5, 12.5), "")],
)
def test_limits_that_look_like_degrees_are_doubted(limits: tuple[float, float], told: str, tmp_path: Path) -> None:
    """Beyond two turns, in a format of radians; a note, for a joint may turn many times."""
    urdf = SMALL_URDF.replace('lower="-1" upper="1"', f'lower="{limits[0]}" upper="{limits[1]}"')
    text = ROBOT.format(**LOCKED).replace('range="-.7 4.5"', f'range="{limits[0]} {limits[1]}"')
    for name, content, chain in (("a.urdf", urdf, "j"), ("a.xml", text, "thigh")):
        picked = robot_leg(written(tmp_path / name, content), [chain], tip=0.2)
        said = [item for item in picked.messages if item.startswith(f"{chain}: {name} has its limits in rad")]
        assert len(said) == bool(told)
        assert told in "".join(said)
        assert picked.leg.joints[0].range == limits


def test_limits_in_degrees_and_of_a_continuous_joint_are_not_doubted(tmp_path: Path) -> None:
    text = ROBOT.format(**LOCKED).replace('range="-.7 4.5"', 'range="0 1500"').replace('angle="radian" ', "")
    urdf = SMALL_URDF.replace('lower="-1" upper="1"', 'lower="0" upper="150"').replace("revolute", "continuous")
    for name, content, chain in (("a.urdf", urdf, "j"), ("a.xml", text, "thigh")):
        picked = robot_leg(written(tmp_path / name, content), [chain], tip=0.2)
        assert not any("in rad" in item for item in picked.messages)


def test_a_leg_that_no_project_reads_is_refused(tmp_path: Path) -> None:
    picked = pick_leg(read_robot(written(tmp_path / "a.urdf", SMALL_URDF)), ["j"])
    bad = picked.leg.with_joints(j={"link": replace(picked.leg.joints[0].link, inertia=-1.0)})
    with pytest.raises(UserError, match=r"a.urdf: joints.j.link.inertia: gives a leg that no project can use"):
        write_robot_project("fit", replace(picked, leg=bad), "a.urdf", tmp_path / "p")


@pytest.mark.parametrize("kind", ["fit", "gap", "leg"])
def test_init_writes_a_project_with_the_robot_s_leg(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(tmp_path / "quad.xml", ROBOT.format(**FREE))
    out = tmp_path / "p"
    words = ["init", kind, str(out), "--from", str(path), "--chain", "thigh,calf", "--plane", "xz", "--tip", "8.5 in"]
    assert main(words) == 0
    said = capsys.readouterr().out
    assert "note: wheel is locked" in said
    leg = read_leg(out / "robot.leg.yaml")
    assert leg.joint_names == ("thigh", "calf")
    assert leg.joints[1].link.length == pytest.approx(0.2159)
    assert "wheel is locked" in (out / "README.md").read_text()
    assert (out / ("animal" if kind == "leg" else "trials")).is_dir()
    if kind == "gap":
        rows = "".join(f"{0.01 * k},{0.5 + 0.1 * math.sin(k)},{0.2 + 0.1 * math.cos(k)}\n" for k in range(30))
        written(out / "trials" / "a.csv", "time [s],thigh [rad],calf [rad]\n" + rows)
        assert read_gap_project(out / "gap.yaml").leg.joint_names == ("thigh", "calf")


def test_init_refuses_contradictory_options(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["init", "leg", str(tmp_path / "p"), "--chain", "a"]) == 2
    assert "--from" in capsys.readouterr().err
    assert main(["init", "hopper", str(tmp_path / "p"), "--from", "x.xml"]) == 2
    said = capsys.readouterr().err
    assert "not with hopper" in said
    assert "--chain" in said
    assert not (tmp_path / "p").exists()


def test_a_guessed_length_of_the_last_link_is_reported(tmp_path: Path) -> None:
    path = written(
        tmp_path / "a.urdf",
        """<robot name="r"><link name="a"/><link name="b"><inertial><origin xyz="0 0 -.1"/><mass value=".2"/>
    <inertia ixx="1e-3" iyy="1e-3" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="j" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/></joint></robot>""",
    )
    guessed, given = pick_leg(read_robot(path), ["j"]), pick_leg(read_robot(path), ["j"], tip=0.3)
    assert guessed.leg.joints[0].link.length == pytest.approx(0.2)
    assert any("no end of the last link: 200 mm" in text for text in guessed.messages)
    assert not any("no end" in text for text in given.messages)


def test_pick_leg_needs_a_mass_below_each_joint(tmp_path: Path) -> None:
    path = written(
        tmp_path / "a.urdf",
        """<robot name="r"><link name="a"/><link name="b"/>
    <joint name="j" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/></joint></robot>""",
    )
    with pytest.raises(UserError, match="has a mass"):
        pick_leg(read_robot(path), ["j"])
