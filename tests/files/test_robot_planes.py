"""The plane of a robot's leg, and gravity in it: torques are MuJoCo's, and what differs from the words is said."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from robot_forces import farthest_from_mujoco
from synth.errors import UserError
from synth.files.robots.planar_chain import PickedLeg
from synth.files.robots.robot_project import robot_leg

ROBOT = """<mujoco><option gravity="{gravity}"/><worldbody><body name="b" pos="0 0 1"><joint name="h" axis="{axis}"/>
<geom type="capsule" fromto="0 0 0 {down}" size=".02"/><body name="c" pos="{down}"><joint name="k" axis="{other}"
ref="30"/><geom type="capsule" fromto="0 0 0 {end}" size=".02"/></body></body></worldbody></mujoco>"""
Z_UP = {"axis": "0 1 0", "other": "0 -1 0", "down": "0 0 -.3", "end": ".05 0 -.25"}
Y_UP = {"axis": "1 0 0", "other": "1 0 0", "down": "0 -.3 0", "end": "0 -.25 .05"}
FLAT = {"axis": "0 0 1", "other": "0 0 1", "down": ".3 0 0", "end": ".25 .05 0"}


def picked(folder: Path, gravity: str, plane: str | None, words: dict[str, str] = Z_UP) -> PickedLeg:
    """The leg, whose inertias and gravity torques are compared with MuJoCo's."""
    (folder / "a.xml").write_text(ROBOT.format(gravity=gravity, **words))
    found = robot_leg(folder / "a.xml", ["h", "k"], plane)
    model = mujoco.MjModel.from_xml_path(str(folder / "a.xml"))
    assert farthest_from_mujoco(found.leg, model) < 1e-9
    return found


@pytest.mark.parametrize(("gravity", "off"), [("0.6 0 -9.79", "3.51"), ("3 0 -9", "18.4"), ("-.02 0 -9.8", "0.117")])
def test_a_gravity_that_leans_in_the_given_plane_stays_and_is_told(gravity: str, off: str, tmp_path: Path) -> None:
    """Up was the named axis: the torques were off by up to 24 % of the largest, the rest pose by the lean."""
    found = picked(tmp_path, gravity, "xz")
    (said,) = found.messages
    assert said.startswith(f"gravity is {off} deg off -z in the plane xz")
    assert found.leg.gravity == pytest.approx(float(np.linalg.norm(np.array(gravity.split(), float))))
    without = picked(tmp_path, gravity, None)
    assert without.messages == ()
    np.testing.assert_allclose(without.leg.zero, found.leg.zero, atol=1e-9)


def test_a_gravity_out_of_the_given_plane_acts_by_its_part_in_it(tmp_path: Path) -> None:
    found = picked(tmp_path, "0 .6 -9.79", "xz")
    assert found.messages == ("gravity is 3.5 deg out of the plane xz; the leg has its part in the plane",)
    assert found.leg.gravity == pytest.approx(9.79)
    with pytest.raises(UserError, match=r"--plane: gravity is 18\.4 deg out of the plane; at most 5 deg are"):
        picked(tmp_path, "0 3 -9", "xz")
    with pytest.raises(UserError, match=r"x is 90 deg from up.*the second axis is up"):
        picked(tmp_path, "0 0 -9.81", "zx")


def test_a_leaning_gravity_keeps_a_plane_of_the_world_at_right_angles(tmp_path: Path) -> None:
    """To the right was the world's axis, oblique to up, of a leg whose axes are a little off the plane."""
    (tmp_path / "a.xml").write_text(ROBOT.format(gravity="0.6 0 -9.79", **Z_UP | {"other": ".02 -1 0"}))
    found = robot_leg(tmp_path / "a.xml", ["h", "k"])
    assert found.messages == ("the axis of k is 1.1 deg off the plane's normal; taken as normal",)
    # The axis' own deviation moves the torques by its cosine and its sine squared.
    assert farthest_from_mujoco(found.leg, mujoco.MjModel.from_xml_path(str(tmp_path / "a.xml"))) < 1e-3


def test_a_robot_with_y_up_is_seen_in_the_world_s_plane(tmp_path: Path) -> None:
    """No world plane was said to be normal to its axes: to the right could be x or y only."""
    assert picked(tmp_path, "0 -9.81 0", None, Y_UP).messages == ()


@pytest.mark.parametrize("plane", [None, "xy", "yx"])
def test_a_level_robot_without_gravity_is_a_leg(plane: str | None, tmp_path: Path) -> None:
    """Up was z: its vertical axes were 90 deg off, and no --plane was allowed."""
    assert picked(tmp_path, "0 0 0", plane, FLAT).leg.gravity == 0.0


@pytest.mark.parametrize(("roll", "told"), [(2.0, "2"), (17.0, "17"), (-60.0, "60")])
def test_a_leg_rolled_about_the_way_to_the_right_feels_a_part_of_gravity(
    roll: float, told: str, tmp_path: Path
) -> None:
    """Within 5 deg it was projected onto the vertical plane, 0.4 % off; beyond it was refused."""
    rolled = ROBOT.replace('pos="0 0 1">', f'pos="0 0 1" euler="{roll} 0 0">', 1)
    (tmp_path / "a.xml").write_text(rolled.format(gravity="0 0 -9.81", **Z_UP))
    found = robot_leg(tmp_path / "a.xml", ["h", "k"])
    assert farthest_from_mujoco(found.leg, mujoco.MjModel.from_xml_path(str(tmp_path / "a.xml"))) < 1e-9
    felt = f"{9.81 * np.cos(np.radians(roll)):.4g} m/s^2"
    assert found.messages == (f"the joints' plane leans {told} deg; the leg has gravity's part in it, {felt}",)
    assert found.leg.gravity == pytest.approx(9.81 * np.cos(np.radians(roll)))


@pytest.mark.parametrize("gravity", ["0 0 -9.81", "0 0 -1.62", "0 0 0"])
def test_a_mass_beside_the_line_weighs_by_the_file_s_gravity(gravity: str, tmp_path: Path) -> None:
    """It was put on the line: a torque of up to 0.039 N*m was missing on Earth, and told."""
    drawn = '<geom type="capsule" fromto="0 0 0 {down}" size=".02"/>'
    beside = ROBOT.replace(drawn, '<inertial pos=".01 0 -.15" mass=".4" diaginertia="1e-3 1e-3 1e-3"/>')
    (tmp_path / "a.xml").write_text(beside.format(gravity=gravity, **Z_UP))
    found = robot_leg(tmp_path / "a.xml", ["h", "k"])
    assert not [item for item in found.messages if "beside" in item]
    assert abs(found.leg.joints[0].link.com_across) == pytest.approx(0.01)
    assert farthest_from_mujoco(found.leg, mujoco.MjModel.from_xml_path(str(tmp_path / "a.xml"))) < 1e-9
