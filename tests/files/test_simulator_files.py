"""The diagnosed leg for simulators: each file read by its own library, its omissions reported."""

from __future__ import annotations

from importlib.util import find_spec
from math import degrees, radians
from pathlib import Path

import mujoco
import numpy as np
import pytest

from fit.simulated_legs import robot
from synth.files.robot_usd import identifier, usd_file
from synth.files.simulator_files import write_simulator_files
from synth.swing.leg_model import Damper, DamperCurve

FASTEST = np.full(3, 10.0)
CURVE = DamperCurve((0.1, 1.0, 8.0), (0.04, 0.11, 0.29))


def test_every_file_lists_its_omissions(tmp_path: Path) -> None:
    leg = robot().with_joints(
        hip={"effects": {"coulomb_friction": {"torque": 0.05}}},
        knee={"damper": Damper(curve=CURVE)},
        ankle={"effects": {"backlash": {"gap": 0.01}}},
    )
    lost = write_simulator_files(leg, FASTEST, tmp_path / "d")
    assert sorted(lost) == ["leg.mjcf.xml", "leg.sdf", "leg.urdf", "leg.usda"]
    assert mujoco.MjModel.from_xml_path(str(tmp_path / "d" / "leg.mjcf.xml")).njnt == 4  # one behind the play
    assert [any("backlash" in text for text in said) for said in lost.values()] == [False, True, True, True]
    assert not any("coulomb" in text for text in lost["leg.mjcf.xml"])
    assert any("coulomb_friction" in text for text in lost["leg.usda"])
    assert any("no springs" in text for text in lost["leg.urdf"])
    assert any("straight line" in text for text in lost["leg.usda"])
    readme = (tmp_path / "d" / "README.md").read_text()
    assert all(text in readme for said in lost.values() for text in said)


def test_usd_rates_are_per_degree() -> None:
    leg = robot().with_joints(hip={"armature": 2e-5, "range": (1.0, 2.0)})
    text = usd_file(leg, FASTEST).text
    hip = leg.joints[0]
    assert hip.spring is not None
    assert hip.damper is not None
    assert hip.damper.rate is not None
    for line in (
        f"physics:stiffness = {hip.spring.rate * radians(1):.9g}",
        f"physics:damping = {hip.damper.rate * radians(1):.9g}",
        f"physics:targetPosition = {degrees(hip.rest):.9g}",
        "physxJoint:armature = 2e-05",
    ):
        assert line in text


def test_names_are_usd_identifiers() -> None:
    assert identifier("left knee-2") == "left_knee_2"
    assert identifier("2nd") == "_2nd"


@pytest.mark.skipif(find_spec("pxr") is None, reason="usd-core is not installed")
def test_usd_reads_the_layer() -> None:
    from pxr import Sdf

    leg = robot()
    layer = Sdf.Layer.CreateAnonymous(".usda")
    assert layer.ImportFromString(usd_file(leg, FASTEST).text)
    root = identifier(leg.name)
    for joint in leg.joints:
        found = layer.GetAttributeAtPath(f"/{root}/joints/{joint.name}.drive:angular:physics:stiffness")
        assert joint.spring is not None
        assert found.default == pytest.approx(joint.spring.rate * radians(1), rel=1e-6)
        mass = layer.GetAttributeAtPath(f"/{root}/{joint.name}_link.physics:mass")
        assert mass.default == pytest.approx(joint.link.mass, rel=1e-6)
