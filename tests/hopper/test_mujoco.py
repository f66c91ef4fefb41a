"""Model A against model C, MuJoCo with a real closed loop, on the same contact: drops first, then the jump."""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
import pytest

from hopper.hoppers import catalogue, motor
from synth.errors import UserError
from synth.hopper.motors import motor_of
from synth.jump import mujoco_model
from synth.jump.hopper_leg import Contact, Flexures, HopperLeg, MotorOptions
from synth.jump.jump_layout import LAYOUTS
from synth.jump.jump_models import MODELS, lane
from synth.jump.jump_runs import compiled_jump, simulate
from synth.jump.mujoco_model import Drop, mujoco_jump
from synth.jump.outcomes import outcome_of
from synth.model_checks.jumping import same_jump, upright

GROUND = Contact()


@pytest.mark.parametrize("bending", LAYOUTS)
@pytest.mark.parametrize("name", ["A", "D"])
def test_the_same_jump_in_mujoco(bending: str, name: str) -> None:
    """Clearance within 0.1 mm of 90 mm, the closed loop within a micrometre."""
    leg = replace(HopperLeg(), bending=bending)
    ours = simulate([(leg, motor())], GROUND, MODELS[name], tolerance=1e-6)[0]
    theirs = mujoco_jump(leg, motor(), GROUND, MODELS[name])
    assert theirs.closure_gap < 1e-6
    assert theirs.outcome.clearance == pytest.approx(ours.clearance, abs=1e-4)
    assert theirs.outcome.rise == pytest.approx(ours.rise, abs=1e-4)
    assert theirs.outcome.takeoff_time == pytest.approx(ours.takeoff_time, abs=2e-4)
    assert theirs.outcome.peak_gear_torque == pytest.approx(ours.peak_gear_torque, rel=0.005)
    assert theirs.outcome.energy == pytest.approx(ours.energy, rel=0.01)


def test_mujoco_keeps_the_momentum_of_a_short_leg_in_flight() -> None:
    """Pressed on its stop by the motors, the straight leg of 60 mm links lost 1 % of its weight in each second."""
    leg = HopperLeg().with_length(0.06)
    own = motor(100)
    found = mujoco_jump(leg, own, GROUND, MODELS["A"])
    flying = found.trace[:, 0] > found.outcome.takeoff_time + 0.01
    momentum = found.trace[flying, 4] + leg.gravity * found.trace[flying, 0]
    assert np.ptp(momentum) < 1e-6
    ours = simulate([(leg, own)], GROUND, MODELS["A"], tolerance=1e-6)[0]
    assert found.outcome.clearance == pytest.approx(ours.clearance, abs=1e-5)


@pytest.mark.parametrize(("times", "crosses"), [(1.0, False), (60.0, True)])
def test_a_leg_that_goes_through_its_stop_does_not_jump(times: float, crosses: bool) -> None:
    """Knees that cross, in either engine: a leg of 300 mm links was said to clear 1.1 m, folded inside out."""
    leg, usual = HopperLeg().with_length(0.12), motor()
    strong = replace(usual, stall_torque=times * usual.stall_torque, torque_limit=None)
    limits = [
        simulate([(leg, strong)], GROUND, MODELS["A"])[0].limit,
        mujoco_jump(leg, strong, GROUND, MODELS["A"]).outcome.limit,
    ]
    assert limits == 2 * ["goes through its stop: the knees cross" if crosses else ""]


@pytest.mark.parametrize(("rate", "damping", "duration"), [(0.0229183, 0.0, 0.2), (0.2, 0.00025, 0.3)])
def test_a_sprung_four_bar_dropped_on_the_ground(rate: float, damping: float, duration: float) -> None:
    """Links on flexures fall 50 mm, land and rebound: height of the hips and of the foot through it all."""
    leg = replace(HopperLeg(), flexures=Flexures(rate=rate, damping=damping), crouch=0.5, extended=0.05)
    model = MODELS["D"]
    theirs = mujoco_jump(leg, motor(), GROUND, model, drop=Drop(0.05, duration), step=2.5e-5)
    layout = LAYOUTS["upper"]
    z = lane(leg, motor(), GROUND, model)
    for name in ("linear_torque", "torque_slope", "linear_current", "current_slope"):
        z[layout.row(name)] = 0.0
    z[layout.row("height")] = leg.height(leg.crouch) + 0.05
    trace = compiled_jump("upper").trace(z, tolerance=1e-7, duration=duration, fall=99.0)
    end = min(trace[-1, 0], theirs.trace[-1, 0])
    times = np.linspace(0.0, end, 200)
    for row, column in ((layout.row("height"), 1), (layout.row("foot"), 3)):
        ours = np.interp(times, trace[:, 0], trace[:, 1 + row])
        other = np.interp(times, theirs.trace[:, 0], theirs.trace[:, column])
        assert np.abs(ours - other).max() < 2e-4
    assert theirs.trace[:, 3].min() < -1e-4


