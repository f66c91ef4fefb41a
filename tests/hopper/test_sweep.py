"""Sweep, front and intervals as functions, the basis of the command's result."""

from __future__ import annotations

import threading
import time
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hopper.hoppers import catalogue, motor
from synth import threads
from synth.arrays import Array
from synth.errors import UserError
from synth.hopper import sweep as sweeping
from synth.hopper.hopper_tolerances import (
    QUANTITIES,
    UNIFORM,
    contributions,
    copies,
    groups,
    half_width,
    intervals,
    outcomes_of_copies,
)
from synth.hopper.motors import chosen_rows, estimates_of, motor_of, with_loss, with_speed, with_torque
from synth.hopper.study import _neighbours
from synth.hopper.sweep import OBJECTIVES, SweepProblem, pareto_front, run_sweep
from synth.hopper.write_study import _map
from synth.jump.hopper_leg import Contact, HopperLeg, HopperTolerances, MotorOptions, lower_angles
from synth.jump.jump_models import MODELS, lane
from synth.jump.jump_runs import compiled_jump, simulate
from synth.jump.outcomes import CLEARANCE, LANDED_AGAIN, N_OUTCOME, STATUS, TOO_STIFF, known_heights, outcome_of
from synth.jump.point_mass import point_mass_outcomes


def problem(
    model: str = "full", lengths: tuple[float, ...] = (0.06, 0.09, 0.12, 0.15), everywhere: bool = False
) -> SweepProblem:
    motors = tuple(motor(ratio) for ratio in (75, 100, 150, 210))
    return SweepProblem(HopperLeg(), motors, (HopperTolerances(),) * 4, lengths, Contact(), MODELS[model], everywhere)


def test_intervals_are_what_random_draws_give() -> None:
    """2 000 draws of every tolerance at once: their 5 and 95 % ends against the first-order interval.

    Speed and current are uniform within a maker's limits; the limits' half widths are the tolerances.
    """
    leg, own, speed, current = HopperLeg(), motor(), 0.2, 0.5
    t = HopperTolerances(speed=half_width(speed), current=half_width(current))
    rng = np.random.default_rng(11)
    columns = []
    z90 = 1.6449
    for _ in range(2000):
        changed = with_speed(own, 1 + speed * rng.uniform(-1, 1))
        changed = with_torque(changed, 1 + t.torque / z90 * rng.normal())
        inertia = own.rotor_inertia * (1 + t.rotor_inertia) ** (rng.normal() / z90)
        changed = replace(with_loss(changed, 1 + current * rng.uniform(-1, 1)), rotor_inertia=inertia)
        mass = leg.structure_mass + t.mass / z90 * rng.normal() * (leg.structure_mass + 2 * own.mass)
        damping = max(0.0, leg.flexures.damping * (1 + t.joint_damping / z90 * rng.normal()))
        body = replace(leg, structure_mass=mass, crouch=leg.crouch + t.crouch / z90 * rng.normal(),
                       flexures=replace(leg.flexures, damping=damping))  # fmt: skip
        columns.append(lane(body, changed, Contact(), MODELS["full"]))
    drawn = compiled_jump("upper").run(np.stack(columns, axis=1))[1]
    low, high = np.quantile(drawn, [0.05, 0.95])
    made = groups(leg, own, Contact(), MODELS["full"], t, np.array([leg.length]))[0]
    nominal, least, most = (float(x[0]) for x in intervals(compiled_jump("upper").run(made)[1][None, :]))
    assert low < nominal < high
    assert least == pytest.approx(low, abs=0.2 * (high - low))
    assert most == pytest.approx(high, abs=0.2 * (high - low))
    assert UNIFORM == 0.9


def test_a_copy_that_is_too_stiff_is_unknown_and_not_a_height_of_zero(monkeypatch: pytest.MonkeyPatch) -> None:
    found = np.zeros((N_OUTCOME, 16))
    found[STATUS], found[CLEARANCE] = LANDED_AGAIN, np.linspace(0.05, 0.06, 16)
    found[STATUS, 1 + QUANTITIES.index("rotor inertia")] = TOO_STIFF
    nominal, low, high = intervals(known_heights(found)[None, :])
    assert nominal[0] == 0.05
    assert np.isnan(low[0])
    assert np.isnan(high[0])
    assert list(contributions(known_heights(found))) == [name for name in QUANTITIES if name != "rotor inertia"]
    monkeypatch.setattr(sweeping.compiled_jump("upper").__class__, "run", lambda self, lanes: found)
    sweep = run_sweep(problem(everywhere=True))
    assert np.isnan(sweep.clearance_low).all()
    assert (sweep.values["clearance"] == 0.05).all()


