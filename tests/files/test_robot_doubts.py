"""What of a robot's file cannot be: a shape in another unit, an inertia that no body has. Notes name it."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
import trimesh

from synth.cli import main
from synth.errors import UserError
from synth.files.robots.planar_chain import PickedLeg
from synth.files.robots.robot_project import robot_leg

ROBOT = """<robot name="r"><link name="base"/>
    <link name="thigh"><inertial><origin xyz="0 0 -.1"/><mass value="1"/><inertia {thigh}/></inertial></link>
    <link name="shank"><inertial><origin xyz="0 0 -{com}"/><mass value=".2"/><inertia {shank}/></inertial>
     <collision><geometry>{shape}</geometry></collision></link>{foot}
    <joint name="hip" type="continuous"><parent link="base"/><child link="thigh"/><axis xyz="0 1 0"/></joint>
    <joint name="knee" type="continuous"><parent link="thigh"/><child link="shank"/><origin xyz="0 0 -.2"/>
     <axis xyz="0 1 0"/></joint></robot>"""
INERTIA = 'ixx="{:g}" iyy="{:g}" izz="{:g}" ixy="0" ixz="0" iyz="0"'
ROD = INERTIA.format(1e-3, 1e-3, 5e-5)
FOOT = """<link name="foot"/><joint name="f" type="fixed"><parent link="shank"/><child link="foot"/>
    <origin xyz="0 0 -.19"/></joint>"""
MESH = '<mesh filename="m.stl"{}/>'


def urdf(folder: Path, shape: str = "", foot: str = "", **more: str) -> Path:
    """A leg of two links; the mesh is a box from the knee 210 down, in its own unit."""
    box = trimesh.creation.box((20.0, 30.0, 210.0))
    box.apply_translation((0.0, 0.0, -105.0))
    box.export(folder / "m.stl")
    text = ROBOT.format(shape=shape, foot=foot, **({"thigh": ROD, "shank": ROD, "com": ".1"} | more))
    (folder / "r.urdf").write_text(text)
    return folder / "r.urdf"


def picked(folder: Path, shape: str = "", foot: str = "", **more: str) -> PickedLeg:
    return robot_leg(urdf(folder, shape, foot, **more), ["hip", "knee"])


@pytest.mark.parametrize(
    ("shape", "foot", "length", "said"),
    [
        (MESH.format(""), FOOT, 190.0, 'the mesh m.stl of shank reaches 210.{}: is it in mm? Then write scale="0.001 '),
        (
            MESH.format(' scale=".1 .1 .1"'),
            FOOT,
            190.0,
            'm, 111 times{}: is it in cm? Then write scale="0.01 0.01 0.01"',
        ),
        (MESH.format(' scale=".0394 .0394 .0394"'), FOOT, 190.0, "m, 43.6 times{}: is it in inches? Then write scale="),
        (
            '<cylinder radius="10" length="420"/>',
            FOOT,
            190.0,
            "the cylinder of shank reaches{}: is it in mm? Then write",
        ),
        (MESH.format(' scale="9 9 9"'), FOOT, 190.0, "{}: check its size. Its length is taken without it; --tip"),
        (MESH.format(""), "", 200.0, "the rest of the link (100 mm){}: is it in mm?"),
        (MESH.format(' scale=".001 .001 .001"'), FOOT, 210.0, ""),
        (MESH.format(' scale=".01 .01 .01"'), FOOT, 2100.0, ""),  # ten times: a boom, perhaps
    ],
)
def test_a_shape_in_another_unit_is_no_end(shape: str, foot: str, length: float, said: str, tmp_path: Path) -> None:
    """A mesh in mm made a leg of 210 m without a word, beside which any inertia passed."""
    found = picked(tmp_path, shape, foot)
    assert 1e3 * found.leg.joints[-1].link.length == pytest.approx(length, rel=1e-6)
    notes = [text for text in found.messages if " times as far as " in text]
    assert len(notes) == bool(said)
    for part in said.split("{}"):
        assert part in "".join(notes)
    given = robot_leg(tmp_path / "r.urdf", ["hip", "knee"], tip=0.3)
    assert given.leg.joints[-1].link.length == pytest.approx(0.3)
    assert given.leg.joints[-1].zero == pytest.approx(0.0, abs=1e-9)
    assert not any(" times as far as " in text for text in given.messages)


def test_an_inertia_in_another_unit_does_not_mislead_the_question_for_a_mesh_s(tmp_path: Path) -> None:
    """The radius of gyration, 1.6 m, would suggest cm."""
    (said,) = [text for text in picked(tmp_path, MESH.format(""), FOOT, shank=INERTIA.format(0.5, 0.5, 5e-3)).messages
               if " times as far as " in text]  # fmt: skip
    assert "is it in mm?" in said


def test_a_link_known_by_nothing_but_such_a_shape_is_refused_with_its_name(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"give its length: --tip; the mesh m.stl of shank reaches .* is it in mm\?"):
        picked(tmp_path, MESH.format(""), com="0")


def test_a_mesh_in_mm_of_an_mjcf(tmp_path: Path) -> None:
    urdf(tmp_path)
    (tmp_path / "r.xml").write_text(
        """<mujoco><asset><mesh name="m" file="m.stl"/></asset><worldbody><body name="t">
        <inertial pos="0 0 -.1" mass=".2" diaginertia="1e-3 1e-3 1e-3"/><joint name="hip" axis="0 1 0"/>
        <geom type="mesh" mesh="m"/></body></worldbody></mujoco>"""
    )
    found = robot_leg(tmp_path / "r.xml", ["hip"])
    assert found.leg.joints[0].link.length == pytest.approx(0.2)
    assert any(text.startswith("the mesh m of t reaches 210") and "is it in mm?" in text for text in found.messages)


@pytest.mark.parametrize(
    ("moments", "said"),
    [
        ((3e-3, 3e-3, 3.2e-5), ""),
        ((3e-3, 3.034e-3, 3.2e-5), ""),  # 0.07 %: a file's digits
        (
            (3e-3, 3.1e-3, 3.2e-5),
            "the largest principal moment of inertia exceeds the sum of the others, .* shank 2.2 %; ",
        ),
        ((3e-3, 0.302, 3.6e-5), r"shank: no body has the principal moments of inertia 3.6e-05, 0.003, 0.302 kg m\^2"),
    ],
)
def test_an_inertia_that_no_body_has_is_told(moments: tuple[float, ...], said: str, tmp_path: Path) -> None:
    """MuJoCo refuses such a body: inertia must satisfy A + B >= C. It was taken without a word."""
    found = picked(tmp_path, "", FOOT, shank=INERTIA.format(*moments))
    notes = [text for text in found.messages if "principal moment" in text]
    assert len(notes) == bool(said)
    assert re.search(said, "".join(notes))
    assert found.leg.joints[1].link.inertia == pytest.approx(moments[1])


def test_init_and_check_tell_an_impossible_link(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Its radius of gyration is 3.6 lengths of the link; `synth check` ended with "all checks hold"."""
    file = urdf(tmp_path, "", FOOT, shank=INERTIA.format(0.1, 0.1, 1e-4))
    made = tmp_path / "made"
    assert main(["init", "gap", str(made), "--from", str(file), "--chain", "hip,knee", "--json"]) == 0
    notes = json.loads(capsys.readouterr().out)["notes"]
    (said,) = [text for text in notes if "its mass by its length squared" in text]
    assert said.startswith("knee: the link's inertia is ")
    assert f"## To check\n\n- {said}\n" in (made / "README.md").read_text()
    assert main(["check", str(made / "robot.leg.yaml"), "--out", str(tmp_path / "checked")]) == 0
    assert f"note: {said}" in capsys.readouterr().out
    assert json.loads((tmp_path / "checked" / "check.json").read_text())["warnings"] == [said]
    page = (tmp_path / "checked" / "report.html").read_text()
    assert "Check the numbers of the links, then run this again." in page


