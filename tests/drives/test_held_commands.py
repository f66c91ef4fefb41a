"""Commands held from each sample to the next by servos that look all the time, against scipy with restarts."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from synth.arrays import Array
from synth.diagnosis.angle_trials import angle_trial
from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo, ServoSignals
from synth.files.leg_file import read_leg, write_leg
from synth.files.recording import read_recording
from synth.files.trial_list import Trial
from synth.fit.recordings import recordings
from synth.fit.sensor_noise import estimate_sensor
from synth.swing.chain import compiled_chain, simulate
from synth.swing.leg_lanes import LegLanes
from synth.swing.leg_model import Damper, Joint, Leg, Link

LINK = Link(0.12, 0.49, 0.1, 1e-4)
MOTOR = GearedMotor(3.5, 0.37 / 200.0, 200.0, 0.9, 4e-8)
SERVO = Servo(2.3, 0.01, 0.007, 0.01, current_limit=1.0, supply=7.4, source_resistance=0.5, duty_limit=0.8, motor=MOTOR)
TIMES = np.linspace(0.0, 2.0, 401)  # s, of the angles
TOLD = np.arange(-0.004, 2.0, 0.01)  # s, of the commands: 100 Hz, on a clock of their own
COMMAND = np.where(TOLD < 1.2, 0.8 * np.sin(4.4 * TOLD) + 0.2 * np.sin(9.0 * TOLD), np.sign(np.sin(25.0 * TOLD)))


def leg(servo: Servo = SERVO) -> Leg:
    return Leg("arm", (Joint("arm", LINK, drive=servo),))


def signals(held: bool = True) -> ServoSignals:
    """Supply and switch change too, linearly, on the same clock."""
    supply, enabled = 7.4 - 0.3 * TOLD, np.clip((1.9 - TOLD) / 0.05, 0.0, 1.0)
    return ServoSignals(TOLD, *(x[:, None] for x in (COMMAND, supply, enabled)), (0,) if held else ())


def given_to(servo: Servo) -> ServoSignals:
    """Without a motor there is no supply."""
    return signals() if servo.motor is not None else replace(signals(), supply=np.ones((len(TOLD), 1)))


def restarted(servo: Servo) -> Array:
    """(m,) rad: scipy from each change of the command to the next; nothing is shared but data and the motor's line."""
    arm, given = leg(servo), given_to(servo)
    inertia = LINK.inertia + LINK.mass * LINK.com**2 + arm.joints[0].with_rotor
    delay = servo.numbers[9]
    corners = [*TOLD, 1.85, 1.9]  # of the switch too
    ends = np.unique([0.0, 2.0, *[t + delay for t in TOLD if 0.0 < t + delay < 2.0], *[t for t in corners if t > 0.0]])
    x, found = np.zeros(2), np.full(len(TIMES), np.nan)
    for start, end in pairwise(ends):
        at = max(np.searchsorted(TOLD, 0.5 * (start + end) - delay, side="right") - 1, 0)

        def slope(t: float, x: Array, told: float = float(COMMAND[at])) -> list[float]:
            supply, on = (np.interp(t, TOLD, values[:, 0]) for values in (given.supply, given.enabled))
            torque = servo.torque(np.array([told - x[0]]), x[1:], supply, on)[0]
            return [x[1], (torque - LINK.mass * 9.81 * LINK.com * math.sin(x[0])) / inertia]

        part = solve_ivp(slope, (start, end), x, "DOP853", rtol=1e-10, atol=1e-12, max_step=1e-3, dense_output=True)
        first, last = np.searchsorted(TIMES, [start - 1e-12, end + 1e-12])
        if last > first:
            found[first:last] = part.sol(TIMES[first:last])[0]
        x = part.y[:, -1]
    return found


@pytest.mark.parametrize(
    "servo",
    [SERVO, replace(SERVO, delay=0.0), replace(SERVO, motor=replace(MOTOR, inductance=1e-3)), Servo(1.5, 0.08, 0.013)],
    ids=["delayed", "at once", "a late winding", "without a motor"],
)
def test_each_command_is_held_against_scipy(servo: Servo) -> None:
    """Steps of the integrator end at each change of the command, of which 200 lie in 2 s."""
    given, expected = given_to(servo), restarted(servo)
    found = simulate(leg(servo), [0.0], [0.0], TIMES, signals=given, tolerance=1e-9)[:, 0]
    np.testing.assert_allclose(found, expected, atol=1e-6)
    linear = simulate(leg(servo), [0.0], [0.0], TIMES, signals=replace(given, held=()))[:, 0]
    assert np.abs(found - linear).max() > 0.01


