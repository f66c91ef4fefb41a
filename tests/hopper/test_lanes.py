"""The compiled jump against closed forms, conservation laws and the planar form with its own equations."""

from __future__ import annotations

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest

from hopper.hoppers import catalogue, motor
from synth.hopper.motors import motor_of
from synth.jump import outcomes
from synth.jump import planar_jump as planar
from synth.jump.hopper_leg import Contact, Flexures, HopperLeg, Laminate, MotorOptions
from synth.jump.jump_layout import LAYOUTS
from synth.jump.jump_models import MODELS, Model, columns, lane, lanes
from synth.jump.jump_runs import TOLERANCE, compiled_jump, simulate
from synth.jump.planar_jump import planar_jump
from synth.model_checks.jumping import energy_of

GROUND = Contact()
LOOSE = Flexures(rate=0.0, damping=0.0)


def test_the_rows_of_an_outcome_have_the_names_that_they_are_listed_under() -> None:
    assert [getattr(outcomes, name.upper()) for name in outcomes.OUTCOMES] == list(range(outcomes.N_OUTCOME))


@pytest.mark.parametrize(("ratio", "variant"), [(75, "HPCB"), (100, "HP"), (150, "HPCB")])
def test_a_peak_torque_lies_between_the_steps(ratio: int, variant: str) -> None:
    """Against steps a tenth as long; at the ends of the steps alone it was up to 1.5 % too low, and never too high.

    The HPCB 150:1 with links of 84 mm was within its gearbox's limit by that.
    """
    leg, own = HopperLeg(crouch=np.radians(39.0), extended=np.radians(10.0)), motor(ratio, variant)
    length = np.arange(0.044, 0.2001, 0.004)
    designs = lanes(leg, own, GROUND, MODELS["full"], length)
    usual, fine = (compiled_jump("upper").run(designs, tolerance) for tolerance in (TOLERANCE, 1e-6))
    assert (usual[outcomes.STATUS] == outcomes.LANDED_AGAIN).all()
    peaks = usual[outcomes.PEAK_GEAR_TORQUE]
    np.testing.assert_allclose(peaks, fine[outcomes.PEAK_GEAR_TORQUE], rtol=5e-3)
    if (ratio, variant) == (150, "HPCB"):
        assert own.torque_limit is not None
        assert peaks[np.argmin(np.abs(length - 0.084))] > own.torque_limit


def unpowered(leg: HopperLeg, contact: Contact = GROUND) -> np.ndarray:
    """A lane of model A with the motors gone."""
    layout = LAYOUTS[leg.bending]
    z = lane(leg, motor(), contact, MODELS["A"])
    for name in ("linear_torque", "torque_slope", "linear_current", "current_slope"):
        z[layout.row(name)] = 0.0
    return z


@pytest.mark.parametrize("bending", LAYOUTS)
def test_a_dropped_leg_without_losses_keeps_its_energy(bending: str) -> None:
    """Flight, landing on a lossless ground, rebound: springs, bending and the ground give back all they take."""
    leg = replace(HopperLeg(), bending=bending, crouch=0.5, extended=0.05)
    contact = Contact(damping=0.0)
    z = unpowered(leg, contact)
    z[LAYOUTS[bending].row("height")] += 0.05
    trace = compiled_jump(bending).trace(z, tolerance=1e-8, duration=0.16, fall=99.0)
    layout = LAYOUTS[bending]
    feet = trace[:, 1 + layout.row("foot")]
    assert feet[0] > 0.04
    assert feet.min() < -1e-4  # it did land
    e = energy_of(leg, motor(), trace, contact)
    assert np.ptp(e) < 2e-6 * 0.0489 * 9.81 * 0.2 + 2e-7


def test_free_fall_is_ballistic() -> None:
    """The centre of mass in the air falls by g t^2/2 whatever springs and links do."""
    leg = replace(HopperLeg(), crouch=0.5)
    z = unpowered(leg)
    layout = LAYOUTS["upper"]
    z[layout.row("height")] += 0.3
    trace = compiled_jump("upper").trace(z, duration=0.15, fall=99.0)
    t, com = trace[:, 0], trace[:, 1 + layout.row("com")]
    np.testing.assert_allclose(com - com[0], -0.5 * 9.81 * t**2, atol=2e-7)


