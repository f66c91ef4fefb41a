"""The page of a rehearsal says nothing of what was not planted."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from synth.reports.page import environment
from synth.reports.reading import Result
from synth.reports.sections.rehearsal_sizes import SECTION

SMALL = {
    "effect": "coulomb_friction", "joint": "hip", "cases": 2, "named": 1, "named_with_absent": 0, "tied": 0,
    "large": 0, "large_named": 0, "large_tied": 0, "visible_from": None, "visible_gap": None, "taken_for": {},
    "tied_with": {},
}  # fmt: skip
LARGE = {**SMALL, "joint": "knee", "large": 1, "large_named": 1}
NOTHING: dict[str, Any] = {"cases": 0, "right": 0, "tied": 0, "with_small": 0, "taken_for": {}}


def page_of(folder: Path, *causes: dict[str, Any], cases: int = 0) -> str:
    found = {**NOTHING, "cases": cases, "right": cases}
    document = {"causes": list(causes), "nothing_planted": found, "not_in_the_library": found}
    content = SECTION.content(Result(folder, "rehearsal.json", document))
    return environment().get_template("rehearsal-sizes.html").render(**content)


def test_what_was_not_planted_is_left_out(tmp_path: Path) -> None:
    """A short rehearsal showed "named if large: 0 of 0", and "0 of 0 without a false alarm"."""
    page = page_of(tmp_path, SMALL)
    assert "1 of 2" in page
    for words in ("0 of 0", "if large", "tied with others", "false alarm", "not in the library"):
        assert words not in page, words


def test_a_cause_that_was_not_planted_large_says_so_beside_one_that_was(tmp_path: Path) -> None:
    page = page_of(tmp_path, SMALL, LARGE, cases=3)
    assert "not planted" in page
    assert "1 of 1" in page
    assert "3 of 3 without a false alarm" in page
    assert "0 of 0" not in page