def test_a_long_flight_in_mujoco() -> None:
    """On the moon, at 1.62 m/s^2, rising takes over a second; the push alone has a limit of one."""
    leg = replace(HopperLeg(), bending="none", gravity=1.62)
    strong = motor_of(catalogue().find_motor("N20 HP 6V 150:1"), MotorOptions(supply=9.0))
    ours = simulate([(leg, strong)], GROUND, MODELS["A"])[0]
    theirs = mujoco_jump(leg, strong, GROUND, MODELS["A"], step=5e-5)
    assert theirs.trace[-1, 0] > 1.0
    assert theirs.outcome.limit == ""
    assert theirs.outcome.clearance == pytest.approx(ours.clearance, rel=0.01)
    weak = motor_of(catalogue().find_motor("N20 HP 6V 1000:1"), MotorOptions(supply=2.0))
    held = mujoco_jump(replace(leg, bending="none"), weak, GROUND, MODELS["A"], step=5e-5)
    assert held.outcome.limit.startswith("too weak")
    assert held.trace[-1, 0] < 1.001


def test_models_a_and_c_differ_by_the_contact() -> None:
    """On MuJoCo's own contact the same leg jumps about a tenth higher.

    Its default constraint gives way by 1.9 mm under the push, ours by 0.4 mm, and gives the energy back as the leg
    leaves. That our linear law pulls is not it: without damping, so without pull, A's clearance rises by half a per
    cent; on a ground as soft as MuJoCo's, without pull, it rises too.
    """
    same = mujoco_jump(HopperLeg(), motor(), GROUND, MODELS["A"])
    own = mujoco_jump(HopperLeg(), motor(), GROUND, MODELS["A"], ground="own")
    assert 1.05 < own.outcome.clearance / same.outcome.clearance < 1.2
    assert own.trace[:, 3].min() < -1.5e-3
    assert same.trace[:, 3].min() > -0.5e-3
    design = [(HopperLeg(), motor())]
    hard = simulate(design, GROUND, MODELS["A"])[0].clearance
    loose = simulate(design, Contact(damping=0.0), MODELS["A"])[0].clearance
    soft = simulate(design, Contact(stiffness=1e3), replace(MODELS["A"], hunt_crossley=True))[0].clearance
    assert loose == pytest.approx(hard, rel=0.01)
    assert soft > 1.04 * hard


def test_without_mujoco_the_message_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(UserError, match="pip install"):
        mujoco_jump(HopperLeg(), motor(), GROUND, MODELS["A"])


def test_rotor_inertia_through_the_gear_is_mujocos_armature() -> None:
    """The linear motor with a rotor's reflected inertia and no loss, in both engines: what A lacks and B has."""
    leg, own, model = HopperLeg(), motor(), MODELS["A"]
    layout = LAYOUTS["upper"]
    z = lane(leg, own, GROUND, model)
    z[layout.row("rotor_inertia")] = own.reflected_inertia
    ours = outcome_of(compiled_jump("upper").run(z[:, None], tolerance=1e-6)[:, 0])
    armature = f'armature="{own.reflected_inertia!r}" '
    original = mujoco_model.mjcf

    def with_armature(*arguments: object) -> str:
        text = original(*arguments)  # type: ignore[arg-type]
        for name in ("r0", "l0"):
            text = text.replace(f'<joint name="{name}" ', f'<joint name="{name}" {armature}')
        return text

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(mujoco_model, "mjcf", with_armature)
        theirs = mujoco_jump(leg, own, GROUND, model).outcome
    without = simulate([(leg, own)], GROUND, model)[0].clearance
    assert theirs.clearance == pytest.approx(ours.clearance, abs=1e-4)
    assert theirs.rise == pytest.approx(ours.rise, abs=1e-4)
    assert ours.clearance < 0.7 * without


def test_model_b_with_a_light_rotor_and_a_fast_winding_is_model_a() -> None:
    """The maker's line is the limit of B: they differ only by its time constants."""
    light = replace(motor(), rotor_inertia=1e-14, inductance=2e-5)
    b = simulate([(HopperLeg(), light)], GROUND, MODELS["B"])[0]
    a = simulate([(HopperLeg(), motor())], GROUND, MODELS["A"])[0]
    assert b.clearance == pytest.approx(a.clearance, rel=0.005)
    assert b.energy == pytest.approx(a.energy, rel=0.02)


def test_the_checks_of_one_clearance_are_told_apart() -> None:
    """Two rows "clearance by model A, foot" had other expected values: those of MuJoCo and of the planar form."""
    leg, drive = HopperLeg(), motor()
    by_planar, by_mujoco = upright(leg, drive, Contact(), "A"), same_jump(leg, drive, Contact())
    assert (by_planar.name, by_planar.where) != (by_mujoco.name, by_mujoco.where)
    assert by_planar.passed
    assert by_mujoco.passed
