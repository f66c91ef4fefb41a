"""Recorded jumps with their landing, with a rest before the push, and on a clock that begins elsewhere."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hopper.hoppers import motor
from hopper.recorded import changed, jumped, write
from synth.arrays import Array
from synth.cli import main
from synth.diagnosis.plants.jumping_leg.jump_data import prepare_jumps
from synth.errors import UserError
from synth.files.hopper_gap_project import read_hopper_gap_project
from synth.files.hopper_recordings import HopperRecording
from synth.hopper.switch_on import from_switch_on
from synth.jump.hopper_leg import HopperLeg
from synth.jump.jump_runs import compiled_jump
from synth.parts.catalogs import Catalogue

DESIGN = 'kind: hopper-design\nmotors: {use: ["N20 HP 6V 150:1"]}\n'
JUMPS = 'kind: hopper-jumps\ndesign: design.yaml\nmotor: "N20 HP 6V 150:1"\nlength: 120 mm\njumps: [a.csv]\n'
GAP = 'kind: gap\nleg: design.yaml\nmotor: "N20 HP 6V 150:1"\nlength: 120 mm\ntrials: [a.csv]\n'
WEIGHT = HopperLeg().total_mass(motor()) * 9.81


def flown(seed: int = 0, end: float = 0.5, noise: float = 0.005) -> Array:
    """(n, 3) time, ground force, upper link of a jump by the complete model with its landing, 1 kHz."""
    jumper = compiled_jump("upper")
    rows = jumper.trace(changed(0.12, 150, {}).workspace()[:, 0], duration=end, fall=99.0)
    time = np.arange(0.0, rows[-1, 0], 1e-3)
    force, angle = (np.interp(time, rows[:, 0], rows[:, 1 + jumper.layout.row(name)]) for name in ("normal", "angle"))
    rng = np.random.default_rng(seed)
    scatter = rng.normal(size=(2, len(time)))
    return np.column_stack([time, force + noise * scatter[0], angle + np.radians(0.05) * scatter[1]])


def rested(values: Array, rest: float, clock: float = 0.0, seed: int = 3) -> Array:
    """The recording with so many seconds at rest before it, its first time ``clock``."""
    count = round(rest / 1e-3)
    rng = np.random.default_rng(seed)
    still = np.repeat(values[:1], count, axis=0)
    still[:, 1] = WEIGHT + 0.02 * rng.normal(size=count)
    still[:, 2] += np.radians(0.1) * rng.normal(size=count)
    found = np.concatenate([still, values])
    found[:, 0] = clock + np.concatenate([np.arange(count) * 1e-3, rest + values[:, 0]])
    return found


def result(folder: Path, values: Array) -> dict[str, Any]:
    """What ``synth hopper`` makes of one recorded jump."""
    folder.mkdir()
    (folder / "design.yaml").write_text(DESIGN)
    write(folder / "a.csv", values)
    (folder / "project.yaml").write_text(JUMPS)
    assert main(["-q", "hopper", str(folder / "project.yaml"), "--out", str(folder / "out")]) == 0
    return json.loads((folder / "out" / "jumps.json").read_text())  # type: ignore[no-any-return]


def test_a_landing_in_the_recording_changes_nothing(tmp_path: Path) -> None:
    """The landing hits the plate five times as hard as the push."""
    whole = flown()
    cut = result(tmp_path / "cut", whole[whole[:, 0] < 0.2])["measured"][0]
    landing = result(tmp_path / "landing", whole)["measured"][0]
    assert whole[:, 1].max() > 3 * cut["peak_force"]["value"]
    for key in ("takeoff_time", "takeoff_speed", "rise", "rise_after_takeoff", "peak_force"):
        assert landing[key]["value"] == pytest.approx(cut[key]["value"], rel=2e-3), key
    # The flight's estimate is of the rise after takeoff, not over the crouch.
    assert cut["flight_rise"] is None
    assert landing["flight_rise"]["value"] == pytest.approx(landing["rise_after_takeoff"]["value"], rel=0.04)
    assert landing["flight_rise"]["value"] < 0.7 * landing["rise"]["value"]


@pytest.mark.parametrize(("rest", "clock"), [(0.05, 0.0), (0.2, 0.0), (0.0, 10.0), (0.3, -0.1)])
def test_a_rest_or_another_clock_changes_nothing(rest: float, clock: float, tmp_path: Path) -> None:
    values = jumped(seed=4)
    plain, moved = result(tmp_path / "plain", values), result(tmp_path / "moved", rested(values, rest, clock))
    assert plain["notes"] == []
    assert plain["measured"][0]["switched_on"]["value"] == 0.0
    assert moved["measured"][0]["switched_on"]["value"] == pytest.approx(rest + clock, abs=1e-6)
    (note,) = moved["notes"]
    assert note.startswith("a.csv: its time does not begin when the motors are switched on")
    for key in ("takeoff_time", "rise", "peak_force"):
        assert moved["measured"][0][key]["value"] == pytest.approx(plain["measured"][0][key]["value"], rel=1e-6), key
    for name, model in plain["models"].items():
        for key in ("angle_error", "force_error"):
            assert moved["models"][name][key]["value"] == pytest.approx(model[key]["value"], rel=1e-6), (name, key)


def test_a_clock_that_runs_from_the_switch_on_with_a_rest_before_it_holds(tmp_path: Path) -> None:
    values = jumped(seed=4)
    moved = result(tmp_path / "moved", rested(values, 0.1, -0.1))
    assert moved["notes"] == []
    assert moved["measured"][0]["takeoff_time"]["value"] == pytest.approx(
        result(tmp_path / "plain", values)["measured"][0]["takeoff_time"]["value"]
    )


def test_the_switch_on_is_found_on_a_large_clock_and_not_where_it_is_set_to_0(tmp_path: Path) -> None:
    """Unix time counts from the first sample, which is no switch-on: a rest shows it, and without one none does."""
    values = jumped(seed=4)
    plain, moved = result(tmp_path / "plain", values), result(tmp_path / "moved", rested(values, 0.2, 1.7e9))
    assert moved["measured"][0]["switched_on"]["value"] == pytest.approx(0.2, abs=1e-6)
    assert "at 0.2 s (the clock begins at 1700000000.000000 s, set to 0), and" in moved["notes"][0]
    for key in ("takeoff_time", "rise", "peak_force"):
        assert moved["measured"][0][key]["value"] == pytest.approx(plain["measured"][0][key]["value"], rel=2e-6), key
    begun = values[6:] + np.array([1.7e9, 0.0, 0.0])
    (tmp_path / "design.yaml").write_text(DESIGN)
    (tmp_path / "gap.yaml").write_text(GAP)
    write(tmp_path / "a.csv", begun)
    with pytest.raises(UserError, match=r"begins at 1700000000.00.* s, in the push: neither its clock nor a rest"):
        prepare_jumps(read_hopper_gap_project(tmp_path / "gap.yaml"), Catalogue.load())


def test_a_gap_counts_time_from_the_switch_on(tmp_path: Path) -> None:
    """The same samples as without the rest; the switch-on is uncertain by a sample."""
    (tmp_path / "design.yaml").write_text(DESIGN)
    (tmp_path / "gap.yaml").write_text(GAP)
    found = []
    for values in (jumped(seed=4), rested(jumped(seed=4), 0.05, 10.0)):
        write(tmp_path / "a.csv", values)
        (jump,), said = prepare_jumps(read_hopper_gap_project(tmp_path / "gap.yaml"), Catalogue.load())
        found.append((jump, [text for text in said if "switched on" in text]))
    (plain, nothing), (moved, told) = found
    assert nothing == []
    assert len(told) == 1
    np.testing.assert_allclose(moved.time, plain.time, atol=1e-9)
    np.testing.assert_allclose(moved.measured["upper link"], plain.measured["upper link"])
    assert plain.start_deviation == 0.0
    assert moved.start_deviation == pytest.approx(1e-3 / np.sqrt(3.0), rel=1e-6)


@pytest.mark.parametrize("columns", [("ground force",), ("current",), ("current", "ground force"), ()])
@pytest.mark.parametrize("step", [2e-4, 1e-3, 5e-3])
def test_the_switch_on_is_found_within_its_stated_deviation(columns: tuple[str, ...], step: float) -> None:
    """At random phases of the samples, from each channel, of four designs: RMS error against the deviation."""
    jumper, rng = compiled_jump("upper"), np.random.default_rng(5)
    noise = {"ground force": 0.02, "current": 0.02, "upper link": np.radians(0.1)}
    rows = {"ground force": "normal", "current": "drawn", "upper link": "angle"}
    errors = []
    for length, ratio in ((0.08, 75), (0.12, 150), (0.14, 210), (0.1, 100)):
        trace = jumper.trace(changed(length, ratio, {}).workspace()[:, 0], tolerance=1e-6)
        for phase in rng.uniform(0.0, step, 8):
            time = np.arange(-0.3, 0.12, step) + phase
            made = {name: np.interp(time, trace[:, 0], trace[:, 1 + jumper.layout.row(rows[name])])
                    for name in (*columns, "upper link")}  # fmt: skip
            if "current" in made:
                made["current"][time < 0.0] = 0.0
            noisy = {name: values + noise[name] * rng.normal(size=len(time)) for name, values in made.items()}
            cut, found = from_switch_on(HopperRecording("a", {"time": time + 7.3, **noisy}), WEIGHT)
            assert found.source == (columns[0] if columns else "upper link")
            assert cut["time"][0] == pytest.approx(0.0, abs=step)
            errors.append((found.time - 7.3) / found.deviation)
    assert np.sqrt(np.mean(np.square(errors))) < 1.7


@pytest.mark.parametrize(("column", "missing"), [("ground force", 6), ("upper link", 40)])
def test_a_recording_that_begins_in_the_push_on_another_clock_is_refused(column: str, missing: int) -> None:
    """With time counted from the switch-on the missing samples do no harm."""
    values = jumped(seed=4)[missing:]
    made = {"time": values[:, 0], "upper link": values[:, 2]}
    if column == "ground force":
        made[column] = values[:, 1]
    with pytest.raises(UserError, match=f"a.csv: {column}: begins at 3.* s, in the push: neither its clock nor a rest"):
        from_switch_on(HopperRecording("a.csv", made | {"time": 3.0 + values[:, 0]}), WEIGHT)
    first = {"time": values[:, 0] - values[0, 0] + 1e-3}
    kept, found = from_switch_on(HopperRecording("a.csv", made | first), WEIGHT)
    assert found.source == ""
    assert len(kept["time"]) == len(values)


def test_noise_before_the_push_is_no_push() -> None:
    """Half a second at 5 kHz: single samples above 1.2 weights, in the force and in the rest before it."""
    values = rested(flown(noise=0.02), 0.5)
    values[100, 1] = 1.5 * WEIGHT
    values[300, 1] = 1.5 * WEIGHT
    made = dict(zip(("time", "ground force", "upper link"), values.T, strict=True))
    _, found = from_switch_on(HopperRecording("a", made), WEIGHT)
    assert found.time == pytest.approx(0.5, abs=1.5e-3)


@pytest.mark.parametrize("zero", [0.2, -0.2, 0.0])
def test_the_current_shown_before_the_switch_on_is_not_the_motors(zero: float, tmp_path: Path) -> None:
    """200 mA of a Hall sensor at 3.2 A made a torque constant of -15 % one of -19 % (90 %: -20 to -18 %)."""
    values, rng = rested(flown(), 0.05), np.random.default_rng(4)
    drawn = np.where(values[:, 0] > 0.05, 3.2 * (1.0 - np.exp(-(values[:, 0] - 0.05) / 3e-4)), 0.0)
    shown = drawn + zero + 0.01 * rng.normal(size=len(drawn))
    header = "time [s],ground force [N],upper link [rad],current [A]"
    np.savetxt(tmp_path / "a.csv", np.column_stack([values, shown]), delimiter=",", header=header, comments="")
    (tmp_path / "design.yaml").write_text(DESIGN)
    (tmp_path / "gap.yaml").write_text(GAP)
    (jump,), said = prepare_jumps(read_hopper_gap_project(tmp_path / "gap.yaml"), Catalogue.load())
    assert jump.measured["current"].max() == pytest.approx(3.2, abs=0.04)
    told = [text for text in map(str, said) if "at rest before the switch-on" in text]
    assert len(told) == (zero != 0.0)
    assert all(text.startswith("a.csv: the current is ") for text in told)