@pytest.mark.parametrize("tolerance", [1e-5, 1e-6])
def test_no_tolerance_is_farther_off_than_with_linear_commands(tolerance: float) -> None:
    """Limits and dead bands bend a motion within a step; that error is no larger than it was."""
    errors = []
    for held in (True, False):
        given = signals(held)
        found, fine = (
            simulate(leg(), [0.0], [0.0], TIMES, signals=given, tolerance=x)[:, 0] for x in (tolerance, 1e-11)
        )
        errors.append(float(np.sqrt(np.mean((found - fine) ** 2))))
    assert errors[0] < 0.5 * errors[1]


def test_lanes_with_other_delays_each_hold_their_own_command() -> None:
    delays = [0.0, 0.007, 0.0070001, 0.019, 0.35]
    lanes = LegLanes.of(leg(), len(delays))
    for k, delay in enumerate(delays):
        lanes.servo[:, 0, k] = replace(SERVO, delay=delay).numbers
    chain = compiled_chain(1)
    together = chain.run(chain.lanes(lanes), TIMES, 1e-9, signals=signals())[:, 0]
    for k, delay in enumerate(delays):
        alone = simulate(leg(replace(SERVO, delay=delay)), [0.0], [0.0], TIMES, signals=signals(), tolerance=1e-9)
        np.testing.assert_allclose(together[:, k], alone[:, 0], atol=1e-7)
    # A motion is differentiable in the delay: a fit of it needs that.
    slope = (together[:, 2] - together[:, 1]) / 1e-7
    assert 0.05 < np.abs(slope).max() < 50.0


def test_time_counted_in_another_unit_changes_nothing() -> None:
    chain = compiled_chain(1)
    lanes = chain.parameters(leg())[:, None]
    usual, slow = (chain.run(lanes, TIMES, 1e-9, signals=signals(), unit=unit) for unit in (1.0, 5.0))
    np.testing.assert_allclose(slow, usual, atol=2e-7)


def test_a_locked_or_passive_joint_beside_a_held_one() -> None:
    """Two links of which the second has no servo: only the first one's commands are held."""
    both = Leg("arm", (Joint("one", LINK, drive=SERVO), Joint("two", Link(0.1, 0.1, 0.05, 1e-4), damper=Damper(2e-3))))
    one = signals()
    wide = replace(
        one,
        command=np.column_stack([COMMAND, 0.0 * COMMAND]),
        supply=np.column_stack([one.supply, one.supply]),
        enabled=np.column_stack([one.enabled, one.enabled]),
    )
    found = simulate(both, [0.0, 0.0], [0.0, 0.0], TIMES, signals=wide, tolerance=1e-9)
    dense = np.arange(0.0, 2.0, 1e-5)
    last = np.searchsorted(TOLD, dense, side="right") - 1
    fine = ServoSignals(dense, *(np.stack([np.interp(dense, TOLD, x) for x in y.T], axis=1) for y in (
        wide.command, wide.supply, wide.enabled)))  # fmt: skip
    fine.command[:] = wide.command[last]
    close = simulate(both, [0.0, 0.0], [0.0, 0.0], TIMES, signals=fine, tolerance=1e-9)
    np.testing.assert_allclose(found, close, atol=3e-4)  # rad; a polygon of 10 us edges


def test_the_mean_of_a_held_command_preserves_its_impulse() -> None:
    fine = np.arange(0.0, 1.99, 1e-5)
    exact = COMMAND[np.clip(np.searchsorted(TOLD, fine - 0.007, side="right") - 1, 0, None)]
    grid = np.arange(0.01, 1.98, 0.0125)
    found = signals().at(grid, np.array([0.007]))[0][:, 0]
    for k in (0, 40, 100, 150):
        inside = np.abs(fine - grid[k]) < 0.5 * 0.0125
        assert found[k] == pytest.approx(exact[inside].mean(), abs=2e-3)
    single = signals().at(np.array([0.5]), np.array([0.0]))[0][0, 0]
    assert single == COMMAND[np.searchsorted(TOLD, 0.5, side="right") - 1]


