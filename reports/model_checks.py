"""The page of a model's checks: expected and computed values."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from synth.reports import page
from synth.reports.opening import Cell, Figures, Opening
from synth.reports.quantities import number, text, with_unit
from synth.reports.reading import Json, Result, read_result
from synth.reports.section import AbsentResult, ReportSection, mapping, sequence

MOST_ROWS = 6  # in the opening: those nearest to their limits; the section has all


def write_checks_report(folder: Path) -> Path:
    """Write ``report.html`` from ``check.json``.

    Raises
    ------
    ReportError
        If ``check.json`` is missing or not a result of checks.
    """
    result = read_result(folder, "check.json", "check")
    return page.write_page(result, "Checks of the model", SECTIONS, checks_opening(result))


def checks_opening(result: Result) -> Opening:
    """The number of checks that passed, and those nearest to their limits."""
    checks = _checks(result.content)
    failed = [check for check in checks if not check.get("passed")]
    left_out = sequence(result.content, "left_out")
    if not checks:
        verdict, good = "No check was possible.", None
    elif failed:
        verdict, good = f"{len(failed)} of {len(checks)} checks of the model fail.", False
    else:
        verdict, good = f"The model holds in all {len(checks)} checks.", True
    doubts = [str(text) for text in sequence(result.content, "warnings")]
    trust = f"{len(left_out)} were not possible: {'; '.join(map(str, left_out))}." if left_out else ""
    trust = " ".join([trust, *(f"{text}." for text in doubts)]).strip()
    nearest = sorted(checks, key=_share, reverse=True)[:MOST_ROWS]
    rows = [
        [Cell(str(check.get("name")), str(check.get("where"))), Cell(_long(check.get("expected"))),
         Cell(_long(check.get("found"))), Cell(_difference_text(check), f"limit {_difference_text(check, 'limit')}")]
        for check in nearest
    ]  # fmt: skip
    steps = (
        ["Start with the first failing check: a wrong model fails for a pendulum before it fails for a jump."]
        if failed
        else ["Check the numbers of the links, then run this again."]
        if doubts
        else ["Use it. That the model moves as the built leg does is shown by `synth gap` and recordings, not here."]
        if checks
        else ["Complete the leg file: a check needs links with mass, and springs or dampers."]
    )
    note = f"The {len(nearest)} of {len(checks)} nearest to their limits." if len(nearest) < len(checks) else ""
    figures = Figures(("Check", "Expected", "Found", "Apart"), rows, note) if rows else None
    return Opening(verdict, trust, steps, figures=figures, good=good)


def _checks(document: Json) -> list[Json]:
    return [dict(check) for check in sequence(document, "checks") if isinstance(check, dict)]


def _share(check: Json) -> float:
    """The difference of a check as a fraction of its limit."""
    off, limit = mapping(check, "off").get("value"), mapping(check, "limit").get("value")
    return float(off) / float(limit) if isinstance(off, (int, float)) and limit else float("inf")


def _long(item: object) -> str:
    """A value with seven digits, to which most checks agree."""
    value = mapping(item).get("value")
    if not isinstance(value, (int, float)):
        return "not found"
    return with_unit(number(value, 7), item)


def _difference_text(check: Json, key: str = "off") -> str:
    item = check.get(key)
    return text({**mapping(item), "value": float(f"{mapping(item).get('value'):.2g}")}) if mapping(item) else "–"


def _all_checks(result: Result) -> dict[str, Any] | AbsentResult:
    """Every check."""
    rows = [
        {"name": check.get("name"), "where": check.get("where"), "expected": _long(check.get("expected")),
         "found": _long(check.get("found")), "off": _difference_text(check), "limit": _difference_text(check, "limit"),
         "passed": bool(check.get("passed")), "source": check.get("source")}
        for check in _checks(result.content)
    ]  # fmt: skip
    if not rows:
        return AbsentResult("check.json holds no check")
    return {"rows": rows, "left_out": sequence(result.content, "left_out"), "inputs": mapping(result.content, "inputs")}


SECTIONS: tuple[ReportSection, ...] = (ReportSection("model-checks", "Every check", _all_checks),)
