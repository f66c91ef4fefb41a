"""The smallest visible size of each cause, and similar causes below a larger one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from synth.reports.openings.check_opening import cause_size, size_text
from synth.reports.quantities import number
from synth.reports.reading import Result
from synth.reports.section import AbsentResult, ReportSection, mapping, sequence
from synth.reports.sections.check_apart import name_of

MOST_RIVALS = 2  # rivals a row


def content(result: Result) -> dict[str, Any] | AbsentResult:
    """A row a cause."""
    causes = [item for item in sequence(result.content, "causes") if isinstance(item, Mapping)]
    if not causes:
        return AbsentResult("a fault must be corrected first")
    rows = []
    for cause in causes:
        rivals = []
        for rival in sequence(cause, "looks_like")[:MOST_RIVALS]:
            angle = mapping(rival, "angle").get("value")
            rivals.append(
                {
                    "name": name_of(rival),
                    "angle": number(angle, 2),
                    "from": _from(rival, limit=bool(cause.get("limit"))),
                }
            )
        rows.append({"name": name_of(cause), "size": cause_size(cause), "rivals": rivals})
    return {"rows": rows}


def _from(rival: Mapping[str, Any], *, limit: bool) -> str:
    parts = rival.get("told_apart_from")
    if parts == {}:
        return "by its position"
    return "at no size" if parts is None else f"from {size_text(parts, limit=limit)}"


SECTION = ReportSection("sizes", "Smallest detectable sizes", content, "check-sizes")
