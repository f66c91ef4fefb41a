"""Run-ups whose recording begins before the switch-on: the motor at rest is the state at a switch between samples."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from synth.files.hopper_recordings import HopperRecording
from synth.hopper.current_zero import current_zero
from synth.hopper.fit_motor_response import INDUCTANCE, fit_response
from synth.hopper.identify_motor import MotorEstimate, identify_motor
from synth.hopper.inductance_profile import inductance_profile
from synth.hopper.motor_response import CONSTANTS, motor_responses
from synth.hopper.response_runs import response_runs
from synth.hopper.write_identified import lines, motor_json

# Of an N20 gear motor; L/R is 0.15 of a sample, so the rise of the current is over before most first samples.
TRUTH = {"resistance": 4.0, "inductance": 0.3e-3, "back_emf": 2e-3, "friction": 3e-5, "viscous": 2e-9,
         "rotor_inertia": 1.5e-8}  # fmt: skip
RATIO, STEP, REST, LENGTH = 150.58, 5e-4, 10, 400  # gear ratio, s a sample, samples at rest and after
NOISE = {"voltage": 0.0, "current": 5e-3, "speed": 0.02}  # V, A, rad/s of the output


def run_ups(seed: int, source: float = 0.0) -> tuple[HopperRecording, ...]:
    """Three run-ups switched on anywhere between two samples, behind a source of so many ohm."""
    rng, found = np.random.default_rng(seed), []
    constants = np.array(list(TRUTH.values()))[:, None]
    constants[0] += source
    for supply in (3.0, 4.5, 6.0):
        since = STEP * (rng.uniform(0.0, 1.0) + np.arange(LENGTH))
        time = np.concatenate([[0.0], since])
        after = motor_responses(time, np.full(len(time), supply), constants, np.zeros((2, 1)))[1:, :, 0]
        current, speed = np.concatenate([np.zeros((REST, 2)), after]).T
        voltage = np.concatenate([np.zeros(REST), supply - source * after[:, 0]])
        columns = {"voltage": voltage, "current": current, "speed": speed / RATIO}
        noisy = {name: values + NOISE[name] * rng.normal(size=len(values)) for name, values in columns.items()}
        found.append(HopperRecording(f"{supply}.csv", {"time": STEP * np.arange(len(voltage)), **noisy}))
    return tuple(found)


@pytest.fixture(scope="module")
def draws() -> list[MotorEstimate]:
    return [identify_motor(run_ups(seed), RATIO) for seed in range(12)]


def test_rest_before_the_switch_on_costs_no_information(draws: list[MotorEstimate]) -> None:
    """It did: the inductance was open in 11 of 12 draws, and the median interval of both was six times as wide."""
    assert max(np.ptp(found.inductance.interval90) for found in draws) < 0.25e-3
    assert all(found.not_determined == () for found in draws)
    assert max(np.ptp(found.resistance.interval90) for found in draws) < 0.02


def test_intervals_of_recordings_with_rest_hold(draws: list[MotorEstimate]) -> None:
    """Of 72 intervals of 90 %, 56 or fewer hold by chance once in a thousand."""
    held = dict.fromkeys(CONSTANTS, 0)
    for found in draws:
        for name, true in TRUTH.items():
            low, high = getattr(found, name).interval90
            held[name] += low <= true <= high
    assert sum(held.values()) > 56, held
    assert min(held.values()) >= 7, held


def test_the_rest_is_no_run_and_the_switch_on_is_in_the_sample_after_it() -> None:
    for recording in run_ups(0):
        (run,) = response_runs(recording, RATIO)
        assert run.time[0] == recording["time"][REST]
        assert run.after_rest == pytest.approx(STEP)


def test_a_motor_that_turns_or_a_source_that_drops_leaves_the_first_state_free() -> None:
    turning = run_ups(0)[0]
    turning["speed"][:REST] += 1.0  # of 19 rad/s
    assert [run.after_rest for run in response_runs(turning, RATIO)] == [None, None]
    assert all(run.after_rest is None for one in run_ups(0, source=0.2) for run in response_runs(one, RATIO))


def test_constants_are_those_of_one_inductance() -> None:
    """An inductance of 0 stood beside the resistance of another, and an interval that left the bound out.

    Without the rise of the current R - L/tau is known, tau = J R / K^2: R is open by the inductance's interval over it.
    """
    fits = 0
    for seed in range(6):
        runs = [part for one in run_ups(seed, source=0.2) for part in response_runs(one, RATIO)]
        fit, best = fit_response(runs, np.array(list(TRUTH.values())))
        profile = inductance_profile(fit, best)
        low, high = profile.interval
        ends = np.exp(profile.ends()[CONSTANTS.index("resistance")])
        tau = TRUTH["rotor_inertia"] * TRUTH["resistance"] / TRUTH["back_emf"] ** 2
        assert np.ptp(ends) > 0.7 * (high - low) / tau
        if profile.value == 0.0:
            fits += 1
            assert profile.best.unknowns[INDUCTANCE] == fit.low[INDUCTANCE]
    assert fits > 0


@pytest.mark.parametrize("off", [0.02, -0.02])
def test_the_current_at_rest_is_the_zero_of_its_sensor(off: float) -> None:
    """It was a current: viscous damping was nine times as large, or nothing was determined.

    Of 36 intervals of 90 %, 27 or fewer hold by chance once in a hundred.
    """
    held = 0
    for seed in range(6):
        runs = [replace(run, columns={**run.columns, "current": run["current"] + off}) for run in run_ups(seed)]
        found = identify_motor(tuple(runs), RATIO)
        low, high = found.current_zero.interval90
        assert low - 2e-3 < off < high + 2e-3
        for name, true in TRUTH.items():
            low, high = getattr(found, name).interval90
            held += low <= true <= high
    assert held >= 28
    content = motor_json(found)
    assert content["current_zero"]["value"] == pytest.approx(off, abs=4e-3)
    assert lines(content)[-1].startswith("note: the current is ")


def test_a_sensor_without_an_offset_has_no_zero() -> None:
    assert current_zero(run_ups(0)).value == 0.0
    turning = run_ups(0)
    for run in turning:
        run["speed"][:REST] += 1.0
        run["current"][:REST] += 0.02
    assert current_zero(turning).value == 0.0
