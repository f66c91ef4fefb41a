"""The gates that the joints passed or failed before export, and each part's best print orientation."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from synth.reports.quantities import number
from synth.reports.reading import Result, png_uri
from synth.reports.section import AbsentResult, ReportSection, mapping, sequence


def content(result: Result) -> dict[str, Any] | AbsentResult:
    """Failed gates with their pictures; of the passed ones, each kind's nearest to its limit; the print plans."""
    solids = mapping(result.content, "solids")
    checks = [check for check in sequence(solids, "checks") if isinstance(check, Mapping)]
    if not checks:
        return AbsentResult("no joints were drawn")
    failed = [check for check in checks if not check.get("passed")]
    kinds: dict[str, list[Mapping[str, Any]]] = {}
    for check in checks:
        kinds.setdefault(str(check.get("name")), []).append(check)
    return {
        "count": len(checks),
        "failed": [{**check, "uri": _picture(result, check)} for check in failed],
        "kinds": [
            {"name": name, "count": len(found), "failed": sum(not c.get("passed") for c in found), **_nearest(found)}
            for name, found in kinds.items()
        ],
        "plans": [_plan(plan) for plan in sequence(solids, "print") if isinstance(plan, Mapping)],
    }


def _picture(result: Result, check: Mapping[str, Any]) -> str | None:
    path = result.path(str(check.get("picture"))) if check.get("picture") else None
    return png_uri(path) if path is not None and path.suffix.lower() == ".png" else None


def _nearest(checks: list[Mapping[str, Any]]) -> dict[str, Any]:
    """The check whose value is nearest to its limit, in relation to the limit."""

    def margin(check: Mapping[str, Any]) -> float:
        value, limit = (mapping(check, key).get("value") for key in ("value", "limit"))
        if not isinstance(value, (int, float)) or not isinstance(limit, (int, float)):
            return 1e300
        return abs(value - limit) / (abs(limit) or 1.0)

    nearest = min(checks, key=lambda check: (bool(check.get("passed")), margin(check)))
    return {"part": nearest.get("part"), "value": nearest.get("value"), "limit": nearest.get("limit")}


def _upward(plan: Mapping[str, Any]) -> str:
    """The direction that points up, in the part's own file."""
    found = [mapping(item).get("value") for item in sequence(plan, "up_in_file")]
    shown = [float(x) for x in found if isinstance(x, (int, float))]
    if len(shown) != 3 or max(map(abs, shown)) > 1.0 - 1e-6:  # along an axis
        axis = max(range(len(shown)), key=lambda k: abs(shown[k]), default=None)
        return str(plan.get("up")) if axis is None else f"{'+' if shown[axis] > 0 else '-'}{'xyz'[axis]}"
    return f"({', '.join(number(x, 3) for x in shown)})"


def _plan(plan: Mapping[str, Any]) -> dict[str, Any]:
    size = [mapping(item).get("value") for item in sequence(plan, "size")]
    shown = " × ".join(number(value, 3) for value in size if isinstance(value, (int, float)))
    return {
        "part": plan.get("part"),
        "up": _upward(plan),
        "support": plan.get("support"),
        "contact": plan.get("contact"),
        "wobbly": plan.get("wobbly"),
        "size": f"{shown} mm",
    }


SECTION = ReportSection("checks", "Checks of the joints", content)