def test_a_stiff_leg_bounces_like_a_pogo_stick() -> None:
    """With its joints stiff the leg is a mass on the ground's spring: half a period pi sqrt(m/k) of touch, and dips.

    Landing at speed v, x(t) = (v/w) sin wt - (g/w^2)(1 - cos wt) while touching, w = sqrt(k/m).
    """
    laminate = Laminate(bending_stiffness=1e3)
    leg = replace(
        HopperLeg(), bending="none", crouch=0.5, flexures=Flexures(1e4, 0.0, 0.5, 0.5, 0.0), laminate=laminate
    )
    b = leg.lower_angle(0.5)
    leg = replace(leg, flexures=replace(leg.flexures, knee_rest=0.5 + b, foot_rest=2 * b))
    contact = Contact(stiffness=200.0, damping=0.0)
    z = unpowered(leg, contact)
    layout = LAYOUTS["none"]
    mass, drop = leg.total_mass(motor()), 0.02
    z[layout.row("height")] = leg.height(0.5) + drop
    trace = compiled_jump("none").trace(z, tolerance=1e-7, duration=0.2, fall=99.0)
    foot = trace[:, 1 + layout.row("foot")]
    w, v = sqrt(200.0 / mass), sqrt(2 * 9.81 * drop)
    deepest = 9.81 / w**2 + sqrt((9.81 / w**2) ** 2 + (v / w) ** 2)
    assert -foot.min() == pytest.approx(deepest, rel=2e-3)
    touching = trace[foot < 0.0, 0]
    held = 2 * (pi - np.arctan2(v / w, 9.81 / w**2)) / w
    assert np.ptp(touching) == pytest.approx(held, rel=5e-3)


def test_the_crouch_rests_where_statics_says() -> None:
    """Torque that holds the weight: m g leverage / 2 a motor, flexures apart; with it nothing starts to move."""
    leg = replace(HopperLeg(), bending="none", flexures=LOOSE)
    layout = LAYOUTS["none"]
    light = replace(leg, laminate=replace(leg.laminate, mass_per_length=1e-9))
    z = unpowered(light)
    holding = light.total_mass(motor()) * 9.81 * light.leverage(light.crouch) / 2
    z[layout.row("linear_torque")] = holding
    compiled = compiled_jump("none")
    workspace = np.repeat(z[:, None], 16, axis=1)
    workspace[layout.row("alive")] = 1.0
    compiled.right_hand_side(workspace)
    acceleration = workspace[layout.row("derivative") + 1 + layout.n, 0]
    assert abs(acceleration) < 1e-3 * 9.81


@pytest.mark.parametrize("bending", LAYOUTS)
@pytest.mark.parametrize("name", ["A", "B", "D", "full"])
def test_planar_form_upright_is_the_symmetric_one(bending: str, name: str) -> None:
    """Multipliers on full coordinates against one side with the loop eliminated: nothing in common but parameters."""
    leg = replace(HopperLeg(), bending=bending, foot_mass=0.001, lower_ratio=1.1)
    symmetric = simulate([(leg, motor())], GROUND, MODELS[name], tolerance=1e-6)[0]
    planar = planar_jump(leg, motor(), GROUND, MODELS[name], tolerance=1e-6)
    assert planar.outcome.clearance == pytest.approx(symmetric.clearance, abs=2e-5)
    assert planar.outcome.rise == pytest.approx(symmetric.rise, abs=2e-5)
    assert planar.outcome.energy == pytest.approx(symmetric.energy, rel=5e-3)
    assert planar.outcome.peak_gear_torque == pytest.approx(symmetric.peak_gear_torque, rel=5e-3)
    assert planar.slip < 1e-5
    assert abs(planar.pitch) < 1e-6


def test_a_leaning_leg_pitches_slips_and_jumps_lower() -> None:
    found = [planar_jump(HopperLeg(), motor(), Contact(friction=mu), MODELS["full"], pitch=0.1) for mu in (0.7, 0.02)]
    upright = planar_jump(HopperLeg(), motor(), GROUND, MODELS["full"])
    assert all(jump.pitch > 0.1 for jump in found)
    assert found[0].outcome.clearance < upright.outcome.clearance
    assert found[1].slip > 5 * found[0].slip > 0


def test_the_outcome_is_independent_of_the_step_size() -> None:
    """At the tolerance in use, clearance within 0.1 mm of that with steps a thousandth as tolerant."""
    rng = np.random.default_rng(3)
    lengths, ratios = rng.uniform(0.06, 0.18, 64), rng.choice([75, 100, 150, 210, 250], 64)
    designs = [(HopperLeg(length=length), motor(ratio)) for length, ratio in zip(lengths, ratios, strict=True)]
    for name in ("A", "B", "D", "full"):
        usual = simulate(designs, GROUND, MODELS[name])
        fine = simulate(designs, GROUND, MODELS[name], tolerance=1e-7)
        assert max(abs(a.clearance - b.clearance) for a, b in zip(usual, fine, strict=True)) < 1e-4, name