@pytest.mark.parametrize("length", [0.043, 0.044])
def test_a_crouch_near_the_lock_is_simulated_where_the_links_reach_it_and_unknown_where_not(length: float) -> None:
    """A design is swept to 80 deg of its lower links; a copy beyond was left as it was, and added nothing."""
    leg = HopperLeg(length=length, crouch=np.radians(39.0))
    own, t = motor(75), HopperTolerances()
    found = known_heights(next(outcomes_of_copies(leg, own, Contact(), MODELS["full"], t, np.array([length]))))
    _, low, high = intervals(found[None, :])
    lower = np.degrees(lower_angles(replace(leg, crouch=leg.crouch + t.crouch), np.array([length])))
    if length == 0.043:
        assert np.isnan(lower[0])
        assert "crouch" not in contributions(found)
        assert np.isnan([low[0], high[0]]).all()
        return
    assert 80.0 < lower[0] < 87.0
    deeper = simulate([(replace(leg, crouch=leg.crouch + t.crouch), own)], Contact(), MODELS["full"])[0]
    assert contributions(found)["crouch"][1] == pytest.approx(deeper.clearance - found[0], abs=1e-4)
    assert deeper.clearance - found[0] > 0.01
    assert high[0] > deeper.clearance


def test_a_design_that_is_too_stiff_keeps_nothing_of_what_it_had_reached(monkeypatch: pytest.MonkeyPatch) -> None:
    """A total height of 85 cm and a relative one of 16.9 stood beside a clearance of 0."""
    found = np.ones((N_OUTCOME, 4))
    found[STATUS] = TOO_STIFF
    monkeypatch.setattr(sweeping.compiled_jump("upper").__class__, "run", lambda self, lanes: found)
    sweep = run_sweep(replace(problem(), height="total"))
    assert (sweep.status == TOO_STIFF).all()
    assert all((values == 0.0).all() for values in sweep.values.values())
    outcome = outcome_of(found[:, 0])
    assert not outcome.known
    assert (outcome.rise, outcome.energy, outcome.takeoff_speed) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("objectives", [["clearance"], ["clearance", "energy"], list(OBJECTIVES)])
def test_the_front_is_the_one_that_comparing_all_pairs_gives(objectives: list[str]) -> None:
    sweep = run_sweep(problem())
    allowed = sweep.feasible("warn")
    scores = np.stack([OBJECTIVES[name] * sweep.values[name] for name in objectives], axis=1)
    wanted = []
    for i in np.flatnonzero(allowed):
        others = [scores[k] for k in np.flatnonzero(allowed) if k != i]
        if not any(np.all(other >= scores[i]) and np.any(other > scores[i]) for other in others):
            wanted.append(int(i))
    assert sorted(pareto_front(sweep, objectives, allowed)) == wanted


def test_workers_and_intervals_do_not_change_a_design() -> None:
    alone, many = (run_sweep(problem(), workers=n).values["clearance"] for n in (1, 4))
    np.testing.assert_array_equal(alone, many)
    with_intervals = run_sweep(problem(everywhere=True))
    np.testing.assert_allclose(with_intervals.values["clearance"], alone, atol=1e-4)
    jumping = with_intervals.status == 1
    assert np.all(with_intervals.clearance_low[jumping] <= with_intervals.values["clearance"][jumping])


def test_chunks_are_counted_in_order_by_the_thread_that_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    """While four threads work, of which the later ones finish first."""
    monkeypatch.setenv(threads.VARIABLE, "4")
    threads._workers.cache_clear()
    monkeypatch.setattr(sweeping, "CHUNK", 2)
    whole = sweeping._chunk

    def chunk(problem: SweepProblem, index: int) -> Array:
        time.sleep(0.01 * (8 - index))
        return whole(problem, index)

    monkeypatch.setattr(sweeping, "_chunk", chunk)
    told: list[tuple[int, int]] = []
    callers = set()

    def progress(done: int, count: int) -> None:
        callers.add(threading.current_thread())
        time.sleep(0.03 if done % 2 else 0.0)
        told.append((done, count))

    try:
        found = run_sweep(problem("point_mass"), progress=progress)
    finally:
        threads._workers().shutdown()
        threads._workers.cache_clear()
    assert told == [(k, 8) for k in range(1, 9)]
    assert callers == {threading.current_thread()}
    monkeypatch.undo()
    np.testing.assert_array_equal(found.status, run_sweep(problem("point_mass")).status)


