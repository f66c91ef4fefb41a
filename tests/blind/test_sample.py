"""Nine small cases of every kind, made and diagnosed, pinned to the present results.

The whole check is ``make blind``. Here legs have one or two joints, so that it takes a minute. One test, so that the
cases are made once.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from blind.cases import make_case
from blind.page import Method, write_page
from blind.score import confusion, scores
from blind.views import View, from_gap
from blind.writing import write_case
from page_reader import Page
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose
from synth.files.gap_project import read_gap_project

SEED = 31
# Number, which seeds the case; kind; effect; strength in floors; joints.
CASES: tuple[tuple[int, str, str | None, float | None, int], ...] = (
    (0, "single", "coulomb_friction", 12.0, 1),
    (2, "single", "shear_thinning_damping", 12.0, 1),
    (4, "single", "one_sided_spring", 12.0, 1),
    (5, "single", "backlash", 12.0, 1),
    (9, "single", "encoder_scale", 6.0, 2),
    (12, "single", "base_tilt", 3.0, 2),
    (13, "none", None, None, 1),
    (17, "unknown", "cogging", 6.0, 1),
    (19, "tie", None, None, 1),
)


def diagnosed(folder: Path) -> View:
    """The program's diagnosis of a case's folder."""
    project = read_gap_project(folder / "gap.yaml")
    return from_gap(diagnose(project.leg, project.trials, project.tolerance).as_json())


def test_nine_cases_whose_effect_was_withheld(tmp_path: Path) -> None:
    answers: dict[str, dict[str, Any]] = {}
    views: dict[str, View] = {}
    for number, kind, effect, strength, joints in CASES:
        case, name = make_case(SEED, number, kind, effect, strength, joints), f"case{number:02d}"
        write_case(case, tmp_path / name, name)
        answers[name], views[name] = case.answer, diagnosed(tmp_path / name)
    found = {score.key: score for score in scores(answers, views)}
    told = [(n, a["kind"], a["effects"], views[n].verdict, views[n].ranked[:2]) for n, a in answers.items()]
    # Present values: 5 of 6, 6 of 6, 6 of 6, .99, .89, 0 of 1, .15, 1 of 1.
    assert found["top1"].count == 6, told
    assert found["top1"].value >= 0.83, told
    assert found["top3"].value == 1.0, told
    assert found["joint"].value == 1.0, told
    assert found["shrink_median"].value >= 0.95, told
    assert found["shrink_p10"].value >= 0.85, told
    assert found["false_alarm"].value == 0.0, told
    assert found["calibration"].value <= 0.22, told
    assert found["unknown_flagged"].value == 1.0, told

    page = write_page(tmp_path, answers, [Method("synth gap", views, list(found.values()))], "here").read_text()
    Page(page)  # tags in balance
    assert "http" not in page
    written = json.loads((tmp_path / "blind.json").read_text())
    assert set(written["list"]) == set(answers)
    assert written["scores"]["synth gap"]["top1"]["value"] == found["top1"].value
    assert sum(number for *_, number in written["confusion"]) == sum(confusion(answers, views).values())
