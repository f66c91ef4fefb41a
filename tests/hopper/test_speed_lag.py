"""Run-ups whose speed is counted over a window, which tells it late."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hopper.test_rest_before_switch_on import RATIO, REST, STEP, TRUTH, run_ups
from synth.files.hopper_recordings import HopperRecording
from synth.hopper.fit_motor_response import ResponseRun
from synth.hopper.identify_motor import identify_motor
from synth.hopper.speed_lag import SpeedLag
from synth.hopper.write_identified import motor_json

WINDOW = 12  # samples, 6 ms beside a run-up's time constant of 15 ms


def counted(run: HopperRecording) -> HopperRecording:
    """The run with a noisy current, and its speed as the mean of the last ``WINDOW`` samples' own."""
    noise = 0.03 * np.random.default_rng(1).standard_normal(len(run["time"]))
    run = replace(run, columns={**run.columns, "current": run["current"] + noise})
    speed = np.concatenate([np.zeros(WINDOW - 1), run["speed"]])
    return replace(run, columns={**run.columns, "speed": np.convolve(speed, np.ones(WINDOW) / WINDOW, mode="valid")})


def without_rest(run: HopperRecording) -> HopperRecording:
    """The run from its first sample after the switch-on."""
    return replace(run, columns={name: values[REST:] for name, values in run.columns.items()})


def test_a_speed_that_is_counted_over_a_window_is_taken_at_its_own_time() -> None:
    """Resistance and rotor inertia came out 6 % too large, beside intervals of 3 %."""
    for seed in range(3):
        found = identify_motor(tuple(map(counted, run_ups(seed))), RATIO)
        assert found.speed_lag.seconds == pytest.approx(STEP * (WINDOW - 1) / 2, abs=STEP / 2)
        for name, allowed in (("resistance", 0.02), ("back_emf", 0.01), ("rotor_inertia", 0.025)):
            assert getattr(found, name).value == pytest.approx(TRUTH[name], rel=allowed)
    written = motor_json(found)
    assert written["speed_lag"]["value"] == pytest.approx(1e3 * found.speed_lag.seconds)
    assert "the speed is told 2." in written["notes"][-1]


def test_a_speed_of_now_is_left_at_its_time() -> None:
    for seed in range(4):
        assert identify_motor(run_ups(seed), RATIO).speed_lag == SpeedLag()
    without = tuple(map(without_rest, map(counted, run_ups(0))))
    assert identify_motor(without, RATIO).speed_lag == SpeedLag()  # it would be that of an inductance


def test_a_speed_is_moved_between_samples_too() -> None:
    time = np.arange(0.0, 0.05, 1e-3)
    moved = SpeedLag(2.5e-3).undone(ResponseRun(time, time, np.column_stack([time, 3.0 * time])))
    assert len(moved.time) == len(moved.voltage) == len(time) - 3
    np.testing.assert_allclose(moved.measured[:, 1], 3.0 * (moved.time + 2.5e-3), atol=1e-12)
    np.testing.assert_array_equal(moved.measured[:, 0], moved.time)
