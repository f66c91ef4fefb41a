"""The leg as MJCF: MuJoCo reads it, and its omissions are listed in it."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from fit.simulated_legs import robot
from synth.files.joint_curves import damping_terms
from synth.files.mjcf import inverse_inertia, mjcf_text
from synth.swing.chain import simulate
from synth.swing.effects import backlash
from synth.swing.leg_model import Damper, DamperCurve, Leg

FASTEST = np.full(3, 10.0)


def test_mujoco_moves_the_written_leg_as_the_chain_does() -> None:
    leg = robot()
    model = mujoco.MjModel.from_xml_string(mjcf_text(leg, FASTEST))
    model.opt.timestep = 1e-4
    data = mujoco.MjData(model)
    data.qpos[:] = start = [0.5, -1.8, 1.2]
    mujoco.mj_step(model, data, nstep=5000)
    ours = simulate(leg, start, [0.0] * 3, np.array([0.0, 0.5]), tolerance=1e-9)[-1]
    assert np.abs(ours - start).max() > 0.1
    np.testing.assert_allclose(data.qpos, ours, atol=1e-6)


KNEE_CURVE = DamperCurve((0.03, 0.1, 0.3, 1.0, 3.0, 8.0), (0.026, 0.04, 0.065, 0.11, 0.19, 0.29))
CASES = {
    "curves": {name: {"damper": Damper(curve=KNEE_CURVE)} for name in ("hip", "knee", "ankle")},
    "dry friction": {"knee": {"effects": {"coulomb_friction": {"torque": 0.05}}}},
    "shear thinning": {"hip": {"effects": {"shear_thinning_damping": {"loss": 0.6, "speed": 1.0, "knee": 2.0}}}},
    "drag": {"knee": {"effects": {"quadratic_damping": {"coefficient": 0.05}}}},
    "hardening": {"ankle": {"effects": {"hardening_spring": {"stiffening": 0.3, "exponent": 3.0}}}},
}


@pytest.mark.parametrize("case", CASES)
def test_mujoco_follows_what_is_not_linear_within_a_tenth_of_a_degree(case: str) -> None:
    """The exported model as it is written, its own step and integrator, swinging for a second and a half."""
    leg = robot().with_joints(**CASES[case])
    model = mujoco.MjModel.from_xml_string(mjcf_text(leg, FASTEST))
    data = mujoco.MjData(model)
    data.qpos[:] = start = np.array([0.5, -1.8, 1.2])
    data.qvel[:] = rate = np.array([2.0, -3.0, 4.0])
    times = np.arange(0.0, 1.5, model.opt.timestep)
    theirs = np.empty((len(times), 3))
    for index in range(len(times)):
        theirs[index] = data.qpos
        mujoco.mj_step(model, data)
    ours = simulate(leg, start, rate, times, tolerance=1e-8)
    plain = simulate(robot(), start, rate, times, tolerance=1e-8)
    assert np.degrees(np.abs(ours - plain).max()) > 0.5  # the case matters
    assert np.degrees(np.abs(theirs - ours).max()) < 0.1


LAWS = [
    {},
    {"one_sided_spring": {"loss_above": 0.4}},
    {"hardening_spring": {"softening": 1.5}},
    {"quadratic_damping": {"coefficient": 0.02}},
    {"quadratic_damping": {"coefficient": 0.02, "exponent": 3.0, "speed": 4.0}},
]


@pytest.mark.parametrize("law", LAWS)
def test_backlash_is_an_arm_within_its_play(law: dict[str, dict[str, float]]) -> None:
    """The spring's laws took the joint's angle in the simulation, 2.5 and 2.0 deg off; drag was on the arm, 2.1 deg."""
    effects = {"backlash": {"gap": 0.035}, **law}
    leg = robot().with_joints(**{name: {"effects": effects} for name in ("hip", "knee", "ankle")})
    model = mujoco.MjModel.from_xml_string(mjcf_text(leg, FASTEST))
    data = mujoco.MjData(model)
    start, rate = np.array([0.5, -1.8, 1.2]), np.array([2.0, -3.0, 4.0])
    for joint, angle, speed in zip(leg.joints, start, rate, strict=True):
        data.joint(joint.name).qpos[0], data.joint(joint.name).qvel[0] = angle, speed
        arm = data.joint(f"{joint.name} arm")
        arm.qpos[0], arm.qvel[0] = joint.rest + backlash.start(angle - joint.rest, 0.035), speed
    times = np.arange(0.0, 0.6, model.opt.timestep)
    hinges = [int(model.joint(joint.name).qposadr[0]) for joint in leg.joints]
    arms = [int(model.joint(f"{joint.name} arm").qposadr[0]) for joint in leg.joints]
    theirs, lag = np.empty((len(times), 3)), 0.0
    for index in range(len(times)):
        theirs[index] = data.qpos[hinges]
        lag = max(lag, float(np.abs(data.qpos[hinges] - data.qpos[arms]).max()))
        mujoco.mj_step(model, data)
    ours = simulate(leg, start, rate, times, tolerance=1e-8)
    plain = simulate(robot(), start, rate, times, tolerance=1e-8)
    assert np.degrees(np.abs(ours - plain).max()) > 0.5  # the play matters
    assert np.degrees(np.abs(theirs - ours).max()) < 0.05
    assert lag == pytest.approx(0.0175, rel=0.1)  # half of the play, and a little where they meet
    assert "not in this model" not in mjcf_text(leg, FASTEST)


def test_a_curve_that_bends_upwards_is_approximated_and_its_error_reported() -> None:
    leg = robot().with_joints(knee={"damper": Damper(curve=DamperCurve((1.0, 2.0, 4.0, 8.0), (0.02, 0.06, 0.2, 0.7)))})
    terms = damping_terms(leg.joints[1], 8.0)
    assert 0.001 < terms.error < 0.1
    speed = np.linspace(0.0, 8.0, 100)
    assert np.all(terms.torque(speed)[1:] > 0.0)  # it damps at every speed
    assert f"at most {terms.error:.1%} of its torque off" in mjcf_text(leg, np.full(3, 8.0))


def test_inverse_inertia_is_mujoco_s_own() -> None:
    model = mujoco.MjModel.from_xml_string(mjcf_text(robot(), FASTEST))
    np.testing.assert_allclose(inverse_inertia(robot()), model.dof_invweight0, rtol=1e-9)


def test_effects_that_mujoco_lacks_are_named() -> None:
    held = {"stribeck_friction": {"torque": 0.1, "speed": 1.0}, "coulomb_friction": {"torque": 0.25}}
    leg = robot().with_joints(knee={"effects": held})
    leg = Leg(leg.name, leg.joints, leg.gravity, leg.tilt, {"base_compliance": {"stiffness": 1e4}})
    text = mjcf_text(leg, FASTEST)
    assert "<!-- not in this model: stribeck_friction -->" in text
    assert "<!-- not in this model: base_compliance of the base -->" in text
    model = mujoco.MjModel.from_xml_string(text)
    assert model.dof_frictionloss.tolist() == pytest.approx([0.0, 0.25, 0.0])
    assert "not in this model" not in mjcf_text(robot(), FASTEST)
