"""The smallest size of each cause found in these trials, and its confusions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from synth.reports.openings.rehearsal_opening import visible_cell
from synth.reports.reading import Result
from synth.reports.section import ReportSection, mapping, sequence


def content(result: Result) -> dict[str, Any]:
    """A row a cause at a joint; what came of nothing and of what no library holds."""
    rows = []
    for cause in sequence(result.content, "causes"):
        if not isinstance(cause, Mapping):
            continue
        cell = visible_cell(cause)
        rows.append(
            {
                "name": f"{str(cause.get('effect')).replace('_', ' ')}, {cause.get('joint')}",
                "size": cell.text if cause.get("cases") else "cannot be planted large enough",
                "gap": cell.small,
                "of": mapping(cause, "visible_from").get("of", ""),
                "named": _share(cause, "named", "cases"),
                "absent": cause.get("named_with_absent") or 0,
                "large": _share(cause, "large_named", "large"),
                "large_tied": cause.get("large_tied") or 0,
                "tied": f"{cause.get('tied')} of {cause.get('cases')}" if cause.get("tied") else "",
                "tied_with": _counts_text(mapping(cause, "tied_with")),
                "taken": _counts_text(mapping(cause, "taken_for")),
            }
        )
    return {
        "rows": rows,
        "any_tied": any(row["tied"] for row in rows),
        "any_large": any(row["large"] for row in rows),
        "nothing": mapping(result.content, "nothing_planted"),
        "strange": mapping(result.content, "not_in_the_library"),
    }


def _share(cause: Mapping[str, Any], hits: str, of: str) -> str:
    """So many of the cases of a kind; empty where none was planted."""
    return f"{cause.get(hits)} of {cause.get(of)}" if cause.get(of) else ""


def _counts_text(found: Mapping[str, Any]) -> str:
    return ", ".join(f"{name.replace('_', ' ')} ×{count}" for name, count in found.items())


SECTION = ReportSection("smallest", "Smallest sizes found", content, "rehearsal-sizes")
