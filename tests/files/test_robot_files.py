"""The leg as URDF and SDF: other readers find the same masses, hinges and rates, and omissions are reported."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from fit.simulated_legs import robot
from synth.files.joint_springs import spring_terms
from synth.files.robot_bodies import RobotLink, Visual
from synth.files.robot_xml import sdf_file, urdf_file, write_robot_files
from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, DamperCurve, Leg, Spring

FASTEST = np.full(3, 10.0)
CURVE = DamperCurve((0.1, 1.0, 10.0), (0.05, 0.1, 0.2))


def without_springs(leg: Leg) -> Leg:
    return leg.with_joints(**{joint.name: {"spring": None} for joint in leg.joints})


def test_mujoco_reads_the_urdf_and_moves_it_as_the_chain_moves_a_leg_without_springs() -> None:
    leg = replace(without_springs(robot()), tilt=0.2)
    model = mujoco.MjModel.from_xml_string(urdf_file(leg, FASTEST).text)
    model.opt.timestep, model.opt.integrator = 1e-4, mujoco.mjtIntegrator.mjINT_RK4
    data = mujoco.MjData(model)
    data.qpos[:] = start = [0.5, -1.8, 1.2]
    mujoco.mj_step(model, data, nstep=3000)
    ours = simulate(leg, start, [0.0] * 3, np.array([0.0, 0.3]), tolerance=1e-9)[-1]
    assert np.abs(ours - start).max() > 0.1
    np.testing.assert_allclose(data.qpos, ours, atol=1e-5)


def test_the_drawn_mount_of_a_tilted_leg_is_tilted_in_every_file() -> None:
    """In the URDF the mount stood upright, so that the links of a leg tilted by 90 deg hung through it."""
    mount = Visual("mount", "mount.stl", 0.3, (0.02, -0.05, 0.01), (0.5, 0.5, 0.5))
    leg, base = replace(robot(), tilt=0.7), RobotLink(None, (mount,))
    turned = Rotation.from_euler("y", -leg.tilt)  # the base's, as MJCF and SDF state it
    wanted = turned * Rotation.from_euler("xyz", mount.rpy)
    visual = ET.fromstring(urdf_file(leg, FASTEST, base).text).find("link[@name='base']/visual/origin")
    assert visual is not None
    place, turn = ([float(value) for value in str(visual.get(key)).split()] for key in ("xyz", "rpy"))
    np.testing.assert_allclose(place, turned.apply(mount.place), atol=1e-9)
    np.testing.assert_allclose(Rotation.from_euler("xyz", turn).as_matrix(), wanted.as_matrix(), atol=1e-8)
    model = ET.fromstring(sdf_file(leg, FASTEST, base).text)
    pose = [float(value) for value in str(model.findtext(".//link[@name='base']/pose")).split()]
    np.testing.assert_allclose(Rotation.from_euler("xyz", pose[3:]).as_matrix(), turned.as_matrix(), atol=1e-8)


def test_the_sdf_holds_springs_with_their_rest_and_dampers() -> None:
    leg = robot()
    root = ET.fromstring(sdf_file(leg, FASTEST).text)
    joints = {j.get("name"): j for j in root.iter("joint") if j.get("type") == "revolute"}
    assert list(joints) == list(leg.joint_names)
    for joint in leg.joints:
        spring, damper = joint.spring, joint.damper
        assert spring is not None
        assert damper is not None
        found = joints[joint.name].find("axis/dynamics")
        assert found is not None
        assert float(found.findtext("spring_stiffness") or "nan") == pytest.approx(spring.rate)
        rest = joint.sign * (spring.free_angle - joint.zero)
        assert float(found.findtext("spring_reference") or "nan") == pytest.approx(rest)
        assert float(found.findtext("damping") or "nan") == pytest.approx(damper.rate)
    masses = [float(mass.text or "nan") for mass in root.iter("mass")]
    assert masses == pytest.approx([joint.link.mass for joint in leg.joints])
    # Each link hangs from its parent's end: heights add up along the chain.
    poses = [link.findtext("pose") for link in root.iter("link")][1:]
    lengths = [0.0, *(-joint.link.length for joint in leg.joints[:-1])]
    assert [float((pose or "").split()[2]) for pose in poses] == pytest.approx(lengths)


def test_a_joint_without_a_spring_lacks_none_in_urdf(tmp_path) -> None:
    """A diagnosis gives every joint a spring, of rate 0 where the leg file has none: "0 N*m/rad is left out"."""
    leg = robot().with_joints(knee={"spring": Spring(0.0, 0.3)})
    said = [text for text in write_robot_files(leg, FASTEST, tmp_path) if "no springs" in text]
    assert not any("knee: URDF has no springs" in text for text in said)
    assert spring_terms(leg.joints[leg.joint_names.index("knee")], 1.0).error == 0.0  # was 0/0


def test_features_that_a_format_lacks_are_reported_in_file_and_report(tmp_path) -> None:
    leg = robot().with_joints(
        knee={"damper": Damper(curve=CURVE), "effects": {"stribeck_friction": {"torque": 0.1, "speed": 1.0}}}
    )
    said = write_robot_files(replace(leg, name="a -- b & <c>"), FASTEST, tmp_path)
    assert [text.split()[0] for text in said] == ["leg.urdf", "leg.sdf"]
    assert "URDF has no springs" in said[0]
    assert "springs" not in said[1]
    for text, name in zip(said, ("leg.urdf", "leg.sdf"), strict=True):
        assert "knee: the damper's torque-speed curve is a straight line here" in text
        assert "knee: not held: stribeck_friction" in text
        written = (tmp_path / name).read_text()
        assert "straight line" in written
        ET.fromstring(written)  # markup in names and comments is escaped
    assert write_robot_files(without_springs(robot()), FASTEST, tmp_path) == []


def test_the_straight_line_is_the_nearest_one() -> None:
    leg = robot().with_joints(knee={"damper": Damper(curve=CURVE)})
    root = ET.fromstring(urdf_file(leg, FASTEST).text)
    found = {j.get("name"): j.find("dynamics") for j in root.iter("joint")}
    rate = float(found["knee"].get("damping"))  # type: ignore[union-attr,arg-type]
    speed = np.linspace(0.0, 10.0, 200)[1:]
    torque = np.interp(speed, [0.0, *CURVE.speed], [0.0, *CURVE.torque])

    def error(tried: float) -> float:
        return float(np.sum((tried * speed - torque) ** 2))

    assert error(rate) < min(error(rate * 1.01), error(rate * 0.99))
