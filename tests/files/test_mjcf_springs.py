"""Springs that are not linear and their curves in MuJoCo: torques on both sides, motion, and what the file states."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from synth.arrays import Array
from synth.files.joint_springs import spring_terms, spring_torque
from synth.files.mjcf import mjcf_text
from synth.files.simulator_files import write_simulator_files
from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

FASTEST, TIMES = np.full(1, 15.0), np.arange(0.0, 1.5, 0.01)
HARD, ONE_SIDED = "hardening_spring", "one_sided_spring"
EXACT = {
    "exponent 2": (0.9, {HARD: {"stiffening": 1.0, "exponent": 2.0}}),
    "exponent 3": (0.9, {HARD: {"stiffening": 1.0, "exponent": 3.0}}),
    "exponent 2 beyond an onset": (0.9, {HARD: {"stiffening": 1.0, "exponent": 2.0, "onset": 0.3}}),
    "exponent 3 beyond an onset": (0.9, {HARD: {"stiffening": 1.0, "exponent": 3.0, "onset": 0.3, "reach": 0.5}}),
    "bumper": (0.9, {HARD: {"stiffening": 2.0, "exponent": 1.0, "onset": 0.3, "reach": 0.3}}),
    "one side only": (0.9, {ONE_SIDED: {"loss_below": 1.0}}),
    "two rates": (0.9, {ONE_SIDED: {"loss_above": 0.6, "loss_below": -0.2, "shift": 0.05}}),
}
FITTED = {
    "exponent 6": (1.3, {HARD: {"stiffening": 1.0, "exponent": 6.0}}),
    "exponent 6 beyond an onset": (1.4, {HARD: {"stiffening": 1.0, "exponent": 6.0, "onset": 0.2}}),
    "exponent 1.5": (1.0, {HARD: {"stiffening": 2.0, "exponent": 1.5, "onset": 0.5}}),
    "softening": (2.0, {HARD: {"softening": 1.0}}),
    "softening and hardening": (1.2, {HARD: {"softening": 1.2, "stiffening": 0.5, "exponent": 4.0}}),
    "rounded changeover": (0.9, {ONE_SIDED: {"loss_above": 0.6, "shift": -0.05, "width": 0.03}}),
    "both": (0.9, {ONE_SIDED: {"loss_above": 0.5, "width": 0.2}, HARD: {"softening": 0.7}}),
}


def one_joint(effects: dict[str, dict[str, float]], sign: int = 1) -> Leg:
    """A leg of one joint; with sign -1 its measured angles count the other way from another zero."""
    zero = 0.0 if sign > 0 else 0.3
    joint = Joint(
        "hip", Link(0.2, 0.7, 0.09, 3.5e-3), zero=zero, sign=sign, spring=Spring(2.0, 0.2), damper=Damper(0.03),
        effects=effects,
    )  # fmt: skip
    return Leg("one", (joint,))


def moved(model: mujoco.MjModel, start: Array) -> Array:
    """(m, n) rad, from rest, with the file's own step and integrator."""
    data, found = mujoco.MjData(model), np.empty((len(TIMES), len(start)))
    data.qpos[:] = start
    for index in range(len(TIMES)):
        found[index] = data.qpos
        mujoco.mj_step(model, data, nstep=round(0.01 / model.opt.timestep))
    return found


def torques(model: mujoco.MjModel, angles: Array) -> Array:
    """(m,) N m that resist, of a single hinge at rest."""
    data, found = mujoco.MjData(model), []
    for angle in angles:
        data.qpos[:] = angle
        mujoco.mj_forward(model, data)
        found.append(-float(data.qfrc_passive[0]))
    return np.array(found)


