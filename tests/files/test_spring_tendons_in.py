"""Springs of MJCF on their way in: each is read as it acts in MuJoCo, or left out or refused with a sentence."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from files.test_mjcf_springs import EXACT, FASTEST, FITTED, TIMES, moved, one_joint
from synth.cli import main
from synth.errors import UserError
from synth.files.joint_springs import spring_torque
from synth.files.leg_file import read_leg, write_leg
from synth.files.mjcf import mjcf_text
from synth.files.robots.planar_chain import PickedLeg
from synth.files.robots.robot_project import robot_leg
from synth.swing.chain import simulate

HINGE = """<mujoco model="i"><compiler angle="radian" autolimits="true"/><option integrator="RK4" timestep="1e-4"/>
<worldbody><body name="a"><joint name="hip" axis="0 -1 0" springref="-.1" damping=".03" stiffness="{}"/>
<inertial pos="0 0 -.09" mass=".7" diaginertia="3.5e-3 3.5e-3 3.5e-3"/>
<geom type="capsule" fromto="0 0 0 0 0 -.2" size=".008" contype="0" conaffinity="0" mass="0"/></body></worldbody>
<tendon>{}</tendon></mujoco>"""


def tendon(stiffness: str, length: str) -> str:
    return f'<fixed stiffness="{stiffness}" springlength="{length}"><joint joint="hip" coef="1"/></fixed>'


def picked(path: Path, text: str) -> PickedLeg:
    path.write_text(text)
    return robot_leg(path, ["hip"], "xz")


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("gap", [0.0, 0.03])
@pytest.mark.parametrize("case", EXACT)
def test_a_spring_that_synth_wrote_is_read_again(case: str, gap: float, sign: int, tmp_path: Path) -> None:
    reach, effects = EXACT[case]
    leg = one_joint({**effects, "backlash": {"gap": gap}} if gap else effects, sign)
    found = picked(tmp_path / "a.xml", mjcf_text(leg, FASTEST))
    assert found.messages == ()
    write_leg(found.leg, tmp_path / "a.leg.yaml")
    (again,) = read_leg(tmp_path / "a.leg.yaml").joints
    assert again.effects.keys() == leg.joints[0].effects.keys()
    deflection = np.linspace(-reach, reach, 50)
    np.testing.assert_allclose(
        spring_torque(again, deflection), spring_torque(leg.joints[0], deflection), rtol=1e-9, atol=1e-9
    )


@pytest.mark.parametrize(
    ("stiffness", "tendons"),
    [
        ("2 0 1", ""),
        ("2", tendon("0 1 0", "-1e6 .2") + tendon("0 -1 0", "-.4 1e6")),
        ("2", tendon("0 0 2", "-1e6 .1") + tendon("0 0 2", "-.3 1e6")),
        ("2", tendon("-1.2", "-1e5 0")),
        ("2 0 1", tendon("1", "-.1 1e6")),
        ("2", tendon("3", "-.3 .1")),
    ],
    ids=["cubic", "quadratic pair", "cubic pair", "softer above", "harder below and cubic", "bumpers"],
)
def test_springs_are_read_as_they_act(stiffness: str, tendons: str, tmp_path: Path) -> None:
    text = HINGE.format(stiffness, tendons)
    found = picked(tmp_path / "a.xml", text)
    assert found.messages == ()
    for start in (0.9, -0.9):
        theirs = moved(mujoco.MjModel.from_xml_string(text), np.array([start]))
        ours = simulate(found.leg, found.leg.to_rotation(np.array([start])), [0.0], TIMES, tolerance=1e-9)
        assert np.degrees(np.abs(found.leg.to_measured(ours) - theirs).max()) < 0.01


@pytest.mark.parametrize("stiffness", ["2 1 0", "2 1", "2.091 -0.549 -0.134", "0 1 0"])
def test_a_quadratic_stiffness_is_refused(stiffness: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It was read as odd: 30.9 deg off."""
    path = tmp_path / "a.xml"
    path.write_text(HINGE.format(stiffness, ""))
    assert main(["init", "gap", str(tmp_path / "p"), "--from", str(path), "--chain", "hip"]) == 2
    said = " ".join(capsys.readouterr().err.split())
    for part in (str(path), "hip: stiffness=", stiffness.split()[1], "pulls the same way on both sides", "make it 0"):
        assert part in said
    assert not (tmp_path / "p").exists()


def test_a_quadratic_stiffness_outside_the_chain_is_no_matter(tmp_path: Path) -> None:
    other = '<body pos="0 0 -.2"><joint name="toe" axis="0 -1 0" stiffness="2 1 0"/><geom size=".01"/></body></body>'
    found = picked(tmp_path / "a.xml", HINGE.format("2", "").replace("</body>", other, 1))
    assert any("toe is locked" in text for text in found.messages)
    with pytest.raises(UserError, match="toe: stiffness="):
        robot_leg(tmp_path / "a.xml", ["hip", "toe"])


@pytest.mark.parametrize(
    ("stiffness", "tendons"),
    [
        ("2", tendon("1 1 0", "-.3 .1")),
        ("2", tendon("0 1 0", "-.3 .1")),
        ("2", tendon("0 1 0", "-1e6 .1") + tendon("0 1 0", "-.3 1e6")),
        ("2", tendon("0 0 1", "-.3 .2")),
        ("2", tendon("0 0 1", "-1e6 .2")),
        ("2", tendon("1", "-1e6 .1") + tendon("1", "-.4 1e6")),
        ("2 0 1", tendon("0 0 1", "-.3 .1")),
    ],
    ids=["two powers", "even", "even pair", "beside", "one side", "two places", "two cubics"],
)
def test_springs_that_a_leg_does_not_know_are_left_out_and_named(stiffness: str, tendons: str, tmp_path: Path) -> None:
    found = picked(tmp_path / "a.xml", HINGE.format(stiffness, tendons))
    assert "hardening_spring" not in found.leg.joints[0].effects
    assert any("hip: the springs of its tendons are left out" in text for text in found.messages)
    assert any("left out: " in text and "tendon" in text for text in found.messages)


@pytest.mark.parametrize("case", ["softening", "exponent 6", "rounded changeover"])
def test_a_fitted_spring_is_left_out_but_for_its_rate(case: str, tmp_path: Path) -> None:
    found = picked(tmp_path / "a.xml", mjcf_text(one_joint(FITTED[case][1]), FASTEST))
    (joint,) = found.leg.joints
    assert joint.effects == {}
    assert joint.spring is not None
    assert joint.spring.rate == 2.0
    assert any("its linear rate alone is kept" in text for text in found.messages)


def test_a_stiffness_without_a_linear_term_is_left_out_and_named(tmp_path: Path) -> None:
    found = picked(tmp_path / "a.xml", HINGE.format("0 0 1", ""))
    assert found.leg.joints[0].spring is None
    assert any("without a linear term" in text for text in found.messages)