def test_takeoff_is_where_the_foot_leaves_the_ground_and_not_the_last_step_on_it() -> None:
    """Two runs of the example's design differed by 0.15 % in energy, each by up to 0.2 % from one with fine steps."""
    leg, drive = HopperLeg(length=0.05), motor(75)
    for name in ("A", "full"):
        z = lane(leg, drive, GROUND, MODELS[name])[:, None]
        fine = compiled_jump("upper").run(z, tolerance=1e-8)[:, 0]
        beside = np.hstack([z, lane(replace(leg, structure_mass=0.01), drive, GROUND, MODELS[name])[:, None]])
        for found in (compiled_jump("upper").run(z)[:, 0], compiled_jump("upper").run(beside)[:, 0]):
            for row in (outcomes.TAKEOFF_TIME, outcomes.TAKEOFF_SPEED, outcomes.TAKEOFF_HEIGHT, outcomes.ENERGY):
                assert found[row] == pytest.approx(fine[row], rel=2e-4), (name, outcomes.OUTCOMES[row])
    planar_form = planar_jump(leg, drive, GROUND, MODELS["full"]).outcome
    assert planar_form.energy == pytest.approx(fine[outcomes.ENERGY], rel=2e-4)
    assert planar_form.takeoff_time == pytest.approx(fine[outcomes.TAKEOFF_TIME], rel=2e-4)


@pytest.mark.parametrize("name", ["A", "D"])
def test_a_leg_that_has_lifted_is_not_too_weak_when_it_passes_through_rest(name: str) -> None:
    """It lifts by 3.9 mm and comes down as its centre of mass stands: at rest for a moment, or for good."""
    leg, drive = HopperLeg(length=0.05), motor_of(catalogue().find_motor("20D 12V 312.5:1"))
    found = simulate([(leg, drive)], GROUND, MODELS[name])[0]
    assert found.limit == ""
    assert found.clearance == pytest.approx(0.0038, abs=2e-4)


def test_a_lane_does_not_depend_on_its_neighbours_beyond_the_tolerance() -> None:
    designs = [(replace(HopperLeg(), length=0.06 + 0.006 * i), motor()) for i in range(16)]
    together = simulate(designs, GROUND, MODELS["full"])
    alone = [simulate([design], GROUND, MODELS["full"])[0] for design in designs]
    assert max(abs(a.clearance - b.clearance) for a, b in zip(together, alone, strict=True)) < 1e-4


def test_a_leg_that_is_too_stiff_leaves_its_neighbours_alone() -> None:
    usual, tiny = HopperLeg(bending="all"), HopperLeg(length=0.005, hip_spacing=0.002, bending="all")
    stiff, *others = simulate([(tiny, motor()), *[(usual, motor())] * 3], GROUND, MODELS["A"])
    alone = simulate([(usual, motor())], GROUND, MODELS["A"])[0]
    assert stiff.limit.startswith("too stiff")
    assert others == [alone] * 3
    assert alone.clearance > 0.03


def test_the_planar_form_has_the_lanes_limit_of_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(planar, "MAX_STEPS", 10)
    found = planar_jump(HopperLeg(), motor(), GROUND, MODELS["full"])
    assert found.outcome.limit.startswith("too stiff")
    assert len(found.trace) <= 10


def test_height_is_insensitive_to_the_ground() -> None:
    """The contact's constants are not known; a tenth or ten times of each moves the clearance by less than 6 %."""
    usual = simulate([(HopperLeg(), motor())], GROUND, MODELS["full"])[0].clearance
    for contact in (
        Contact(stiffness=3e3),
        Contact(stiffness=3e4),
        Contact(dissipation=0.5),
        Contact(dissipation=50.0),
    ):
        found = simulate([(HopperLeg(), motor())], contact, MODELS["full"])[0].clearance
        assert found == pytest.approx(usual, rel=0.06)


def test_hunt_crossley_never_pulls_and_the_linear_law_does() -> None:
    layout = LAYOUTS["upper"]
    least = {}
    for name in ("A", "full"):
        trace = compiled_jump("upper").trace(lane(HopperLeg(), motor(), GROUND, MODELS[name]))
        least[name] = trace[:, 1 + layout.row("normal")].min()
    assert least["full"] == 0.0
    assert least["A"] < -0.01


