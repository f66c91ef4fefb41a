"""A jump's rise from the force plate: how far it may be off at the plate's sampling rate."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hopper.hoppers import motor
from hopper.recorded import DESIGN, changed, write
from synth.arrays import Array
from synth.cli import main
from synth.diagnosis.plants.jumping_leg.jump_data import prepare_jumps
from synth.files.hopper_gap_project import read_hopper_gap_project
from synth.files.hopper_recordings import HopperRecording, read_plate_jumps
from synth.hopper.measured_jump import MeasuredJump, measure
from synth.hopper.plate_zero import PlateZero, without_plate_zero
from synth.hopper.validate_jumps import validate
from synth.hopper.write_identified import validation_json
from synth.jump.hopper_leg import HopperLeg
from synth.jump.jump_runs import compiled_jump
from synth.jump.outcomes import APEX
from synth.parts.catalogs import Catalogue

DESIGNS = ((0.05, 75), (0.08, 75), (0.12, 150), (0.14, 210))


def sampled(length: float, ratio: int, step: float) -> tuple[Array, float, float]:
    """Time, ground force and upper link (n, 3) of the complete model's jump without noise; mass, kg; true rise, m."""
    lanes, jumper = changed(length, ratio, {}), compiled_jump("upper")
    parameters = lanes.workspace()[:, 0]
    trace = jumper.trace(parameters, tolerance=1e-6)
    time = np.arange(0.0, trace[-1, 0], step)
    rows = [np.interp(time, trace[:, 0], trace[:, 1 + jumper.layout.row(name)]) for name in ("normal", "angle")]
    true = float(jumper.run(parameters[:, None])[APEX, 0])
    return np.column_stack([time, *rows]), float(lanes.total_mass[0]), true


def measured(values: Array, mass: float) -> MeasuredJump:
    columns = dict(zip(("time", "ground force", "upper link"), values.T, strict=True))
    return measure(HopperRecording("a.csv", columns), mass, 9.81)


@pytest.mark.parametrize("step", [5e-4, 1e-3, 2e-3, 4e-3, 5e-3])
def test_the_true_rise_is_in_its_interval_at_every_sampling_rate(step: float) -> None:
    for length, ratio in DESIGNS:
        values, mass, true = sampled(length, ratio, step)
        found = measured(values, mass)
        assert abs(found.rise - true) < found.rise_reach, (length, ratio)
        if step <= 1e-3:  # 1 kHz is asked for, so it is enough
            assert found.rise_reach < 0.08 * true
            assert found.sentence() == ""
        if step >= 4e-3:
            assert f"only {found.samples} samples of the plate are in the push" in found.sentence()


def test_a_noisy_plate_does_not_lower_the_rise() -> None:
    """With noise of a quarter of the weight the foot leaves the plate unseen: what it still pushes counts."""
    values, mass, true = sampled(0.12, 150, 5e-4)
    rises, reaches = [], []
    for seed in range(20):
        noisy = values.copy()
        noisy[:, 1] += 0.1 * np.random.default_rng(seed).normal(size=len(values))
        found = measured(noisy, mass)
        rises.append(found.rise)
        reaches.append(found.rise_reach)
    assert np.mean(rises) == pytest.approx(true, rel=0.02)
    assert np.mean(np.abs(np.array(rises) - true) < np.array(reaches)) > 0.8


@pytest.mark.parametrize("zero", [0.05, -0.05, 0.2, -0.2])
def test_a_plates_zero_is_found_in_the_flight(zero: float) -> None:
    """A tenth of the weight made the rise 8 % too large, seven half intervals; four tenths were refused as no jump."""
    values, mass, true = sampled(0.12, 150, 1e-3)
    held = []
    for seed in range(10):
        shown = values[:, 1] + zero + 0.02 * np.random.default_rng(seed).normal(size=len(values))
        columns = {"time": values[:, 0], "ground force": shown, "upper link": values[:, 2]}
        jump, found = without_plate_zero(HopperRecording("a.csv", columns), 9.81 * mass)
        assert found.value == pytest.approx(zero, abs=5.0 * found.deviation)
        assert f"a.csv: the plate shows {found.value:.3g} N in the flight" in found.sentence("a.csv")
        rise = measure(jump, mass, 9.81, zero_deviation=found.deviation)
        held.append(abs(rise.rise - true) < rise.rise_reach)
    assert np.mean(held) >= 0.8


def test_a_plate_without_a_zero_or_a_flight_is_left_as_it_is() -> None:
    values, mass, _ = sampled(0.12, 150, 1e-3)
    columns = {"time": values[:, 0], "ground force": values[:, 1], "upper link": values[:, 2]}
    jump = HopperRecording("a.csv", columns)
    assert without_plate_zero(jump, 9.81 * mass) == (jump, PlateZero())
    standing = replace(jump, columns={**columns, "ground force": np.full(len(values), 9.81 * mass)})
    assert without_plate_zero(standing, 9.81 * mass)[1] == PlateZero()
    unseen = replace(jump, columns={"time": values[:, 0], "upper link": values[:, 2]})
    assert without_plate_zero(unseen, 9.81 * mass)[0] is unseen


