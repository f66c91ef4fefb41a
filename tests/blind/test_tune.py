"""The table behind the odds: what it makes of a search is what the program says of the case."""

from __future__ import annotations

import json
from dataclasses import replace
from math import log
from pathlib import Path

import pytest

from blind import tune, tune_rigs
from blind.cases import make_case
from blind.rig_cases import make_rig
from blind.views import from_gap
from blind.writing import write_case
from synth.diagnosis.odds import far_share
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose
from synth.diagnosis.verdict import CALIBRATED
from synth.files.gap_project import read_gap_project


def test_a_case_from_the_search_has_the_verdict_of_a_diagnosis(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tune, "FACTORS", (2.0,))
    effect = "coulomb_friction"
    case = make_case(31, 0, "single", effect, 6.0, 1)
    write_case(case, tmp_path / "case", "case")
    project = read_gap_project(tmp_path / "case" / "gap.yaml")
    wanted = from_gap(diagnose(project.leg, project.trials, project.tolerance, seed=project.seed).as_json())
    tune._search(tmp_path / "case", tmp_path)
    searched = tune._read(tmp_path / "case.json")
    got = tune.view(searched, CALIBRATED)
    assert (got.verdict, got.explanation) == (wanted.verdict, wanted.explanation)
    assert got.none == pytest.approx(wanted.none, abs=1e-6)
    assert got.unknown == pytest.approx(wanted.unknown, abs=1e-6)
    for (key, probability), (other, told) in zip(got.ranked[:3], wanted.ranked[:3], strict=True):
        assert key == other
        assert probability == pytest.approx(told, abs=1e-6)

    answers, cases = {"case": case.answer}, {"case": searched}
    values = dict(zip(["log p", *tune.SHOWN], tune.line(answers, cases, CALIBRATED), strict=True))
    assert values["log p"] == pytest.approx(log(dict(got.ranked)[effect, "hip"]))
    assert tune.view(searched, replace(CALIBRATED, doubt=0.6)).unknown >= 0.6
    assert values["top1"] == float(got.first[0][0] == effect)
    written = tune.table(answers, cases).splitlines()
    assert len(written) == 2 + len(tune.FACTORS) * len(vars(CALIBRATED))


def test_a_rig_from_the_search_has_the_verdict_of_a_diagnosis(tmp_path: Path) -> None:
    """Far above the noise: errors by trial, the free torque and the motion are noted too."""
    case = make_rig(5, 1, "single", "torque_offset", 1, True)
    write_case(case, tmp_path / "rig", "rig")
    project = read_gap_project(tmp_path / "rig" / "gap.yaml")
    wanted = from_gap(diagnose(project.leg, project.trials, project.tolerance, seed=project.seed).as_json())
    tune_rigs._search(tmp_path / "rig", tmp_path)
    searched = tune_rigs.read(json.loads((tmp_path / "rig.json").read_text()))
    assert far_share([searched.found.none, *searched.found.singles]) > 0.0
    got = tune_rigs.view(searched, CALIBRATED)
    assert (got.verdict, got.explanation) == (wanted.verdict, wanted.explanation)
    assert got.unknown == pytest.approx(wanted.unknown, abs=1e-6)
    assert got.first[0] == wanted.first[0]
    assert got.first[1] == pytest.approx(wanted.first[1], abs=1e-6)
    written = tune_rigs.table({"rig": case.answer}, {"rig": searched}).splitlines()
    assert len(written) == 2 + len(tune.FACTORS) * len(tune_rigs.FAR)