def test_a_leg_that_cannot_jump_is_reported() -> None:
    weak = replace(motor(), stall_torque=0.01)
    folded = simulate([(HopperLeg(), weak)], GROUND, MODELS["A"])[0]
    assert folded.limit.startswith("too weak")
    assert folded.clearance == 0.0
    tiny = HopperLeg(length=0.005, hip_spacing=0.002, bending="all")  # links that swing at 200 kHz
    found = simulate([(tiny, motor())], GROUND, MODELS["A"])[0]
    assert found.clearance == 0.0
    assert found.limit.startswith("too stiff")


@pytest.mark.parametrize("bending", LAYOUTS)
def test_a_flight_on_the_moon_may_take_longer_than_a_push(bending: str) -> None:
    """At 1.62 m/s^2 a takeoff at 1.5 m/s rises for 0.9 s: the rise is the takeoff's height and v^2 / (2 g)."""
    leg = replace(HopperLeg(), bending=bending, gravity=1.62)
    strong = motor_of(catalogue().find_motor("N20 HP 6V 150:1"), MotorOptions(supply=9.0))
    for name in ("A", "full"):
        z = lane(leg, strong, GROUND, MODELS[name])
        jumper = compiled_jump(bending)
        found = jumper.run(z[:, None])[:, 0]
        jump = outcomes.outcome_of(found)
        assert jump.limit == ""
        assert jump.takeoff_speed > 1.4
        assert found[outcomes.END_TIME] > 1.0
        pushed = found[outcomes.TAKEOFF_HEIGHT] - found[outcomes.START_COM]
        assert jump.rise == pytest.approx(pushed + jump.takeoff_speed**2 / (2 * 1.62), rel=5e-3)
        assert jumper.trace(z)[-1, 0] > 1.0
        assert jumper.trace(z, duration=0.5)[-1, 0] < 0.51
    planar = planar_jump(leg, strong, GROUND, MODELS["full"]).outcome
    assert planar.limit == ""
    assert planar.clearance == pytest.approx(jump.clearance, rel=2e-3)


def test_a_push_still_has_one_second() -> None:
    """A leg that pushes its weight slowly, by a motor at a third of its voltage, has not lifted by then."""
    slow = motor_of(catalogue().find_motor("N20 HP 6V 1000:1"), MotorOptions(supply=2.0))
    for gravity in (9.81, 1.62):
        leg = replace(HopperLeg(), gravity=gravity)
        jump = simulate([(leg, slow)], GROUND, MODELS["full"])[0]
        assert jump.limit.startswith("too weak")
        assert planar_jump(leg, slow, GROUND, MODELS["full"]).outcome.limit.startswith("too weak")


def test_what_a_model_includes_is_named_and_each_model_includes_what_it_says() -> None:
    """Four switches in a row can be exchanged without a word."""
    with pytest.raises(TypeError):
        Model("E", "everything", "lanes", True, True)  # type: ignore[misc]
    switches = ("electric", "joint_damping", "gear_loss", "hunt_crossley")
    included = {name: {each for each in switches if getattr(model, each)} for name, model in MODELS.items()}
    assert included == {
        "point_mass": set(), "A": set(), "B": {"electric"}, "C": set(), "D": {"joint_damping"}, "full": {*switches},
    }  # fmt: skip
    leg, own, contact = HopperLeg(), motor(), Contact()
    made = {name: columns(leg, own, contact, model, np.array([0.1])) for name, model in MODELS.items()}
    assert [name for name, each in made.items() if each.electric] == ["B", "full"]
    assert [name for name, each in made.items() if each.inductance[0] > 0.0] == ["B", "full"]
    assert [name for name, each in made.items() if each.joint_damping[0] > 0.0] == ["D", "full"]
    assert [name for name, each in made.items() if each.driving[0] < 1.0] == ["full"]
    assert [name for name, each in made.items() if not each.may_pull] == ["full"]
    assert [name for name, each in made.items() if each.contact_damping[0] == 0.0] == ["full"]


