"""How long the last link of a robot's file is: up to the farthest point of its shapes."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import trimesh

from synth.errors import UserError
from synth.files.robots.planar_chain import PickedLeg
from synth.files.robots.robot_project import robot_leg, write_robot_project

TURN = 0.4  # rad, of a shape about the hinge
SINE, COSINE = np.sin(TURN), np.cos(TURN)
# Half sizes 10, 15, 100 mm about a centre 100 mm below the joint: MJCF, URDF, reach below the centre when turned, mm.
SHAPES = {
    "capsule": ('type="capsule" size=".01 .1"', '<capsule radius=".01" length=".2"/>', 100.0 * COSINE),
    "cylinder": ('type="cylinder" size=".01 .1"', '<cylinder radius=".01" length=".2"/>', 10 * SINE + 100 * COSINE),
    "box": ('type="box" size=".01 .015 .1"', '<box size=".02 .03 .2"/>', 10 * SINE + 100 * COSINE),
    "sphere": ('type="sphere" size=".1"', '<sphere radius=".1"/>', 100.0),
    "ellipsoid": ('type="ellipsoid" size=".01 .015 .1"', "", np.hypot(10 * SINE, 100 * COSINE)),
    "mesh": ('type="mesh" mesh="m"', '<mesh filename="m.stl" scale=".001 .001 .001"/>', 10 * SINE + 100 * COSINE),
}
ASSET = '<asset><mesh name="m" file="m.stl" scale=".001 .001 .001"/></asset>'


def mjcf(folder: Path, geom: str) -> PickedLeg:
    """The leg of one link of 200 g, its centre of mass 100 mm below the joint."""
    asset = ASSET if "mesh" in geom else ""
    text = f"""<mujoco><compiler angle="radian"/>{asset}<worldbody>
        <body name="b" pos="0 0 1"><geom type="box" size=".1 .1 .1" mass="1"/><body name="t">
        <inertial pos="0 0 -.1" mass=".2" diaginertia="1e-3 1e-3 1e-3"/><joint name="hip" axis="0 1 0"/>
        <geom pos="0 0 -.1" {geom}/></body></body></worldbody></mujoco>"""
    (folder / "r.xml").write_text(text)
    return robot_leg(folder / "r.xml", ["hip"])


def urdf(folder: Path, geometry: str, turn: float = 0.0) -> PickedLeg:
    """The same leg."""
    text = f"""<robot name="r"><link name="b"/><link name="t"><inertial><origin xyz="0 0 -.1"/><mass value=".2"/>
        <inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial>
        <visual><origin xyz="0 0 -.1" rpy="0 {turn} 0"/><geometry>{geometry}</geometry></visual></link>
        <joint name="hip" type="continuous"><parent link="b"/><child link="t"/><axis xyz="0 1 0"/></joint></robot>"""
    (folder / "r.urdf").write_text(text)
    return robot_leg(folder / "r.urdf", ["hip"])


def length(picked: PickedLeg) -> float:
    """Of the last link, mm."""
    return 1e3 * picked.leg.joints[-1].link.length


def mesh(folder: Path, name: str = "m.stl") -> Path:
    """A box of 20 x 30 x 200 in mm."""
    trimesh.creation.box((20.0, 30.0, 200.0)).export(folder / name)
    return folder / name


@pytest.mark.parametrize("name", SHAPES)
def test_the_last_link_ends_with_its_shape(name: str, tmp_path: Path) -> None:
    mesh(tmp_path)
    geom, geometry, turned = SHAPES[name]
    for picked, wanted in (
        (mjcf(tmp_path, geom), 200.0),
        (mjcf(tmp_path, f'{geom} euler="0 {TURN} 0"'), 100.0 + turned),
        *([(urdf(tmp_path, geometry), 200.0), (urdf(tmp_path, geometry, TURN), 100.0 + turned)] if geometry else []),
    ):
        assert length(picked) == pytest.approx(wanted, rel=1e-6)  # STL has single precision
        assert not any("farther out" in text for text in picked.messages)


@pytest.mark.parametrize("name", ["m.obj", "m.ply", "meshes/m.STL", "package://robot/meshes/m.stl"])
def test_meshes_of_the_folder_are_read(name: str, tmp_path: Path) -> None:
    (tmp_path / "meshes").mkdir()
    for each in ("m.obj", "m.ply", "meshes/m.stl"):
        mesh(tmp_path, each)
    (tmp_path / "meshes" / "m.stl").rename(
        tmp_path / "meshes" / "m.STL" if "STL" in name else tmp_path / "meshes/m.stl"
    )
    assert length(urdf(tmp_path, f'<mesh filename="{name}" scale="1e-3 1e-3 1e-3"/>')) == pytest.approx(200.0)


def test_a_mesh_beside_the_folder_of_a_package_s_robot_is_read(tmp_path: Path) -> None:
    """As ROS lays a robot out: description/urdf/a.urdf and description/meshes; it was not found."""
    package, name = tmp_path / "source" / "description", '<mesh filename="package://{}_description/meshes/m.stl"/>'
    (package / "urdf").mkdir(parents=True)
    (package / "meshes").mkdir()
    mesh(package, "meshes/m.stl")
    (package / "package.xml").write_text("<package><name> a1_description </name></package>")
    scaled = name.replace("/>", ' scale="1e-3 1e-3 1e-3"/>')
    assert length(urdf(package / "urdf", scaled.format("a1"))) == pytest.approx(200.0)
    other = urdf(package / "urdf", scaled.format("b2"))  # another package's is not sought outside the folder
    assert "does not exist" in " ".join(other.messages)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("../out.stl", "leads out of"),
        ("link.stl", "leads out of .* by a link"),
        ("package://robot/../../out.stl", "leads out of"),
        ("file:///etc/passwd.stl", "is no file in the folder"),
        ("/etc/passwd.stl", "is an absolute path"),
        ("m.dae", r"is none of \.stl, \.obj, \.ply"),
        ("none.stl", "does not exist"),
        ("broken.stl", "cannot be read as a mesh"),
        ("broken.obj", "cannot be read as a mesh"),
        ("nan.obj", "cannot be read as a mesh: it has no points, or some are not finite"),
        ("", "no file is named"),
    ],
)
def test_a_mesh_that_is_not_read_is_said_to_be_known_by_its_centre(name: str, said: str, tmp_path: Path) -> None:
    folder = tmp_path / "robot"
    folder.mkdir()
    (folder / "link.stl").symlink_to(mesh(tmp_path, "out.stl"))
    (folder / "broken.stl").write_bytes(b"\0" * 80 + b"\xff" * 20)
    (folder / "broken.obj").write_text("v 1 2\nf 1 2 9\n")
    (folder / "nan.obj").write_text("mtllib ../../secret.mtl\nv 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n")
    picked = urdf(folder, f'<mesh filename="{name}"/>')
    assert length(picked) == pytest.approx(100.0)  # the shape's centre
    (text,) = [item for item in picked.messages if "farther out, --tip gives its length" in item]
    assert re.search(f"only the centre is known of the mesh {re.escape(name)}: .*{said}", text)


def test_a_given_tip_needs_no_shape(tmp_path: Path) -> None:
    urdf(tmp_path, '<mesh filename="m.dae"/>')
    picked = robot_leg(tmp_path / "r.urdf", ["hip"], tip=0.3)
    assert length(picked) == pytest.approx(300.0)
    assert not any("farther out" in text for text in picked.messages)


def test_a_shape_across_the_limb_keeps_the_limb_s_direction(tmp_path: Path) -> None:
    """The centre of mass on the joint, a counterweight above: the direction is that of the shapes' axes."""
    box, weight = '<geom pos="0 0 -.1" type="box" size=".04 .01 .1"/>', '<geom type="sphere" size=".02" pos="0 0 .05"/>'
    text = f"""<mujoco><worldbody><body name="b" pos="0 0 1"><geom type="box" size=".1 .1 .1" mass="1"/><body name="t">
        <inertial pos="0 0 0" mass=".2" diaginertia="1e-3 1e-3 1e-3"/><joint name="hip" axis="0 1 0"/>{box}{weight}
        </body></body></worldbody></mujoco>"""
    (tmp_path / "r.xml").write_text(text)
    picked = robot_leg(tmp_path / "r.xml", ["hip"])
    assert length(picked) == pytest.approx(200.0)
    assert picked.leg.joints[0].zero == pytest.approx(0.0, abs=1e-9)


