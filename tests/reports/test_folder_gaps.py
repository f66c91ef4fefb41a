"""The page of many diagnoses: only accepted causes count, and only a probable "none" is told as one."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from page_reader import page_of
from synth.reports.many_pages import write_gaps_report

Json = dict[str, Any]


def leg(name: str, verdict: str, cause: str | None = None, none: float = 0.0, warnings: tuple[str, ...] = ()) -> Json:
    """An entry of ``gaps.json``."""
    explanation = [{"effect": cause, "joint": "knee", "parameters": {}}] if cause else []
    rms = {"value": 0.5, "unit": "deg"}
    return {
        "name": name,
        "report": f"legs/{name}/report.html",
        "trials": 3,
        "verdict": verdict,
        "sentence": "",
        "explanation": explanation,
        "ranked": [{**cause, "probability": 0.3, "shrink": {"value": 0.2, "unit": "1"}} for cause in explanation],
        "probability_none": none,
        "probability_unknown": 0.0,
        "where": {"knee": 1.0},
        "rms": dict.fromkeys(("as_designed", "before", "after", "noise_floor"), rms),
        "warnings": list(warnings),
    }


def text_of_page(folder: Path, *legs: Json) -> str:
    """The text of the page of these legs."""
    (folder / "gaps.json").write_text(json.dumps({"format": "synth/gaps/1", "legs": legs, "failed": []}))
    _, page = page_of(write_gaps_report(folder))
    return " ".join(page.text.split())


def test_a_leg_with_an_error_far_above_the_noise_does_not_lack_nothing(tmp_path: Path) -> None:
    far = leg("a", "none", none=0.93)
    far["rms"]["noise_floor"] = {"value": 0.01, "unit": "deg"}
    assert "diagnosed: 1 has an error that no effect reduces." in text_of_page(tmp_path, far)
    assert "diagnosed: 1 lacks nothing." in text_of_page(tmp_path, {**far, "probability_none": 1.0})  # accurate enough


def test_a_cause_that_was_not_accepted_is_not_counted(tmp_path: Path) -> None:
    legs = [leg("a", "effect", "backlash"), leg("b", "unknown", "coulomb_friction", none=0.24)]
    text = text_of_page(tmp_path, *legs)
    counted = text.split("Causes across the legs")[-1]
    assert "backlash, knee" in counted
    assert "coulomb friction" not in counted
    assert "coulomb friction, knee (nearest, not accepted)" in text
    assert "1 has a cause and 1 has an unknown cause" in text


def test_without_an_accepted_cause_no_cause_is_drawn(tmp_path: Path) -> None:
    text = text_of_page(tmp_path, leg("b", "unknown", "coulomb_friction"))
    assert "no leg's explanation names a cause" in text


@pytest.mark.parametrize(
    ("none", "words"), [(0.46, "1 cannot show whether an effect is missing"), (0.9, "1 lacks nothing")]
)
def test_a_leg_lacks_nothing_only_where_that_is_probable(tmp_path: Path, none: float, words: str) -> None:
    text = text_of_page(tmp_path, leg("a", "none", none=none, warnings=("a warning",)))
    assert f"1 of 1 projects was diagnosed: {words}." in text
    assert "1 of them has warnings." in text
    assert ("See in the reports of a what would decide." in text) is (none < 0.8)