def test_a_length_out_of_reach_does_not_jump_and_has_a_reason() -> None:
    sweep = run_sweep(replace(problem(lengths=(0.03, 0.12))))
    assert not sweep.feasible("warn")[0]
    assert "out of the links' reach" in sweep.limit_text(0)
    assert sweep.limit_text(1) == ""


def test_the_point_mass_flies_as_high_as_its_speed_says() -> None:
    found = point_mass_outcomes(HopperLeg(), motor(), np.array([0.1, 0.14]))
    np.testing.assert_allclose(found[1], found[3] ** 2 / (2 * 9.81))
    still = point_mass_outcomes(HopperLeg(), replace(motor(), stall_torque=0.001), np.array([0.1]))
    assert still[0, 0] == 2
    assert still[1, 0] == 0.0


def test_every_complete_row_makes_a_motor_that_has_the_makers_line() -> None:
    """At rest the stall torque, at free speed none: by R, K_e, K_t and friction, for all 103 complete rows."""
    rows = [row for row in catalogue().motors if row.complete]
    assert len(rows) == 103
    for row in rows:
        made = motor_of(row)
        stall = made.gear_ratio * made.torque_constant * (made.voltage / made.resistance)
        friction = made.gear_ratio * made.friction * made.torque_constant / made.back_emf_constant
        assert stall - friction == pytest.approx(row.stall_torque, rel=1e-9)
        back = made.back_emf_constant * made.gear_ratio * made.no_load_speed
        current = (made.voltage - back) / made.resistance
        assert made.gear_ratio * made.torque_constant * current == pytest.approx(friction, rel=1e-9)
        assert 0.1 <= made.efficiency <= 1.0


@pytest.mark.parametrize("factor", [0.7, 1.4])
def test_with_a_given_resistance_the_free_speed_is_the_maker_s_and_the_stall_torque_is_not(factor: float) -> None:
    row = catalogue().find_motor("N20 HPCB 12V 75:1")
    assert row.voltage
    assert row.stall_current
    assert row.stall_torque
    usual = row.voltage / row.stall_current
    made = motor_of(row, MotorOptions(resistance=factor * usual))
    assert made.no_load_speed == pytest.approx(row.no_load_speed)
    assert made.no_load_current == pytest.approx(row.no_load_current)
    share = (row.stall_current / factor - made.no_load_current) / (row.stall_current - made.no_load_current)
    assert made.stall_torque / row.stall_torque == pytest.approx(share)
    with pytest.raises(UserError, match=r"the resistance must be below \d+ ohm"):
        motor_of(row, MotorOptions(resistance=1.01 * row.voltage / made.no_load_current))


def test_currents_of_another_ratio_are_named_as_such() -> None:
    """Eleven rows of the catalogue, of which the example chooses one."""
    rows = [row for row in catalogue().motors if row.basis_remark.startswith("currents are those of ")]
    assert len(rows) == 11
    told = estimates_of(catalogue().find_motor("N20 HP 6V 75:1"), MotorOptions())
    of_others = "stall and no-load currents are those of the 50:1"
    assert told[2] == f"{of_others}; resistance, back-EMF constant and efficiency follow from them"
    given = estimates_of(catalogue().find_motor("N20 HP 6V 75:1"), MotorOptions(resistance=4.0))
    assert any("; back-EMF constant and efficiency follow" in text for text in given)
    assert not any(
        "currents" in text for text in estimates_of(catalogue().find_motor("N20 HP 6V 298:1"), MotorOptions())
    )


def test_at_another_supply_speed_and_torque_follow_the_winding() -> None:
    row = catalogue().find_motor("N20 HP 6V 150:1")
    rated, less = motor_of(row), motor_of(row, MotorOptions(supply=3.0))
    assert less.stall_current == pytest.approx(rated.stall_current / 2)
    slope = (rated.no_load_speed - less.no_load_speed) / 3.0
    assert slope * row.gear_ratio * rated.back_emf_constant == pytest.approx(1.0)
    assert less.stall_torque == pytest.approx(row.gear_ratio * less.torque_constant * (less.stall_current - 0.1))