def test_mujoco_s_own_quadratic_stiffness_is_even_and_its_damping_odd() -> None:
    """What the writer and the reader rest on."""
    text = """<mujoco><option gravity="0 0 0"/><worldbody><body><joint name="h" {}/><inertial pos="0 0 0" mass="1"
    diaginertia="1 1 1"/></body></worldbody><tendon>{}</tendon></mujoco>"""
    joint = mujoco.MjModel.from_xml_string(text.format('stiffness="2 -.5 .8"', ""))
    np.testing.assert_allclose(torques(joint, np.array([1.0, -1.0])), [2.3, -3.3])
    fixed = '<fixed springlength="{}" stiffness="2 -.5 .8"><joint joint="h" coef="1"/></fixed>'
    tendon = mujoco.MjModel.from_xml_string(text.format("", fixed.format("-.5 .5")))
    np.testing.assert_allclose(torques(tendon, np.array([1.5, 0.4, -0.4, -1.5])), [2.3, 0.0, 0.0, -3.3])
    above = mujoco.MjModel.from_xml_string(text.format("", fixed.format("-1e6 .5")))
    np.testing.assert_allclose(torques(above, np.array([1.5, -1.5])), [2.3, 0.0])
    damped = mujoco.MjModel.from_xml_string(text.format('damping="0 1 0"', ""))
    data = mujoco.MjData(damped)
    for speed in (2.0, -2.0):
        data.qvel[:] = speed
        mujoco.mj_forward(damped, data)
        assert data.qfrc_passive[0] == pytest.approx(-speed * abs(speed))


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("case", [*EXACT, *FITTED])
def test_mujoco_s_spring_pulls_and_moves_as_ours(case: str, sign: int) -> None:
    """Both sides, over what the motion covers; 30.9 deg off where the quadratic term was the joint's own."""
    reach, effects = (EXACT | FITTED)[case]
    leg = one_joint(effects, sign)
    joint, start = leg.joints[0], np.array([leg.joints[0].rest - 0.98 * reach])
    model = mujoco.MjModel.from_xml_string(mjcf_text(leg, FASTEST, deflected=np.full(1, reach)))
    deflection = np.linspace(-reach, reach, 61)
    wanted = spring_torque(joint, deflection)
    off = np.abs(torques(model, joint.rest + deflection) - wanted).max() / np.abs(wanted).max()
    assert off < (1e-8 if case in EXACT else 3e-4)
    ours = simulate(leg, start, [0.0], TIMES, tolerance=1e-9)
    plain = simulate(one_joint({}, sign), start, [0.0], TIMES, tolerance=1e-9)
    assert np.degrees(np.abs(ours - plain).max()) > 3.0  # the case matters
    assert np.degrees(np.abs(moved(model, start) - ours).max()) < (0.001 if case in EXACT else 0.01)


@pytest.mark.parametrize("case", EXACT)
def test_what_mujoco_holds_exactly_is_no_omission_and_has_no_range(case: str, tmp_path: Path) -> None:
    leg = one_joint(EXACT[case][1])
    assert write_simulator_files(leg, FASTEST, tmp_path, deflected=np.full(1, 0.1))["leg.mjcf.xml"] == ()
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "leg.mjcf.xml"))
    deflection = np.linspace(-3.0, 3.0, 31)
    np.testing.assert_allclose(
        torques(model, leg.rest + deflection), spring_torque(leg.joints[0], deflection), rtol=1e-7, atol=1e-8
    )


def test_a_fitted_spring_states_how_far_and_how_well_it_holds(tmp_path: Path) -> None:
    leg = one_joint({HARD: {"softening": 1.0}})
    (said,) = write_simulator_files(leg, FASTEST, tmp_path, deflected=np.full(1, 1.2))["leg.mjcf.xml"]
    terms = spring_terms(leg.joints[0], 1.1 * 1.2)
    assert 1e-6 < terms.error < 3e-4
    where = "the spring's curve is fitted up to 75.6 deg of deflection, there at most "
    assert said == f"hip: {where}{terms.error:.2%} of its torque off; beyond, it goes on straight"
    assert said in (tmp_path / "README.md").read_text()
    text = (tmp_path / "leg.mjcf.xml").read_text()
    assert said.removeprefix("hip: ") in text
    model = mujoco.MjModel.from_xml_string(text)
    inside, beyond, farther = torques(model, leg.rest + np.array([1.32, 2.0, 3.0]))
    assert 0.0 < inside < beyond < farther
    assert farther == pytest.approx(beyond + (beyond - inside) / (2.0 - 1.32), rel=1e-6)


@pytest.mark.parametrize(
    ("span", "deflected", "reach"),
    [(None, None, 180.0), (None, 0.5, 31.5), ((-0.8, 1.2), None, 57.3), ((-0.8, 1.2), 1.5, 94.5), (None, 0.0, 1.0)],
)
def test_the_fit_reaches_over_the_known_motion_and_the_range(
    span: tuple[float, float] | None, deflected: float | None, reach: float
) -> None:
    leg = one_joint({HARD: {"softening": 1.0}}).with_joints(hip={"range": span})
    known = None if deflected is None else np.full(1, deflected)
    assert f"up to {reach:.3g} deg of deflection" in mjcf_text(leg, FASTEST, deflected=known)


def test_behind_backlash_the_arm_has_the_whole_spring() -> None:
    effects = {HARD: {"stiffening": 1.0, "exponent": 2.0, "onset": 0.1}, "backlash": {"gap": 0.03}}
    model = mujoco.MjModel.from_xml_string(mjcf_text(one_joint(effects), FASTEST))
    data, arm = mujoco.MjData(model), int(model.joint("hip arm").dofadr[0])
    for angle in (0.9, -0.6):
        data.qpos[:] = angle
        mujoco.mj_forward(model, data)
        wanted = spring_torque(one_joint(effects).joints[0], np.array(angle - 0.2))
        assert -data.qfrc_passive[arm] == pytest.approx(wanted, rel=1e-8)
        assert data.qfrc_passive[1 - arm] == 0.0
