"""Each effect of the motor leg in a case whose answer is known without it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hopper.hoppers import motor
from synth.arrays import Array
from synth.hopper.fold import fold, leg_parameters, mechanics, parameters_of
from synth.jump.effects import MotorEffect, motor_effect_named, motor_effects
from synth.jump.hopper_leg import Contact, HopperLeg
from synth.jump.jump_lanes import JumpLanes
from synth.jump.jump_models import MODELS, columns, lane
from synth.jump.jump_runs import compiled_jump
from synth.jump.outcomes import outcome_of
from synth.jump.planar_jump import planar_record
from synth.swing.effects import registered

NAMES = {  # and places, as the file formats have them
    "winding_inductance": "hip", "voltage_sag": "hip", "torque_constant": "hip", "gear_friction": "hip",
    "joint_damping": "all", "ground_slip": "base", "ground_compliance": "base",
}  # fmt: skip
LEG = HopperLeg()


def made(model: str = "full", **effects: dict[str, float]) -> JumpLanes:
    """One lane with effects in."""
    jumps = columns(LEG, motor(), Contact(), MODELS[model], np.array([LEG.length]))
    for name, values in effects.items():
        effect = motor_effect_named(name)
        given = [np.array([values.get(p.name, effect.defaults[p.name])]) for p in effect.parameters]
        effect.function("change")(jumps, *given)
    return jumps


def trace(jumps: JumpLanes) -> dict[str, Array]:
    """Time and the compared quantities of a jump."""
    jumper = compiled_jump(LEG.bending)
    rows = jumper.trace(jumps.workspace()[:, 0], tolerance=1e-6)
    names = ("angle", "normal", "drawn", "gear_torque", "foot")
    return {"time": rows[:, 0], **{name: rows[:, 1 + jumper.layout.row(name)] for name in names}}


def clearance(jumps: JumpLanes) -> float:
    return outcome_of(compiled_jump(LEG.bending).run(jumps.workspace(), 1e-5)[:, 0]).clearance


def test_effects_are_those_of_the_file_formats_and_share_the_drive_s_names_only() -> None:
    """A servo's and a jumping leg's motor have three names in common; each has its own law for them."""
    assert {effect.name: effect.place for effect in motor_effects()} == NAMES
    shared = {effect.name for effect in registered()} & set(NAMES)
    assert shared == {"gear_friction", "torque_constant", "voltage_sag"}


@pytest.mark.parametrize("effect", motor_effects(), ids=lambda effect: effect.name)
@pytest.mark.parametrize("model", ["A", "full"])
def test_switched_off_it_changes_nothing(effect: MotorEffect, model: str) -> None:
    np.testing.assert_array_equal(made(model, **{effect.name: {}}).workspace(), made(model).workspace())
    assert made(model, **{effect.name: {}}).ground_friction == made(model).ground_friction


@pytest.mark.parametrize("effect", motor_effects(), ids=lambda effect: effect.name)
def test_every_effect_is_documented(effect: MotorEffect) -> None:
    assert effect.meaning
    assert effect.phrase
    assert effect.formula
    assert effect.source
    assert all(p.unit and p.meaning and p.prior is not None for p in effect.parameters)
    assert {name for shape in effect.shapes for name in shape.free} == {p.name for p in effect.parameters}


def test_current_rises_with_the_time_constant_of_inductance_and_resistance() -> None:
    """At first the link hardly turns: i = V/R (1 - exp(-t R/L))."""
    own, more = motor().inductance, 8e-3
    found = trace(made(winding_inductance={"inductance": more}))
    early = found["time"] < 1.5e-3
    time_constant = (own + more) / motor().resistance
    wanted = 2 * motor().voltage / motor().resistance * (1.0 - np.exp(-found["time"][early] / time_constant))
    np.testing.assert_allclose(found["drawn"][early], wanted, atol=0.01 * wanted.max())


def test_a_winding_of_tiny_inductance_moves_like_the_makers_line() -> None:
    tiny = trace(made("A", winding_inductance={"inductance": 1e-5}))
    line = trace(made("A"))
    at = np.linspace(0.002, 0.05, 40)
    for name, tolerance in (("angle", 1e-3), ("drawn", 5e-3), ("gear_torque", 2e-3)):
        a, b = (np.interp(at, t["time"], t[name]) for t in (tiny, line))
        np.testing.assert_allclose(a, b, atol=tolerance * max(1.0, np.abs(b).max()))


@pytest.mark.parametrize("model", ["A", "B", "full"])
def test_a_sagging_supply_is_resistance_in_both_windings(model: str) -> None:
    """Twice the supply's: both motors' current is in it. At stall V R / (R + 2 R_s) is left."""
    jumps = made(model, voltage_sag={"resistance": 0.5})
    first = trace(jumps)["gear_torque"][0] if model == "A" else None
    if first is not None:
        resistance = motor().voltage / motor().stall_current
        assert first == pytest.approx(motor().stall_torque * resistance / (resistance + 1.0), rel=1e-9)
    else:
        other = replace(motor(), resistance=motor().resistance + 1.0)
        stiffer = columns(LEG, other, Contact(), MODELS[model], np.array([LEG.length]))
        np.testing.assert_allclose(jumps.workspace(), stiffer.workspace(), rtol=1e-14)
    assert clearance(jumps) < 0.8 * clearance(made(model))


def test_torque_and_back_emf_change_together() -> None:
    jumps = made("A", torque_constant={"share": -0.2})
    assert jumps.stall_torque[0] == pytest.approx(0.8 * motor().stall_torque)
    assert jumps.no_load_speed[0] == pytest.approx(motor().no_load_speed / 0.8)
    power = jumps.stall_torque[0] * jumps.no_load_speed[0]
    assert power == pytest.approx(motor().stall_torque * motor().no_load_speed)
    electric = made("full", torque_constant={"share": -0.2})
    assert electric.torque_constant[0] / electric.back_emf[0] == pytest.approx(1.0)


def test_friction_of_the_stall_torque_holds_the_leg() -> None:
    at_rotor = motor().stall_torque / motor().gear_ratio
    stuck = trace(made("A", gear_friction={"torque": 1.001 * at_rotor}))
    assert np.ptp(stuck["angle"]) < np.radians(3.0)  # it creeps at the speed over which friction turns over


def test_a_lossy_gear_transmits_the_stated_share() -> None:
    found = trace(made("A", gear_friction={"loss": 0.3}))
    speed = -np.gradient(found["angle"], found["time"])
    driven = (speed > 1.0) & (found["time"] < 0.04)  # the motor drives the link
    line = motor().stall_torque * (1.0 - speed / motor().no_load_speed)
    np.testing.assert_allclose(found["gear_torque"][driven], 0.7 * line[driven], rtol=0.01)


def test_joint_damping_is_the_flexures() -> None:
    damped = replace(LEG, flexures=replace(LEG.flexures, damping=LEG.flexures.damping + 4e-4))
    wanted = lane(damped, motor(), Contact(), MODELS["full"])
    np.testing.assert_allclose(made(joint_damping={"damping": 4e-4}).workspace()[:, 0], wanted, rtol=1e-14)


def test_a_ground_as_soft_as_the_contact_doubles_the_deflection() -> None:
    soft, hard = made(ground_compliance={"stiffness": Contact().stiffness}), made()
    weight = LEG.total_mass(motor()) * LEG.gravity
    layout = soft.layout
    sag = [LEG.height(LEG.start) - jumps.workspace()[layout.row("height"), 0] for jumps in (soft, hard)]
    assert sag == pytest.approx([2 * weight / Contact().stiffness, weight / Contact().stiffness])


def test_on_ice_the_foot_slides_and_the_centre_of_mass_stays_over_its_place() -> None:
    """Without friction nothing pushes sideways; with enough of it the foot stays."""
    times = np.linspace(0.0, 0.045, 46)

    def slide(friction: float) -> float:
        jumps = made(ground_slip={"friction": friction})
        told = planar_record(jumps, LEG.body_inertia, 1e-3, np.radians(8.0), times, 1e-6)
        return float(told["slide"][-1])

    grips, slides = slide(0.7), slide(1e-6)
    assert abs(grips) < 5e-4
    assert slide(0.08) > 10 * abs(grips)
    height = LEG.height(LEG.start)
    assert slides > 0.3 * height * np.sin(np.radians(8.0))  # it goes under the centre of mass, and past as it tips


def test_a_pull_up_of_a_design_is_that_of_its_jumping_leg() -> None:
    leg = HopperLeg(bending="none")
    jumps = columns(leg, motor(), Contact(), MODELS["full"], np.array([leg.length]))
    parameters = leg_parameters(leg, float(jumps.body_mass[0]), np.array([leg.flexures.damping]))
    np.testing.assert_allclose(parameters, parameters_of(jumps), rtol=1e-12)
    time = np.arange(0.0, 0.4, 1e-3)
    torque = 0.05 * (1.0 + 0.5 * np.sin(20.0 * time))
    closed = fold(parameters, time, torque, np.array([np.radians(15.0)]), np.zeros(1))[:, 0]
    assert np.ptp(closed) > np.radians(5.0)


def test_a_pull_up_of_no_torque_and_damping_keeps_its_energy() -> None:
    """And the tables' slopes are those of their inertia: M a'^2 / 2 + V is constant."""
    leg = HopperLeg(bending="none")
    parameters = leg_parameters(leg, 0.05, np.zeros(1))
    time = np.linspace(0.0, 0.2, 2001)
    angle = fold(parameters, time, np.zeros(len(time)), np.array([np.radians(30.0)]), np.zeros(1))[:, 0]
    inertia, slope, force, _ = mechanics(angle, parameters[:, 0])
    rate = np.gradient(angle, time)
    potential = np.concatenate([[0.0], np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(angle))])
    energy = (0.5 * inertia * rate**2 + potential)[2:-2]
    assert np.ptp(energy) < 1e-3 * np.ptp(potential)
    np.testing.assert_allclose(
        slope[2:-2] * rate[2:-2], np.gradient(inertia, time)[2:-2], atol=2e-3 * np.abs(slope * rate).max()
    )