def test_the_map_and_the_neighbours_of_a_motor_are_of_its_own_family() -> None:
    """Two vendors' motors without a product line have nothing in common."""
    rows = [
        replace(catalogue().find_motor(part), vendor=vendor, product_line="", variant="")
        for part, vendor in (("N20 HP 6V 75:1", "ACME"), ("N20 HP 6V 150:1", "Bolt"), ("N20 HP 6V 210:1", "Bolt"))
    ]
    own = [catalogue().find_motor(f"N20 HP 6V {ratio}:1") for ratio in (75, 150)]
    asked = replace(problem("point_mass"), motors=tuple(motor_of(row) for row in (*rows, *own)))
    asked = replace(asked, tolerances=(HopperTolerances(),) * 5)
    sweep, found = run_sweep(asked), []
    for best in range(0, asked.size, len(asked.lengths)):
        study = SimpleNamespace(best=best, sweep=sweep, rows=(*rows, *own), project=SimpleNamespace(gearbox="warn"))
        shown = _map(study)  # type: ignore[arg-type]
        found.append((shown["family"], shown["gear_ratio"]))
        ratios = {each.motor.gear_ratio for each in _neighbours(asked, (*rows, *own), best)}
        assert ratios == set(shown["gear_ratio"])
    alone = [(f"{row.vendor} {row.part}", [row.gear_ratio]) for row in rows]
    both = (f"{own[0].vendor} {own[0].product_line} {own[0].variant}", [row.gear_ratio for row in own])
    assert found == [*alone, both, both]


def test_motors_are_chosen_by_pattern_and_missing_values_are_reported() -> None:
    rows = catalogue().motors
    assert {row.variant for row in chosen_rows(rows, ["n20 hp 6v *"])} == {"HP 6V"}
    with pytest.raises(UserError, match="matches no gear motor"):
        chosen_rows(rows, ["maxon *"])
    with pytest.raises(UserError, match="no stall torque"):
        chosen_rows(rows, ["N20 HPCB 12V 150:1"])


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_a_motor_s_friction_is_its_own_at_every_supply_and_gives_the_maker_s_line(share: float) -> None:
    """Steady: V = R i + K_e w, torque of the motor K_e i - f - b w, through the gear's loss K_t/K_e."""
    row = catalogue().find_motor("N20 HP 6V 75:1")
    assert row.stall_torque is not None
    for supply in (3.0, 6.0, 12.0):
        made = motor_of(row, MotorOptions(supply=supply, friction_share=share))
        rated = motor_of(row, MotorOptions(friction_share=share))
        assert (made.friction, made.viscous) == (rated.friction, rated.viscous)
        loss = made.torque_constant / made.back_emf_constant
        rotor = made.no_load_speed * made.gear_ratio
        current = (supply - made.back_emf_constant * rotor) / made.resistance
        free = made.back_emf_constant * current - made.friction - made.viscous * rotor
        assert free == pytest.approx(0.0, abs=1e-9)
        assert made.no_load_current == pytest.approx(current)
        held = made.gear_ratio * loss * (made.back_emf_constant * made.stall_current - made.friction)
        assert made.stall_torque == pytest.approx(held)
        if supply == row.voltage:
            assert made.stall_torque == pytest.approx(row.stall_torque)
            assert made.no_load_speed == pytest.approx(row.no_load_speed)
            assert made.no_load_current == pytest.approx(row.no_load_current)


def test_the_current_s_tolerance_is_of_dry_and_viscous_friction() -> None:
    row, tolerances = catalogue().find_motor("N20 HP 6V 75:1"), HopperTolerances(current=0.45)
    place = 1 + QUANTITIES.index("no-load current")
    for share in (0.0, 0.5, 1.0):
        made = motor_of(row, MotorOptions(friction_share=share))
        less = copies(HopperLeg(), made, tolerances)[place][1]
        back_emf = less.back_emf_constant / made.back_emf_constant  # the free speed is still the maker's
        assert less.friction == pytest.approx(0.55 * made.friction * back_emf)
        assert less.viscous == pytest.approx(0.55 * made.viscous * back_emf)
