"""Dampers' torque-speed tables in MuJoCo, straight and curved: torques within and beyond the represented speeds."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from files.test_mjcf_springs import TIMES, moved
from synth.arrays import Array
from synth.files.joint_curves import damper_torque, damping_terms
from synth.files.mjcf import mjcf_text
from synth.files.robots.robot_project import robot_leg
from synth.files.simulator_files import write_simulator_files
from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, DamperCurve, Joint, Leg, Link, Spring

SPEEDS = (
    (0.05, 0.2, 0.8, 3.0, 10.0, 30.0),
    (0.5, 1.0, 2.0, 4.0, 8.0),
    (0.1, 0.3, 1.0, 3.0, 10.0),
    (1.0, 2.0, 3.0, 4.0, 5.0, 6.0),
    (0.2, 0.5, 1.0, 2.0, 5.0, 10.0),
)
RATES = (0.01, 0.013, 0.02, 0.037, 0.1, 0.29)
TABLES = {
    "straight": DamperCurve(SPEEDS[0], tuple(0.01 * speed for speed in SPEEDS[0])),
    "flattens": DamperCurve((0.1, 1.0, 5.0, 20.0), (0.02, 0.06, 0.12, 0.2)),
    "steepens": DamperCurve((1.0, 2.0, 4.0, 8.0), (0.005, 0.015, 0.05, 0.17)),
    "wavy": DamperCurve((0.5, 1.0, 3.0, 6.0, 12.0), (0.02, 0.03, 0.08, 0.11, 0.15)),
}


def one_joint(curve: DamperCurve) -> Leg:
    return Leg(
        "one", (Joint("hip", Link(0.2, 0.7, 0.09, 3.5e-3), spring=Spring(2.0, 0.0), damper=Damper(curve=curve)),)
    )


def torques(model: mujoco.MjModel, speeds: Array) -> Array:
    """(m,) N m that resist at speeds (m,) rad/s, of a single hinge at its rest."""
    data, found = mujoco.MjData(model), []
    for speed in speeds:
        data.qpos[:], data.qvel[:] = 0.0, speed
        mujoco.mj_forward(model, data)
        found.append(-float(data.qfrc_passive[0] + data.qfrc_constraint[0]))
    return np.array(found)


@pytest.mark.parametrize("fastest", [2.0, 5.0, 15.0])
@pytest.mark.parametrize("speeds", SPEEDS)
def test_a_straight_table_is_a_rate_at_every_speed(speeds: tuple[float, ...], fastest: float) -> None:
    """Of 60 such tables 28 held their torque beyond a speed: a clamp took the whole rate."""
    for rate in RATES:
        joint = one_joint(DamperCurve(speeds, tuple(rate * speed for speed in speeds))).joints[0]
        terms = damping_terms(joint, fastest)
        assert (terms.speed, terms.slope, terms.error) == ((), (), 0.0)
        assert terms.polynomial == pytest.approx((rate, 0.0, 0.0), rel=1e-9)


@pytest.mark.parametrize(("digits", "off"), [(3, 0.1), (4, 1e-3), (6, 1e-5)])
@pytest.mark.parametrize("fastest", [2.0, 5.0])
def test_a_straight_table_of_rounded_numbers_does_not_saturate(fastest: float, digits: int, off: float) -> None:
    speeds = np.array([5.0, 10.0, 20.0, 40.0, 60.0, 100.0]) * np.pi / 30.0
    for rate in RATES:
        table = DamperCurve(tuple(speeds.tolist()), tuple(float(f"{rate * speed:.{digits}g}") for speed in speeds))
        terms = damping_terms(one_joint(table).joints[0], fastest)
        far = np.array([fastest, 2.0 * fastest, 4.0 * fastest])
        np.testing.assert_allclose(terms.torque(far), rate * far, rtol=off)


@pytest.mark.parametrize("table", TABLES)
def test_mujoco_s_damper_is_the_table_s(table: str, tmp_path: Path) -> None:
    """Torques up to the fastest speed within the stated error, and the motion; the flattening table at every speed."""
    leg, fastest = one_joint(TABLES[table]), np.full(1, 8.0)
    lost = write_simulator_files(leg, fastest, tmp_path)["leg.mjcf.xml"]
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "leg.mjcf.xml"))
    terms, speed = damping_terms(leg.joints[0], 8.0), np.linspace(-8.0, 8.0, 81)
    wanted = damper_torque(leg.joints[0], speed)
    off = np.abs(torques(model, speed) - wanted).max() / wanted.max()
    assert off == pytest.approx(terms.error, abs=1e-3)
    stated = () if terms.error == 0.0 else (f"most {terms.error:.1%} of its torque off up to 8 rad/s",)
    assert [text in said for text, said in zip(stated, lost, strict=True)] == [True] * len(stated)
    if table in ("straight", "flattens"):
        far = np.array([12.0, 20.0, 40.0])
        np.testing.assert_allclose(torques(model, far), damper_torque(leg.joints[0], far), rtol=2e-3)
    ours = simulate(leg, [0.9], [0.0], TIMES, tolerance=1e-9)
    assert np.degrees(np.abs(moved(model, np.array([0.9])) - ours).max()) < 0.1 + 60.0 * terms.error


@pytest.mark.parametrize("loss", [0.4, 1.0])
def test_a_thinning_damper_does_not_saturate_where_its_fit_ends(loss: float) -> None:
    joint = one_joint(TABLES["straight"]).joints[0]
    thinned = Leg("one", (joint,)).with_joints(
        hip={"damper": Damper(0.05), "effects": {"shear_thinning_damping": {"loss": loss, "speed": 3.0, "knee": 2.0}}}
    )
    terms = damping_terms(thinned.joints[0], 8.0)
    assert max(terms.speed) < 8.0
    slope = np.diff(terms.torque(np.array([7.9, 8.0, 8.1])))
    assert slope[1] == pytest.approx(slope[0], rel=1e-2)


def test_a_straight_table_is_read_again_as_a_rate(tmp_path: Path) -> None:
    """It came back as a curve that is flat above 10 rad/s."""
    for fastest in (2.0, 5.0):
        path = tmp_path / "a.xml"
        path.write_text(mjcf_text(one_joint(TABLES["straight"]), np.full(1, fastest)))
        damper = robot_leg(path, ["hip"]).leg.joints[0].damper
        assert damper is not None
        assert damper.curve is None
        assert damper.rate == pytest.approx(0.01, rel=1e-9)
