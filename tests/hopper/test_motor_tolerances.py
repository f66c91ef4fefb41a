"""A motor at the ends of its tolerances, and one that its supply does not turn."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from hopper.hoppers import catalogue
from synth.errors import UserError
from synth.files.hopper_project import read_hopper_project
from synth.hopper.hopper_tolerances import QUANTITIES, copies
from synth.hopper.motors import chosen_rows, motor_of, with_loss
from synth.hopper.study import sweep_problem
from synth.jump.hopper_leg import HopperLeg, MotorOptions


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("supply", [6.0, 4.0])
def test_another_no_load_current_leaves_the_maker_s_free_speed_and_stall(share: float, supply: float) -> None:
    """It is that of the row with this current alone: its effect on the height was 2.3 times too large."""
    row, options = catalogue().find_motor("N20 HP 6V 75:1"), MotorOptions(supply=supply, friction_share=share)
    assert row.no_load_current is not None
    for factor in (0.55, 1.45):
        changed = with_loss(motor_of(row, options), factor)
        wanted = motor_of(replace(row, no_load_current=factor * row.no_load_current), options)
        for name in ("stall_torque", "no_load_speed", "stall_current", "no_load_current", "friction", "viscous",
                     "back_emf_constant", "torque_constant"):  # fmt: skip
            assert getattr(changed, name) == pytest.approx(getattr(wanted, name), rel=1e-9, abs=1e-15), name


def test_a_no_load_current_that_would_stop_the_motor_hardly_turns_it() -> None:
    made = motor_of(catalogue().find_motor("N20 HP 6V 75:1"), MotorOptions(supply=0.5))
    stuck = with_loss(made, 1.9)
    assert 0.0 < stuck.no_load_speed < 0.1 * made.no_load_speed
    assert 0.0 < stuck.stall_torque < 0.1 * made.stall_torque
    hot = motor_of(catalogue().find_motor("N20 HP 6V 75:1"), MotorOptions(resistance=50.0))
    assert with_loss(hot, 1.9).back_emf_constant > 0.0


def test_a_motor_that_its_supply_does_not_turn_is_refused() -> None:
    """Its friction drove it, and its stall torque was negative."""
    row = catalogue().find_motor("N20 HP 6V 75:1")
    with pytest.raises(UserError, match=r"at 0.3 V this motor does not turn: its no-load current alone takes 0.375 V"):
        motor_of(row, MotorOptions(supply=0.3))
    assert motor_of(row, MotorOptions(supply=0.38)).stall_torque > 0.0
    assert motor_of(row, MotorOptions(supply=0.3, friction_share=0.5)).no_load_speed > 0.0


def test_written_tolerances_count_as_written_and_a_maker_s_limits_at_their_90_percent_end(tmp_path: Path) -> None:
    """Both were multiplied by 0.9."""
    row = catalogue().find_motor("N20 HP 6V 75:1")
    assert (row.speed_tolerance, row.current_tolerance) == (0.2, 0.5)
    file = tmp_path / "hopper.yaml"
    file.write_text('kind: hopper-design\nmotors: {use: ["N20 HP 6V 75:1"]}\ntolerance: {speed: 20 %}\n')
    problem, _ = sweep_problem(read_hopper_project(file), catalogue())
    (taken,) = problem.tolerances
    assert (taken.speed, taken.current) == pytest.approx((0.2, 0.45))
    made = problem.motors[0]
    slow = copies(HopperLeg(), made, taken)[1 + QUANTITIES.index("no-load speed")][1]
    assert slow.no_load_speed == pytest.approx(0.8 * made.no_load_speed)


def test_a_row_that_contradicts_itself_is_refused_in_a_sentence() -> None:
    row = catalogue().find_motor("N20 HP 6V 75:1").judged("contradiction", ["stall torque and current disagree"])
    said = '"n20*" cannot be simulated: the row of N20 HP 6V 75:1 contradicts itself: stall torque and current disagree'
    with pytest.raises(UserError) as raised:
        chosen_rows([row], ["n20*"])
    assert said == str(raised.value)
