"""What a study warns of: lengths at an edge, and torques whose interval passes the gearbox's limit."""

from __future__ import annotations

import csv
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from hopper.hoppers import catalogue
from synth.files.hopper_project import read_hopper_project
from synth.hopper import study as studying
from synth.hopper.hopper_tolerances import QUANTITIES, outcomes_of_copies
from synth.hopper.study import Study, sweep_problem
from synth.hopper.study_warnings import overvoltage_sentence, warnings_of
from synth.hopper.write_study import hopper_json, write_designs
from synth.jump.outcomes import CROSSED, PEAK_GEAR_TORQUE
from synth.remarks import Remark

PROJECT = """\
kind: hopper-design
model: full
motors: {{use: ["N20 {motor}"], gearbox: {gearbox}}}
lengths: {{least: {least} mm, most: {most} mm, step: 2 mm}}
leg: {{crouch: 39.0 deg, extended: 10 deg}}
"""


@pytest.fixture(autouse=True)
def without_other_models(monkeypatch: pytest.MonkeyPatch) -> None:
    """The choice by every model takes a minute, and no warning here looks at it."""
    monkeypatch.setattr(studying, "run_ladder", lambda *given: ((), {}))
    monkeypatch.setattr(studying, "_lean_design", lambda *given: None)


def studied(
    folder: Path, least: int, most: int, gearbox: str = "stop", motor: str = "HP 6V 75:1", more: str = ""
) -> Study:
    """The study of a small sweep of one motor; ``more`` : further lines of the project."""
    text = PROJECT.format(least=least, most=most, gearbox=gearbox, motor=motor)
    (folder / "a.yaml").write_text(text + more)
    return studying.study(read_hopper_project(folder / "a.yaml"), catalogue(), None, lambda stage: nullcontext())


@pytest.mark.parametrize(
    ("least", "most", "more", "length", "words"),
    [
        (30, 60, "", 44, "the shortest in reach, set by the crouch: 4.0 deg before the lower links lock"),
        (44, 60, "", 44, "the shortest of the sweep"),
        (48, 50, "", 48, ""),
        (90, 100, "choose: peak_gear_torque\n", 90, "the shortest of the sweep"),
    ],
)
def test_a_choice_at_the_edge_of_reach_or_sweep_is_named(
    tmp_path: Path, least: int, most: int, more: str, length: int, words: str
) -> None:
    """An optimum beside lengths whose crouch is out of reach had no warning: only the ends of the sweep had one."""
    study = studied(tmp_path, least, most, more=more)
    assert round(1000.0 * study.best_leg.length) == length
    told = [text for text in warnings_of(study) if "the chosen length is" in text]
    assert len(told) == bool(words)
    assert all(text.startswith(f"the chosen length is {words}") for text in told)
    assert all(isinstance(text, Remark) and "legs too" in text.remedy for text in told)


def test_a_supply_far_above_the_rated_one_of_a_single_motor_names_it(tmp_path: Path) -> None:
    """It was "of 1 of the 1 motors"."""
    text = PROJECT.format(least=60, most=62, gearbox="warn", motor="HP 6V 150:1")
    (tmp_path / "a.yaml").write_text(text.replace("motors: {", "motors: {supply: 24 V, "))
    project = read_hopper_project(tmp_path / "a.yaml")
    problem, rows = sweep_problem(project, catalogue())
    assert len(problem.motors) == 1
    said = overvoltage_sentence(SimpleNamespace(project=project, rows=rows))  # type: ignore[arg-type]
    assert "times the rated voltage (6 V) of N20 HP 6V 150:1: winding" in said


@pytest.mark.parametrize("gearbox", ["stop", "warn"])
def test_a_torque_whose_90_percent_end_is_beyond_the_gearbox_is_warned_of(tmp_path: Path, gearbox: str) -> None:
    """Torques were judged at their nominal value, and those of the copies for the interval were dropped."""
    study = studied(tmp_path, 88, 96, gearbox, "HPCB 6V 100:1")
    sweep, limit = study.sweep, study.best_motor.torque_limit
    assert limit is not None
    own, t = sweep.problem.motors[0], sweep.problem.tolerances[0]
    for k, length in enumerate(sweep.length):
        leg = sweep.problem.leg
        found = next(outcomes_of_copies(leg, own, sweep.problem.contact, sweep.problem.model, t, np.array([length])))
        torque, count = found[PEAK_GEAR_TORQUE], len(QUANTITIES)
        change = np.maximum(torque[1 : 1 + count], torque[1 + count : 1 + 2 * count]) - torque[0]
        assert study.torque_ends[1, k] == pytest.approx(torque[0] + np.sqrt((np.maximum(change, 0.0) ** 2).sum()))
        assert study.torque_ends[0, k] < torque[0] < study.torque_ends[1, k]
    over = study.over_limit_at_end
    assert over[study.best]
    assert (over <= sweep.feasible("stop")).all()  # the status is still that of the nominal torque
    told = [text for text in warnings_of(study) if "90 % end" in text]
    high = study.torque_ends[1, study.best]
    ends = f"{high:.3f} N*m at the 90 % end of its tolerances, above the gearbox's {limit:.3f}"
    assert ends in told[0]
    assert len(told) == (2 if gearbox == "stop" else 1)
    if gearbox == "stop":
        assert f"{over.sum()} of {sweep.feasible('stop').sum()} feasible designs exceed" in told[1]
    write_designs(study, tmp_path / "designs.csv")
    with (tmp_path / "designs.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    written = [float(row["peak_gear_torque_high [N*m]"]) for row in rows]
    np.testing.assert_allclose(written, study.torque_ends[1], atol=1e-5)
    document = hopper_json(replace(study, leaning=[]), [], tmp_path)
    assert document["best"]["peak_gear_torque"]["interval90"] == study.torque_ends[:, study.best].tolist()
    assert document["counts"]["beyond the gearbox at the torque's 90 % end"] == over.sum()


def test_designs_that_go_through_their_stop_are_counted_and_not_chosen(tmp_path: Path) -> None:
    """At 24 V these motors go through the assumed stop of legs of 300 mm: one cleared 1 m with crossed knees."""
    text = """kind: hopper-design
motors: {use: ["25D HP 12V *"], supply: 24 V}
lengths: {least: 280 mm, most: 300 mm, step: 20 mm}
"""
    (tmp_path / "a.yaml").write_text(text)
    project = read_hopper_project(tmp_path / "a.yaml")
    study = studying.study(project, catalogue(), None, lambda stage: nullcontext())
    crossed = study.sweep.status == CROSSED
    assert 0 < crossed.sum() < len(crossed)
    assert study.best is not None
    assert not crossed[study.best]
    assert {study.sweep.limit_text(int(k)) for k in np.flatnonzero(crossed)} == {
        "goes through its stop: the knees cross"
    }
    (told,) = [text for text in warnings_of(study) if "knees cross" in text]
    assert told.startswith(f"{int(crossed.sum())} of {len(crossed)} designs go through the leg's stop")
    assert isinstance(told, Remark)
    assert "stop_rate" in told.remedy
