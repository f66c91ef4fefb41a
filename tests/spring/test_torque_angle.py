"""Springs measured on a bench: by exact lines, by a slider of its own simulated here, and by damaged tables."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from synth.cli import main
from synth.errors import UserError
from synth.spring.torque_angle import MeasuredCycles, measured_cycles

RATE, FREE = 2.06, math.radians(3.0)


def cycles(count: int, samples: int = 40, travel: float = math.radians(70.0)) -> np.ndarray:
    up = np.linspace(0.0, travel, samples)
    return np.concatenate([np.concatenate([up, up[-2::-1]]) for _ in range(count)])


def slider(angle: np.ndarray, friction: float, slip: float, share: float = 0.0, free: float = FREE) -> np.ndarray:
    """Torque of a spring beside an elastic slider (Prandtl, 1928) of ``friction`` N m and a ``share`` of the load."""
    torque, stretched = np.empty_like(angle), 0.0
    for k, each in enumerate(angle):
        moved = each - angle[k - 1] if k else 0.0
        stretched = min(max(stretched + moved / slip, -1.0), 1.0)
        load = RATE * (each - free)
        torque[k] = load + stretched * (friction + share * abs(load))
    return torque


def test_a_line_is_found_to_rounding() -> None:
    angle = cycles(3)
    found = measured_cycles(angle, RATE * (angle - FREE))
    assert found.rate.value == pytest.approx(RATE, rel=1e-12)
    assert found.free_angle.value == pytest.approx(FREE, abs=1e-12)
    assert found.friction is not None
    assert abs(found.friction.value) < 1e-12
    assert found.slip is None
    assert found.bend is None
    assert found.preload(0.0) == pytest.approx(-RATE * FREE)


def test_hysteresis_of_a_slider_is_found_with_its_slip() -> None:
    angle = cycles(3, 400)
    found = measured_cycles(angle, slider(angle, 0.06, math.radians(3.0)))
    assert found.rate.value == pytest.approx(RATE, rel=1e-9)
    assert found.free_angle.value == pytest.approx(FREE, abs=1e-9)
    assert found.friction is not None
    assert found.friction.value == pytest.approx(0.06, rel=1e-9)
    assert found.slip == pytest.approx(math.radians(3.0), rel=0.02)
    assert not found.reversed_branches


def test_friction_that_grows_with_the_load_makes_two_rates() -> None:
    angle = cycles(3, 400)
    found = measured_cycles(angle, slider(angle, 0.0, math.radians(1.0), share=0.05, free=0.0))
    assert found.winding == pytest.approx(1.05 * RATE, rel=1e-3)
    assert found.unwinding == pytest.approx(0.95 * RATE, rel=1e-3)
    assert found.rate.value == pytest.approx(RATE, rel=1e-3)


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_signs_of_angle_and_torque_do_not_matter(way: float, sign: float) -> None:
    angle = cycles(2)
    found = measured_cycles(way * angle, sign * way * slider(angle, 0.05, math.radians(2.0)))
    assert found.rate.value == pytest.approx(RATE, rel=1e-6)
    assert found.free_angle.value == pytest.approx(way * FREE, abs=1e-6)
    assert found.friction is not None
    assert found.friction.value == pytest.approx(0.05, rel=1e-6)


def test_a_spring_turned_both_ways_has_one_line() -> None:
    angle = cycles(2, 80, math.radians(120.0)) - math.radians(60.0)
    found = measured_cycles(angle, slider(angle, 0.05, math.radians(2.0)))
    assert found.rate.value == pytest.approx(RATE, rel=1e-6)
    assert found.friction is not None
    assert found.friction.value == pytest.approx(0.05, rel=1e-6)


@pytest.mark.parametrize("samples", [12, 60, 400])
def test_intervals_hold_nine_times_in_ten(samples: int) -> None:
    """80 tests with noise; 8 of 80 may miss, and with 90 % 14 or more do so once in 50 such counts (binomial)."""
    random, missed = np.random.default_rng(11 + samples), np.zeros(2, dtype=int)
    for _ in range(80):
        angle = cycles(int(random.integers(1, 6)), samples)
        torque = slider(angle, 0.1 * random.random(), math.radians(1.0 + 4.0 * random.random()))
        noisy = torque + random.normal(0.0, 0.01, len(torque))
        found = measured_cycles(angle + random.normal(0.0, 0.002, len(angle)), noisy)
        missed += [abs(found.rate.value - RATE) > found.rate.within,
                   abs(found.free_angle.value - FREE) > found.free_angle.within]  # fmt: skip
    assert (missed <= 14).all()


def test_a_slack_beginning_does_not_move_the_line() -> None:
    """Until the pin touches the arm the torque is zero; a line through all samples would be 2 % too soft."""
    angle = cycles(3)
    found = measured_cycles(angle, np.maximum(RATE * (angle - FREE), 0.0))
    assert found.rate.value == pytest.approx(RATE, rel=1e-12)
    assert found.free_angle.value == pytest.approx(FREE, abs=1e-12)


def test_a_spring_that_hardens_and_a_lagging_torque_are_told() -> None:
    angle = cycles(3)
    hard = measured_cycles(angle, RATE * angle * (1.0 + 0.2 * angle))
    assert hard.bend is not None
    assert hard.bend > 0.1
    late = measured_cycles(angle, np.roll(RATE * angle, 2))
    assert late.reversed_branches
    assert not measured_cycles(angle, np.roll(RATE * angle, -2)).reversed_branches


def test_only_wound_up_has_no_hysteresis() -> None:
    angle = np.linspace(0.0, 1.0, 9)
    found = measured_cycles(angle, RATE * angle)
    assert found.friction is None
    assert found.cycles == 1


@pytest.mark.parametrize(
    ("angle", "torque", "said"),
    [
        ([0.0, 1.0], [0.0, 1.0], "tell no rate"),
        ([1.0] * 9, list(range(9)), "tell no rate"),
        (list(range(9)), [0.0] * 9, "does not change with the angle"),
        ([0.0, 1.0, 0.0, 1.0, 0.0], [0.0, 1.0, 0.0, 1.0, 0.0], "read more angles between the ends"),
    ],
)
def test_what_holds_no_spring_is_refused(angle: list[float], torque: list[float], said: str) -> None:
    with pytest.raises(UserError, match=said):
        measured_cycles(np.array(angle, dtype=float), np.array(torque, dtype=float))


def table(folder: Path, head: str = "angle [deg],torque [N*mm]", scale: float = 1e3) -> Path:
    angle = cycles(3)
    torque = slider(angle, 0.06, math.radians(4.0))
    rows = [f"{math.degrees(a):.4f},{scale * m:.6f}" for a, m in zip(angle, torque, strict=True)]
    path = folder / "bench.csv"
    path.write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")
    return path


def test_the_command_compares_with_the_drawing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """By hand, k = E d^4/(64 D N): music wire of 3 mm has 196.5 GPa (Shigley, table 10-5)."""
    out = tmp_path / "measured.json"
    coil = ["--wire-diameter", "3 mm", "--mean-diameter", "25 mm", "--coils", "5.25"]
    assert main(["spring", "-q", "measure", str(table(tmp_path)), *coil, "--json", str(out)]) == 0
    shown, found = capsys.readouterr().out, json.loads(out.read_text())
    stated = 196.5e9 * 3e-3**4 / (64 * 25e-3 * 5.25)
    assert found["rate"]["value"] == pytest.approx(RATE, rel=1e-3)
    assert found["drawing"]["rate"]["value"] == pytest.approx(stated, rel=1e-3)
    assert found["drawing"]["measured_over_drawing"]["value"] == pytest.approx(RATE / stated, rel=2e-3)
    assert found["drawing"]["preload"]["value"] == pytest.approx(-RATE * FREE, rel=1e-2)
    assert found["hysteresis"]["torque"]["value"] == pytest.approx(0.06, rel=1e-3)
    assert "measured: {spring: {JOINT: {rate: 2.06" in shown
    assert "effects: [spring_hysteresis: {stiffness: " in shown
    again = ["--rate", "0.036 N*m/rad"]  # 2.06 N m/rad is 0.036 N m/deg
    assert main(["spring", "measure", str(table(tmp_path)), *again]) == 0
    assert "differ as per degree and per radian do" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("head", "options", "said"),
    [
        ("angle [deg],force [N]", [], "multiply a force by the length of its lever"),
        ("angle [deg],torque", [], "torque"),
        ("angle [deg],torque [N*mm]", ["--wire-diameter", "2 mm"], "needs --mean-diameter and --coils as well"),
        ("angle [deg],torque [N*mm]", ["--part", "LTR135H 10 M", "--rate", "1 N*m/rad"], "keep one of them"),
        ("angle [deg],torque [N*mm]", ["--travel", "40 deg"], "is not used by measure"),
        ("angle [deg],torque [N*mm]", ["--leg-length", "-1 mm"], "must be 0 or more"),
    ],
)
def test_mistakes_are_told_with_the_place(
    head: str, options: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["spring", "measure", str(table(tmp_path, head)), *options]) == 2
    assert said in capsys.readouterr().err
    assert main(["spring", "measure"]) == 2
    assert "the table is missing" in capsys.readouterr().err


def test_the_pasted_hysteresis_has_the_measured_loop() -> None:
    """The effect's own law, integrated here over the test's angles, gives the friction and half turn that were read."""
    angle = cycles(3, 400)
    found: MeasuredCycles = measured_cycles(angle, slider(angle, 0.06, math.radians(4.0)))
    assert found.slip is not None
    assert found.friction is not None
    stiffness, memory, torque = found.friction.value / found.slip, 0.0, []
    for k, each in enumerate(angle):
        moved = each - angle[k - 1] if k else 0.0
        memory += moved * (1.0 - (abs(memory / found.slip) ** 1.5 if moved * memory > 0.0 else 0.0))
        torque.append(RATE * (each - FREE) + stiffness * memory)
    again = measured_cycles(angle, np.array(torque))
    assert again.friction is not None
    assert again.friction.value == pytest.approx(found.friction.value, rel=0.05)
    assert again.slip == pytest.approx(found.slip, rel=0.05)