@pytest.mark.parametrize("name", ["20D 12V 250:1", "20D 6V 250:1"])
def test_a_slow_leg_that_lifts_its_foot_twice_takes_off_for_the_greater_height(name: str) -> None:
    """The foot is up 1 to 3 mm at 0.05 s, on the ground again from 0.09 to 0.11 s, and then up 15 mm.

    Against the planar form, and ballistics: the centre of mass rises by v^2/2g from there.
    """
    own = motor_of(catalogue().find_motor(name))
    found = compiled_jump("upper").run(lanes(HopperLeg(), own, GROUND, MODELS["full"], np.array([0.2])))[:, 0]
    other = planar_jump(HopperLeg().with_length(0.2), own, GROUND, MODELS["full"]).outcome
    outcome = outcomes.outcome_of(found)
    assert outcome.takeoff_time > 0.1
    assert outcome.takeoff_time == pytest.approx(other.takeoff_time, abs=5e-5)
    assert outcome.takeoff_speed == pytest.approx(other.takeoff_speed, rel=1e-3)
    assert outcome.energy == pytest.approx(other.energy, rel=1e-3)
    rise = found[outcomes.TAKEOFF_HEIGHT] - found[outcomes.START_COM] + outcome.takeoff_speed**2 / (2.0 * 9.81)
    assert rise == pytest.approx(outcome.rise, abs=2e-4)


@pytest.mark.parametrize(
    ("model", "name", "length", "first", "peak"),
    [("full", "20D 12V 250:1", 0.13, 0.617, 2.25), ("B", "20D 6V 195.31:1", 0.18, 0.633, 3.04)],
)
def test_the_push_of_a_leg_that_lifts_its_foot_twice_ends_at_takeoff(
    model: str, name: str, length: float, first: float, peak: float
) -> None:
    """The gear's torque of the second push, 3.6 and 4.8 times that until the foot first lifted.

    Against a finer trace of the leg and the planar form.
    """
    leg, own = HopperLeg().with_length(length), motor_of(catalogue().find_motor(name))
    jumper, design = compiled_jump("upper"), lane(leg, own, GROUND, MODELS[model])
    outcome = outcomes.outcome_of(jumper.run(design[:, None])[:, 0])
    trace, layout = jumper.trace(design, 1e-5), jumper.layout
    torque, foot = np.abs(trace[:, 1 + layout.row("gear_torque")]), trace[:, 1 + layout.row("foot")]
    lifted = int(np.argmax(foot > outcomes.LIFTED))
    assert torque[:lifted].max() == pytest.approx(first, rel=0.01)
    assert torque[trace[:, 0] <= outcome.takeoff_time].max() == pytest.approx(peak, rel=0.01)
    assert outcome.peak_gear_torque == pytest.approx(peak, rel=0.01)
    other = planar_jump(leg, own, GROUND, MODELS[model]).outcome
    assert outcome.peak_gear_torque == pytest.approx(other.peak_gear_torque, rel=0.02)
    assert outcome.peak_current == pytest.approx(other.peak_current, rel=1e-3)


def test_a_leg_that_hops_and_then_stands_up_has_the_height_of_its_hop() -> None:
    """Its foot rises by 2 mm, its centre of mass by 26 mm; standing, 0.9 s later, it is 98 mm above the crouch."""
    leg, own = HopperLeg().with_length(0.2), motor_of(catalogue().find_motor("25D LP 6V 498.87:1"))
    jumper, design = compiled_jump("upper"), lane(leg, own, GROUND, MODELS["full"])
    found = jumper.run(design[:, None])[:, 0]
    trace, layout = jumper.trace(design, 1e-5), jumper.layout
    risen = trace[:, 1 + layout.row("com")] - trace[0, 1 + layout.row("com")]
    assert risen.max() == pytest.approx(0.098, abs=1e-3)
    assert found[outcomes.APEX] == pytest.approx(0.0262, abs=3e-4)
    hop = found[outcomes.TAKEOFF_HEIGHT] - found[outcomes.START_COM] + found[outcomes.TAKEOFF_SPEED] ** 2 / (2.0 * 9.81)
    assert found[outcomes.APEX] == pytest.approx(hop, abs=1e-3)  # while its links swing in the flight
    other = planar_jump(leg, own, GROUND, MODELS["full"]).outcome
    assert found[outcomes.APEX] == pytest.approx(other.rise, abs=3e-4)


def test_the_rise_of_a_jump_ends_with_its_landing() -> None:
    foot = np.array([-1e-5, 5e-4, -1e-5, 2e-3, 4e-3, 1e-3, -1e-5, 2e-3, -1e-5])
    rise = np.array([0.0, 1.0, 1.2, 2.0, 3.0, 2.5, 2.2, 4.0, 5.0])
    assert outcomes.rise_of_jump(rise, foot, 0.0) == 3.0
    assert outcomes.rise_of_jump(rise, 0.1 * foot, 0.0) == 5.0  # it does not lift