@pytest.mark.parametrize("kind", ["hopper-jumps", "gap"])
def test_a_plates_zero_is_subtracted_and_told(kind: str, tmp_path: Path) -> None:
    values, mass, true = sampled(0.12, 150, 1e-3)
    values[:, 1] += 0.05 + 0.02 * np.random.default_rng(1).normal(size=len(values))
    write(tmp_path / "a.csv", values)
    (tmp_path / "hopper.yaml").write_text(DESIGN)
    project, leg = tmp_path / "p.yaml", 'motor: "N20 HP 6V 150:1"\nlength: 120 mm\n'
    if kind == "gap":
        project.write_text(f"kind: gap\nleg: hopper.yaml\n{leg}trials: [a.csv]\n")
        (jump,), said = prepare_jumps(read_hopper_gap_project(project), Catalogue.load())
        assert jump.seen is not None
        rise, reach = jump.seen.rise, jump.seen.rise_reach
        assert jump.measured["ground force"][0] == pytest.approx(9.81 * mass, abs=0.1)
    else:
        project.write_text(f"kind: hopper-jumps\ndesign: hopper.yaml\n{leg}jumps: [a.csv]\n")
        found = validate(read_plate_jumps(project), Catalogue.load())
        rise, reach, said = found.mean_rise, found.rise_reach, validation_json(found)["notes"]
    assert abs(rise - true) < reach
    assert any("a.csv: the plate shows 0.0" in str(text) for text in said)


@pytest.mark.parametrize(
    ("change", "said"),
    [(np.radians, "deg; is it in radians under [deg]?"),
     (lambda degrees: degrees + 15.0, "begins at 54.01 deg; the design's crouch, where every model begins, is 39")],
)  # fmt: skip
@pytest.mark.parametrize("kind", ["hopper-jumps", "gap"])
def test_an_angle_that_does_not_begin_in_the_crouch_is_refused(
    kind: str, change: Callable[[Array], Array], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    values, _, _ = sampled(0.12, 150, 1e-3)
    values[:, 2] = np.radians(change(np.degrees(values[:, 2])))
    write(tmp_path / "a.csv", values)
    (tmp_path / "design.yaml").write_text(DESIGN)
    names = {"hopper-jumps": ("design", "jumps", "hopper"), "gap": ("leg", "trials", "gap")}[kind]
    (tmp_path / "p.yaml").write_text(
        f'kind: {kind}\n{names[0]}: design.yaml\nmotor: "N20 HP 6V 150:1"\nlength: 120 mm\n{names[1]}: [a.csv]\n'
    )
    assert main(["-q", names[2], str(tmp_path / "p.yaml"), "--out", str(tmp_path / "out")]) == 2
    shown = capsys.readouterr().err
    assert "a.csv: upper link: " in shown
    assert said in shown
    assert not (tmp_path / "out").exists()


def test_a_coarse_plate_is_told_and_the_comparison_has_an_interval(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    values, _, true = sampled(0.05, 75, 5e-3)
    write(tmp_path / "a.csv", values)
    (tmp_path / "design.yaml").write_text('kind: hopper-design\nmotors: {use: ["N20 HP 6V 75:1"]}\n')
    (tmp_path / "p.yaml").write_text(
        'kind: hopper-jumps\ndesign: design.yaml\nmotor: "N20 HP 6V 75:1"\nlength: 50 mm\njumps: [a.csv]\n'
    )
    assert main(["hopper", str(tmp_path / "p.yaml"), "--out", str(tmp_path / "out")]) == 0
    found = json.loads((tmp_path / "out" / "jumps.json").read_text())
    low, high = found["mean_rise"]["interval90"]
    assert low < true < high
    assert found["measured"][0]["rise"]["interval90"] == [low, high]
    least, most = found["models"]["full"]["over_measured_interval90"]
    assert least < 0.0 < most
    (note,) = found["notes"]
    assert "at 1 kHz or more" in note
    shown = capsys.readouterr()
    assert f"({100 * low:.2f} to {100 * high:.2f}, 90 %)" in shown.out + shown.err


def test_a_leg_that_lands_straighter_than_it_took_off_flies_shorter() -> None:
    """A flight in closed form; from its time alone the rise was 11 % too low."""
    leg, own = HopperLeg(), motor()
    mass, speed, gravity = leg.total_mass(own), 1.05, 9.81
    bent, straight = np.radians(19.2), np.radians(8.7)
    heights = [leg.centre_height(own, angle) for angle in (bent, straight)]
    flown = (speed + np.sqrt(speed**2 + 2.0 * gravity * (heights[0] - heights[1]))) / gravity
    step, push = 1e-4, 0.05
    time = np.arange(0.0, push + flown + 0.05, step)
    force = np.where(time < push, mass * (gravity + speed / push), 0.0)
    force[time >= push + flown] = 5.0 * mass * gravity
    force[0] = mass * gravity
    jump = {"time": time, "ground force": force, "upper link": np.where(time < push + 0.5 * flown, bent, straight)}
    found = measure(HopperRecording("a.csv", jump), mass, gravity, lambda angle: leg.centre_height(own, angle))
    assert found.rise_after_takeoff == pytest.approx(speed**2 / (2.0 * gravity), rel=0.01)
    assert found.flight_rise == pytest.approx(speed**2 / (2.0 * gravity), rel=0.01)
    alone = measure(HopperRecording("a.csv", jump), mass, gravity).flight_rise
    assert alone is not None
    assert alone < 0.95 * speed**2 / (2.0 * gravity)


def test_the_centre_of_mass_is_between_hips_and_foot() -> None:
    own, upright = motor(), HopperLeg(hip_spacing=0.0)
    assert upright.centre_height(own, 0.0) == pytest.approx(
        (2 * upright.length * (upright.structure_mass + 2 * own.mass) + 4 * upright.link_mass[0] * upright.length)
        / upright.total_mass(own)
    )
