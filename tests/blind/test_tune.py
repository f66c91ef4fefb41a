"""The tables behind the odds: a stored search gives the same diagnosis as the program."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from math import log
from pathlib import Path

import pytest

from blind import searched, tune, tune_rigs
from blind.cases import make_case
from blind.rig_cases import make_rig
from blind.views import from_gap
from blind.writing import write_case
from synth.diagnosis import cause_findings
from synth.diagnosis.angle_search import search
from synth.diagnosis.effect_shape import ShapedEffect
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.hypotheses import Hypotheses
from synth.diagnosis.odds import Calibration, far_share
from synth.diagnosis.plants.swinging_chain import stated_candidates
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose
from synth.diagnosis.verdict import CALIBRATED
from synth.diagnosis.workbench import Workbench
from synth.files.gap_project import read_gap_project


@pytest.fixture(autouse=True)
def searched_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """A search of the same trials with the same noise and candidates is made once: it takes most of the time."""
    made: dict[object, Hypotheses[EvaluatedHypothesis]] = {}

    def once(
        bench: Workbench,
        candidates: Sequence[ShapedEffect],
        calibration: Calibration,
        progress: Callable[[str], None] | None = None,
    ) -> Hypotheses[EvaluatedHypothesis]:
        key = (
            tuple(trial.measured.tobytes() for trial in bench.trials),
            bench.noise.tobytes(),
            bench.effective,
            tuple((candidate.key, repr(candidate.shape)) for candidate in candidates),
        )
        if key not in made:
            made[key] = search(bench, candidates, calibration, progress)
        return made[key]

    for module in (tune, stated_candidates):
        monkeypatch.setattr(module, "search", once)


@pytest.fixture(autouse=True)
def without_later_doubts(monkeypatch: pytest.MonkeyPatch) -> None:
    """The tables are of the search's odds; what single recordings and held-out trials add later is not in them."""
    for doubt in ("with_further_doubt", "with_doubt_of_held_out"):
        monkeypatch.setattr(cause_findings, doubt, lambda judged, chance: judged)


@pytest.mark.slow  # like the rig's
def test_a_stored_search_of_a_case_gives_the_verdict_of_its_diagnosis(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tune, "FACTORS", (2.0,))
    effect = "coulomb_friction"
    case = make_case(31, 0, "single", effect, 6.0, 1)
    write_case(case, tmp_path / "case", "case")
    project = read_gap_project(tmp_path / "case" / "gap.yaml")
    wanted = from_gap(diagnose(project.leg, project.trials, project.tolerance, seed=project.seed).as_json())
    searched.store(tmp_path / "case", tune.search_case, tmp_path)
    found = searched.read(json.loads((tmp_path / "case.json").read_text()))
    got = searched.view(found, CALIBRATED)
    assert (got.verdict, got.explanation) == (wanted.verdict, wanted.explanation)
    assert got.none == pytest.approx(wanted.none, abs=1e-6)
    assert got.unknown == pytest.approx(wanted.unknown, abs=1e-6)
    for (key, probability), (other, expected) in zip(got.ranked[:3], wanted.ranked[:3], strict=True):
        assert key == other
        assert probability == pytest.approx(expected, abs=1e-6)

    answers, cases = {"case": case.answer}, {"case": found}
    values = dict(zip(["log p", *tune.SHOWN], tune.line(answers, cases, CALIBRATED), strict=True))
    assert values["log p"] == pytest.approx(log(dict(got.ranked)[effect, "hip"]))
    assert searched.view(found, replace(CALIBRATED, doubt=0.6)).unknown >= 0.6
    assert values["top1"] == float(got.first[0][0] == effect)
    written = tune.table(answers, cases).splitlines()
    assert len(written) == 2 + len(tune.FACTORS) * len(vars(CALIBRATED))


@pytest.mark.slow
def test_a_stored_search_of_a_rig_gives_the_verdict_of_its_diagnosis(tmp_path: Path) -> None:
    """Far above the noise: errors by trial, the free torque and the motion are stored too."""
    case = make_rig(5, 1, "single", "torque_offset", 1, True)
    write_case(case, tmp_path / "rig", "rig")
    project = read_gap_project(tmp_path / "rig" / "gap.yaml")
    wanted = from_gap(diagnose(project.leg, project.trials, project.tolerance, seed=project.seed).as_json())
    searched.store(tmp_path / "rig", tune_rigs.search_rig, tmp_path)
    found = searched.read(json.loads((tmp_path / "rig.json").read_text()))
    assert far_share([found.found.none, *found.found.singles]) > 0.0
    got = searched.view(found, CALIBRATED)
    told = tune_rigs.reliability_table({"rig": case.answer}, {"rig": found}).splitlines()
    assert told[1:] == [f"from {int(10 * got.first[1]) / 10:.1f}:   1 rigs, {got.first[1]:.3f}, 1 right"]
    assert (got.verdict, got.explanation) == (wanted.verdict, wanted.explanation)
    assert got.unknown == pytest.approx(wanted.unknown, abs=1e-6)
    assert got.first[0] == wanted.first[0]
    assert got.first[1] == pytest.approx(wanted.first[1], abs=1e-6)
    written = tune_rigs.table({"rig": case.answer}, {"rig": found}).splitlines()
    assert len(written) == 2 + len(tune.FACTORS) * len(tune_rigs.FAR)
