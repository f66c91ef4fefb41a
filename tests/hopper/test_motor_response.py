"""Motor constants from noisy run-ups: no bias, intervals that hold, no negative inductance."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from synth.arrays import Array
from synth.cli import main
from synth.errors import UserError
from synth.files.hopper_recordings import HopperRecording
from synth.hopper.fit_motor_response import ResponseRun, fit_response, standard_deviations
from synth.hopper.identify_motor import MotorEstimate, identify_motor
from synth.hopper.motor_response import CONSTANTS, motor_responses
from synth.hopper.quiet_voltage import pieces, quiet_voltage
from synth.hopper.write_identified import lines, motor_json

# Of an N20 gear motor; L/R is a quarter of a sample.
TRUTH = {"resistance": 3.75, "inductance": 0.9e-3, "back_emf": 1.7e-3, "friction": 1.7e-4, "viscous": 2e-9,
         "rotor_inertia": 1.5e-8}  # fmt: skip
RATIO, STEP, FINE = 150.58, 1e-3, 20  # gear ratio, s a sample, steps of the reference in it


def stepped(voltage: Array, friction: float = TRUTH["friction"]) -> Array:
    """(n, 2, m) current and rotor speed under voltages (n, m), linear between samples: Runge-Kutta in small steps."""
    r, inductance, k, _, b, j = TRUTH.values()
    i, w, h = np.zeros(voltage.shape[1]), np.zeros(voltage.shape[1]), STEP / FINE
    rows = [np.array([i, w])]

    def rates(i: Array, w: Array, v: Array, sign: Array) -> tuple[Array, Array]:
        standing = (sign == 0.0) & (np.abs(k * i) <= friction)
        way = np.where(sign == 0.0, np.sign(i), sign)
        return (v - r * i - k * w) / inductance, np.where(standing, 0.0, (k * i - friction * way - b * w) / j)

    for first, last in pairwise(voltage):
        for step in range(FINE):
            v0, v1 = (first + (last - first) * (step + part) / FINE for part in (0.0, 1.0))
            sign = np.sign(w)
            a = rates(i, w, v0, sign)
            m = rates(i + h / 2 * a[0], w + h / 2 * a[1], (v0 + v1) / 2, sign)
            n = rates(i + h / 2 * m[0], w + h / 2 * m[1], (v0 + v1) / 2, sign)
            e = rates(i + h * n[0], w + h * n[1], v1, sign)
            i = i + h / 6 * (a[0] + 2 * m[0] + 2 * n[0] + e[0])
            new = w + h / 6 * (a[1] + 2 * m[1] + 2 * n[1] + e[1])
            w = np.where(new * sign < 0.0, 0.0, new)
        rows.append(np.array([i, w]))
    return np.array(rows)


@pytest.fixture(scope="module")
def clean() -> tuple[Array, Array]:
    """Voltages (n, 3) of run-ups over a second, and their responses (n, 2, 3)."""
    voltage = np.ones((1000, 1)) * np.array([3.0, 4.5, 6.0])
    return voltage, stepped(voltage)


def identified(
    voltage: Array, responses: Array, noise: tuple[float, float, float] = (0.0, 0.0, 0.0), seed: int = 0
) -> MotorEstimate:
    """From the runs with noise of current A, speed at the output rad/s, voltage V."""
    rng, runs = np.random.default_rng(seed), []
    for lane in range(voltage.shape[1]):
        current, speed = responses[:, 0, lane], responses[:, 1, lane] / RATIO
        columns = {"current": current, "speed": speed, "voltage": voltage[:, lane]}
        noisy = {
            name: column + size * rng.normal(size=len(column))
            for (name, column), size in zip(columns.items(), noise, strict=True)
        }
        runs.append(HopperRecording(f"{lane}.csv", {"time": STEP * np.arange(len(voltage)), **noisy}))
    return identify_motor(tuple(runs), RATIO)


def test_the_response_is_that_of_small_steps_also_where_the_rotor_turns_and_stands() -> None:
    time = STEP * np.arange(400)
    voltage = np.column_stack([3.0 + 0.0 * time, 4.0 * np.sin(2 * np.pi * 6 * time), np.where(time < 0.2, 0.2, 3.0)])
    lanes, friction = np.array(list(TRUTH.values()))[:, None], 3.0 * TRUTH["friction"]
    lanes[3] = friction
    wanted = stepped(voltage, friction)
    assert np.all(wanted[:200, 1, 2] == 0.0)  # it stands at 0.2 V
    for lane in range(3):
        found = motor_responses(time, voltage[:, lane], lanes, np.zeros((2, 1)))[:, :, 0]
        largest = np.abs(wanted[:, :, lane]).max(axis=0)
        assert np.all(np.abs(found - wanted[:, :, lane]).max(axis=0) < 2e-3 * largest)


@pytest.mark.parametrize("shape", ["run-ups", "switched within", "wave"])
def test_recordings_without_noise_give_the_constants(shape: str, clean: tuple[Array, Array]) -> None:
    voltage, responses = clean
    if shape == "wave":
        voltage = voltage * np.sin(2 * np.pi * 5 * STEP * np.arange(len(voltage)))[:, None]
        responses = stepped(voltage)
    if shape == "switched within":  # just after a sample, which a voltage linear between samples is not
        still = np.zeros((100, 3))
        voltage = np.concatenate([still, voltage[1:]])
        responses = np.concatenate([np.zeros((100, 2, 3)), responses[1:]])
    found = identified(voltage, responses)
    for name in ("resistance", "back_emf", "rotor_inertia", "inductance", "friction"):
        # The small steps stop a turning rotor at the end of one, which is seen in the inductance.
        most = 0.02 if (shape, name) == ("wave", "inductance") else 0.01
        assert getattr(found, name).value == pytest.approx(TRUTH[name], rel=most), name
    assert found.not_determined == ()


@pytest.mark.parametrize("noise", [(0.02, 0.2, 0.0), (0.05, 0.5, 0.05)])
def test_intervals_of_noisy_run_ups_hold(noise: tuple[float, float, float], clean: tuple[Array, Array]) -> None:
    """Twelve draws: of 72 intervals of 90 %, 56 or fewer hold by chance once in a thousand; the mean error is small."""
    draws = [identified(*clean, noise, seed) for seed in range(12)]
    held = dict.fromkeys(CONSTANTS, 0)
    for found in draws:
        for name, true in TRUTH.items():
            low, high = getattr(found, name).interval90
            held[name] += low <= true <= high
        assert 0.0 <= found.inductance.interval90[0] <= found.inductance.value <= found.inductance.interval90[1]
        assert bool(found.not_determined) == (found.inductance.interval90[0] == 0.0)
    assert sum(held.values()) > 56, held
    assert min(held.values()) >= 7, held
    for name in ("resistance", "back_emf", "rotor_inertia"):
        estimates = [getattr(found, name) for found in draws]
        off = np.mean([item.value for item in estimates]) - TRUTH[name]
        assert abs(off) < 4.0 * np.mean([item.deviation for item in estimates]) / len(draws) ** 0.5, name


def test_runs_of_another_rate_have_a_noise_of_their_own(clean: tuple[Array, Array]) -> None:
    """Noise that lasts 10 ms, at 1 kHz and at 100 Hz: together both were taken to be as correlated as the first."""
    voltage, responses = clean
    rng, decay = np.random.default_rng(3), np.exp(-0.1)
    noise = rng.normal(size=(len(voltage), 2, 2)) * np.array([0.02, 20.0])[:, None]
    for k in range(1, len(noise)):
        noise[k] = decay * noise[k - 1] + np.sqrt(1.0 - decay**2) * noise[k]
    runs = []
    for lane, every in ((0, 1), (1, 10)):
        time = STEP * np.arange(len(voltage))[::every]
        measured = (responses[:, :, lane] + noise[:, :, lane])[::every]
        runs.append(ResponseRun(time, voltage[::every, lane], measured))
    deviation = fit_response(runs, np.array(list(TRUTH.values())))[0].deviation
    wanted = np.sqrt([(1.0 + a) / (1.0 - a) for a in (decay, decay**10)])
    np.testing.assert_allclose(deviation[0] / deviation[1], wanted[0] / wanted[1], rtol=0.35)


def test_an_inductance_that_the_runs_do_not_show_is_said_to_be_open(clean: tuple[Array, Array]) -> None:
    found = identified(*clean, (0.2, 0.5, 0.0), seed=1)
    content = motor_json(found)
    assert content["motor"]["inductance"]["interval90"][0] == 0.0
    (said,) = content["not_determined"]
    assert said.startswith("inductance: the runs show only that it is below")
    assert lines(content)[-1] == f"not determined: {said}"


def test_runs_at_one_steady_speed_with_noise_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rng, n = np.random.default_rng(0), 1000
    for name, factor in (("a", 1.0), ("b", 1.001)):
        steady = [factor * value + size * rng.normal(size=n) for value, size in ((6.0, 0.01), (0.1, 0.01), (20.0, 0.1))]
        text = "time [s],voltage [V],current [A],speed [rad/s]"
        table = np.column_stack([STEP * np.arange(n), *steady])
        np.savetxt(tmp_path / f"{name}.csv", table, delimiter=",", header=text, comments="")
    (tmp_path / "p.yaml").write_text("kind: hopper-motor\ngear_ratio: 150\nruns: [a.csv, b.csv]\n")
    assert main(["-q", "hopper", str(tmp_path / "p.yaml"), "--out", str(tmp_path / "o")]) == 2
    said = capsys.readouterr().err
    assert "several voltages" in said or "no motor has" in said
    assert not (tmp_path / "o").exists()


def test_the_answer_has_the_keys_that_it_had(clean: tuple[Array, Array]) -> None:
    content = json.loads(json.dumps(motor_json(identified(*clean, (0.01, 0.05, 0.0)))))
    assert set(content) == {"motor", "windows"}
    names = {"resistance", "inductance", "back_emf_constant", "friction", "viscous", "rotor_inertia"}
    assert set(content["motor"]) == names
    assert content["motor"]["inductance"]["unit"] == "mH"


def test_a_voltage_loses_its_noise_and_keeps_its_switches_sags_and_waves() -> None:
    rng, time = np.random.default_rng(1), STEP * np.arange(1000)
    noise = 0.05 * rng.normal(size=1000)
    constant, wave = np.full(1000, 6.0), 6.0 * np.sin(2 * np.pi * 5 * time)
    switched, sagging = np.where(time < 0.3, 0.0, 6.0), 6.0 - np.exp(-time / 0.019)
    for true, left in ((constant, 0.3), (switched, 0.3), (wave, 0.5), (sagging, 0.6)):
        assert np.std(quiet_voltage(true + noise) - true) < left * 0.05
        np.testing.assert_allclose(quiet_voltage(true), true, atol=2e-3)
    fast = rng.choice([2.0, 6.0], size=1000)  # a source, not a sensor
    np.testing.assert_array_equal(quiet_voltage(fast), fast)


def test_a_run_is_cut_where_its_voltage_switches() -> None:
    rng, time = np.random.default_rng(1), STEP * np.arange(1000)
    switched = np.where(time < 0.3, 0.0, 6.0)
    assert pieces(switched) == [slice(0, 300), slice(300, 1000)]
    assert pieces(6.0 * np.sin(2 * np.pi * 5 * time)) == [slice(0, 1000)]
    assert pieces(rng.choice([2.0, 6.0], size=1000)) == [slice(0, 1000)]


def test_constants_whose_simulation_diverges_are_refused_in_the_words_of_the_runs(clean: tuple[Array, Array]) -> None:
    """The message was that of a leg's fit: its file, and `synth fit`."""
    voltage, responses = clean
    runs = [ResponseRun(STEP * np.arange(len(voltage)), voltage[:, 0], responses[:, :, 0])]
    fit, best = fit_response(runs, np.array(list(TRUTH.values())))
    with pytest.raises(UserError, match="the simulated current and speed diverge") as raised, np.errstate(all="ignore"):
        standard_deviations(replace(fit, deviation=np.zeros((1, 2))), best)
    assert "synth fit" not in str(raised.value)