FRAMED = """<robot name="r"><link name="base"/><link name="shin"><inertial><origin xyz="0 0 -{com}"/><mass value="0.4"/>
    <inertia ixx="1e-3" ixy="0" ixz="0" iyy="1e-3" iyz="0" izz="1e-4"/></inertial>{shape}</link><link name="imu"/>
    <joint name="knee" type="revolute"><parent link="base"/><child link="shin"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1"/></joint><joint name="i" type="fixed"><parent link="shin"/><child link="imu"/>
    <origin xyz="0 0 {at}"/></joint></robot>"""
ROD = "the file shows no end of the last link{}: 180 mm is that of a rod with this centre of mass; --tip gives another"
SHELL = '<visual><origin xyz="0 0 -{}"/><geometry><box size=".02 .02 .02"/></geometry></visual>'


@pytest.mark.parametrize(
    ("at", "shape", "wanted", "said"),
    [
        (-0.03, "", 180.0, ROD.format(" (the frame imu: 30 mm, its centre of mass: 90 mm)")),
        (-0.012, "", 180.0, ROD.format(" (the frame imu: 12 mm, its centre of mass: 90 mm)")),
        (0.06, "", 180.0, ROD.format("")),  # above the joint: no counterweight
        (-0.01, SHELL.format(0.03), 180.0, ROD.format(" (its shapes: 40 mm, its centre of mass: 90 mm)")),
        (-0.2, "", 200.0, "the last link has no shape and ends at the frame imu, 200 mm from its joint; --tip gives"),
        (-0.2, SHELL.format(0.1), 200.0, "the last link has no shape beyond 110 mm and ends at the frame imu, 200 mm"),
        (-0.11, SHELL.format(0.1), 110.0, ""),
    ],
)
def test_a_frame_short_of_the_centre_of_mass_is_no_end(
    at: float, shape: str, wanted: float, said: str, tmp_path: Path
) -> None:
    """It was the link's end without a word, where a tip mass acts, or its centre of mass was refused for its unit."""
    (tmp_path / "r.urdf").write_text(FRAMED.format(com=0.09, at=at, shape=shape))
    picked = robot_leg(tmp_path / "r.urdf", ["knee"])
    assert length(picked) == pytest.approx(wanted)
    assert picked.leg.joints[0].link.com == pytest.approx(0.09)
    found = [text for text in picked.messages if "last link" in text]
    assert len(found) == bool(said)
    assert "".join(found).startswith(said)
    assert length(robot_leg(tmp_path / "r.urdf", ["knee"], tip=0.03)) == pytest.approx(30.0)