def test_rows_of_commands_alone_are_no_samples_of_the_motion(tmp_path: Path) -> None:
    """Commands of another topic have rows of their own; samples, noise and what the servo is told stay the same."""
    noise = 2e-4  # rad
    angles = 0.5 * np.sin(3.0 * TIMES) + noise * np.random.default_rng(4).standard_normal(len(TIMES))
    told = 0.5 * np.sin(3.1 * TIMES)
    together = [f"{t!r},{a!r},{c!r}" for t, a, c in zip(TIMES.tolist(), angles.tolist(), told.tolist(), strict=True)]
    apart = [
        row
        for t, a, c in zip(TIMES.tolist(), angles.tolist(), told.tolist(), strict=True)
        for row in ((f"{t - 0.002!r},,{c!r}", f"{t!r},{a!r},") if t else (f"{t!r},{a!r},{c!r}",))
    ]
    found = []
    for rows in (together, apart):
        (tmp_path / "log.csv").write_text("\n".join(["time [s],arm [rad],arm command [rad]", *rows]) + "\n")
        read = read_recording(tmp_path / "log.csv", leg())
        (made,) = recordings(leg(), [Trial("log", read.time, read.angles, signals=read.signals)])
        np.testing.assert_allclose(made.time, TIMES, atol=1e-12)
        assert made.counts.all()
        assert made.n_lost == 0
        assert estimate_sensor([made]).noise[0] == pytest.approx(noise, rel=0.1)
        assert angle_trial(made, held_out=False).counted[0] == len(TIMES)
        assert made.signals is not None
        late = 0.002 if rows is together else 0.0  # s, by which each command comes later
        found.append(made.signals.at(np.array([0.1, 1.0]) + late, np.zeros(1))[0][:, 0])
    np.testing.assert_allclose(found[0], found[1], atol=1e-12)


@pytest.mark.parametrize("period", [0.0, 8e-3])
def test_a_file_says_whether_its_servo_interpolates(period: float, tmp_path: Path) -> None:
    """``commands: linear`` in the leg file; else each command of the log is held."""
    cells = np.full(len(TIMES), np.nan)
    cells[::2] = COMMAND[: len(cells[::2])]
    rows = [
        f"{t:.9g},0,{'' if math.isnan(c) else repr(math.degrees(c))}"
        for t, c in zip(TIMES.tolist(), cells.tolist(), strict=True)
    ]
    (tmp_path / "log.csv").write_text("\n".join(["time [s],arm [deg],arm command [deg]", *rows]) + "\n")
    motions = []
    for linear in (False, True):
        write_leg(leg(replace(SERVO, control_period=period, linear_commands=linear)), tmp_path / "arm.leg.yaml")
        read = read_leg(tmp_path / "arm.leg.yaml")
        drive = read.joints[0].drive
        assert isinstance(drive, Servo)
        assert drive.linear_commands == linear
        found = read_recording(tmp_path / "log.csv", read).signals
        assert found is not None
        assert found.held == (() if linear else (0,))
        motions.append(simulate(read, [0.0], [0.0], TIMES, signals=found, tolerance=1e-9)[:, 0])
        # A polygon on a far denser clock is the same motion, and so is a staircase.
        dense = np.arange(0.0, 2.0, 1e-4)
        known = np.isfinite(cells)
        held = np.searchsorted(TIMES[known], dense + 1e-9, side="right") - 1
        fine = np.interp(dense, TIMES[known], cells[known]) if linear else cells[known][held]
        wide = np.ones((len(dense), 1))
        fine_signals = ServoSignals(dense, fine[:, None], 7.4 * wide, wide, () if linear else (0,))
        close = simulate(read, [0.0], [0.0], TIMES, signals=fine_signals, tolerance=1e-9)[:, 0]
        np.testing.assert_allclose(close, motions[-1], atol=1e-6)
    assert np.abs(motions[0] - motions[1]).max() > 0.01
