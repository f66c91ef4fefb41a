"""The leg as MJCF: MuJoCo reads it, and what it cannot hold is said in it."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from fit.simulated_legs import robot
from synth.files.mjcf import mjcf_text
from synth.model.chain import simulate
from synth.model.leg import Leg

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
