"""MuJoCo's warnings are told, and leave no file in the folder that the user is in; so is an MJCF that is not in SI."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from synth.files.robots.robot_project import robot_leg
from synth.mujoco_warnings import heard_warnings

LINK = '<body><joint name="h" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 -.3" size=".02"/></body>'


def test_a_file_s_warning_is_told_beside_what_is_left_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    text = f'<mujoco><compiler settotalmass="1"/><worldbody>{LINK}</worldbody></mujoco>'
    (tmp_path / "a.xml").write_text(text, encoding="utf-8")
    picked = robot_leg(tmp_path / "a.xml", ["h"])
    assert any("MuJoCo warns" in each and "settotalmass" in each for each in picked.messages)
    assert [path.name for path in tmp_path.iterdir()] == ["a.xml"]


def test_a_simulation_that_is_lost_is_heard(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{LINK}</worldbody></mujoco>")
    data = mujoco.MjData(model)
    with heard_warnings(mujoco) as heard:
        data.qvel[0] = np.inf
        mujoco.mj_step(model, data)
    assert heard
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("gravity", "unit"), [(-981.0, "centimetres"), (-9810.0, "millimetres"), (-9.81, "")])
def test_gravity_of_a_file_in_smaller_units_is_told(gravity: float, unit: str, tmp_path: Path) -> None:
    """Of a fly in centimetres and grams a leg of metres and kilograms was made without a word."""
    link = '<body><joint name="h" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 -.3" size=".02"/></body>'
    text = f'<mujoco><option gravity="0 0 {gravity}"/><worldbody>{link}</worldbody></mujoco>'
    (tmp_path / "a.xml").write_text(text, encoding="utf-8")
    told = [each for each in robot_leg(tmp_path / "a.xml", ["h"]).messages if "gravity is" in each]
    assert [unit in each for each in told] == ([True] if unit else [])
