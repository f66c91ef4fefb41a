"""The section of the joints' checks: failed ones with a picture, passed ones by the nearest to its limit."""

from __future__ import annotations

import base64
from pathlib import Path

from synth.reports.page import environment
from synth.reports.reading import Result
from synth.reports.section import AbsentResult
from synth.reports.sections import joint_checks

DOT = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="
)


def check(part: str, value: float, *, passed: bool = True, **more: object) -> dict[str, object]:
    quantities = {"value": {"value": value, "unit": "mm"}, "limit": {"value": 0.4, "unit": "mm"}}
    return {"name": "gap", "part": part, "passed": passed, "text": f"{part} <text>", **quantities, **more}


def shown(folder: Path, *found: dict[str, object]) -> tuple[dict[str, object], str]:
    size = [{"value": value, "unit": "mm"} for value in (59.4, 50.0, 90.8)]
    plan = {"part": "hip_upper", "up": "+y", "support": {"value": 9.0, "unit": "mm^2"}, "size": size}
    plan |= {"contact": {"value": 12.5, "unit": "mm^2"}, "wobbly": True}
    content = joint_checks.content(Result(folder, "design.json", {"solids": {"checks": list(found), "print": [plan]}}))
    assert not isinstance(content, AbsentResult)
    return dict(content), environment().get_template("checks.html").render(**content, file="design.json")


def test_of_the_passed_the_nearest_to_its_limit_is_shown(tmp_path: Path) -> None:
    content, page = shown(tmp_path, check("far", 0.9), check("near", 0.41), check("middle", 0.6))
    assert [kind["part"] for kind in content["kinds"]] == ["near"]  # type: ignore[attr-defined]
    assert "All 3 checks passed" in page
    assert "near" in page
    assert "far" not in page
    assert "59.4 × 50 × 90.8 mm" in page
    assert "12.5\u00a0mm²; with a brim" in page


def test_the_direction_to_print_is_that_of_the_part_s_own_file(tmp_path: Path) -> None:
    for vector, words in (((0.0, 0.0, -1.0), "-z"), ((0.6, 0.8, 0.0), "(0.6, 0.8, 0)")):
        plan = {"part": "hip_lower", "up": "+y", "up_in_file": [{"value": x, "unit": "1"} for x in vector]}
        result = Result(tmp_path, "design.json", {"solids": {"checks": [check("a", 1.0)], "print": [plan]}})
        content = joint_checks.content(result)
        assert not isinstance(content, AbsentResult)
        assert content["plans"][0]["up"] == words


def test_a_failed_one_comes_first_with_its_picture_and_markup_escaped(tmp_path: Path) -> None:
    (tmp_path / "checks").mkdir()
    (tmp_path / "checks" / "a.png").write_bytes(DOT)
    angle = {"value": 61.0, "unit": "deg"}
    bad = check("bad", 0.1, passed=False, picture="checks/a.png", angle=angle)
    _, page = shown(tmp_path, check("good", 0.41), bad, check("worse", 0.0, passed=False, picture="../outside.png"))
    assert "2 of 3 checks failed, so no part is exported" in page
    assert page.count("data:image/png;base64,") == 1
    assert "bad &lt;text&gt;" in page
    assert "61°" in page


def test_without_solids_it_is_left_out(tmp_path: Path) -> None:
    assert isinstance(joint_checks.content(Result(tmp_path, "design.json", {"solids": {"checks": []}})), AbsentResult)