def test_a_frame_far_beyond_a_counterweight_is_the_limb_s_end(tmp_path: Path) -> None:
    (tmp_path / "r.urdf").write_text(FRAMED.format(com=0.09, at=0.3, shape=""))
    link = robot_leg(tmp_path / "r.urdf", ["knee"]).leg.joints[0].link
    assert (link.length, link.com) == pytest.approx((0.3, -0.09))


def test_a_last_link_that_is_too_short_for_its_inertia_names_the_tip(tmp_path: Path) -> None:
    """Balanced on its joint, without a shape: the units of its inertia were asked for alone."""
    (tmp_path / "r.urdf").write_text(FRAMED.format(com=0.001, at=0.0, shape=""))
    picked = robot_leg(tmp_path / "r.urdf", ["knee"])
    with pytest.raises(UserError, match=r"check the units of .*; --tip gives the last link another length than 2 mm"):
        write_robot_project("gap", picked, "r.urdf", tmp_path / "p")


BODY = """<worldbody><body name="t"><inertial pos="0 0 -.1" mass=".2" diaginertia="1e-3 1e-3 1e-3"/>
    <joint name="hip" axis="0 1 0"/><geom type="mesh" mesh="m" pos="0 0 -.1"/></body></worldbody>"""
SCALED = 'name="m" scale=".001 .001 .001"'


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (f'<asset><mesh {SCALED} file="../out.stl"/></asset>{BODY}', r"mesh.file: .* leads out of"),
        (f'<compiler meshdir=".."/><asset><mesh {SCALED} file="out.stl"/></asset>{BODY}', "leads out of"),
        (f'<compiler assetdir="a/../.."/><asset><mesh {SCALED} file="out.stl"/></asset>{BODY}', "leads out of"),
        (f'<asset><mesh {SCALED} file="{{outside}}/out.stl"/></asset>{BODY}', "is an absolute path"),
        (f'<compiler meshdir="{{outside}}"/><asset><mesh {SCALED} file="out.stl"/></asset>{BODY}', "absolute path"),
        (f'<asset><mesh {SCALED} file="link.stl"/></asset>{BODY}', "leads out of .* by a link"),
        (f'<include file="part.xml"/>{BODY}', r"part.xml: mesh.file: .* leads out of"),
        (f'<include file="../part.xml"/>{BODY}', r"include.file: .* leads out of"),
        (f'<asset><texture type="skybox" fileup="../out.png"/></asset>{BODY}', r"texture.fileup: .* leads out of"),
    ],
)
def test_an_mjcf_opens_no_file_outside_its_folder(text: str, said: str, tmp_path: Path) -> None:
    """MuJoCo opened them: a file from anyone could read meshes and XML anywhere on the machine."""
    folder = tmp_path / "robot"
    folder.mkdir()
    (folder / "link.stl").symlink_to(mesh(tmp_path, "out.stl"))
    part = f'<mujoco><asset><mesh {SCALED} file="../out.stl"/></asset></mujoco>'
    for place in (folder, tmp_path):
        (place / "part.xml").write_text(part)
    (folder / "r.xml").write_text(f"<mujoco>{text.format(outside=tmp_path)}</mujoco>")
    with pytest.raises(UserError, match=said):
        robot_leg(folder / "r.xml", ["hip"])


@pytest.mark.parametrize(
    "text",
    [
        f'<compiler meshdir="meshes"/><asset><mesh {SCALED} file="m.stl"/></asset>{BODY}',
        f'<compiler meshdir="meshes" strippath="true"/><asset><mesh {SCALED} file="../../far/m.stl"/></asset>{BODY}',
        f'<include file="parts/part.xml"/>{BODY}',
    ],
)
def test_an_mjcf_s_own_files_are_read(text: str, tmp_path: Path) -> None:
    (tmp_path / "meshes").mkdir()
    (tmp_path / "parts").mkdir()
    mesh(tmp_path / "meshes")
    part = f'<mujoco><asset><mesh {SCALED} file="meshes/m.stl"/></asset></mujoco>'
    (tmp_path / "parts" / "part.xml").write_text(part)
    (tmp_path / "r.xml").write_text(f"<mujoco>{text}</mujoco>")
    assert length(robot_leg(tmp_path / "r.xml", ["hip"])) == pytest.approx(200.0)