def test_a_project_s_folders_are_as_the_user_s_others(tmp_path: Path) -> None:
    """That of a robot's leg was closed to all but its maker."""
    (tmp_path / "plain").mkdir()
    made = tmp_path / "made"
    assert main(["init", "gap", str(made), "--from", str(urdf(tmp_path, "", FOOT)), "--chain", "hip,knee", "-q"]) == 0
    for folder in (made, made / "trials", made / "schemas"):
        assert folder.stat().st_mode == (tmp_path / "plain").stat().st_mode


@pytest.mark.parametrize("moments", ["-3.535e-08 3.501e-08 9.087e-08", "-1e-3 -1e-3 -1e-3"])
def test_a_body_outside_the_leg_may_have_any_inertia(moments: str, tmp_path: Path) -> None:
    """TIAGo's antennas have such numbers; no leg or arm of it was read."""
    xx, yy, zz = moments.split()
    antenna = f"""<link name="antenna"><inertial><mass value="1e-6"/><inertia ixx="{xx}" iyy="{yy}" izz="{zz}"/>
        </inertial></link><joint name="a" type="fixed"><parent link="base"/><child link="antenna"/></joint>"""
    path = urdf(tmp_path, foot=FOOT + antenna)
    assert robot_leg(path, ["hip", "knee"]).leg == picked(tmp_path, foot=FOOT).leg


def test_what_arithmetic_leaves_of_no_inertia_is_none(tmp_path: Path) -> None:
    """ICub's CAD wrote -5.4e-20 kg m^2 for links of 0.5 kg: refused, though nothing is off by it."""
    dust = INERTIA.format(-5.42101e-20, -5.42101e-20, 0.0)
    found, none = (picked(tmp_path, foot=FOOT, thigh=each) for each in (dust, INERTIA.format(0.0, 0.0, 0.0)))
    assert found.leg.joints[0].link == none.leg.joints[0].link
    assert found.messages == none.messages
