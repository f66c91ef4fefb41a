"""A small sample of the study, with consecutive seeds; the whole one is ``make robustness``."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from peers.mujoco_leg import simulate
from robustness import __main__ as whole
from robustness.numbers import Record, exact_lines, hand_lines, hands, headline, line, succeeded
from robustness.page import write_page
from robustness.random_legs import Recorder, random_case, random_recorder
from robustness.study import study_case
from robustness.unseen import main as unseen_main

LEGS = 10
MOST_TRIALS = 5  # so that the sample takes seconds


@pytest.fixture(scope="module")
def records() -> list[Record]:
    made = []
    for seed in range(9000, 9000 + LEGS):
        drawn = random_case(seed, links=3).recorder
        recorder = replace(drawn, trials=min(drawn.trials, MOST_TRIALS))
        made.append(study_case(seed, random_case(seed, recorder, links=3)))
    return made


def test_every_fit_of_the_sample_succeeds_and_nine_in_ten_intervals_hold(records: list[Record]) -> None:
    fits = [headline(record) for record in records]
    assert [record["seed"] for record, fit in zip(records, fits, strict=True) if not succeeded(fit)] == []
    found = line("all", fits)
    assert found.intervals == 9 * LEGS  # of legs whose links are off by their tolerance
    assert 0.90 - 3 * max(found.error, 0.022) < found.held < 0.90 + 3 * max(found.error, 0.022)
    assert abs(found.bias) < 0.25
    assert found.rate < 0.03
    exact = exact_lines(records)[0]
    assert 0.90 - 3 * max(exact.error, 0.022) < exact.held < 0.90 + 3 * max(exact.error, 0.022)
    assert exact.rate < 0.02
    assert exact.width < 0.5 * found.width


def test_an_external_torque_at_the_start_is_cut_and_free_motion_kept(records: list[Record]) -> None:
    seen = hands(records)
    assert seen["driven"][1] > 0
    assert seen["driven"][0] > 0.5 * seen["driven"][1]
    assert seen["free"][0] < 0.1 * seen["free"][1]  # 3 of 58: a false detection costs samples, not accuracy
    by_name = {item.name: item for item in hand_lines(records)}
    known, cut = by_name["driven, cut at the known end of the torque"], by_name["driven, cut by detection"]
    assert cut.held > known.held - 0.15


def test_the_page_says_what_the_records_say(records: list[Record], tmp_path: Path) -> None:
    page = write_page(tmp_path, records, "Made here.").read_text()
    found = json.loads((tmp_path / "robustness.json").read_text())
    inside = sum(
        low <= 0.0 <= high for r in records for joint in headline(r)["joints"] for _, low, high in joint.values()
    )
    assert found["all"]["held"] == pytest.approx(inside / (9 * LEGS))
    assert f"{inside / (9 * LEGS):.1%}" in page
    assert page.count("<svg") == 2
    assert "Made here." in page
    lost = next(item for item in found["tables"]["Lost samples"] if item["name"] == "5 % lost")
    assert lost["legs"] == sum(record["lost"] > 0 for record in records)


def test_numbers_of_a_line_are_those_by_hand() -> None:
    joint = {"spring_rate": [0.02, 0.0, 0.04], "damper_rate": [-0.05, -0.08, -0.02], "free_angle": [0.0, -0.1, 0.1]}
    good = {"done": True, "over": -0.001, "joints": [joint]}
    bad = {"done": True, "over": 0.3, "joints": [joint]}
    failed = {"done": False, "message": "no"}
    found = line("three", [good, bad, failed])
    assert found.success == pytest.approx(1 / 3)
    assert found.held == pytest.approx(4 / 6)  # the damper's interval does not contain zero
    assert found.rate == pytest.approx(0.035)
    assert found.width == pytest.approx(0.025)
    assert found.bias == pytest.approx(0.0)


def test_an_interrupted_study_resumes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(whole, "_source_hash", lambda: "one program")
    words = ["--seed", "1", "--to", str(tmp_path), "--workers", "1", "--count"]
    assert whole.main([*words, "1"]) == 0
    first = tmp_path / "records" / "1000.json"
    before = first.stat().st_mtime_ns
    assert whole.main([*words, "2"]) == 0
    assert first.stat().st_mtime_ns == before
    assert "2 legs, 1 done before" in capsys.readouterr().err
    assert sorted(path.name for path in first.parent.glob("*.json")) == ["1000.json", "1001.json"]
    monkeypatch.setattr(whole, "_source_hash", lambda: "another program")
    assert whole.main([*words, "0"]) == 0
    assert list(first.parent.glob("*.json")) == []


@pytest.mark.parametrize("seed", [1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (2, 3))])
def test_the_recorded_motion_is_also_mujocos(seed: int) -> None:
    """Without noise, counts and losses: within a thousandth of a degree of the other engine's."""
    clean = Recorder(noise=0.0, counts=0, rate=100.0, trials=1)
    case = random_case(seed, clean, links=3)
    trial = case.trials[0]
    rotation = case.leg.to_rotation(trial.angles)
    # The first rates are not recorded: they are the ones that the generator drew after the directions.
    generator = np.random.default_rng([seed, 500])
    from robustness.random_legs import random_leg

    random_leg(generator, 3)
    random_recorder(generator)
    generator.uniform(8, 30, 3), generator.choice((-1, 1), 3)
    rate = generator.normal(0.0, 0.2, 3)
    other = simulate(case.leg, rotation[0], rate, trial.time, step=1e-4)
    assert np.abs(other - rotation).max() < math.radians(1e-3)


def test_the_study_of_unseen_hands_fits_those_only_and_goes_on(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Seed 900211 is a leg of one link whose hand its one recording does not show."""
    seen = [{"seed": seed} for seed in range(900000, 900211)]
    (tmp_path / "legs.jsonl").write_text("".join(json.dumps(record) + "\n" for record in seen))
    unseen_main(["--seed", "900", "--count", "212", "--to", str(tmp_path)])
    records = [json.loads(text) for text in (tmp_path / "legs.jsonl").read_text().splitlines()]
    assert records[:-1] == seen
    assert records[-1]["seed"] == 900211
    assert records[-1]["fit"]["done"]
    said = capsys.readouterr().out
    assert "of 3 intervals, 1 legs of 212" in said
    assert "cut: 1 of 1 legs" in said


def test_a_leg_that_no_hand_drives_counts_as_cut_without_need(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    unseen_main(["--free", "--seed", "900", "--count", "1", "--to", str(tmp_path)])
    (record,) = [json.loads(text) for text in (tmp_path / "legs.jsonl").read_text().splitlines()]
    assert record["fit"]["cut"] == 0.0
    assert "cut: 0 of 1 legs" in capsys.readouterr().out
